"""The plane kernel: what it computes exactly, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.recovery import von_mises
from geometry.mesh import FoldedElementError, MeshError

from .mesh import TRIANGLE_EDGES, PlaneMesh, directed
from .model import PlaneModel
from .recovery import largest_principal, von_mises_plane

STEEL = (210e3, 0.3)
FOAM = (210e3, 0.0)  # without Poisson's effect strips are exactly one-dimensional


def strip(columns, rows, size=(8.0, 3.0), *, start=(0.0, 0.0), distortion=0.0):
    """A rectangle of straight triangles, two per cell; edges left, right, bottom, top."""
    lattice = np.stack(
        np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij"), axis=-1
    )
    corners = lattice.reshape(-1, 2).astype(float)
    moves = np.random.default_rng(3).uniform(-distortion, distortion, corners.shape)
    inner = ((corners > 0) & (corners < [columns, rows])).all(axis=1)
    corners[inner] += moves[inner]
    cell = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    a, b, c, d = cell, cell + rows + 1, cell + rows + 2, cell + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    pairs = np.sort(triangles[:, TRIANGLE_EDGES].reshape(-1, 2), axis=1)
    unique, place = np.unique(pairs, axis=0, return_inverse=True)
    elements = np.hstack([triangles, len(corners) + place.reshape(-1, 3)])
    nodes = np.vstack([corners, corners[unique].mean(axis=1)])
    nodes = np.array(start) + nodes / [columns, rows] * size
    mesh = PlaneMesh(nodes, elements, {})
    middles = (nodes[mesh.boundary[:, 2]] - start) / size
    on = {
        "left": middles[:, 0] < 1e-9,
        "right": middles[:, 0] > 1 - 1e-9,
        "bottom": middles[:, 1] < 1e-9,
        "top": middles[:, 1] > 1 - 1e-9,
    }
    return replace(mesh, edges={name: mesh.boundary[where] for name, where in on.items()})


SYMMETRY = {"left": (0.0, None), "bottom": (None, 0.0)}


@pytest.mark.parametrize("aspect", [1, 1000])
def test_a_pulled_strip_is_uniform_whatever_its_elements_look_like(aspect):
    """70 MPa: stress and Poisson's contraction to round-off; no patch test has an aspect limit.

    The stiffness' condition, and the round-off with it, grows with the square of the aspect.
    """
    round_off = 1e-11 + 1e-14 * aspect**2
    size = (8.0 * aspect, 3.0)
    solution = PlaneModel(strip(3, 2, size, distortion=0.2), *STEEL, thickness=2.0).solve(
        dirichlet=SYMMETRY, tractions={"right": lambda _points, normals: 70 * normals}
    )
    assert_allclose(solution.stress - [70, 0, 0, 0], 0, atol=round_off * 70)
    far = solution.displacement[solution.model.mesh.nearest_node(*size)]
    assert_allclose(far, 70 / 210e3 * np.array([size[0], -0.3 * 3]), rtol=round_off)
    assert solution.scatter.max() < round_off * 70
    assert_allclose(solution.energy, 70**2 / 210e3 / 2 * np.prod(size) * 2, rtol=round_off)
    assert_allclose(solution.reactions[:, 0].sum(), -70 * 3 * 2, rtol=1e-8)
    assert solution.backward_error < 1e-12


def test_a_strip_that_cannot_thin_is_stiffer_and_carries_stress_out_of_plane():
    """Plane strain: sigma_zz = nu sigma, u = sigma L (1 - nu^2) / E; exact."""
    solution = PlaneModel(strip(2, 2), *STEEL, "strain").solve(
        dirichlet=SYMMETRY, tractions={"right": lambda _points, normals: 70 * normals}
    )
    assert_allclose(solution.stress - [70, 0, 21, 0], 0, atol=1e-9)
    moved = solution.displacement[solution.model.mesh.edge_nodes("right"), 0]
    assert_allclose(moved, 70 * 8 * (1 - 0.09) / 210e3, rtol=1e-10)


def test_a_rod_pulled_along_its_axis_is_uniform_up_to_the_axis():
    """Axisymmetric, radius 3, along y: F = sigma pi r^2, u_r = -nu sigma r / E; exact."""
    solution = PlaneModel(strip(2, 3, (3.0, 8.0)), *STEEL, "axisymmetric").solve(
        dirichlet={"bottom": (None, 0.0)},
        tractions={"top": lambda _points, normals: 70 * normals},
    )
    assert_allclose(solution.stress - [0, 70, 0, 0], 0, atol=1e-9)
    assert_allclose(solution.load.sum(axis=0), [0, 70 * np.pi * 9], atol=1e-9)
    radius = solution.model.mesh.nodes[:, 0]
    assert_allclose(solution.displacement[:, 0], -0.3 * 70 / 210e3 * radius, atol=1e-15)


def test_nodes_on_the_axis_of_a_ring_stay_on_it():
    """A pressure on the middle of a disc, held at its rim: nothing but the axis itself says so."""
    solution = PlaneModel(strip(4, 2), *STEEL, "axisymmetric").solve(
        dirichlet={"right": (0.0, 0.0)},
        tractions={"top": lambda points, normals: -normals * np.exp(-points[..., :1])},
    )
    on_axis = solution.model.mesh.edge_nodes("left")
    assert np.abs(solution.displacement[on_axis, 0]).max() == 0
    assert np.abs(solution.displacement[on_axis, 1]).max() > 1e-6


def test_a_shear_that_is_prescribed_all_around_is_found_inside():
    """Every linear displacement is exact; the angle xy times G."""
    mesh = strip(4, 4, distortion=0.25)
    mesh = replace(mesh, edges={"rim": mesh.boundary})
    solution = PlaneModel(mesh, *STEEL).solve(
        dirichlet={"rim": (lambda points: 1e-3 * points[:, 1], lambda points: 2e-3 * points[:, 0])}
    )
    exact = mesh.nodes[:, ::-1] * [1e-3, 2e-3]
    assert len(np.unique(mesh.boundary)) < len(mesh.nodes)
    assert_allclose(solution.displacement, exact, atol=1e-15)
    assert_allclose(solution.stress - [0, 0, 0, 3e-3 * 210e3 / 2.6], 0, atol=1e-9)


def test_a_hanging_strip_carries_the_weight_below():
    """Pulled by b = 2e-3 N/mm3 along x, held at x = 0: sigma = b (L - x), linear; round-off."""
    solution = PlaneModel(strip(3, 2, distortion=0.2), *FOAM, thickness=4.0).solve(
        dirichlet=SYMMETRY, body=lambda points: np.full_like(points, 2e-3) * [1, 0]
    )
    exact = 2e-3 * (8 - solution.model.mesh.nodes[:, 0])
    assert_allclose(solution.stress[:, 0], exact, atol=1e-9 * exact.max())
    assert_allclose(solution.load.sum(axis=0), [2e-3 * 8 * 3 * 4, 0], atol=1e-12)
    assert_allclose(solution.reactions.sum(axis=0), [-2e-3 * 8 * 3 * 4, 0], atol=1e-12)


def test_a_thickness_for_each_element_scales_its_stress():
    """1 mm thick to x = 4, then 2.5 mm: 100 N over 3 mm gives 33.3 and 13.3 MPa."""
    mesh = strip(4, 2)
    right = mesh.nodes[mesh.elements[:, :3], 0].mean(axis=1) > 4
    model = PlaneModel(mesh, *FOAM, thickness=np.where(right, 2.5, 1.0))
    solution = model.solve(
        dirichlet=SYMMETRY, tractions={"right": lambda _points, normals: 100 / 7.5 * normals}
    )
    assert_allclose(solution.load.sum(axis=0), [100, 0], atol=1e-10)
    stress = solution.element_stress[:, :, 0]
    assert_allclose(stress[right], 100 / 7.5, rtol=1e-9)
    assert_allclose(stress[~right], 100 / 3, rtol=1e-9)


def test_scatter_is_the_weighted_spread_of_the_elements_at_a_node():
    """The same strip: on its step 33.3 and 13.3 MPa meet, weighted with the elements' volumes."""
    mesh = strip(4, 2)
    right = mesh.nodes[mesh.elements[:, :3], 0].mean(axis=1) > 4
    solution = PlaneModel(mesh, *FOAM, thickness=np.where(right, 2.5, 1.0)).solve(
        dirichlet=SYMMETRY, tractions={"right": lambda _points, normals: 100 / 7.5 * normals}
    )
    node = mesh.nearest_node(4.0, 0.75)  # the middle of a side: one element left and one right
    mean = (100 / 3 * 1.0 + 100 / 7.5 * 2.5) / 3.5
    away = (1.0 * (100 / 3 - mean) ** 2 + 2.5 * (100 / 7.5 - mean) ** 2) / 3.5
    assert_allclose(solution.stress[node, 0], mean, rtol=1e-9)
    assert_allclose(solution.scatter[node], np.sqrt(away), rtol=1e-9)
    assert solution.scatter[mesh.nearest_node(0.0, 0.75)] < 1e-9


