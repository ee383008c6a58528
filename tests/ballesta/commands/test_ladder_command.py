"""`ballesta ladder` as a user runs it: rungs that are real, solids that are made up."""

import json
from dataclasses import replace
from math import inf
from time import sleep

import pytest

from ballesta.commands import ladder_command
from ballesta.commands.ladder_command import PricedModels, Wanted, ladder_of_file, run_ladder
from checks.models import bands
from checks.result.verdict import RungTried
from checks.stress.solid_mesh_level import Models
from geometry.mesh import MeshError, TooManyElementsError

from ...checks.models.wide_bands import bands_of
from ...small_machine import MACHINE, PLATE

BANDS = bands_of(formula=0.1)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    return path


@pytest.fixture
def solids(monkeypatch):
    """Solids that say what the formula says; the list tells which were asked for."""
    asked = []

    def made_up(climb, models, say, *, everything, deadline=float("inf")):
        asked.append((climb.part.fineness, climb.loaded.accuracy, everything))
        if climb.level is None:
            climb.by_formula()
        checks = [replace(e.check, method="solid") for e in climb.best.values()]
        tried = RungTried("solid", 2.0, 1000, checks, "stopped: made up")
        return _Result([*climb.tried, tried], checks)

    class _Result:
        def __init__(self, rungs, checks):
            self.rungs, self.checks = rungs, checks

    monkeypatch.setattr(ladder_command, "solid_result", made_up)
    return asked


@pytest.fixture
def without_bands(monkeypatch):
    """No rung below the solid has a bar: auto must ask for the solid."""
    monkeypatch.setattr(bands, "_data", lambda: {})


@pytest.fixture
def with_bands(monkeypatch):
    """Every rung of a plate is within 10 %."""
    monkeypatch.setattr(bands, "_data", lambda: BANDS)


def rungs_of(result):
    (part,) = result.parts
    return {rung.rung: rung for rung in part.rungs}


def test_every_rung_is_told_and_solids_of_three_finenesses(file, solids, without_bands):
    """mesh.fineness is 0.5 and the accuracy 3 %: half as fine, four times the error."""
    result = ladder_of_file(file)
    assert list(rungs_of(result)) == [
        "formula", "solid 0.25", "solid 0.35", "solid 0.5"
    ]  # fmt: skip
    everything = [(fineness, accuracy) for fineness, accuracy, whole in solids if whole]
    assert everything == [
        (0.25, pytest.approx(0.12)), (0.35, pytest.approx(0.03 / 0.49)), (0.5, 0.03)
    ]  # fmt: skip


def test_without_bars_auto_takes_the_solid_and_only_what_is_open(file, solids, without_bands):
    (part,) = ladder_of_file(file).parts
    assert [rung.rung for rung in part.tried][-1] == "solid"
    assert {check.method for check in part.chosen} == {"solid"}
    assert [whole for *_, whole in solids] == [False, True, True, True]
    assert part.seconds > 2.0  # what the made-up solid takes


def test_with_narrow_bars_auto_stops_at_the_formula(file, solids, with_bands):
    (part,) = ladder_of_file(file).parts
    assert [rung.rung for rung in part.tried] == ["formula"]
    assert part.tried[0].why.startswith("stopped: ")
    assert {check.method for check in part.chosen} == {"formula"}
    assert [whole for *_, whole in solids] == [True, True, True]


def test_rungs_by_themselves_are_those_of_auto(file, solids, with_bands):
    """The same part and loads: auto's formula and the one of the table agree to the last digit."""
    (part,) = ladder_of_file(file).parts
    alone = {check.kind: check.value for check in part.rungs[0].checks}
    assert alone == {check.kind: check.value for check in part.chosen}


def test_a_coarser_solid_that_cannot_be_meshed_is_a_row_that_says_so(
    file, solids, with_bands, monkeypatch
):
    made_up = ladder_command.solid_result

    def coarse_fails(climb, models, say, **asked):
        if climb.part.fineness < 0.5:
            raise MeshError("a round face has four elements")
        return made_up(climb, models, say, **asked)

    monkeypatch.setattr(ladder_command, "solid_result", coarse_fails)
    rungs = rungs_of(ladder_of_file(file))
    assert rungs["solid 0.25"].checks == []
    assert "a round face has four elements" in rungs["solid 0.25"].why
    assert rungs["solid 0.5"].checks


