"""Plates with holes, which several parts share."""

from typing import Any

import numpy as np

from geometry.meshing import faces_where


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
