"""Outline of a lever: round eyes about its pins, joined by their common tangents, and fillets.

Neighbouring eyes of radii a and b at p and q, at the distance c, have on the left of the way from
p to q the common tangent with the normal n, (q - p).n/c = (a - b)/c =: s, so that n = u (s + i w),
w^2 = 1 - s^2, u the unit vector from p to q: it touches at p + a n and q + b n.

Where the lever turns at an eye, its two tangents on the outer side leave an arc of the eye between
them. On the inner side they cross before they touch it, r tan(turn/2) away; the corner there is
rounded by a fillet that touches both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import sqrt, tan

import numpy as np

from geometry.outlines import Contour, PlateOutline, bulge_of
from geometry.parameters import ParameterError, check_above

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