@pytest.mark.parametrize(
    ("error", "code"), [(MeshError("no mesh"), 3), (TooManyElementsError("too many"), 2)]
)
def test_a_part_s_own_solid_that_fails_ends_the_command(
    file, with_bands, monkeypatch, capsys, tmp_path, error, code
):
    def fails(*_, **__):
        raise error

    monkeypatch.setattr(ladder_command, "solid_result", fails)
    assert run_ladder(file, Wanted(out=tmp_path)) == code
    told = capsys.readouterr()
    assert f"machine.toml: parts.rod: {error}" in told.err
    assert told.out == ""
    assert not (tmp_path / "machine").exists()


def test_the_command_prints_the_rungs_and_writes_their_page(
    file, solids, with_bands, tmp_path, capsys
):
    assert run_ladder(file, Wanted(out=tmp_path)) == 0
    told = capsys.readouterr().out
    page = tmp_path / "machine" / "ladder.html"
    assert f"written: {page}" in told
    assert "AUTO     after" in told
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_json_holds_the_rungs_and_what_auto_takes(file, solids, with_bands, tmp_path, capsys):
    assert run_ladder(file, Wanted(out=tmp_path, as_json=True)) == 0
    data = json.loads(capsys.readouterr().out)
    (part,) = data["parts"]
    assert data["format"] == "ballesta-ladder/1"
    assert [rung["rung"] for rung in part["auto"]["rungs"]] == ["formula"]
    assert {check["kind"] for check in part["auto"]["checks"]} >= {"static", "fatigue"}


def test_only_the_part_that_is_named_is_told_and_an_unknown_one_names_the_nearest(
    file, solids, with_bands, tmp_path, capsys
):
    assert len(ladder_of_file(file, part="rod").parts) == 1
    assert run_ladder(file, Wanted(part="rood", out=tmp_path)) == 2
    assert "did you mean rod" in capsys.readouterr().err


def test_a_design_without_parts_is_exit_code_2(file, tmp_path, capsys):
    file.write_text(MACHINE, encoding="utf-8")
    assert run_ladder(file, Wanted(out=tmp_path)) == 2
    assert "there are none" in capsys.readouterr().err


def test_a_page_that_cannot_be_written_is_exit_code_2(file, solids, with_bands, tmp_path, capsys):
    taken = tmp_path / "taken"
    taken.write_text("a file")
    assert run_ladder(file, Wanted(out=taken)) == 2
    assert "--out: cannot be written" in capsys.readouterr().err


def test_the_command_line_asks_for_the_ladder(monkeypatch, tmp_path):
    from ballesta.cli import main

    asked = []
    monkeypatch.setattr(ladder_command, "run_ladder", lambda *given: asked.append(given) or 0)
    code = main(["ladder", "a.toml", "--part", "rod", "--out", str(tmp_path), "--set", "k=1"])
    assert code == 0
    assert [(str(path), wanted.part, list(given)) for path, wanted, given in asked] == [
        ("a.toml", "rod", ["k=1"])
    ]


def test_an_answer_from_memory_is_charged_with_what_it_once_took(monkeypatch):
    """A mesh of 20 ms, asked for three times: twice it is spared. Sleeping never takes less."""
    meshed = []

    def mesh(self, shape, fineness, sizes=None, most_unknowns=inf):
        if (shape, fineness, sizes) not in self._meshes:
            sleep(0.02)
            meshed.append(shape)
            self._meshes[shape, fineness, sizes] = shape
        return self._meshes[shape, fineness, sizes]

    monkeypatch.setattr(Models, "mesh", mesh)
    models = PricedModels()
    assert [models.mesh("plate", 1.0) for _ in range(3)] == ["plate"] * 3
    assert meshed == ["plate"]
    assert models.spared == pytest.approx(2 * models._prices["plate", 1.0, None])
    assert models.spared >= 0.04


@pytest.mark.slow
def test_solids_of_a_plate_agree_within_their_bars(file, without_bands):
    """No band of a rung is needed: the finest solid is the measure of the two coarser ones."""
    rungs = rungs_of(ladder_of_file(file))
    coarse, middle, fine = (rungs[f"solid {fineness}"] for fineness in (0.25, 0.35, 0.5))
    for solid in (coarse, middle):
        for one, other in zip(solid.checks, fine.checks, strict=True):
            bars = one.numerical + other.numerical
            assert abs(one.value - other.value) <= bars, (solid.rung, one.kind)
    assert coarse.unknowns < fine.unknowns
