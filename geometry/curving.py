"""Curved elements that fold on a small fillet, mended.

A chord across a fillet leaves the part where the tangent plane at its end turns: the edge from
there to a node in the part then begins outside, and its element is folded although nothing is wrong
with its corners. Bending that edge mends it; corners and all nodes on the surface stay where the
mesher has put them. An element with all corners on a fillet has no such edge: there the nodes of
the elements around it move, too, those on the surface along it. The shape of the part stays its
own.

The determinant of an element's Jacobian is a cubic polynomial; its least Bernstein coefficient is
not above its least value anywhere in the element, as the polynomial lies in the convex hull of its
coefficients. It is taken over the determinant of the element with straight edges.

Nodes move where the part lets them: free inside of it, on the surface along it. A node on a CAD
face has two coordinates of that face, one on a CAD edge has one, a corner of the CAD body has none.
Moves along the face are in mm along the tangents where the node began, so that all count alike.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from math import factorial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from geometry.mesh import TET_EDGES, BoolArray, FloatArray, IntArray, shape_gradients

_SAME = 1e-6  # of the part's size: a node is where its coordinates on the face say
_POLE = 1e-6  # of the longest tangent: a shorter second one is the pole of a face
ENOUGH = 0.1  # the least coefficient that needs no mending; gmsh's own limit
_WANTED = 0.25  # up to which it is raised where edges bend
_STEPS = 200
_LITTLE = 1e-2  # of the sum of squares: a free step that gains less is the last
_FREE = 1.0  # damping up to which a step is free
_STUCK = 1e9  # damping beyond which no step helps
_FLAT = 1e-9  # of the size: edges bent by less are straight
_STIFF = 1e-3  # share of an edge's own bending in what is made small
Scale = Callable[[FloatArray], FloatArray]  # places (n, 10, 3) of elements to det J (n,)


@dataclass(frozen=True, eq=False)
class _Patch:
    """Some nodes on one CAD face or edge.

    entity   (dimension, tag) of gmsh
    rows     (n,)        their rows among the moving nodes
    start    (n, d)      coordinates on the face or edge
    per_mm   (n, d, d)   coordinates per mm along d tangents
    """

    entity: tuple[int, int]
    rows: IntArray
    start: FloatArray
    per_mm: FloatArray


class Gliding:
    """Nodes of gmsh's model that may move.

    moving  (m,) indices of nodes, ascending
    """

    def __init__(self, gmsh: Any, nodes: FloatArray, index: IntArray, wanted: IntArray) -> None:
        """Let the nodes `wanted` (k,) move; nodes (n, 3) mm, index of each of gmsh's node tags."""
        self._gmsh = gmsh
        inside: list[IntArray] = []
        on: list[tuple[tuple[int, int], IntArray, FloatArray, FloatArray]] = []
        chosen: BoolArray = np.zeros(len(nodes), dtype=bool)
        chosen[wanted] = True
        for entity in gmsh.model.getEntities():
            tags = gmsh.model.mesh.getNodes(*entity, returnParametricCoord=False)[0]
            some = index[np.asarray(tags, dtype=np.int64)]
            some = some[chosen[some]]
            if entity[0] == 3:
                inside.append(some)
            elif entity[0] in (1, 2) and len(some):
                on.extend(self._on(entity, some, nodes))
        self.moving: IntArray = np.sort(np.concatenate([*inside, *(some for _, some, *_ in on)]))
        self._start = nodes[self.moving]
        self._inside = np.searchsorted(self.moving, np.concatenate(inside))
        self._patches = [
            _Patch(entity, np.searchsorted(self.moving, some), start, per_mm)
            for entity, some, start, per_mm in on
        ]

    def _on(
        self, entity: tuple[int, int], some: IntArray, nodes: FloatArray
    ) -> Iterator[tuple[tuple[int, int], IntArray, FloatArray, FloatArray]]:
        """Those nodes of a face or edge that have coordinates and tangents there."""
        try:
            flat = self._gmsh.model.getParametrization(*entity, nodes[some].ravel())
            start = np.reshape(flat, (len(some), -1))
            places, tangents = self._at(entity, start)
        except Exception:  # gmsh raises bare Exception only; on such a face no node moves
            return
        upper = np.linalg.qr(tangents, mode="r")  # (n, d, d)
        lengths = np.abs(np.diagonal(upper, axis1=1, axis2=2))
        off = np.linalg.norm(places - nodes[some], axis=1)
        good = (off < _SAME * np.ptp(nodes, axis=0).max()) & (
            lengths.min(axis=1) > _POLE * lengths.max(axis=1)
        )
        if good.any():
            yield entity, some[good], start[good], np.linalg.inv(upper[good])

    def _at(self, entity: tuple[int, int], where: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (n, 3) and tangents (n, 3, d) at coordinates (n, d) of a face or edge."""
        flat = where.ravel()
        places = np.reshape(self._gmsh.model.getValue(*entity, flat), (-1, 3))
        tangents = np.reshape(self._gmsh.model.getDerivative(*entity, flat), (len(where), -1, 3))
        return places, np.swapaxes(tangents, 1, 2)

    def places(self, moves: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (m, 3) mm after moves (m, 3) mm, and slopes (m, 3, 3): place by move.

        On a face the third move does nothing, on an edge the second and third.
        """
        found = self._start.copy()
        slopes = np.zeros((len(found), 3, 3))
        found[self._inside] += moves[self._inside]
        slopes[self._inside] = np.eye(3)
        for patch in self._patches:
            count = patch.start.shape[1]
            own = moves[patch.rows, :count]
            where = patch.start + np.einsum("nij,nj->ni", patch.per_mm, own)
            places, tangents = self._at(patch.entity, where)
            # where nothing moves, the node stays to the last bit
            found[patch.rows] = np.where(np.any(own, axis=1)[:, None], places, found[patch.rows])
            slopes[patch.rows, :, :count] = tangents @ patch.per_mm
        return found, slopes


if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


def least_coefficients(nodes: FloatArray, elements: IntArray) -> FloatArray:
    """Least Bernstein coefficient of each element's det J over its straight one's, (n_elements,).

    Minus infinity where the corners themselves are folded. Nodes mm, elements in VTK order.
    """
    places = nodes[elements]
    straight = _straight(places)
    found = np.where(straight > 0, 1.0, -np.inf)
    middles = np.stack([(places[:, i] + places[:, j]) / 2 for i, j in TET_EDGES], axis=1)
    away = np.abs(places[:, 4:] - middles).max(axis=(1, 2))
    size = np.ptp(places[:, :4], axis=1).max(axis=1)
    curved = np.flatnonzero((straight > 0) & (away > _FLAT * size))  # others are 1 everywhere
    found[curved] = (_coefficients(places[curved])[0] / straight[curved, None]).min(axis=1)
    return found


def nearly_folded(nodes: FloatArray, elements: IntArray) -> BoolArray:
    """Elements (n_elements,) whose det J comes close to zero, by what is usual in them.

    Corners nearly in one plane give an element hardly any volume while its edges are straight. It
    may get some by its curved edges, and nearly fold by that measure.
    """
    places = nodes[elements]
    least = _coefficients(places)[0].min(axis=1)
    return np.asarray(least < ENOUGH * _usual(places))


def bent(nodes: FloatArray, elements: IntArray, inside: IntArray) -> FloatArray:
    """Nodes (n_nodes, 3) with the inner edges of folded elements bent, mm.

    nodes     (n_nodes, 3) mm
    elements  (n_elements, 10), VTK order
    inside    indices of the nodes that are on no surface

    Where that mends all, elements that nearly fold are bent too, if the worst is no worse for it.
    """
    least = least_coefficients(nodes, elements)
    if not (least < ENOUGH).any():
        return nodes
    first = _raised(nodes, elements, inside, least < ENOUGH)
    least = least_coefficients(first, elements)
    if (least < ENOUGH).any():
        return first
    second = _raised(first, elements, inside, least < _WANTED)
    return second if least_coefficients(second, elements).min() >= least.min() else first


class Moves(Protocol):
    """Nodes that may move, and where they go.

    moving  (m,) indices of nodes, ascending
    """

    moving: IntArray

    def places(self, moves: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (m, 3) mm after moves (m, 3) mm, and slopes (m, 3, 3): place by move."""
        ...


class _InSpace:
    """Nodes inside of the part: they go where they are moved."""

    def __init__(self, nodes: FloatArray, moving: IntArray) -> None:
        self.moving, self._start = moving, nodes[moving]

    def places(self, moves: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._start + moves, np.broadcast_to(np.eye(3), (len(moves), 3, 3))


def around(elements: IntArray, low: BoolArray, layers: int) -> IntArray:
    """Indices of the nodes of some elements and of `layers` of elements around them, ascending.

    elements (n_elements, 10), low (n_elements,) bool
    """
    for _ in range(layers):
        low = np.asarray(np.isin(elements, elements[low]).any(axis=1))
    return np.unique(elements[low])


def moved(nodes: FloatArray, elements: IntArray, moves: Moves) -> FloatArray:
    """Nodes (n_nodes, 3) with those that may move where no element nearly folds, mm.

    No more than can be: elements may stay folded.
    """
    return _minimised(nodes, elements, moves, _usual)


def _raised(nodes: FloatArray, elements: IntArray, inside: IntArray, low: BoolArray) -> FloatArray:
    """Nodes (n_nodes, 3) with the inner edges of some elements bent, mm; low (n_elements,) bool."""
    free = np.zeros(len(nodes), dtype=bool)
    free[inside] = True
    free[elements[:, :4]] = False
    free &= np.isin(np.arange(len(nodes)), elements[low])
    return _minimised(nodes, elements, _InSpace(nodes, np.flatnonzero(free)), _straight)


def _minimised(nodes: FloatArray, elements: IntArray, moves: Moves, scale: Scale) -> FloatArray:
    """Nodes (n_nodes, 3) where the sum of squares of `_Lacking` is least, mm.

    By Levenberg's and Marquardt's method, until a free step gains little. A step that gains as much
    as the slopes foretold lowers the damping to a third at most; each that gains nothing raises it,
    ever faster. Smaller steps, or those of a quasi-Newton method, would wander along the valleys of
    this sum to where rounding leads them: to another place on another processor.
    """
    if not len(moves.moving):
        return nodes
    from scipy.sparse.linalg import splu

    touched = np.isin(elements, moves.moving).any(axis=1)
    lacking = _Lacking(nodes, elements[touched], moves, scale)
    at = np.zeros(3 * len(moves.moving))
    damping, growth, value = 1e-3, 2.0, lacking.move(at)
    slopes, squares = lacking.normal()
    for _ in range(_STEPS):
        if not slopes.any():
            break
        own = squares.diagonal()
        scaled = damping * own
        squares.setdiag(own + scaled)
        step = -splu(squares).solve(slopes)
        squares.setdiag(own)
        found = lacking.move(at + step)
        gain = (value - found) / (0.5 * step @ (scaled * step - slopes))
        if gain > 0.0:
            little = value - found < _LITTLE * value and damping < _FREE
            at, value = at + step, found
            if little:
                break
            slopes, squares = lacking.normal()
            damping, growth = damping * max(1 / 3, 1.0 - (2.0 * gain - 1.0) ** 3), 2.0
        else:
            damping, growth = damping * growth, 2.0 * growth
            if damping > _STUCK:
                break
    result = nodes.copy()
    result[moves.moving] = moves.places(at.reshape(-1, 3))[0]
    return result


class _Lacking:
    """Lack of the coefficients of some elements, and moves of nodes over their elements' size.

    sizes  (3 n_moving,) mm, of the largest element at each node
    """

    def __init__(self, nodes: FloatArray, elements: IntArray, moves: Moves, scale: Scale) -> None:
        self._moves = moves
        place = np.full(len(nodes), -1)
        place[moves.moving] = np.arange(len(moves.moving))
        self._local = place[elements]
        self._element, self._node = np.nonzero(self._local >= 0)
        self._rows = self._local[self._element, self._node]
        self._start = nodes[elements]
        self._whole = scale(self._start)
        size = np.zeros(len(moves.moving))
        extent = np.ptp(self._start[:, :4], axis=1).max(axis=1)
        np.maximum.at(size, self._rows, extent[self._element])
        self.sizes = np.repeat(size, 3)
        self._stiff = _STIFF / self.sizes**2

    def move(self, flat: FloatArray) -> float:
        """Half the sum of squares where nodes have moved by flat (n,) mm."""
        targets, self._tangents = self._moves.places(flat.reshape(-1, 3))
        places = self._start.copy()
        places[self._element, self._node] = targets[self._rows]
        coefficients, self._jacobians = _coefficients(places)
        self._lacking = np.maximum(0.0, _WANTED - coefficients / self._whole[:, None])
        self._flat = flat
        return 0.5 * float((self._lacking**2).sum() + (self._stiff * flat**2).sum())

    def normal(self) -> "tuple[FloatArray, csc_matrix]":
        """Gradient (n,) of that half after the last move, and the squares of its slopes (n, n)."""
        from scipy.sparse import csc_matrix, csr_matrix, diags

        bad, which = np.nonzero(self._lacking)
        elements, place = np.unique(bad, return_inverse=True)
        cofactors = _cofactors(self._jacobians[elements]).reshape(-1, 3 * len(_POINTS), 3)
        by_place = np.matmul(_SLOPES[which], cofactors[place]) / -self._whole[bad, None, None]
        pair, node = np.nonzero(self._local[bad] >= 0)
        rows = self._local[bad[pair], node]
        slopes = np.matmul(by_place[pair, node][:, None], self._tangents[rows])
        columns = 3 * rows[:, None] + np.arange(3)
        table = csr_matrix(
            (slopes.ravel(), (np.repeat(pair, 3), columns.ravel())), (len(bad), len(self._flat))
        )
        gradient = self._stiff * self._flat + table.T @ self._lacking[bad, which]
        return gradient, csc_matrix(table.T @ table + diags(self._stiff))


def _coefficients(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bernstein coefficients (n, 20) of det J, and the Jacobians (n, 20, 3, 3) they come from.

    Jacobians of local by place: [..., r, x] is d x / d r.
    """
    jacobians = np.matmul(_BY_LOCAL, places).reshape(-1, len(_POINTS), 3, 3)
    (ax, ay, az), b, c = _rows(jacobians)
    x, y, z = _crossed(b, c)
    return (ax * x + ay * y + az * z) @ _FROM_VALUES.T, jacobians


def _cofactors(jacobians: FloatArray) -> FloatArray:
    """Slopes (n, 20, 3, 3) of det J by the Jacobians' entries."""
    a, b, c = _rows(jacobians)
    slopes = np.empty_like(jacobians)
    for k, pair in enumerate(((b, c), (c, a), (a, b))):
        for x, component in enumerate(_crossed(*pair)):
            slopes[..., k, x] = component
    return slopes


def _rows(jacobians: FloatArray) -> list[list[FloatArray]]:
    """The nine entries (n, 20) of the Jacobians (n, 20, 3, 3), row by row."""
    return [[jacobians[..., k, x] for x in range(3)] for k in range(3)]


def _crossed(a: list[FloatArray], b: list[FloatArray]) -> tuple[FloatArray, ...]:
    """The components of cross products; sums over a last axis of three take twice as long."""
    (ax, ay, az), (bx, by, bz) = a, b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def _straight(places: FloatArray) -> FloatArray:
    """Det J of the elements with straight edges, (n,)."""
    sides = places[:, 1:4] - places[:, :1]
    return np.asarray(np.linalg.det(sides))


def _usual(places: FloatArray) -> FloatArray:
    """Det J of the elements with straight edges, or half of its mean where that is larger, (n,)."""
    return np.asarray(np.maximum(_straight(places), _coefficients(places)[0].mean(axis=1) / 2))


def _lattice() -> tuple[FloatArray, FloatArray]:
    """Local points (20, 3) of a cubic, and the matrix from values there to its coefficients."""
    powers = np.array([p for p in product(range(4), repeat=4) if sum(p) == 3])
    shares = powers / 3
    count = np.array([6 / np.prod([factorial(k) for k in p]) for p in powers])
    values = count * np.prod(shares[:, None, :] ** powers[None, :, :], axis=2)
    return shares[:, 1:], np.linalg.inv(values)


_POINTS, _FROM_VALUES = _lattice()
_GRADIENTS = shape_gradients(_POINTS)
_BY_LOCAL = _GRADIENTS.transpose(0, 2, 1).reshape(-1, 10)  # (20 x 3, 10): from places to Jacobians
# (20, 10, 20 x 3): from cofactors at the points to slopes of a coefficient by nodes
_SLOPES = np.einsum("cq,qar->caqr", _FROM_VALUES, _GRADIENTS).reshape(len(_POINTS), 10, -1)
