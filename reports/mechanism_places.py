"""Places of a mechanism's picture: ends of forces, entries of torques, outlines of bodies."""

from math import cos, hypot, pi, sin
from typing import Any

from loads import Angle, Fixed, Linkage, Revolute
from reports.loads_figures import FloatArray


def both_ends(force: Any) -> tuple[tuple[str, str], ...]:
    """Body and point of either end of a force between two points."""
    span = force.coordinate
    return (span.body_a, span.point_a), (span.body_b, span.point_b)


def same(first: tuple[float, float], second: tuple[float, float]) -> bool:
    """Return True if two places, mm, are the same within 1e-6 mm."""
    return hypot(first[0] - second[0], first[1] - second[1]) < 1e-6


def entry(linkage: Linkage, coordinate: Any) -> tuple[str, str]:
    """Body and point at which a torque is drawn: where it enters, else the body's first point."""
    assert isinstance(coordinate, Angle)
    points = linkage.body(coordinate.body).points
    return coordinate.body, coordinate.point or next(iter(points))


def at_one_point(joint: Any) -> bool:
    """Return True if a joint is at a point of both bodies, not along a line."""
    return isinstance(joint, Revolute | Fixed)


def arrow_path(ends: FloatArray, tip: float) -> str:
    """Path of an arrow from (x, y) to (x, y); none where it is too short for its tip of a size."""
    x0, y0, x1, y1 = (float(value) for value in ends)
    length = hypot(x1 - x0, y1 - y0)
    if length < 0.4 * tip:
        return ""
    ux, uy = tip * (x1 - x0) / length, tip * (y1 - y0) / length
    sides = ((2 * ux + uy, 2 * uy - ux), (2 * ux - uy, 2 * uy + ux))
    head = "".join(f"M{x1:.5g} {y1:.5g}L{x1 - dx:.5g} {y1 - dy:.5g}" for dx, dy in sides)
    return f"M{x0:.5g} {y0:.5g}L{x1:.5g} {y1:.5g}{head}"


def bent_path(share: float, tip: float) -> str:
    """Path of an arc about the origin, the longer the larger a torque; above 0 it goes ccw."""
    if abs(share) < 0.02:
        return ""
    radius, turn, way = 5 * tip, 1.6 * pi * abs(share), -1.0 if share > 0 else 1.0
    c, s = cos(way * turn), sin(way * turn)
    x, y, ux, uy = radius * c, radius * s, -way * s * tip, way * c * tip
    sides = ((2 * ux + uy, 2 * uy - ux), (2 * ux - uy, 2 * uy + ux))
    head = "".join(f"M{x:.5g} {y:.5g}L{x - dx:.5g} {y - dy:.5g}" for dx, dy in sides)
    flags = f"{int(turn > pi)} {int(way > 0)}"
    return f"M{radius:.5g} 0A{radius:.5g} {radius:.5g} 0 {flags} {x:.5g} {y:.5g}{head}"


def flipped(values: FloatArray) -> FloatArray:
    """Places (n, m, 2 or 4) with the signs of their y changed."""
    result = values.copy()
    result[..., 1::2] *= -1.0
    return result


def hull(points: FloatArray) -> list[tuple[float, float]]:
    """The convex hull of points in order (Andrew's monotone chain); two ends if all are in line."""
    places = sorted({(round(float(x), 9), round(float(y), 9)) for x, y in points})
    if len(places) < 3:
        return places

    def chain(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in ordered:
            while len(kept) > 1:
                (x0, y0), (x1, y1) = kept[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return chain(places) + chain(places[::-1])
