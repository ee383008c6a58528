"""Stress all round a pin's hole over the patterns of its pressure, for a lug of any outline."""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from checks.handbook.notch_factors import bent_plate_hole
from checks.handbook.pin_loaded_hole import PATTERNS, ComplexArray, PinLoadedHole
from geometry.mesh import FloatArray

_MIRROR = np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0, -1.0])  # of the patterns under x -> -x
_FULL = 3.0  # factor of a hole in a plate whose layers do not hold each other


@dataclass(frozen=True, eq=False)
class Lug:
    """A lug about its hole, its free end at -x, or at +x where it is `mirrored`.

    thickness      mm
    twist_modulus  mm3, torque over the shear stress on the faces of the bar that holds the lug;
                   infinite where no couple out of the plane acts
    """

    hole: PinLoadedHole
    thickness: float
    mirrored: bool = False
    twist_modulus: float = inf

    @property
    def relief(self) -> float:
        """Share of the plane hoop stress that is left at the faces, where the rim may bulge.

        1 in a thin plate and about 0.77 beside a hole that is small against the thickness, nu = 0.3
        (Folias and Wang, Computational Mechanics 6 (1990) 379; Sternberg and Sadowsky, J. Appl.
        Mech. 16 (1949) 27, who have 3 % more than the plane state at mid-thickness and 7 % less at
        the faces of a plate 3/4 as thick as the hole); between by 1/(1 + d/t).
        """
        return 1 - 0.23 / (1 + 2 * self.hole.radius / self.thickness)

    def stress(self, arms: ComplexArray) -> FloatArray:
        """Stress xx, yy, xy (k, 3, 8), MPa per coefficient of `bearing_coefficients`, in plane.

        arms  (k,) x + i y from the hole's middle, mm
        """
        if not self.mirrored:
            return self.hole.at(arms) / self.thickness
        found = self.hole.at(-arms.conj()) * _MIRROR / self.thickness
        found[:, 2] *= -1
        return np.asarray(found)

    def tilted(self, angles: FloatArray) -> FloatArray:
        """Stress xx, yy, xy (k, 3, 2) at the rim's face z = +thickness/2 per N mm of M_x and M_y.

        A couple out of the plane presses with a force that grows along z, 12 M z/t^3 per mm. Its
        layers would be as many lugs in their own planes; those of a thick plate are, those of a
        thin one hold each other by shear along z, which relieves the edge as it does for a bent
        plate with a free hole: by its factor over 3. M_y bends the lug. M_x twists it: the layers'
        forces along y are then balanced by shear along z and not by bending in their planes, so
        the infinite plate's hoop stress (1 - nu)/(2 pi r) sin(t) of a force is taken. The bar
        that holds the lug takes the torque on one side: half of its shear stress on either, as for
        a force, and -4 S sin(2 t) of it around the hole, relieved alike.
        """
        radius = self.hole.radius
        share = bent_plate_hole(2 * radius, self.thickness) / _FULL
        rim = radius * np.exp(1j * angles)
        force = 6 / self.thickness  # at the face, of a lug as thick, per N mm
        bent = self.stress(rim)[:, :, PATTERNS.index("cos 1")] * force
        hoop, radial, shear = polar(bent, angles)
        bending = cartesian(share * hoop, radial, share * shear, angles)
        nu = self.hole.poisson_ratio
        even = force * np.sin(angles) / (pi * radius * self.thickness)
        passing = (-0.5 if self.mirrored else 0.5) / self.twist_modulus
        hoop = -share * ((1 - nu) / 2 * even + 4 * passing * np.sin(2 * angles))
        twist = cartesian(hoop, even, np.zeros_like(even), angles)
        return np.stack([twist, bending], axis=2)


def polar(stress: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Hoop, radial and shear stress of xx, yy, xy (k, 3) at angles (k,)."""
    c, s = np.cos(angles), np.sin(angles)
    xx, yy, xy = stress.T
    hoop = xx * s**2 + yy * c**2 - 2 * xy * s * c
    radial = xx * c**2 + yy * s**2 + 2 * xy * s * c
    return hoop, radial, (yy - xx) * s * c + xy * (c**2 - s**2)


def cartesian(
    hoop: FloatArray, radial: FloatArray, shear: FloatArray, angles: FloatArray
) -> FloatArray:
    """Stress xx, yy, xy (k, 3) of hoop, radial and shear stress at angles (k,)."""
    c, s = np.cos(angles), np.sin(angles)
    xx = radial * c**2 + hoop * s**2 - 2 * shear * s * c
    yy = radial * s**2 + hoop * c**2 + 2 * shear * s * c
    return np.stack([xx, yy, (radial - hoop) * s * c + shear * (c**2 - s**2)], axis=1)
