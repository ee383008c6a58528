"""Pins whose fit is stated: contact decides the checks of a part, and both ends of its range."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from checks.derivations.stresses import solid_bars
from checks.design.errors import DesignError
from checks.ladder import solid
from checks.ladder.climb import start_climb
from checks.ladder.levels import Asked, first_level, solve_levels
from checks.ladder.part_facts import assumed_of, contact_facts, gates_of
from checks.ladder.result import solid_result
from checks.ladder.solid import _judgement, check_solid
from checks.models import shapes
from checks.models.bands import NoBand
from checks.models.checked import band_around, rung_estimates, rung_level
from checks.part.loaded_part import LoadedPart, with_fits
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, Status
from checks.result.ways import clearance_fact, mesh_that_settles
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.clearances import over_clearances
from checks.stress.error_bars import _missed_of_contact, bars_of
from checks.stress.judged import StaticPeak
from checks.stress.pins_in_bores import CLEARANCES, LARGEST, LEAST, MIDDLE, fits_of
from checks.stress.solid_mesh_level import Models
from fem.contact.superposed import superposed
from reports.gauge import shares

from ..small_machine import machine

ASKED = Asked(kinds=frozenset(("static", "fatigue")), modes=False)
FORCE = 300.0


def pulled(force=FORCE):
    """The first bore towards -x, the second towards +x, and back to a tenth."""
    along = np.outer([force, 0.1 * force], [1.0, 0, 0, 0, 0, 0])
    return PartLoads(
        {"first": -along, "second": along},
        np.zeros((2, 4)),
        {"turn": slice(0, 2)},
        ("pulled", "released"),
        ("turn", "turn"),
    )


def rod(folder, stated="", loads=None):
    """The eye of "quick return, rod" in docs/validation.md, 48 mm between its pins."""
    text = f"""
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = {{ first = "A", second = "B" }}
material = "S275"
width = "16 mm"
thickness = "6 mm"
hole = "8 mm"
mesh = {{ fineness = 0.6 }}
{stated}
"""
    design = replace(machine(folder, text), accuracy=0.2)
    return LoadedPart(design, design.parts["rod"], pulled() if loads is None else loads)


def solved(loaded):
    """Levels, and value and bars of the static and the fatigue check."""
    judged = [StaticPeak(loaded.loads), fatigue_use(loaded)]
    limit = endurance_of(loaded.part).value
    levels, _, _ = solve_levels(loaded, Models(), judged, limit, lambda _: None, ASKED)
    return levels, [(w.value(levels[-1]), bars_of(w, loaded.part, levels, 0.2)) for w in judged]


@pytest.fixture(scope="module")
def loose(tmp_path_factory):
    """Both pins with 0 to 0.04 mm of clearance."""
    loaded = rod(
        tmp_path_factory.mktemp("loose"),
        'fits = { first = "0 .. 0.04 mm", second = "0 .. 0.04 mm" }',
    )
    return loaded, *solved(loaded)


def test_a_neat_pin_stresses_an_eye_as_calculix_says(tmp_path):
    """Plane contact: 17 MPa, cosines 19.9 to 23.4 MPa; a solid's peak is some 5 % above it."""
    _, ((value, bars), _) = solved(rod(tmp_path, 'fits = { first = "0 mm", second = "0 mm" }'))
    assert 0.97 < value / 17.0 < 1.1
    assert bars.above == bars.below == 0
    _, ((cosine, _), _) = solved(rod(tmp_path))
    assert cosine > 1.08 * value


def test_the_band_of_a_fit_reaches_both_ends_and_nothing_else(loose):
    _, _, found = loose
    for value, bars in found:
        assert bars.by_arc == {}
        assert bars.in_bores == 0
        values = bars.clearances.values
        assert set(CLEARANCES) < set(values)
        assert values[MIDDLE] == value
        assert value + bars.above == pytest.approx(max(values.values()))
        assert value - bars.below == pytest.approx(min(values.values()))
    (_, bars), _ = found
    assert bars.clearances.values[LARGEST] > 1.2 * bars.clearances.values[LEAST]


