"""Linkages of bars and rigid bodies as frames: joints as exact constraints, forces that go along.

Every link keeps its own unknowns in its own axes; a joint is a set of rows that vanish. All links
move in the x-y plane and are symmetric about it, so what happens in it (x, y, turn about z) and out
of it (z, turns about x and y) separate. Forces keep size and direction while the frame buckles, but
for those between two points, which keep pointing from one to the other, and those of a slot, which
turn with it. The potential of a force f at the arm r of a body that turns by t is to second order

    1/2 [(f . r) t . t - (f . t)(r . t)],

as the point goes on by 1/2 t x (t x r). The rows of a pin never hold the turn about z.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from fem.frame import (
    Frame,
    FrameModes,
    buckling_modes,
    gauss_points,
    whitening,
    work_of_axial_force,
)
from fem.unit_solutions import Elastic
from geometry.bars import Bar
from geometry.mesh import FloatArray, IntArray

IN_PLANE, OUT_OF_PLANE = (0, 1, 5), (2, 3, 4)
_ON_NODE = 1e-9  # of a link's length
_REDUNDANT = 1e-9  # of the largest singular value: a constraint that others imply


@dataclass(frozen=True, eq=False)
class Link:
    """A bar along its own x axis, or a rigid body.

    name
    frame  of the bar: its nodes on the x axis, rising; None: rigid
    """

    name: str
    frame: Frame | None = None

    def __post_init__(self) -> None:
        if self.frame is None:
            return
        nodes = self.frame.nodes
        if nodes[:, 1:].any() or (np.diff(nodes[:, 0]) <= 0).any():
            raise ValueError(f"link {self.name!r}: its nodes must rise along its own x axis")
        if not np.array_equal(self.frame.members, chain(len(nodes))):
            raise ValueError(f"link {self.name!r}: its members must join one node to the next")

    @property
    def n_unknowns(self) -> int:
        """Six per node; a rigid body has one node, at its origin."""
        return 6 if self.frame is None else 6 * len(self.frame.nodes)

    @cached_property
    def stiffness(self) -> FloatArray:
        """In its own axes, (n, n)."""
        if self.frame is None:
            return np.zeros((6, 6))
        return self.frame.dense_stiffness()

    @cached_property
    def _work(self) -> FloatArray:
        assert self.frame is not None
        return work_of_axial_force(self.frame)

    def geometric(self, axial: FloatArray) -> FloatArray:
        """Geometric stiffness (l, n, n) of axial forces at the Gauss points (l, m, 6), own axes."""
        assert self.frame is not None
        blocks = np.einsum("lmg,mguv->mluv", axial, self._work)
        result = np.zeros((len(axial), self.n_unknowns, self.n_unknowns))
        for member, block in enumerate(blocks):
            own = slice(6 * member, 6 * member + 12)  # members join one node to the next
            result[:, own, own] += block
        return result

    def motion(self, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion (6, n) of a place (2,), and its arm (2,) from the axis; own axes.

        Beside the axis and beyond the ends a rigid arm leads there; between nodes the axis is
        taken as bent by cubics.
        """
        x, y = float(place[0]), float(place[1])
        result = np.zeros((6, self.n_unknowns))
        if self.frame is None:
            result[:, :6] = _carried(x, y)
            return result, np.array([x, y])
        along = self.frame.nodes[:, 0]
        nearest = int(np.argmin(np.abs(along - x)))
        inside = along[0] < x < along[-1]
        if not inside or abs(x - along[nearest]) < _ON_NODE * (along[-1] - along[0]):
            arm = x - along[nearest]
            result[:, 6 * nearest : 6 * nearest + 6] = _carried(arm, y)
            return result, np.array([arm, y])
        first = int(np.searchsorted(along, x)) - 1
        length = along[first + 1] - along[first]
        result[:, 6 * first : 6 * first + 12] = _carried(0.0, y) @ _cubics(
            (x - along[first]) / length, length
        )
        return result, np.array([0.0, y])


def chain(n_nodes: int) -> IntArray:
    """Members from one node to the next, (n - 1, 2)."""
    return np.column_stack([np.arange(n_nodes - 1), np.arange(1, n_nodes)])


def bar_frame(bar: Bar, material: Elastic, pieces: int, places: Sequence[float] = ()) -> Frame:
    """Members of a bar between its cuts and `places`, its longest stretch in at least `pieces`."""
    stations = bar.stations(pieces, places)
    nodes = np.zeros((len(stations), 3))
    nodes[:, 0] = stations
    members = chain(len(stations))
    sections = bar.at(gauss_points(nodes, members)[..., 0])
    return Frame(nodes, members, np.array([0.0, 1.0, 0.0]), sections, material)


def _carried(x: float, y: float) -> FloatArray:
    """Matrix (6, 6) from the motion of a rigid arm's foot to the motion of its end (x, y)."""
    result = np.eye(6)
    result[0, 5], result[1, 5] = -y, x
    result[2, 3], result[2, 4] = y, -x
    return result


