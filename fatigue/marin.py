"""Endurance limit of steel parts by Marin's factors.

Source: Budynas and Nisbett, Shigley's Mechanical Engineering Design, 9th edition, chapter 6:
specimen limit eq. (6-8), Marin's equation (6-18), surface (6-19) and table 6-2, size (6-20) and
(6-21), equivalent diameters (6-24) and (6-25), load (6-26), temperature (6-27), reliability (6-29)
and table 6-5; fretting as a miscellaneous effect, section 6-9. The power law of table 6-2
lies several per cent off charts of the same data.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, prod, sqrt
from statistics import NormalDist

# Surface finish, the smoothest first: a (MPa) and b of k_a = a * ultimate**b, table 6-2.
SURFACES = {
    "ground": (1.58, -0.085),
    "machined": (4.51, -0.265),
    "cold_drawn": (4.51, -0.265),
    "hot_rolled": (57.7, -0.718),
    "as_forged": (272.0, -0.995),
}

# Eq. (6-26); torsion is 1 because stresses are compared in the von Mises norm (0.59 otherwise).
LOADS = {"bending": 1.0, "axial": 0.85, "torsion": 1.0}

LARGEST_SIZE = 254.0  # mm, equivalent diameter at which the data of the size factor end
LARGEST_SPECIMEN_LIMIT = 700.0  # MPa, eq. (6-8): where 0.5 * ultimate stops to hold
HOTTEST = 537.8  # deg C, 1000 deg F: end of eq. (6-27)


@dataclass(frozen=True)
class EnduranceLimit:
    """The fully reversed stress amplitude that a part endures without end, and how it came about.

    value        MPa, uncorrected times the five factors
    uncorrected  MPa, of the polished rotating-beam specimen, 7.62 mm in diameter
    surface, size, load, temperature, reliability    Marin's factors k_a to k_e, each at most 1
    """

    value: float
    uncorrected: float
    surface: float
    size: float
    load: float
    temperature: float
    reliability: float

    def __post_init__(self) -> None:
        factors = self.surface, self.size, self.load, self.temperature, self.reliability
        if not all(0.0 < factor <= 1.0 for factor in factors):
            raise ValueError(f"Marin factors must lie above 0 and at most at 1, got {factors}")
        product = self.uncorrected * prod(factors)
        if not (self.value > 0.0 and abs(self.value - product) <= 1e-9 * product):
            raise ValueError(
                f"the endurance limit must be the product of its factors, {product:g} MPa, "
                f"got {self.value:g} MPa"
            )


def endurance_limit(
    ultimate_strength: float,
    surface: str,
    *,
    equivalent_diameter: float | None = None,
    load: str = "bending",
    temperature: float = 20.0,
    reliability: float = 0.5,
    specimen_limit: float | None = None,
) -> EnduranceLimit:
    """Return the endurance limit of a steel part.

    ultimate_strength in MPa; surface one of SURFACES; equivalent_diameter in mm (see the
    `*_equivalent_diameter` functions), None for no size effect; load one of LOADS; temperature in
    deg C; reliability the share of parts that survive, 0.5 to 0.999999; specimen_limit in MPa
    where it was measured, instead of half the ultimate strength.
    """
    uncorrected = _uncorrected(ultimate_strength, specimen_limit)
    factors = (
        surface_factor(ultimate_strength, surface),
        _size(equivalent_diameter, load),
        load_factor(load),
        temperature_factor(temperature),
        reliability_factor(reliability),
    )
    return EnduranceLimit(uncorrected * prod(factors), uncorrected, *factors)


def _uncorrected(ultimate_strength: float, specimen_limit: float | None) -> float:
    _above_zero("ultimate strength", ultimate_strength, "MPa")
    if specimen_limit is not None:
        _above_zero("specimen limit", specimen_limit, "MPa")
        return specimen_limit
    return min(0.5 * ultimate_strength, LARGEST_SPECIMEN_LIMIT)


def surface_factor(ultimate_strength: float, surface: str) -> float:
    """Return k_a = a * ultimate**b, eq. (6-19), but not more than any smoother finish, nor than 1.

    The power laws of table 6-2 cross in soft steels (ground and machined at 339 MPa, the others
    below 300 MPa) and exceed 1, the polished specimen; a rougher surface gets no credit for that.
    """
    _above_zero("ultimate strength", ultimate_strength, "MPa")
    if surface not in SURFACES:
        raise ValueError(f"surface {surface!r} is unknown; one of {', '.join(SURFACES)}")
    smoother = list(SURFACES)[: list(SURFACES).index(surface) + 1]
    return min(1.0, *(_surface_law(ultimate_strength, finish) for finish in smoother))


def _surface_law(ultimate_strength: float, surface: str) -> float:
    a, b = SURFACES[surface]
    return float(a * ultimate_strength**b)


def size_factor(equivalent_diameter: float) -> float:
    """Return k_b for bending and torsion, eq. (6-20), of a diameter in mm.

    (d/7.62)**-0.107 up to 51 mm, 1.51 d**-0.157 above; there the book jumps down by 0.2 %.
    Below 7.62 mm, the diameter of the specimen, the book goes on above 1 (1.11 at 2.79 mm): here
    the factor is 1. Above `LARGEST_SIZE`, the end of the data, the same curve continues downwards.
    """
    _above_zero("equivalent diameter", equivalent_diameter, "mm")
    if equivalent_diameter > 51.0:
        return float(1.51 * equivalent_diameter**-0.157)
    return min(1.0, float((equivalent_diameter / 7.62) ** -0.107))


def _size(equivalent_diameter: float | None, load: str) -> float:
    """k_b; 1 where no diameter is given, and in axial force, eq. (6-21)."""
    factor = 1.0 if equivalent_diameter is None else size_factor(equivalent_diameter)
    return 1.0 if load == "axial" else factor


ROTATING_AREA = 0.0766  # with 95 % of the largest stress, over d^2, of a bar that rotates (6-22)


def round_equivalent_diameter(diameter: float) -> float:
    """Return 0.370 d, mm, of a round bar in bending that does not rotate, eq. (6-24)."""
    _above_zero("diameter", diameter, "mm")
    return 0.370 * diameter


def rectangle_equivalent_diameter(width: float, height: float) -> float:
    """Return 0.808 sqrt(width * height), mm, of a bar in bending, eq. (6-25)."""
    _above_zero("width", width, "mm")
    _above_zero("height", height, "mm")
    return 0.808 * sqrt(width * height)


def load_factor(load: str) -> float:
    """Return k_c, eq. (6-26): bending 1, axial 0.85, torsion 1 in the von Mises norm."""
    if load not in LOADS:
        raise ValueError(f"load {load!r} is unknown; one of {', '.join(LOADS)}")
    return LOADS[load]


def temperature_factor(temperature: float) -> float:
    """Return k_d of a temperature in deg C: 1 up to 250, then eq. (6-27) to 537.8 (1000 deg F).

    The up to 2 % that the book gains between 50 and 200 deg C are not counted. At 250 deg C the
    polynomial is at 1.0004, so the cap at 1 leaves no step.
    """
    if not (isfinite(temperature) and -273.15 <= temperature <= HOTTEST):
        raise ValueError(
            f"the temperature must lie between -273.15 and {HOTTEST:g} deg C, the end of the "
            f"temperature factor's data, got {temperature:g} deg C"
        )
    if temperature <= 250.0:
        return 1.0
    f = 1.8 * temperature + 32.0
    return min(1.0, 0.975 + 0.432e-3 * f - 0.115e-5 * f**2 + 0.104e-8 * f**3 - 0.595e-12 * f**4)


def reliability_factor(reliability: float) -> float:
    """Return k_e = 1 - 0.08 z, eq. (6-29), z the normal variate of the share that survives.

    8 % standard deviation of the endurance limit. z is computed, not read from table 6-5, whose
    1.288 at 90 % is rounded; the factors agree to 0.001.
    """
    if not 0.5 <= reliability <= 0.999999:
        raise ValueError(f"the reliability must lie between 0.5 and 0.999999, got {reliability:g}")
    return 1.0 - 0.08 * NormalDist().inv_cdf(reliability)


def _above_zero(what: str, value: float, unit: str) -> None:
    if not (isfinite(value) and value > 0.0):
        raise ValueError(f"the {what} must be above 0 {unit}, got {value:g}")
