"""The mesh of one part: nodes, second-order tetrahedra, named surfaces; and its mass properties."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

# Corner pairs of the mid-side nodes 4..9 of a ten-node tetrahedron, in VTK's order.
TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
_FARTHEST = 1e7  # sizes: stress keeps six digits there (docs/extremes.md)
SYMMETRY = "symmetry"  # the surface at which a half ends, z = 0


class MeshError(ValueError):
    """A mesh that cannot carry a trustworthy solution."""


class TooManyElementsError(MeshError):
    """A part whose element sizes would need a mesh that no solver here can hold."""


class TooManyUnknownsError(TooManyElementsError):
    """A mesh of more unknowns than are allowed, by an estimate before it is made.

    unknowns  about how many it would have
    """

    def __init__(self, unknowns: float) -> None:
        super().__init__(unknowns)
        self.unknowns = unknowns

    def __str__(self) -> str:
        return f"would have about {self.unknowns:.2g} unknowns"


class TooFineError(TooManyElementsError):
    """A part whose smallest and largest size lie so far apart that no mesh can have both."""


class FoldedElementError(MeshError):
    """A curved element that turns inside out somewhere."""


class UnsafeMesherError(MeshError):
    """A mesher that would write outside of its memory, or leave too many elements flat."""


@dataclass(frozen=True, eq=False)
class Interface:
    """Where another part presses on this one.

    kind      "bore" (a pin inside a hole), "journal" (a lug around a pin), "face" (a cut end),
              "clamp" (faces normal to y that are squeezed and carried) or "slide" (a contact that
              moves along x, on one of two faces normal to y)
    centre    (3,) mm, the point at which the interface's wrench is stated
    radius    mm, of a bore or journal; 0 for the others
    length    mm, total loaded length along z (sum of both cheeks); 0 for a face
    travel    mm, lowest and highest x of a slide's contact, from the centre
    patch     mm, half the length along x on which a slide's contact presses
    tilts     True if a bore or journal also carries couples about x and y
    piece     mm, its length in the thinner of two cheeks; inf where it is in one piece
    """

    name: str
    kind: str
    centre: FloatArray
    radius: float = 0.0
    length: float = 0.0
    travel: tuple[float, float] = (0.0, 0.0)
    patch: float = 0.0
    tilts: bool = False
    piece: float = inf

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Surfaces of the mesh that belong to it.

        Of a slide the one that a force along +y presses on, then the one of a force along -y.
        """
        return (f"{self.name}+", f"{self.name}-") if self.kind == "slide" else (self.name,)

    def in_mm(self, unit: float) -> "Interface":
        """Return it in mm, where its lengths are in a unit of so many mm."""
        if unit == 1.0:
            return self
        low, high = self.travel
        return replace(
            self,
            centre=unit * self.centre,
            radius=unit * self.radius,
            length=unit * self.length,
            travel=(unit * low, unit * high),
            patch=unit * self.patch,
            piece=unit * self.piece,
        )


