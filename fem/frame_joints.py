"""Linkages of bars and rigid bodies as frames: joints as exact constraints, forces that go along.

Every link keeps its own unknowns in its own axes; a joint is a set of rows that vanish. All links
move in the x-y plane and are symmetric about it, so what happens in it (x, y, turn about z) and out
of it (z, turns about x and y) separate. Forces keep size and direction while the frame buckles, but
for those between two points, which keep pointing from one to the other, and those of a slot, which
turn with it. The potential of a force f at the arm r of a body that turns by t is to second order

    1/2 [(f . r) t . t - (f . t)(r . t)],

as the point goes on by 1/2 t x (t x r). The rows of a pin never hold the turn about z.

Motions of unit stiffness are sought where most unknowns are free of constraints in all poses. Their
stiffness is taken apart by blocks: the root of what nothing constrains is inverted once, and what
is left for a pose is as small as the unknowns that constraints hold.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from fem.frame import (
    MECHANISM,
    Frame,
    FrameModes,
    LooseFrameError,
    buckling_modes,
    gauss_points,
    lower_inverse,
    unit_diagonal,
    whitening,
    work_of_axial_force,
)
from fem.unit_solutions import Elastic
from geometry.bars import Bar
from geometry.mesh import BoolArray, FloatArray, IntArray

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
        count, points = axial.shape[0], axial.shape[1:]
        work = self._work.reshape(*points[:1], points[1], -1)
        blocks = (np.swapaxes(axial, 0, 1) @ work).reshape(-1, count, 12, 12)
        result = np.zeros((count, self.n_unknowns, self.n_unknowns))
        for member, block in enumerate(blocks):
            own = slice(6 * member, 6 * member + 12)  # members join one node to the next
            result[:, own, own] += block
        return result

    def motion(self, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion (..., 6, n) of places (..., 2), and their arms (..., 2) from the axis.

        In its own axes.

        Beside the axis and beyond the ends a rigid arm leads there; between nodes the axis is
        taken as bent by cubics.
        """
        if place.ndim > 1:
            found = [self.motion(one) for one in place.reshape(-1, 2)]
            motions, arms = (np.array(some) for some in zip(*found, strict=True))
            return motions.reshape(*place.shape[:-1], 6, -1), arms.reshape(place.shape)
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
    """Motion of a place of a link with all unknowns, in global axes; of one pose or many.

    rows   (..., 6, n)  displacement and turn per unknown; zero on the ground
    place  (..., 2)     mm
    arm    (..., 2)     mm, from the node or axis that turns with it
    """

    rows: FloatArray
    place: FloatArray
    arm: FloatArray


