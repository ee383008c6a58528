"""Stress all round a pin's hole over the patterns of its pressure, for a lug of any outline.

Outlines of lugs about a pin's hole, and how the rest of a part holds them, in points.
"""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from checks.handbook.notch_factors import bent_plate_hole
from checks.handbook.pin_loaded_hole import PATTERNS, ComplexArray, LugOutline, PinLoadedHole
from geometry.mesh import FloatArray

_POINTS = 90  # of half an outline


def strip_outline(
    half_width: float,
    end: float | None,
    cut: float,
    stringer: float = 0.0,
    stringer_from: float = -np.inf,
) -> LugOutline:
    """Lug that goes on as a strip of the same width along +x, cut at x = `cut`.

    half_width     mm
    end            mm, from the hole's middle to its square end; None: round about the middle
    cut            mm; the strip is held there as a bar: evenly, with M y/I and V S/(I t)
    stringer       mm, area of a stringer along both edges over the lug's thickness
    stringer_from  mm, x from which on it is there; none where that is beyond the cut
    """
    h = half_width
    if stringer_from >= cut:
        stringer = 0.0
    length = (h * pi / 2 if end is None else end + h) + cut + h
    size = length / _POINTS
    pieces = []
    if end is None:
        angles, weights = _even(pi, pi / 2, h * pi / 2, size)
        outward = np.exp(1j * angles)
        pieces.append((h * outward, outward, weights))
        start = 0.0
    else:
        y, weights = _even(0.0, h, h, size)
        pieces.append((-end + 1j * y, np.full(len(y), -1.0 + 0j), weights))
        start = -end
    x, weights = _even(start, cut, cut - start, size)
    pieces.append((x + 1j * h, np.full(len(x), 1j), weights))
    y, weights = _even(h, 0.0, h, size)
    pieces.append((cut + 1j * y, np.full(len(y), 1.0 + 0j), weights))
    points, normals = (np.concatenate([piece[k] for piece in pieces]) for k in (0, 1))
    weights = np.concatenate([piece[2] for piece in pieces])
    on_cut = np.arange(len(points)) >= len(points) - len(y)
    on_edge = (normals == 1j) & (points.real >= stringer_from)
    forced = np.zeros((3, len(points)), complex)
    area, inertia = 2 * (h + stringer), 2 * h**3 / 3 + 2 * stringer * h**2
    y = points[on_cut].imag
    forced[0, on_cut] = -1 / area
    forced[1, on_cut] = -cut * y / inertia - 1j * (stringer * h + (h**2 - y**2) / 2) / inertia
    forced[2, on_cut] = y / inertia
    return LugOutline(points, normals, weights, forced, np.where(on_edge, stringer, 0.0))


def round_outline(radius: float, shank: float) -> LugOutline:
    """Round eye that a shank along +x holds: evenly, with M y/I and an even V, on its own width.

    radius  mm, of the eye
    shank   mm, half the width of the shank, below the radius
    """
    at = np.arcsin(shank / radius)
    size = pi * radius / _POINTS
    free, first = _even(pi, at, (pi - at) * radius, size)
    joined, second = _even(at, 0.0, at * radius, size / 2)
    angles, weights = np.concatenate([free, joined]), np.concatenate([first, second])
    normals = np.exp(1j * angles)
    points: ComplexArray = np.asarray(radius * normals)
    held = np.arange(len(points)) >= len(free)
    y, slope = points[held].imag, normals[held].real  # dy = slope ds
    inertia, place = 2 * shank**3 / 3, points[held].real
    forced = np.zeros((3, len(points)), complex)
    forced[0, held] = -slope / (2 * shank)
    # V acts at different places along x: what M balances is its moment at their mean
    mean = (place * slope * second).sum() / shank
    forced[1, held] = -1j * slope / (2 * shank) - mean * y * slope / inertia
    forced[2, held] = y * slope / inertia
    return LugOutline(points, normals, weights, forced, np.zeros(len(points)))


def _even(start: float, stop: float, length: float, size: float) -> tuple[FloatArray, FloatArray]:
    """Middles of even pieces between two places, and the length of each."""
    count = max(4, int(np.ceil(length / size)))
    places = start + (stop - start) * (np.arange(count) + 0.5) / count
    return places, np.full(count, length / count)


def mirrored(points: ComplexArray) -> ComplexArray:
    """Mirror the points of a lug with its free end at +x to one with its free end at -x."""
    return np.asarray(-points.conj())


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
