"""Outlines from drawings: DXF files, and the path of an SVG drawing."""

import re
from cmath import phase
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np

from geometry.drawings import Chain, DrawingError, Drawn, Row, as_arcs, outline_of, told_place
from geometry.outlines import bulge_of
from geometry.parameters import MOST_CAD, read_bounded

UNITS = {"in": 25.4, "ft": 304.8, "mm": 1.0, "cm": 10.0, "m": 1000.0}  # in mm
_HEADER = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}  # of $INSUNITS
_SILENT = frozenset(
    ["TEXT", "MTEXT", "ATTDEF", "ATTRIB", "DIMENSION", "ARC_DIMENSION", "LEADER", "MULTILEADER",
     "TOLERANCE", "HATCH", "POINT", "VIEWPORT", "IMAGE", "WIPEOUT"]
)  # fmt: skip
_DEFPOINTS = "defpoints"
_PLANE = 1e-6  # mm, that a line may rise out of the drawing's plane
_DEEPEST = 8  # blocks within blocks
_FULL = 1e-9  # rad, short of a full turn


@dataclass(frozen=True, eq=False)
class DxfDrawing:
    """Outline of a file, mm, and in words the entities that were read and those left out."""

    drawn: Drawn
    told: tuple[str, ...]


def read_dxf(path: Path, unit: str | None = None, layers: Sequence[str] = ()) -> DxfDrawing:
    """Read the outline of a DXF file.

    unit    of the drawing, a key of UNITS, where the file's header states none
    layers  that bound the plate; without it all that are on, but Defpoints

    Raises DrawingError that names the entity and its place for what is no outline.
    """
    document = _document(path)
    scale, said = _unit(document, unit)
    known = {layer.dxf.name.lower(): layer for layer in document.layers}
    entities = list(_entities(document.modelspace(), ""))
    # a layer of which the file's table does not know is there all the same
    there = known.keys() | {str(entity.dxf.layer).lower() for entity, _ in entities}
    for name in layers:
        if name.lower() not in there:
            raise DrawingError(f"has no layer {name!r}; it has {', '.join(sorted(there))}")
    wanted = {name.lower() for name in layers}
    chains: list[Chain] = []
    silent: Counter[str] = Counter()
    for entity, name in entities:
        layer = str(entity.dxf.layer)
        if not _is_read(layer, wanted, known):
            continue
        kind = entity.dxftype()
        if kind in _SILENT:
            silent[kind] += 1
            continue
        if rows := _rows(entity, name, scale):
            chains.append(Chain(f"{name} on layer {layer}", layer, rows))
    try:
        drawn = outline_of(chains)
    except DrawingError as error:
        if not chains and wanted:
            raise DrawingError(f"{error} on layers {', '.join(layers)}") from None
        raise
    told = [said, f"{1 + len(drawn.outline.inner)} contours of {len(chains)} entities"]
    if silent:
        left_out = ", ".join(f"{count} {kind}" for kind, count in sorted(silent.items()))
        told.append(f"not read, as they bound nothing: {left_out}")
    return DxfDrawing(drawn, tuple(told))


def _document(path: Path) -> Any:
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    try:
        read_bounded(path, MOST_CAD)
    except OSError as error:
        raise DrawingError(f"cannot be read: {error.strerror or error}") from None
    try:
        return readfile(path)
    except OSError:
        raise DrawingError("is no DXF file") from None
    except (DXFError, ValueError, KeyError, IndexError, AttributeError) as error:
        raise DrawingError(f"is no whole DXF file: {error}") from None


def _unit(document: Any, unit: str | None) -> tuple[float, str]:
    """Length of the drawing's unit, mm, and who states it."""
    stated = _HEADER.get(int(document.header.get("$INSUNITS", 0)))
    if stated is None and unit is None:
        raise DrawingError(
            f"states no unit that is read ($INSUNITS = {document.header.get('$INSUNITS', 0)}): "
            f"state `unit`, one of {', '.join(UNITS)}"
        )
    if stated is not None and unit is not None and stated != unit:
        raise DrawingError(
            f"is drawn in {stated} by its header ($INSUNITS) and in {unit} by `unit`: leave "
            "`unit` out, or mend the header"
        )
    name = unit or stated or "mm"
    who = "by its header" if stated is not None else "as `unit` states"
    return UNITS[name], f"drawn in {name}, {who}"


def _is_read(layer: str, wanted: set[str], known: Any) -> bool:
    if wanted:
        return layer.lower() in wanted
    entry = known.get(layer.lower())
    hidden = entry is not None and (entry.is_off() or entry.is_frozen())
    return not hidden and layer.lower() != _DEFPOINTS


