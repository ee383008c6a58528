"""Smooth curves as arcs: two that share a tangent between any two points, as many as it takes.

Between p with tangent t and q with tangent s stand two arcs that meet at (p + q + d (t - s))/2 with
one tangent, d the way to their control points: d (v.(t + s)) + d^2 (1 - t.s) = v.v/2 with v = q - p
(Bolton, Biarc curves, Computer-Aided Design 7 (1975) 89, gives the family; d alike on both sides).
"""

from collections.abc import Callable
from math import atan2, sqrt, tan

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