def _cubics(s: float, length: float) -> FloatArray:
    """Matrix (6, 12) from the motion of a member's nodes to the motion at its share s."""
    start, end = 1 - 3 * s**2 + 2 * s**3, 3 * s**2 - 2 * s**3
    lean, tail = length * s * (1 - s) ** 2, length * s**2 * (s - 1)
    slope = 6 * s * (1 - s) / length
    lean_slope, tail_slope = 1 - 4 * s + 3 * s**2, 3 * s**2 - 2 * s
    result = np.zeros((6, 12))
    result[[0, 3], [0, 3]], result[[0, 3], [6, 9]] = 1 - s, s
    result[1, [1, 5, 7, 11]] = start, lean, end, tail
    result[5, [1, 5, 7, 11]] = -slope, lean_slope, slope, tail_slope
    result[2, [2, 4, 8, 10]] = start, -lean, end, -tail
    result[4, [2, 4, 8, 10]] = slope, lean_slope, -slope, tail_slope
    return result


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a place of a link with all unknowns, in global axes.

    rows   (6, n)  displacement and turn per unknown; zero on the ground
    place  (2,)    mm
    arm    (2,)    mm, from the node or axis that turns with it
    """

    rows: FloatArray
    place: FloatArray
    arm: FloatArray


@dataclass(frozen=True, eq=False)
class PlacedLinks:
    """Links where they stand in one position of a linkage.

    links
    origins  (n_links, 2) mm, angles (n_links,) rad: of their own axes
    """

    links: Sequence[Link]
    origins: FloatArray
    angles: FloatArray

    @cached_property
    def _starts(self) -> IntArray:
        return np.cumsum([0, *(link.n_unknowns for link in self.links)])

    @property
    def n_unknowns(self) -> int:
        """Of all links together."""
        return int(self._starts[-1])

    @cached_property
    def size(self) -> float:
        """The extent of all, mm: by it a turn counts as a displacement."""
        ends = [
            self.to_ground(k, place)
            for k, link in enumerate(self.links)
            for place in (np.zeros((1, 2)) if link.frame is None else link.frame.nodes[[0, -1], :2])
        ]
        return float(np.ptp(np.array(ends), axis=0).max()) or 1.0

    def to_ground(self, link: int, place: FloatArray) -> FloatArray:
        """A place (2,) of a link in global axes."""
        return np.asarray(self.origins[link] + _turn(self.angles[link]) @ place)

    @cached_property
    def _motions(self) -> dict[tuple[int | None, bytes], Motion]:
        return {}

    def motion(self, link: int | None, place: FloatArray) -> Motion:
        """Motion of a place (2,) of a link, in its own axes; None is the ground."""
        key = link, np.asarray(place, dtype=float).tobytes()
        if key not in self._motions:  # joints and forces ask for the same places
            self._motions[key] = self._motion(link, place)
        return self._motions[key]

    def _motion(self, link: int | None, place: FloatArray) -> Motion:
        rows = np.zeros((6, self.n_unknowns))
        if link is None:
            return Motion(rows, np.asarray(place), np.zeros(2))
        turn = _turn(self.angles[link])
        own, arm = self.links[link].motion(place)
        part = slice(self._starts[link], self._starts[link + 1])
        rows[:, part] = own
        for k in (0, 3):
            rows[k : k + 2] = turn @ rows[k : k + 2]
        return Motion(rows, self.to_ground(link, place), turn @ arm)

    @cached_property
    def stiffness(self) -> FloatArray:
        """Of all unknowns, (n, n), in the links' own axes: the same in every position."""
        return _stiffness(tuple(self.links))

    def axial(self, link: int, forces: FloatArray) -> FloatArray:
        """Geometric stiffness (l, n, n) of axial forces (l, m, 6) in a bar."""
        result = np.zeros((len(forces), self.n_unknowns, self.n_unknowns))
        part = slice(self._starts[link], self._starts[link + 1])
        result[:, part, part] = self.links[link].geometric(forces)
        return result

    def unknowns(self, plane: Sequence[int]) -> IntArray:
        """Unknowns that move in a plane, (k,)."""
        return _in_plane(self.n_unknowns, tuple(plane))

    def part(self, link: int) -> IntArray:
        """Unknowns of a link, (k,)."""
        return np.arange(self._starts[link], self._starts[link + 1])

    def free_motions(self, constraints: FloatArray, plane: Sequence[int]) -> FloatArray:
        """Motions (n, k) in a plane that leave constraints (r, n) at zero."""
        own = self.unknowns(plane)
        scale = np.where(own % 6 < 3, 1.0, 1 / self.size)
        rows = constraints[:, own] * scale
        lengths = np.linalg.norm(rows, axis=1)
        free = _left_free(rows[lengths > 0] / lengths[lengths > 0, None])
        result = np.zeros((self.n_unknowns, free.shape[1]))
        result[own] = scale[:, None] * free
        return result

    def unit_motions(self, constraints: FloatArray, plane: Sequence[int]) -> FloatArray:
        """The same motions (n, k), combined so that their stiffness is the unit matrix.

        Raises LooseFrameError if something moves without strain.
        """
        moves = self.free_motions(constraints, plane)
        own = self.unknowns(plane)
        inside = moves[own]
        moves[own] = inside @ whitening(inside.T @ self.stiffness[np.ix_(own, own)] @ inside)
        return moves

    def buckling(
        self,
        constraints: FloatArray,
        geometric: FloatArray,
        plane: Sequence[int],
    ) -> FrameModes:
        """Lowest buckling factor in one plane; its shape (n, 1) in the links' own axes.

        Raises LooseFrameError if something moves without strain.
        """
        moves = self.free_motions(constraints, plane)
        found = buckling_modes(
            moves.T @ self.stiffness @ moves, moves.T @ geometric @ moves, count=1
        )
        return replace(found, shapes=moves @ found.shapes)


