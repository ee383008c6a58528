"""A part's mesh as scikit-fem's own, for forms that ballesta does not have and for comparisons."""

from typing import Any

import numpy as np

from geometry.mesh import Mesh


def to_scikit_fem(mesh: Mesh) -> Any:
    """Return a skfem.MeshTet2 with the same elements in the same order and the same curved sides.

    scikit-fem numbers nodes in its own way: `doflocs` tells where each one is.
    """
    import skfem

    corners, elements = np.unique(mesh.elements[:, :4], return_inverse=True)
    elements = elements.reshape(-1, 4)
    straight = skfem.MeshTet1(
        np.ascontiguousarray(mesh.nodes[corners].T), np.ascontiguousarray(elements.T)
    )
    if not np.array_equal(straight.t, elements.T):  # the order of corners in an element is ours
        raise AssertionError("scikit-fem reordered the corners of the elements")
    quadratic = skfem.MeshTet2.from_mesh(straight)
    dofs = skfem.CellBasis(quadratic, skfem.ElementTetP2(), intorder=0).element_dofs
    locations = quadratic.doflocs.copy()
    locations[:, dofs] = np.moveaxis(mesh.nodes[mesh.elements], (0, 1, 2), (2, 1, 0))
    return skfem.MeshTet2(locations, quadratic.t)
