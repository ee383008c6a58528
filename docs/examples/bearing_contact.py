"""Bearing contact: pressure times sliding speed of the bushes on a pin, as a package adds it."""

from collections.abc import Iterator

import numpy as np

from checks.part.derived import Heading, Kind, Series
from checks.part.loaded_part import LoadedPart
from checks.part.lugs import bushes_of, uneven_share
from checks.result.derivation import Given, Step
from checks.result.verdict import Check

BEARING_CONTACT = Kind(
    name="bearing contact",
    quantity="p v of {}",
    demand="pressure times sliding speed of a bush",
    limit="stated `pv`",
    require="bush",
    source="the maker of the bush",
)
KINDS = (BEARING_CONTACT,)


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Peak of p v in every bush that states what it bears of it (`pv` in the design file)."""
    for bush in bushes_of(loaded.part):
        turning = loaded.loads.spins[bush.name]
        if bush.pv is None or np.isnan(turning).all():
            continue
        speed = np.nan_to_num(turning)  # measured runs have none
        force = loaded.loads.resultant(bush.name)
        yield loaded.worst(
            Heading(
                kind=BEARING_CONTACT,
                of=bush.name,
                place=f"sliding on {bush.diameter:g} mm",
                basis="allowable p v as stated in the design",
                unit="MPa m/s",
            ),
            [
                Series("F", f"force of {bush.name} on the pin", force, "N", main=True),
                Series("omega", "angular speed of both bodies, relative", speed, "rad/s"),
                Given("m", "bushes that share the force", float(bush.count), "", "the design"),
                Given("d", "diameter of the pin", bush.diameter, "mm", "the design"),
                Given("l", "length of a bush", bush.length, "mm", "the design"),
                Step("p", "mean pressure on the projected area", "F/(m*d*l)", "MPa"),
                Step("v", "sliding speed", "abs(omega)*d/2000", "m/s"),
                Step("q", "pressure times sliding speed", "p*v", "MPa m/s", main=True),
            ],
            [Given("q_a", "allowable p v", bush.pv / 1e3, "MPa m/s", "the design", main=True)],
            uneven_share(bush, "q", "MPa m/s"),  # the model band: a pair may share unevenly
        )


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Runs whose sliding speeds are not known."""
    for name, columns in loaded.loads.cycles.items():
        if any(np.isnan(spin[columns]).any() for spin in loaded.loads.spins.values()):
            yield f"NOT CHECKED: p v in {name}: measured loads tell no relative speeds"
