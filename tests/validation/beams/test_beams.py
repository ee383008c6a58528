"""Frames against closed forms: leaves of uniform strength, shear, turning bars, free bars.

Units N, mm, s, t; the references were computed from the closed forms to ten digits.
"""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.frame import gauss_points
from fem.unit_solutions import Elastic
from geometry.bars import Sections, rectangle, rectangle_torsion
from tests.fem.solved_frames import Frame

SPRING = Elastic(206e3, 0.3, 7.85e-9)
STEEL = Elastic(210e3, 0.3, 7.85e-9)
UP = np.array([0.0, 1.0, 0.0])


def beam(length, count, section, material):
    """Straight along x, `section` (of x at Gauss points) along it."""
    nodes = np.zeros((count + 1, 3))
    nodes[:, 0] = np.linspace(0, length, count + 1)
    members = np.column_stack([np.arange(count), np.arange(1, count + 1)])
    return Frame(nodes, members, UP, section(gauss_points(nodes, members)[..., 0]), material)


def cantilever(frame, force):
    """Tip deflection and moments at the Gauss points; held at x = 0, pushed along y at the end."""
    last = len(frame.nodes) - 1
    held = frame.held(np.arange(6))
    solution = held.solve(frame.nodal(last, [0, force, 0, 0, 0, 0]))
    return solution.displacement[6 * last + 1, 0], solution


def gauss_moments(frame, solution):
    stations = (np.polynomial.legendre.leggauss(6)[0] + 1) / 2
    return solution.section_forces(stations)[..., 5, 0]


# BM-01: half spring L = 500, t = 8, 300 wide at the clamp; (tip width, deflection)
@pytest.mark.parametrize(("tip", "deflection"), [(0.0, 47.4059466), (60.0, 41.55011158)])
@pytest.mark.parametrize("count", [1, 4, 16])
def test_a_leaf_of_tapering_width_bends_as_the_integral_of_its_flexibility(tip, deflection, count):
    """BM-01, Euler-Bernoulli; stated tolerance 0.1 % with 16 elements.

    M^2 / E I is linear in x for the triangle, so one member is exact; for the trapezoid six Gauss
    points leave 4e-6 on one member, and with four only the table's ten digits are left.
    """

    def section(x):
        return rectangle(8.0, 300 + (tip - 300) * x / 500, shear_coefficient=np.inf)

    frame = beam(500.0, count, section, SPRING)
    found, solution = cantilever(frame, 2000.0)
    assert_allclose(found, deflection, rtol=1e-5 if tip == 60 and count == 1 else 3e-10)
    if not tip:
        x = frame.points[..., 0]
        stress = gauss_moments(frame, solution) / ((300 - 0.6 * x) * 8**2 / 6)
        assert_allclose(stress, 312.5, rtol=1e-8)
    else:
        assert_allclose(found / (2000 * 500**3 / (3 * 206e3 * 300 * 8**3 / 12)), 1.314712011,
                        rtol=1e-5 if count == 1 else 1e-9)  # fmt: skip


def test_a_triangular_leaf_of_even_steps_converges_at_second_order():
    """BM-01's note: each element as wide as at its middle; the error falls by 4 per halving."""
    errors = []
    for count in (8, 16, 32):

        def steps(x):
            middle = x.mean(axis=1, keepdims=True)
            return rectangle(8.0, 300 - 240 * middle / 500, shear_coefficient=np.inf)

        found, _ = cantilever(beam(500.0, count, steps, SPRING), 2000.0)
        errors.append(found - 41.55011158)
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.1)
    assert abs(errors[2]) < 1e-3 * 41.55  # 0.105 % with 16, 0.026 % with 32


def parabola(blunt):
    def section(x):
        rest = np.maximum(1 - x / 500, blunt)
        return rectangle(14 * np.sqrt(rest), 80.0, shear_coefficient=np.inf)

    return section


