"""Solids of curved, twisted and slender shape against exact and converged references.

The cases state hexahedra; here each brick is six ten-node tetrahedra. Where their first mesh must
be finer than the stated one for the stated tolerance, the test says so.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.recovery import von_mises
from fem.unit_solutions import Elastic
from geometry.bars import rectangle_torsion

from ...boundary_value import SolidProblem, traction_load, uniform_load
from .meshes import falls, mapped, on, ring
from .problems import (
    held,
    pressed_ring,
    thick_plate,
    thick_plate_mesh,
    turning_bar,
    turning_disc,
    twist,
    twisted_bar,
    twisted_beam,
)


def polar(solution):
    """Hoop and radial stress and the radius at all surface nodes of a body about z."""
    points = solution.problem.recovery.points
    x, y, _ = solution.problem.mesh.nodes[points].T
    c, s = x / np.hypot(x, y), y / np.hypot(x, y)
    xx, yy, _, xy, _, _ = solution.stress.T
    hoop = xx * s * s + yy * c * c - 2 * xy * s * c
    return hoop, xx + yy - hoop, np.hypot(x, y)


# FE-04, Lame: a = 50, b = 100 mm, 100 MPa; exact
def test_the_thick_cylinder_has_the_stress_of_lame():
    """FE-04, quarter slice with uz = 0: 4 x 8 x 1 bricks: stress 1 %, displacement 0.05 %.

    The largest error of all nodes of each face, not only of a point that happens to be good.
    """
    errors = {"hoop a": [], "hoop b": [], "radial a": [], "u a": [], "u b": []}
    for counts in ((2, 4, 1), (4, 8, 1), (8, 16, 1)):
        solution = pressed_ring(ring(counts, 50.0, 100.0, 100.0 / counts[0]))
        hoop, radial, radius = polar(solution)
        inside, outside = radius < 50 + 1e-6, radius > 100 - 1e-6
        errors["hoop a"].append(np.abs(hoop[inside] / 166.6666667 - 1).max())
        errors["radial a"].append(np.abs(radial[inside] + 100).max() / 166.7)
        errors["hoop b"].append(np.abs(hoop[outside] / 66.66666667 - 1).max())
        moved = [solution.displacement_at((r, 0, 0))[0] for r in (50, 100)]
        errors["u a"].append(moved[0] / 0.0453968254 - 1)
        errors["u b"].append(moved[1] / 0.02888888889 - 1)
        if counts[0] == 4:
            at = solution.stress_at((50, 0, 0))
            assert_allclose(at[2], 20.0, rtol=0.01)
            assert_allclose(von_mises(at), 231.3246876, rtol=0.01)
    for name, values in errors.items():
        assert falls(values), name
        assert abs(values[1]) < (5e-4 if name.startswith("u") else 1e-2), name
    assert np.log2(errors["u a"][1] / errors["u a"][2]) > 2.5
    assert np.log2(errors["hoop a"][1] / errors["hoop a"][2]) > 1.7


def test_the_thick_plate_has_the_stress_of_le10():
    """FE-08, NAFEMS LE10: -5.38 MPa published, -5.385 +- 0.02 converged; 2 % with 8 x 8 x 4.

    The line support is ill posed, so 1 % is the best that may be asked. On the opposite face it
    is 4.48 +- 0.02, which comes more slowly (2.8 % here): its sign and size are tested.
    """
    errors = []
    for counts in ((4, 4, 2), (8, 8, 4), (12, 12, 6)):
        solution = thick_plate(thick_plate_mesh(counts))
        errors.append(solution.stress_at((2000, 0, 600))[1] / -5.385 - 1)
    assert falls(errors)
    assert abs(errors[1]) < 0.02
    assert abs(errors[2]) < 0.01
    assert_allclose(solution.stress_at((2000, 0, 0))[1], 4.48, rtol=0.04)


def test_the_twisted_beam_bends_as_converged_solids_do():
    """FE-12: (a) 0.0054247 +- 2e-7, (b) 0.0017534 +- 1e-7; published 0.005424 and 0.001754.

    0.5 % with 24 x 4 x 1 bricks. The case states 12 x 2 x 1 hexahedra; six tetrahedra in each of
    those are too stiff by 1.3 and 0.9 %, as warped bending is cubic and they are quadratic.
    """
    errors = [np.divide(twisted_beam(n), (0.0054247, 0.0017534)) - 1
              for n in ((12, 2, 1), (24, 4, 1), (48, 6, 2))]  # fmt: skip
    for load in (0, 1):
        assert falls([e[load] for e in errors])
    assert np.abs(errors[1]).max() < 0.005
    assert np.abs(errors[2]).max() < 0.0015


def straight_beam(counts):
    """FE-13: relative errors of extension, two deflections, twist; against the clamped solid."""
    mesh = mapped(counts, lambda x, y, z: (6 * x, 0.2 * (y - 0.5), 0.1 * (z - 0.5)), 0.12)
    problem = SolidProblem(mesh, Elastic(1e7, 0.3, 0.0), held(mesh, ("x0", "xyz")))
    errors = []
    for force, wanted in zip(np.eye(3), (2.9978e-5, 0.107937, 0.431128), strict=True):
        solution = problem.solve(uniform_load(problem.elements, "x1", force))
        errors.append(solution.displacement_at((6, 0, 0)) @ force / wanted - 1)
    solution = problem.solve(traction_load(problem.elements, "x1", twist(1, 0.2, 0.1)))
    up, down = (solution.displacement_at((6, y, 0))[2] for y in (0.1, -0.1))
    return [*errors, (up - down) / 0.2 / 0.03408 - 1]


@pytest.mark.slow
def test_the_straight_beam_stretches_bends_and_twists():
    """FE-13: 1 % of the clamped solid: 2.9978e-5, 0.107937, 0.431128, and a twist of 0.03408 rad.

    The published twist, 0.03208, is 6 % low. On the stated 48 x 2 x 1 three loads pass; torsion of
    the section, whose shear is far from linear, needs 6 x 3 bricks in it when they are tetrahedra.
    """
    errors = np.array([straight_beam(n) for n in ((24, 2, 1), (48, 2, 1), (60, 6, 3))])
    assert np.abs(errors[1, :3]).max() < 0.01
    assert np.abs(errors[2]).max() < 0.01
    for load in range(3):
        assert falls(errors[:, load])
    assert falls(errors[[0, 2], 3])


def inclined(kind):
    """The six 1.0 x 0.2 bricks of FE-13 with sides at 45 degrees, as a map of the unit cube.

    Sides of trapezoids lean in turn to either side, those of parallelograms all to one.
    """

    def mapping(x, y, z):
        # the lean at the sides x = k/6 is linear between them, and none at the ends
        sides = np.arange(7)
        lean = np.where((sides > 0) & (sides < 6), (-1.0) ** sides if kind == "trapezoid" else 1, 0)
        shift = np.interp(6 * x, sides, lean) * 0.2 * (y - 0.5)
        return 6 * x + shift, 0.2 * (y - 0.5), 0.1 * (z - 0.5)

    return mapping


@pytest.mark.parametrize("kind", ["trapezoid", "parallelogram"])
def test_inclined_elements_bend_nearly_as_straight_ones(kind):
    """FE-13's other two meshes: linear elements lose 90 % of the deflection in trapezoids.

    48 x 2 x 1 bricks whose sides lean at up to 45 degrees; in-plane shear, 1 %.
    """
    errors = []
    for counts in ((12, 2, 1), (24, 2, 1), (48, 2, 1)):
        mesh = mapped(counts, inclined(kind), 0.12)
        problem = SolidProblem(mesh, Elastic(1e7, 0.3, 0.0), held(mesh, ("x0", "xyz")))
        solution = problem.solve(uniform_load(problem.elements, "x1", (0, 1, 0)))
        errors.append(solution.displacement_at((6, 0, 0))[1] / 0.107937 - 1)
    assert falls(errors)
    assert abs(errors[2]) < 0.01


def bar_mesh(counts, width, height, length):
    def mapping(x, y, z):
        return length * (x - 0.5), width * (y - 0.5), height * (z - 0.5)

    return mapped(counts, mapping, width * height * length)


def torsion_errors(counts, ratio):
    """FE-14: relative errors of peak shear at mid-length and of the rate of twist there."""
    length = 10.0 * ratio
    solution = twisted_bar(bar_mesh(counts, ratio, 1.0, length), ratio, 1.0)
    constant, modulus = rectangle_torsion(ratio, 1.0)
    stress = solution.stress_at((0, 0, 0.5))
    angles = []
    for x in (-length / 4, length / 4):
        up, down = (solution.displacement_at((x, y, 0))[2] for y in (ratio / 2, -ratio / 2))
        angles.append((up - down) / ratio)
    rate = (angles[1] - angles[0]) / (length / 2)
    assert np.abs(solution.reactions).max() < 1e-9
    return np.hypot(stress[3], stress[5]) * modulus - 1, rate * 210e3 / 2.6 * constant - 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "meshes"),
    [
        (1.0, [(20, 2, 2), (20, 4, 4), (20, 6, 6)]),
        (2.0, [(20, 4, 2), (30, 6, 3), (40, 8, 4)]),
        (10.0, [(20, 4, 1), (20, 10, 2), (40, 20, 2)]),
    ],
)
def test_bars_in_torsion_have_the_shear_and_twist_of_saint_venant(ratio, meshes):
    """FE-14, solid: 1 % at mid-length of bars of ten widths, held determinately, free to warp."""
    errors = np.array([torsion_errors(counts, ratio) for counts in meshes])
    for k in (0, 1):
        assert falls(errors[:, k])
        assert abs(errors[2, k]) < 0.01


def test_the_turning_disc_has_the_stress_of_its_closed_form():
    """FE-17 with a hole, 2 mm half thickness: 262.484375 MPa at the bore, 71.140625 at the rim.

    0.5 %. The free faces of a disc this thin change it by 1e-5 (nu (1 + nu) h^2).
    """
    errors = []
    for counts in ((6, 4, 1), (12, 8, 1), (24, 16, 1)):
        hoop, _, radius = polar(turning_disc(ring(counts, 50.0, 200.0, 2.0)))
        inside, outside = radius < 50 + 1e-6, radius > 200 - 1e-6
        errors.append(
            [
                np.abs(hoop[inside] / 262.484375 - 1).max(),
                np.abs(hoop[outside] / 71.140625 - 1).max(),
            ]
        )
    errors = np.array(errors)
    assert falls(errors[:, 0])
    assert falls(errors[:, 1])
    assert errors[-1].max() < 0.005


def test_the_turning_bar_has_the_stress_of_its_inertia():
    """FE-18 as a solid of L = 500, nu = 0: 88.3125 MPa at the root, 140.1785714 um.

    0.5 % of stress, 0.1 % of displacement with 8 bricks along it. The stress is a parabola and
    linear in each brick: its end misses h^2 / 6 L^2 of the root stress, 2.6e-3 with 8 of them.
    """
    errors = []
    for count in (4, 8, 16):
        mesh = mapped((count, 1, 1), lambda x, y, z: (500 * x, 20 * y, 20 * z), 500 * 400)
        solution = turning_bar(mesh)
        root = np.isin(solution.problem.recovery.points, on(mesh, "x0"))
        stress = np.abs(solution.stress[root, 0] / 88.3125 - 1).max()
        errors.append([stress, solution.displacement_at((500, 0, 0))[0] / 0.1401785714 - 1])
    errors = np.array(errors)
    assert falls(errors[:, 0])
    assert abs(errors[1, 0]) < 0.005
    assert np.abs(errors[1:, 1]).max() < 0.001
