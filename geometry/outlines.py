"""Plane outlines of straight and circular edges: moments, sections across them, sides of a section.

A contour is a closed chain of edges, each from one corner to the next: straight, or an arc of the
angle theta by its bulge tan(theta/4) as DXF has it, above 0 where it turns counter-clockwise.
Points are complex numbers x + i y, mm. With h = (1 - b^2)/(4 b) an arc from p to q of bulge b has
its centre at (p + q)/2 + i h (q - p).

Integrals over an area are those of its boundary by Green's theorem, of x^m y^n by x^(m+1) y^n/(m+1)
along y, with Gauss' rule on every edge: exact on straight ones, to round-off on arcs up to a half
circle, into which longer ones are cut.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, pi, tan
from typing import Self

import numpy as np

from geometry.mesh import BoolArray, FloatArray, IntArray

ComplexArray = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]

_GAUSS = np.polynomial.legendre.leggauss(20)
_CHORD = 0.1  # rad, of the straight pieces of an arc by which crossing contours are found
_ON_CORNER = 1e-9  # of a contour's size: a section through a corner is taken so far beside it
_SAME = 1e-7  # of a radius: edges of one circle
_ROWS = 256  # sides of a polygon that are compared at a time


class OutlineError(ValueError):
    """An outline that bounds no plate.

    at  x + i y, mm, where
    """

    def __init__(self, problem: str, at: complex) -> None:
        super().__init__(problem, at)
        self.problem, self.at = problem, at

    def __str__(self) -> str:
        return f"{self.problem} at ({self.at.real:.6g}, {self.at.imag:.6g}) mm"


@dataclass(frozen=True)
class Moments:
    """Integrals over an area.

    area    mm2
    first   mm3, of x and of y
    second  mm4, of x^2, x y and y^2
    """

    area: float
    first: tuple[float, float]
    second: tuple[float, float, float]

    @classmethod
    def of(cls, values: FloatArray) -> Self:
        """Moments of 1, x, y, x^2, x y and y^2, (6,)."""
        area, x, y, xx, xy, yy = (float(value) for value in values)
        return cls(area, (x, y), (xx, xy, yy))

    @property
    def centre(self) -> complex:
        """Centre of the area, mm."""
        return complex(*self.first) / self.area

    @property
    def polar(self) -> float:
        """Second moment about the area's own centre, of the distance squared, mm4."""
        return self.second[0] + self.second[2] - self.area * abs(self.centre) ** 2


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges in a row, (n,): where they start and end, and their bulges."""

    starts: ComplexArray
    ends: ComplexArray
    bulges: FloatArray

    @property
    def curved(self) -> BoolArray:
        """True (n,) for arcs."""
        return np.asarray(self.bulges != 0.0)

    @cached_property
    def angles(self) -> FloatArray:
        """Angles (n,) that the edges turn by, rad; 0 of straight ones."""
        return np.asarray(4 * np.arctan(self.bulges))

    @cached_property
    def centres(self) -> ComplexArray:
        """Centres (n,) of the arcs; without meaning for straight edges."""
        bulge = np.where(self.curved, self.bulges, 1.0)
        height = (1 - bulge**2) / (4 * bulge)
        return np.asarray((self.starts + self.ends) / 2 + 1j * height * (self.ends - self.starts))

    @cached_property
    def radii(self) -> FloatArray:
        """Radii (n,) of the arcs, mm; infinite of straight edges."""
        return np.where(self.curved, np.abs(self.starts - self.centres), inf)

    def at(self, share: FloatArray) -> ComplexArray:
        """Points (n, k) at shares (k,) or (n, k) of the edges' lengths."""
        turned = np.exp(1j * self.angles[:, None] * share)
        arc = self.centres[:, None] + (self.starts - self.centres)[:, None] * turned
        line = self.starts[:, None] + (self.ends - self.starts)[:, None] * share
        return np.where(self.curved[:, None], arc, line)

    def part(self, index: int, first: float, last: float) -> tuple[complex, complex, float]:
        """Start, end and bulge of one edge between two shares of its length."""
        ends = self.at(np.array([first, last]))[index]
        return complex(ends[0]), complex(ends[1]), tan(self.angles[index] * (last - first) / 4)

    def integrals(self) -> FloatArray:
        """Green's integrals (6,) of 1, x, y, x^2, x y and y^2 along the edges."""
        total = np.zeros(6)
        pieces = np.where(np.abs(self.bulges) > 1.0, 2, 1)
        for cuts in (1, 2):
            own = pieces == cuts
            if not own.any():
                continue
            some = Edges(self.starts[own], self.ends[own], self.bulges[own])
            for k in range(cuts):
                total += _along(some, k / cuts, (k + 1) / cuts)
        return total

    def crossings(self, point: complex, along: complex) -> tuple[FloatArray, IntArray, FloatArray]:
        """Where the edges cross the line through a point, across the unit vector `along`.

        Returns (m,) distances from the point along i `along`, rising, mm; the number of the edge,
        and the share of its length. Edges that end on the line make no sense: move the point.
        """
        turned = (self.starts - point) * np.conj(along), (self.ends - point) * np.conj(along)
        low, high = turned[0].real, turned[1].real
        straight = np.flatnonzero(~self.curved & ((low > 0) != (high > 0)))
        share = low[straight] / (low[straight] - high[straight])
        at = turned[0][straight] + share * (turned[1][straight] - turned[0][straight])
        places, numbers, shares = [at.imag], [straight], [share]
        centre = (self.centres - point) * np.conj(along)
        met = np.flatnonzero(self.curved & (np.abs(centre.real) < self.radii))
        reach = np.sqrt(self.radii[met] ** 2 - centre.real[met] ** 2)
        for sign in (-1.0, 1.0):
            arm = -centre.real[met] + 1j * sign * reach  # from the centre to the line
            turn = np.angle(arm / (turned[0][met] - centre[met]))
            angle = self.angles[met]
            turn = np.where(angle > 0, turn % (2 * pi), -((-turn) % (2 * pi)))
            inside = np.abs(turn) < np.abs(angle)
            places.append((centre.imag[met] + sign * reach)[inside])
            numbers.append(met[inside])
            shares.append((turn / angle)[inside])
        s, k, u = (np.concatenate(lists) for lists in (places, numbers, shares))
        order = np.argsort(s)
        return s[order], k[order].astype(np.int64), u[order]

    def box(self) -> tuple[complex, complex]:
        """Lower left and upper right corner of the box around them, mm."""
        points = [self.starts, self.ends]
        for way in (1, 1j, -1, -1j):
            turn = np.angle(way / (self.starts - self.centres)[self.curved])
            angle = self.angles[self.curved]
            turn = np.where(angle > 0, turn % (2 * pi), -((-turn) % (2 * pi)))
            far = self.centres[self.curved] + way * self.radii[self.curved]
            points.append(far[np.abs(turn) < np.abs(angle)])
        every = np.concatenate(points)
        x, y = every.real, every.imag
        return complex(x.min(), y.min()), complex(x.max(), y.max())

    def flat(self) -> ComplexArray:
        """Points of a polygon (m,) along the edges, arcs in pieces of at most 0.1 rad."""
        found = []
        for k, angle in enumerate(self.angles):
            count = max(1, int(np.ceil(abs(angle) / _CHORD)))
            found.append(self.at(np.arange(count) / count)[k])
        return np.concatenate(found)


