"""Which rungs are tried, and what a part's result says of it."""

from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import AUTO
from checks.design.errors import DesignError
from checks.ladder import climb
from checks.ladder.climb import climb_cheap, start_climb
from checks.ladder.part_ladder import Effort, Ladder
from checks.ladder.result import cheap_result, solid_result
from checks.models import bands
from checks.models.bands import proportions_of
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.result.verdict import NOT_MESHED, Status
from checks.result.words import reason
from checks.stress.kept_models import check_seconds
from checks.stress.solid_mesh_level import Models

from ...small_machine import PLATE, machine, solved
from ..models.wide_bands import bands_of

GALLERY = Path(__file__).parents[3] / "designs" / "gallery"
LOOSE = "accuracy=25%"  # two meshes say which model has judged as well as four


@pytest.fixture
def bars(monkeypatch):
    """Set the bars of the rungs."""

    def put(**widths):
        monkeypatch.setattr(bands, "_data", lambda: bands_of(**widths))

    return put


def started(folder, *overrides, text=PLATE):
    design = machine(folder, text, *overrides)
    part = design.parts["rod"]
    cycles = solved(design)
    return start_climb(LoadedPart(design, part, loads_on(design, part, cycles), cycles))


def required_at(state, kind, utilisation):
    """The required safety at which a check of a climb is used so far."""
    check = state.best[kind].check
    return utilisation * check.limit / check.value


def test_a_part_that_obviously_passes_stops_at_the_formula(tmp_path, bars):
    bars(formula=0.1)
    state = started(tmp_path)
    assert not climb_cheap(state, AUTO)
    assert [rung.rung for rung in state.tried] == ["formula"]
    assert state.tried[0].why.startswith("stopped: static pass")


def test_no_rung_below_a_solid_settles_a_part_at_its_limit(tmp_path, bars):
    bars(formula=0.1)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    state = started(tmp_path, f"require.static={required_at(first, 'static', 1.0)}")
    assert climb_cheap(state, AUTO)
    assert state.open == ["static"]


def test_proportions_that_no_solid_was_compared_at_climb_to_the_solid(tmp_path, monkeypatch):
    monkeypatch.setattr(bands, "_data", lambda: {})
    state = started(tmp_path)
    assert climb_cheap(state, AUTO)
    assert state.best["static"].check.model == inf
    assert "no error bar" in state.best["static"].check.note


def test_an_estimate_beyond_all_that_was_compared_fails_where_half_of_it_is_over_the_limit(
    tmp_path, monkeypatch
):
    """2.2 times what is allowed is a FAIL, but a better model is asked; 4.5 times needs none."""
    known = bands_of(formula=0.1)
    for kind in known["plate_link"]["formula"].values():
        kind["scales"] = dict.fromkeys(proportions_of(*rod_of(started(tmp_path))), (1e6, 2e6))
    monkeypatch.setattr(bands, "_data", lambda: known)
    monkeypatch.setattr(bands, "_beyond_data", dict)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    for share, status in ((1.9, Status.UNDECIDED), (2.2, Status.FAIL), (4.5, Status.FAIL)):
        state = started(tmp_path, f"require.static={required_at(first, 'static', share)}")
        climb_cheap(state, AUTO)
        check = state.best["static"].check
        assert (check.status, check.model) == (status, inf)
        assert state.best["static"].settled is (share == 4.5)
    assert "over the limit" in reason(check)
    assert "at the least plausible value" in reason(check)


def rod_of(state):
    return state.part, state.loads


def test_fkm_goes_straight_to_the_solid(tmp_path, bars):
    bars(formula=0.1)
    fkm = ('parts.rod.strength="fkm"', 'parts.rod.roughness="25 um"')
    state = started(tmp_path, *fkm)
    assert climb_cheap(state, AUTO)
    assert state.level is None
    assert "FKM" in state.tried[0].why


def test_a_part_that_passes_by_formula_is_never_meshed(tmp_path, bars, monkeypatch):
    bars(formula=0.1)
    design = machine(tmp_path, PLATE)

    def no_mesh(*_):
        raise AssertionError("meshed")

    monkeypatch.setattr(Models, "mesh", no_mesh)
    result = check_design(design)
    (part,) = result.parts
    assert part.meshes == []
    assert part.surface.is_bare
    assert not np.any(part.surface.fields[NOT_MESHED])
    assert part.facts["mass [kg]"] > 0.1
    assert {check.method for check in part.checks} == {"formula"}
    assert [gate.name for gate in part.gates if not gate.holds] == []


