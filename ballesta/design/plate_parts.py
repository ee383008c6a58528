"""Makes a plate from its entry: the outline of a lever or a drawing, and which holes take pins.

A part of a STEP file is made from the file and from where the linkage has its holes.
"""

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from math import atan2, cos, sin
from typing import Any

from ballesta.design.files import Sources
from checks.design.data import Pair, Part
from checks.design.errors import listed, no_such
from checks.design.file_entries import KINDS
from checks.design.model import BeamPartEntry, PlatePartEntry, StepPartEntry
from geometry.drawings import DrawingError, Drawn
from geometry.dxf_file import UNITS, read_dxf, read_svg_path
from geometry.outlines import OutlineError
from geometry.parameters import GIVEN_BY_DESIGN, MOST_CAD, ParameterError, read_bounded
from geometry.parts import Beam, PinHole
from geometry.parts.plate import Eye, Plate, PlateBore, lever_outline
from geometry.parts.step_part import NamedHole, StepPart

_ASIDE = 1e-6  # of a beam's length: how far a pin may stand beside its middle line
_MOST_TOLD = 20  # holes in one message
_BELONGS = {  # keys of the shape's table and of a hole, and the kinds that they belong to
    "fillet": ("lever",),
    "layers": ("dxf",),
    "unit": ("dxf", "svg"),
    "eye": ("lever",),
    "at": ("dxf", "svg"),
    "layer": ("dxf",),
}


def shape_name(entry: PlatePartEntry) -> str:
    """Name of a plate's shape in reports: "lever", its file, or "plate"."""
    if entry.shape.lever is not None:
        return "lever"
    return entry.shape.dxf or "plate"


def plate_geometry(
    key: str,
    entry: PlatePartEntry,
    pins: Sequence[str],
    points: Mapping[str, Pair],
    sources: Sources,
) -> Plate:
    """Return the part's geometry; a drawing's file is added to the sources.

    pins    the body's points in the order in which it states them
    points  of the body, mm

    Raises DesignError for a file that cannot be read, ParameterError where it is not the part.
    """
    kind = _kind(entry)
    if kind == "lever":
        return _lever(entry, points)
    names = sorted(entry.interfaces, key=lambda name: pins.index(entry.interfaces[name]))
    at = {name: points[entry.interfaces[name]] for name in names}
    origin, towards = (at[name] for name in names[:2])
    wanted = {name: complex(*from_frame(origin, towards, place)) for name, place in at.items()}
    try:
        drawn, notes = _drawn(key, entry, kind, sources)
    except DrawingError as error:
        raise ParameterError(f"shape.{kind}", str(error)) from None
    return _Holes(entry, drawn, wanted).plate(notes)


def _kind(entry: PlatePartEntry) -> str:
    """How the outline is drawn; ParameterError for none or several, and keys of another way."""
    shape = entry.shape
    stated = [kind for kind in KINDS if getattr(shape, kind) is not None]
    if len(stated) != 1:
        raise ParameterError("shape", f"needs one of {', '.join(KINDS)}, got {listed(stated)}")
    (kind,) = stated
    tables: list[tuple[str, Any]] = [("shape", shape)]
    tables += [(f"holes.{name}", hole) for name, hole in entry.holes.items()]
    for where, table in tables:
        for name in sorted(table.model_fields_set & _BELONGS.keys()):
            if kind not in _BELONGS[name] and getattr(table, name):
                raise ParameterError(
                    f"{where}.{name}", f"belongs to {' or '.join(_BELONGS[name])}, not to {kind}"
                )
    if kind == "lever" and entry.flip:
        raise ParameterError("flip", "belongs to a drawing: a lever lies as its points do")
    return kind


def _lever(entry: PlatePartEntry, points: Mapping[str, Pair]) -> Plate:
    names = entry.shape.lever or []
    if sorted(names) != sorted(entry.holes):
        wrong = [name for name in names if name not in entry.holes]
        if wrong:
            raise ParameterError("shape.lever", no_such("hole of the part", wrong[0], entry.holes))
        left = [name for name in entry.holes if name not in names]
        told = f"leaves out {listed(left)}" if left else "has one hole twice"
        raise ParameterError("shape.lever", f"{told}: it goes once past every hole")
    at = [points[entry.interfaces[name]] for name in names]
    eyes = []
    for name, place in zip(names, at, strict=True):
        hole = entry.holes[name]
        for field in ("diameter", "eye"):
            if getattr(hole, field) is None:
                raise ParameterError(f"holes.{name}.{field}", "must be stated for a lever")
        centre = complex(*from_frame(at[0], at[1], place))
        eyes.append(Eye(name, _rounded(centre), hole.diameter or 0.0, hole.eye or 0.0))
    try:
        outline = lever_outline(eyes, entry.shape.fillet)
    except OutlineError as error:
        raise ParameterError("shape.lever", f"cannot be drawn: {error}") from None
    except ParameterError as error:
        field = "shape.fillet" if error.field == "fillet" else error.field
        raise ParameterError(field, error.problem) from None
    bores = tuple(PlateBore(eye.name, eye.hole, (eye.centre.real, eye.centre.imag)) for eye in eyes)
    return Plate(outline, bores, entry.thickness)