def _along(edges: Edges, first: float, last: float) -> FloatArray:
    """Green's integrals (6,) along a share of every edge."""
    point, weight = _GAUSS
    share = first + (last - first) * (point + 1) / 2
    z = edges.at(share)
    span = edges.ends - edges.starts
    turning = 1j * edges.angles[:, None] * (z - edges.centres[:, None])
    rate = np.where(edges.curved[:, None], turning, span[:, None]).imag
    dy = rate * weight * (last - first) / 2
    x, y = z.real, z.imag
    kinds = (x, x**2 / 2, x * y, x**3 / 3, x**2 * y / 2, x * y**2)
    return np.array([float((kind * dy).sum()) for kind in kinds])


@dataclass(frozen=True)
class Contour:
    """A closed contour, counter-clockwise: corners (n,), and the bulge (n,) of the edge after each.

    Raises OutlineError for one that has no area or goes through itself.
    """

    corners: tuple[tuple[float, float], ...]
    bulges: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.corners) != len(self.bulges):
            raise ValueError(f"{len(self.corners)} corners have {len(self.bulges)} bulges")
        if len(self.corners) < 2 or self.area <= 0:
            raise OutlineError("a contour encloses no area", self.start)

    @classmethod
    def round(cls, centre: complex, radius: float) -> Self:
        """A circle."""
        return cls.of((centre + radius, centre - radius), (1.0, 1.0))

    @classmethod
    def of(cls, corners: Sequence[complex], bulges: Sequence[float]) -> Self:
        """A contour, counter-clockwise, whose corners are complex numbers."""
        return cls(tuple((z.real, z.imag) for z in map(complex, corners)), tuple(bulges))

    @classmethod
    def either_way(cls, corners: Sequence[complex], bulges: Sequence[float]) -> Self:
        """A contour that is given in either sense."""
        ends = np.array(corners, dtype=complex)
        edges = Edges(ends, np.roll(ends, -1), np.array(bulges, dtype=float))
        if edges.integrals()[0] >= 0:
            return cls.of(corners, bulges)
        turned = [-bulge for bulge in reversed(bulges)]
        return cls.of(corners[::-1], (*turned[1:], turned[0]))

    @property
    def start(self) -> complex:
        """The first corner."""
        return complex(*self.corners[0])

    @cached_property
    def edges(self) -> Edges:
        """The edges in a row."""
        x, y = np.array(self.corners, dtype=float).T
        corners = x + 1j * y
        return Edges(corners, np.roll(corners, -1), np.array(self.bulges, dtype=float))

    @property
    def area(self) -> float:
        """Area inside, mm2."""
        return float(self.edges.integrals()[0])

    @cached_property
    def circle(self) -> tuple[complex, float] | None:
        """Centre and radius, mm, of a contour that is one circle; None of another."""
        edges = self.edges
        if not edges.curved.all() or (edges.bulges < 0).any():
            return None
        centre, radius = complex(edges.centres[0]), float(edges.radii[0])
        apart = np.abs(edges.centres - centre).max() + np.abs(edges.radii - radius).max()
        return (centre, radius) if apart < _SAME * radius else None

    @cached_property
    def flat(self) -> ComplexArray:
        """A polygon (m,) nearly along it."""
        return self.edges.flat()

    def placed(self, origin: complex, turn: complex, *, mirrored: bool = False) -> Self:
        """The contour seen from a frame with its origin and x axis there, perhaps from below."""
        moved = [complex(z) for z in (self.edges.starts - origin) / turn]
        if mirrored:
            return self.either_way(
                [corner.conjugate() for corner in moved], [-bulge for bulge in self.bulges]
            )
        return self.of(moved, self.bulges)

    def contains(self, point: complex) -> bool:
        """True for a point inside."""
        return _inside(self.edges, point)