def _entities(space: Any, owner: str, depth: int = 0) -> Iterator[tuple[Any, str]]:
    """Entities and their names; those of a block stand where its reference puts them."""
    for entity in space:
        handle = f" {entity.dxf.handle}" if entity.dxf.handle else ""
        name = f"{entity.dxftype()}{handle}{owner}"
        if entity.dxftype() != "INSERT":
            yield entity, name
            continue
        if depth == _DEEPEST:
            raise DrawingError(f"the {name} nests blocks more than {_DEEPEST} deep")
        inside = f" of block {entity.dxf.name} (INSERT{handle}{owner})"
        references = entity.multi_insert() if entity.mcount > 1 else [entity]
        for reference in references:
            for own, named in _entities(reference.virtual_entities(), inside, depth + 1):
                if own.dxf.layer == "0":  # layer 0 in a block is the reference's
                    own.dxf.layer = entity.dxf.layer
                yield own, named


def _rows(entity: Any, name: str, scale: float) -> list[Row]:
    """Edges of one entity, mm."""
    from ezdxf.upright import upright

    kind = entity.dxftype()
    if kind in ("ARC", "CIRCLE", "ELLIPSE", "LWPOLYLINE", "POLYLINE"):
        upright(entity)  # drawn from below: turned over where it is the same in the plane
        extrusion = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
        if abs(extrusion[0]) + abs(extrusion[1]) > _PLANE or extrusion[2] < 0:
            raise DrawingError(f"the {name} does not lie in the drawing's plane")
    readers = {
        "LINE": _line,
        "ARC": _arc,
        "CIRCLE": _arc,
        "ELLIPSE": _ellipse,
        "LWPOLYLINE": _light_polyline,
        "POLYLINE": _polyline,
        "SPLINE": _spline,
    }
    if kind not in readers:
        place = _somewhere(entity, scale)
        raise DrawingError(
            f"the {name} on layer {entity.dxf.layer}{place} is nothing that bounds a plate: lines, "
            "arcs, circles, ellipses, polylines and splines do; explode it, or leave its layer out"
        )
    try:
        return [
            (start * scale, end * scale, bulge)
            for start, end, bulge in readers[kind](entity, name, scale)
        ]
    except (ValueError, ZeroDivisionError) as error:
        if isinstance(error, DrawingError):
            raise
        place = _somewhere(entity, scale)
        raise DrawingError(f"the {name}{place} cannot be followed: {error}") from None


def _somewhere(entity: Any, scale: float) -> str:
    """Where an entity begins, in words; nothing where it does not say."""
    for key in ("start", "center", "insert", "location", "vtx0"):
        if entity.dxf.hasattr(key):
            return f" at {told_place(complex(*tuple(entity.dxf.get(key))[:2]) * scale)}"
    points = getattr(entity, "control_points", None)
    if points is not None and len(points):
        return f" at {told_place(complex(*tuple(points[0])[:2]) * scale)}"
    return ""


def _flat(point: Any, name: str, scale: float) -> complex:
    x, y, z = (float(value) for value in (*point, 0.0)[:3])
    if not np.isfinite([x, y, z]).all():
        raise DrawingError(f"the {name} has a coordinate that is no number")
    if abs(z) * scale > _PLANE:
        raise DrawingError(
            f"the {name} stands out of the drawing's plane, by z = {z * scale:.4g} mm at "
            f"{told_place(complex(x, y) * scale)}"
        )
    return complex(x, y)


def _line(entity: Any, name: str, scale: float) -> list[Row]:
    start, end = (_flat(point, name, scale) for point in (entity.dxf.start, entity.dxf.end))
    return [(start, end, 0.0)] if start != end else []


def _arc(entity: Any, name: str, scale: float) -> list[Row]:
    centre, radius = _flat(entity.dxf.center, name, scale), float(entity.dxf.radius)
    if not radius > 0:
        raise DrawingError(
            f"the {name} at {told_place(centre * scale)} has a radius of {radius * scale:g} mm"
        )
    if entity.dxftype() == "CIRCLE":
        return [(centre + radius, centre - radius, 1.0), (centre - radius, centre + radius, 1.0)]
    start, end = (
        centre + radius * np.exp(1j * np.radians(angle))
        for angle in (entity.dxf.start_angle, entity.dxf.end_angle)
    )
    middle = (
        np.radians(entity.dxf.start_angle)
        + np.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360 or 360) / 2
    )
    between = complex(centre + radius * np.exp(1j * middle))
    return [
        (complex(start), between, bulge_of(start, between, centre)),
        (between, complex(end), bulge_of(between, end, centre)),
    ]


