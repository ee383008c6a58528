"""Stress on the surface of a round pin: of bending, shear and twist, and under a lug's pressure."""

from functools import lru_cache
from math import pi

import numpy as np

from geometry.mesh import FloatArray

_AT_EDGE = 1e-11  # of the radius: sums of lengths stray by that much from an edge that they mean


def section_stress(
    angles: FloatArray,
    diameter: float,
    shear: FloatArray,
    moment: FloatArray,
    torque: FloatArray,
    poisson_ratio: float,
) -> tuple[FloatArray, FloatArray]:
    """Stress along z, and shear of the sections (normal +z) around the pin, (k, c), MPa.

    At angles (k,) for c cases: shear (c, 2) and torque (c,) are sums over the loads below the
    section, moment (c, 2) the sum of forces times their distance below it, as in a pin's diagram.
    The upper part answers with the opposite: sigma = -M cos(..) 32/(pi d^3), and at the rim
    of a round bar (1 + 2 nu)/(1 + nu) V/A (Timoshenko and Goodier, Theory of Elasticity, 3rd ed.,
    article 122), around it where it is square to V, and 16 T/(pi d^3).
    """
    outward = np.stack([np.cos(angles), np.sin(angles)])
    around = np.stack([-np.sin(angles), np.cos(angles)])
    area = pi * diameter**2 / 4
    along = -(moment @ outward).T * 32 / (pi * diameter**3)
    rim = (1 + 2 * poisson_ratio) / (1 + poisson_ratio) / area
    sheared = -(shear @ around).T * rim - torque * 16 / (pi * diameter**3)
    return along, sheared


def cylinder_stress(
    angles: FloatArray, pressure: FloatArray, along: FloatArray, sheared: FloatArray
) -> FloatArray:
    """Stress (k, 6) at angles (k,) of a pin's surface under a pressure that is long along it.

    A pressure on a solid disc, its resultant carried away evenly by shear along z, is the same
    stress along the radius and around: of every harmonic of it, also the first (Michell's solution
    with r^n and r^(n+2); x times the even body force). So it is -p in both.
    """
    return surface_stress(angles, -pressure, -pressure, along, sheared)


def surface_stress(
    angles: FloatArray,
    radial: FloatArray,
    around: FloatArray,
    along: FloatArray,
    sheared: FloatArray,
) -> FloatArray:
    """Stress (k, 6) xx, yy, zz, xy, yz, zx of tractions at angles (k,) of a pin's surface.

    For m cases at once, tractions are (k, m) and the stress is (k, 6, m).
    """
    c, s = np.cos(angles), np.sin(angles)
    if radial.ndim > 1:
        c, s = c[:, None], s[:, None]
    stress = np.zeros((len(angles), 6, *radial.shape[1:]))
    stress[:, 0] = radial * c**2 + around * s**2
    stress[:, 1] = radial * s**2 + around * c**2
    stress[:, 2] = along
    stress[:, 3] = (radial - around) * s * c
    stress[:, 4] = c * sheared
    stress[:, 5] = -s * sheared
    return stress


def under_band(
    places: FloatArray, low: FloatArray, high: FloatArray, radius: float, poisson_ratio: float
) -> FloatArray:
    """Stress (3, s, k) along, around and along the radius at z = `places` (s,) per pressure.

    It presses bands from z = `low` to `high` (k,), mm, of a long solid cylinder. The middle of a
    long band is pressed as a disc (`cylinder_stress`): -1 around and along the radius, nothing
    along z. Under a short one the surface behaves as a half-space's does: -1 along z, too, and
    -2 nu around. Between, and beside it, the stress comes from the Fourier integral of the even
    pressure around (Rankin, J. Appl. Mech. 11 (1944) A-77; Timoshenko and Goodier, Theory of
    Elasticity, 3rd ed., article 143), taken for every harmonic. At a band's edge half of it
    presses.
    """
    distance, table = _steps(poisson_ratio)
    found = np.zeros((3, len(places), len(low)))
    for sign, edge in ((-1.0, low), (1.0, high)):
        away = (places[:, None] - edge) / radius
        away[np.abs(away) < _AT_EDGE] = 0.0
        for row in (0, 1):
            found[row] += sign * np.sign(away) * np.interp(np.abs(away), distance, table[row])
        found[2] += sign * 0.5 * np.sign(away)
    return found


@lru_cache(maxsize=8)
def _steps(poisson_ratio: float) -> tuple[FloatArray, FloatArray]:
    """Half the stress along and around (2, m) that a step of the pressure makes at distances (m,).

    Love's function (A I0(k r) + B k r I1(k r)) sin(k z) has, over cos(k z) and with x = k r,

        tau_rz = 0:  A = -B (2 (1 - nu) + x I0/I1)
        sigma_z = (4 - 2 nu) B I0 + A I0 + B x I1
        sigma_t = 2 nu B I0 - A I1/x - B I0
        sigma_r = 2 nu B I0 - A (I0 - I1/x) - B (I0 + x I1)

    and a step is the integral of sin(k z)/(pi k) of it. The remainder of the ratios at large x
    falls as 1/x; it is integrated up to x = 150. Their limits 1 and 2 nu are half of a step.
    """
    x = (np.arange(7500) + 0.5) * 0.02
    # I_n(x) exp(-x), the mean of exp(x (cos t - 1)) cos(n t) over half a turn: exact by midpoints
    along_turn = np.cos((np.arange(100) + 0.5) * np.pi / 100)
    falling = np.exp(np.outer(x, along_turn - 1))
    zero, one = falling.mean(axis=1), (falling * along_turn).mean(axis=1)
    a = -(2 * (1 - poisson_ratio) + x * zero / one)
    radial = 2 * poisson_ratio * zero - a * (zero - one / x) - (zero + x * one)
    along = ((4 - 2 * poisson_ratio) * zero + a * zero + x * one) / radial
    around = (2 * poisson_ratio * zero - a * one / x - zero) / radial
    distance = np.concatenate([np.linspace(0.0, 3.0, 61), np.linspace(3.1, 8.0, 50)])
    waves = np.sin(np.outer(distance, x)) / (np.pi * x) * 0.02
    table = [
        end / 2 + waves @ (ratio - end)
        for ratio, end in ((along, 1.0), (around, 2 * poisson_ratio))
    ]
    return distance, np.array(table)