@dataclass(frozen=True, eq=False)
class Tie:
    """Nodes of bodies that touch: equal displacement along one axis, free along the others.

    axis   0, 1, 2: x, y, z
    pairs  (n, 2) node indices, at the same place
    """

    axis: int
    pairs: IntArray


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass properties about axes through the centre of mass, parallel to the part's axes.

    mass     t
    centre   (3,) mm, in the part's axes
    inertia  t mm2, about z through the centre of mass
    """

    mass: float
    centre: FloatArray
    inertia: float


@dataclass(frozen=True, eq=False)
class Mesh:
    """Ten-node tetrahedra of one part, in the part's own axes.

    nodes       (n_nodes, 3)       mm
    elements    (n_elements, 10)   node indices, VTK order (corners, then TET_EDGES)
    surfaces    name -> (n_facets, 6) node indices: corners, then mid-sides 01, 12, 20
    interfaces  name -> Interface, with the surfaces that it names
    volume_cad  mm3, of the CAD body the mesh stands for
    mesher      name of the program that made the volume mesh
    ties        between the bodies of a stack, such as the leaves of a spring
    half        True if it is the half at z >= 0 of a part that is its own mirror image about z = 0;
                it ends at the surface SYMMETRY, and its interfaces are those of the whole part
    unit        mm, in which it was meshed: sizes of a finer mesh are steps of that unit
    entities    (n_nodes, 2) dimension and tag of the CAD vertex, edge, face or solid that each node
                is on; none of a stack
    """

    nodes: FloatArray
    elements: IntArray
    surfaces: Mapping[str, IntArray]
    interfaces: Mapping[str, Interface]
    volume_cad: float
    mesher: str = "HXT"
    ties: tuple[Tie, ...] = ()
    half: bool = False
    unit: float = 1.0
    entities: IntArray | None = None

    def __post_init__(self) -> None:
        if self.nodes.ndim != 2 or self.nodes.shape[1] != 3:
            raise MeshError(f"nodes must have shape (n, 3), got {self.nodes.shape}")
        if self.elements.ndim != 2 or self.elements.shape[1] != 10 or not len(self.elements):
            raise MeshError(f"elements must have shape (n, 10), n > 0, got {self.elements.shape}")
        wanted = {name for face in self.interfaces.values() for name in face.surfaces}
        missing = wanted - set(self.surfaces)
        if missing:
            raise MeshError(f"interfaces without a surface: {', '.join(sorted(missing))}")
        used = np.zeros(len(self.nodes), dtype=bool)
        used[self.elements] = True
        if not used.all():
            raise MeshError(f"{np.count_nonzero(~used)} nodes belong to no element")
        away = float(np.abs(self.nodes).max() / np.ptp(self.nodes, axis=0).max())
        if away > _FARTHEST:
            raise MeshError(
                f"the part stands {away:.1e} times its size from the origin of its axes (limit "
                f"{_FARTHEST:.0e}): its coordinates lose their digits; move it closer"
            )
        self._check_overlap()
        self._check_half()
        worst = self.jacobian_minimum
        if not worst > 0:
            raise FoldedElementError(
                f"an element is folded: smallest scaled det J is {worst:.3g}, near "
                f"{_place(self.nodes[self._worst_element].mean(axis=0))} mm; a wall or a ligament "
                "there may be far thinner than its elements"
            )
        self._check_touching()
        deviation = abs(self.volume / self.volume_cad - 1)
        if deviation > 1e-3:
            raise MeshError(
                f"the mesh has {self.volume:.6g} mm3 and the body {self.volume_cad:.6g} mm3, "
                f"{deviation:.1e} apart (limit 1e-3)"
            )

    def _check_overlap(self) -> None:
        """MeshError where a facet belongs to two interfaces, or an interface has none.

        A sliding contact may run over a face that carries another interface: it presses on a
        patch of its surface alone.
        """
        owner: dict[tuple[int, ...], str] = {}
        for name, face in self.interfaces.items():
            facets = np.concatenate([self.surfaces[surface] for surface in face.surfaces])
            if not len(facets):
                raise MeshError(f"interface {name!r} has no facets on the mesh")
            if face.kind == "slide":
                continue
            corners = {tuple(row) for row in np.sort(facets[:, :3], axis=1).tolist()}
            for other in sorted({owner[row] for row in corners if row in owner}):
                raise MeshError(f"interfaces {other!r} and {name!r} overlap: they share a face")
            owner |= dict.fromkeys(corners, name)

    def _check_half(self) -> None:
        """MeshError where a half has no cut, or is not all on one side of it."""
        if not self.half:
            return
        if not len(self.surfaces.get(SYMMETRY, ())):
            raise MeshError(f"half of a part needs the surface {SYMMETRY!r} at which it was cut")
        low = float(self.nodes[:, 2].min())
        if low < 0 or self.nodes[self.cut_nodes, 2].any():
            raise MeshError(f"half of a part must end at z = 0, it reaches down to {low:.3g} mm")

    def check_whole(self, what: str) -> None:
        """MeshError if the mesh is half of a part: `what` needs all of it."""
        if self.half:
            raise MeshError(
                f"{what} needs the whole part; this mesh is the half at z >= 0, for loads without "
                "a part out of the plane"
            )

    def _check_touching(self) -> None:
        """MeshError where the body touches itself along a line, as beside a hole tangent to it."""
        corners = self.facets[:, :3]
        sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        # one number per side: NumPy sorts rows ten times as slowly
        numbers, counts = np.unique(sides[:, 0] * len(self.nodes) + sides[:, 1], return_counts=True)
        lines = numbers[counts > 2]
        if len(lines):
            at = self.nodes[lines[0] // len(self.nodes)]
            raise MeshError(
                f"the body touches itself along a line, at {_place(at)} mm: a "
                "wall or a ligament has no thickness there"
            )

    @cached_property
    def jacobian_minimum(self) -> float:
        """The smallest det J over all elements' nodes, scaled by the element's mean det J."""
        return float(self._scaled_jacobians.min())

    @property
    def _worst_element(self) -> IntArray:
        return np.asarray(self.elements[self._scaled_jacobians.argmin()])

    @cached_property
    def _scaled_jacobians(self) -> FloatArray:
        """(n_elements,)."""
        determinants = _jacobian_determinants(self.nodes, self.elements, _NODE_POINTS)
        mean = np.abs(determinants.mean(axis=1))
        return np.asarray(determinants.min(axis=1) / np.where(mean > 0, mean, 1.0))

    @cached_property
    def facets(self) -> IntArray:
        """Facets that belong to one element only, (n, 6): of a half with its cut."""
        return boundary_facets(self.elements)

    @cached_property
    def cut_nodes(self) -> IntArray:
        """Indices of the nodes in the plane at which a half ends, ascending; none of a whole."""
        return np.unique(self.surfaces[SYMMETRY]) if self.half else np.zeros(0, dtype=np.int64)

    @property
    def share(self) -> float:
        """Share of the part that is meshed: 1, or 1/2."""
        return 0.5 if self.half else 1.0

    @cached_property
    def boundary(self) -> IntArray:
        """Facets of the part's own surface, (n, 6): without the cut of a half."""
        cut = np.isin(self.facets[:, :3], self.cut_nodes).all(axis=1)
        return np.asarray(self.facets[~cut])

    @cached_property
    def volume(self) -> float:
        """Volume of the curved elements, mm3."""
        return float(self._weights.sum())

    @cached_property
    def _weights(self) -> FloatArray:
        determinants = _jacobian_determinants(self.nodes, self.elements, _QUADRATURE_POINTS)
        return np.asarray(determinants * _QUADRATURE_WEIGHTS)

    @cached_property
    def surface_nodes(self) -> IntArray:
        """Indices of the nodes on the part's own surface, ascending."""
        return np.unique(self.boundary)

    def mass_properties(self, density: float) -> MassProperties:
        """Mass, centre and moment of inertia about z, by quadrature on the curved elements.

        Of the whole part, also where the mesh is half of it.
        """
        points = np.einsum("qa,eax->eqx", _shape(_QUADRATURE_POINTS), self.nodes[self.elements])
        mass = density * self._weights.sum()
        centre = density * np.einsum("eq,eqx->x", self._weights, points) / mass
        arm = points[..., :2] - centre[:2]
        inertia = density * np.einsum("eq,eqx,eqx->", self._weights, arm, arm)
        if self.half:
            centre[2] = 0.0
        return MassProperties(float(mass / self.share), centre, float(inertia / self.share))


