"""Loads and supports of the solid solver: which way they act, what they sum to, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.assembly import Elements
from fem.unit_loads import resultants
from fem.unit_solutions import Elastic
from geometry.mesh import MeshError, Tie

from ..boundary_value import (
    SolidProblem,
    body_load,
    pressure_load,
    surface_normals,
    traction_load,
    uniform_load,
    unknowns,
)
from .blocks import block

STEEL = Elastic(210e3, 0.3, 7.85e-9)
SIZES = (12.0, 5.0, 4.0)


@pytest.fixture(scope="module")
def mesh():
    return block((3, 2, 2), SIZES, distortion=0.2)


def flipped(mesh, name):
    """The same mesh with one surface's facets named the other way round."""
    facets = mesh.surfaces[name][:, [0, 2, 1, 5, 4, 3]]
    return replace(mesh, surfaces={**mesh.surfaces, name: facets})


@pytest.mark.parametrize("name", ["start", "end"])
def test_normals_point_outwards_however_the_facets_turn(mesh, name):
    outward = [-1.0 if name == "start" else 1.0, 0, 0]
    for given in (mesh, flipped(mesh, name)):
        normals = surface_normals(given, name)
        assert_allclose(normals, np.broadcast_to(outward, normals.shape), atol=1e-14)


def test_a_pressure_pushes_inwards_with_its_area(mesh):
    elements = Elements(flipped(mesh, "end"))
    force = resultants(elements, pressure_load(elements, "end", 3.0)[:, None], np.zeros(3))[:, 0]
    assert_allclose(force, [-60, 0, 0, 0, -120, 150], atol=1e-11)


def test_an_even_force_has_its_resultant_at_the_middle_of_the_face(mesh):
    elements = Elements(mesh)
    load = uniform_load(elements, "end", (1.0, 2.0, -3.0))
    found = resultants(elements, load[:, None], np.array([12.0, 2.5, 2.0]))[:, 0]
    assert_allclose(found, [1, 2, -3, 0, 0, 0], atol=1e-12)


def test_a_traction_of_points_has_its_moment(mesh):
    """t_x = y - 2.5: no force, M_z = -I / 1 of the face, 4 * 5^3 / 12."""
    elements = Elements(mesh)
    load = traction_load(
        elements, "end", lambda points, _: (points[..., 1:2] - 2.5) * [1.0, 0.0, 0.0]
    )
    found = resultants(elements, load[:, None], np.array([12.0, 2.5, 2.0]))[:, 0]
    assert_allclose(found, [0, 0, 0, 0, 0, -4 * 125 / 12], atol=1e-11)


def test_a_body_force_sums_to_the_volume(mesh):
    elements = Elements(mesh)
    load = body_load(elements, lambda points: np.broadcast_to([1.0, 0, 2.0], points.shape))
    found = resultants(elements, load[:, None], np.array([6.0, 2.5, 2.0]))[:, 0]
    assert_allclose(found, [240, 0, 480, 0, 0, 0], atol=1e-10)


def test_a_pulled_bar_has_its_stress_stretch_reactions_and_energy(mesh):
    """Exact: F L / E A = 600 * 12 / 210e3 / 20, sigma = 30 MPa, energy F u / 2."""
    start = np.unique(mesh.surfaces["start"])
    corner = int(np.flatnonzero((mesh.nodes == 0).all(axis=1))[0])
    side = int(np.argmin(np.abs(mesh.nodes - [0, 5, 0]).sum(axis=1)))
    held = np.r_[unknowns(start, "x"), unknowns(np.array([corner]), "yz"), 3 * side + 2]
    problem = SolidProblem(mesh, STEEL, held)
    solution = problem.solve(uniform_load(problem.elements, "end", (600.0, 0, 0)))
    stretch = 600 * 12 / 210e3 / 20
    assert_allclose(solution.displacement_at((12, 0, 0))[0], stretch, rtol=1e-10)
    assert_allclose(solution.stress, np.tile([30.0, 0, 0, 0, 0, 0], (len(solution.stress), 1)),
                    atol=1e-9)  # fmt: skip
    assert solution.scatter_at((12, 5, 4)) < 1e-9
    assert_allclose(solution.reactions[: len(start)].sum(), -600, rtol=1e-10)
    assert_allclose(solution.energy, 300 * stretch, rtol=1e-10)


def test_given_displacements_stand_in_the_order_of_the_held_unknowns(mesh):
    start, end = (np.unique(mesh.surfaces[name]) for name in ("start", "end"))
    held = np.r_[unknowns(end, "x"), unknowns(start)]
    given = np.r_[np.full(len(end), 0.5), np.zeros(3 * len(start))]
    solution = SolidProblem(mesh, STEEL, held).solve(given=given)
    assert_allclose(solution.displacement_at((12, 5, 4))[0], 0.5, rtol=1e-15)
    assert_allclose(solution.displacement_at((0, 5, 4)), 0, atol=1e-300)


def test_a_part_that_can_move_is_refused(mesh):
    start = np.unique(mesh.surfaces["start"])
    with pytest.raises(ValueError, match=r"can move: its supports stop 3 of the six"):
        SolidProblem(mesh, STEEL, unknowns(start, "x"))
    with pytest.raises(ValueError, match="stop 0 of the six"):
        SolidProblem(mesh, STEEL, np.array([], dtype=int))


def test_supports_that_cannot_be_are_refused(mesh):
    start = np.unique(mesh.surfaces["start"])
    with pytest.raises(ValueError, match="held twice"):
        SolidProblem(mesh, STEEL, np.r_[unknowns(start), 3 * start[0]])
    with pytest.raises(ValueError, match="held unknowns must be in 0"):
        SolidProblem(mesh, STEEL, np.r_[unknowns(start), 10**6])
    with pytest.raises(ValueError, match="axes must be some of x, y and z"):
        unknowns(start, "xw")
    tied = replace(mesh, ties=(Tie(1, np.array([[0, 1]])),))
    with pytest.raises(ValueError, match="tied"):
        SolidProblem(tied, STEEL, unknowns(start))


def test_loads_of_a_wrong_shape_are_refused(mesh):
    problem = SolidProblem(mesh, STEEL, unknowns(np.unique(mesh.surfaces["start"])))
    with pytest.raises(ValueError, match="a load must have shape"):
        problem.solve(np.zeros(3))
    with pytest.raises(ValueError, match="a traction must have shape"):
        traction_load(problem.elements, "end", lambda points, _: points[..., 0])
    with pytest.raises(ValueError, match="a body force must have shape"):
        body_load(problem.elements, lambda points: points[..., 0])


def test_a_surface_inside_the_part_has_no_outside(mesh):
    elements = mesh.elements
    inner = elements[:1, [0, 1, 3, 4, 8, 7]]
    for local in ([0, 2, 1, 6, 5, 4], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]):
        inner = np.concatenate([inner, elements[:1, local]])
    odd = replace(mesh, surfaces={**mesh.surfaces, "odd": inner})
    with pytest.raises(MeshError, match="'odd' has facets inside the part"):
        surface_normals(odd, "odd")


def test_a_place_without_a_node_or_inside_is_refused(mesh):
    problem = SolidProblem(mesh, STEEL, unknowns(np.unique(mesh.surfaces["start"])))
    solution = problem.solve(uniform_load(problem.elements, "end", (1.0, 0, 0)))
    with pytest.raises(ValueError, match=r"no node stands at \[12.1"):
        solution.stress_at((12.1, 0, 0))
    inside = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.surface_nodes)[0]
    with pytest.raises(ValueError, match="lies inside the part"):
        solution.stress_at(mesh.nodes[inside])
