"""Plane stress, plane strain and axisymmetry on six-node triangles.

    model = PlaneModel(mesh, 210e3, 0.3, "stress", thickness=10.0)
    solution = model.solve(
        dirichlet={"left": (0.0, None), "bottom": (None, 0.0)},
        tractions={"right": lambda points, normals: 100.0 * normals},
    )
    solution.stress  # (n_nodes, 4): xx, yy, zz, xy

An axisymmetric model has the radius along x and the axis along y; forces are those of the whole
ring.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from fem.solvers import Factor, factorize
from geometry.mesh import FloatArray, IntArray

from .elements import EdgeQuadrature, PlaneElements
from .mesh import PlaneMesh
from .recovery import PlaneRecovery

Kind = Literal["stress", "strain", "axisymmetric"]
Traction = Callable[[FloatArray, FloatArray], FloatArray]  # points, outward normals -> MPa
Body = Callable[[FloatArray], FloatArray]  # points -> N/mm3
Given = float | Callable[[FloatArray], FloatArray] | None  # mm, mm of points, or free
Supports = Mapping[str | int, tuple[Given, Given]]


@dataclass(frozen=True, eq=False)
class PlaneModel:
    """A plane domain of one isotropic material.

    youngs_modulus  MPa
    poisson_ratio   1
    kind            "stress", "strain" or "axisymmetric"
    thickness       mm, one for all or (n_elements,); a whole ring has none
    """

    mesh: PlaneMesh
    youngs_modulus: float
    poisson_ratio: float
    kind: Kind = "stress"
    thickness: float | FloatArray | None = None

    def __post_init__(self) -> None:
        if not self.youngs_modulus > 0:
            raise ValueError(f"Young's modulus must be above 0 MPa, got {self.youngs_modulus}")
        if not -1 < self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio must be in (-1, 0.5), got {self.poisson_ratio}")
        if self.kind not in get_args(Kind):
            raise ValueError(f"kind must be one of {', '.join(get_args(Kind))}, got {self.kind!r}")
        if self.kind == "axisymmetric":
            if self.thickness is not None:
                raise ValueError("an axisymmetric model is a whole ring and has no thickness")
            if self.mesh.nodes[:, 0].min() < -1e-9 * np.ptp(self.mesh.nodes, axis=0).max():
                raise ValueError(
                    f"an axisymmetric model has its radius along x, from 0 up, and the mesh "
                    f"reaches x = {self.mesh.nodes[:, 0].min():.6g} mm"
                )
            return
        thickness = np.asarray(self.thickness if self.thickness is not None else 1.0, dtype=float)
        if thickness.shape not in ((), (len(self.mesh.elements),)):
            raise ValueError(
                f"thickness must be one number or one for each of {len(self.mesh.elements)} "
                f"elements, got {thickness.shape}"
            )
        if not thickness.min() > 0:
            raise ValueError(f"thickness must be above 0 mm, got {thickness.min()}")

    @cached_property
    def elements(self) -> PlaneElements:
        """The finite elements."""
        return PlaneElements(self.mesh)

    @cached_property
    def depths(self) -> FloatArray:
        """Extent out of the plane at the integration points, (n_elements, n_q), mm."""
        if self.kind == "axisymmetric":
            return np.asarray(2 * np.pi * self.elements.points[..., 0])
        return self._thicknesses[:, None] * np.ones((1, 3))

    @cached_property
    def _thicknesses(self) -> FloatArray:
        value = 1.0 if self.thickness is None else self.thickness
        return np.broadcast_to(np.asarray(value, dtype=float), (len(self.mesh.elements),))

    @cached_property
    def moduli(self) -> FloatArray:
        """Stress xx, yy, zz, xy of strain xx, yy, zz and the angle xy, (4, 4), MPa."""
        young, poisson = self.youngs_modulus, self.poisson_ratio
        moduli = np.zeros((4, 4))
        if self.kind == "stress":
            moduli[:2, :2] = young / (1 - poisson**2) * np.array([[1, poisson], [poisson, 1]])
        else:
            moduli[:3, :3] = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
            moduli[[0, 1, 2], [0, 1, 2]] += young / (1 + poisson)
        moduli[3, 3] = young / (2 * (1 + poisson))
        return moduli

    @cached_property
    def recovery(self) -> PlaneRecovery:
        """Stress of displacement."""
        gradients = self.elements.gradients  # (e, q, 6, 2)
        strains = np.zeros((*gradients.shape[:2], 4, 6, 2))
        strains[:, :, 0, :, 0] = strains[:, :, 3, :, 1] = gradients[..., 0]
        strains[:, :, 1, :, 1] = strains[:, :, 3, :, 0] = gradients[..., 1]
        if self.kind == "axisymmetric":  # the hoop strain is u_r / r
            radius = self.elements.points[..., 0, None]
            strains[:, :, 2, :, 0] = self.elements.values / radius
        flat = strains.reshape(*strains.shape[:3], 12)
        return PlaneRecovery(self.elements, self.elements.areas * self.depths, flat, self.moduli)

    @cached_property
    def stiffness(self) -> sp.csr_array:
        """Stiffness matrix, N/mm; unknown 2 n + i is component i of node n."""
        strains, count = self.recovery.strains, len(self.mesh.elements)
        stresses = (self.moduli @ strains) * self.recovery.volumes[:, :, None, None]
        flat = strains.reshape(count, -1, 12)
        blocks = np.matmul(np.swapaxes(flat, 1, 2), stresses.reshape(count, -1, 12))
        unknowns = (2 * self.mesh.elements[:, :, None] + np.arange(2)).reshape(count, 12)
        rows = np.broadcast_to(unknowns[:, :, None], blocks.shape)
        columns = np.broadcast_to(unknowns[:, None, :], blocks.shape)
        size = 2 * len(self.mesh.nodes)
        matrix = sp.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), (size, size))
        return matrix.tocsr()

    def loads(
        self,
        tractions: Mapping[str, Traction] | None = None,
        body: Body | None = None,
        nodal: FloatArray | None = None,
    ) -> FloatArray:
        """Load vector (2 n_nodes,), N.

        tractions  on named edges: f(points (..., 2), outward normals (..., 2)) -> (..., 2), MPa
        body       per volume: f(points (..., 2)) -> (..., 2), N/mm3
        nodal      (n_nodes, 2), N
        """
        load = np.zeros_like(self.mesh.nodes)
        for name, traction in (tractions or {}).items():
            edge = self.elements.edge(name)
            given = _checked(traction(edge.points, edge.normals), edge.points, f"edge {name!r}")
            weights = edge.weights * self._edge_depths(name, edge)
            np.add.at(load, edge.nodes, np.einsum("aq,kq,kqx->kax", edge.shape, weights, given))
        if body is not None:
            points = self.elements.points
            given = _checked(body(points), points, "the body force")
            share = np.einsum("qa,eq,eqx->eax", self.elements.values, self.recovery.volumes, given)
            np.add.at(load, self.mesh.elements, share)
        if nodal is not None:
            load += _checked(nodal, self.mesh.nodes, "nodal forces")
        return load.ravel()

    def _edge_depths(self, name: str, edge: EdgeQuadrature) -> FloatArray:
        """Extent out of the plane along an edge, (n_pieces, n_q), mm."""
        if self.kind == "axisymmetric":
            return np.asarray(2 * np.pi * edge.points[..., 0])
        owner = np.full(len(self.mesh.nodes), -1, dtype=np.int64)
        owner[self.mesh.elements[:, 3:]] = np.arange(len(self.mesh.elements))[:, None]
        return self._thicknesses[owner[edge.nodes[:, 2]]][:, None] * np.ones_like(edge.weights)

    def held(self, dirichlet: Supports) -> "HeldPlane":
        """The model on supports, factorised: many loads can then be solved at one price.

        dirichlet  edge name or node index -> displacement along x and along y: mm, or a function
                   of points (k, 2), or None where free

        Nodes on the axis of an axisymmetric model stay on it. Raises ValueError where two supports
        contradict each other or leave the model free to move as a rigid body.
        """
        given = np.full(self.mesh.nodes.shape, np.nan)
        if self.kind == "axisymmetric":
            span = np.ptp(self.mesh.nodes, axis=0).max()
            given[self.mesh.nodes[:, 0] <= 1e-9 * span, 0] = 0.0
        for place, components in dirichlet.items():
            nodes = self._nodes_of(place)
            points = self.mesh.nodes[nodes]
            for axis, wanted in enumerate(components):
                if wanted is None:
                    continue
                values = wanted(points) if callable(wanted) else np.full(len(nodes), float(wanted))
                before = np.where(np.isnan(given[nodes, axis]), values, given[nodes, axis])
                apart = np.abs(before - values)
                if apart.max() > 1e-9 * max(np.abs(values).max(), np.abs(before).max()):
                    raise ValueError(
                        f"support {place!r}: wants a node moved by {values[apart.argmax()]:.6g} mm "
                        f"along {'xy'[axis]}, and another support by {before[apart.argmax()]:.6g}"
                    )
                given[nodes, axis] = values
        self._check_held(~np.isnan(given))
        return HeldPlane(self, given.ravel())

    @cached_property
    def rigid_modes(self) -> FloatArray:
        """Motions without strain, (2 n_nodes, 3): along x, along y, turn; of a ring along y only.

        The turn is about the middle of the mesh, 1 rad.
        """
        x, y = (self.mesh.nodes - self.mesh.nodes.mean(axis=0)).T
        zero, one = np.zeros_like(x), np.ones_like(x)
        modes = [(zero, one)]
        if self.kind != "axisymmetric":
            modes += [(one, zero), (-y, x)]
        return np.stack([np.stack(mode, axis=1).ravel() for mode in modes], axis=1)

    def _check_held(self, held: npt.NDArray[np.bool_]) -> None:
        """Raise ValueError where some connected piece of the domain can move as a rigid body."""
        pairs = self.mesh.elements[:, [0, 0, 0, 0, 0]].ravel(), self.mesh.elements[:, 1:].ravel()
        graph = sp.coo_array((np.ones(len(pairs[0])), pairs), (len(held), len(held)))
        count, piece = sp.csgraph.connected_components(graph, directed=False)
        modes = self.rigid_modes / np.linalg.norm(self.rigid_modes, axis=0)
        for number in range(count):
            fixed = (held & (piece == number)[:, None]).ravel()
            values = np.linalg.svd(modes[fixed], compute_uv=False)
            if fixed.sum() < modes.shape[1] or not values[-1] > 1e-9 * values[0]:
                raise ValueError(
                    "the supports leave the domain free to move without strain: "
                    f"{fixed.sum()} displacements are given"
                    + (f" on piece {number + 1} of {count}" if count > 1 else "")
                )

    def _nodes_of(self, place: str | int) -> IntArray:
        if isinstance(place, str):
            return self.mesh.edge_nodes(place)
        if not 0 <= place < len(self.mesh.nodes):
            raise ValueError(f"no node {place}: the mesh has {len(self.mesh.nodes)}")
        return np.array([place])

    def solve(
        self,
        *,
        dirichlet: Supports,
        tractions: Mapping[str, Traction] | None = None,
        body: Body | None = None,
        nodal: FloatArray | None = None,
    ) -> "PlaneSolution":
        """Displacement and stress under one load; see `held` and `loads`."""
        return self.held(dirichlet).solve(self.loads(tractions, body, nodal))


@dataclass(frozen=True, eq=False)
class HeldPlane:
    """A plane model on supports.

    given  (2 n_nodes,) mm, prescribed displacement, NaN where free
    """

    model: PlaneModel
    given: FloatArray

    @cached_property
    def free(self) -> IntArray:
        """Indices of the free unknowns."""
        return np.flatnonzero(np.isnan(self.given))

    @cached_property
    def factor(self) -> Factor:
        """The factorised stiffness of the free unknowns."""
        free = self.model.stiffness[self.free][:, self.free]
        return factorize(sp.triu(free, format="csr"))

    def solve(self, load: FloatArray) -> "PlaneSolution":
        """Solution under a load (2 n_nodes,), N; its backward error is checked."""
        displacement = np.nan_to_num(self.given, nan=0.0)
        right = load - self.model.stiffness @ displacement
        error = 0.0
        if len(self.free):
            displacement[self.free], error = self.factor.solve(right[self.free])
        return PlaneSolution(self.model, displacement.reshape(-1, 2), load.reshape(-1, 2), error)


@dataclass(frozen=True, eq=False)
class PlaneSolution:
    """Displacement of a plane model under one load, and what follows from it.

    displacement    (n_nodes, 2), mm
    load            (n_nodes, 2), N
    backward_error  of the linear equations
    """

    model: PlaneModel
    displacement: FloatArray
    load: FloatArray
    backward_error: float

    @cached_property
    def stress(self) -> FloatArray:
        """Recovered stress xx, yy, zz, xy at the nodes, (n_nodes, 4), MPa."""
        return self.model.recovery.nodal_stress(self.displacement.ravel())[..., 0]

    @cached_property
    def element_stress(self) -> FloatArray:
        """Stress of each element at its own nodes, not averaged, (n_elements, 6, 4), MPa."""
        return self.model.recovery.element_stress(self.displacement.ravel())[..., 0]

    @cached_property
    def quadrature_stress(self) -> FloatArray:
        """Stress at the integration points, (n_elements, n_q, 4), MPa."""
        return self.model.recovery.quadrature_stress(self.displacement.ravel())[..., 0]

    @cached_property
    def scatter(self) -> FloatArray:
        """Von Mises size of the elements' scatter about the recovered stress, (n_nodes,), MPa."""
        return self.model.recovery.scatter(self.displacement.ravel())

    @cached_property
    def energy(self) -> float:
        """Strain energy, N mm."""
        u = self.displacement.ravel()
        return float(u @ (self.model.stiffness @ u) / 2)

    @cached_property
    def reactions(self) -> FloatArray:
        """Forces of the supports at the nodes, (n_nodes, 2), N; round-off where free."""
        inner = self.model.stiffness @ self.displacement.ravel()
        return np.asarray(inner.reshape(-1, 2) - self.load)


def _checked(values: FloatArray, points: FloatArray, what: str) -> FloatArray:
    given = np.asarray(values, dtype=float)
    if given.shape != points.shape:
        raise ValueError(f"{what}: {given.shape} values for points {points.shape}")
    if not np.isfinite(given).all():
        raise ValueError(f"{what}: not every value is finite")
    return given