def test_the_end_of_a_range_is_the_contact_of_that_clearance(loose, tmp_path):
    """On one mesh, the first."""
    loaded, levels, _ = loose
    judged = StaticPeak(loaded.loads)
    over = over_clearances(judged, levels[0])
    alone = rod(tmp_path, 'fits = { first = "0.04 mm", second = "0.04 mm" }')
    value = judged.value(first_level(alone, Models()))
    assert over.values[LARGEST] == pytest.approx(value, rel=0.02)


def test_the_derivation_of_a_fits_band_is_the_checks(loose):
    """Its formulas stand for the numbers: of solid_bars, and of the checks that a user reads."""
    loaded, _, found = loose
    result = check_solid(loaded, Models(), asked=ASKED)
    for check, (value, bars) in zip(result.checks, found, strict=True):
        _, items = solid_bars(bars, "v")
        assert {"fit_1", "fit_2", "fit_3", "b_up", "b_lo"} <= {item.symbol for item in items}
        assert not any(item.symbol.startswith("p_") for item in items)
        assert check.value == pytest.approx(value)
        assert check.derivation is not None
        numbers = check.derivation.values
        assert numbers["b_up"] == pytest.approx(bars.above)
        assert numbers["b_lo"] == pytest.approx(bars.below)
        (fit,) = (share for share in shares(check) if share.name.startswith("clearance of pins"))
        least = check.limit / (value + bars.clearances.above)
        assert float(fit.ends.partition(" ")[0]) == pytest.approx(least, rel=0.01)


def test_contact_is_a_validity_check_and_is_told(loose):
    loaded, levels, _ = loose
    properties = Models().body(loaded.part.geometry).mass_properties(loaded.part.material.density)
    gates = {gate.name: gate for gate in gates_of(loaded, levels, properties)}
    assert gates["rod: contact of its pins"].holds
    assert all(gates[f"rod: {name}"].holds for name in ("loads on the mesh", "support reactions"))
    level = levels[-1]
    worse = replace(
        level.contact,
        cycle=replace(level.contact.cycle, not_complementary=1e-5),
    )
    broken = [*levels[:-1], replace(level, contact=worse)]
    gates = {gate.name: gate for gate in gates_of(loaded, broken, properties)}
    assert not gates["rod: contact of its pins"].holds
    said = " ".join(assumed_of(loaded, level))
    assert "first: pin of the part's own S275" in said
    assert "cosine" not in said
    facts = contact_facts(level)
    assert len(facts) == 2
    assert all("0.02 mm: " in text and " deg, " in text for text in facts.values())


def test_the_order_of_keys_does_not_matter(tmp_path, loose):
    _, levels, _ = loose
    turned = rod(tmp_path, 'fits = { second = "0 .. 0.04 mm", first = "0 .. 0.04 mm" }')
    again, _ = solved(turned)
    for one, other in zip(levels, again, strict=True):
        assert_array_equal(one.history.coefficients, other.history.coefficients)
        assert_array_equal(one.history.basis, other.history.basis)


def test_one_fit_leaves_the_other_bore_its_arcs(tmp_path):
    levels, ((_, bars), _) = solved(
        rod(tmp_path, 'fits = { second = "0 mm" }\nbearing_arc = "120 deg"')
    )
    assert bars.by_arc
    assert bars.clearances is not None
    assert set(levels[-1].solved_bores) == {"second"}
    at_first = levels[-1].history.points[StaticPeak(pulled()).point(levels[-1])][0]
    assert at_first < 5  # the neat pin presses less hard than the cosine


