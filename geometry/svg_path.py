"""Outlines from the path of an SVG drawing, the text of its attribute `d`."""

import re
from cmath import phase
from collections.abc import Iterator
from itertools import pairwise
from math import ceil, cos, hypot, pi, radians, sin, sqrt, tan

from geometry.drawings import Chain, DrawingError, Drawn, Row, as_arcs, outline_of, told_place

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
        return _arc(here, end, *numbers[:5])
    ends = [here, *points]

    def at(u: float) -> tuple[complex, complex]:
        level, slope = ends, 0j
        while len(level) > 1:
            if len(level) == 2:
                slope = (len(ends) - 1) * (level[1] - level[0])
            level = [a + u * (b - a) for a, b in pairwise(level)]
        return level[0], slope

    return as_arcs(at, 0.0, 1.0)


def _arc(
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
