"""The model band of bores: arcs on which a pin may press, and what contacts exceed these by."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from bench.closed_forms import lug_factor
from checks.derivations.stresses import solid_bars
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.ladder.carried import _loosely
from checks.ladder.levels import Asked, first_level, solve_levels
from checks.ladder.passing_fits import with_assumed_fits
from checks.ladder.solid import stress_check
from checks.models import shapes
from checks.models.checked import band_around, rung_estimates, rung_level
from checks.models.in_bores import Arcs, in_bores
from checks.part.loaded_part import LoadedPart, Loose
from checks.part.part_loads import PartLoads, loads_on
from checks.part.pressed_along import Uneven
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.duty_verdict import duty_verdict
from checks.stress.error_bars import bars_of
from checks.stress.judged import StaticPeak
from checks.stress.solid_mesh_level import Models
from fatigue import goodman

from ..small_machine import machine

ASKED = Asked(kinds=frozenset(("static", "fatigue")), modes=False)
FORCE, WIDTH, THICK = 1000.0, 30.0, 8.0
PULLED = PartLoads(
    {
        "first": np.array([[-FORCE, 0, 0, 0, 0, 0], [FORCE, 0, 0, 0, 0, 0]]),
        "second": np.array([[FORCE, 0, 0, 0, 0, 0], [-FORCE, 0, 0, 0, 0, 0]]),
    },
    np.zeros((2, 4)),
    {"turn": slice(0, 2)},
    ("pulled", "pushed"),
    ("turn", "turn"),
)
# as solids were compared with the rungs: more pushed than pulled; by 100 kN, under which no pin of
# the default fit presses on less than the assumed arcs
PUSHED = replace(PULLED, wrenches={n: w * [[50.0], [100.0]] for n, w in PULLED.wrenches.items()})


def link(folder, share, stated=""):
    """The design of a link with holes of a share of its width."""
    text = f"""
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = {{ first = "A", second = "B" }}
material = "S275"
width = "{WIDTH} mm"
thickness = "{THICK} mm"
hole = "{share * WIDTH} mm"
mesh = {{ fineness = 0.5 }}
{stated}
"""
    return replace(machine(folder, text), accuracy=0.2)


def bars(folder, share, stated="", loads=PULLED):
    """Static and fatigue checks of a pulled link with holes of a share of its width."""
    design = link(folder, share, stated)
    part = design.parts["rod"]
    loaded = LoadedPart(design, part, loads)
    judged = [StaticPeak(loads), fatigue_use(loaded)]
    limit = endurance_of(part).value
    levels, _, _ = solve_levels(loaded, Models(), judged, limit, lambda _: None, ASKED)
    return [(what.value(levels[-1]), bars_of(what, part, levels, 0.2)) for what in judged]


@pytest.mark.parametrize("share", [0.3, 0.4, 0.5])
def test_the_default_bars_of_a_lug_reach_the_handbooks_factor(tmp_path, share):
    """A round end raises the peak above that of Peterson's square one (`lug_factor`)."""
    chart = lug_factor(share * WIDTH, WIDTH) * FORCE / ((WIDTH - share * WIDTH) * THICK)
    (value, found), _ = bars(tmp_path, share)
    assert value + found.above > chart
    assert found.in_bores == pytest.approx((1 + BEYOND_ARCS) * max(found.by_arc.values()))


def test_a_bore_whose_arc_is_not_stated_has_more_above_and_its_derivation_says_so(tmp_path):
    for (value, taken), (_, known) in zip(
        bars(tmp_path, 0.4), bars(tmp_path, 0.4, 'bearing_arc = "90 deg"'), strict=True
    ):
        assert taken.below == pytest.approx(known.below)
        assert taken.above - known.above == pytest.approx(
            BEYOND_ARCS * max(taken.by_arc.values()), rel=1e-9
        )
        assert known.in_bores == 0.0
        assert value < taken.in_bores
        steps = {item.symbol: item for item in solid_bars(taken, "sigma")[1]}
        assert "p_b - p_1" in steps["b_up"].formula
        assert steps["p_b"].value == taken.in_bores


