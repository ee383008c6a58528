"""Bands: how far a number may move before its test fails, by its repeatability."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from math import inf, isfinite
from pathlib import Path
from typing import Any

from checks.design.errors import no_such

ROUND_OFF = 1e-6  # another processor's arithmetic; the same one repeats to 1e-9
LARGEST = 0.04  # a peak stress that changes by 5 % must always be seen
MARGIN = 1.5  # band over the worst scatter of re-meshed parts
MASS_KIND = "mass"
NOISE = Path(__file__).with_name("noise.json")
_MESHED = "solid"
_REFINED = ("static", "fatigue")  # kinds that a solid's meshes are refined for
_BOUNDED = 1.5  # times the accuracy: what meshes leave, and what the bearing series cuts off


@dataclass(frozen=True)
class Tolerance:
    """Share of a baseline's number by which it may move; None where none is known, then why."""

    width: float | None
    why: str = ""

    @property
    def text(self) -> str:
        """The band as a table shows it."""
        return "none" if self.width is None else f"±{percent(self.width)}"


def percent(share: float) -> str:
    """Return a share as people read it.

    >>> percent(1e-6), percent(0.0125)
    ('0.0001 %', '1.25 %')
    """
    text = f"{100 * share:.3g}"
    return f"{float(text):f}".rstrip("0").rstrip(".") + " %" if "e" in text else f"{text} %"


def mass_band(part: str, stated: Mapping[str, float]) -> Tolerance:
    """The band of a part's mass: round-off, for the CAD kernel weighs it."""
    return Tolerance(_stated(part, MASS_KIND, stated) or ROUND_OFF)


def band_of(
    part: str, key: str, check: Mapping[str, Any], accuracy: float, stated: Mapping[str, float]
) -> Tolerance:
    """The band of a check of a part.

    key, check  as a baseline has them ("static: peak von Mises stress")
    accuracy    numerical error, as a share, that the design asks its meshes for
    stated      bands that the baseline file states, by kind or by part and kind
    """
    kind, rung = key.partition(":")[0], str(check["rung"])
    own = _stated(part, kind, stated)
    if own is not None:
        return Tolerance(own)
    if rung != _MESHED:
        return Tolerance(ROUND_OFF)
    bar = check.get("numerical", 0.0)
    if not is_bounded(rung, kind, bar, accuracy):
        known = "is not known" if bar is None else f"is {percent(bar)}"
        return Tolerance(
            None,
            f"the numerical error {known}, where {percent(accuracy)} is asked for: its "
            f"noise is not bounded; raise mesh.most_unknowns{_or_state(part, kind)}",
        )
    return _measured_band(part, rung, kind, accuracy)


def largest_bar(rung: str, kind: str, accuracy: float) -> float | None:
    """The largest numerical bar, as a share, that re-mesh noise is measured for.

    None where nothing is refined: then the bar is the same on every mesh.
    """
    if rung != _MESHED or kind not in _REFINED:
        return None
    return _BOUNDED * accuracy


def is_bounded(rung: str, kind: str, numerical: float | None, accuracy: float) -> bool:
    """True if re-mesh noise is measured for a numerical error bar, given as a share."""
    largest = largest_bar(rung, kind, accuracy)
    return largest is None or (numerical is not None and numerical <= largest)


def _measured_band(part: str, rung: str, kind: str, accuracy: float) -> Tolerance:
    """Band of measured re-mesh noise; a finer accuracy's band counts for a coarser one."""
    known = sorted(
        (entry["accuracy"], band_width(entry["worst"]))
        for entry in _noise()
        if entry["rung"] == rung and entry["kind"] == kind
    )
    covering = next((measured for measured, _ in known if measured >= accuracy), None)
    width = max((width for measured, width in known if measured <= (covering or 0)), default=inf)
    if covering is not None and width <= LARGEST:
        return Tolerance(width)
    quiet = [measured for measured, width in known if width <= LARGEST]
    if covering is not None:
        said = f"re-meshing moves it by more than {percent(LARGEST)} at this accuracy"
    else:
        said = f"the re-mesh noise of {kind} by the {rung} is not measured at {percent(accuracy)}"
    cure = f'set accuracy = "{percent(max(quiet))}" or finer' if quiet else "pin another rung"
    return Tolerance(None, f"{said}: {cure}{_or_state(part, kind)}")


def band_width(worst: float) -> float:
    """The band for a worst scatter of re-meshed parts, as shares."""
    return max(MARGIN * worst, 10 * ROUND_OFF)


def _or_state(part: str, kind: str) -> str:
    return f', or state bands = {{"{part}: {kind}": "2 %"}} in the baseline'


@cache
def _noise() -> list[dict[str, Any]]:
    """Worst scatter by rung, kind and accuracy, as `python -m bench.remesh_noise` measured it."""
    return list(json.loads(NOISE.read_text(encoding="utf-8"))["worst"])


def _stated(part: str, kind: str, stated: Mapping[str, float]) -> float | None:
    return stated.get(f"{part}: {kind}", stated.get(kind))


def parse_bands(stated: object, parts: Mapping[str, Iterable[str]]) -> dict[str, float]:
    """Return the bands that a baseline file states, as shares.

    stated  {"static": "2 %", "bar_upper: fatigue": 0.01, "mass": 1e-4}
    parts   part -> the kinds of its checks

    Raises ValueError with what was found and what was expected.
    """
    if not isinstance(stated, Mapping):
        raise ValueError(f'bands: must be a table such as {{"static": "2 %"}}, got {stated!r}')
    kinds = {kind: [*found, MASS_KIND] for kind, found in parts.items()}
    known = {kind: None for found in kinds.values() for kind in found}
    known |= {f"{part}: {kind}": None for part, found in kinds.items() for kind in found}
    bands = {}
    for key, value in stated.items():
        if key not in known:
            raise ValueError(f"bands: {no_such('kind of check', str(key), known)}")
        bands[str(key)] = _share(str(key), value)
    return bands


def _share(key: str, value: object) -> float:
    number: object = value
    if isinstance(value, str) and value.strip().endswith("%"):
        try:
            number = float(value.strip()[:-1]) / 100
        except ValueError:
            number = None
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise ValueError(f'bands.{key}: must be a share such as "2 %" or 0.02, got {value!r}')
    if not isfinite(number) or not 0 < number < 1:
        raise ValueError(f"bands.{key}: must be above 0 % and below 100 %, got {value!r}")
    return float(number)
