"""Bars of what Findley judges, and points that FKM has to judge."""

from math import sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.materials import known_materials
from checks.design.strength import FkmStrength
from checks.strength import fatigue_assessment
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.fkm_strength import fkm_judgement, fkm_points
from checks.stress import judged
from checks.stress.duty_verdict import duty_runs, duty_verdict
from checks.stress.judged import direct_under
from fatigue import FkmMaterial
from fem.recovery import von_mises

S355 = known_materials()["S355"]  # 470 and 355 MPa
LIMIT = 150.0
STRENGTH = FkmStrength(FkmMaterial(410.0), 200.0)


def level_of(stress, notch=1.0):
    """A level of points with stress (n, 6, positions), MPa, of which the first is in a notch."""
    coefficients = np.eye(stress.shape[2])
    limits = np.full(len(stress), LIMIT)
    limits[0] /= notch
    runs = duty_runs({"a": slice(0, stress.shape[2])}, {"a": 1.0})
    duty = duty_verdict(stress, coefficients, limits, LIMIT, S355.ultimate_stress, runs)
    return SimpleNamespace(
        judged_duty=duty,
        fatigue=duty.peak,
        limits=limits,
        coefficients=coefficients,
        history=SimpleNamespace(basis=stress),
        scatter=lambda state, point, of_edges=True: (
            0.01 * float(von_mises((stress[point] @ state)[None])[0])
        ),
    )


def tension(*history):
    stress = np.zeros((1, 6, len(history)))
    stress[0, 0] = history
    return stress


def circle():
    """Bending of 100 MPa and torsion a quarter turn behind, equal von Mises: Findley decides."""
    turn = 2 * np.pi * np.arange(24) / 24
    stress = np.zeros((1, 6, 24))
    stress[0, 0], stress[0, 3] = 100 * np.cos(turn), 100 / sqrt(3) * np.sin(turn)
    return stress


# bars of what Findley judges ---------------------------------------------------------------------


@pytest.mark.parametrize("notch", [1.0, 1.6])
@pytest.mark.parametrize("stress", [tension(53.0, 147.0), circle()], ids=["Goodman", "Findley"])
def test_one_per_cent_of_all_stresses_is_one_per_cent_of_what_is_judged(monkeypatch, stress, notch):
    """Scatter of elements, and pressures as they are, whichever criterion decides."""
    level = level_of(stress, notch)
    use = FatigueUse(None, LIMIT, S355.ultimate_stress)
    value = use.value(level)
    assert use.scatter(level) == pytest.approx(0.01 * value, rel=1e-6)

    def raised(loads, level, position, arcs):
        return 1.01 * level.history.basis[:, :, position, None]

    monkeypatch.setattr(fatigue_assessment, "direct_under", raised)
    assert use.direct(level, [np.pi]) == pytest.approx([1.01 * value], rel=1e-6)


def test_positions_of_equal_loads_share_one_solve_of_every_arc(monkeypatch):
    """The closed cycle comes back to its first loads; a third position has others."""
    asked = []

    def solved(solutions, wrenches, coefficients, arcs, bores, lasting):
        asked.append((coefficients.tolist(), list(arcs)))
        return np.full((1, 6, len(arcs)), coefficients[0])

    monkeypatch.setattr(judged, "direct_displacement", solved)
    coefficients = np.array([[1.0, 2.0, 1.0]])
    level = SimpleNamespace(
        solutions=None,
        coefficients=coefficients,
        direct_stresses={},
        solved_bores=(),
        lasting={},
        contact=None,
        stress_of=lambda displacement: displacement,
    )
    loads = SimpleNamespace(wrenches={"pin": np.zeros((3, 6))})
    found = [direct_under(loads, level, k, [np.pi, 2.0])[0, 0, 0] for k in (0, 1, 2, 0)]
    assert found == [1.0, 2.0, 1.0, 1.0]
    assert asked == [([1.0], [np.pi, 2.0]), ([2.0], [np.pi, 2.0])]
    direct_under(loads, level, 2, [np.pi, 2.0, 1.5])
    assert asked[2:] == [([1.0], [1.5])]