@dataclass(frozen=True, eq=False)
class PlacedLinks:
    """Links where they stand in one position of a linkage, or in many of them.

    links
    origins  (..., n_links, 2) mm, angles (..., n_links) rad: of their own axes
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

    def at(self, position: int | IntArray) -> "PlacedLinks":
        """The links in one of many positions, or in some of them."""
        return PlacedLinks(self.links, self.origins[position], self.angles[position])

    @cached_property
    def size(self) -> FloatArray:
        """The extents (...) of all, mm: by them a turn counts as a displacement."""
        ends = [
            self.to_ground(k, place)
            for k, link in enumerate(self.links)
            for place in (np.zeros((1, 2)) if link.frame is None else link.frame.nodes[[0, -1], :2])
        ]
        extent = np.ptp(np.array(ends), axis=0).max(axis=-1)
        return np.asarray(np.where(extent > 0, extent, 1.0))

    def to_ground(self, link: int, place: FloatArray) -> FloatArray:
        """Places (..., 2) of a link in global axes."""
        return np.asarray(self.origins[..., link, :] + _turned(self.angles[..., link], place))

    @cached_property
    def _motions(self) -> dict[tuple[int | None, bytes], Motion]:
        return {}

    def motion(self, link: int | None, place: FloatArray) -> Motion:
        """Motion of a place (..., 2) of a link, in its own axes; None is the ground."""
        key = link, np.asarray(place, dtype=float).tobytes()
        if key not in self._motions:  # joints and forces ask for the same places
            self._motions[key] = self._motion(link, place)
        return self._motions[key]

    def _motion(self, link: int | None, place: FloatArray) -> Motion:
        many = self.angles.shape[:-1]
        rows = np.zeros((*many, 6, self.n_unknowns))
        if link is None:
            return Motion(rows, np.asarray(place), np.zeros(2))
        own, arm = self.links[link].motion(place)
        angle = self.angles[..., link]
        turn, part = _turn(angle), slice(self._starts[link], self._starts[link + 1])
        rows[..., part] = own
        for k in (0, 3):
            rows[..., k : k + 2, part] = turn @ own[..., k : k + 2, :]
        return Motion(rows, self.to_ground(link, place), _turned(angle, arm))

    @cached_property
    def stiffness(self) -> FloatArray:
        """Of all unknowns, (n, n), in the links' own axes: the same in every position."""
        return _stiffness(tuple(self.links))

    def axial(self, link: int, forces: FloatArray) -> FloatArray:
        """Geometric stiffness (l, n, n) of axial forces (l, m, 6) in a bar, in any pose."""
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
        free = self._left_free(constraints, own)
        result = np.zeros((self.n_unknowns, free.shape[1]))
        result[own] = free
        return result

    def _left_free(self, constraints: FloatArray, own: IntArray) -> FloatArray:
        """Motions (m, k) of some unknowns (m,) alone that leave constraints (r, n) at zero."""
        scale = np.where(own % 6 < 3, 1.0, 1 / self.size)
        rows = constraints[:, own] * scale
        lengths = np.linalg.norm(rows, axis=1)
        free = _left_free(rows[lengths > 0] / lengths[lengths > 0, None])
        return scale[:, None] * free

    def unit_motions(self, constraints: FloatArray, plane: Sequence[int]) -> Sequence[FloatArray]:
        """Motions (m, k) of a plane's m unknowns, combined to make their stiffness the unit matrix.

        One for each of many positions, whose constraints (p, r, n) they leave at zero. Raises
        LooseFrameError if something moves without strain.
        """
        own = self.unknowns(plane)
        held = constraints[..., own].any(axis=(0, 1))
        inner = _inner(tuple(self.links), tuple(plane), held.tobytes())
        free = None if inner is None else self._all_left_free(constraints, own[held])
        found = None if inner is None or free is None else inner.unit_motions(free)
        if found is not None:
            return list(found)
        stiffness = self.stiffness[np.ix_(own, own)]
        motions = []
        for number, rows in enumerate(constraints):
            inside = self.at(number)._left_free(rows, own)
            motions.append(inside @ whitening(inside.T @ stiffness @ inside))
        return motions

    def _all_left_free(self, constraints: FloatArray, own: IntArray) -> FloatArray | None:
        """Motions (p, m, k) as `_left_free`, for many positions at once.

        None where constraints (p, r, n) of a position imply each other.
        """
        scale = np.where(own % 6 < 3, 1.0, 1 / self.size[:, None])
        rows = constraints[..., own] * scale[:, None]
        lengths = np.linalg.norm(rows, axis=-1)
        some = (lengths > 0).any(axis=0)
        count = int(some.sum())
        if count > len(own) or not (lengths[:, some] > 0).all():
            return None
        unit = rows[:, some] / lengths[:, some, None]
        turned, upper = np.linalg.qr(np.swapaxes(unit, 1, 2), mode="complete")
        values = np.linalg.svd(upper[:, :count], compute_uv=False)
        if not (values[:, -1] > _REDUNDANT * values[:, 0]).all():
            return None
        return np.asarray(scale[..., None] * turned[..., count:])

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


@dataclass(frozen=True, eq=False)
class Inner:
    """Unknowns that no constraint holds, i of n, and their tie to the b held ones.

    held     (n,) true for the b unknowns that constraints hold
    outer    (b, b) stiffness of those
    scale    (i,) factors of the others that make their stiffness ones on its diagonal
    unit     (i, i) combinations of the others whose stiffness is the unit matrix
    size     its squares, rows over `scale`, summed
    reach    (i, b) unit' times the stiffness between both
    """

    held: BoolArray
    outer: FloatArray
    scale: FloatArray
    unit: FloatArray
    size: float
    reach: FloatArray

    def unit_motions(self, free: FloatArray) -> FloatArray | None:
        """Motions (..., n, m) whose stiffness is the unit matrix, for free ones (..., b, k).

        Those are of the held unknowns, in one pose or many. None where it takes more than this to
        tell if something moves without strain.
        """
        own = np.swapaxes(free, -1, -2) @ self.outer @ free
        diagonal = np.diagonal(own, axis1=-2, axis2=-1)
        if not (diagonal > 0).all():
            return None
        scale = 1 / np.sqrt(diagonal)
        moved = free * scale[..., None, :]
        across = self.reach @ moved
        tied = scale[..., :, None] * own * scale[..., None, :]
        try:
            root = np.swapaxes(lower_inverse(tied - np.swapaxes(across, -1, -2) @ across), -1, -2)
        except np.linalg.LinAlgError:
            return None
        carried = -self.unit @ (across @ root)
        size = self.size + (root**2).sum(axis=(-2, -1))
        size += ((carried / self.scale[:, None]) ** 2).sum(axis=(-2, -1))
        count, further = len(self.scale), root.shape[-1]
        if not (size * (count + further) * MECHANISM < 1).all():  # as `fem.frame.whitening`
            return None
        result = np.zeros((*free.shape[:-2], len(self.held), count + further))
        result[..., ~self.held, :count] = self.unit
        result[..., ~self.held, count:] = carried
        result[..., self.held, count:] = moved @ root
        return result


