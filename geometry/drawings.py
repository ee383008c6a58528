"""From the lines of a drawing to an outline: chains that close, nested, or why they do not.

Smooth curves as arcs: two that share a tangent between any two points, as many as it takes.

Between p with tangent t and q with tangent s stand two arcs that meet at (p + q + d (t - s))/2 with
one tangent, d the way to their control points: d (v.(t + s)) + d^2 (1 - t.s) = v.v/2 with v = q - p
(Bolton, Biarc curves, Computer-Aided Design 7 (1975) 89, gives the family; d alike on both sides).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import atan2, sqrt, tan

import numpy as np

from geometry.mesh import FloatArray, IntArray
from geometry.outlines import Contour, Edges, OutlineError, PlateOutline

Row = tuple[complex, complex, float]  # start, end and bulge of an edge
Curve = Callable[[float], tuple[complex, complex]]  # place and derivative at a parameter

ENOUGH = 5e-3  # mm, from curve to arcs
_DEEPEST = 12  # halvings
_ASKED = (0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9)


def as_arcs(curve: Curve, start: float, stop: float) -> list[Row]:
    """Edges along a curve between two parameters, at most 0.005 mm beside it.

    Raises ValueError for a curve that stands still or turns round at a point.
    """
    return _halved(curve, start, stop, _DEEPEST)


def _halved(curve: Curve, start: float, stop: float, depth: int) -> list[Row]:
    inset = 1e-9 * (stop - start)  # at a knot the tangents of both sides may differ
    (p, _), (q, _) = curve(start), curve(stop)
    rows = _biarc(p, curve(start + inset)[1], q, curve(stop - inset)[1])
    apart = [
        min(_beside(row, curve(start + share * (stop - start))[0]) for row in rows)
        for share in _ASKED
    ]
    if rows and max(apart) <= ENOUGH:
        return rows
    if not depth:
        raise ValueError("it has a corner or stands still within itself")
    middle = (start + stop) / 2
    return _halved(curve, start, middle, depth - 1) + _halved(curve, middle, stop, depth - 1)


def _biarc(p: complex, before: complex, q: complex, after: complex) -> list[Row]:
    if not abs(before) or not abs(after) or p == q:
        raise ValueError("it stands still at a point")
    t, s, v = before / abs(before), after / abs(after), q - p
    along, spare = (v.conjugate() * (t + s)).real, 1 - (t.conjugate() * s).real
    square = abs(v) ** 2
    if spare > 1e-12:
        reach = (-along + sqrt(along**2 + 2 * spare * square)) / (2 * spare)
    elif along > 0:
        reach = square / (2 * along)
    else:
        return [(p, q, 0.0)]
    joint = (p + q + reach * (t - s)) / 2
    return [(p, joint, _bulge(p, joint, t)), (joint, q, -_bulge(q, joint, -s))]


def _bulge(start: complex, end: complex, tangent: complex) -> float:
    """Bulge of the arc that leaves a point along a tangent."""
    way = (end - start) / tangent
    return tan(atan2(way.imag, way.real) / 2)


def _beside(row: Row, point: complex) -> float:
    """Distance of a point from the circle or line of an edge, mm."""
    start, end, bulge = row
    way = end - start
    if abs(bulge) < 1e-9:
        return abs(((point - start) * way.conjugate()).imag) / abs(way)
    centre = (start + end) / 2 + 1j * (1 - bulge**2) / (4 * bulge) * way
    return float(abs(abs(point - centre) - abs(start - centre)))


JOINED = 0.01  # mm: ends that are nearer to each other are one
MOST_EDGES = 2000
_TOLD = 4  # entities in one message


class DrawingError(ValueError):
    """A drawing that is no outline: why, in words that name the entity and where."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Edges of one entity of a drawing, each beginning where the last one ends, mm.

    name   the entity, in words
    layer  that it stands on
    """

    name: str
    layer: str
    rows: Sequence[Row]

    @property
    def ends(self) -> tuple[complex, complex]:
        """Where it begins and ends."""
        return self.rows[0][0], self.rows[-1][1]


@dataclass(frozen=True, eq=False)
class Drawn:
    """An outline, and the layer that each of its contours stands on, the outer one first."""

    outline: PlateOutline
    layers: tuple[str, ...]


def told_place(point: complex) -> str:
    """A place in words."""
    return f"({point.real:.6g}, {point.imag:.6g}) mm"


def outline_of(chains: Sequence[Chain]) -> Drawn:
    """Return the outline that a drawing's lines bound; raises DrawingError."""
    chains = [whole for whole in map(_without_slivers, chains) if whole is not None]
    if not chains:
        raise DrawingError("has no lines that bound a plate")
    count = sum(len(chain.rows) for chain in chains)
    if count > MOST_EDGES:
        raise DrawingError(
            f"has {count} edges, at most {MOST_EDGES} are read: draw curves as arcs or splines"
        )
    found: list[tuple[Contour, list[Chain]]] = []
    for loop in _loops(chains):
        rows = [row for chain in loop for row in chain.rows]
        try:
            contour = Contour.either_way([row[0] for row in rows], [row[2] for row in rows])
        except OutlineError as error:
            raise DrawingError(f"{error} ({_names(loop)})") from None
        found.append((contour, loop))
    found.sort(key=lambda one: -one[0].area)
    try:
        outline = PlateOutline(found[0][0], tuple(contour for contour, _ in found[1:]))
    except OutlineError as error:
        near = _nearest(chains, error.at)
        raise DrawingError(f"{error} ({near.name})") from None
    return Drawn(outline, tuple(loop[0].layer for _, loop in found))