def beam_geometry(shape: type[Beam], entry: BeamPartEntry, points: Mapping[str, Pair]) -> Beam:
    """Return a beam with its pins where the linkage has them, the outermost two first.

    points  of the body, mm

    Raises ParameterError for pins beside the line from one end to the other.
    """
    at = {name: points[entry.interfaces[name]] for name in entry.holes}

    def apart(pair: tuple[str, str]) -> float:
        (a, b), (c, d) = (at[name] for name in pair)
        return round(abs(complex(a - c, b - d)), 9)

    first, last = max(combinations(at, 2), key=apart)
    places = {
        name: _rounded(complex(*from_frame(at[first], at[last], place)))
        for name, place in at.items()
    }
    length = places[last].real
    for name, place in places.items():
        if abs(place.imag) > _ASIDE * length:
            raise ParameterError(
                f"interfaces.{name}",
                f"sits {abs(place.imag):.6g} mm beside the line from {first} to {last}: a beam is "
                "straight; a `lever` may bend",
            )
    between = sorted((n for n in at if n not in (first, last)), key=lambda n: places[n].real)
    holes = tuple(
        PinHole(name, at=places[name].real, diameter=one.diameter, boss=one.boss)
        for name in (first, last, *between)
        for one in (entry.holes[name],)
    )
    stated = (
        field.name
        for field in dataclasses.fields(shape)
        if field.metadata.get("given_by") == GIVEN_BY_DESIGN
    )
    make: Callable[..., Beam] = shape
    return make(holes=holes, **{name: getattr(entry, name) for name in stated})


def _rounded(place: complex) -> complex:
    """A place to 12 digits: meshing is chaotic, and round-off hangs on how a machine is drawn."""
    size = abs(place) or 1.0
    x, y = (0.0 if abs(value) < 1e-12 * size else float(f"{value:.12g}")
            for value in (place.real, place.imag))  # fmt: skip
    return complex(x, y)


def _drawn(
    key: str, entry: PlatePartEntry, kind: str, sources: Sources
) -> tuple[Drawn, tuple[str, ...]]:
    shape = entry.shape
    if kind == "svg":
        unit = shape.unit or "mm"
        return read_svg_path(shape.svg or "", UNITS[unit]), (f"the path's unit is {unit}",)
    where = f"{key}.shape.dxf"
    add_to_sources(where, shape.dxf or "", sources)
    found = read_dxf(sources.file_of(where).parent / (shape.dxf or ""), shape.unit, shape.layers)
    return found.drawn, found.told


