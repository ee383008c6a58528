"""Stress all round a pin's hole over the patterns of its pressure, for a lug of any outline.

Outlines of lugs about a pin's hole, and how the rest of a part holds them, in points.

Handbook factors are peak stress over nominal stress at holes, shoulders and fillets.
"""

from dataclasses import dataclass
from math import inf, log1p, pi, sqrt

import numpy as np

from checks.handbook.pin_loaded_hole import ComplexArray, LugOutline, PinLoadedHole
from geometry.mesh import FloatArray

_STEPPED = (0.1, 2.0, 20.0)  # least and middle h/r, largest h/r of the fits
_Fit = tuple[tuple[float, float, float], ...]
_TORSION: _Fit = (
    (0.905, 0.783, -0.075),
    (-0.437, -1.969, 0.553),
    (1.557, 1.073, -0.578),
    (-1.061, 0.171, 0.086),
)
_FITS: dict[str, tuple[_Fit, _Fit]] = {
    "tension": (
        (
            (0.926, 1.157, -0.099),
            (0.012, -3.036, 0.961),
            (-0.302, 3.977, -1.744),
            (0.365, -2.098, 0.878),
        ),
        (
            (1.200, 0.860, -0.022),
            (-1.805, -0.346, -0.038),
            (2.198, -0.486, 0.165),
            (-0.593, -0.028, -0.106),
        ),
    ),
    "bending": (
        (
            (0.947, 1.206, -0.131),
            (0.022, -3.405, 0.915),
            (0.869, 1.777, -0.555),
            (-0.810, 0.422, -0.260),
        ),
        (
            (1.232, 0.832, -0.008),
            (-3.813, 0.968, -0.260),
            (7.423, -4.868, 0.869),
            (-3.839, 3.070, -0.600),
        ),
    ),
    "torsion": (_TORSION, _TORSION),
}

_POINTS = 90  # of half an outline
_FULL = 3.0  # factor of a hole in a plate whose layers do not hold each other


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


def _even(start: float, stop: float, length: float, size: float) -> tuple[FloatArray, FloatArray]:
    """Middles of even pieces between two places, and the length of each."""
    count = max(4, int(np.ceil(length / size)))
    places = start + (stop - start) * (np.arange(count) + 0.5) / count
    return places, np.full(count, length / count)


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
        found = self.hole.at(-arms.conj()) * _mirror(self.hole.patterns) / self.thickness
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
        bent = self.stress(rim)[:, :, self.hole.patterns.index("cos 1")] * force
        hoop, radial, shear = polar(bent, angles)
        bending = cartesian(share * hoop, radial, share * shear, angles)
        nu = self.hole.poisson_ratio
        even = force * np.sin(angles) / (pi * radius * self.thickness)
        passing = (-0.5 if self.mirrored else 0.5) / self.twist_modulus
        hoop = -share * ((1 - nu) / 2 * even + 4 * passing * np.sin(2 * angles))
        twist = cartesian(hoop, even, np.zeros_like(even), angles)
        return np.stack([twist, bending], axis=2)


def _mirror(patterns: tuple[str, ...]) -> FloatArray:
    """Signs of patterns under x -> -x, by which t becomes pi - t."""
    signs = [(-1.0) ** (int(name[4:]) + name.startswith("sin")) for name in patterns[:-1]]
    return np.array([*signs, -1.0])


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


def bent_plate_hole(diameter: float, thickness: float) -> float:
    """Factor of a hole in a wide plate that is bent, on 6 M/t^2 per width.

    Reissner's thick plate (J. Appl. Mech. 12 (1945) A-69) as fitted in Pilkey and Pilkey,
    Peterson's Stress Concentration Factors, 3rd ed., 2008, chart 4.92: 3 for a hole small against
    the thickness, 1.79 for a thin plate, at nu = 0.3.

    >>> round(bent_plate_hole(0.0, 10.0), 2), round(bent_plate_hole(1e6, 10.0), 2)
    (2.98, 1.79)
    """
    u = diameter / thickness
    return 1.79 + 0.25 / (0.39 + u) + 0.81 / (1 + u**2) - 0.26 / (1 + u**3)


def stepped_bar(kind: str, wide: float, narrow: float, radius: float) -> float:
    """Factor of shoulder fillets of a flat bar in "tension" or "bending", on the narrow part's.

    Heywood, Designing by Photoelasticity, 1952: with h = (D - d)/2, 1 + [h/(r (2.8 D/d - 2))]^0.65
    in tension and 1 + [h/(r (5.37 D/d - 4.8))]^0.85 in bending.

    >>> round(stepped_bar("tension", 20.0, 10.0, 1.0), 2)
    2.24
    """
    ratio = wide / narrow
    depth = (wide - narrow) / 2 / radius
    if kind == "tension":
        return float(1 + (depth / (2.8 * ratio - 2)) ** 0.65)
    return float(1 + (depth / (5.37 * ratio - 4.8)) ** 0.85)


def curved_bar(depth: float, radius: float) -> float:
    """Factor at the inside of a bent bar of rectangular section that is curved, on 6 M/(t d^2).

    Winkler and Bach (Timoshenko, Strength of Materials, part I, 3rd ed., 1955, article 75): with
    the neutral axis at r_n = d/ln((r + d)/r) and e = r + d/2 - r_n, K = (r_n - r) d/(6 e r).

    depth   mm, of the section in the plane of bending
    radius  mm, of its inside

    >>> round(curved_bar(10.0, 5.0), 2), round(curved_bar(1.0, 1000.0), 3)
    (1.52, 1.0)
    """
    neutral = depth / log1p(depth / radius)
    return (neutral - radius) * depth / (6 * (radius + depth / 2 - neutral) * radius)


def stepped_shaft(kind: str, wide: float, narrow: float, radius: float) -> float:
    """Factor of a shoulder fillet of a round shaft in "tension", "bending" or "torsion".

    On the nominal stress of the narrow shaft. Fits of Peterson's charts 3.4, 3.10 and 3.12 (Pilkey
    and Pilkey, 3rd ed., 2008; Roark's Formulas for Stress and Strain, 7th ed., table 17.1, 16):
    with h = (D - d)/2, s = 2 h/D, K = C1 + C2 s + C3 s^2 + C4 s^3, C linear in sqrt(h/r) and h/r.
    Beyond the fits' h/r of 20 or below 0.1 (0.25 in torsion) the fit of the bound is continued:
    above as sqrt(h/r), below towards 1 at h = 0.

    >>> round(stepped_shaft("bending", 15.0, 10.0, 1.0), 2)
    1.74
    """
    height = (wide - narrow) / 2
    if height <= 0:
        return 1.0
    low, middle, high = (0.25, 4.0, 4.0) if kind == "torsion" else _STEPPED
    depth, share = height / radius, 2 * height / wide
    held = min(max(depth, low), high)
    factor = _stepped_fit(kind, held, share, upper=held > middle)
    if depth > high:
        return float(1 + (factor - 1) * sqrt(depth / high))
    if depth < low:
        return float(1 + (factor - 1) * sqrt(depth / low))
    return float(factor)


def _stepped_fit(kind: str, depth: float, share: float, *, upper: bool) -> float:
    root = sqrt(depth)
    table = _FITS[kind][1 if upper else 0]
    terms = [a + b * root + c * depth for a, b, c in table]
    return sum(term * share**k for k, term in enumerate(terms))
