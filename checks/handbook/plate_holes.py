"""Stress at open holes of bent and pulled plates, and in sections of curved plates."""

from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray


def open_hole(angles: FloatArray, share: float) -> FloatArray:
    """Hoop stress (k, 3) at a hole's edge per unit of what a plate has there without the hole.

    Of sigma_x at its middle, of the rate of sigma_x along y times the radius, and of tau_xy:

        1 - 2 cos 2t,    sin t - sin 3t,    -4 sin 2t

    in a wide plate. The first and third are Kirsch's. The second follows from Airy's function
    g y^3/6 = g r^3 (3 sin t - sin 3t)/24 with the terms r^-1 sin t, r^-1 sin 3t and r^-3 sin 3t
    that free the edge (docs/theory/plates.md). In a plate that is not wide they are raised as the
    nominal stress is that the ligaments have: the first by [2 + (1 - d/W)^3]/3 over 1 - d/W
    (Heywood's fit of Howland's strip, see `notch_factors`), the second by 1/(1 - (d/W)^3).

    share  d/W, diameter over the plate's width
    """
    left = 1 - share
    tension = (2 + left**3) / 3 / left
    bending = 1 / (1 - share**3)
    return np.stack(
        [
            tension * (1 - 2 * np.cos(2 * angles)),
            bending * (np.sin(angles) - np.sin(3 * angles)),
            -4 * np.sin(2 * angles) / left,
        ],
        axis=1,
    )


@dataclass(frozen=True, eq=False)
class CurvedSection:
    """A plate's section whose fibres are arcs about one centre, by Winkler's theory.

    spans      (m, 2) mm, from where to where it has material, by the distance from the centre
    thickness  mm

    A plane section that shifts and turns strains a fibre, whose length is in proportion to r, by
    a + b/r. The sums of stress and of its moment about the centroid give a and b, so

        sigma = N/A + M (A - r A_m)/(A r (R A_m - A)),    A_m = integral of dA/r,

    R the centroid's r, M above 0 where it pulls the inside (docs/theory/plates.md).
    """

    spans: FloatArray
    thickness: float

    @property
    def area(self) -> float:
        """Area, mm2."""
        return float(np.diff(self.spans, axis=1).sum()) * self.thickness

    @property
    def centroid(self) -> float:
        """Distance of its centroid from the centre, mm."""
        return float(np.diff(self.spans**2, axis=1).sum()) / 2 * self.thickness / self.area

    def stress(self, radii: FloatArray) -> FloatArray:
        """Stress (k, 2) along the fibres at r (k,), MPa per N at the centroid and per N mm."""
        area, mean = self.area, float(np.diff(np.log(self.spans), axis=1).sum()) * self.thickness
        bent = (area - radii * mean) / (area * radii * (self.centroid * mean - area))
        return np.stack([np.full(len(radii), 1 / area), bent], axis=1)
