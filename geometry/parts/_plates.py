"""Plates with holes, which several parts share."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geometry.shape import faces_where


def stadium(gmsh: Any, start: float, stop: float, width: float, thickness: float) -> int:
    """Tag of a plate along x from `start` to `stop` with half-round ends, z = 0 its middle."""
    occ = gmsh.model.occ
    half, low = width / 2, -thickness / 2
    near, far = start + half, stop - half

    def point(x: float, y: float) -> int:
        return int(occ.addPoint(x, y, low))

    corners = [point(near, -half), point(far, -half), point(far, half), point(near, half)]
    middles = {x: point(x, 0) for x in (near, far)}
    extremes = {"start": point(start, 0), "stop": point(stop, 0)}
    curves = [
        occ.addLine(corners[0], corners[1]),
        occ.addCircleArc(corners[1], middles[far], extremes["stop"]),
        occ.addCircleArc(extremes["stop"], middles[far], corners[2]),
        occ.addLine(corners[2], corners[3]),
        occ.addCircleArc(corners[3], middles[near], extremes["start"]),
        occ.addCircleArc(extremes["start"], middles[near], corners[0]),
    ]
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    extruded = occ.extrude([(2, face)], 0, 0, thickness)
    return next(int(tag) for dimension, tag in extruded if dimension == 3)


def drill(gmsh: Any, x: float, diameter: float, through: float) -> tuple[int, int]:
    """Solid of a hole along z at (x, 0), through anything that is `through` thick."""
    occ = gmsh.model.occ
    return 3, occ.addCylinder(x, 0, -through, 0, 0, 2 * through, diameter / 2)


def bore_at(gmsh: Any, x: float, diameter: float) -> list[int]:
    """Tags of the cylindrical faces of a whole hole along z at (x, 0)."""
    radius = diameter / 2
    wanted = (x - radius, -radius, x + radius, radius)
    return faces_where(
        gmsh,
        lambda box, kind: (
            kind == "Cylinder"
            and bool(np.allclose(box[[0, 1, 3, 4]], wanted, rtol=0, atol=1e-4 * diameter))
        ),
    )


# Solids that several parts share.


def square_tube(
    gmsh: Any, start: float, stop: float, width: float, wall: float, radius: float
) -> int:
    """Tag of a square tube along x from `start` to `stop`; `radius` rounds its inside, mm."""
    occ = gmsh.model.occ
    outer = occ.addBox(start, -width / 2, -width / 2, stop - start, width, width)
    inner = width - 2 * wall
    if radius:
        face = occ.addRectangle(-inner / 2, -inner / 2, start, inner, inner, roundedRadius=radius)
        occ.rotate([(2, face)], 0, 0, start, 0, 1, 0, 1.5707963267948966)
        occ.translate([(2, face)], start, 0, -start)
        bore = [entity for entity in occ.extrude([(2, face)], stop - start, 0, 0) if entity[0] == 3]
        occ.remove([(2, face)])
    else:
        bore = [(3, occ.addBox(start, -inner / 2, -inner / 2, stop - start, inner, inner))]
    solids, _ = occ.cut([(3, outer)], bore)
    return int(solids[0][1])


# The outline of a turned part in its (radius, z) half-plane.


@dataclass
class Outline:
    """A chain of straight and circular edges, mm; drawn point by point, then turned about z."""

    corners: list[tuple[float, float]] = field(default_factory=list)
    centres: list[tuple[float, float] | None] = field(default_factory=list)

    def line_to(self, radius: float, z: float) -> None:
        """Go straight to a point; a step of no length is left out."""
        self._add((radius, z), None)

    def arc_to(self, radius: float, z: float, centre: tuple[float, float]) -> None:
        """Go along a circle to a point."""
        self._add((radius, z), centre)

    def _add(self, corner: tuple[float, float], centre: tuple[float, float] | None) -> None:
        if self.corners:
            if np.allclose(self.corners[-1], corner, rtol=0, atol=1e-9):
                return
            self.centres.append(centre)
        self.corners.append(corner)

    def revolve(self, gmsh: Any) -> int:
        """Close the outline, turn it about z in gmsh's current model, return the solid's tag."""
        occ = gmsh.model.occ
        points = [occ.addPoint(radius, 0, z) for radius, z in self.corners]
        following = [*points[1:], points[0]]
        curves = []
        for first, last, centre in zip(points, following, [*self.centres, None], strict=True):
            if centre is None:
                curves.append(occ.addLine(first, last))
            else:
                middle = occ.addPoint(centre[0], 0, centre[1])
                curves.append(occ.addCircleArc(first, middle, last))
        face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
        turned = occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, 2 * np.pi)
        return next(int(tag) for dimension, tag in turned if dimension == 3)