class _Holes:
    """Which of a drawing's round holes the entry means, and where the linkage has them."""

    def __init__(self, entry: PlatePartEntry, drawn: Drawn, wanted: Mapping[str, complex]) -> None:
        self.entry, self.drawn, self.wanted = entry, drawn, wanted
        self.circles = [
            (contour.circle, layer)
            for contour, layer in zip(drawn.outline.inner, drawn.layers[1:], strict=True)
            if contour.circle is not None
        ]

    def plate(self, notes: tuple[str, ...]) -> Plate:
        """The plate in its own frame, its holes where the linkage has them."""
        entry, names = self.entry, list(self.wanted)
        found: dict[str, tuple[complex, float]] = {}
        for name in names:
            circle = self._match(name)
            taken = next((other for other, one in found.items() if one == circle), None)
            if taken is not None:
                raise ParameterError(
                    f"holes.{name}", f"is the same hole as {taken}; {self._told()}"
                )
            found[name] = circle
        first, second = (found[name][0] for name in names[:2])
        turn = (second - first) / abs(second - first)
        places = {name: (centre - first) / turn for name, (centre, _) in found.items()}
        if entry.flip:
            places = {name: place.conjugate() for name, place in places.items()}
        self._check_places(places)
        shifts = tuple(
            (name, (place.real, place.imag))
            for name, place in ((name, places[name] - self.wanted[name]) for name in names)
        )
        outline = self.drawn.outline.placed(first, turn, mirrored=entry.flip)
        bores = tuple(
            PlateBore(name, 2 * found[name][1], (places[name].real, places[name].imag))
            for name in names
        )
        return Plate(outline, bores, entry.thickness, shifts, notes)

    def _match(self, name: str) -> tuple[complex, float]:
        """Centre and radius of the one hole that an entry can mean."""
        hole, tolerance = self.entry.holes[name], self.entry.hole_tolerance
        asked = []
        if hole.diameter is not None:
            asked.append(f"of {hole.diameter:g} mm")
        if hole.at is not None:
            asked.append("at ({:g}, {:g}) mm".format(*hole.at))
        if hole.layer is not None:
            asked.append(f"on layer {hole.layer}")
        if not asked:
            raise ParameterError(
                f"holes.{name}", f"must say which hole it is: diameter, at or layer; {self._told()}"
            )
        fits = [
            (centre, radius)
            for (centre, radius), layer in self.circles
            if (hole.diameter is None or abs(2 * radius - hole.diameter) <= tolerance)
            and (hole.at is None or abs(centre - complex(*hole.at)) <= tolerance)
            and (hole.layer is None or layer.lower() == hole.layer.lower())
        ]
        what = f"round hole {' '.join(asked)}"
        if not fits:
            raise ParameterError(
                f"holes.{name}",
                f"no {what} is in the drawing within {tolerance:g} mm; {self._told()}",
            )
        if len(fits) > 1:
            raise ParameterError(
                f"holes.{name}",
                f"{len(fits)} holes are a {what}: `at` must say which, by its middle in the "
                f"drawing's own frame; {self._told()}",
            )
        return fits[0]

    def _told(self) -> str:
        """All round holes in words."""
        if not self.circles:
            return "the drawing has no round hole"
        more = len(self.circles) - _MOST_TOLD
        rest = f"; and {more} more" if more > 0 else ""
        return (
            "there are "
            + "; ".join(
                f"{2 * radius:.6g} mm at ({centre.real:.6g}, {centre.imag:.6g}) mm"
                + (f" on layer {layer}" if layer else "")
                for (centre, radius), layer in self.circles[:_MOST_TOLD]
            )
            + rest
        )

    def _check_places(self, places: Mapping[str, complex]) -> None:
        tolerance, first = self.entry.hole_tolerance, next(iter(places))
        for number, (name, here) in enumerate(places.items()):
            wanted = self.wanted[name]
            if abs(here - wanted) <= tolerance:
                continue
            if number == 1:
                raise ParameterError(
                    f"holes.{name}",
                    f"is {abs(here):.6g} mm from {first} in the drawing and {abs(wanted):.6g} mm "
                    f"in the linkage, more than {tolerance:g} mm apart"
                    + _unit_hint(abs(wanted), abs(here)),
                )
            hint = ""
            if abs(here.conjugate() - wanted) <= tolerance:
                hint = f"; flip = {str(not self.entry.flip).lower()} puts it there"
            raise ParameterError(
                f"holes.{name}",
                f"is at ({here.real:.6g}, {here.imag:.6g}) mm in the drawing and at "
                f"({wanted.real:.6g}, {wanted.imag:.6g}) mm in the linkage, from {first} with x "
                f"towards {list(places)[1]}{hint}",
            )


def _unit_hint(stated: float, found: float) -> str:
    """Return a hint at mixed-up units if the ratio of two lengths suggests one, else ""."""
    apart = max(stated / found, found / stated)
    for name, size in UNITS.items():
        if size > 1 and abs(apart / size - 1) < 1e-3:
            return f"; {size:g} times apart: were {name} and mm mixed up?"
    return ""


def step_geometry(
    key: str, entry: StepPartEntry, points: Mapping[str, Pair], sources: Sources
) -> StepPart:
    """Return the part's geometry; the STEP file's text is added to the sources.

    Raises DesignError for a file that cannot be read, ParameterError where it is not the part.
    """
    shape = f"{key}.shape.step"
    path = sources.file_of(shape).parent / entry.shape.step
    add_to_sources(shape, entry.shape.step, sources)
    at = [points[point] for point in entry.interfaces.values()]
    return StepPart(
        path=path,
        holes=tuple(
            NamedHole(name, hole.diameter, hole.at, hole.kind)
            for name in entry.interfaces
            for hole in (entry.holes[name],)
        ),
        places=tuple(from_frame(at[0], at[1], point) for point in at),
        tolerance=entry.hole_tolerance,
        flip=entry.flip,
        section=entry.section,
        thickness=entry.thickness,
    )


def told_of_steps(parts: Mapping[str, Part]) -> Iterator[tuple[str, str]]:
    """Reading of each part's STEP file or drawing: its key, and unit and holes in words."""
    for name, part in parts.items():
        yield from ((f"parts.{name}.shape", said) for said in part.geometry.told)


def add_to_sources(key: str, name: str, sources: Sources) -> None:
    """Read a CAD file's text; names in it may be in any encoding, which changes no geometry."""
    path = sources.file_of(key).parent / name
    try:
        text = read_bounded(path, MOST_CAD)
        text.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        if isinstance(error, UnicodeDecodeError):
            sources.texts[path] = text.decode("latin-1")
            return
    sources.read_beside(key, name, MOST_CAD)


def from_frame(origin: Pair, towards: Pair, point: Pair) -> Pair:
    """Return a point in the frame with its x axis from one point towards another."""
    angle = atan2(towards[1] - origin[1], towards[0] - origin[0])
    x, y = point[0] - origin[0], point[1] - origin[1]
    return cos(angle) * x + sin(angle) * y, cos(angle) * y - sin(angle) * x
