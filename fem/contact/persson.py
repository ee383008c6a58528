"""Arc and pressure of contact of a pin in the hole of an infinite plate, a closed form.

Frictionless, both of one material: Persson, thesis, Gothenburg 1964; Ciavarella and Decuzzi, Int.
J. Solids Struct. 38 (2001) 4507. The parameter is E* dR t/F, with dR half the clearance, 1/E* the
sum of 1/E of both bodies (plane strain: of (1 - nu^2)/E), t the thickness and F the force. In small
arcs it is Hertz's contact.
"""

import numpy as np

from geometry.roots import root

_NARROWEST = 1e-3  # rad
_MIDPOINTS = 32
_EXACT = 1e-12  # of the arc


def persson_parameter(half_arc: float) -> float:
    """E* dR t / F at which a pin of the plate's material touches +-half_arc (rad).

    Half of their E dR/F: E* = E/2 here.
    """
    b = np.tan(half_arc / 2)
    edge = np.sqrt(b * b + 1)
    # t = b sin u, which removes the root at the ends; its period is pi then, so that the error of
    # n midpoints falls as exp(-2 asinh(1/b) n)
    u = np.pi * (np.arange(_MIDPOINTS) + 0.5) / _MIDPOINTS
    c = b * np.cos(u)
    inner = np.log((edge + c) / (edge - c)) / (1 + (b * np.sin(u)) ** 2) * c
    integral = np.pi * inner.mean()
    whole = 2 * (1 - b * b) / (np.pi * b * b) - integral / (np.pi * b * edge) ** 2
    return float(whole / 2)


def persson_half_arc(parameter: float) -> float:
    """Half the arc of contact, rad; 1e-3 rad of what would be less, a right angle at most.

    >>> round(float(np.degrees(persson_half_arc(0.0))), 1), round(persson_half_arc(100.0), 3)
    (84.8, 0.112)
    """
    if parameter >= persson_parameter(_NARROWEST):
        return _NARROWEST
    return root(lambda half: persson_parameter(half) - parameter, _NARROWEST, np.pi / 2, _EXACT)


def persson_pressure(half_arc: float, angle: float = 0.0) -> float:
    """Pressure over F/(R t) at an angle from the force, rad, within the arc."""
    b, y = np.tan(half_arc / 2), np.tan(angle / 2)
    edge, c = np.sqrt(b * b + 1), np.sqrt(b * b - y * y)
    even = 2 * c / (np.pi * edge * (1 + y * y))
    return float(even + np.log((edge + c) / (edge - c)) / (2 * np.pi * b * b * edge**2))
