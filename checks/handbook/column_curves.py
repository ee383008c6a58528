"""Column curves that know crookedness: Perry and Robertson's, and those of Eurocode 3.

A hinged column with the initial deflection e sin(pi x/L) bends on to e/(1 - F/F_E). Its outermost
fibre yields at the axial stress s with

    (S_y - s) (s_E - s) = eta s_E s,    eta = e A/W

(Ayrton and Perry, The Engineer 62 (1886) 464; Robertson, ICE Selected Paper 28 (1925): eta = 0.003
L/k for steel, which is on the safe side of all his tests). EN 1993-1-1:2005, 6.3.1.2, has the same
formula with eta = alpha (slenderness - 0.2), where alpha was fitted to tests and stands for
crookedness and residual stress together.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

# EN 1993-1-1:2005, table 6.1
IMPERFECTION = {"a0": 0.13, "a": 0.21, "b": 0.34, "c": 0.49, "d": 0.76}
# EN 1993-1-1:2005, table 5.1, elastic analysis: L/e of the bow that stands for crookedness and
# residual stress together
BOW = {"a0": 350.0, "a": 300.0, "b": 250.0, "c": 200.0, "d": 150.0}

ROBERTSON = 0.003  # of the slenderness: Robertson's eta, where no crookedness is stated

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
    johnson, euler  MPa; johnson is None where Euler governs
    """

    slenderness: float
    critical: float
    governs: str
    johnson: float | None
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
        return ColumnStrength(float(slenderness), float(euler), "Euler", None, float(euler))
    johnson = johnson_stress(slenderness, yield_stress, youngs_modulus)
    governs = "yield" if johnson > 0.999 * yield_stress else "Johnson"
    return ColumnStrength(float(slenderness), float(johnson), governs, float(johnson), float(euler))
