"""FE-14: Saint-Venant torsion of sections against series and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from . import problems_exact
from .domains import Outline, Piece, mapped, meshed, ring
from .torsion import SectionTorsion

# FE-14, exact (series): b/t -> J/(b t^3), tau_max b t^2/T
RECTANGLES = {
    1: (0.140577015, 4.803875538),
    2: (0.2286816771, 4.067051989),
    10: (0.3123250375, 3.201791838),
}


def rectangle(breadth, cells):
    """Breadth x 1, `cells` through the thickness, at most 160 along the breadth."""
    columns = min(breadth * cells, 160)
    mesh = mapped(columns, cells, lambda s, t: (breadth * (s - 0.5), t - 0.5))
    return SectionTorsion(mesh)


@pytest.mark.parametrize(("breadth", "exact"), RECTANGLES.items())
def test_rectangles_have_the_torsion_constant_and_peak_shear_of_the_series(breadth, exact):
    """FE-14: both within 1e-4, on 64 cells through the thickness of a square, 32 of the others.

    J is a minimum of an energy, so it falls to the exact value from above, like h^4.
    """
    finest = 64 if breadth == 1 else 32
    constants, shears = [], []
    for cells in (finest // 4, finest // 2, finest):
        section = rectangle(breadth, cells)
        constants.append(section.torsion_constant / breadth / exact[0] - 1)
        shear = np.hypot(*section.shear[section.mesh.nearest_node(0, -0.5)])
        shears.append(abs(shear * breadth / exact[1] - 1))
    assert constants[0] > constants[1] > constants[2] > 0
    assert shears[0] > shears[1] > shears[2]
    assert constants[2] < 1e-4
    assert shears[2] < 1e-4


def test_a_rectangle_s_peak_shear_stands_in_the_middle_of_its_long_sides():
    section = rectangle(2, 16)
    worst = np.hypot(*section.shear.T).argmax()
    assert_allclose(np.abs(section.mesh.nodes[worst]), [0, 0.5], atol=1e-9)
    assert abs(section.shear[worst, 1]) < 1e-3 * abs(section.shear[worst, 0])


def test_a_tube_does_not_warp_and_is_sheared_like_its_radius():
    """J = pi (b^4 - a^4) / 2 and tau = T r / J, exact; the curved mesh leaves 1e-5.

    The second derivative of a stress linear in r is zero, so its recovery is as good as the mesh.
    """
    mesh = mapped(2, 64, ring(3.0, 5.0, 0.0, 360.0))
    # close the ring: the nodes of "top" (360 deg) become those of "bottom" (0 deg)
    _, first, place = np.unique(
        np.round(mesh.nodes, 9) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    closed = type(mesh)(mesh.nodes[first], place.reshape(-1)[mesh.elements], {})
    section = SectionTorsion(closed)
    exact = np.pi / 2 * (5.0**4 - 3.0**4)
    assert_allclose(section.torsion_constant, exact, rtol=1e-5)
    assert np.abs(section.warping).max() < 1e-4 * 25
    radius = np.linalg.norm(closed.nodes, axis=1)
    assert_allclose(np.hypot(*section.shear.T), radius / exact, rtol=2e-3)


def test_a_square_box_comes_to_that_of_bredt_as_its_wall_thins():
    """R. Bredt (1896): J = 4 A^2 t / s = 20^3 t, and s t^3 / 3 of the walls; exact for thin walls.

    Four corners add a share that is proportional to the wall: measured, 3.8 % at a tenth of the
    side and 1.1 % at a fortieth.
    """
    more = []
    for wall in (2.0, 1.0, 0.5):
        outer, inner = 10 + wall / 2, 10 - wall / 2
        loops = (
            ((-outer, -outer), (outer, -outer), (outer, outer), (-outer, outer)),
            ((-inner, -inner), (-inner, inner), (inner, inner), (inner, -inner)),
        )
        pieces = tuple(tuple(Piece(start, "rim") for start in loop) for loop in loops)
        section = SectionTorsion(meshed(Outline(pieces, wall / 3)))
        more.append(section.torsion_constant / (20**3 * wall + 80 / 3 * wall**3) - 1)
    assert_allclose(np.divide(more[:-1], more[1:]), 2, atol=0.25)
    assert 0 < more[2] < 0.0125


def test_an_ellipse_and_a_triangle_have_their_closed_torsion_constants():
    """Timoshenko and Goodier, articles 104, 106: pi a^3 b^3 / (a^2 + b^2), sqrt(3) s^4 / 80."""
    for make, exact in (
        (problems_exact.twisted_ellipse, np.pi * 8 / 5),
        (problems_exact.twisted_triangle, 3**0.5 / 80),
    ):
        errors = [abs(make(fineness).torsion_constant / exact - 1) for fineness in (1, 2, 4)]
        assert errors[0] > 4 * errors[1] > 16 * errors[2]
        assert errors[2] < 1e-4


def test_torsion_does_not_know_where_the_section_lies_or_how_it_is_turned():
    """Far away 1e-9; the warping is stated about the centroid."""
    section = problems_exact.twisted_triangle(1.0)
    mesh, turn = section.mesh, np.array([[0.8, -0.6], [0.6, 0.8]])
    moved = SectionTorsion(type(mesh)(mesh.nodes @ turn.T + [300, -200], mesh.elements, {}))
    assert_allclose(moved.torsion_constant, section.torsion_constant, rtol=1e-9)
    assert_allclose(moved.warping, section.warping, atol=1e-9 * np.ptp(section.warping) * 1e3)
    assert_allclose(moved.shear, section.shear @ turn.T, atol=1e-8 * np.abs(section.shear).max())


def test_a_section_in_two_pieces_is_refused():
    mesh = rectangle(1, 2).mesh
    nodes = np.vstack([mesh.nodes, mesh.nodes + np.array([5, 0])])
    two = type(mesh)(nodes, np.vstack([mesh.elements, mesh.elements + len(mesh.nodes)]), {})
    with pytest.raises(ValueError, match="one piece, and the mesh has 2"):
        _ = SectionTorsion(two).torsion_constant