def test_a_linear_stress_is_recovered_exactly_on_straight_elements():
    """Pure bending sigma = 10 y: displacement quadratic; the elements hold it."""
    mesh = strip(4, 2, start=(0.0, -1.5), distortion=0.2)
    ends = {
        name: lambda points, normals: 10 * points[..., 1:] * normals for name in ("left", "right")
    }
    held = {mesh.nearest_node(0, 0): (0.0, 0.0), mesh.nearest_node(8, 0): (None, 0.0)}
    solution = PlaneModel(mesh, *STEEL).solve(dirichlet=held, tractions=ends)
    exact = 10 * mesh.nodes[:, 1]
    assert_allclose(solution.stress[:, 0], exact, atol=1e-8)
    assert_allclose(solution.stress[:, 1:], 0, atol=1e-8)
    assert np.abs(solution.reactions).max() < 1e-9 * 150


def test_loads_superpose_on_one_factorisation():
    model = PlaneModel(strip(4, 2), *STEEL)
    held = model.held({"left": (0.0, 0.0)})
    pulled = model.loads(tractions={"right": lambda _points, normals: normals})
    nodal = np.zeros_like(model.mesh.nodes)
    nodal[model.mesh.nearest_node(8, 3)] = [0.0, 5.0]
    bent = model.loads(nodal=nodal)
    both = held.solve(2 * pulled - 3 * bent)
    one, other = held.solve(pulled), held.solve(bent)
    assert_allclose(both.stress, 2 * one.stress - 3 * other.stress, atol=1e-11)
    assert_allclose(other.reactions.sum(axis=0), [0, -5], atol=1e-11)
    assert held.factor is held.factor
    together = model.recovery.nodal_stress(
        np.stack([one.displacement.ravel(), other.displacement.ravel()], axis=1)
    )
    assert_allclose(together[..., 0], one.stress, atol=1e-12)
    assert_allclose(together[..., 1], other.stress, atol=1e-12)


