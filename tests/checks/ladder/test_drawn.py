"""Stress to look at: parts that a formula settles get one mesh where a picture is asked for."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.ladder.part_fields import undrawn_warnings
from checks.result.live_fields import von_mises
from checks.strength.part_strength import endurance_of
from geometry.parts import PlateLink
from reports.live.section import with_encoded_fields
from reports.page_parts import _captions

from ...small_machine import MACHINE, PLATE, machine

BY_FORMULA = Effort("formula")
DRAWN = replace(BY_FORMULA, fields=True)


def checked(folder, effort, *overrides, live=True):
    return check_design(machine(folder, PLATE, *overrides), effort=effort, live=live)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    (part,) = checked(tmp_path_factory.mktemp("bare"), BY_FORMULA).parts
    return part


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return checked(tmp_path_factory.mktemp("drawn"), DRAWN)


@pytest.fixture(scope="module")
def drawn(result):
    (part,) = result.parts
    return part


def test_without_the_option_the_part_is_estimated_and_names_it(bare):
    assert bare.live.estimated
    assert "--fields" in bare.live.notes[0]


def test_the_checks_are_those_of_the_formula_to_the_last_bit(bare, drawn):
    assert drawn.checks == bare.checks
    assert drawn.meshes == []


def test_the_picture_is_near_what_the_formula_says_and_decides_nothing(drawn):
    static = next(check for check in drawn.checks if check.kind == "static")
    low, high = static.value - static.below, static.value + static.model
    assert 0.9 * low < drawn.live.peak.value < 1.1 * high
    peak = drawn.live.peak
    stress = drawn.live.at(peak.cycle, peak.position)
    assert von_mises(stress)[peak.node] == pytest.approx(peak.value, rel=1e-5)
    assert drawn.live.displacement is not None
    assert {*drawn.live.fatigue} == {"utilisation", "amplitude", "mean"}
    assert not drawn.live.decides
    assert not drawn.live.judged
    assert "decides no check" in drawn.live.notes[0]
    assert "formula" in drawn.live.notes[0]


def test_still_and_vtu_show_what_is_drawn_and_say_that_it_is_to_look_at(drawn, bare):
    assert bare.surface.is_bare
    assert not drawn.surface.is_bare
    assert all(name.endswith(", to look at") for name in drawn.surface.fields)
    shown = drawn.surface.fields["von Mises [MPa], to look at"]
    assert shown.max() == pytest.approx(drawn.live.peak.value, rel=1e-12)
    assert "to look at: the checks are decided by formula" in _captions(drawn)["whole"][2]


def goodman_of(fatigue, limit, ultimate):
    """Utilisation by amplitude and mean, and which share of the nodes Goodman's rule decides."""
    used = fatigue["amplitude"] / limit + fatigue["mean"] / ultimate
    assert (fatigue["utilisation"] > used * (1 - 1e-5)).all()
    return np.median(fatigue["utilisation"] / used)


def test_the_utilisation_that_is_drawn_is_of_the_part_s_own_limit_and_strength(drawn, tmp_path):
    part = machine(tmp_path, PLATE).parts["rod"]
    limit, ultimate = endurance_of(part).value, part.material.ultimate_stress
    assert goodman_of(drawn.live.fatigue, limit, ultimate) == pytest.approx(1.0, rel=1e-5)
    (check,) = (check for check in drawn.checks if check.kind == "fatigue")
    assert check.limit == pytest.approx(limit)
    low, high = check.value - check.below, check.value + check.model
    assert 0.9 * low < limit * drawn.live.fatigue["utilisation"].max() < 1.1 * high


def test_where_a_surface_frets_its_own_limit_is_drawn(tmp_path, drawn, monkeypatch):
    """The first hole as if a pin fretted there: a third of the limit, and of nothing else."""
    monkeypatch.setattr(PlateLink, "notch_factors", {"first": 3.0})
    (part,) = checked(tmp_path, DRAWN).parts
    plain, lowered = drawn.live.fatigue, part.live.fatigue
    radius = np.hypot(*part.live.nodes[:, :2].T)
    at_hole = np.abs(radius - 6.0) < 1e-3
    limit = endurance_of(machine(tmp_path, PLATE).parts["rod"]).value
    more = (lowered["utilisation"] - plain["utilisation"])[at_hole]
    assert_allclose(more, 2 * plain["amplitude"][at_hole] / limit, rtol=1e-3)
    assert_allclose(lowered["utilisation"][~at_hole], plain["utilisation"][~at_hole], rtol=1e-6)


def test_a_cycle_that_the_duty_has_not_does_not_use_what_is_drawn(tmp_path, drawn):
    harder = MACHINE[MACHINE.index("[cycles.turn]") : MACHINE.index("[duty]")]
    harder = harder.replace("turn]", "harder]").replace("400 N", "900 N")
    design = machine(tmp_path, PLATE + harder)
    (part,) = check_design(design, effort=DRAWN, live=True).parts
    assert part.live.peak.cycle == "harder"
    assert part.live.peak.value > 1.5 * drawn.live.peak.value
    assert_allclose(part.live.fatigue["utilisation"], drawn.live.fatigue["utilisation"], rtol=1e-6)


def test_the_page_is_told_that_it_decides_nothing(result):
    (part,) = with_encoded_fields(result).parts
    assert part.live.head["decides"] is False
    assert part.live.head["limits"]["fatigue"] is None
    assert result.command.endswith("--fidelity formula --fields") or (
        "--fidelity formula --fields" in result.command
    )


def test_a_part_that_cannot_be_meshed_keeps_its_estimate_and_says_why(tmp_path, bare):
    few = "parts.rod.mesh.most_unknowns=1000"
    (part,) = checked(tmp_path, DRAWN, few).parts
    assert part.live.estimated
    note = part.live.notes[0]
    assert note.startswith("no mesh to look at: ")
    assert "mesh.most_unknowns is 1000" in note
    assert undrawn_warnings([part]) == [f"rod: {note}"]
    assert [check.value for check in part.checks] == [check.value for check in bare.checks]


def test_no_mesh_is_begun_that_there_is_no_time_for(tmp_path):
    (part,) = checked(tmp_path, replace(DRAWN, within=1e-3)).parts
    assert part.live.estimated
    assert "s are left" in part.live.notes[0]


def test_nothing_is_meshed_where_nobody_looks(tmp_path, monkeypatch):
    monkeypatch.setattr("checks.ladder.part_ladder.with_drawn_fields", None)
    (part,) = checked(tmp_path, DRAWN, live=False).parts
    assert part.live is None


def test_the_fields_of_a_solid_stay_those_that_decide(tmp_path):
    solid = Effort("solid", fields=True)
    (part,) = checked(tmp_path, solid, 'accuracy="50 %"').parts
    assert part.live.decides
    assert np.isfinite(part.checks[0].numerical)


def test_a_buckling_mode_by_formula_is_drawn_on_the_mesh_to_look_at(tmp_path):
    """A rod that is pulled, and bent by its own inertia: its elastic load governs, no column."""
    path = tmp_path / "pulled.toml"
    path.write_text((MACHINE + PLATE).replace('"400 N"', '"-400 N"'), encoding="utf-8")
    design = read_design(path, ["require.buckling=1e9"])
    result = check_design(design, effort=DRAWN, live=True)
    (part,) = result.parts
    assert result.deciding.quantity == "elastic load share"
    assert result.deciding.method == "formula"
    assert not part.live.estimated
    assert np.linalg.norm(part.live.mode, axis=1).max() == pytest.approx(1)
    assert "estimate by formula" in part.live.notes[-1]
