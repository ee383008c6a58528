"""Bushes that are pressed into lugs: the pressure that the interference leaves, by Lame's rings.

Plane stress. A bush of outer radius R, k times its inner one, gives way under a pressure p on its
outside by p R b, b = ((k^2 + 1)/(k^2 - 1) - nu)/E, and a lug under p in its bore by p R l. What
was larger than its hole by the interference s on diameter then fits: p R (b + l) = s/2. The lug's l
is its own model's, from the stress all round the bore: a displacement that closes has the mean
hoop strain, so that u/R and (sigma_t - nu sigma_r)/E have one mean. For a ring up to Q R it
is ((Q^2 + 1)/(Q^2 - 1) + nu)/E, (1 + nu)/E in an endless plate (docs/theory/press_fits.md).
Loads that pass the bore and close it by R c in the mean add to the interference:
p (b + l) = s/(2 R) + c. An even pressure of the bore's own pin, q on the bore, is q k in the bush,
whose radius is smaller. It opens the bore: p is less by q [l - (nu - (k - 1)/(k + 1))/E]/(b + l).
"""

from dataclasses import dataclass, replace
from math import inf, pi
from typing import Self

import numpy as np

from geometry.mesh import FloatArray

MIDDLE, LEAST, LARGEST = 0.5, 0.0, 1.0  # share of the range of interferences


@dataclass(frozen=True)
class PressFit:
    """A bush that is pressed into a bore.

    least, largest  mm, interference on diameter
    radius          mm, of the bore
    ratio           of the bush's outer radius to its inner one
    youngs_modulus  MPa, of the bush
    poisson_ratio   of the bush
    share           of the way from the least to the largest interference
    pin             name of the part whose stack has the bush
    yield_stress    MPa, of the bush
    """

    least: float
    largest: float
    radius: float
    ratio: float
    youngs_modulus: float
    poisson_ratio: float
    share: float = MIDDLE
    pin: str = ""
    yield_stress: float = inf

    def at(self, share: float) -> Self:
        """The same bush at another share of the way from the least to the largest interference."""
        return replace(self, share=share)

    @property
    def interference(self) -> float:
        """Interference on diameter, mm."""
        return self.least + self.share * (self.largest - self.least)

    @property
    def flexibility(self) -> float:
        """Inward displacement of the bush's outside, over pressure there and radius, 1/MPa."""
        square = self.ratio**2
        return ((square + 1) / (square - 1) - self.poisson_ratio) / self.youngs_modulus

    def pressure(self, lug: float) -> float:
        """Pressure between bush and lug, MPa.

        lug  1/MPa, mean outward displacement of the bore over pressure in it and radius
        """
        return self.interference / (2 * self.radius) / (self.flexibility + lug)

    def pressures(self, lug: float, others: FloatArray, even: FloatArray) -> FloatArray:
        """Pressure (n,) between bush and lug, MPa, more where the loads close the bore.

        lug     as for `pressure`
        others  (n,) mean outward displacement of the bore over its radius, by all other loads
        even    (n,) MPa, even pressure of the bore's own pin, as on the bore
        """
        handed_on = self.poisson_ratio - (self.ratio - 1) / (self.ratio + 1)
        opened = others + even * (lug - handed_on / self.youngs_modulus)
        closed = np.maximum(-opened, 0.0)
        return np.asarray(self.pressure(lug) + closed / (self.flexibility + lug))

    def per_pressure(self, length: float) -> float:
        """Coefficient, N per MPa, of a unit harmonic 0, 1/(pi R L): as `fem.unit_loads` has it.

        length  mm, of the bore
        """
        return pi * self.radius * length

    def hoop(self, lug: float) -> float:
        """Compression around the bush at its inside, MPa, where it yields first.

        lug  as for `pressure`
        """
        square = self.ratio**2
        return self.pressure(lug) * 2 * square / (square - 1)

    def closing(self, lug: float) -> float:
        """How much narrower the pressed bush is inside, mm on diameter.

        lug  as for `pressure`
        """
        return 2 * self.radius / self.ratio * self.hoop(lug) / self.youngs_modulus


def ring_flexibility(ratio: float, youngs_modulus: float, poisson_ratio: float) -> float:
    """Outward displacement of a ring's bore over pressure in it and radius, 1/MPa.

    ratio  of its outer radius to the bore's; infinite in an endless plate

    >>> round(210e3 * ring_flexibility(2.0, 210e3, 0.3), 3)
    1.967
    """
    square = ratio**2
    hoop = 1.0 if ratio == inf else (square + 1) / (square - 1)
    return (hoop + poisson_ratio) / youngs_modulus
