"""Handbook factors: peak stress over nominal stress at holes, shoulders and fillets."""

from math import log1p, sqrt

_STEPPED = (0.1, 2.0, 20.0)  # least and middle h/r, largest h/r of the fits


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