def test_every_fidelity_gives_the_same_checks_by_its_own_model(tmp_path, bars):
    bars(formula=0.2)
    design = machine(tmp_path, PLATE)
    values = {}
    for fidelity in ("formula", "solid"):
        (part,) = check_design(design, effort=Effort(fidelity)).parts
        stress = {check.kind: check for check in part.checks if check.kind in ("static", "fatigue")}
        by_model = "solid" if fidelity == "solid" else "formula"
        assert {check.method for check in stress.values()} == {by_model}
        values[fidelity] = {kind: check.value for kind, check in stress.items()}
        (share,) = (check for check in part.checks if check.quantity == "elastic load share")
        assert share.method.split()[0] == fidelity
    for fidelity, found in values.items():
        for kind, value in found.items():
            assert value == pytest.approx(values["solid"][kind], rel=0.12), (fidelity, kind)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.98, 1.015])
def test_a_verdict_by_auto_is_that_of_the_solid_near_the_limit(tmp_path, bars, share):
    """The solid that `auto` comes to judges as the whole solid does, and says what it tried."""
    bars(formula=0.1)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    need = required_at(first, "static", share)
    design = machine(tmp_path, PLATE, f"require.static={need}", LOOSE)
    (part,) = check_design(design).parts
    (whole,) = check_design(design, effort=Effort("solid")).parts
    by_auto, by_solid = (
        next(check for check in one.checks if check.kind == "static") for one in (part, whole)
    )
    assert by_auto.status is by_solid.status
    assert by_auto.method == by_solid.method
    assert by_auto.value == pytest.approx(by_solid.value, abs=by_solid.numerical)
    assert part.rungs[-1].rung == "solid"
    assert part.rungs[-1].seconds > 0


def test_without_time_no_solid_is_begun_and_what_it_would_settle_is_told(tmp_path, bars):
    bars(formula=0.1)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    need = required_at(first, "static", 1.0)
    design = machine(tmp_path, PLATE, f"require.static={need}")
    result = check_design(design, effort=Effort(within=0.001))
    (part,) = result.parts
    assert part.meshes == []
    assert part.rungs[-1].why.startswith("no time")
    assert part.rungs[-1].why.endswith("it may settle static")
    assert "let a solid judge it" in [way.text for way in result.ways]
    assert any("it may settle static" in text for text in result.warnings)
    assert result.status is Status.UNDECIDED
    assert "--within 0.001s" in result.command


def test_the_time_of_a_solid_is_told_from_the_mesh_that_it_begins_with(tmp_path, bars):
    """Of stress alone: half of a coarse one, where the whole solid would begin with a finer one."""
    bars(formula=0.1)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    need = required_at(first, "static", 1.0)
    design = machine(tmp_path, PLATE, f"require.static={need}", LOOSE)
    (late,) = check_design(design, effort=Effort(within=0.001)).parts
    (part,) = check_design(design).parts
    unknowns = part.meshes[0]["unknowns"]
    assert late.rungs[-1].expected == pytest.approx(check_seconds(unknowns, stress=True))


def test_a_solid_of_more_unknowns_than_allowed_leaves_what_the_formula_knows(tmp_path, bars):
    """A long thin beam is one; asked for, such a solid is refused."""
    bars(static=100.0)
    design = machine(tmp_path, PLATE, "parts.rod.mesh.most_unknowns=100")
    result = check_design(design)
    (part,) = result.parts
    assert result.status is Status.UNDECIDED
    assert [rung.rung for rung in part.rungs] == ["formula", "solid"]
    assert {check.method for check in part.checks if check.kind == "static"} == {"formula"}
    assert any("rod: solid: mesh.most_unknowns is 100" in text for text in result.warnings)
    assert any("allow at least twice as many" in way.text for way in result.ways)
    with pytest.raises(DesignError, match=r"most_unknowns is 100, but"):
        check_design(design, effort=Effort("solid"))


