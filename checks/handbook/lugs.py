"""Pin joints by formula: stress beside the hole of an eye, a round pin's stress."""

from math import pi

from geometry.mesh import FloatArray

_FITTED = (0.15, 0.75)  # hole over width for which the lug factor was fitted


def lug_factor(hole: float, width: float) -> float | None:
    """Peak stress beside the hole of a pulled lug over F / ((H - d) t); None outside the fit.

    Peterson's chart as fitted by Pilkey: 12.882 - 52.714 u + 89.762 u^2 - 51.667 u^3, u = d/H, for
    a close pin and an end distance of at least H. An end that is round about the pin, H/2 away,
    raises it: at u = 0.4 from 2.85 to 3.35 (under a cosine pressure).

    >>> round(lug_factor(20.0, 50.0), 3)
    2.852
    """
    u = hole / width
    if not _FITTED[0] <= u <= _FITTED[1]:
        return None
    return 12.882 - 52.714 * u + 89.762 * u**2 - 51.667 * u**3


def round_bending(moment: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest bending stress of a round bar, MPa: 32 M / (pi d^3)."""
    return 32 * moment / (pi * diameter**3)


def round_shear(force: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest shear stress of a round bar, MPa: 4/3 of V / A, in the middle (Jourawski)."""
    return 16 * force / (3 * pi * diameter**2)


def round_torsion(torque: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest shear stress of a twisted round bar, MPa: 16 T / (pi d^3)."""
    return 16 * torque / (pi * diameter**3)