def test_a_blunt_parabolic_leaf_bends_by_its_factor():
    """BM-02, tip constant over the last 9 %; stated tolerance 0.2 % with 20 elements.

    100 elements put a node at the kink of the thickness: then every part is smooth and what is
    left is the table's last digit.
    """
    rough = []
    for count in (5, 20, 100):
        found, solution = cantilever(beam(500.0, count, parabola(0.09), SPRING), 3000.0)
        rough.append(abs(found / 65.44508407 - 1))
    assert rough[1] < 2e-3
    assert rough[1] < rough[0]
    assert rough[2] < 1e-9
    frame = solution.frame
    moments, x = gauss_moments(frame, solution), frame.points[..., 0]
    height = 14 * np.sqrt(1 - x / 500)
    stress = (moments / (80 * height**2 / 6))[x < 455]
    assert_allclose(stress, 573.9795918, rtol=1e-8)
    factor = found / (3000 * 500**3 / (3 * 206e3 * 80 * 14**3 / 12))
    assert_allclose(factor, 1.973, rtol=1e-9)


def test_a_full_parabola_bends_twice_as_far_as_an_even_leaf():
    """BM-02: M^2 / E I ~ sqrt of the distance from the tip: Gauss quadrature errs at the tip only,
    by (1 / count)^1.5.
    """
    errors = []
    for count in (1, 4, 16):
        found, _ = cantilever(beam(500.0, count, parabola(0.0), SPRING), 3000.0)
        errors.append(found / (3000 * 500**3 / (3 * 206e3 * 80 * 14**3 / 12)) - 2)
    assert abs(errors[-1]) < 1e-4
    assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])) / 2, 1.5, atol=0.05)


@pytest.mark.parametrize("count", [1, 7])
@pytest.mark.parametrize(
    ("height", "force", "deflection"), [(20.0, 1000.0, 0.2455238095), (0.1, 0.001, 1.90476339)]
)
def test_one_element_is_exact_deep_or_slender(height, force, deflection, count):
    """BM-03, shear coefficient 5/6: F L^3 / 3 E I + F L / k G A; 1e-9, and no locking."""
    frame = beam(100.0, count, lambda x: rectangle(height, 10.0), STEEL)
    found, _ = cantilever(frame, force)
    assert_allclose(found, deflection, rtol=1e-9)


@pytest.mark.parametrize("slenderness", [1, 10, 100, 1000])
def test_a_beam_of_any_slenderness_is_exact(slenderness):
    """1e-9 of theory with L / h from 1 to 1000; eight elements."""
    height = 100 / slenderness
    frame = beam(100.0, 8, lambda x: rectangle(height, 10.0), STEEL)
    found, _ = cantilever(frame, 1.0)
    bending = 100**3 / (3 * 210e3 * 10 * height**3 / 12)
    shear = 100 / (5 / 6 * 210e3 / 2.6 * 10 * height)
    assert_allclose(found, bending + shear, rtol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 8])
def test_a_bar_turning_about_its_end_is_stretched_by_its_own_inertia(count):
    """FE-18: L = 0.5 m, 300 rad/s: 88.3125 MPa at the root, 140.1785714 um. Exact: round-off."""
    bar = beam(500.0, count, lambda x: rectangle(20.0, 5.0), STEEL)
    spin = bar.planar_inertia().combined(np.array([[0.0], [0.0], [0.0], [300.0**2]]))
    solution = bar.held(np.arange(6)).solve(spin)
    root = solution.section_forces(np.zeros(1))[0, 0, 0, 0] / 100
    assert_allclose(root, 88.3125, rtol=1e-12)
    assert_allclose(solution.displacement[-6, 0], 0.1401785714, rtol=1e-9)


# FE-19: bar L = 1 m, A = 4e-4 m2, I = 1e-8 m4, free in space
def free_bar(count):
    even = Sections(*(np.array(v) for v in (400.0, 1e4, 1e4, 1.69e4, np.inf, np.inf)))
    return beam(1000.0, count, lambda x: even, STEEL)


HOLDS = [
    [0, 1, 2, 3, 4, 5],
    [-6, -5, -4, -3, -2, -1],
    [0, 1, 2, 3, -5, -4],  # a pin at the start, a slide at the end
    [12, 13, 14, 15, 1, 2],
]