def test_parts_that_need_solids_come_cheapest_first_under_a_time_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(bands, "_data", lambda: {})
    two = PLATE + PLATE.replace("[parts.rod]", "[parts.crank]").replace(
        'body = "rod"', 'body = "crank"'
    ).replace('first = "A", second = "B"', 'first = "O", second = "A"').replace(
        'width = "30 mm"', 'width = "60 mm"'
    )
    design = machine(tmp_path, two)
    order = []
    costs = {"rod": 9.0, "crank": 2.0}

    def noted(state, models, *_, **__):
        order.append(state.part.name)
        return cheap_result(state, models)

    monkeypatch.setattr("checks.ladder.part_ladder.solid_result", noted)
    monkeypatch.setattr("checks.ladder.part_ladder.Ladder._cost", lambda _, name: costs[name])
    Ladder(design, Models(), Effort(within=1e6), 0.0, lambda _: None).check(solved(design))
    assert order == ["crank", "rod"]


def test_what_no_model_settles_is_not_meshed(tmp_path, bars, monkeypatch):
    """A band that every model has, across the limit wherever in the formula's bars the value is."""
    bars(formula=0.05)

    def wide(check):
        return replace(
            check, model=check.model + check.value, model_below=check.below + 0.9 * check.value
        )

    monkeypatch.setattr(climb, "leaf_band", lambda *_: wide)
    arc = 'parts.rod.bearing_arc="90 deg"'  # of a loose pin a solid's contact knows more
    first = started(tmp_path, arc)
    climb_cheap(first, AUTO)
    need = [f"require.{kind}={required_at(first, kind, 1.0)}" for kind in ("static", "fatigue")]
    state = started(tmp_path, arc, *need)
    assert not climb_cheap(state, AUTO)
    assert "stays UNDECIDED by what every model assumes" in state.tried[-1].why


def test_a_band_of_bent_pins_goes_to_the_solid_whose_contact_narrows_it():
    """The gas engine's rod by formula: 87 +130 MPa of 134, nearly all above by its gudgeon pin."""
    design = read_design(GALLERY / "gas_engine.toml", ["cycles.run.positions=73"])
    cycles, part = solved(design), design.parts["rod"]
    state = start_climb(LoadedPart(design, part, loads_on(design, part, cycles), cycles))
    assert climb_cheap(state, AUTO)
    assert state.open == ["fatigue"]
    estimate = state.best["fatigue"]
    assert estimate.check.status is Status.UNDECIDED
    assert estimate.check.model > 100.0
    assert estimate.above > 0.9 * estimate.check.model


def test_a_solid_that_is_asked_for_one_check_leaves_the_others_to_the_rungs_below(tmp_path, bars):
    bars(formula=0.1)
    first = started(tmp_path)
    climb_cheap(first, AUTO)
    state = started(tmp_path, f"require.fatigue={required_at(first, 'fatigue', 1.0)}", LOOSE)
    assert climb_cheap(state, AUTO)
    assert state.open == ["fatigue"]
    result = solid_result(state, Models(), lambda _: None, everything=False)
    methods = {check.kind: check.method for check in result.checks if "column" not in check.quantity
               and "crooked" not in check.quantity}  # fmt: skip
    assert methods["fatigue"] == "solid"
    assert methods["buckling"] == "formula"


@pytest.mark.slow
def test_a_solid_that_fails_by_its_bars_is_not_refined_for_its_other_checks(tmp_path, bars):
    """Static fails by a third; fatigue is at its limit, which a finer mesh would look into."""
    bars()
    known = started(tmp_path)
    result = solid_result(known, Models(), lambda _: None, everything=True)
    values = {check.kind: check.limit / check.value for check in result.checks[:2]}
    state = started(
        tmp_path,
        f"require.static={1.33 * values['static']}",
        f"require.fatigue={values['fatigue']}",
        "accuracy=0.1%",
    )
    result = solid_result(state, Models(), lambda _: None, everything=False)
    status = {check.kind: check.status for check in result.checks[:2]}
    assert status == {"static": Status.FAIL, "fatigue": Status.UNDECIDED}
    assert len(result.meshes) == 2
    assert any("fails already (static)" in check.note for check in result.checks)