def rung_checks(design, name, loads):
    """Static and fatigue checks of a part by formula, and its model."""
    part = design.parts[name]
    loaded = LoadedPart(design, part, loads)
    level = rung_level(loaded, shapes.model_of(part, loads))
    found = rung_estimates(loaded, level, fatigue_use(loaded), partial(shapes.model_of, part))
    return [(found[kind], level.model) for kind in ("static", "fatigue")]


def test_a_rungs_bars_reach_as_high_as_those_of_the_solid_that_may_follow(tmp_path):
    """On each arc 7 % of where solids lie, of which a better model takes the half circle's."""
    taken = rung_checks(link(tmp_path, 0.4), "rod", PUSHED)
    stated = link(tmp_path, 0.4, 'bearing_arc = "90 deg"')
    known = rung_checks(stated, "rod", PUSHED)
    solids = bars(tmp_path, 0.4, loads=PUSHED)
    for (wide, model), (narrow, _), (solid, found) in zip(taken, known, solids, strict=True):
        check = wide.check
        band = band_around(link(tmp_path, 0.4).parts["rod"], PUSHED, model, check)
        arcs = wide.bores.by_arc
        assert arcs == narrow.bores.by_arc
        assert [round(np.degrees(arc)) for arc in arcs] == [180, 135, 90]
        high = max(1.0, band.high)
        above = (1 + BEYOND_ARCS) * max(arcs.values()) * high - check.value
        assert check.model == pytest.approx(above, rel=1e-9)
        assert narrow.check.model == pytest.approx(
            max(max(arcs.values()) * high, check.value * band.high) - check.value, rel=1e-9
        )
        assert wide.above == pytest.approx(check.model - BEYOND_ARCS * check.value, rel=1e-9)
        least = check.value - min(arcs.values()) * min(1.0, band.low)
        assert check.below == narrow.check.below == pytest.approx(least, rel=1e-9)
        assert "7 % more in bores" in check.note
        assert "by arc of contact, MPa: 180 deg " in check.note
        assert check.value + check.model > solid + found.above


def test_a_bore_that_carries_less_than_the_peak_widens_nothing():
    """The lever of the quick return is strained at its slot's end, its bores by a third of that."""
    design = read_design(Path(__file__).parents[2] / "designs" / "quick_return.toml")
    part = design.parts["lever"]
    loads = loads_on(design, part, solve_cycles(design, {}))
    loaded = LoadedPart(design, part, loads)
    level = rung_level(loaded, shapes.model_of(part, loads))
    again = partial(shapes.model_of, part)
    found = rung_estimates(loaded, level, None, again)["static"].check
    assert 0.0 < in_bores(Arcs(loaded, level, again), None, found.value).most < found.value
    assert "more in bores" not in found.note


def swung_and_pulled(folder, across, pulled):
    """A long link by formula, on stated arcs: inertia across bends it, then its pins pull it."""
    design = link(folder, 0.4, 'bearing_arc = "90 deg"')
    part = design.parts["rod"]
    part = replace(part, geometry=replace(part.geometry, length=450.0))
    area = 450.0 * WIDTH + np.pi * WIDTH**2 / 4 * (1 - 2 * 0.4**2)
    force = part.material.density * area * THICK * across / 2
    first = np.array([[0, force], [0, -force], [-pulled, 0], [0, 0]])
    second = first * [[-1, 1]]
    sides = {"first": first, "second": second}
    wrenches = {name: np.pad(forces, ((0, 0), (0, 4))) for name, forces in sides.items()}
    inertia = np.array([[0, across, 0, 0], [0, -across, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]])
    labels = tuple("abcd")
    loads = PartLoads(wrenches, inertia, {"turn": slice(0, 4)}, labels, ("turn",) * 4)
    loaded = LoadedPart(design, part, loads)
    level = rung_level(loaded, shapes.model_of(part, loads))
    return Arcs(loaded, level, partial(shapes.model_of, part))


