"""Boundary-value problems of one solid: given displacements, tractions, pressure, body force.

For users in Python and for validation. Held unknowns are chosen first and the stiffness matrix is
factorised once; then any number of loads is solved. Unknown 3 n + i is component i of node n.
Tractions are integrated with a rule of degree 8.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fem.assembly import Elements, FacetQuadrature, Pattern, full, stiffness
from fem.recovery import Recovery
from fem.solvers import Factor, factorize
from fem.unit_solutions import Elastic, rigid_modes
from geometry.mesh import FloatArray, IntArray, Mesh, MeshError

Traction = Callable[[FloatArray, FloatArray], FloatArray]
_DEGREE = 8


def unknowns(nodes: IntArray, axes: str = "xyz") -> IntArray:
    """Unknowns of some nodes along some axes.

    >>> unknowns(np.array([0, 4]), "xz")
    array([ 0,  2, 12, 14])
    """
    if not axes or set(axes) - set("xyz"):
        raise ValueError(f"axes must be some of x, y and z, got {axes!r}")
    return np.asarray((3 * np.asarray(nodes)[:, None] + ["xyz".index(a) for a in axes]).ravel())


def surface_normals(mesh: Mesh, name: str, degree: int = _DEGREE) -> FloatArray:
    """Unit outward normals at the quadrature points of a named surface, (n_facets, n_q, 3)."""
    import skfem

    named, outer = mesh.surfaces[name], mesh.facets
    corners = np.sort(np.concatenate([outer[:, :3], named[:, :3]]), axis=1)
    _, key = np.unique(corners, axis=0, return_inverse=True)
    row = np.full(len(corners), -1)
    row[key[: len(outer)]] = np.arange(len(outer))
    row = row[key[len(outer) :]]
    if (row < 0).any():
        raise MeshError(f"surface {name!r} has facets inside the part, which have no outside")
    order = np.argmax(named[:, :3, None] == outer[row][:, None, :3], axis=2)
    outward = (order[:, 1] - order[:, 0]) % 3 == 1  # the named facet turns as the boundary does
    (r, s), _ = skfem.quadrature.get_quadrature(skfem.refdom.RefTri, degree)
    t, zero = 1 - r - s, np.zeros_like(r)
    by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    tangents = (np.einsum("aq,fax->fqx", slope, mesh.nodes[named]) for slope in (by_r, by_s))
    normals = np.cross(*tangents)
    normals *= np.where(outward, 1.0, -1.0)[:, None, None]
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True))


def traction_load(elements: Elements, name: str, traction: Traction) -> FloatArray:
    """Nodal forces (3 n_nodes,) of a traction on a named surface, N.

    traction  of points and outward normals (..., 3) to MPa (..., 3)
    """
    surface = elements.surface(name, degree=_DEGREE)
    field = np.asarray(traction(surface.points, surface_normals(elements.mesh, name)))
    if field.shape != surface.points.shape:
        raise ValueError(f"a traction must have shape {surface.points.shape}, got {field.shape}")
    return _nodal(elements, surface, field)


def pressure_load(elements: Elements, name: str, pressure: float) -> FloatArray:
    """Nodal forces (3 n_nodes,) of a pressure on a named surface, N; above 0 pushes inwards."""
    return traction_load(elements, name, lambda _, normals: -pressure * normals)


def uniform_load(elements: Elements, name: str, force: Iterable[float]) -> FloatArray:
    """Nodal forces (3 n_nodes,) of a force (3,) spread evenly over a named surface, N."""
    area = float(elements.surface(name, degree=_DEGREE).weights.sum())
    even = np.array(list(force), dtype=float) / area
    return traction_load(elements, name, lambda points, _: np.broadcast_to(even, points.shape))


def body_load(elements: Elements, force: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Nodal forces (3 n_nodes,) of a force per volume, N, by the rule of the stiffness.

    force  of points (..., 3) to N/mm3 (..., 3)
    """
    mesh = elements.mesh
    field = np.asarray(force(elements.points))
    if field.shape != elements.points.shape:
        raise ValueError(f"a body force must have shape {elements.points.shape}, got {field.shape}")
    local = np.einsum("qa,eq,eqx->eax", elements.values, elements.weights, field, optimize=True)
    load = np.zeros_like(mesh.nodes)
    np.add.at(load, mesh.elements, local)
    return load.ravel()


def _nodal(elements: Elements, surface: FacetQuadrature, field: FloatArray) -> FloatArray:
    local = np.einsum("aq,fq,fqx->fax", surface.shape, surface.weights, field, optimize=True)
    load = np.zeros_like(elements.mesh.nodes)
    np.add.at(load, surface.nodes, local)
    return load.ravel()