def test_findley_judges_a_circle_higher_than_the_chord_it_rests_on():
    """Else the test above would not tell the two criteria apart."""
    level = level_of(circle())
    assert level.fatigue.value > 1.1 * 100.0
    assert level_of(tension(53.0, 147.0)).fatigue.criterion == "Goodman"


# points that FKM has to judge --------------------------------------------------------------------


def points_of(*rows):
    """Basis of tension that swings between -1 and 1 besides a static one, and gradients G."""
    basis, slope = np.zeros((2, len(rows), 6, 2))
    for row, (swing, static, gradient) in enumerate(rows):
        basis[row, 0] = swing, static
        slope[row, 0] = -gradient * swing, -gradient * static
    return basis, slope


SWING = np.array([[-1.0, 1.0], [1.0, 1.0]])


def used_by(amplitude):
    """a_BK of an even, reversed amplitude."""
    return float(STRENGTH.utilisation(amplitude, 0.0, STRENGTH.plain))


def test_only_points_that_may_exceed_the_worst_are_asked_for_their_gradient():
    """Above 88 MPa: 100 and 90 reversed, and 86 that M = 0.0435 raises to 89.7; 87 is not."""
    basis, slope = points_of((100, 0, 1), (90, 0, 0), (87, 0, 0), (86, 86, 0), (50, 0, 0))
    asked = []

    def slopes(rows):
        asked.extend(rows.tolist())
        return slope[rows]

    found = fkm_points(STRENGTH, basis, SWING, np.arange(5), slopes, used_by(88.0))
    assert found.points.tolist() == asked == [0, 1, 3]
    expected = [
        used_by(100 / (1 + 10 ** -(0.5 + 410 / 2700))),
        used_by(90),
        used_by(86 * 1.0435),
    ]
    assert_allclose(found.utilisation, expected, rtol=1e-3)


def test_a_mean_that_raises_the_smaller_swing_makes_it_the_worst_point():
    """98 MPa with as much mean is as 102.3; 70 points of 100 MPa stand before it."""
    basis, slope = points_of(*[(100, 0, 0)] * 70, (98, 98, 0))
    runs = {"a": np.arange(2)}
    found = fkm_judgement(STRENGTH, basis, SWING, runs, lambda rows: slope[rows])
    assert found.point == 70
    assert found.utilisation == pytest.approx(used_by(98 * 1.0435), rel=1e-3)


def test_a_point_after_all_that_are_judged_together_is_the_worst_without_support():
    """80 points of 100 MPa with n = 1.22 are as 82; then 95 MPa that are even, then 60."""
    basis, slope = points_of(*[(100, 0, 1)] * 80, (95, 0, 0), *[(60, 0, 0)] * 300)
    runs = {"a": np.arange(2), "weaker": np.array([0, 0, 1])}
    found = fkm_judgement(STRENGTH, basis, SWING * [[0.5, 1.0], [1, 1]], runs, slope.__getitem__)
    assert (found.point, found.run) == (80, "a")
    assert found.amplitude == pytest.approx(0.75 * 95)


def test_points_that_cannot_be_the_worst_are_never_judged():
    """The first 64 of 400 even points have 95 to 100 MPa, the others at most 94; the second path
    has half of the swing: nobody is asked again.
    """
    sizes = [*np.linspace(100, 95, 64), *np.linspace(94, 10, 336)]
    basis, slope = points_of(*[(size, 0, 0) for size in sizes])
    path = np.array([[-1.0, 1.0, -0.5, 0.5], [1.0] * 4])
    runs = {"a": np.arange(2), "b": np.arange(2, 4)}
    asked = []
    found = fkm_judgement(
        STRENGTH, basis, path, runs, lambda rows: asked.extend(rows) or slope[rows]
    )
    assert (found.point, found.run, len(asked)) == (0, "a", 64)
