"""Pressure times sliding speed of the bushes on a pin, against what a bush may take of it.

The sliding speed is v = omega d/2 with the angular speed omega of the lug against the pin. Measured
loads tell no speeds: their rows count as standing still, and the report says that they do.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from checks.part.derived import Heading, Kind, Series, demand_over
from checks.part.loaded_part import LoadedPart
from checks.part.lugs import BushOnPin, bushes_of, pressure_on, uneven_share
from checks.result.derivation import Given, Item, Step
from checks.result.formulas import Value
from checks.result.verdict import Check
from geometry.mesh import FloatArray

SLIDING = Kind(
    name="bush",
    quantity="p v of the bush of {}",
    demand="pressure times sliding speed",
    limit="stated `pv`",
    require="bush",
    source="[fits](../theory/fits.md)",
)
KINDS = (SLIDING,)

_UNIT = "MPa m/s"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Peak of p v of every bush that states what it bears of it."""
    for bush in bushes_of(loaded.part):
        speed = np.abs(loaded.loads.spins.get(bush.name, np.nan))
        if bush.pv is None or np.isnan(speed).all():
            continue
        demand: list[Series | Item] = [
            *pressure_on(loaded, bush),
            Series("omega", "angular speed against the pin", np.nan_to_num(speed), "rad/s"),
            Step("v", "sliding speed", "omega*d/2000", "m/s"),
            Step("q", "pressure times speed", "p*v", _UNIT, main=True),
        ]
        means = _means(loaded, demand_over(demand), speed) if loaded.solved else ""
        yield loaded.worst(
            _heading(bush, means),
            demand,
            [Given("q_a", "allowable p v", bush.pv / 1e3, _UNIT, "the design", main=True)],
            uneven_share(bush, "q", _UNIT),
        )


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Runs whose sliding speeds are not known."""
    for bush in bushes_of(loaded.part):
        speed = loaded.loads.spins.get(bush.name)
        if bush.pv is None or speed is None:
            continue
        runs = [name for name, own in loaded.loads.cycles.items() if np.isnan(speed[own]).any()]
        if runs:
            quantity = SLIDING.quantity.format(bush.name)
            yield (
                f"NOT CHECKED: {quantity} in {', '.join(runs)}: measured loads tell no relative "
                "speeds"
            )


def _heading(bush: BushOnPin, means: str) -> Heading:
    def note(found: Mapping[str, Value]) -> str:
        peak = f"p = {found['p']:.3g} MPa, v = {found['v']:.3g} m/s"
        return f"peak: {peak}; mean over each cycle, {_UNIT}: {means}"

    return Heading(
        kind=SLIDING,
        of=bush.name,
        place=f"sliding on {bush.diameter:g} mm",
        basis="allowable p v as stated in the design",
        unit=_UNIT,
        note=note,
    )


def _means(loaded: LoadedPart, product: FloatArray, speed: FloatArray) -> str:
    """Mean of p v (n,) over the time of each cycle whose speeds (n,) are known, in words."""
    told = []
    for name, columns in loaded.loads.cycles.items():
        times = loaded.runs[name].times
        if times is not None and not np.isnan(speed[columns]).any():
            mean = np.trapezoid(product[columns], times) / np.ptp(times)
            told.append(f"{name} {mean:.3g}")
    return ", ".join(told)