@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("count", [2, 8])
def test_a_free_bar_pulled_at_one_end_is_half_stretched(count, hold):
    """FE-19 a: a = 318.4713376 m/s2, N = F s, elongation F L / 2 E A = 5.952380952 um."""
    bar = free_bar(count)
    solution, accelerations = relieved(bar, count, [1000.0, 0, 0, 0, 0, 0], hold)
    assert_allclose(accelerations[0, 0], 318.4713376e3, rtol=1e-9)
    stations = np.array([0.0, 0.25, 1.0])
    forces = solution.section_forces(stations)[..., 0, 0]
    s = (np.arange(count)[:, None] + stations) / count
    assert_allclose(forces, 1000 * s, rtol=0, atol=1e-7)
    stretch = solution.displacement[-6, 0] - solution.displacement[0, 0]
    assert_allclose(stretch, 5.952380952e-3, rtol=1e-9)


@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("count", [2, 8])
def test_a_free_bar_pushed_in_the_middle_bends_by_its_inertia(count, hold):
    """FE-19 b: M = F L / 8 = 125 N m; middle against ends F L^3 / 128 E I = 3.720238095 mm."""
    bar = free_bar(count)
    solution, _ = relieved(bar, count // 2, [0, 1000.0, 0, 0, 0, 0], hold)
    middle = solution.section_forces(np.zeros(1))[count // 2, 0, 5, 0]
    assert_allclose(middle, -125e3, rtol=1e-9)
    y = solution.displacement[1::6, 0]
    assert_allclose(y[count // 2] - (y[0] + y[-1]) / 2, 3.720238095, rtol=1e-9)


@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("count", [3, 12])
def test_a_free_bar_pushed_at_one_end_turns_and_bends(count, hold):
    """FE-19 c: M = F L s (1 - s)^2, 148.1481481 N m at L / 3; alpha = 1910.828025 rad/s2."""
    bar = free_bar(count)
    solution, accelerations = relieved(bar, 0, [0, 1000.0, 0, 0, 0, 0], hold)
    assert_allclose(accelerations[5, 0], -1910.828025, rtol=1e-9)
    stations = np.array([0.0, 0.4, 1.0])
    moments = solution.section_forces(stations)[..., 5, 0]
    s = (np.arange(count)[:, None] + stations) / count
    assert_allclose(moments, 1000e3 * s * (1 - s) ** 2, rtol=0, atol=1e-3)
    third = solution.section_forces(np.zeros(1))[count // 3, 0, 5, 0]
    assert_allclose(third, 148.1481481e3, rtol=1e-9)


def relieved(bar, node, wrench, hold):
    """Solve under the load and its inertia; the supports must feel less than 1e-8 of the load."""
    loads, accelerations = bar.relieved(bar.nodal(node, wrench))
    held = np.array(hold) % (6 * len(bar.nodes))
    solution = bar.held(held).solve(loads)
    turns = np.isin(np.sort(held) % 6, [3, 4, 5])
    scale = np.where(turns, 1000.0, 1.0)  # couples against F L
    assert (np.abs(solution.reactions[:, 0]) / scale).max() < 1e-8 * np.abs(wrench).max()
    return solution, accelerations


# FE-14: b / t, J / (b t^3), tau_max b t^2 / T; exact, Saint-Venant's series
@pytest.mark.parametrize(
    ("ratio", "constant", "peak"),
    [
        (1, 0.140577015, 4.803875538),
        (2, 0.2286816771, 4.067051989),
        (10, 0.3123250375, 3.201791838),
    ],
)
def test_the_torsion_of_rectangles_is_the_series_of_saint_venant(ratio, constant, peak):
    """FE-14; the table's ten digits. Stated tolerance of a section solver: 1e-4."""
    torsion, modulus = rectangle_torsion(7.0 * ratio, 7.0)
    assert_allclose(torsion / (ratio * 7**4), constant, rtol=1e-9)
    assert_allclose(ratio * 7**3 / modulus, peak, rtol=1e-9)


def test_a_stepped_bar_is_springs_in_series():
    """Two members of different area: F (L1 / E A1 + L2 / E A2)."""
    bar = beam(300.0, 3, lambda x: rectangle(np.where(x < 100, 10.0, 20.0), 5.0), STEEL)
    solution = bar.held(np.arange(6)).solve(bar.nodal(3, [1000.0, 0, 0, 0, 0, 0]))
    ends = [0, *solution.displacement[6::6, 0]]
    wanted = [1000 * 100 / (210e3 * area) for area in (50, 100, 100)]
    assert_allclose([b - a for a, b in pairwise(ends)], wanted, rtol=1e-10)
