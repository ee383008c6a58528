"""Where a point of a part is, as an engineer says it: "knee bore, edge at the outer face"."""

from collections.abc import Iterable
from math import acos, degrees, hypot

import numpy as np

from geometry.mesh import FloatArray, Interface

_AT_END = 0.02  # of a surface's depth: how near its end counts as its edge
_NEAR = 0.005  # of the way between two interfaces: a place as near as that is at one
_ALONG = 30.0  # deg from a line, within which a side of a bore faces along it
_OUTER_EDGE = " edge"  # ends the name of a lug's outer edge by the rung `formula`
_ON_THE_PIN = " on the pin"  # ends the name of a seat by the rung `formula`


def place_words(
    name: str,
    at: FloatArray,
    depth: tuple[float, float] | None,
    interfaces: Iterable[Interface],
) -> str:
    """Where a point of a part is, in words.

    name        of the surface or section that it is on; of several that meet there, "one/two"
    at          (3,) mm, in the part's own axes
    depth       least and largest |z| of that surface on the point's side, mm; None if not known
    interfaces  of the part: bores, seats, faces
    """
    by_name = {one.name: one for one in interfaces}
    seats = [one.removesuffix(_ON_THE_PIN) for one in name.split("/")]
    own = next((by_name[seat] for seat in seats if seat in by_name), None)
    end = _end(depth, abs(float(at[2])))
    others = [one for one in by_name.values() if one is not own and one.kind != "slide"]
    if own is not None and own.kind == "journal":
        return f"seat of {own.name}{', at its edge' if end else ''}"
    if own is not None and own.kind == "bore":
        edge = [f"edge at the {end}"] if end else []
        return ", ".join([f"{own.name} bore", *edge, *_side(own, at, others)])
    if (bore := name.removesuffix(_OUTER_EDGE)) in by_name:
        return f"outer edge beside the {bore} bore"
    return ", ".join([name, *_between(at, others)])


def coordinates(at: FloatArray) -> str:
    """A place (3,), mm, to tenths."""
    x, y, z = (f"{round(float(value), 1) + 0.0:.1f}" for value in at)
    return f"({x}, {y}, {z})"


def _end(depth: tuple[float, float] | None, height: float) -> str:
    """Which end of a surface's depth a height over the middle plane is at; "" between, or unknown.

    A surface through the middle plane has a depth from 0 on.
    """
    if depth is None:
        return ""
    low, high = depth
    near = _AT_END * (high - low)
    if height >= high - near:
        return "outer face" if low > near else "face"
    return "inner face" if low > near and height <= low + near else ""


def _side(own: Interface, at: FloatArray, others: list[Interface]) -> list[str]:
    """The side of a bore, by the line from its middle to the farthest other interface."""
    lines = [(other.centre - own.centre)[:2] for other in others]
    arm = (at - own.centre)[:2]
    k = max(range(len(lines)), key=lambda k: hypot(*lines[k]), default=-1)
    if k < 0 or not hypot(*lines[k]) * hypot(*arm):
        return []
    cosine = float(arm @ lines[k]) / (hypot(*arm) * hypot(*lines[k]))
    angle = degrees(acos(min(1.0, max(-1.0, cosine))))
    if angle <= _ALONG:
        return [f"towards {others[k].name}"]
    if angle >= 180.0 - _ALONG:
        return [f"away from {others[k].name}"]
    return [f"{angle:.0f} deg from the line to {others[k].name}"]


def _between(at: FloatArray, others: list[Interface]) -> list[str]:
    """How far along the line from the first interface to the second; [] outside of it."""
    if len(others) < 2:
        return []
    first, second = others[:2]
    line = second.centre - first.centre
    length = float(line @ line)
    share = float((at - first.centre) @ line) / length if length else -1.0
    if not _NEAR <= share <= 1.0 - _NEAR:
        return []
    return [f"{100 * share:.0f} % of the way from {first.name} to {second.name}"]


def depth_of(z: FloatArray, at: float) -> tuple[float, float]:
    """Lowest and highest distance (n,) from the middle plane, of what is on the side of `at`."""
    side = np.abs(z[z >= 0] if at >= 0 else z[z <= 0])
    return float(side.min()), float(side.max())
