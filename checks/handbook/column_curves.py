"""Column curves that know crookedness: Ayrton and Perry's formula, and Eurocode 3's curves.

A hinged column with the initial deflection e sin(pi x/L) bends on to e/(1 - F/F_E). Its outermost
fibre yields at the axial stress s with

    (S_y - s) (s_E - s) = eta s_E s,    eta = e A/W

(Ayrton and Perry, The Engineer 62 (1886) 464). EN 1993-1-1:2005, 6.3.1.2, has the same formula with
eta = alpha (slenderness - 0.2), where alpha was fitted to tests and stands for crookedness and
residual stress together.

Out of a plane a bar buckles as a column, and sideways where it is bent; both by energy.

A cylinder is a straight column of two lengths of unequal stiffness, hinged at both ends. Between
its ends M'' + k^2 M = -q with k^2 = F/(E I) on each length, M and the moment F y of the deflection
y being continuous, and the slope of y jumping by the kink of the axis that play of the guides
allows (docs/theory/cylinders.md). Lengths and stiffnesses are of the tube, first, and the rod;
arrays (n,) are of positions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from geometry.mesh import BoolArray, FloatArray

_TERMS = 3

# EN 1993-1-1:2005, table 6.1
IMPERFECTION = {"a0": 0.13, "a": 0.21, "b": 0.34, "c": 0.49, "d": 0.76}
# EN 1993-1-1:2005, table 5.1, elastic analysis: L/e of the bow that stands for crookedness and
# residual stress together
BOW = {"a0": 350.0, "a": 300.0, "b": 250.0, "c": 200.0, "d": 150.0}

_PLATEAU = 0.2  # slenderness up to which Eurocode's curves carry the yield stress


def transition_slenderness(yield_stress: float, youngs_modulus: float) -> float:
    """Slenderness at which Johnson's parabola meets Euler's hyperbola, at half the yield stress.

    >>> round(transition_slenderness(350.0, 210e3), 5)
    108.82796
    """
    _check(yield_stress=yield_stress, youngs_modulus=youngs_modulus)
    return pi * sqrt(2 * youngs_modulus / yield_stress)


def johnson_stress(slenderness: float, yield_stress: float, youngs_modulus: float) -> float:
    """Johnson's parabola, MPa, of a slenderness up to the transition to Euler.

    At the transition it touches Euler's hyperbola, at half the yield stress (Shigley, Mechanical
    Engineering Design, 10th ed., section 4-13).

    >>> round(johnson_stress(transition_slenderness(350.0, 210e3), 350.0, 210e3), 9)
    175.0
    """
    _check(yield_stress=yield_stress, youngs_modulus=youngs_modulus)
    return yield_stress * (1 - yield_stress * slenderness**2 / (4 * pi**2 * youngs_modulus))


def perry_robertson(euler: float, yield_stress: float, eta: float) -> float:
    """Axial stress, MPa, at which the crooked column's outermost fibre yields.

    euler  MPa, Euler's stress
    eta    e A/W, the stress of the crookedness over the axial one

    >>> round(perry_robertson(pi**2 * 210e3 / 100**2, 350.0, 0.3), 5)
    156.79872
    """
    _check(euler_stress=euler, yield_stress=yield_stress)
    if not eta >= 0:
        raise ValueError(f"the column's imperfection eta must be at least 0, got {eta}")
    # both sides over Euler's stress, and the root that does not cancel: any slenderness will do
    share = yield_stress / euler
    half = (share + 1 + eta) / 2
    root = sqrt(((1 - share) / 2) ** 2 + eta * (eta + 2 * (1 + share)) / 4)  # half^2 - share
    return yield_stress / (half + root)


def eurocode_reduction(slenderness: float, curve: str) -> float:
    """Share chi of the yield stress that a column carries by EN 1993-1-1, 6.3.1.2.

    slenderness  non-dimensional, sqrt(S_y/s_E)
    curve        "a0", "a", "b", "c" or "d"

    >>> round(eurocode_reduction(1.0, "b"), 8), eurocode_reduction(0.15, "b")
    (0.59702319, 1.0)
    """
    if curve not in IMPERFECTION:
        raise ValueError(f"no column curve is named {curve!r}; there are {', '.join(IMPERFECTION)}")
    if not slenderness >= 0:
        raise ValueError(f"a column's slenderness must be at least 0, got {slenderness}")
    if slenderness <= _PLATEAU:
        return 1.0
    eta = IMPERFECTION[curve] * (slenderness - _PLATEAU)
    return perry_robertson(1 / slenderness**2, 1.0, eta)


def eurocode_stress(euler: float, yield_stress: float, curve: str) -> float:
    """Axial stress, MPa, that a column carries by EN 1993-1-1, 6.3.1.2, without partial factor."""
    _check(euler_stress=euler, yield_stress=yield_stress)
    return yield_stress * eurocode_reduction(sqrt(yield_stress / euler), curve)


def _check(**values: float) -> None:
    for name, value in values.items():
        if not value > 0:
            raise ValueError(f"the column's {name.replace('_', ' ')} must be above 0, got {value}")


# Column strength of a section by handbook: yield, Johnson's parabola, Euler.
#
# Johnson below the slenderness at which Euler's stress is half the yield stress, Euler above
# (Shigley, Mechanical Engineering Design, 10th ed., section 4-12 and 4-13).


@dataclass(frozen=True)
class ColumnStrength:
    """Strength of a column in one plane.

    slenderness     effective length over radius of gyration
    critical        MPa, the stress that governs
    governs         "yield", "Johnson" or "Euler"
    euler           MPa
    """

    slenderness: float
    critical: float
    governs: str
    euler: float


def column_strength(
    area: float, inertia: float, length: float, yield_stress: float, youngs_modulus: float
) -> ColumnStrength:
    """Critical stress of a column with hinged ends and effective length `length`, MPa.

    >>> strength = column_strength(181.76, 24510.94, 250.0, 355.0, 210e3)
    >>> round(strength.slenderness, 2), round(strength.critical, 1), strength.governs
    (21.53, 348.0, 'Johnson')
    """
    for name, value in (("area", area), ("inertia", inertia), ("yield stress", yield_stress)):
        if not value > 0:
            raise ValueError(f"the column's {name} must be above 0, got {value}")
    slenderness = length / np.sqrt(inertia / area)
    euler = np.pi**2 * youngs_modulus / slenderness**2 if slenderness else float("inf")
    if slenderness >= transition_slenderness(yield_stress, youngs_modulus):
        return ColumnStrength(float(slenderness), float(euler), "Euler", float(euler))
    johnson = johnson_stress(slenderness, yield_stress, youngs_modulus)
    governs = "yield" if johnson > 0.999 * yield_stress else "Johnson"
    return ColumnStrength(float(slenderness), float(johnson), governs, float(euler))


def column_force(stiffness: FloatArray, shear: FloatArray | float, length: float) -> float:
    """Buckling force, N, of a hinged column whose stiffness changes along it.

    Timoshenko's quotient with one sine wave (Timoshenko and Gere, Theory of Elastic Stability, 2nd
    ed., 2.8), with the shear strain of 2.17: integral of w'^2 over integral of w^2/(E I) + w'^2/S.
    Never below the exact force; exact for a column of constant section.

    stiffness  (k,) E I at even places from end to end, N mm2
    shear      (k,) or one S, N; infinite without shear strain

    >>> bool(np.isclose(column_force(np.full(9, 2.0), np.inf, 3.0), 2 * np.pi**2 / 9, rtol=1e-12))
    True
    """
    count = len(stiffness)
    s = np.linspace(0.0, pi, count)
    weights = np.full(count, 1.0)
    weights[[0, -1]] = 0.5
    wave, slope = np.sin(s) ** 2 * weights, (pi / length * np.cos(s)) ** 2 * weights
    return float(slope.sum() / ((wave / stiffness) + slope / shear).sum())


def lateral_share(
    compression: FloatArray,
    moment: FloatArray,
    stiffness: FloatArray,
    twisting: FloatArray,
    length: float,
    *,
    held_last: bool = False,
) -> FloatArray:
    """Share (n,) that loads are of those under which a bar buckles out of its plane.

    compression  (n,) axial force over the column's critical one out of the plane; < 0 is tension
    moment       (k, n) N mm in the plane at k even places between the ends
    stiffness    (k,) E I out of the plane, N mm2
    twisting     (k,) G J, N mm2
    held_last    True if the second end holds the bar against twisting and not the first

    A deflection aside w follows the twist t by E I w'' = -M t where both ends are held sideways.
    Then the energy integral of G J t'^2 - M^2 t^2/(E I) is stationary (Timoshenko and Gere, Theory
    of Elastic Stability, 2nd ed., 6.2 and 6.3), t = 0 at one end and free at the other.
    Three sines of odd quarter waves are taken: a cantilever's lowest m is at most 1 % above
    4.013 sqrt(E I G J)/(F L^2). An axial force p (over critical) takes a share of the stiffness
    aside: (1 - s p) = (s m)^2 at the load factor s (same, 6.1), so the share is
    (p + sqrt(p^2 + 4 m^2))/2.
    """
    _, forms = _twisted(moment, stiffness, twisting, length, held_last)
    squares = np.linalg.eigvalsh(forms)[:, -1]
    bent = np.sqrt(np.maximum(squares, 0.0))
    return np.asarray((compression + np.sqrt(compression**2 + 4 * bent**2)) / 2)


def lateral_twist(
    moment: FloatArray,
    stiffness: FloatArray,
    twisting: FloatArray,
    length: float,
    *,
    held_last: bool = False,
) -> tuple[float, FloatArray]:
    """Share m of a moment (k,) alone, and the twist (k,) of its mode, of unit energy C t'^2.

    Parameters are those of `lateral_share`, at one position.
    """
    normal, (form,) = _twisted(moment[:, None], stiffness, twisting, length, held_last)
    squares, modes = np.linalg.eigh(form)
    return float(np.sqrt(max(squares[-1], 0.0))), np.asarray(modes[:, -1] @ normal)


def _twisted(
    moment: FloatArray,
    stiffness: FloatArray,
    twisting: FloatArray,
    length: float,
    held_last: bool,
) -> tuple[FloatArray, FloatArray]:
    """Twists (_TERMS, k) of unit energy, and the forms (n, _TERMS, _TERMS) of M^2 t^2/(E I)."""
    count = len(stiffness)
    s = np.linspace(1.0, 0.0, count) if held_last else np.linspace(0.0, 1.0, count)
    weights = np.full(count, length / (count - 1))
    weights[[0, -1]] /= 2
    order = (2 * np.arange(_TERMS) + 1) * pi / 2
    waves, slopes = np.sin(np.outer(order, s)), np.cos(np.outer(order, s)) * order[:, None] / length
    elastic = (slopes * (twisting * weights)) @ slopes.T
    root = np.linalg.inv(np.linalg.cholesky(elastic))
    normal = root @ waves  # the elastic energy of these is 1
    pairs = np.einsum("ik,jk->kij", normal, normal) * (weights / stiffness)[:, None, None]
    forms = (moment**2).T @ pairs.reshape(count, -1)
    return normal, forms.reshape(-1, _TERMS, _TERMS)


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
    low, high = bisected(lambda force: _angle(force, (one, two), stiffness) < pi, low, high)
    return np.asarray(0.5 * (low + high))


def bisected(
    below: Callable[[FloatArray], BoolArray], low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Ends (n,), but for rounding one, between which the answer changes that is given of places."""
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        still = below(middle)
        low, high = np.where(still, middle, low), np.where(still, high, middle)
    return low, high


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
