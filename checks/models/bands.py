"""How far solids lie from a rung's numbers: the error bars of the rungs, from bands.json.

Converged solids of variations of the machines' parts are compared with each rung
(`python -m bench.rung_bands`). The band of a check is the prediction interval of solid over rung,
in which the next solid lies in 95 % of all cases if the logarithm of that ratio scatters normally:
exp(m -+ t s sqrt(1 + 1/n)) with mean m and deviation s of the n compared. What a part's proportions
have beyond those compared has no band.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from checks.models.proportions import SHARE

_BEYOND = 0.1  # of the range that was compared: how far a part's proportions may be outside it
_OTHER_SHARE = 0.1  # how far a share of the largest force may be outside the range compared


@dataclass(frozen=True)
class Band:
    """Where solids lie, as a factor on a rung's value.

    low, high     factors between which 95 % of the solids lie
    count         solids compared
    above, below  how far the model band of the solids reaches (arcs of contact, forks), as shares
                  of the value: least and most of those compared
    """

    low: float
    high: float
    count: int
    above: tuple[float, float]
    below: tuple[float, float]

    @property
    def width(self) -> float:
        """How wide the band is, as a share of the value."""
        return self.high - self.low


@dataclass(frozen=True)
class NoBand:
    """Why a rung's value has no band, in words."""

    why: str


@cache
def _data() -> Mapping[str, Any]:
    text = files("checks.models").joinpath("bands.json").read_text(encoding="utf-8")
    return dict(json.loads(text)["families"])


def known_band(family: str, rung: str, kind: str) -> Band | None:
    """Band of a check for a family (families.py), whatever its proportions; None if unknown."""
    entry = _data().get(family, {}).get(rung, {}).get(kind)
    if entry is None:
        return None
    above, below = ((float(entry[side][0]), float(entry[side][1])) for side in ("above", "below"))
    return Band(entry["low"], entry["high"], entry["count"], above, below)


def band_of(family: str, rung: str, kind: str, scales: Mapping[str, float]) -> Band | NoBand:
    """Band of a rung's check for a part with these proportions."""
    band = known_band(family, rung, kind)
    if band is None:
        return NoBand(f"no solids of the family {family!r} were compared with the rung {rung}")
    compared = _data()[family][rung][kind]["scales"]
    for name, value in scales.items():
        if name not in compared:
            return NoBand(f"no solid with {name} was compared")
        low, high = compared[name]
        slack = _BEYOND * (high - low) + 1e-9 * abs(high)
        if name.startswith(SHARE):
            slack = max(slack, _OTHER_SHARE)
        if not low - slack <= value <= high + slack:
            return NoBand(
                f"{name} is {value:.3g}, solids were compared from {low:.3g} to {high:.3g}"
            )
    return band
