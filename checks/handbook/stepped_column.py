"""A straight column of two lengths of unequal stiffness, hinged at both ends: a cylinder.

Between its ends M'' + k^2 M = -q with k^2 = F/(E I) on each length, M and the moment F y of the
deflection y being continuous, and the slope of y jumping by the kink of the axis that play of the
guides allows (docs/theory/cylinders.md). Lengths and stiffnesses are of the tube, first, and the
rod. All functions take arrays (n,) of positions.
"""

from math import pi

import numpy as np

from geometry.mesh import FloatArray

_HALVINGS = 60  # of an interval as long as the root: to the last digit


def buckling_force(
    lengths: tuple[FloatArray, FloatArray], stiffness: tuple[float, float]
) -> FloatArray:
    """Least force (n,), N, at which a hinged column of two lengths buckles elastically.

    lengths    (n,) mm each, above 0
    stiffness  E I of each, N mm2

    The least root F of sin(k1 l1) cos(k2 l2)/k1 + cos(k1 l1) sin(k2 l2)/k2 = 0. It lies between
    Euler's forces of the whole length with the lesser and the greater stiffness, as a stiffness
    that grows anywhere raises it. Other roots lie there, too, so that the angle of the deflection
    over its slope is bisected, which rises with F and is pi at the first.
    """
    one, two = (np.asarray(length, dtype=float) for length in lengths)
    euler = (pi / (one + two)) ** 2
    low, high = euler * min(stiffness), euler * max(stiffness)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = _angle(middle, (one, two), stiffness) < pi
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(0.5 * (low + high))


def _angle(
    force: FloatArray, lengths: tuple[FloatArray, FloatArray], stiffness: tuple[float, float]
) -> FloatArray:
    """Angle, rad, of k2 y over y' at the second hinge, from 0 at the first; steady in the force."""
    k1, k2 = (np.sqrt(force / one) for one in stiffness)
    before = k1 * lengths[0]
    after = np.arctan2(k2 * np.sin(before), k1 * np.cos(before))
    return np.asarray(after + 2.0 * pi * np.round((before - after) / (2.0 * pi)) + k2 * lengths[1])


def largest_moments(
    force: FloatArray,
    lengths: tuple[FloatArray, FloatArray],
    stiffness: tuple[float, float],
    weights: tuple[FloatArray, FloatArray],
    kink: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Largest bending moments (n,) N mm on both lengths, with the deflection they cause.

    force    (n,) N of compression, below the buckling force; one that pulls is taken as none
    weights  (n,) N/mm each, across the axis
    kink     (n,) rad, angle between the axes of both lengths while nothing acts, towards the side
             to which the weight bends the column

    With M1 = p1 (cos k1 x - 1) + D1 sin k1 x from the hinge of the first length, p1 = q1/k1^2, and
    M2 alike from the second's hinge, the constants follow from M1 = M2 and M1' - M2' = F kink
    where they meet.
    """
    # less is none, but for rounding
    least = 1e-6 * buckling_force(lengths, stiffness)
    force = np.maximum(force, least)
    k = [np.sqrt(force / one) for one in stiffness]
    angle = [one * length for one, length in zip(k, lengths, strict=True)]
    p = [weight / one**2 for weight, one in zip(weights, k, strict=True)]
    sines, cosines = [np.sin(one) for one in angle], [np.cos(one) for one in angle]
    # cos - 1 without cancellation
    falls = [-2.0 * np.sin(0.5 * one) ** 2 for one in angle]
    jump = p[1] * falls[1] - p[0] * falls[0]
    slope = force * kink + sum(q * one * s for q, one, s in zip(p, k, sines, strict=True))
    whole = sines[0] * k[1] * cosines[1] + sines[1] * k[0] * cosines[0]
    d1 = (jump * k[1] * cosines[1] + slope * sines[1]) / whole
    d2 = (slope * sines[0] - jump * k[0] * cosines[0]) / whole
    return (
        _largest(p[0], d1, angle[0], falls[0], sines[0]),
        _largest(p[1], d2, angle[1], falls[1], sines[1]),
    )


def _largest(
    p: FloatArray, d: FloatArray, end: FloatArray, falls: FloatArray, sine: FloatArray
) -> FloatArray:
    """Largest of p (cos t - 1) + d sin t for t from 0 to an angle."""
    top = np.arctan2(d, p)
    size = np.hypot(p, d)
    # hypot - p without cancellation
    inside = np.divide(d**2, size + p, out=np.zeros_like(size), where=size + p > 0.0)
    return np.where(top <= end, inside, p * falls + d * sine)