@pytest.mark.parametrize("factor", [1e-12, 1e12])
def test_answers_are_proportional_to_loads_of_any_size(factor):
    """1e-12: no absolute tolerance hides a small load."""
    model = PlaneModel(strip(4, 2), *STEEL)

    def stress(size):
        return model.solve(
            dirichlet={"left": (0.0, 0.0)},
            tractions={"right": lambda _points, normals: size * normals},
        ).stress

    assert_allclose(stress(factor) / factor, stress(1.0), rtol=0, atol=1e-11)


def test_metres_and_pascals_give_the_stress_of_millimetres_and_megapascals():
    """Stress in the ratio 1e6, displacement 1e-3; 1e-9."""
    mesh = strip(4, 2, distortion=0.2)
    metres = replace(mesh, nodes=mesh.nodes / 1e3)
    found = [
        PlaneModel(m, young, 0.3, thickness=thickness).solve(
            dirichlet={"left": (0.0, 0.0)},
            tractions={"top": lambda _points, normals, p=pressure: -p * normals},
        )
        for m, young, thickness, pressure in (
            (mesh, 210e3, 2.0, 5.0),
            (metres, 210e9, 2e-3, 5e6),
        )
    ]
    size = np.abs(found[0].stress).max()
    assert_allclose(found[1].stress / 1e6, found[0].stress, rtol=0, atol=1e-9 * size)
    assert_allclose(found[1].displacement * 1e3, found[0].displacement, rtol=0, atol=1e-12)


