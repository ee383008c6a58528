"""Buckling of solids against columns: end conditions, steps, tapers, holes, and plane stress.

References are those of BK-01, BK-03, BK-04 and BK-05 (docs/validation.md). A solid buckles below
Euler's load by shear, P = Pe / (1 + Pe / (k G A)) (Engesser), and by the axial term of the
geometric stiffness, about 1 - sigma / E; without Poisson's ratio k = 5/6 for a rectangle.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from bench.fixed_solid import fixed_solid
from fem.assembly import Elements
from fem.buckling import part_buckling, solid_buckling
from fem.unit_solutions import solve_unit_loads

from ...boundary_value import unknowns
from ...fem.blocks import block, wrench
from ..solids.meshes import Cad, on, plane_at
from .solids import bar, clamped, guided, pushed, solved, steel

YOUNG = 210e3
SIDE = (12 * 1e4) ** 0.25  # of the square with I = 1e4 mm4
ENDS = {  # of the side "x1": Euler's load of L = 1000 mm, N
    "free": ((), 5181.5423),
    "hinged": (("y", "z"), 42400.53),
    "clamped": (("y", "z", "yx", "zx"), 82904.677),
}


def reduced(euler, area):
    """Euler's load less shear and the axial term."""
    return euler * (1 - euler / (area * YOUNG)) / (1 + euler / (5 / 6 * YOUNG / 2 * area))


def clamped_column(end, bricks):
    """Loads at which a square column buckles whose first side is clamped, N, in both planes."""
    mesh = bar((bricks, 2, 2), 1000.0, SIDE, (-SIDE / 2, SIDE / 2))
    rows, _ = ENDS[end]
    solid = clamped(mesh, steel(0.0), guided(mesh, Elements(mesh), "x1", rows) if rows else None)
    found = solid_buckling(solid, pushed(solid))
    return np.array([mode.factor for mode in found.modes]) * SIDE**2


@pytest.mark.parametrize("end", list(ENDS))
def test_a_column_with_one_clamped_end_buckles_at_eulers_load_less_shear(end):
    """BK-01, 0.1 %. Shear and the axial term are 0.02 to 0.4 % of the load and are taken off."""
    euler = ENDS[end][1]
    coarse, fine = (clamped_column(end, bricks) for bricks in (24, 48))
    assert len(fine) == 2  # a square section buckles in both planes
    assert_allclose(fine, reduced(euler, SIDE**2), rtol=5e-4)
    error = [np.abs(load / reduced(euler, SIDE**2) - 1).max() for load in (coarse, fine)]
    assert error[1] < error[0] / 4


def pinned_column(slenderness, force, *, bricks=40, side=10.0):
    """A square column between two hinges, and the coefficients of a force on it."""
    length = slenderness * side / np.sqrt(12)
    solutions = solve_unit_loads(block((bricks, 2, 2), (length, side, side)), steel(0.0))
    ends = {"start": wrench(force), "end": wrench(-force)}
    return solutions, solutions.coefficients(ends, np.zeros((1, 4)))[0][:, 0]


def test_a_column_on_two_hinges_buckles_at_eulers_loads_in_pairs():
    """BK-01: the first and second of a square section, 0.1 %, at slenderness 186 as there."""
    slenderness = 1000 * np.sqrt(12) / SIDE
    found = part_buckling(*pinned_column(slenderness, 1.0), tilt_held=False, count=4)
    euler = np.pi**2 * YOUNG / slenderness**2 * np.array([1, 1, 4, 4])
    factors = [mode.factor / 100 for mode in found.modes]
    assert_allclose(factors, reduced(euler, 1.0), rtol=1e-3)
    assert factors[3] < found.proven / 100 < 1.03 * factors[3]
    length = np.pi * np.sqrt(YOUNG * 1e4 / 12 / found.modes[2].factor)
    assert_allclose(length, 1000 * 10 / SIDE / 2, rtol=2e-3)


@pytest.mark.parametrize("slenderness", [20, 100, 500])
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_columns_from_stocky_to_slender_buckle_at_their_load(slenderness, size):
    """1 % at slenderness 20, where Engesser and the axial term are 16 % and 2.4 % themselves."""
    euler = np.pi**2 * YOUNG / slenderness**2
    critical = 100 * reduced(euler, 1.0)
    found = part_buckling(*pinned_column(slenderness, size * critical, bricks=60), tilt_held=False)
    assert_allclose([mode.factor for mode in found.modes], 1 / size, rtol=0.01)


def test_a_column_of_slenderness_five_buckles_below_engessers_stress():
    """The axial term, 39 % by the first-order rule, is then no small one: between the two."""
    euler = np.pi**2 * YOUNG / 25
    found = part_buckling(*pinned_column(5, 100.0, bricks=6), tilt_held=False)
    engesser = euler / (1 + euler / (5 / 6 * YOUNG / 2))
    assert reduced(euler, 1.0) < found.modes[0].factor < engesser


@pytest.mark.parametrize(("height", "stress"), [(5, 107.727), (10, 428.265), (20, 1672.09)])
def test_a_plane_stress_column_buckles_below_beam_theory(height, stress):
    """BK-03, 0.2 % on 20 x 4; a slice of 0.25 mm whose middle plane stays plane."""
    errors = []
    for counts in ((10, 2, 1), (20, 4, 1)):
        mesh = bar(counts, 100.0, height, 0.25)
        side = on(mesh, "x0")
        middle = side[np.abs(mesh.nodes[side, 1]) < 1e-9]
        held = [unknowns(side, "x"), unknowns(middle, "y"), unknowns(on(mesh, "z0"), "z")]
        solid = fixed_solid(mesh, steel(), np.unique(np.concatenate(held)))
        errors.append(solid_buckling(solid, pushed(solid)).modes[0].factor / stress - 1)
    assert abs(errors[1]) < 2e-4
    assert abs(errors[1]) < abs(errors[0]) / 4


