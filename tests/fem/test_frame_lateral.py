"""Frames that twist aside under bending, and plates that buckle at a free edge."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.models.shapes.prismatic_tube import pressed_edge_stress
from fem.frame import POINTS, Frame, buckling_modes
from fem.frame_joints import chain
from fem.unit_solutions import Elastic
from geometry.bars import rectangle
from tests.fem.buckled_frames import axial_stiffness as of_axial_force
from tests.fem.buckled_frames import geometric_stiffness

STEEL = Elastic(210e3, 0.3, 7.85e-9)
LENGTH, HEIGHT, WIDTH = 1000.0, 60.0, 5.0


def blade(pieces):
    nodes = np.zeros((pieces + 1, 3))
    nodes[:, 0] = np.linspace(0, LENGTH, pieces + 1)
    sections = rectangle(HEIGHT, WIDTH, shear_coefficient=np.inf)
    return Frame(nodes, chain(pieces + 1), np.array([0.0, 1.0, 0.0]), sections, STEEL)


def lowest(frame, forces, held):
    free = np.setdiff1d(np.arange(6 * len(frame.nodes)), held)
    inside = np.ix_(free, free)
    geometric = geometric_stiffness(frame, forces)
    return buckling_modes(frame.dense_stiffness()[inside], geometric[inside]).factors[0]


def test_axial_force_alone_gives_the_columns_geometric_stiffness():
    frame = blade(4)
    forces = np.zeros((4, 6, 6))
    forces[:, :, 0] = np.linspace(-2.0, 1.0, 24).reshape(4, 6)
    expected = of_axial_force(frame, forces[:, :, 0])
    size = np.abs(expected).max()
    assert_allclose(geometric_stiffness(frame, forces), expected, rtol=0, atol=1e-13 * size)


def stiffness():
    """sqrt(E I_y G J), N mm2."""
    section = rectangle(HEIGHT, WIDTH)
    shear = STEEL.youngs_modulus / (2 * (1 + STEEL.poisson_ratio))
    return np.sqrt(STEEL.youngs_modulus * section.inertia_y * shear * section.torsion)


def bent(pieces, *, by_force):
    """Lowest factor of a blade that is bent evenly, or by a force at the end of a cantilever."""
    frame, forces, last = blade(pieces), np.zeros((pieces, 6, 6)), 6 * pieces
    forces[:, :, 5] = 1.0
    if not by_force:
        return lowest(frame, forces, [0, 1, 2, 3, last + 1, last + 2, last + 3])
    forces[:, :, 1] = 1.0
    forces[:, :, 5] = LENGTH - (np.arange(pieces)[:, None] + POINTS) * LENGTH / pieces
    return lowest(frame, forces, np.arange(6))


def test_an_evenly_bent_blade_buckles_at_prandtls_moment():
    """pi/L sqrt(E I_y G J), ends held aside and against twist (Timoshenko and Gere, 6.2).

    Factors come from above and fall with h^2: measured 4.01 times from 8 to 16 pieces. What is left
    after extrapolation is of h^4: the coarser error's square, 6e-3^2.
    """
    coarse, fine = (bent(pieces, by_force=False) for pieces in (8, 16))
    expected = np.pi / LENGTH * stiffness()
    assert coarse > fine > expected
    assert_allclose((coarse - expected) / (fine - expected), 4, atol=0.05)
    assert_allclose(fine + (fine - coarse) / 3, expected, rtol=4e-5)


def test_a_blade_with_a_force_at_its_end_buckles_at_4_013():
    """4.013 sqrt(E I_y G J)/L^2, the force at the section's middle (Timoshenko and Gere, 6.3).

    Half a unit of its last digit is 1.25e-4 of it; extrapolated from 8 and 16 pieces.
    """
    coarse, fine = (bent(pieces, by_force=True) for pieces in (8, 16))
    found = fine + (fine - coarse) / 3
    assert_allclose(found * LENGTH**2 / stiffness(), 4.013, rtol=1.7e-4)


def angle_factors(pieces):
    """Lowest moments of either sign of a right angle of blades, 240 mm each, bent evenly."""
    leg, half = 240.0, np.sqrt(0.5)
    share = np.linspace(0, 1, pieces + 1)
    up = np.stack([leg * half * share, leg * half * share, 0 * share], axis=1)
    down = np.stack([leg * half * (1 + share), leg * half * (1 - share), 0 * share], axis=1)
    nodes = np.concatenate([up, down[1:]])
    members, last = chain(len(nodes)), 6 * (len(nodes) - 1)
    sections = rectangle(30.0, 0.6, shear_coefficient=np.inf)
    frame = Frame(nodes, members, np.array([0.0, 1.0, 0.0]), sections, Elastic(71240.0, 0.31, 1e-9))
    forces = np.zeros((len(members), 6, 6))
    forces[:, :, 5] = frame.axes[:, 2, 2, None]  # about z, whichever way the member's z points
    held = [0, 1, 2, 3, 4, *(last + k for k in (1, 2, 3, 4))]  # hinges about z that slide along x
    return [lowest(frame, sign * forces, held) for sign in (1.0, -1.0)]


def test_a_right_angle_of_blades_buckles_at_argyris_moment():
    """622.2 N mm of either sign; the ends are hinges about z that slide along x.

    Argyris et al., Comput. Methods Appl. Mech. Eng. 20 (1979) 105; Simo and Vu-Quoc, ditto 58
    (1986) 79. It is pi/L sqrt(E I G J) with J = b t^3/3; Saint-Venant's J is 1.26 % less, so the
    moment 0.63 %. Rounding of 622.2 and the mesh's fourth order are left.
    """
    coarse, fine = (np.array(angle_factors(pieces)) for pieces in (8, 16))
    thin = np.sqrt(1 - 0.63 * 0.6 / 30)
    assert_allclose(fine + (fine - coarse) / 3, 622.2 * thin, rtol=5e-4)


@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_a_pressed_free_edge_buckles_where_its_two_decaying_waves_meet_both_conditions(ratio):
    """The determinant of the edge's conditions changes its sign there and nowhere below."""

    def determinant(factor):
        roots = np.roots([1, 0, factor - 2, 0, 1])
        first, second = (root for root in roots if root.real < 0)
        rows = [
            [root**2 - ratio, root**3 + (factor - 2 + ratio) * root] for root in (first, second)
        ]
        return (np.linalg.det(np.array(rows)) / (first - second)).real

    steel = np.pi**2 * 210e3 / (12 * (1 - ratio**2)) * (2.0 / 50.0) ** 2
    factor = pressed_edge_stress(2.0, 50.0, 210e3, ratio) / steel
    signs = np.sign([determinant(k) for k in np.r_[0.05:factor:0.01, factor + 1e-3]])
    assert (signs[:-1] == signs[0]).all()
    assert signs[-1] == -signs[0]


def test_a_plate_without_thickness_is_refused():
    with pytest.raises(ValueError, match="sizes above 0 mm"):
        pressed_edge_stress(0.0, 10.0, 210e3, 0.3)