def test_principal_and_von_mises_stress_count_the_direction_out_of_the_plane():
    """(120, 40, z, 30): in the plane 130 and 30; z = 150 is then the largest."""
    stress = np.array([[120.0, 40, 0, 30], [120.0, 40, 150, 30], [0, 0, 50, 0]])
    assert_allclose(largest_principal(stress), [130, 150, 50])
    six = np.hstack([stress, np.zeros((3, 2))])
    assert_allclose(von_mises_plane(stress), von_mises(six))
    assert_allclose(von_mises_plane(stress)[2], 50)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"youngs_modulus": 0.0}, "Young's modulus must be above 0 MPa, got 0"),
        ({"poisson_ratio": 0.5}, r"Poisson's ratio must be in \(-1, 0.5\), got 0.5"),
        ({"kind": "shell"}, "kind must be one of stress, strain, axisymmetric, got 'shell'"),
        ({"thickness": 0.0}, "thickness must be above 0 mm, got 0"),
        ({"thickness": np.ones(3)}, "one for each of 4 elements"),
        ({"kind": "axisymmetric", "thickness": 2.0}, "whole ring and has no thickness"),
    ],
)
def test_impossible_models_are_refused(changed, says):
    mesh = strip(2, 1)
    with pytest.raises(ValueError, match=says):
        PlaneModel(mesh, **({"youngs_modulus": 1.0, "poisson_ratio": 0.3} | changed))


def test_a_ring_that_reaches_over_its_axis_is_refused():
    with pytest.raises(ValueError, match="reaches x = -1 mm"):
        PlaneModel(strip(2, 1, start=(-1.0, 0.0)), *STEEL, "axisymmetric")


@pytest.mark.parametrize(
    ("kind", "supports"),
    [
        ("stress", {}),
        ("stress", {"left": (0.0, None)}),
        ("stress", {0: (0.0, 0.0)}),
        ("strain", {0: (0.0, 0.0), "bottom": (0.0, None)}),  # all on one line along x
        ("axisymmetric", {"left": (0.0, None)}),
    ],
)
def test_supports_that_leave_a_rigid_motion_are_refused(kind, supports):
    with pytest.raises(ValueError, match="free to move without strain"):
        PlaneModel(strip(2, 1), *STEEL, kind).held(supports)


def test_a_second_piece_without_supports_is_refused():
    mesh = strip(2, 1)
    nodes = np.vstack([mesh.nodes, mesh.nodes + np.array([20.0, 0])])
    elements = np.vstack([mesh.elements, mesh.elements + len(mesh.nodes)])
    two = PlaneMesh(nodes, elements, mesh.edges)
    with pytest.raises(ValueError, match="on piece 2 of 2"):
        PlaneModel(two, *STEEL).held({"left": (0.0, 0.0)})


def test_supports_that_contradict_each_other_are_refused_and_equal_ones_are_not():
    model = PlaneModel(strip(2, 1), *STEEL)
    with pytest.raises(ValueError, match=r"'bottom': wants a node moved by 0.1 mm along x"):
        model.held({"left": (0.0, 0.0), "bottom": (0.1, None)})
    held = model.held({"left": (0.0, 0.0), "bottom": (0.0, None)})
    assert np.isnan(held.given).any()


@pytest.mark.parametrize(
    ("load", "says"),
    [
        ({"tractions": {"rigth": lambda p, n: n}}, "no edge is named 'rigth'; the mesh has left"),
        ({"tractions": {"right": lambda p, n: n[..., 0]}}, "edge 'right': .* values for points"),
        ({"tractions": {"right": lambda p, n: n * np.nan}}, "edge 'right': not every value is"),
        ({"body": lambda p: p[..., 0]}, "the body force: .* values for points"),
        ({"nodal": np.zeros((3, 2))}, "nodal forces: "),
    ],
)
def test_loads_that_do_not_fit_are_refused(load, says):
    with pytest.raises(ValueError, match=says):
        PlaneModel(strip(2, 1), *STEEL).loads(**load)