@dataclass(frozen=True, eq=False)
class SolidProblem:
    """A solid with some unknowns given, ready for any number of loads.

    held  (k,) unknowns whose displacement is given
    """

    mesh: Mesh
    material: Elastic
    held: IntArray

    def __post_init__(self) -> None:
        size = 3 * len(self.mesh.nodes)
        held = np.asarray(self.held)
        if self.mesh.ties:
            raise ValueError("a boundary-value problem is of one body; this mesh has tied ones")
        if len(np.unique(held)) != len(held):
            raise ValueError("an unknown is held twice")
        if len(held) and not (held.min() >= 0 and held.max() < size):
            raise ValueError(f"held unknowns must be in 0 .. {size - 1}")
        modes = rigid_modes(self.mesh.nodes / np.ptp(self.mesh.nodes, axis=0).max())
        stopped = int(np.linalg.matrix_rank(modes[held], tol=1e-8)) if len(held) else 0
        if stopped < 6:
            raise ValueError(
                f"the part can move: its supports stop {stopped} of the six rigid motions"
            )

    @cached_property
    def elements(self) -> Elements:
        """The finite elements."""
        return Elements(self.mesh)

    @cached_property
    def stiffness(self) -> "scipy.sparse.csr_array":
        """The whole stiffness matrix, N/mm."""
        material = self.material
        upper = stiffness(Pattern(self.elements), material.youngs_modulus, material.poisson_ratio)
        return full(upper)

    @cached_property
    def recovery(self) -> Recovery:
        """The rule that turns displacements into stress at surface nodes."""
        return Recovery(self.elements, self.material.youngs_modulus, self.material.poisson_ratio)

    @cached_property
    def _free(self) -> IntArray:
        return np.setdiff1d(np.arange(3 * len(self.mesh.nodes)), self.held)

    @cached_property
    def _factor(self) -> Factor:
        return factorize(scipy.sparse.triu(self.stiffness[self._free][:, self._free], format="csr"))

    def solve(
        self, load: FloatArray | None = None, given: FloatArray | float = 0.0
    ) -> "SolidSolution":
        """Solve one load case.

        load   (3 n_nodes,) N; None: no load
        given  (k,) mm, displacement of the held unknowns, in their order

        Raises SolverError if the equations cannot be solved to a trustworthy residual.
        """
        size = 3 * len(self.mesh.nodes)
        load = np.zeros(size) if load is None else np.asarray(load)
        if load.shape != (size,):
            raise ValueError(f"a load must have shape ({size},), got {load.shape}")
        displacement = np.zeros(size)
        displacement[self.held] = given
        residual = 0.0
        if len(self._free):
            right = (load - self.stiffness @ displacement)[self._free]
            displacement[self._free], residual = self._factor.solve(right)
        return SolidSolution(self, load, displacement, residual)


@dataclass(frozen=True, eq=False)
class SolidSolution:
    """One solved load case.

    load          (3 n_nodes,) N
    displacement  (3 n_nodes,) mm
    residual      largest backward error of the solve
    """

    problem: SolidProblem
    load: FloatArray
    displacement: FloatArray
    residual: float

    @cached_property
    def _internal(self) -> FloatArray:
        return np.asarray(self.problem.stiffness @ self.displacement)

    @property
    def energy(self) -> float:
        """Strain energy, N mm."""
        return float(self.displacement @ self._internal / 2)

    @property
    def reactions(self) -> FloatArray:
        """Support reactions at the held unknowns, (k,) N."""
        return np.asarray((self._internal - self.load)[self.problem.held])

    @cached_property
    def stress(self) -> FloatArray:
        """Stress (n_points, 6) at the surface nodes `problem.recovery.points`, MPa."""
        return self.problem.recovery.surface_stress(self.displacement)[:, :, 0]

    @cached_property
    def scatter(self) -> FloatArray:
        """Von Mises size (n_points,) of the elements' scatter about that stress, MPa."""
        return self.problem.recovery.scatter(self.displacement)

    def node_at(self, place: Iterable[float]) -> int:
        """Index of the node at a place (3,); ValueError if none is there."""
        nodes, wanted = self.problem.mesh.nodes, np.array(list(place), dtype=float)
        away = np.linalg.norm(nodes - wanted, axis=1)
        nearest = int(np.argmin(away))
        if away[nearest] > 1e-6 * np.ptp(nodes, axis=0).max():
            raise ValueError(
                f"no node stands at {wanted.tolist()}; the nearest is {away[nearest]:.3g} mm away"
            )
        return nearest

    def displacement_at(self, place: Iterable[float]) -> FloatArray:
        """Displacement (3,) of the node at a place, mm."""
        return np.asarray(self.displacement.reshape(-1, 3)[self.node_at(place)])

    def stress_at(self, place: Iterable[float]) -> FloatArray:
        """Recovered stress (6,) at the surface node at a place, MPa."""
        return np.asarray(self.stress[self._point_at(place)])

    def scatter_at(self, place: Iterable[float]) -> float:
        """The elements' scatter at the surface node at a place, MPa."""
        return float(self.scatter[self._point_at(place)])

    def _point_at(self, place: Iterable[float]) -> int:
        node = self.node_at(place)
        points = self.problem.recovery.points
        row = int(np.searchsorted(points, node))
        if row == len(points) or points[row] != node:
            raise ValueError(
                f"node {node} lies inside the part: stress is recovered on its surface"
            )
        return row