def inner_unknowns(stiffness: FloatArray, held: BoolArray) -> Inner | None:
    """Return the unknowns of a stiffness (n, n) that are not held; None where they are loose."""
    free = ~held
    try:
        scaled, scale = unit_diagonal(stiffness[np.ix_(free, free)])
        inverse = lower_inverse(scaled)
    except (LooseFrameError, np.linalg.LinAlgError):
        return None
    unit, size = scale[:, None] * inverse.T, float((inverse**2).sum())
    reach = unit.T @ stiffness[np.ix_(free, held)]
    return Inner(held, stiffness[np.ix_(held, held)], scale, unit, size, reach)


@lru_cache(maxsize=32)
def _inner(links: tuple[Link, ...], plane: tuple[int, ...], held: bytes) -> Inner | None:
    """Unknowns of a plane that no joint holds, by the bytes of those that any does."""
    stiffness = _stiffness(links)
    own = _in_plane(len(stiffness), plane)
    return inner_unknowns(stiffness[np.ix_(own, own)], np.frombuffer(held, dtype=bool))


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


def _turn(angle: FloatArray) -> FloatArray:
    """Matrices (..., 2, 2) that turn by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def _turned(angle: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by angles (...)."""
    return np.asarray((_turn(angle) @ vectors[..., None])[..., 0])


def _along(direction: FloatArray, rows: FloatArray) -> FloatArray:
    """The row (..., 1, n) of motions (..., 2, n) along a direction (..., 2)."""
    return np.asarray(direction[..., None, :] @ rows)


def pin(a: Motion, b: Motion, axis: FloatArray | None = None) -> FloatArray:
    """Rows (..., r, n) of a hinge about z; its fork holds both tilts, or that about `axis`.

    axis  (..., 2)
    """
    apart = b.rows - a.rows
    if axis is None:
        return np.asarray(apart[..., :5, :])
    unit = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.concatenate([apart[..., :3, :], _along(unit, apart[..., 3:5, :])], axis=-2)


def slide(a: Motion, b: Motion, normal: FloatArray, held: Sequence[int] = ()) -> FloatArray:
    """Rows (..., r, n) of a point b that stays on a line; `held` are other motions against a.

    normal  (..., 2) of the line
    held    0 .. 5
    """
    apart = b.rows - a.rows
    return np.concatenate([_along(normal, apart[..., :2, :]), apart[..., list(held), :]], axis=-2)


def dead_force(at: Motion, force: FloatArray) -> FloatArray:
    """Geometric stiffness (..., n, n) of a force (..., 2) that keeps its direction, at its arm."""
    form = np.zeros((*np.broadcast_shapes(force.shape, at.arm.shape)[:-1], 3, 3))
    product = force[..., :, None] * at.arm[..., None, :]
    form[..., :2, :2] = -(product + np.swapaxes(product, -1, -2)) / 2
    form += np.sum(force * at.arm, axis=-1)[..., None, None] * np.eye(3)
    return _form_of(at.rows[..., 3:, :], form)


def following_force(a: Motion, b: Motion, tension: FloatArray | float) -> FloatArray:
    """Geometric stiffness (..., n, n) of forces between two points, N, that pull above 0."""
    span = b.place - a.place
    square = np.sum(span**2, axis=-1)[..., None, None]
    across = np.zeros((*span.shape[:-1], 3, 3))
    across[..., :2, :2] = -span[..., :, None] * span[..., None, :] / square
    across += np.eye(3)
    force = np.asarray(tension)[..., None, None] / np.sqrt(square)
    return _form_of((b.rows - a.rows)[..., :3, :], force * across)


def slot_force(a: Motion, b: Motion, normal: FloatArray, force: FloatArray | float) -> FloatArray:
    """Geometric stiffness (..., n, n) of forces (...) along a line's normal (..., 2), on b.

    The line is of a, and turns with it: to second order the gap also is
    (t x normal) . (u_b - u_a).
    """
    x, y = normal[..., 0], normal[..., 1]
    cross = np.zeros((*normal.shape[:-1], 3, 3))  # t x normal
    cross[..., 0, 2], cross[..., 1, 2] = -y, x
    cross[..., 2, 0], cross[..., 2, 1] = y, -x
    turned = np.asarray(force)[..., None, None] * (cross @ a.rows[..., 3:, :])
    half = -np.swapaxes(turned, -1, -2) @ (b.rows - a.rows)[..., :3, :]
    return np.asarray(half + np.swapaxes(half, -1, -2))


def _form_of(rows: FloatArray, form: FloatArray) -> FloatArray:
    """Rows' form rows (..., n, n) of rows (..., 3, n) and a form (..., 3, 3)."""
    return np.asarray(np.swapaxes(rows, -1, -2) @ form @ rows)
