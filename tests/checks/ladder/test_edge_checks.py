"""Parts with sharp re-entrant edges: static by a field that spares them, fatigue by Taylor's point.

The plates of tests/fem/notched.py, pulled to 100 MPa and pushed back to -100 MPa.
"""

from dataclasses import replace
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.ladder.edge_checks import (
    NotJudged,
    critical_distance,
    edge_fatigue,
    edge_static,
    known_at_edges,
)
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, Status
from checks.strength.fatigue_assessment import FatigueUse
from checks.stress.error_bars import bars_of
from checks.stress.judged import StaticPeak, direct_under
from checks.stress.sharp_edges import Spared, spared_level
from checks.stress.solid_mesh_level import solve_level
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from tests.fem.notched import Plate, reference

LIMIT, ULTIMATE, YIELD = 100.0, 500.0, 355.0
DUTY = {"pull": 1.0}
LENGTH = 0.2  # mm


def loads_of(plate, ends=(1.0, -1.0)):
    wrenches = {name: np.outer(ends, wrench) for name, wrench in plate.wrenches().items()}
    count = len(ends)
    labels = tuple(f"{end:+g}" for end in ends)
    return PartLoads(
        wrenches, np.zeros((count, 4)), {"pull": slice(0, count)}, labels, ("pull",) * count
    )


def levels_of(opening, sizes, thick=4.0, ends=(1.0, -1.0)):
    loads, levels = loads_of(Plate(opening, thick, 1.0), ends), []
    for size in sizes:
        solutions = solve_unit_loads(
            mesh_shape(Plate(opening, thick, size)), Elastic(210e3, 0.3, 7.85e-9)
        )
        levels.append(solve_level(solutions, 1.0, loads, LIMIT, ULTIMATE, DUTY))
    return loads, levels


def part_of(threshold=None, ductile=True):
    material = SimpleNamespace(
        ultimate_stress=ULTIMATE, endurance_ratio=None, threshold=threshold, ductile=ductile
    )
    geometry = SimpleNamespace(stressed_evenly=True)
    return SimpleNamespace(
        material=material,
        geometry=geometry,
        surface="ground",
        reliability=0.5,
        bearing_arc=pi,
        arc_stated=True,
        clearances={},
        interfaces={},
    )


def threshold_for(length):
    """MPa mm^0.5, with 250 MPa of a polished bar of 500 MPa: L = (threshold / 500)^2 / pi."""
    return 500.0 * (pi * length) ** 0.5


def loaded(part, loads):
    duty = SimpleNamespace(cycles=DUTY)
    return SimpleNamespace(
        part=part, loads=loads, duty=duty, accuracy=0.05, runs={}, uneven={}, loose={}
    )


def made(judged, limit):
    def make(level, bars):
        return Check(
            part="plate",
            kind="fatigue",
            quantity="",
            value=judged.value(level),
            unit="MPa",
            numerical=bars.numerical.value,
            model=bars.above,
            limit=limit,
            required=1.0,
            cycle="",
            position="",
            place=level.place(judged.point(level)),
            method="solid",
            basis="",
        )

    return make


@pytest.fixture(scope="module", params=[90, "step"])
def plate(request):
    loads, levels = levels_of(request.param, (4.0, 2.0))
    return request.param, loads, levels


def test_the_critical_distance_is_that_of_a_polished_bar_at_even_reversal():
    assert_allclose(critical_distance(part_of(threshold_for(0.2))), 0.2, rtol=1e-12)
    assert critical_distance(part_of()) is None


def test_fatigue_of_an_edge_is_the_stress_at_half_the_critical_distance(plate):
    """By hand from the plane reference; the step's worst plane is none but up to 15 % above it."""
    opening, loads, levels = plate
    use = FatigueUse(loads, LIMIT, ULTIMATE)
    assert bars_of(use, part_of(), levels, 0.05).numerical.value == np.inf
    part = part_of(threshold_for(LENGTH))
    check = edge_fatigue(loaded(part, loads), levels, use, made(use, LIMIT))
    first, second = reference(opening)
    hoop = first * (LENGTH / 2) ** (0.5445 - 1) / np.sqrt(2 * pi)
    shear = second * (LENGTH / 2) ** (0.9085 - 1) / np.sqrt(2 * pi)
    by_hand = np.sqrt(hoop**2 + 3 * shear**2)
    assert 0.96 * by_hand < check.value < (1.2 if opening == "step" else 1.05) * by_hand
    assert abs(check.value - by_hand) < check.numerical + check.model
    assert "sharp edge of 270 deg" in check.place
    assert "half of L = 0.2 mm" in check.note


