"""Mean pressure of the bushes on a pin, on their projected area, against what a bush may take."""

from collections.abc import Iterator, Mapping

from checks.joints.bushes import BushOnPin, bushes_of, pressure_on, uneven_share
from checks.part.derived import Heading
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Given
from checks.result.formulas import Value
from checks.result.verdict import Check


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Pressure p = F/(m d l) of every bush in a pin's stack."""
    for bush in bushes_of(loaded.part):
        yield loaded.worst(
            _heading(loaded, bush),
            pressure_on(loaded, bush),
            [Given("p_a", "allowable pressure", bush.allowable, "MPa", "the design", main=True)],
            uneven_share(bush, "p", "MPa"),
        )


def _heading(loaded: LoadedPart, bush: BushOnPin) -> Heading:
    size = f"{bush.diameter:g} x {bush.length:g}"

    def note(found: Mapping[str, Value]) -> str:
        return f"p = {found['F'] / bush.count:.0f} N / ({size} mm2){bush.note_on_sharing}"

    return Heading(
        kind="bush",
        quantity=f"bush of {bush.name}",
        required=loaded.required.bush,
        place=f"mean pressure on {size} mm",
        basis="allowable pressure as stated in the design",
        note=note,
    )