def _place(point: FloatArray) -> str:
    return "({:.4g}, {:.4g}, {:.4g})".format(*point + 0.0)


def boundary_facets(elements: IntArray) -> IntArray:
    """Facets that belong to one element only, (n, 6): corners, then mid-sides 01, 12, 20."""
    local = np.array(
        [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]]
    )
    facets = elements[:, local].reshape(-1, 6)
    corners = np.sort(facets[:, :3], axis=1)
    order = np.lexsort(corners.T[::-1])  # NumPy's unique sorts rows ten times as slowly
    ascending = corners[order]
    other = np.ones(len(facets) + 1, dtype=bool)  # than the one before
    other[1:-1] = (ascending[1:] != ascending[:-1]).any(axis=1)
    return np.asarray(facets[order[other[:-1] & other[1:]]])


def _shape(points: FloatArray) -> FloatArray:
    """Shape functions of the ten-node tetrahedron, (n_points, 10)."""
    barycentric = np.column_stack([1 - points.sum(axis=1), points])
    corner = barycentric * (2 * barycentric - 1)
    middle = [4 * barycentric[:, i] * barycentric[:, j] for i, j in TET_EDGES]
    return np.column_stack([corner, *middle])


def shape_gradients(points: FloatArray) -> FloatArray:
    """Their derivatives by the three local coordinates, (n_points, 10, 3)."""
    barycentric = np.column_stack([1 - points.sum(axis=1), points])
    slopes = np.vstack([-np.ones(3), np.eye(3)])
    corner = (4 * barycentric - 1)[:, :, None] * slopes
    middle = [
        4 * (barycentric[:, i, None] * slopes[j] + barycentric[:, j, None] * slopes[i])
        for i, j in TET_EDGES
    ]
    return np.concatenate([corner, np.stack(middle, axis=1)], axis=1)


def _jacobian_determinants(nodes: FloatArray, elements: IntArray, points: FloatArray) -> FloatArray:
    """Det J at the given local points of every element, (n_elements, n_points)."""
    by_local = shape_gradients(points).transpose(0, 2, 1).reshape(-1, 10)
    jacobians = np.matmul(by_local, nodes[elements]).reshape(-1, len(points), 3, 3)
    (a, b, c), (d, e, f), (g, h, i) = ([jacobians[..., k, j] for j in range(3)] for k in range(3))
    # NumPy factorises each matrix, which takes ten times as long
    return np.asarray(a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g))


def _keast_degree_4() -> tuple[FloatArray, FloatArray]:
    """Eleven points, degree 4 (Keast 1986, table 1 no. 4); weights sum to 1/6."""
    a, b = (1 + np.sqrt(5 / 14)) / 4, (1 - np.sqrt(5 / 14)) / 4
    corners = np.full((4, 4), 1 / 14) + np.eye(4) * (11 / 14 - 1 / 14)
    edges = np.array([[a if k in pair else b for k in range(4)] for pair in TET_EDGES])
    barycentric = np.vstack([np.full(4, 0.25), corners, edges])
    weights = np.r_[-74 / 5625, np.full(4, 343 / 45000), np.full(6, 28 / 1125)]
    return barycentric[:, 1:], weights


_QUADRATURE_POINTS, _QUADRATURE_WEIGHTS = _keast_degree_4()
_NODE_POINTS: Any = np.vstack(
    [
        np.vstack([np.zeros(3), np.eye(3)]),
        [
            (np.vstack([np.zeros(3), np.eye(3)])[i] + np.vstack([np.zeros(3), np.eye(3)])[j]) / 2
            for i, j in TET_EDGES
        ],
    ]
)