def test_a_bent_pin_is_asked_where_the_part_itself_is_strained_little(tmp_path, monkeypatch):
    """158 MPa in the swinging shank, 71 in the pulled bores, which a bent pin doubles."""
    arcs = swung_and_pulled(tmp_path, 4e6, 3000.0)
    peaks = arcs.level.peaks_by_position
    assert peaks[2] < 0.5 * peaks[0]
    uneven = dict.fromkeys(("first", "second"), Uneven(2.0, "edges", None))
    monkeypatch.setattr(LoadedPart, "uneven", uneven)
    monkeypatch.setattr("checks.models.in_bores.that_count", lambda *_, **__: uneven)
    found = in_bores(arcs, None, peaks[0])
    assert found.half == pytest.approx(2 * peaks[2], rel=1e-6)
    assert found.most > 1.1 * found.half


def test_fatigue_of_bores_on_arcs_is_that_of_their_own_positions(tmp_path):
    """The shank swings between two positions at which nothing pulls the bores."""
    arcs = swung_and_pulled(tmp_path, 1.2e6, 3000.0)
    use = fatigue_use(arcs.loaded)
    value, model = use.value(arcs.level), arcs.models[np.pi / 2]
    assert arcs.level.place(use.point(arcs.level)).startswith("plate")
    narrow = use.anew(
        arcs.level, arcs.points, model.history.basis[arcs.points], model.history.coefficients
    )
    assert narrow > 1.1 * value
    assert in_bores(arcs, use, value).most == pytest.approx(narrow, rel=1e-9)


def test_a_loose_pin_counts_at_the_positions_that_strain_its_own_bore(tmp_path, monkeypatch):
    """Pulled bores that the swinging shank exceeds, by formula and by a solid.

    The pressure of a loose pin comes on top of what they have when they are pulled.
    """
    arcs = swung_and_pulled(tmp_path, 4e6, 3000.0)
    loose = {"first": Loose(100.0, 120.0, np.radians(50.0))}
    monkeypatch.setattr(LoadedPart, "loose", loose)
    narrowest = [*arcs.models.values()][-1]
    rim = arcs.points[[arcs.level.model.places[point] == "first" for point in arcs.points]]
    own = narrowest.history.peaks_by_point(rim).max()
    assert in_bores(arcs, None, arcs.level.peak.value).loose == pytest.approx((own, 100.0))

    loads, use = arcs.loaded.loads, fatigue_use(arcs.loaded)
    pulled = use.anew(arcs.level, rim, narrowest.history.basis[rim], narrowest.history.coefficients)
    assert in_bores(arcs, use, use.value(arcs.level)).loose[0] == pytest.approx(pulled)

    loaded = replace(arcs.loaded, part=replace(arcs.loaded.part, arc_stated=False))
    level = first_level(loaded, Models())
    for what in (StaticPeak(loads), fatigue_use(loaded)):
        value, points = what.value(level), level.in_bores_of("first")
        found = bars_of(what, loaded.part, [level, level], 0.2, {}, loose)
        adds = what.of_pressure(level, points, loose["first"])
        alone = what.anew(level, points, level.history.basis[points], level.coefficients)
        assert alone < 0.9 * value
        assert found.in_bores > adds + (1 + BEYOND_ARCS) * alone
    uneven = {"first": Uneven(1.5, "edges", None)}
    monkeypatch.setattr(LoadedPart, "uneven", uneven)
    monkeypatch.setattr("checks.ladder.carried.that_count", lambda *_, **__: uneven)
    more = _loosely(loaded, "static", StaticPeak(loads), level)  # of meshes that are carried over
    assert more == pytest.approx(1.5 * 100.0 / level.peak.value)

    left = replace(stress_check(loaded, level, what, found), model=1e4, limit=1e3)
    fitted = with_assumed_fits(loaded, level, [left])  # friction counts on the loose pin's arc
    assert fitted.part.narrowest_arc == loose["first"].arc == loaded.narrowest_arc


