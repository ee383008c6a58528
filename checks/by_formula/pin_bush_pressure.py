"""Mean pressure of the bushes on a pin, on their projected area, against what a bush may take."""

from collections.abc import Iterator, Mapping

from checks.joints.lugs import BushOnPin, bushes_of, pressure_on, uneven_share
from checks.part.derived import Heading, Kind
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Given
from checks.result.formulas import Value
from checks.result.verdict import Check

BUSH = Kind(
    name="bush",
    quantity="bush of {}",
    demand="mean pressure on the projected area",
    limit="stated `allowable`",
    require="bush",
    source="[fits](../theory/fits.md)",
)
KINDS = (BUSH,)


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Pressure p = F/(m d l) of every bush in a pin's stack."""
    for bush in bushes_of(loaded.part):
        yield loaded.worst(
            _heading(bush),
            pressure_on(loaded, bush),
            [Given("p_a", "allowable pressure", bush.allowable, "MPa", "the design", main=True)],
            uneven_share(bush, "p", "MPa"),
        )


def _heading(bush: BushOnPin) -> Heading:
    size = f"{bush.diameter:g} x {bush.length:g}"

    def note(found: Mapping[str, Value]) -> str:
        return f"p = {found['F'] / bush.count:.0f} N / ({size} mm2){bush.note_on_sharing}"

    return Heading(
        kind=BUSH,
        of=bush.name,
        place=f"mean pressure on {size} mm",
        basis="allowable pressure as stated in the design",
        note=note,
    )