@lru_cache(maxsize=8)
def _stiffness(links: tuple[Link, ...]) -> FloatArray:
    """Stiffness (n, n) of links beside each other, in their own axes."""
    starts = np.cumsum([0, *(link.n_unknowns for link in links)])
    result = np.zeros((starts[-1],) * 2)
    for link, first, end in zip(links, starts, starts[1:], strict=False):
        result[first:end, first:end] = link.stiffness
    result.flags.writeable = False
    return result


@lru_cache(maxsize=64)
def _in_plane(n_unknowns: int, plane: tuple[int, ...]) -> IntArray:
    nodes = np.arange(n_unknowns // 6)
    result = np.sort((6 * nodes[:, None] + np.array(plane)).ravel())
    result.flags.writeable = False
    return result


def _left_free(rows: FloatArray) -> FloatArray:
    """Orthonormal vectors (n, k) that rows (r, n) of unit length take to zero.

    Rows that do not imply each other give them by a QR decomposition, for a fraction of the cost.
    """
    count, n = rows.shape
    if 0 < count <= n:
        turned, upper = np.linalg.qr(rows.T, mode="complete")
        values = np.linalg.svd(upper[:count], compute_uv=False)
        if values[-1] > _REDUNDANT * values[0]:
            return np.asarray(turned[:, count:])
    _, values, right = np.linalg.svd(rows)
    rank = int((values > _REDUNDANT * values[0]).sum()) if len(values) else 0
    return np.asarray(right[rank:].T)


def _turn(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def pin(a: Motion, b: Motion, axis: FloatArray | None = None) -> FloatArray:
    """Rows (r, n) of a hinge about z; its fork holds both tilts, or only that about `axis` (2,)."""
    apart = b.rows - a.rows
    tilts = apart[3:5] if axis is None else (axis / np.linalg.norm(axis)) @ apart[3:5]
    return np.vstack([apart[:3], tilts])


def slide(a: Motion, b: Motion, normal: FloatArray, held: Sequence[int] = ()) -> FloatArray:
    """Rows (r, n) of a point b that stays on a line; `held` are other motions against a, 0 .. 5."""
    apart = b.rows - a.rows
    return np.vstack([normal @ apart[:2], apart[list(held)]])


def dead_force(at: Motion, force: FloatArray) -> FloatArray:
    """Geometric stiffness (n, n) of a force (2,) that keeps its direction, at its arm."""
    f, r = np.append(force, 0.0), np.append(at.arm, 0.0)
    product = np.outer(f, r)
    turns = at.rows[3:]
    return np.asarray(turns.T @ ((f @ r) * np.eye(3) - (product + product.T) / 2) @ turns)


def following_force(a: Motion, b: Motion, tension: float) -> FloatArray:
    """Geometric stiffness (n, n) of a force between two points, N, that pulls above 0."""
    span = np.append(b.place - a.place, 0.0)
    length = float(np.linalg.norm(span))
    across = np.eye(3) - np.outer(span, span) / length**2
    apart = (b.rows - a.rows)[:3]
    return np.asarray(tension / length * apart.T @ across @ apart)


def slot_force(a: Motion, b: Motion, normal: FloatArray, force: float) -> FloatArray:
    """Geometric stiffness (n, n) of a force along the normal of a line of a, on b.

    The normal turns with a: to second order the gap also is (t x normal) . (u_b - u_a).
    """
    x, y = normal
    cross = np.array([[0.0, 0.0, -y], [0.0, 0.0, x], [y, -x, 0.0]])  # t x normal
    half = -force * (cross @ a.rows[3:]).T @ (b.rows - a.rows)[:3]
    return np.asarray(half + half.T)