def test_a_support_at_a_node_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="no node 99: the mesh has 15"):
        PlaneModel(strip(2, 1), *STEEL).held({99: (0.0, 0.0)})


def test_a_folded_triangle_is_refused_even_if_its_corners_are_well():
    """A mid-side pulled across to the opposite corner turns det J over on the way."""
    mesh = strip(1, 1, (1.0, 1.0))
    middle = np.flatnonzero((mesh.nodes == [0.5, 0.5]).all(axis=1))
    nodes = mesh.nodes.copy()
    nodes[middle] += [0.0, 0.3]
    with pytest.raises(FoldedElementError, match="an element is folded"):
        replace(mesh, nodes=nodes)
    turned = mesh.elements[:, [0, 2, 1, 5, 4, 3]]
    with pytest.raises(FoldedElementError):
        PlaneMesh(mesh.nodes, turned, {})


def test_a_triangle_that_is_folded_only_between_its_nodes_is_refused():
    """Det J is 5.2, 0.24, 3.9, 0.02, 0.16 and 2.9 at the nodes, and -0.56 between two of them."""
    nodes = [[0, 0], [1, 0], [0, 1], [0.8, 0.35], [0.79, 0.23], [-0.34, 0.63]]
    with pytest.raises(FoldedElementError):
        PlaneMesh(np.array(nodes, dtype=float), np.arange(6)[None], {})


def test_det_j_is_bounded_between_the_nodes_too():
    """Sampled at 861 points, no det J is below the bound that the mesh states."""
    mesh = strip(1, 1, (1.0, 1.0))
    middle = np.flatnonzero((mesh.nodes == [0.5, 0.5]).all(axis=1))
    nodes = mesh.nodes.copy()
    nodes[middle] += [-0.08, 0.12]
    bent = replace(mesh, nodes=nodes)
    model = PlaneModel(bent, *STEEL)
    r, s = np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41))
    inside = r + s <= 1 + 1e-12
    r, s = np.r_[0, 1, 0, 0.5, 0.5, 0, r[inside]], np.r_[0, 0, 1, 0, 0.5, 0.5, s[inside]]
    t = 1 - r - s
    zero = 0 * r
    by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    places = bent.nodes[bent.elements]
    along = [np.einsum("ap,eax->epx", slope, places) for slope in (by_r, by_s)]
    det = along[0][..., 0] * along[1][..., 1] - along[0][..., 1] * along[1][..., 0]
    scaled = det / det[:, :6].mean(axis=1, keepdims=True)  # by the six nodes, as the mesh does
    assert 0 < bent.jacobian_minimum <= scaled.min() + 1e-12
    assert_allclose(model.elements.areas.sum(), 1.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda m: {"nodes": m.nodes[:, :1]}, "nodes must have shape"),
        (lambda m: {"elements": m.elements[:, :3]}, "elements must have shape"),
        (lambda m: {"nodes": np.vstack([m.nodes, [9, 9]])}, "1 nodes belong to no element"),
        (lambda m: {"edges": {"e": m.boundary[:, :2]}}, "edge 'e' must have shape"),
        (lambda m: {"edges": {"e": m.boundary[:, [1, 0, 2]]}}, "edge 'e': 6 of 6 pieces are no"),
    ],
)
def test_meshes_that_do_not_hold_together_are_refused(change, says):
    mesh = strip(2, 1)
    with pytest.raises(MeshError, match=says):
        replace(mesh, **change(mesh))


def test_edges_are_turned_to_have_the_domain_on_their_left():
    mesh = strip(2, 1)
    mixed = mesh.boundary.copy()
    mixed[::2] = mixed[::2][:, [1, 0, 2]]
    assert_allclose(directed(mesh.elements, mixed), mesh.boundary)
    x, y = np.moveaxis(mesh.nodes[mesh.boundary[:, :2]], -1, 0)
    assert_allclose((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum() / 2, 24.0)  # its area, positive
    normals = PlaneModel(mesh, *STEEL).elements.edge("top").normals
    assert_allclose(normals, np.broadcast_to([0.0, 1.0], normals.shape), atol=1e-12)