def test_an_edge_that_endures_passes_and_leaves_the_rest_of_the_surface_to_decide(plate):
    """A tenth of the load: the edge takes 90 MPa and less of 1000."""
    _, loads, levels = plate
    use = FatigueUse(loads, 1000.0, ULTIMATE)
    part = part_of(threshold_for(LENGTH))
    check = edge_fatigue(loaded(part, loads), levels, use, made(use, 1e4))
    assert check.status is Status.PASS


@pytest.mark.parametrize(
    ("threshold", "why"), [(None, "threshold"), (threshold_for(60.0), "dominates")]
)
def test_an_edge_stays_open_without_a_threshold_or_beyond_its_singular_stress(
    plate, threshold, why
):
    _, loads, levels = plate
    use = FatigueUse(loads, LIMIT, ULTIMATE)
    said = edge_fatigue(loaded(part_of(threshold), loads), levels, use, made(use, LIMIT))
    assert isinstance(said, NotJudged)
    assert why in said.why


def test_a_brittle_part_is_not_judged_by_a_field_that_spares_its_edges(plate):
    _, loads, levels = plate
    peak = StaticPeak(loads)
    said = edge_static(loaded(part_of(ductile=False), loads), levels, peak, made(peak, YIELD))
    assert "brittle" in said.why


@pytest.mark.parametrize(("finer", "stops"), [(False, True), (True, False)])
def test_edges_that_no_mesh_can_judge_ask_for_no_finer_one(plate, finer, stops):
    _, loads, levels = plate
    use = FatigueUse(loads, LIMIT, ULTIMATE)
    part = loaded(part_of(None), loads)
    bars = bars_of(use, part.part, levels, part.accuracy)
    check = made(use, LIMIT)(levels[-1], bars)
    assert check.numerical == inf
    said = known_at_edges(part, levels, [use], [check], [NotJudged("why", finer)])
    assert bool(said) == stops


def test_the_field_that_spares_an_edge_is_in_balance_and_bounds_the_plastic_limit(plate):
    """By hand, of a ligament under n = N/(s b t) and m = 4 M/(s b^2 t): n^2 + m = 1 at collapse.

    The notch leaves 30 mm and an eccentricity of 5 mm: 133.3 and 88.9 MPa, s = 185 MPa. The step
    leaves 20 mm pulled straight: 100 MPa. The field must take more, and far less than the edge.
    """
    opening, loads, levels = plate
    least = 100.0 if opening == "step" else 185.3
    spared = Spared.of(levels[0])
    found = [spared_level(level, loads, spared) for level in levels]
    for level, one in zip(levels, found, strict=True):
        assert least < one.peak.value < 1.35 * least
        assert one.peak.value < 0.9 * level.peak.value
    assert_allclose(found[0].peak.value, found[1].peak.value, rtol=0.05)
    reactions = found[-1].softened.reactions(levels[-1].coefficients)
    assert np.abs(reactions).max() < 1e-6 * loads.largest_force


def test_arcs_tried_on_that_field_keep_what_is_pressed_in(plate):
    _, loads, levels = plate
    level = spared_level(replace(levels[0], lasting={}), loads, Spared.of(levels[0]))
    stress = direct_under(loads, level, 0, [pi])[:, :, 0]
    assert_allclose(stress, level.history.at(0), atol=1e-6 * level.peak.value)
    lasting = {"bore": np.full(level.coefficients.shape[1], 5.0)}
    pressed = spared_level(replace(levels[0], lasting=lasting), loads, Spared.of(levels[0]))
    assert pressed.lasting is lasting


def test_a_field_that_spares_edges_passes_a_part_and_never_fails_it(plate):
    """A limit just below its peak leaves the part open: another field may hold."""
    _, loads, levels = plate
    peak = StaticPeak(loads)
    check = edge_static(loaded(part_of(), loads), levels, peak, made(peak, YIELD))
    assert check.status is Status.PASS
    assert "sharp edges spared" in check.quantity
    tight = edge_static(loaded(part_of(), loads), levels, peak, made(peak, 0.99 * check.value))
    assert tight.status is Status.UNDECIDED
    assert tight.lower <= 0


def test_what_yields_away_from_the_edges_still_fails(plate):
    """A third of the stress that acts in the shank: it yields wherever the edge is."""
    _, loads, levels = plate
    peak = StaticPeak(loads)
    check = edge_static(loaded(part_of(), loads), levels, peak, made(peak, 30.0))
    assert check.status is Status.FAIL
