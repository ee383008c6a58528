"""A flat plate with any outline and any number of pins: a lever, a bell crank, a drawn part."""

from cmath import phase
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from math import degrees, hypot, sqrt, tan
from typing import Any, ClassVar

import numpy as np

from geometry.bars import (
    BESIDE,
    Bar,
    RulingSection,
    Section,
    Sections,
    Walls,
    plate_section,
    rectangle,
    stretches,
)
from geometry.mesh import FloatArray, Interface
from geometry.outlines import Contour, Edges, PlateOutline, bulge_of
from geometry.parameters import ParameterError, check_above
from geometry.shape import Body, Region, Shape, faces_where

_BORE_ELEMENTS = 7.0  # elements along the radius of a bore
_FILLET_ELEMENTS = 2.0  # along the radius of a hollow edge
_FINEST = 8.0  # times smaller than in general at the most, before any error is known
_QUARTER = (
    0.42  # bulge of an arc a little longer than a quarter: longer ones are cut for the kernel
)
_NEAR = 1e-4  # of a radius: how exactly faces are found
_STATIONS = 65  # heights of a link, between which they are straight
_STATED = 1e-3  # mm, how exactly points are usually stated
_STRAIGHT = 1e-3  # of the bores' distance: how far the sections of a column may lie beside it
_BESIDE = 32  # sections within a height on either side of one
_PLACES = 100  # along an arm, of which the nearest that may have a weld is told
_TAPER = 0.25  # slope of an edge up to which a section has the stress of an even bar

Pair = tuple[float, float]


@dataclass(frozen=True)
class PlateBore:
    """A hole of a plate in which a pin sits.

    diameter  mm
    at        mm, its middle in the plate's frame
    """

    name: str
    diameter: float
    at: Pair

    @property
    def centre(self) -> complex:
        """The middle as a complex number."""
        return complex(*self.at)


