"""From the lines of a drawing to an outline: chains that close, nested, or why they do not."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.biarcs import Row
from geometry.mesh import FloatArray, IntArray
from geometry.outlines import Contour, Edges, OutlineError, PlateOutline

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
