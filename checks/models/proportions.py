"""Numbers without unit of a part and its loads on which the error of every rung depends.

What solids were compared with tells of a part only if it is like them in all of these: in its
shape's proportions, in how its loads pull, push and bend it, and in the arc on which pins press.
"""

from collections.abc import Mapping
from math import degrees, inf

import numpy as np

from checks.design.data import Part
from checks.models.shapes import shape_model
from checks.part.part_loads import PartLoads

ARC = "arc of contact, deg"
SHARE = "share of the largest force: "
PULLED = SHARE + "pulled"
# Proportions up to which no wall buckles by itself below yield under what bends a pulled part or
# what a pin presses: docs/theory/buckling.md.
_STOCKY = {
    "thickness / hole": (0.1, inf),
    "hole / wall": (0.0, 10.0),
    "width / wall": (0.0, 16.0),
    "wall / tube": (0.03, inf),
}
_COUPLE = 1e-6  # of force times size: couples out of the plane that are more than round-off


def proportions_of(part: Part, loads: PartLoads) -> dict[str, float]:
    """All of them, by name; shares of the largest force begin with SHARE."""
    return {
        **part.geometry.proportions,
        ARC: degrees(part.bearing_arc),
        **_of_loads(part, loads),
        **_of_tilt(part, loads),
    }


def of_buckling(proportions: Mapping[str, float]) -> dict[str, float]:
    """The proportions that a buckling load depends on: loads over the largest that can buckle.

    A pull buckles nothing, however large it is beside them. A part that is only pulled has none.
    The arc of contact is none of them: every model buckles under resultants, or the half circle's
    pressure.
    """
    shares = {name: one for name, one in proportions.items() if name.startswith(SHARE)}
    shares.pop(PULLED, None)
    largest = max(shares.values(), default=0.0)
    shape = {
        name: one for name, one in proportions.items() if not name.startswith(SHARE) and name != ARC
    }
    return shape | {name: one / largest for name, one in shares.items() if largest}


def tilting_couple(part: Part, loads: PartLoads) -> float:
    """Largest couple out of the plane, N mm; 0 where it is not more than round-off."""
    size = loads.largest_force * part.geometry.length
    couple = max(float(np.abs(wrench[:, 3:5]).max()) for wrench in loads.wrenches.values())
    return couple if couple > _COUPLE * size else 0.0


def unknown_load(part: Part, loads: PartLoads) -> str:
    """Load on a part that no rung of its shape knows, in words; "" if there is none."""
    if _knows_tilt(part):
        return ""
    couple = tilting_couple(part, loads)
    if couple:
        return (
            f"couples out of the plane, up to {couple:.3g} N mm, which no rung of {part.shape} has"
        )
    return ""


def _knows_tilt(part: Part) -> bool:
    model = shape_model(part.geometry)
    return model is not None and model.tilts


def proportions_known(part: Part) -> bool:
    """True for the shapes that are built from dimensions: what comes from CAD tells no walls."""
    return bool(part.geometry.proportions)


def thin_wall(proportions: Mapping[str, float]) -> str:
    """Name a proportion of walls that are so thin that they may buckle by themselves; or ""."""
    for name, (low, high) in _STOCKY.items():
        value = proportions.get(name)
        if value is not None and not low <= value <= high:
            return f"{name} is {value:.3g}: a wall may buckle by itself"
    return ""


def _of_tilt(part: Part, loads: PartLoads) -> dict[str, float]:
    """How far beside a plate its forces stand, over its width."""
    if part.body is None or not _knows_tilt(part):
        return {}
    couple, width = tilting_couple(part, loads), part.geometry.stressed_section[0]
    if not couple:
        return {}
    return {"couple out of the plane / force x width": couple / (loads.largest_force * width)}


def _of_loads(part: Part, loads: PartLoads) -> dict[str, float]:
    """How it is pulled and pushed at its second interface, pressed across and turned."""
    largest = loads.largest_force
    if part.body is None or not largest or len(loads.wrenches) < 2:
        return {}
    second = loads.wrenches[part.geometry.interfaces[1]]
    across, turned = (
        max(float(np.abs(wrench[:, row]).max()) for wrench in loads.wrenches.values())
        for row in (1, 5)
    )
    return {
        PULLED: max(float(second[:, 0].max()), 0.0) / largest,
        SHARE + "pushed": max(float(-second[:, 0].min()), 0.0) / largest,
        SHARE + "across": across / largest,
        SHARE + "couple over its size": turned / (largest * part.geometry.length),
    }