def _without_slivers(chain: Chain) -> Chain | None:
    """The chain without edges shorter than what joins; None where nothing is left."""
    rows: list[Row] = []
    for start, end, bulge in chain.rows:
        if abs(end - start) < JOINED and abs(bulge) < 1:
            continue
        rows.append((rows[-1][1] if rows else start, end, bulge))
    return Chain(chain.name, chain.layer, rows) if rows else None


def _loops(chains: Sequence[Chain]) -> Iterator[list[Chain]]:
    """Chains in rings, each turned so that it begins where the one before ends."""
    ends = np.array([end for chain in chains for end in chain.ends])
    partner = _partners(chains, ends)
    left = set(range(len(chains)))
    while left:
        start = min(left)
        at, loop = 2 * start, []
        while True:
            k, reversed_ = divmod(at, 2)
            left.discard(k)
            loop.append(_turned(chains[k]) if reversed_ else chains[k])
            at = int(partner[at ^ 1])
            if at // 2 == start:
                break
        yield [_joined(chain, loop[n - 1]) for n, chain in enumerate(loop)]


def _partners(chains: Sequence[Chain], ends: FloatArray) -> IntArray:
    """Number of the end that each end (n,) goes on to: 2 k begins chain k, 2 k + 1 ends it."""
    partner = np.full(len(ends), -1)
    for k, end in enumerate(ends):
        apart = np.abs(ends - end)
        apart[k] = np.inf
        near = np.flatnonzero(apart < JOINED)
        chain = chains[k // 2]
        if not len(near):
            nearest = int(np.argmin(apart))
            gap = ""
            if apart[nearest] < np.inf:
                gap = f"; the nearest end is {apart[nearest]:.4g} mm away"
                gap += f", of {chains[nearest // 2].name}"
            raise DrawingError(
                f"the {chain.name} ends at {told_place(complex(end))}, where nothing goes on{gap}: "
                "outlines must be closed within "
                f"{JOINED:g} mm, and lines that bound nothing stand on layers that are not read"
            )
        if len(near) > 1:
            names = dict.fromkeys([chain.name, *(chains[int(n) // 2].name for n in near)])
            raise DrawingError(
                f"{len(near) + 1} ends meet at {told_place(complex(end))}: "
                f"{', '.join(list(names)[:_TOLD])}; an outline goes on to one line only, so one "
                "is drawn twice or bounds nothing"
            )
        partner[k] = near[0]
    return partner


def _turned(chain: Chain) -> Chain:
    rows = [(end, start, -bulge) for start, end, bulge in reversed(chain.rows)]
    return Chain(chain.name, chain.layer, rows)


def _joined(chain: Chain, before: Chain) -> Chain:
    """The chain from where the one before ends."""
    first = (before.ends[1], *chain.rows[0][1:])
    return Chain(chain.name, chain.layer, [first, *chain.rows[1:]])


def _names(loop: Sequence[Chain]) -> str:
    names = list(dict.fromkeys(chain.name for chain in loop))
    more = f" and {len(names) - _TOLD} more" if len(names) > _TOLD else ""
    return ", ".join(names[:_TOLD]) + more


def _nearest(chains: Sequence[Chain], at: complex) -> Chain:
    """The chain that passes nearest to a point."""

    def distance(chain: Chain) -> float:
        starts, ends, bulges = (np.array(column) for column in zip(*chain.rows, strict=True))
        points = Edges(starts, ends, bulges.astype(float)).at(np.linspace(0, 1, 33))
        return float(np.abs(points - at).min())

    return min(chains, key=distance)