def test_a_pin_is_of_the_material_of_the_pin_part(tmp_path):
    loaded = rod(tmp_path, 'fits = { first = "0 mm", second = "0 mm" }')
    steel = loaded.part.material
    soft = replace(steel, name="soft", youngs_modulus=70e3, endurance_ratio=0.4)
    pin = replace(loaded.part, name="pin", body=None, joint="B", material=soft)
    design = replace(loaded.design, parts={**loaded.design.parts, "pin": pin})
    fits = fits_of(replace(loaded, design=design))
    assert fits["second"].youngs_modulus == 70e3
    assert fits["second"].material == "pin of soft"
    assert fits["first"].youngs_modulus == steel.youngs_modulus


def test_fits_of_all_bores_beside_an_arc_are_refused(tmp_path):
    with pytest.raises(DesignError, match=r"parts\.rod\.bearing_arc: the fit of the pin in every"):
        rod(tmp_path, 'fits = { first = "H7/f7", second = "H7/f7" }\nbearing_arc = "120 deg"')


def test_a_pin_that_carries_nothing_is_refused(tmp_path):
    loads = pulled(0.0)
    loaded = rod(tmp_path, 'fits = { first = "H7/f7" }', loads)
    with pytest.raises(DesignError, match=r"parts\.rod\.fits: nothing presses in 'first'"):
        solved(loaded)


def by_formula(loaded, kind):
    """The static or the fatigue check, and its band."""
    faces = loaded.part.geometry.placed_interfaces
    loaded = replace(loaded, part=with_fits(loaded.part, loaded.loads, faces, {}))
    model = shapes.model_of(loaded.part, loaded.loads)
    level = rung_level(loaded, model)
    found = rung_estimates(loaded, level, fatigue_use(loaded), lambda _: model)[kind].check
    return found, band_around(loaded.part, loaded.loads, model, found)


@pytest.mark.parametrize("kind", ["static", "fatigue"])
def test_a_close_fit_in_one_bore_leaves_formulas_the_bars_of_arcs_that_are_not_stated(
    tmp_path, kind
):
    """The neat pin's arc is among those that are assumed where nothing is stated."""
    silent, band = by_formula(rod(tmp_path), kind)
    found, same = by_formula(rod(tmp_path, 'fits = { second = "0 mm" }'), kind)
    assert (found.value, found.model, same) == (silent.value, silent.model, band)


@pytest.mark.parametrize("kind", ["static", "fatigue"])
def test_where_a_fit_is_loose_formulas_do_not_decide_stress(tmp_path, kind):
    loaded = rod(tmp_path, 'fits = { first = "H7/f7", second = "H7/f7" }')
    _, band = by_formula(loaded, kind)
    assert isinstance(band, NoBand)
    assert "on a solid only" in band.why


PIN_A = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "{} mm"
stack = [
  {{ body = "rod", at = "0 mm", width = "6 mm"{} }},
  {{ body = "crank", at = "8 mm", width = "8 mm" }},
]
"""
BUSH = ', bush = { length = "6 mm", allowable = "20 MPa" }'


def test_a_pin_thinner_than_its_hole_is_as_loose_as_both_say(tmp_path):
    """7.5 in 8 mm: no arc is assumed. H7/f7 leaves at most 0.043 mm there, which 7.96 mm is in."""
    stated = rod(tmp_path, 'fits = { first = "0.5 .. 0.5 mm" }').part
    found = rod(tmp_path, PIN_A.format(7.5, ""))
    assert found.part.clearances == stated.clearances == {"first": (0.5, 0.5)}
    assert isinstance(by_formula(found, "static")[1], NoBand)
    for pin in (PIN_A.format(7.96, ""), PIN_A.format(7.5, BUSH)):
        assert rod(tmp_path, pin).part.clearances == {}
    assert rod(tmp_path, 'bearing_arc = "90 deg"' + PIN_A.format(7.5, "")).part.clearances == {}


def open_force(folder, stated=""):
    """A force at which the arcs' band holds the fatigue limit."""
    loaded = rod(folder, stated)
    _, (_, (value, bars)) = solved(loaded)
    limit = fatigue_use(loaded).limit / loaded.required.fatigue
    return FORCE * limit / (value + bars.above / 2)