@dataclass(frozen=True)
class Plate(Shape):
    """Flat plate of one thickness; its holes for pins stand along z, z = 0 is its middle plane.

    The first bore's middle is the origin and the second bore stands on +x. Plates are mounted side
    by side, so that their pins also tilt in the holes.

    bores    at least two; each is one of the outline's inner contours
    outline  in the plate's frame, mm
    moved    mm, bore -> from its point of the linkage to where the plate has it
    notes    on how its drawing was read, for reports

    Raises ParameterError for a thickness or bores that no plate has.
    """

    middle_plane: ClassVar[bool] = True

    outline: PlateOutline
    bores: tuple[PlateBore, ...]
    thickness: float
    moved: tuple[tuple[str, Pair], ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_above("thickness", self.thickness, 0)
        if len(self.bores) < 2:
            raise ParameterError("holes", f"needs at least two holes, got {len(self.bores)}")
        circles = [contour.circle for contour in self.outline.inner]
        for bore in self.bores:
            if not any(
                circle is not None
                and abs(circle[0] - bore.centre) <= _STATED
                and abs(2 * circle[1] - bore.diameter) <= _STATED
                for circle in circles
            ):
                raise ParameterError(
                    f"holes.{bore.name}", f"is no round hole of the plate: {bore.diameter:g} mm"
                )

    @property
    def shifts(self) -> Mapping[str, Pair]:
        """Bore -> mm, from its point of the linkage to where the plate has it."""
        return dict(self.moved)

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the bores; the first two make the frame."""
        return tuple(bore.name for bore in self.bores)

    @property
    def length(self) -> float:
        """Distance of the first two bores, mm."""
        return abs(self.bores[1].centre - self.bores[0].centre)

    @cached_property
    def neighbours(self) -> tuple[tuple[int, int], ...]:
        """Pairs of bores that are joined: the shortest lines that hold all of them together."""
        count = len(self.bores)
        lines = sorted(
            (round(abs(self.bores[i].centre - self.bores[j].centre), 9), i, j)
            for i, j in combinations(range(count), 2)
        )
        group = list(range(count))
        found = []
        for _, i, j in lines:
            if group[i] != group[j]:
                found.append((i, j))
                group = [group[i] if one == group[j] else one for one in group]
        return tuple(sorted(found))

    def link(self, poisson_ratio: float) -> Bar | None:
        """The plate from its first bore to its last, where all stand on its own middle line."""
        places = sorted(bore.at[0] for bore in self.bores)
        stations = np.linspace(places[0], places[-1], _STATIONS)
        walls = [self._walls(float(x)) for x in stations]
        aside = max(abs(bore.at[1]) for bore in self.bores)
        if aside > _STATED or any(w is None or abs(w[0] + w[1]) > _STATED for w in walls):
            return None
        heights = np.array([w[1] - w[0] for w in walls if w is not None])

        def at(x: FloatArray) -> Sections:
            return rectangle(np.interp(x, stations, heights), self.thickness)

        cuts = tuple(places)
        return Bar(cuts, at)

    def _walls(self, x: float) -> Pair | None:
        """Lower and upper y of the section at x, mm; None where the line leaves the plate."""
        cut = self.outline.cut(complex(x, 0.0), 1)
        return None if cut is None else cut.ends

    @property
    def sections(self) -> Sequence[Section]:
        """Sections of a straight bar between two bores; none of another plate."""
        return self._column[0]

    @property
    def net_section(self) -> float | None:
        """Least area beside the holes of two bores, mm2."""
        cuts = [self.outline.cut(bore.centre, 1) for bore in self.bores]
        areas = [self.thickness * float(np.diff(cut.spans).sum()) for cut in cuts if cut]
        return min(areas, default=None) if len(self.bores) == 2 else None

    @cached_property
    def _column(self) -> tuple[Sequence[Section], str]:
        """Its sections as a column, or why it is none, in words."""
        if len(self.bores) != 2:
            return (), "it has more than two holes"
        if self.windows:
            return (), "a window is cut out of it"
        start, stop = self.bores[0].diameter / 2, self.length - self.bores[1].diameter / 2
        edges = self.outline.outer.edges
        # corners, middles of edges, and where arcs come nearest to the line of the holes
        marks = np.append(edges.at(np.array([0.0, 0.5])).real, edges.centres[edges.curved].real)
        even = np.linspace(start, stop, _STATIONS + 2)[1:-1]
        places = np.union1d(even, marks[(marks > start) & (marks < stop)])
        walls = [self._walls(float(x)) for x in places]
        known = np.array([w for w in walls if w is not None])
        if not start < stop or len(known) < len(walls):
            return (), "the line between its holes leaves it"
        aside = float(np.abs(known.sum(axis=1)).max()) / 2
        if aside > _STRAIGHT * self.length:
            return (), f"its sections lie up to {aside:.2g} mm beside the line of its holes"
        heights, thick = np.ptp(known, axis=1), np.full(len(known), self.thickness)
        own = rectangle(heights, thick)
        values = np.stack([own.area, own.inertia_z, own.inertia_y], axis=1)
        moved = [complex(*dict(self.moved).get(bore.name, (0.0, 0.0))) for bore in self.bores]
        apart = self.bores[1].centre - moved[1] - self.bores[0].centre + moved[0]
        return stretches(places, values, np.stack([heights, thick], axis=1), abs(apart)), ""

    def beyond(self, bore: PlateBore, towards: PlateBore) -> tuple[int, ...]:
        """Bores that hang on a neighbour of a bore, itself included."""
        start, found = self.bores.index(bore), [self.bores.index(towards)]
        for k in found:
            for pair in self.neighbours:
                if k in pair:
                    other = pair[1 - pair.index(k)]
                    if other != start and other not in found:
                        found.append(other)
        return tuple(found)

    @cached_property
    def longest_way(self) -> tuple[int, ...]:
        """Bores along the longest way from neighbour to neighbour."""
        ways: list[tuple[int, ...]] = [(k,) for k in range(len(self.bores))]
        for way in ways:
            for pair in self.neighbours:
                if way[-1] in pair:
                    other = pair[1 - pair.index(way[-1])]
                    if other not in way:
                        ways.append((*way, other))

        def length(way: tuple[int, ...]) -> float:
            places = [self.bores[k].centre for k in way]
            return round(sum(abs(b - a) for a, b in pairwise(places)), 9)

        return max(ways, key=lambda way: (length(way), [-k for k in way]))

    @cached_property
    def bend(self) -> float:
        """Largest turn at a bore of the longest way, deg."""
        places = [self.bores[k].centre for k in self.longest_way]
        steps = [b - a for a, b in pairwise(places)]
        return max((abs(degrees(phase(b / a))) for a, b in pairwise(steps)), default=0.0)

    def walls_across(self, at: float, between: Sequence[str]) -> Walls:
        """The section across the line from one bore to its neighbour, `at` mm from the first.

        Raises ParameterError where its stress is not a bar's: beside the plate, nearer to a hole
        than 1.25 of its heights, or where an edge within its height is not nearly along the line.
        """
        arms = [f"{self.bores[i].name} and {self.bores[j].name}" for i, j in self.neighbours]
        pairs = [{self.bores[i].name, self.bores[j].name} for i, j in self.neighbours]
        names = tuple(between) or (self.interfaces if len(self.bores) == 2 else ())
        if set(names) not in pairs:
            told = f"got {' and '.join(names)}" if names else "so state it"
            raise ParameterError(
                "between", f"must be two neighbouring holes: {', '.join(arms)}; {told}"
            )
        first, last = (self.bores[self.interfaces.index(name)].centre for name in names)
        way, apart = (last - first) / abs(last - first), abs(last - first)
        if not 0 <= at <= apart:
            told = f"beyond {names[1]}, which is {apart:.6g} mm from {names[0]}"
            raise ParameterError("at", f"{at:g} mm lies {told if at > 0 else f'before {names[0]}'}")
        found = self._bar_at(first + at * way, way)
        if isinstance(found, str):
            step = max(1.0, round(apart / _PLACES))
            for one in sorted(np.arange(0.0, apart, step), key=lambda place: abs(place - at)):
                if not isinstance(self._bar_at(first + one * way, way), str):
                    told = f"the nearest place where it is: {one:g} mm"
                    break
            else:
                told = f"it is nowhere from {names[0]} to {names[1]}"
            raise ParameterError("at", f"at {at:g} mm {found}; {told}")
        section = plate_section("arm", found, self.thickness)
        across = first + at * way, way
        return Walls("flat", found, self.thickness, (at, at), section, across=across)

    def _bar_at(self, point: complex, way: complex) -> float | str:
        """Height of the section across a way; or why its stress is not a bar's, in words."""
        cut = self.outline.cut(point, way)
        if cut is None or len(cut.spans) > 1:
            where = "beside the plate" if cut is None else "at a hole"
            return f"the stress is not that of a bar: the section is {where}"
        height = cut.ends[1] - cut.ends[0]
        for contour in self.outline.inner:
            middle = contour.circle[0] if contour.circle else contour.flat
            gap = float(np.abs(middle - point).min())
            if gap < BESIDE * height:
                return (
                    f"the stress is not that of a bar: a hole is {gap:.4g} mm away; it must be at "
                    f"least {BESIDE:g} heights, {BESIDE * height:.4g} mm"
                )
        for step in height * np.linspace(-1.0, 1.0, _BESIDE):
            near = self.outline.cut(point + step * way, way)
            aside = np.inf if near is None else np.abs(np.subtract(near.ends, cut.ends)).max()
            if aside > _TAPER * abs(step):
                return (
                    f"the stress is not that of a bar: an edge within its height of {height:.4g} "
                    f"mm is steeper than 1 to {1 / _TAPER:g}"
                )
        return float(height)

    def hollow_edges(self, shares: Sequence[float]) -> Iterator[tuple[complex, complex, float]]:
        """Points at shares of every hollow arc of the outer contour, its centre and angle, rad."""
        edges = self.outline.outer.edges
        for k in np.flatnonzero(edges.bulges < 0):
            for point in edges.at(np.array(shares))[k]:
                yield complex(point), complex(edges.centres[k]), float(abs(edges.angles[k]))

    @property
    def proportions(self) -> Mapping[str, float]:
        """Bores over their ligaments, thickness over bores, arms over eyes, fillets over depths."""
        eyes = {
            bore.name: 2
            * min(self.outline.reach(bore.centre, 1j**k) for k in np.arange(0, 4, 0.25))
            for bore in self.bores
        }
        holes = [bore.diameter for bore in self.bores]
        arms = [abs(self.bores[j].centre - self.bores[i].centre) for i, j in self.neighbours]
        found = {
            "hole / eye": max(bore.diameter / eyes[bore.name] for bore in self.bores),
            "thickness / hole": self.thickness / min(holes),
            "length / eye": min(arms) / max(eyes.values()),
            "least eye / largest eye": min(eyes.values()) / max(eyes.values()),
        }
        fillets = []
        for point, centre, _ in self.hollow_edges((0.5,)):
            inward = (point - centre) / abs(point - centre)
            depth = self.outline.reach(point + 1e-6 * inward * abs(point - centre), inward)
            fillets.append(abs(point - centre) / depth if depth else 1.0)
        if self.bend > 1.0:
            found["bend, deg"] = self.bend
        if fillets:
            found["fillet / depth"] = min(fillets)
        return found

    @cached_property
    def windows(self) -> tuple[Contour, ...]:
        """Inner contours that are no bores."""
        middles = [bore.centre for bore in self.bores]
        return tuple(
            contour
            for contour in self.outline.inner
            if contour.circle is None
            or min(abs(contour.circle[0] - middle) for middle in middles) > _STATED
        )

    @cached_property
    def stressed_section(self) -> Pair:
        """Height and thickness in mm, for Marin's size factor: its highest section.

        Of those across the lines between neighbouring bores, through the bores and between them.
        """
        heights = [0.0]
        for i, j in self.neighbours:
            first, last = self.bores[i].centre, self.bores[j].centre
            for share in (0.0, 0.25, 0.5, 0.75, 1.0):
                cut = self.outline.cut(first + share * (last - first), last - first)
                if cut is not None:
                    heights.append(cut.ends[1] - cut.ends[0])
        return max(heights) or self.outline.size, self.thickness

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""
        return (RulingSection(self.thickness),)

    def bore_key(self, interface: str) -> str:
        """Key of the part's entry that states a bore's diameter."""
        return f"holes.{interface}.diameter"

    @property
    def told(self) -> tuple[str, ...]:
        """Notes on its drawing and on checks that it does not have: sentences for the report."""
        said = list(self.notes)
        why = self._column[1]
        if why:
            said.append(f"no column formula judged it, so yield was not checked by one: {why}")
        for name, (x, y) in self.moved:
            if hypot(x, y) > _STATED:
                said.append(
                    f"{name} is {hypot(x, y):.2g} mm from where the linkage has it; its force acts "
                    "in the hole, with the couple that balances it"
                )
        return tuple(said)

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [
            Interface(
                bore.name,
                "bore",
                np.array([*bore.at, 0.0]),
                bore.diameter / 2,
                self.thickness,
                tilts=True,
            )
            for bore in self.bores
        ]

    def build(self, gmsh: Any) -> Body:
        """Build the plate in gmsh's current model."""
        occ = gmsh.model.occ
        low = -self.thickness / 2
        loops = [_loop(occ, self.outline.outer.edges, low)]
        for contour in self.outline.inner:
            if contour.circle is None:
                loops.append(_loop(occ, contour.edges, low))
                continue
            (centre, radius) = contour.circle
            loops.append(occ.addCurveLoop([occ.addCircle(centre.real, centre.imag, low, radius)]))
        occ.extrude([(2, occ.addPlaneSurface(loops))], 0, 0, self.thickness)
        occ.synchronize()
        return self.named(gmsh)

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole plate or its half at z >= 0."""
        bores = {bore.name: _faces_in(gmsh, bore.centre, bore.diameter / 2) for bore in self.bores}
        size = self._size
        return Body(
            surfaces=bores,
            interfaces=self.placed_interfaces,
            size=size,
            regions=[
                *(
                    Region(
                        [(2, tag) for tag in bores[bore.name]],
                        min(bore.diameter / 2 / _BORE_ELEMENTS, size),
                        bore.diameter / 2,
                    )
                    for bore in self.bores
                ),
                *self._hollow_regions(gmsh, size),
            ],
        )

    @property
    def _size(self) -> float:
        """General element size, mm: of a strip as wide as its area is over its half girth."""
        edges = self.outline.outer.edges
        straight = np.abs(edges.ends - edges.starts)
        girth = np.where(
            edges.curved, np.abs(edges.angles) * np.abs(_finite(edges.radii)), straight
        )
        width = 2 * self.outline.moments.area / float(girth.sum())
        return min(width / 4, max(self.thickness / 2, width / 8))

    def _hollow_regions(self, gmsh: Any, size: float) -> list[Region]:
        """Hollow edges that are sharper than the elements, but for the bores."""
        groups: dict[float, list[tuple[int, int]]] = {}
        for low, high, radius in self._hollow():
            wanted = max(radius / _FILLET_ELEMENTS, size / _FINEST)
            if wanted >= size:
                continue
            near = _NEAR * radius + 1e-6
            box = np.array([low.real, low.imag, high.real, high.imag])

            def on_it(
                found: FloatArray, kind: str, box: FloatArray = box, near: float = near
            ) -> bool:
                return kind == "Cylinder" and bool(
                    np.allclose(found[[0, 1, 3, 4]], box, rtol=0, atol=near)
                )

            tags = [(2, tag) for tag in faces_where(gmsh, on_it)]
            if tags:
                groups.setdefault(round(wanted, 3), []).extend(tags)
        return [Region(tags, wanted, 2 * wanted) for wanted, tags in sorted(groups.items())]

    def _hollow(self) -> Iterator[tuple[complex, complex, float]]:
        """Corners of the boxes around hollow arcs, as the kernel has them, and their radii."""
        outer, sign = self.outline.outer, -1.0
        for contour in (outer, *self.windows):
            sign = -1.0 if contour is outer else 1.0
            if contour.circle is not None and contour is not outer:
                centre, radius = contour.circle
                reach = complex(radius, radius)
                yield centre - reach, centre + reach, radius
                continue
            edges = contour.edges
            for k in np.flatnonzero(sign * edges.bulges > 0):
                for piece in _arcs(edges, int(k)):
                    yield *piece.box(), float(edges.radii[k])


def as_plate(shape: Shape) -> Plate | None:
    """Return a shape that is a plate of any outline; None for another."""
    return shape if isinstance(shape, Plate) else None


def _finite(radii: FloatArray) -> FloatArray:
    return np.where(np.isfinite(radii), radii, 0.0)


def _arcs(edges: Edges, k: int) -> list[Edges]:
    """The pieces, at most a quarter of a circle, in which the kernel has an edge."""
    count = max(1, int(np.ceil(abs(edges.angles[k]) / (4 * np.arctan(_QUARTER)))))
    rows = [edges.part(k, n / count, (n + 1) / count) for n in range(count)]
    return [Edges(*(np.array([value]) for value in row)) for row in rows]


def _loop(occ: Any, edges: Edges, z: float) -> int:
    """Curve loop of a closed row of edges at a height, in gmsh's kernel."""
    points: dict[complex, int] = {}

    def point(place: complex) -> int:
        if place not in points:
            points[place] = int(occ.addPoint(place.real, place.imag, z))
        return points[place]

    curves = []
    corners = [complex(start) for start in edges.starts]
    for k, corner in enumerate(corners):
        last = corners[(k + 1) % len(corners)]
        if not edges.curved[k]:
            curves.append(occ.addLine(point(corner), point(last)))
            continue
        centre = complex(edges.centres[k])
        middle = occ.addPoint(centre.real, centre.imag, z)
        pieces = _arcs(edges, k)
        ends = [corner, *(complex(piece.starts[0]) for piece in pieces[1:]), last]
        for n in range(len(pieces)):
            curves.append(occ.addCircleArc(point(ends[n]), middle, point(ends[n + 1])))
    return int(occ.addCurveLoop(curves))


def _faces_in(gmsh: Any, centre: complex, radius: float) -> list[int]:
    """Tags of the cylindrical faces of a whole hole."""
    wanted = (
        centre.real - radius, centre.imag - radius, centre.real + radius, centre.imag + radius
    )  # fmt: skip
    return faces_where(
        gmsh,
        lambda box, kind: (
            kind == "Cylinder"
            and bool(np.allclose(box[[0, 1, 3, 4]], wanted, rtol=0, atol=2 * _NEAR * radius + 1e-6))
        ),
    )


# Outline of a lever: round eyes about its pins, joined by their common tangents, and fillets.
#
# Neighbouring eyes of radii a and b at p and q, at the distance c, have on the left of the way from
# p to q the common tangent with the normal n, (q - p).n/c = (a - b)/c =: s, so that
# n = u (s + i w), w^2 = 1 - s^2, u the unit vector from p to q: it touches at p + a n and q + b n.
#
# Where the lever turns at an eye, its two tangents on the outer side leave an arc of the eye
# between them. On the inner side they cross before they touch it, r tan(turn/2) away; the corner
# there is rounded by a fillet that touches both.
_STRAIGHT = 1e-9  # rad, of turning that needs neither arc nor fillet


@dataclass(frozen=True)
class Eye:
    """An eye of a lever about one of its pins: names, and mm."""

    name: str
    centre: complex
    hole: float
    diameter: float


def lever_outline(eyes: Sequence[Eye], fillet: float | None) -> PlateOutline:
    """The lever's outline along its eyes, in their order, with its holes.

    fillet  mm, radius on the inner side of every bend

    Raises ParameterError, its field a key of the lever, for eyes that cannot be joined so.
    """
    if len(eyes) < 2:
        raise ParameterError("holes", f"needs at least two holes, got {len(eyes)}")
    for eye in eyes:
        check_above(f"holes.{eye.name}.diameter", eye.hole, 0)
        check_above(f"holes.{eye.name}.eye", eye.diameter, eye.hole)
    for one, other in pairwise(eyes):
        apart = abs(other.centre - one.centre)
        if not apart > (one.diameter + other.diameter) / 2:
            raise ParameterError(
                f"holes.{other.name}.eye",
                f"{other.diameter:g} mm meets the eye of {one.name}, {one.diameter:g} mm: their "
                f"pins are {apart:.6g} mm apart",
            )
    there = _side(eyes, fillet)
    back = _side(eyes[::-1], fillet)
    corners, bulges = [], []
    for side, eye in ((there, eyes[-1]), (back, eyes[0])):
        corners += [corner for corner, _ in side]
        bulges += [bulge for _, bulge in side]
        bulges[-1] = bulge_of(side[-1][0], (back if side is there else there)[0][0], eye.centre)
    holes = tuple(Contour.round(eye.centre, eye.hole / 2) for eye in eyes)
    return PlateOutline(Contour.of(corners, bulges), holes)


def _side(eyes: Sequence[Eye], fillet: float | None) -> list[tuple[complex, float]]:
    """Corners along the right of the way past the eyes, with the bulge of the edge after each.

    On the right, so that a lever that is walked round there and back has its material on the left.
    """
    lines = []
    for one, other in pairwise(eyes):
        way = other.centre - one.centre
        share = (one.diameter - other.diameter) / 2 / abs(way)
        normal = way / abs(way) * (share - 1j * sqrt(1 - share**2))
        lines.append((one.centre + one.diameter / 2 * normal, normal,
                      other.centre + other.diameter / 2 * normal))  # fmt: skip
    found = [(lines[0][0], 0.0)]
    for k, ((start, before, end), (begin, after, _)) in enumerate(pairwise(lines), 1):
        turn = float(np.angle(after / before))
        if abs(turn) < _STRAIGHT:
            continue
        if turn > 0:  # the outer side of the bend: round the eye
            found += [(end, tan(turn / 4)), (begin, 0.0)]
            continue
        name = eyes[k].name
        if fillet is None or not fillet > 0:
            raise ParameterError(
                "fillet",
                f"must be stated: at {name} the lever has a re-entrant corner, whose stress has no "
                "end without one",
            )
        half = tan(-turn / 2)
        corner = end - 1j * before * half * eyes[k].diameter / 2
        first, last = corner - 1j * before * half * fillet, corner + 1j * after * half * fillet
        _check_room(name, fillet, half, corner, start, lines[k][2])
        found += [(first, tan(turn / 4)), (last, 0.0)]
    return [*found, (lines[-1][2], 0.0)]


def _check_room(
    name: str, fillet: float, half: float, corner: complex, start: complex, end: complex
) -> None:
    room = min(abs(corner - start), abs(end - corner))
    if fillet * half > room:
        raise ParameterError(
            "fillet",
            f"{fillet:g} mm does not fit at {name}: it must be at most {room / half:.6g} mm",
        )
