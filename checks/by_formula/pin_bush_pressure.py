"""Mean pressure of the bushes on a pin, on their projected area, against what a bush may take."""

from collections.abc import Iterator, Mapping
from math import inf

from checks.handbook.fits import LARGEST, ring_flexibility
from checks.part.derived import Heading, Kind
from checks.part.loaded_part import LoadedPart
from checks.part.lugs import BushOnPin, bushes_of, pressure_on, uneven_share
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


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Bushes in a part's bores: what pressing them in leaves there, or that it is left out."""
    part, design = loaded.part, loaded.design
    for bore, point in part.interfaces.items():
        fit = part.press_fits.get(bore)
        if fit is not None:
            yield (
                f"the bush of {fit.pin} in {bore} is pressed in with {fit.least:.3g} to "
                f"{fit.largest:.3g} mm of interference on diameter: the even pressure that this "
                "leaves between elastic rings acts for good, in static checks and as a mean "
                "stress, and more where the loads close the bore; how much of it is left at "
                "working temperature, and what holds the bush in place, is not checked"
            )
            own = part.material
            lug = ring_flexibility(inf, own.youngs_modulus, own.poisson_ratio)
            hoop = fit.at(LARGEST).hoop(lug)
            if hoop > fit.yield_stress:
                yield (
                    f"the bush of {fit.pin} in {bore} yields as it is pressed in (up to "
                    f"{hoop:.3g} MPa of {fit.yield_stress:.3g} MPa at its inside): it presses less "
                    "than told, and closes more"
                )
            continue
        for pin in design.parts.values():
            for index, entry in enumerate(pin.stack if pin.joint == point else ()):
                if entry.bush is not None and entry.body == part.body:
                    yield (
                        f"the stress that pressing the bush of {pin.name} into {bore} leaves there "
                        f"is left out, as parts.{pin.name}.stack[{index}].bush.fit is not stated"
                    )