TAPERS = {
    2: (1.5911987, lambda x: (np.ones_like(x), (1 - x + x * np.sqrt(0.2)) ** 2)),
    3: (1.533987, lambda x: (1 - x + x * 0.2 ** (1 / 3), np.ones_like(x))),
    4: (1.5050848, lambda x: (1 - x + x * 0.2**0.25,) * 2),
}


@pytest.mark.parametrize("power", list(TAPERS))
def test_a_tapered_cantilever_buckles_at_dinniks_load(power):
    """BK-05: I = I2 (x / x2)^n, I1 / I2 = 0.2, P = m E I2 / L^2; 0.5 %. Slenderness 60 L / h."""
    reference, shape = TAPERS[power]
    width = (-5.0, 5.0) if power == 4 else 4.0
    inertia = (10.0 if power == 4 else 4.0) * 10.0**3 / 12
    errors = []
    for bricks in (4, 8, 16):
        mesh = bar((bricks, 1, 1), 600.0, 10.0, width, shape=shape)
        held = unknowns(on(mesh, "x0"))
        if power < 4:  # a slender section the other way
            held = np.union1d(held, unknowns(on(mesh, "z0"), "z"))
        stress = solved(mesh, steel(0.0), held, -1.0)
        found = solid_buckling(fixed_solid(mesh, steel(0.0), held), stress)
        errors.append(found.modes[0].factor * 600**2 / (YOUNG * inertia) / reference - 1)
    assert abs(errors[2]) < 1.5e-3
    assert abs(errors[2]) < abs(errors[1]) / 3 < abs(errors[0]) / 6


def cantilever(make, fineness):
    """Load at which a bar of gmsh's buckles along y, 600 mm long, clamped at x = 0, N."""
    faces = {"x0": plane_at(0, 0.0), "x1": plane_at(0, 600.0), "z0": plane_at(2, 0.0)}
    mesh = Cad(make, faces, 8.0).mesh(fineness)
    held = np.union1d(unknowns(on(mesh, "x0")), unknowns(on(mesh, "z0"), "z"))
    stress = solved(mesh, steel(0.0), held, -1.0)
    return solid_buckling(fixed_solid(mesh, steel(0.0), held), stress, count=1).modes[0].factor


@pytest.mark.parametrize(("tip_share", "root"), [(0.5, 2.0672329), (0.4, 7.6059763 / 4)])
def test_a_stepped_cantilever_buckles_at_the_root_of_its_matching_equation(tip_share, root):
    """BK-04 a: the tip half is half as thick, so EI is half; P L^2 / EI1. And b, of which one half
    is a cantilever whose tip half has 0.4 EI1.

    The thickness (4 and 2 mm, half of it across a plane of symmetry) carries its share only some
    thicknesses away from the step: in a the load is 0.24 and 0.12 % lower; nothing else is left.
    """

    def stepped(thick):
        def make(occ):
            base = occ.addBox(0, -5, 0, 300, 10, thick)
            tip = occ.addBox(300, -5, 0, 300, 10, tip_share * thick)
            occ.fuse([(3, base)], [(3, tip)])

        return make

    load = root * YOUNG * 1000 / 12 / 600**2
    thick, thin = (cantilever(stepped(t), 1.5) / (t * load) - 1 for t in (4.0, 2.0))
    assert -4e-3 < thick < thin < 0
    assert_allclose(2 * thin - thick, 0.0, atol=5e-4)  # of a step without thickness


def holed_beam(diameter):
    """Load of the beam whose section lacks the hole's chord at every place, N."""

    def inertia(x):
        half = np.sqrt(max((diameter / 2) ** 2 - (x - 150) ** 2, 0.0))
        return 4.0 * (20**3 - (2 * half) ** 3) / 12

    def tip_slope(load):
        def slope(x, y):
            return [y[1], -load * y[0] / (YOUNG * inertia(x))]

        found = solve_ivp(slope, (0, 600), [0.0, 1.0], max_step=2.0, rtol=1e-8)  # y = M / load
        return found.y[1, -1]

    euler = np.pi**2 * YOUNG * 4.0 * 20**3 / 12 / 600**2 / 4
    return brentq(tip_slope, 0.5 * euler, 1.05 * euler, rtol=1e-6)


@pytest.mark.slow
def test_a_hole_lowers_the_buckling_load_as_its_chord_lowers_the_section():
    """Widths 20, hole 150 mm from the tip end; monotonic, and within 1 % of the beam."""

    def holed(diameter):
        def make(occ):
            bar_ = occ.addBox(0, -10, 0, 600, 20, 4)
            if diameter:
                hole = occ.addCylinder(450, 0, 0, 0, 0, 4, diameter / 2)
                occ.cut([(3, bar_)], [(3, hole)])

        return make

    loads = [cantilever(holed(diameter), 1.0) for diameter in (0, 8, 14, 17)]
    assert (np.diff(loads) < 0).all()
    assert_allclose(loads, [holed_beam(diameter) for diameter in (0, 8, 14, 17)], rtol=0.01)
