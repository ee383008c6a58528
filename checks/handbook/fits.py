"""Clearance of a pin in its bore, or interference, from an ISO code of limits and fits.

ISO 286-1: a bore lies between EI and EI + IT above its nominal diameter, a pin between es - IT
and es. Standard tolerances IT5 to IT11 and the deviations es of pins d to h stand in the tables
here, up to 500 mm; bores D to H have EI = -es. Read in a maker's table of h5 to h9 (BIG DAISHOWA
catalogue, p. 139) and in the tables of two packages, pressfit 0.1.0 (all of these numbers) and
isofits 1.0 (600 limits of 3 to 400 mm; 595 agree, the others contradict their own neighbours).
What is pressed in, p to s, lies between ei and ei + IT: p in both packages, r above 3 mm in
isofits (not known up to there) and s in pressfit.

Bushes that are pressed into lugs keep the pressure that the interference leaves, by Lame's rings in
plane stress. A bush of outer radius R, k times its inner one, gives way under a pressure p on its
outside by p R b, b = ((k^2 + 1)/(k^2 - 1) - nu)/E, and a lug under p in its bore by p R l. What was
larger than its hole by the interference s on diameter then fits: p R (b + l) = s/2. The lug's l is
its own model's, from the stress all round the bore: a displacement that closes has the mean hoop
strain, so that u/R and (sigma_t - nu sigma_r)/E have one mean. For a ring up to Q R it is ((Q^2 +
1)/(Q^2 - 1) + nu)/E, (1 + nu)/E in an endless plate (docs/theory/press_fits.md). Loads that pass
the bore and close it by R c in the mean add to the interference: p (b + l) = s/(2 R) + c. An even
pressure of the bore's own pin, q on the bore, is q k in the bush, whose radius is smaller. It opens
the bore: p is less by q [l - (nu - (k - 1)/(k + 1))/E]/(b + l).
"""

import re
from bisect import bisect_left
from dataclasses import dataclass, replace
from math import inf, pi
from typing import Self

import numpy as np

from geometry.mesh import FloatArray

# nominal diameters up to, mm
_STEPS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
_TOLERANCES = {  # um
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
}
_DEVIATIONS = {  # um below the nominal diameter of a pin, above that of a bore
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20),
    "h": (0,) * 13,
}
_BETWEEN = (65, 100, 140, 160, 200, 225, 280, 355)  # mm, where the steps of r and s are finer
_UNREAD = 0  # of r up to 3 mm no table was opened
_PRESSED = {  # um above the nominal diameter: p by steps, the others by finer ones
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62),
    "r": (_UNREAD, 15, 19, 23, 28, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84, 94, 98, 108, 114),
    "s": (14, 19, 23, 28, 35, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140, 158, 170, 190, 208),
}
_MOST_PRESSED = 400  # mm
DEFAULT = "H7/f7"  # of a pin that turns in its bore, where a design states no fit
_CODE = re.compile(r"\s*([A-Z]+)([1-9]\d*)\s*/\s*([a-z]+)([1-9]\d*)\s*")
MIDDLE, LEAST, LARGEST = 0.5, 0.0, 1.0  # share of the range of interferences


def clearances_of(code: str, diameter: float) -> tuple[float, float]:
    """Least and largest clearance on diameter, mm, of a fit such as "H7/f7" of a diameter, mm.

    Raises ValueError for a code that is none, or one that this table does not hold.

    >>> clearances_of("H7/f7", 44.0)
    (0.025, 0.075)
    """
    bore, bore_grade, pin, pin_grade, step = _read(code, diameter, _STEPS[-1])
    for letter, shown in ((bore.lower(), bore), (pin, pin)):
        if letter not in _DEVIATIONS:
            raise ValueError(
                f"fits with clearance are known for bores D to H and pins d to h, not {shown}; "
                'state the clearance itself, such as "0.02 .. 0.06 mm"'
            )
    least = _DEVIATIONS[bore.lower()][step] + _DEVIATIONS[pin][step]
    play = _TOLERANCES[bore_grade][step] + _TOLERANCES[pin_grade][step]
    return least / 1000, (least + play) / 1000


def interferences_of(code: str, diameter: float) -> tuple[float, float]:
    """Least and largest interference on diameter, mm, of a press fit such as "H7/p6".

    diameter  mm, of the bore

    Raises ValueError for a code that is none, one that this table does not hold, and one that may
    leave no interference.

    >>> interferences_of("H7/p6", 44.0)
    (0.001, 0.042)
    """
    bore, bore_grade, pressed, grade, step = _read(code, diameter, _MOST_PRESSED)
    if bore != "H" or pressed not in _PRESSED:
        raise ValueError(
            f"press fits are known for bores H and what is pressed in p, r and s, not "
            f'{bore}/{pressed}; state the interference itself, such as "0.02 .. 0.05 mm"'
        )
    finer = sorted({*_STEPS, *_BETWEEN})
    own = step if pressed == "p" else bisect_left(finer, diameter)
    deviation = _PRESSED[pressed][own]
    if deviation == _UNREAD:
        raise ValueError(
            f"the limits of {pressed} are not known at {diameter:g} mm; state the interference "
            'itself, such as "0.005 .. 0.01 mm"'
        )
    least = deviation - _TOLERANCES[bore_grade][step]
    if least <= 0:
        raise ValueError(
            f"{code!r} may leave no interference: {least} um at {diameter:g} mm; state a tighter "
            "fit, or the interference itself"
        )
    return least / 1000, (deviation + _TOLERANCES[grade][step]) / 1000


def _read(code: str, diameter: float, largest: float) -> tuple[str, int, str, int, int]:
    """Letters and grades of bore and pin, and the number of the step of a diameter."""
    found = _CODE.fullmatch(code)
    if found is None:
        raise ValueError(f"{code!r} is no fit; a fit reads bore/pin, such as H7/f7")
    bore, bore_grade, pin, pin_grade = found.groups()
    if not 0 < diameter <= largest:
        raise ValueError(f"fits are known up to {largest} mm, the bore has {diameter:g} mm")
    for grade in (bore_grade, pin_grade):
        if int(grade) not in _TOLERANCES:
            raise ValueError(f"tolerance grades are known from 5 to 11, not {grade}")
    return bore, int(bore_grade), pin, int(pin_grade), bisect_left(_STEPS, diameter)


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
