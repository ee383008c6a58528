"""Hertz contact of cylinders and spheres: width, pressure, and the shear below the surface.

Johnson, Contact Mechanics, 1985: line contact section 4.2(c), point contact section 4.2(a); stress
on the axis below them in the same sections. Bodies are half-spaces there, so the patch must be
small against the radii: a pin that fits its hole closely is no such contact.
"""

from dataclasses import dataclass
from math import inf, isfinite, pi, sqrt

import numpy as np

from geometry.roots import root

_WIDEST = 0.5  # half width over the smaller radius: an arc of 60 degrees
_FLATTEST = 1e-6  # relative curvature, against the larger of the two, below which it is conformal


class HertzError(ValueError):
    """A contact to which Hertz's theory does not apply."""


@dataclass(frozen=True)
class HertzBody:
    """One of two bodies in contact.

    radius          mm; infinite for a flat, negative for a hollow (a hole, a groove)
    youngs_modulus  MPa
    poisson_ratio   1
    """

    radius: float
    youngs_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not self.radius or np.isnan(self.radius):
            raise HertzError(f"a body's radius must not be 0 or missing, got {self.radius} mm")
        if not 0 < self.youngs_modulus < inf:
            raise HertzError(f"Young's modulus must be above 0 MPa, got {self.youngs_modulus}")
        if not -1 < self.poisson_ratio <= 0.5:
            raise HertzError(f"Poisson's ratio must be in (-1, 0.5], got {self.poisson_ratio}")


@dataclass(frozen=True)
class HertzContact:
    """The contact of two bodies.

    half_width     mm, of the line, or the radius of the circle
    peak_pressure  MPa
    shear          MPa, the largest shear stress below the surface
    shear_depth    mm, where it stands
    approach       mm, of two bodies with point contact; None for a line, where it depends on how
                   far away it is measured
    """

    half_width: float
    peak_pressure: float
    shear: float
    shear_depth: float
    approach: float | None = None


def line_contact(force: float, first: HertzBody, second: HertzBody) -> HertzContact:
    """Contact of parallel cylinders under `force` per length, N/mm.

    b = sqrt(4 P R / (pi E*)), p0 = 2 P / (pi b) with 1/R = 1/R1 + 1/R2. On the axis the largest
    shear is p0 (s - s^2 / sqrt(1 + s^2)) at depth s b; its greatest is 0.300283 p0 at s^2 =
    (sqrt 5 - 1) / 2, s = 0.786151, whatever Poisson's ratio.

    >>> steel = 210e3, 0.3
    >>> found = line_contact(100.0, HertzBody(10.0, *steel), HertzBody(float("inf"), *steel))
    >>> round(found.half_width, 6), round(found.peak_pressure, 3)
    (0.105046, 606.037)
    """
    _check_force(force, "N/mm")
    half = sqrt(4 * force * _relative_radius(first, second) / (pi * _modulus(first, second)))
    _check_width(half, first, second)
    pressure = 2 * force / (pi * half)
    depth = sqrt((sqrt(5) - 1) / 2)
    shear = depth - depth**2 / sqrt(1 + depth**2)
    return HertzContact(half, pressure, shear * pressure, depth * half)


def point_contact(force: float, first: HertzBody, second: HertzBody) -> HertzContact:
    """Contact of spheres under `force`, N; the shear is the larger of both bodies' shear.

    a = (3 P R / (4 E*))^(1/3), p0 = 3 P / (2 pi a^2), approach a^2 / R. On the axis at depth s a:
    sigma_r / p0 = -(1 + nu)(1 - s atan(1/s)) + 1 / (2 (1 + s^2)), sigma_z / p0 = -1 / (1 + s^2).
    """
    _check_force(force, "N")
    radius = _relative_radius(first, second)
    a = (3 * force * radius / (4 * _modulus(first, second))) ** (1 / 3)
    _check_width(a, first, second)
    pressure = 3 * force / (2 * pi * a * a)
    ratio = min(first.poisson_ratio, second.poisson_ratio)  # less of it, more shear
    depth, shear = _below_a_point(ratio)
    return HertzContact(a, pressure, shear * pressure, depth * a, a * a / radius)


def _below_a_point(poisson_ratio: float) -> tuple[float, float]:
    """Depth over radius and shear over peak pressure where the shear is largest."""

    def shear(s: float) -> float:
        along = (1 + poisson_ratio) * (1 - s * np.arctan(1 / s)) - 0.5 / (1 + s * s)
        return float((1 / (1 + s * s) - along) / 2)

    def slope(s: float) -> float:
        turn = np.arctan(1 / s) - s / (1 + s * s)
        return float((-3 * s / (1 + s * s) ** 2 + (1 + poisson_ratio) * turn) / 2)

    depth = root(slope, 1e-3, 3.0, 1e-14)
    return depth, shear(depth)


def _modulus(first: HertzBody, second: HertzBody) -> float:
    """E*, MPa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""
    return 1 / sum((1 - body.poisson_ratio**2) / body.youngs_modulus for body in (first, second))


def _relative_radius(first: HertzBody, second: HertzBody) -> float:
    one, other = 1 / first.radius, 1 / second.radius
    curvature = one + other
    if one == other == 0:
        raise HertzError("two flats touch on their whole faces, not on a Hertz contact")
    if abs(curvature) <= _FLATTEST * max(abs(one), abs(other)):
        raise HertzError(
            f"radii of {first.radius:g} and {second.radius:g} mm fit each other: a conformal "
            "contact, to which Hertz's theory does not apply"
        )
    if curvature < 0:
        raise HertzError(
            f"radii of {first.radius:g} and {second.radius:g} mm cannot touch: the hollow must be "
            "wider than what lies in it"
        )
    return 1 / curvature


def _check_force(force: float, unit: str) -> None:
    if not (force > 0 and isfinite(force)):
        raise HertzError(f"a contact needs a force above 0 {unit}, got {force}")


def _check_width(half: float, first: HertzBody, second: HertzBody) -> None:
    smallest = min(abs(first.radius), abs(second.radius))
    if half > _WIDEST * smallest:
        raise HertzError(
            f"a contact of {half:.3g} mm half width is not small against a radius of "
            f"{smallest:.3g} mm (limit {_WIDEST:g}): Hertz's theory does not apply"
        )
