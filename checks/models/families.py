"""Which solids a part is compared with: those of its shape that carry their loads as it does."""

import numpy as np

from checks.design.data import Part
from checks.joints.pin_diagrams import pin_diagram
from checks.models.proportions import tilting_couple
from checks.part.part_loads import PartLoads
from geometry.parts import Pin, PlateLink
from geometry.parts.step_part import StepPart

_CAD = "CAD part"
_PRESSED = 1.75  # mean pressure over a neck's bending stress, up to which the neck decides


def family_of(part: Part, loads: PartLoads, kind: str) -> str:
    """Name of the family for a kind of check; it begins with the part's shape.

    A pin in lugs that all stand on one side is bent out of a couple, one with a neck at the neck,
    unless a short arc of contact presses harder on a seat: then no half circle tells its stress. A
    plate beside others is bent out of its plane, too. Each scatters about solids in its own way.
    Buckling is compared by shape alone.
    """
    shape = part.geometry
    if isinstance(shape, StepPart):  # named after its file, whatever that is called
        return _CAD
    if kind == "buckling":
        return part.shape
    if isinstance(shape, Pin):
        if any((seat.diameter or shape.diameter) < shape.diameter for seat in shape.seats):
            weaker = _pressed_over_bent(shape, loads) > _PRESSED
            return f"{part.shape} with a neck" + (" and short seats" if weaker else "")
        if not any(seat.single for seat in shape.seats):
            return part.shape
        if all(seat.single or (not seat.paired and seat.at == 0.0) for seat in shape.seats):
            return f"{part.shape} in single lugs"
        return f"{part.shape} in single and paired lugs"
    if isinstance(shape, PlateLink):
        return f"{part.shape} beside others" if tilting_couple(part, loads) else part.shape
    return part.shape


def _pressed_over_bent(shape: Pin, loads: PartLoads) -> float:
    """Largest mean pressure on a seat over the largest bending stress of the necks.

    Nominal both, F/(d w) and 32 M/(pi d^3), each over all positions.
    """
    pressures = [
        float(np.hypot(*loads.wrenches[seat.name][:, :2].T).max())
        / ((seat.diameter or shape.diameter) * seat.width * len(seat.places))
        for seat in shape.seats
    ]
    diagram = pin_diagram(shape, dict(loads.wrenches), spread=True, ends_only=True)
    bent = float(diagram.bending_stress[:, diagram.diameter < shape.diameter].max())
    return max(pressures) / bent if bent else np.inf
