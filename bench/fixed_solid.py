"""Solids with fixed unknowns and parts afloat: closed forms and other programs know their modes."""

import numpy as np

from fem.assembly import Elements, Pattern, full, stiffness
from fem.lowest_modes import Vibration, mass, solid_vibration
from fem.mode_count import SupportedSolid, check_whole, supported
from fem.solvers import factorize, node_dissection
from fem.unit_solutions import Elastic, UnitSolutions, rigid_modes
from geometry.mesh import FloatArray, IntArray, Mesh


def fixed_solid(
    mesh: Mesh, material: Elastic, fixed: IntArray, rows: FloatArray | None = None
) -> SupportedSolid:
    """Return a solid with some unknowns fixed, and further conditions.

    fixed  (k,) unknowns 3 n + i of component i of node n; they stop all rigid motions
    rows   (c, 3 n_nodes) conditions rows @ u = 0, zero at the fixed unknowns

    Raises SolverError if the part can still move.
    """
    mesh.check_whole("a solid's mode")
    if mesh.ties:
        raise ValueError("modes are computed for one body; this mesh has tied ones")
    elements = Elements(mesh)
    pattern = Pattern(elements)
    upper = stiffness(pattern, material.youngs_modulus, material.poisson_ratio)
    free = np.setdiff1d(np.arange(upper.shape[0]), fixed)
    if not 0 < len(free) <= upper.shape[0] - 6:
        raise ValueError(f"{upper.shape[0] - len(free)} fixed unknowns; at least six are needed")
    rows = np.zeros((0, upper.shape[0])) if rows is None else np.array(rows, dtype=float)
    rows[:, fixed] = 0.0
    by_node = node_dissection(mesh.elements)
    factor = factorize(
        upper[free][:, free].tocsr(), place=None if by_node is None else by_node[free // 3]
    )
    return SupportedSolid(
        elements, pattern, material, upper, np.unique(fixed), rows, np.unique(fixed), factor
    )


def free_vibration(solutions: UnitSolutions, *, count: int = 4, prove: bool = True) -> Vibration:
    """Return the elastic vibration of a part afloat: without momentum, so without rigid motions.

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for a stack of
    tied bodies, half of a part and a part without mass.
    """
    check_whole(solutions, "vibration")
    upper = mass(solutions.pattern, solutions.material.density)
    momentum = full(upper) @ rigid_modes(solutions.mesh.nodes)
    rows = (momentum / np.linalg.norm(momentum, axis=0)).T.copy()
    return solid_vibration(supported(solutions, rows), count=count, prove=prove)