def _inside(edges: Edges, point: complex) -> bool:
    """True where a ray from a point leaves a closed row of edges once more than it enters."""
    size = float(np.ptp(np.concatenate([edges.starts.real, edges.starts.imag]))) or 1.0
    while (np.abs((edges.starts - point).imag) < 1e-12 * size).any():
        point += 1j * _ON_CORNER * size
    # the line through the point along x: across -i, whose i times is +1
    places, _, _ = edges.crossings(point, -1j)
    return bool(np.count_nonzero(places > 0) % 2)


@dataclass(frozen=True, eq=False)
class Cut:
    """A straight section across a plate that parts it in two.

    point, along  mm, on the section, and the unit vector normal to it
    spans         (m, 2) mm, from where to where it runs through material, along i `along`
    ahead         moments of the part of the plate that lies ahead, on the side of `along`
    boundary      edges around that part, without inner contours
    """

    point: complex
    along: complex
    spans: FloatArray
    ahead: Moments
    boundary: Edges

    @property
    def ends(self) -> tuple[float, float]:
        """First and last place in material, mm."""
        return float(self.spans[0, 0]), float(self.spans[-1, 1])

    def is_ahead(self, point: complex) -> bool:
        """True for a point on the side of `along`."""
        return _inside(self.boundary, point)