def _ellipse(entity: Any, name: str, scale: float) -> list[Row]:
    centre, major = (_flat(entity.dxf.get(key), name, scale) for key in ("center", "major_axis"))
    minor = 1j * major * float(entity.dxf.ratio)
    start, end = float(entity.dxf.start_param), float(entity.dxf.end_param)
    while end <= start + _FULL:
        end += 2 * np.pi

    def at(angle: float) -> tuple[complex, complex]:
        c, s = np.cos(angle), np.sin(angle)
        place = centre + c * major + s * minor
        return place * scale, (c * minor - s * major) * scale

    return _scaled(at, np.linspace(start, end, 5), scale)


def _spline(entity: Any, name: str, scale: float) -> list[Row]:
    curve = entity.construction_tool()
    for point in curve.control_points:
        _flat(point, name, scale)

    def at(parameter: float) -> tuple[complex, complex]:
        place, slope = curve.derivative(parameter, 1)
        return complex(place.x, place.y) * scale, complex(slope.x, slope.y) * scale

    knots = np.array(curve.knots(), dtype=float)
    first, last = knots[curve.order - 1], knots[len(curve.control_points)]
    inside = np.unique(knots[(knots >= first) & (knots <= last)])
    return _scaled(at, inside, scale)


def _scaled(curve: Any, knots: Any, scale: float) -> list[Row]:
    """Edges along a curve that is given in mm, in the drawing's unit."""
    rows: list[Row] = []
    for first, last in pairwise(knots):
        rows += as_arcs(curve, float(first), float(last))
    return [(start / scale, end / scale, bulge) for start, end, bulge in rows]


def _light_polyline(entity: Any, name: str, scale: float) -> list[Row]:
    height = float(entity.dxf.get("elevation", 0.0))
    points = [
        (_flat((x, y, height), name, scale), bulge) for x, y, bulge in entity.get_points("xyb")
    ]
    return _of_points(points, closed=bool(entity.closed), name=name)


def _polyline(entity: Any, name: str, scale: float) -> list[Row]:
    if not (entity.is_2d_polyline or entity.is_3d_polyline):
        raise DrawingError(f"the {name} is a mesh, which bounds no plate")
    points = [
        (_flat(vertex.dxf.location, name, scale), float(vertex.dxf.get("bulge", 0.0)))
        for vertex in entity.vertices
    ]
    return _of_points(points, closed=bool(entity.is_closed), name=name)


def _of_points(points: Sequence[tuple[complex, float]], *, closed: bool, name: str) -> list[Row]:
    if len(points) < 2:
        raise DrawingError(f"the {name} has fewer than two points")
    after = [*points[1:], points[0]]
    rows = [
        (here, there, bulge)
        for (here, bulge), (there, _) in zip(points, after, strict=True)
        if here != there
    ]
    if closed or points[-1][0] == points[0][0]:
        return rows
    return rows[:-1]