def fatigue_of(result):
    (check,) = (one for one in result.checks if one.kind == "fatigue")
    return check


def test_a_way_out_names_clearances_up_to_which_contact_passes_and_it_does(tmp_path, monkeypatch):
    """A running fit may press harder than the arcs' band says: it stays open, a closer one not.

    No level is judged twice: without assumed arcs none of them can settle it.
    """
    judged = []

    def counted(loaded, levels, what, doubts):
        judged.append((levels[-1], what))
        return _judgement(loaded, levels, what, doubts)

    monkeypatch.setattr(solid, "_judgement", counted)
    force = open_force(tmp_path)
    result = check_solid(rod(tmp_path, loads=pulled(force)), Models(), asked=ASKED)
    assert fatigue_of(result).status is Status.UNDECIDED
    assert len(judged) == len(set(judged)) > 0
    assert "ASSUMED" in " ".join(result.assumed)
    most = {name: result.facts[clearance_fact("fatigue", name)] for name in ("first", "second")}
    stated = ", ".join(f'{name} = "0 .. {value:g} mm"' for name, value in most.items())
    again = check_solid(
        rod(tmp_path, f"fits = {{ {stated} }}", pulled(force)), Models(), asked=ASKED
    )
    assert fatigue_of(again).status is Status.PASS


def test_a_running_fit_is_assumed_and_told_where_arcs_leave_a_check_open(tmp_path):
    """As if it were stated, but for meshes that arcs were refined for."""
    force = open_force(tmp_path)
    result = check_solid(rod(tmp_path, loads=pulled(force)), Models(), asked=ASKED)
    found = fatigue_of(result)
    said = " ".join(result.assumed)
    assert "0 to 0.043 mm of clearance (H7/f7 or closer ASSUMED: the design states no fit)" in said
    assert "cosine" not in said
    assert any(gate.name == "rod: contact of its pins" for gate in result.gates)
    fits = 'fits = { first = "0 .. 0.043 mm", second = "0 .. 0.043 mm" }'
    stated = check_solid(rod(tmp_path, fits, pulled(force)), Models(), asked=ASKED)
    for name in ("value", "model", "model_below"):
        known = getattr(fatigue_of(stated), name)
        assert getattr(found, name) == pytest.approx(known, rel=0.02, abs=0.02 * found.value)
    assert "ASSUMED" not in " ".join(stated.assumed)


def test_where_arcs_decide_no_fit_is_assumed(tmp_path):
    result = check_solid(rod(tmp_path, loads=pulled(FORCE / 4)), Models(), asked=ASKED)
    assert all(check.status is Status.PASS for check in result.checks)
    assert "cosine" in " ".join(result.assumed)
    assert "ASSUMED" not in " ".join(result.assumed)


@pytest.mark.slow
def test_a_mesh_is_refined_beyond_the_accuracy_where_that_settles_a_check(tmp_path):
    """A limit inside of a numerical bar of 20 %, with nothing else uncertain."""
    arc = 'bearing_arc = "180 deg"'
    loaded = rod(tmp_path, arc)
    _, (_, (value, bars)) = solved(loaded)
    limit = fatigue_use(loaded).limit / loaded.required.fatigue
    force = FORCE * limit / (value + bars.numerical.value / 2)
    loaded = rod(tmp_path, arc, pulled(force))
    left = check_solid(loaded, Models(), asked=ASKED)
    assert fatigue_of(left).status is Status.UNDECIDED
    share, more = mesh_that_settles(fatigue_of(left))
    assert 0 < share < 0.2
    assert more > 1

    def settling(checks, _unknowns):
        return min(mesh_that_settles(one)[0] * one.value / one.numerical or 1.0 for one in checks)

    settled = check_solid(loaded, Models(), asked=replace(ASKED, settling=settling))
    assert fatigue_of(settled).status is not Status.UNDECIDED
    assert len(settled.meshes) == len(left.meshes) + 1