@dataclass(frozen=True)
class PlateOutline:
    """One outer contour and what is cut out of it.

    Raises OutlineError where contours cross themselves or each other, or one is not inside.
    """

    outer: Contour
    inner: tuple[Contour, ...] = ()

    def __post_init__(self) -> None:
        contours = (self.outer, *self.inner)
        for contour in contours:
            _check_simple(contour.flat)
        for k, contour in enumerate(self.inner):
            at = contour.start
            if not self.outer.contains(at):
                raise OutlineError("a contour lies outside of the outermost one", at)
            for other in self.inner[:k]:
                if other.contains(at) or contour.contains(other.start):
                    raise OutlineError("a contour lies inside of one that is cut out", at)
        for k, contour in enumerate(contours):
            for other in contours[:k]:
                _check_apart(contour.flat, other.flat)

    @cached_property
    def moments(self) -> Moments:
        """Moments of the plate's area."""
        total = self.outer.edges.integrals()
        for contour in self.inner:
            total = total - contour.edges.integrals()
        return Moments.of(total)

    @cached_property
    def size(self) -> float:
        """Largest size along an axis, mm."""
        low, high = self.outer.edges.box()
        return float(max((high - low).real, (high - low).imag))

    def placed(self, origin: complex, turn: complex, *, mirrored: bool = False) -> Self:
        """The outline seen from a frame with its origin and x axis there, perhaps from below."""
        return type(self)(
            self.outer.placed(origin, turn, mirrored=mirrored),
            tuple(contour.placed(origin, turn, mirrored=mirrored) for contour in self.inner),
        )

    def reach(self, point: complex, way: complex) -> float:
        """Way from a point inside to the outer contour, mm, along a unit vector.

        The shorter one of both sides of a way that meets a corner.
        """
        found = []
        for at in self._beside(point, -1j * way):
            places, _, _ = self.outer.edges.crossings(at, -1j * way)
            ahead = places[places > 0]
            found.append(float(ahead[0]) if len(ahead) else 0.0)
        return min(found)

    def _beside(self, point: complex, along: complex) -> Iterator[complex]:
        """Points so near that no corner lies on the sections through them, on either side."""
        corners = np.concatenate([contour.edges.starts for contour in (self.outer, *self.inner)])
        away = np.abs(((corners - point) * np.conj(along)).real) / self.size
        if away.min() >= 1e-12:
            yield point
            return
        for step in (_ON_CORNER * self.size * along, -_ON_CORNER * self.size * along):
            at = point + step
            while (np.abs(((corners - at) * np.conj(along)).real) < 1e-12 * self.size).any():
                at += step
            yield at

    def cut(self, point: complex, along: complex) -> Cut | None:
        """The section through a point inside, across a unit vector.

        Of the two at a corner or an edge across, where the width may step, the narrower one. None
        where the point is outside of the outer contour.
        """
        return _narrower(self, point + 0.0, along / abs(along) + 0.0)  # + 0.0: none is -0.0

    def _cut(self, point: complex, along: complex) -> Cut | None:
        """The section through a point, on which no corner lies."""
        edges = self.outer.edges
        places, numbers, shares = edges.crossings(point, along)
        after = int(np.searchsorted(places, 0.0))
        if after % 2 == 0 or after >= len(places):
            return None
        low, high = places[after - 1], places[after]
        first, last = ((int(numbers[k]), float(shares[k])) for k in (after - 1, after))
        rows = list(_between(edges, first, last))
        across = 1j * along
        rows.append((point + high * across, point + low * across, 0.0))
        boundary = _edges(rows)
        total = boundary.integrals()
        gaps: list[tuple[float, float]] = []
        for contour in self.inner:
            cutting = contour.edges.crossings(point, along)
            inside = (cutting[0] > low) & (cutting[0] < high)
            if not inside.any():
                if _inside(boundary, contour.start):
                    total = total - contour.edges.integrals()
                continue
            total = total - _ahead_of(contour.edges, point, along, cutting)
            gaps += zip(cutting[0][::2].tolist(), cutting[0][1::2].tolist(), strict=True)
        walls = np.array([low, *(place for gap in sorted(gaps) for place in gap), high])
        return Cut(point, along, walls.reshape(-1, 2), Moments.of(total), boundary)