# Outlines from the path of an SVG drawing, the text of its attribute `d`.
_TOKEN = re.compile(r"\s*,?\s*([A-Za-z]|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
_COUNT = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_LONGEST = 1_000_000  # letters


def read_svg_path(text: str, scale: float = 1.0) -> Drawn:
    """The outline of a path (SVG 1.1, chapter 8), seen as it is on a screen: y is turned up.

    scale  mm, of one unit of the path

    Raises DrawingError that names the command and its place for what is no outline.
    """
    if len(text) > _LONGEST:
        raise DrawingError(f"has {len(text)} letters, at most {_LONGEST} are read")
    chains: list[Chain] = []
    for number, (start, rows) in enumerate(_subpaths(text), 1):
        if not rows:
            raise DrawingError(f"has a subpath {number} of one point at {_told(start, scale)}")
        end = rows[-1][1]
        if end != start:
            rows.append((end, start, 0.0))
        up = [(a.conjugate() * scale, b.conjugate() * scale, -bulge) for a, b, bulge in rows]
        chains.append(Chain(f"subpath {number}", "", up))
    return outline_of(chains)


def _told(point: complex, scale: float) -> str:
    return told_place(point.conjugate() * scale)


def _commands(text: str) -> Iterator[tuple[str, list[float]]]:
    """Commands with their numbers, repeated ones by the letter that they repeat."""
    at, name = 0, ""
    tokens: list[str] = []
    while at < len(text.rstrip()):
        found = _TOKEN.match(text, at)
        if found is None:
            raise DrawingError(f"cannot be read from letter {at + 1} on: {text[at : at + 12]!r}")
        tokens.append(found[1])
        at = found.end()
    queue = iter(tokens)
    for token in queue:
        if token.isalpha():
            name = token
            if name.upper() not in _COUNT:
                raise DrawingError(f"has {name!r}, which is no command of a path")
            if name.upper() == "Z":
                yield name, []
            continue
        if not name or name.upper() == "Z":
            raise DrawingError(f"has the number {token} where a command begins")
        numbers = [float(token)]
        while len(numbers) < _COUNT[name.upper()]:
            more = next(queue, "")
            if not more or more.isalpha():
                raise DrawingError(
                    f"has {name!r} with {len(numbers)} numbers, it takes {_COUNT[name.upper()]}"
                )
            numbers.append(float(more))
        yield name, numbers
        name = {"M": "L", "m": "l"}.get(name, name)


def _subpaths(text: str) -> Iterator[tuple[complex, list[Row]]]:
    """Starts and edges of subpaths, in the path's unit, y down."""
    here = start = control = 0j
    rows: list[Row] = []
    begun, last = False, ""
    for letter, numbers in _commands(text):
        name = letter.upper()
        base = here if letter.islower() else 0j
        if name == "M":
            if begun:
                yield start, rows
            here = start = base + complex(*numbers)
            rows, begun, last = [], True, name
            continue
        if not begun:
            raise DrawingError(f"begins with {letter!r}: a path begins with M")
        if name == "Z":
            yield start, rows
            here, rows, begun, last = start, [], False, name
            continue
        if name == "H":
            points = [complex(numbers[0] + base.real, here.imag)]
        elif name == "V":
            points = [complex(here.real, numbers[0] + base.imag)]
        elif name == "A":
            points = [base + complex(*numbers[5:])]
        else:
            points = [
                base + complex(*pair) for pair in zip(numbers[::2], numbers[1::2], strict=True)
            ]
        if name in "ST":
            smooth = last in ("CS" if name == "S" else "QT")
            points.insert(0, 2 * here - control if smooth else here)
        try:
            rows += _edges(name, here, points, numbers)
        except ValueError as error:
            raise DrawingError(
                f"has a {letter!r} at {told_place(here.conjugate())} of its units that cannot be "
                f"followed: {error}"
            ) from None
        control = points[-2] if name in "CSQT" else points[-1]
        here, last = points[-1], name
    if begun:
        yield start, rows


def _edges(name: str, here: complex, points: list[complex], numbers: list[float]) -> list[Row]:
    end = points[-1]
    if name in "LHV":
        return [(here, end, 0.0)] if end != here else []
    if name == "A":
        return _svg_arc(here, end, *numbers[:5])
    ends = [here, *points]

    def at(u: float) -> tuple[complex, complex]:
        level, slope = ends, 0j
        while len(level) > 1:
            if len(level) == 2:
                slope = (len(ends) - 1) * (level[1] - level[0])
            level = [a + u * (b - a) for a, b in pairwise(level)]
        return level[0], slope

    return as_arcs(at, 0.0, 1.0)


def _svg_arc(
    start: complex, end: complex, rx: float, ry: float, turn: float, large: float, sweep: float
) -> list[Row]:
    """An elliptical arc by its ends (SVG 1.1, appendix F.6)."""
    if large not in (0.0, 1.0) or sweep not in (0.0, 1.0):
        raise ValueError("the flags of an arc are 0 or 1, with a space between")
    rx, ry = abs(rx), abs(ry)
    if start == end:
        return []
    if not rx or not ry:
        return [(start, end, 0.0)]
    tilt = complex(cos(radians(turn)), sin(radians(turn)))
    half = (start - end) / 2 / tilt
    size = hypot(half.real / rx, half.imag / ry)
    if size > 1:
        rx, ry = rx * size, ry * size
    share = max(1 / min(size, 1.0) ** 2 - 1, 0.0)
    side = 1 if large != sweep else -1
    middle = side * sqrt(share) * complex(rx * half.imag / ry, -ry * half.real / rx)
    first = complex((half - middle).real / rx, (half - middle).imag / ry)
    last = complex((-half - middle).real / rx, (-half - middle).imag / ry)
    angle = phase(last / first) % (2 * pi)
    if not sweep:
        angle -= 2 * pi
    centre, begin = middle * tilt + (start + end) / 2, phase(first)

    def at(u: float) -> tuple[complex, complex]:
        c, s = cos(begin + angle * u), sin(begin + angle * u)
        place = centre + tilt * complex(rx * c, ry * s)
        return place, tilt * complex(-rx * s, ry * c) * angle

    count = ceil(abs(angle) / pi + 1e-12)
    if abs(rx - ry) <= 1e-9 * rx:
        places = [at(k / count)[0] for k in range(count)]
        places = [start, *places[1:], end]
        bulge = tan(angle / count / 4)
        return [(places[k], places[k + 1], bulge) for k in range(count)]
    rows: list[Row] = []
    for k in range(4):
        rows += as_arcs(at, k / 4, (k + 1) / 4)
    return rows
