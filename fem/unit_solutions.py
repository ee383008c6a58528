"""Everything about a part that does not depend on the size of its loads: solved once.

Unit loads of every interface and of four rigid-body accelerations, one factorisation, and the
stress basis at the surface nodes. The part is held at six displacements that just stop it from
moving as a rigid body; loads in equilibrium need no reaction there, which is checked for every
position of the cycle.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fem.assembly import Pattern, stiffness
from fem.elements import Elements
from fem.recovery import Recovery
from fem.solvers import Factor, factorize
from fem.unit_loads import (
    ACCELERATIONS,
    InterfaceLoads,
    acceleration_loads,
    bearing_coefficients,
    interface_loads,
    resultants,
)
from geometry.mesh import FloatArray, IntArray, Mesh


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elasticity.

    youngs_modulus  MPa
    poisson_ratio   1
    density         t/mm3
    """

    youngs_modulus: float
    poisson_ratio: float
    density: float

    def __post_init__(self) -> None:
        if not self.youngs_modulus > 0:
            raise ValueError(f"Young's modulus must be above 0 MPa, got {self.youngs_modulus}")
        if not -1 < self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio must be in (-1, 0.5), got {self.poisson_ratio}")
        if not self.density >= 0:
            raise ValueError(f"density must not be negative, got {self.density}")


@dataclass(frozen=True, eq=False)
class UnitSolutions:
    """Solved unit loads of one part.

    elements      the finite elements
    material      elastic constants
    interfaces    unit loads per interface, in the order of their columns
    loads         (3 n_nodes, n_basis)  N per unit
    displacement  (3 n_nodes, n_basis)  mm per unit
    held          (6,) unknowns held still
    factor        of the stiffness matrix without the held unknowns
    stiffness     upper triangle of the whole stiffness matrix
    residual      largest backward error of the solves
    """

    elements: Elements
    pattern: Pattern
    material: Elastic
    interfaces: tuple[InterfaceLoads, ...]
    loads: FloatArray
    displacement: FloatArray
    held: IntArray
    factor: Factor
    stiffness: sp.csr_array
    residual: float

    @property
    def mesh(self) -> Mesh:
        """The part's mesh."""
        return self.elements.mesh

    @cached_property
    def recovery(self) -> Recovery:
        """The rule that turns displacements into stress at surface nodes."""
        return Recovery(self.elements, self.material.youngs_modulus, self.material.poisson_ratio)

    @cached_property
    def basis(self) -> FloatArray:
        """Stress of the unit loads at the surface nodes, (n_points, 6, n_basis), MPa per unit."""
        return self.recovery.surface_stress(self.displacement)

    @property
    def raw_deviation(self) -> float:
        """Largest relative error of a unit load's resultant before it was normalised."""
        return max(loads.raw_deviation for loads in self.interfaces)

    @cached_property
    def unit_resultants(self) -> FloatArray:
        """Force and moment about the frame origin of every unit load, (6, n_basis)."""
        return resultants(self.elements, self.loads, np.zeros(3))

    def coefficients(
        self, wrenches: Mapping[str, FloatArray], accelerations: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Coefficients (n_basis, n) of the unit loads, and what inertia was added (n, 3).

        wrenches       interface -> (n, 6) N, N mm at the interface's centre, in the part's axes
        accelerations  (n, 4)  a_x, a_y (less gravity), alpha, omega^2 of the part's frame

        Loads that come with other mass properties than the mesh's leave a residual; it is balanced
        by a rigid-body acceleration field, returned as (a_x, a_y, alpha) for the report.
        """
        columns = []
        for loads in self.interfaces:
            wrench = np.asarray(wrenches[loads.interface.name])
            other = np.abs(wrench[:, 2:5]).max(initial=0.0)
            if other > 1e-9 * max(np.abs(wrench).max(initial=0.0), 1e-300):
                raise ValueError(
                    f"interface {loads.interface.name!r} carries forces along z or moments about x "
                    f"or y up to {other:.3g}; this model has no unit load for them"
                )
            planar = wrench[:, [0, 1, 5]]
            if loads.interface.kind != "face":
                planar = bearing_coefficients(planar, loads.interface.kind == "journal")
            columns.append(planar)
        columns.append(np.asarray(accelerations))
        coefficients = np.concatenate(columns, axis=1).T
        rows = [0, 1, 5]
        balance = self.unit_resultants[rows]
        first = coefficients.shape[0] - len(ACCELERATIONS)
        added = -np.linalg.solve(balance[:, first : first + 3], balance @ coefficients)
        coefficients[first : first + 3] += added
        return coefficients, np.asarray(added.T, dtype=np.float64)

    def reactions(self, coefficients: FloatArray) -> FloatArray:
        """Support reactions (6, n) at the held unknowns, N."""
        rows = self.stiffness[self.held] + self.stiffness.T.tocsr()[self.held]
        diagonal = self.stiffness.diagonal()[self.held]
        internal = rows @ self.displacement - diagonal[:, None] * self.displacement[self.held]
        return np.asarray((internal - self.loads[self.held]) @ coefficients)

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) of other nodal forces under the same hold."""
        return _solve_held(self.factor, self.held, loads)[0]


def solve_unit_loads(mesh: Mesh, material: Elastic) -> UnitSolutions:
    """Solve the unit loads of a part.

    Raises MeshError if an interface's loads cannot be brought onto the mesh, SolverError if the
    equations cannot be solved.
    """
    elements = Elements(mesh)
    pattern = Pattern(elements)
    upper = stiffness(pattern, material.youngs_modulus, material.poisson_ratio)
    interfaces = tuple(interface_loads(elements, i) for i in mesh.interfaces.values())
    inertia = acceleration_loads(elements, material.density)
    loads = np.concatenate([*(i.vectors for i in interfaces), inertia], axis=1)
    held = determinate_hold(mesh.nodes)
    free = np.setdiff1d(np.arange(3 * len(mesh.nodes)), held)
    factor = factorize(upper[free][:, free].tocsr())
    displacement, residual = _solve_held(factor, held, loads)
    return UnitSolutions(
        elements, pattern, material, interfaces, loads, displacement, held, factor, upper, residual
    )


def rigid_modes(nodes: FloatArray) -> FloatArray:
    """Six rigid-body displacement fields about the middle of the part, (3 n_nodes, 6)."""
    x, y, z = (nodes - nodes.mean(axis=0)).T
    modes = np.zeros((len(nodes), 3, 6))
    modes[:, [0, 1, 2], [0, 1, 2]] = 1
    modes[:, 1, 3], modes[:, 2, 3] = -z, y
    modes[:, 2, 4], modes[:, 0, 4] = -x, z
    modes[:, 0, 5], modes[:, 1, 5] = -y, x
    return modes.reshape(-1, 6)


def determinate_hold(nodes: FloatArray) -> IntArray:
    """Six unknowns that hold a part statically determinately, as far apart as pivoting finds."""
    modes = rigid_modes(nodes)
    modes[:, 3:] /= np.abs(nodes - nodes.mean(axis=0)).max()
    *_, order = scipy.linalg.qr(modes.T, mode="economic", pivoting=True)
    return np.sort(order[:6])


def _solve_held(factor: Factor, held: IntArray, loads: FloatArray) -> tuple[FloatArray, float]:
    free = np.setdiff1d(np.arange(len(loads)), held)
    displacement = np.zeros_like(loads)
    displacement[free], residual = factor.solve(loads[free])
    return displacement, residual
