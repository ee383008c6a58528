"""Numbers without unit of a part and its loads on which the error of every rung depends.

What solids were compared with tells of a part only if it is like them in all of these: in its
shape's proportions, in how its loads pull, push and bend it, and in the arc on which pins press.
"""

from collections.abc import Mapping
from itertools import pairwise
from math import degrees, inf
from typing import Any

import numpy as np

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from geometry.parts import (
    LeafPack,
    Pin,
    PlateLink,
    PrismaticTube,
    SlottedLever,
    ToggleBar,
    TubeRod,
)

ARC = "arc of contact, deg"
SHARE = "share of the largest force: "
PULLED = SHARE + "pulled"
_KNOWS_TILT = (PlateLink, SlottedLever, Pin)
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
        **_of_shape(part.geometry),
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
    shape: Any = part.geometry
    size = loads.largest_force * shape.length
    couple = max(float(np.abs(wrench[:, 3:5]).max()) for wrench in loads.wrenches.values())
    return couple if couple > _COUPLE * size else 0.0


def unknown_load(part: Part, loads: PartLoads) -> str:
    """Load on a part that no rung of its shape knows, in words; "" if there is none."""
    if isinstance(part.geometry, _KNOWS_TILT):
        return ""
    couple = tilting_couple(part, loads)
    if couple:
        return (
            f"couples out of the plane, up to {couple:.3g} N mm, which no rung of {part.shape} has"
        )
    return ""


def proportions_known(part: Part) -> bool:
    """True for the shapes that are built from dimensions: what comes from CAD tells no walls."""
    return bool(_of_shape(part.geometry))


def thin_wall(proportions: Mapping[str, float]) -> str:
    """Name a proportion of walls that are so thin that they may buckle by themselves; or ""."""
    for name, (low, high) in _STOCKY.items():
        value = proportions.get(name)
        if value is not None and not low <= value <= high:
            return f"{name} is {value:.3g}: a wall may buckle by itself"
    return ""


def _of_shape(shape: object) -> dict[str, float]:
    match shape:
        case PlateLink():
            second = shape.hole if shape.second_hole is None else shape.second_hole
            return {
                "hole / width": max(shape.hole, second) / shape.width,
                "thickness / hole": shape.thickness / min(shape.hole, second),
                "length / width": shape.length / shape.width,
            }
        case ToggleBar():
            free = shape.cutout_length - shape.overhang  # of the cheeks, beyond the knee's axis
            return {
                "hole / width": shape.hole / shape.width,
                "overhang / hole": shape.overhang / shape.hole,
                "hole / wall": shape.hole / shape.wall,
                "width / wall": shape.width / shape.wall,
                "cut-out / width": shape.cutout_length / shape.width,
                "cut-out corner / wall": shape.cutout_corner / shape.wall,
                "hole to the cut-out's end / width": (free - shape.hole / 2) / shape.width,
                "length / width": shape.length / shape.width,
            }
        case PrismaticTube():
            return {
                "width / wall": shape.width / shape.wall,
                "length / width": shape.length / shape.width,
            }
        case SlottedLever():
            return _of_lever(shape)
        case TubeRod():
            wall = shape.tube_diameter / 2 if shape.wall is None else shape.wall
            return {
                "hole / eye": shape.hole / shape.eye_diameter,
                "eye width / eye": shape.eye_width / shape.eye_diameter,
                "tube / eye": shape.tube_diameter / shape.eye_diameter,
                "wall / tube": wall / shape.tube_diameter,
                "fillet / tube": shape.fillet / shape.tube_diameter,
                "length / eye": shape.length / shape.eye_diameter,
            }
        case LeafPack():
            beside = shape.contact_from - shape.clamp_length / 2
            return {
                "leaves": float(shape.leaves),
                "width / thickness": shape.width / shape.thickness,
                "clamp / thickness": shape.clamp_length / shape.thickness,
                "contact / thickness": shape.contact_length / shape.thickness,
                "clamp to contact / thickness": beside / shape.thickness,
            }
        case Pin():
            return _of_pin(shape)
        case _:
            return {}


def _of_tilt(part: Part, loads: PartLoads) -> dict[str, float]:
    """How far beside a plate its forces stand, over its width."""
    shape = part.geometry
    if not isinstance(shape, PlateLink | SlottedLever):
        return {}
    couple = tilting_couple(part, loads)
    if not couple:
        return {}
    return {"couple out of the plane / force x width": couple / (loads.largest_force * shape.width)}


def _of_lever(shape: SlottedLever) -> dict[str, float]:
    rail = (shape.width - shape.slot_width) / 2
    ligaments = (shape.slot_from - shape.hole / 2, shape.length - shape.slot_to - shape.hole / 2)
    return {
        "hole / width": shape.hole / shape.width,
        "slot / width": shape.slot_width / shape.width,
        "rail / slot length": rail / (shape.slot_to - shape.slot_from),
        "thickness / rail": shape.thickness / rail,
        "boss height / thickness": shape.boss_height / shape.thickness,
        "pivot's ligament / hole": ligaments[0] / shape.hole,
        "tip's ligament / hole": ligaments[1] / shape.hole,
        "length / width": shape.length / shape.width,
    }


def _of_pin(shape: Pin) -> dict[str, float]:
    seated = shape.seated()
    gaps = [upper[1] - lower[2] for lower, upper in pairwise(seated)]
    widths = [high - low for _, low, high in seated]
    neck = min(shape.diameter if seat.diameter is None else seat.diameter for seat in shape.seats)
    scales = {
        "lug width / diameter": min(widths) / shape.diameter,
        "widest lug / diameter": max(widths) / shape.diameter,
        "gap / diameter": max([*gaps, 0.0]) / shape.diameter,
        "neck / diameter": neck / shape.diameter,
    }
    if neck < shape.diameter:
        scales["fillet / neck"] = shape.step_fillet / neck
    return scales


def _of_loads(part: Part, loads: PartLoads) -> dict[str, float]:
    """How it is pulled and pushed at its second interface, pressed across and turned."""
    largest = loads.largest_force
    if isinstance(part.geometry, Pin) or not largest or len(loads.wrenches) < 2:
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