@lru_cache(maxsize=2048)  # a plate is cut alike for its stress on every arc, and as a link
def _narrower(outline: PlateOutline, point: complex, along: complex) -> Cut | None:
    """The section as `PlateOutline.cut` has it, whose arrays are shared."""
    cuts = [outline._cut(at, along) for at in outline._beside(point, along)]
    met = [found for found in cuts if found is not None]
    return min(met, key=lambda found: float(np.diff(found.spans).sum()), default=None)


def _edges(rows: Iterable[tuple[complex, complex, float]]) -> Edges:
    starts, ends, bulges = zip(*rows, strict=True)
    return Edges(np.array(starts), np.array(ends), np.array(bulges, dtype=float))


def _between(
    edges: Edges, first: tuple[int, float], last: tuple[int, float]
) -> Iterator[tuple[complex, complex, float]]:
    """Edges of a closed row from one place (number, share) on to another."""
    (k, start), (end, stop) = first, last
    if k == end and start < stop:
        yield edges.part(k, start, stop)
        return
    yield edges.part(k, start, 1.0)
    k = (k + 1) % len(edges.bulges)
    while k != end:
        yield complex(edges.starts[k]), complex(edges.ends[k]), float(edges.bulges[k])
        k = (k + 1) % len(edges.bulges)
    yield edges.part(k, 0.0, stop)


def _ahead_of(
    edges: Edges, point: complex, along: complex, cutting: tuple[FloatArray, IntArray, FloatArray]
) -> FloatArray:
    """Green's integrals (6,) of what a contour, counter-clockwise, has ahead of a line."""
    places, numbers, shares = cutting
    order = np.lexsort((shares, numbers))  # along the contour
    spots = [(int(numbers[k]), float(shares[k])) for k in order]
    rows: list[tuple[complex, complex, float]] = []
    for here, there in zip(spots, [*spots[1:], spots[0]], strict=True):
        pieces = list(_between(edges, here, there))
        middle = _edges(pieces[:1]).at(np.array([0.5]))[0, 0]
        if ((middle - point) * np.conj(along)).real > 0:
            rows += pieces
    across = 1j * along
    for low, high in zip(places[::2], places[1::2], strict=True):
        rows.append((point + high * across, point + low * across, 0.0))
    return _edges(rows).integrals()


def _check_simple(polygon: ComplexArray) -> None:
    """Raise OutlineError where a polygon goes through itself."""
    n = len(polygon)
    for i, j, at in _met(polygon, polygon):
        if j - i > 1 and not (i == 0 and j == n - 1):
            raise OutlineError("a contour goes through itself", at)


def _check_apart(one: ComplexArray, other: ComplexArray) -> None:
    for _, _, at in _met(one, other):
        raise OutlineError("two contours cross", at)


def _met(one: ComplexArray, other: ComplexArray) -> Iterator[tuple[int, int, complex]]:
    """Which sides of two polygons meet, and where."""
    after, c, d = np.roll(one, -1), other[None, :], np.roll(other, -1)[None, :]
    for first in range(0, len(one), _ROWS):
        a, b = (ends[first : first + _ROWS, None] for ends in (one, after))
        span, back = b - a, d - c
        turn = _cross(span, back)
        safe = np.where(turn == 0, 1.0, turn)
        t, u = _cross(c - a, back) / safe, _cross(c - a, span) / safe
        met = (turn != 0) & (t >= 0) & (t <= 1) & (u >= 0) & (u <= 1)
        for i, j in np.argwhere(met):
            yield first + int(i), int(j), complex(a[i, 0] + t[i, j] * span[i, 0])


def _cross(one: ComplexArray, other: ComplexArray) -> FloatArray:
    return np.asarray((np.conj(one) * other).imag)


def bulge_of(start: complex, end: complex, centre: complex) -> float:
    """Bulge of the counter-clockwise arc about a centre from one point to another."""
    return tan(float(np.angle((end - centre) / (start - centre))) % (2 * pi) / 4)