def test_a_model_put_on_another_arc_is_the_one_that_is_built_for_it(tmp_path):
    arcs = swung_and_pulled(tmp_path, 1.2e6, 3000.0)
    assert len(arcs.models) == 2
    for arc, model in arcs.models.items():
        built = shapes.model_of(arcs.loaded.part, replace(arcs.loaded.loads, arc=arc))
        assert model.units == built.units
        np.testing.assert_array_equal(model.history.basis, built.history.basis)
        np.testing.assert_array_equal(model.history.coefficients, built.history.coefficients)


def test_no_point_is_left_out_that_uses_more_than_what_is_reached(tmp_path, monkeypatch):
    """The floor of a verdict is the stress that is reached over the limit."""
    arcs, floors = swung_and_pulled(tmp_path, 1.2e6, 3000.0), []
    level, use = arcs.level, fatigue_use(arcs.loaded)

    def judged(*asked):
        floors.append(asked[-1])
        return duty_verdict(*asked)

    monkeypatch.setattr("checks.strength.fatigue_assessment.duty_verdict", judged)
    history = level.history
    use.anew(level, arcs.points, history.basis[arcs.points], history.coefficients, reached=40.0)
    assert floors == [40.0 / use.limit]


def test_two_states_use_a_part_as_goodman_has_them(tmp_path):
    arcs = swung_and_pulled(tmp_path, 1.2e6, 3000.0)
    level, use = arcs.level, fatigue_use(arcs.loaded)
    assert use.worst(level).criterion == "Goodman"
    stress = level.history.basis @ level.coefficients[:, [0, 2]]
    used = goodman(stress, np.eye(2), level.limits, use.ultimate).utilisation
    some = [stress, stress[arcs.points], stress[:0]]
    limits = [level.limits, level.limits[arcs.points], level.limits[:0]]
    wanted = [used.max() * use.limit, used[arcs.points].max() * use.limit, 0.0]
    assert use.of_states(level, some, limits) == pytest.approx(wanted, rel=1e-12)


def test_the_edges_of_a_levers_lug_end_where_its_outline_does():
    """Beyond, the series tell nothing, and with more harmonics the most: it was 100 times this."""
    design = read_design(Path(__file__).parents[2] / "designs" / "gallery" / "shaper.toml")
    part = design.parts["lever"]
    part = replace(part, geometry=replace(part.geometry, width=58.0, slot_width=20.0))
    pull = np.array([[-1000.0, 300.0, 0, 0, 0, 0]])
    wrenches = {"pivot": pull, "tip": -pull, "slot": 0 * pull}
    loads = PartLoads(
        wrenches, np.zeros((1, 4)), {"turn": slice(0, 1)}, ("k",), ("turn",),
        {"slot": np.array([200.0])},
    )  # fmt: skip
    ends = []
    for arc in (np.pi, np.pi / 2):
        found = shapes.model_of(part, replace(loads, arc=arc))
        edge = np.char.endswith(found.places, " edge")
        far = np.abs(found.history.points[:, 0] - part.geometry.length / 2) < 130.0
        ends.append(found.history.peaks_by_point()[edge & far])
    assert len(ends[0])
    # within 2 % of the largest, which is what the series of fewer powers leaves far from the hole
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=0.02 * ends[0].max())


def test_couples_out_of_the_plane_are_not_raised_in_a_rungs_bores():
    """As in a solid: lugs were compared under forces in their plane."""
    design = read_design(Path(__file__).parents[2] / "designs" / "slider_crank.toml")
    part = design.parts["crank"]
    loads = loads_on(design, part, solve_cycles(design, {}))
    loaded = LoadedPart(design, part, loads)
    level = rung_level(loaded, shapes.model_of(part, loads))
    assert level.place(level.peak.point).startswith("first (")
    again = partial(shapes.model_of, part)
    raised = in_bores(Arcs(loaded, level, again), None, level.peak.value).half
    raised /= level.peak.value
    assert 1.0 < raised < 1.0 + 0.8 * BEYOND_ARCS
