"""The outline of a turned part in its (radius, z) half-plane."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np


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
