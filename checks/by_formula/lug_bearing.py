"""Mean pressure of a pin on the projected area of its hole, against the weaker of both.

EN 1993-1-8:2005, table 3.10, first row, in terms of stress: it allows 1.5 f_y for a joint that
stands still and 0.6 f_y under service loads for a pin that is to come out again.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from checks.part.derived import EXACT, Heading, Kind, Series
from checks.part.loaded_part import LoadedPart
from checks.part.lugs import Lug, lugs_of
from checks.part.part_loads import first_largest
from checks.result.derivation import Given, Step
from checks.result.verdict import Check

BEARING = Kind(
    name="bearing",
    quantity="mean pressure of the pin F/(d t)",
    demand="mean pressure on the projected area",
    limit="yield stress of the softer of pin and hole",
    require="static",
    source="EN 1993-1-8, table 3.10; [fits](../theory/fits.md)",
)
KINDS = (BEARING,)

_SHAPE = "the part's shape"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Pressure p = F/(d t) in the hole where it is the largest share of what it may bear."""
    lugs = lugs_of(loaded)
    if not lugs:
        return
    found = [_pressed(loaded, lug) for lug in lugs]
    (most,) = first_largest(np.array([check.value / check.limit for check in found]))
    others = [
        f"{lug.interface} {check.value:.3g}"
        for lug, check in zip(lugs, found, strict=True)
        if check is not found[most]
    ]
    told = f"other holes, MPa: {', '.join(others)}" if others else ""
    notes = (found[most].note, lugs[most].note, told)
    yield replace(found[most], note="; ".join(note for note in notes if note))


def _pressed(loaded: LoadedPart, lug: Lug) -> Check:
    softer, force = lug.softer, loaded.loads.resultant(lug.interface)
    return loaded.worst(
        Heading(
            kind=BEARING,
            place=f"{lug.interface}, {lug.diameter:g} x {lug.width:g} mm",
            basis=f"yield stress of {softer.name}, the weaker of pin and hole, on the projected "
            "area: EN 1993-1-8 table 3.10 allows 1.5 f_y where nothing moves, 0.6 f_y under "
            "service loads for a pin that is to come out again",
            note=lambda found: f"F = {found['F']:.0f} N",
        ),
        [
            Series("F", f"force of the pin in {lug.interface}", force, "N", main=True),
            Given("d", "diameter that presses", lug.diameter, "mm", _SHAPE),
            Given("t", "width that presses", lug.width, "mm", _SHAPE),
            Step("p", "mean pressure on the projected area", "F/(d*t)", "MPa",
                 "EN 1993-1-8:2005, table 3.10; docs/theory/fits.md", main=True),
        ],
        [
            Given("S_y", f"yield stress of {softer.name}, the weaker of pin and hole",
                  softer.yield_stress, "MPa", softer.source, main=True),
        ],
        EXACT,
    )  # fmt: skip