def test_auto_asks_for_a_mesh_that_settles_within_the_unknowns_allowed(tmp_path, monkeypatch):
    loaded = rod(tmp_path)
    asked = []

    def stand_in(_loaded, _models, _say, given):
        asked.append(given)
        return check_solid(loaded, Models(), asked=ASKED)

    monkeypatch.setattr("checks.ladder.result.check_solid", stand_in)
    solid_result(start_climb(loaded), Models(), lambda _: None, everything=False)
    (given,) = asked
    check = Check(
        part="rod", kind="static", quantity="", value=100.0, unit="MPa", numerical=4.0, model=0.0,
        limit=153.0, required=1.5, cycle="", position="", place="", method="solid", basis="",
    )  # fmt: skip
    share, more = mesh_that_settles(check)
    assert (share, more) == (pytest.approx(0.02), pytest.approx(2**1.5))
    most = loaded.part.most_unknowns
    assert given.settling([check], 0.9 * most / more) == share * 100.0 / 4.0
    assert given.settling([check], 1.1 * most / more) == 1
    assert given.settling([replace(check, numerical=1.0)], 1e3) == 1


def test_a_force_and_its_opposite_reach_the_mesh_exactly(tmp_path):
    loads = pulled()
    turned = {name: wrench * [[1.0], [-5.0]] for name, wrench in loads.wrenches.items()}
    loads = replace(loads, wrenches=turned)
    loaded = rod(tmp_path, 'fits = { first = "H7/g6", second = "H7/g6" }', loads)
    levels, _ = solved(loaded)
    assert levels[-1].load_residual(loads) < 1e-9
    assert levels[-1].reaction_residual(loads) < 1e-9
    contact = levels[-1].contact
    arcs = contact.cycle.bores["second"].arcs
    assert arcs[1] < arcs[0]  # half the force


@pytest.mark.slow
def test_pressure_that_patterns_miss_counts_as_what_it_changes(monkeypatch, tmp_path):
    """A loose pin whose force turns all around, with hardly a pattern and with one a position."""
    angles = 2 * np.pi * np.arange(24) / 24
    second = np.zeros((24, 6))
    second[:, 0], second[:, 1] = FORCE * np.cos(angles), FORCE * np.sin(angles)
    first = -second
    first[:, 5] = -48 * second[:, 1]
    loads = PartLoads(
        {"first": first, "second": second},
        np.zeros((24, 4)),
        {"turn": slice(0, 24)},
        tuple(f"{k}" for k in range(24)),
        ("turn",) * 24,
    )
    loaded = rod(tmp_path, 'fits = { first = "0.1 mm", second = "0.1 mm" }', loads)
    often = replace(loaded.duty, life="finite", damage_so_far=1e-6, cycles={"turn": 1e12})
    used = replace(loaded, design=replace(loaded.design, duty=often))
    judged = [StaticPeak(loads), fatigue_use(loaded), fatigue_use(used)]
    found, missed = {}, {}
    for patterns in (4, 48):
        monkeypatch.setattr(
            "checks.stress.pins_in_bores.superposed",
            lambda bores, cycle, most=patterns: superposed(bores, cycle, most),
        )
        level = first_level(loaded, Models())
        found[patterns] = [(w.value(level), _missed_of_contact(w, level)) for w in judged]
        missed[patterns] = level.contact.most_missed.max()
    assert missed[4] > 10 > 1000 * missed[48]
    for (rough, bar), (exact, none) in zip(found[4], found[48], strict=True):
        assert none < 1e-3 * exact
        assert abs(rough - exact) <= bar + 1e-3 * exact
        assert bar < 1.1 * max(abs(rough - exact), 0.01 * exact)
