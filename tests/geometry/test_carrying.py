"""Meshes carried over to shapes of other dimensions."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import Delaunay

from geometry.carrying import Carrier, harmonic
from geometry.mesh import FoldedElementError, Mesh, MeshError
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink
from geometry.shape import Half

from .bars import PRESS_BAR


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return mesh_shape(Half(PRESS_BAR), fineness=0.5)


@pytest.fixture(scope="module")
def carrier(mesh: Mesh) -> Carrier:
    return Carrier(mesh, Half(PRESS_BAR))


def test_a_mesh_carried_over_to_its_own_shape_is_the_same(mesh: Mesh, carrier: Carrier):
    """Nodes are rounded to 1e-10 of the part's size, 1e-7 mm: twice here, once each way."""
    assert_allclose(carrier.to(Half(PRESS_BAR)).nodes, mesh.nodes, rtol=0, atol=2e-7)


def test_a_carried_mesh_stands_on_the_new_shape(mesh: Mesh, carrier: Carrier):
    """Nodes of bores at the new radius, walls at the new height: to the digits of the CAD kernel.

    Volume as that of any mesh here: facets of second order, 1e-3 of the body's at the most.
    """
    shape = replace(PRESS_BAR, hole=46.0, wall=6.6, width=84.0, cutout_length=59.0)
    found = carrier.to(Half(shape))
    for name, x in (("knee", 0.0), ("end", 250.0)):
        bore = found.nodes[np.unique(found.surfaces[name])]
        assert_allclose(np.hypot(bore[:, 0] - x, bore[:, 1]), 23.0, rtol=0, atol=1e-6)
    assert_allclose(found.nodes[:, 2].max(), 42.0, rtol=0, atol=1e-6)
    assert_allclose(found.volume, found.volume_cad, rtol=1e-3)
    assert found.jacobian_minimum > 0
    assert_allclose(found.elements, mesh.elements)
    assert found.interfaces["knee"].radius == 23.0


LINK = PlateLink(length=160.0, width=30.0, thickness=8.0, hole=12.0)


@pytest.fixture(scope="module")
def link() -> Carrier:
    return Carrier(mesh_shape(Half(LINK), fineness=0.3), Half(LINK))


@pytest.mark.parametrize(
    "change", [{"thickness": 0.3}, {"thickness": 3.0}, {"hole": 0.5}, {"hole": 1.5}]
)
def test_a_link_s_mesh_is_carried_over_to_dimensions_far_off(
    link: Carrier, change: dict[str, float]
):
    """The volume as near to the body's as of the mesh that was made: 1.0e-4, by its round ends."""
    found = link.to(Half(changed(LINK, change)))
    assert found.jacobian_minimum > 0
    assert_allclose(found.volume, found.volume_cad, rtol=2e-4)


def test_a_hole_that_leaves_its_link_little_takes_no_mesh(link: Carrier):
    """Of the 9 mm beside the hole 4.2 are left at 1.8 times its size."""
    with pytest.raises(FoldedElementError, match="an element folds"):
        link.to(Half(changed(LINK, {"hole": 1.8})))


@pytest.mark.parametrize(
    "change",
    [{"wall": 0.3}, {"wall": 2.0}, {"wall": 3.0, "hole": 0.7}, {"hole": 0.5}, {"hole": 1.2}],
)
def test_a_bar_s_dimensions_far_off_never_leave_a_folded_element(
    carrier: Carrier, change: dict[str, float]
):
    """Where an element folds there is no mesh; where there is one, none does."""
    try:
        found = carrier.to(Half(changed(PRESS_BAR, change)))
    except MeshError:
        return
    assert found.jacobian_minimum > 0


def changed(shape: Any, change: dict[str, float]) -> Any:
    """The shape with dimensions that are so many times its own."""
    return replace(shape, **{name: by * getattr(shape, name) for name, by in change.items()})


def test_a_body_with_other_faces_takes_no_mesh(carrier: Carrier):
    """A whole bar has no face at z = 0, where the half that was meshed ends."""
    with pytest.raises(MeshError, match="other faces and edges"):
        carrier.to(PRESS_BAR)


def test_a_linear_function_is_harmonic():
    """Linear elements hold it, so round-off is left: in space, and on a plane's triangles."""
    random = np.random.default_rng(1)
    for dimension in (2, 3):
        nodes = np.zeros((60, 3))
        nodes[:, :dimension] = random.random((60, dimension))
        cells = Delaunay(nodes[:, :dimension])
        linear = nodes @ np.array([[1.0, 0.5], [2.0, -1.0], [-3.0, 0.25]])
        free = ~np.isin(np.arange(60), cells.convex_hull)
        assert free.any()
        known = np.where(free[:, None], 0.0, linear)
        found = harmonic(nodes, known, cells.simplices.astype(np.int64), free)
        assert_allclose(found, linear, rtol=0, atol=1e-9)
