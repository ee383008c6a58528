"""Column strength of a section by handbook: yield, Johnson's parabola, Euler.

Johnson below the slenderness at which Euler's stress is half the yield stress, Euler above
(Shigley, Mechanical Engineering Design, 10th ed., section 4-12 and 4-13).
"""

from dataclasses import dataclass

import numpy as np

from checks.handbook.column_curves import johnson_stress, transition_slenderness


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


def engesser_force(euler: float, shear_stiffness: float) -> float:
    """Buckling force, N, of a hinged column that also gives way by shear.

    euler            N, without shear strain
    shear_stiffness  N, G times the shear area; of two plates that rack, 24 E I/length^2 with both
                     their ends clamped and 6 E I/length^2 with one end of each hinged

    Engesser (1889); Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.17. Haringx lets
    the shear force act square to the section instead of the axis and comes out higher (0.8 % for a
    bar five times as long as high); Engesser's is on the safe side.

    >>> round(engesser_force(1381744.616, 5 / 6 * 200 * 210e3 / 2.6), 1)
    1253119.6
    """
    for name, value in (("Euler force", euler), ("shear stiffness", shear_stiffness)):
        if not value > 0:
            raise ValueError(f"the column's {name} must be above 0, got {value}")
    return euler / (1 + euler / shear_stiffness)
