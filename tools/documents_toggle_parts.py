"""The toggle press: what ballesta finds for bars, pin and bushes, and the thesis' own sizing.

Bars are judged as the thesis does, at x = 2 mm under 11 kN, but by the yield stress of S355.
"""

from math import cbrt, hypot, pi, sqrt

from documents_toggle import bar_force, bar_force_formula

from checks.handbook.column_curves import ColumnStrength, column_strength
from geometry.bars import square_tube_section

YIELD, THESIS_YIELD, YOUNGS = 355.0, 400.0, 210e3  # MPa


def _force() -> float:
    return max(bar_force("lower", 2.0), bar_force("upper", 2.0))


def _column(width: float, length: float = 250.0) -> ColumnStrength:
    tube = square_tube_section("tube", width, 1.6, 0.0)
    return column_strength(tube.area, tube.inertia_in_plane, length, YIELD, YOUNGS)


def area(width: float = 13.0) -> float:
    """Return the area of a square tube, wall 1.6 mm [mm2]."""
    return square_tube_section("tube", width, 1.6, 0.0).area


def inertia(width: float = 13.0) -> float:
    """Return the moment of inertia of a square tube, wall 1.6 mm [mm4]."""
    return square_tube_section("tube", width, 1.6, 0.0).inertia_in_plane


def slenderness(width: float = 13.0) -> float:
    """Return the slenderness of a bar of that tube between its pins."""
    return _column(width).slenderness


def euler_stress(width: float = 13.0) -> float:
    """Return Euler's stress of a bar of that tube [MPa]."""
    return _column(width).euler


def column_safety(width: float = 13.0, length: float = 250.0) -> float:
    """Return the critical stress that governs over the bar's stress; length effective [mm]."""
    return _column(width, length).critical / (_force() / area(width))


def euler_safety() -> float:
    """Return the thesis' safety: Euler's stress of the 30 mm tube over its yield stress."""
    return euler_stress(30.0) / THESIS_YIELD


def needed_area() -> float:
    """Return the area that the larger bar force needs at the yield stress [mm2]."""
    return _force() / YIELD


def needed_area_formula() -> float:
    """Return the same with the thesis' force and yield stress [mm2]."""
    return bar_force_formula("upper") / THESIS_YIELD


def needed_side() -> float:
    """Return the side of the solid square of that area [mm]."""
    return sqrt(needed_area())


def needed_side_formula() -> float:
    """Return the same with the thesis' force and yield stress [mm]."""
    return sqrt(needed_area_formula())


def pin_moment_level() -> float:
    """Return the moment of the cylinder's force by the thesis' gaps [N mm], outer arm 8 + 4 mm."""
    return 11000.0 / 4.0 * (8.0 + 8.0 + 4.0)


def pin_moment_level_formula() -> float:
    """Return the same with an outer arm of 4 mm."""
    return 11000.0 / 4.0 * (8.0 + 4.0)


def pin_moment_gaps() -> float:
    """Return the whole moment by the thesis' gaps [N mm]."""
    return hypot(124000.0, pin_moment_level())


def pin_moment_gaps_formula() -> float:
    """Return the whole moment with the outer arm of 4 mm [N mm]."""
    return hypot(124000.0, pin_moment_level_formula())


def pin_radius() -> float:
    """Return the pin's radius for that moment at 400 MPa / 1.5 [mm]."""
    return cbrt(4.0 * pin_moment_gaps() / (pi * THESIS_YIELD / 1.5))


def pin_radius_formula() -> float:
    """Return the same for the thesis' moment [mm]."""
    return cbrt(4.0 * pin_moment_gaps_formula() / (pi * THESIS_YIELD / 1.5))


def bush_pressure(x: float = 2.0) -> float:
    """Return the pressure of the larger bar force on two bushes of 40 x 6.3 mm [MPa]."""
    return max(bar_force("lower", x), bar_force("upper", x)) / 2.0 / (40.0 * 6.3)


def bush_pressure_formula() -> float:
    """Return the same with 62 kN, and the cylinder's force added across them [MPa]."""
    return hypot(62000.0 / 2.0, 11000.0 / 2.0) / (40.0 * 6.3)


def rear_pivot() -> float:
    """Return the pin-to-pin length of the retracted cylinder [m], by its catalogue."""
    return (80.0 + 180.0 + 55.0 + 210.0 + 125.0) / 1e3
