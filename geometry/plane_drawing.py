"""What the outlines of several parts share: holes, half-round ends, curves by their place."""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, Interface
from geometry.meshing import Region
from geometry.plane_outlines import Drawn

AROUND = 36  # elements around a hole on the first mesh
_GROWTH = 0.8  # of the elements' size, per distance from a hole
_SAME = 1e-6  # of a length: how close a curve must be to be the one that is meant
Hole = tuple[str, float, float]  # name of the interface, x and diameter, mm


def even(thickness: float) -> Callable[[FloatArray], FloatArray]:
    """The same thickness everywhere."""
    return lambda points: np.full(len(points), thickness)


def bores(holes: list[Hole], depths: list[float], *, tilts: bool = False) -> list[Interface]:
    """The interfaces of holes whose loaded lengths along z are `depths`, mm."""
    return [
        Interface(name, "bore", np.array([x, 0.0, 0.0]), hole / 2, depth, tilts=tilts)
        for (name, x, hole), depth in zip(holes, depths, strict=True)
    ]


def disks(gmsh: Any, holes: list[Hole]) -> list[tuple[int, int]]:
    """What holes take away."""
    return [(2, gmsh.model.occ.addDisk(x, 0, 0, hole / 2, hole / 2)) for _, x, hole in holes]


def drawn(
    gmsh: Any,
    holes: list[Hole],
    size: float,
    near: list[Region] | None = None,
    curves: dict[str, list[int]] | None = None,
) -> Drawn:
    """What was drawn with holes: their edges named, and small elements around them."""
    edges = {name: curves_on_circle(gmsh, x, 0.0, hole / 2) for name, x, hole in holes}
    around = []
    for name, _, hole in holes:
        fine = pi * hole / AROUND
        reach = max(hole / 2, (size - fine) / _GROWTH)
        around.append(Region([(1, tag) for tag in edges[name]], fine, reach))
    return Drawn(edges | (curves or {}), size, [*around, *(near or [])])


def line(gmsh: Any, *ends: float) -> tuple[int, int]:
    """A line between two points: x, y, x, y."""
    occ = gmsh.model.occ
    return 1, occ.addLine(occ.addPoint(*ends[:2], 0), occ.addPoint(*ends[2:], 0))


def stadium(gmsh: Any, start: float, stop: float, width: float) -> int:
    """Tag of a face along x from `start` to `stop` with half-round ends."""
    occ = gmsh.model.occ
    half = width / 2
    near, far = start + half, stop - half
    corners = [
        occ.addPoint(x, y, 0) for x, y in ((near, -half), (far, -half), (far, half), (near, half))
    ]
    middles = {x: occ.addPoint(x, 0, 0) for x in (near, far)}
    tips = {x: occ.addPoint(x, 0, 0) for x in (start, stop)}
    curves = [
        occ.addLine(corners[0], corners[1]),
        occ.addCircleArc(corners[1], middles[far], tips[stop]),
        occ.addCircleArc(tips[stop], middles[far], corners[2]),
        occ.addLine(corners[2], corners[3]),
        occ.addCircleArc(corners[3], middles[near], tips[start]),
        occ.addCircleArc(tips[start], middles[near], corners[0]),
    ]
    return int(occ.addPlaneSurface([occ.addCurveLoop(curves)]))


def curves_on_circle(gmsh: Any, x: float, y: float, radius: float) -> list[int]:
    """Tags of the curves that lie on a circle."""
    return _curves_where(
        gmsh,
        lambda points: bool(
            (np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius) < _SAME * radius).all()
        ),
    )


def curves_in_box(gmsh: Any, x: tuple[float, float], y: tuple[float, float]) -> list[int]:
    """Tags of the curves that lie between two x and two y, mm."""
    slack = _SAME * max(x[1] - x[0], y[1] - y[0])

    def inside(points: FloatArray) -> bool:
        low, high = np.array([x[0], y[0]]) - slack, np.array([x[1], y[1]]) + slack
        return bool(((points >= low) & (points <= high)).all())

    return _curves_where(gmsh, inside)


def _curves_where(gmsh: Any, test: Callable[[FloatArray], bool]) -> list[int]:
    found = []
    for _, tag in gmsh.model.getEntities(1):
        first, last = (bound[0] for bound in gmsh.model.getParametrizationBounds(1, tag))
        values = gmsh.model.getValue(1, tag, list(np.linspace(first, last, 5)))
        if test(np.asarray(values).reshape(-1, 3)[:, :2]):
            found.append(int(tag))
    return found
