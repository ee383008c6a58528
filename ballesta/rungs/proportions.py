"""Numbers without unit of a part and its loads on which the error of every rung depends.

What solids were compared with tells of a part only if it is like them in all of these: in its
shape's proportions, in how its loads pull, push and bend it, and in the arc on which pins press.
"""

from itertools import pairwise
from math import degrees

import numpy as np

from ballesta.design_data import Part
from ballesta.part_loads import PartLoads
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
_KNOWS_TILT = (PlateLink, SlottedLever, Pin)
_COUPLE = 1e-6  # of force times size: couples out of the plane that are more than round-off


def proportions_of(part: Part, loads: PartLoads) -> dict[str, float]:
    """All of them, by name; shares of the largest force begin with SHARE."""
    return {**_of_shape(part.geometry), ARC: degrees(part.bearing_arc), **_of_loads(part, loads)}


def unknown_load(part: Part, loads: PartLoads) -> str:
    """What acts on a part that no rung of its shape knows, in words; nothing if there is none."""
    if isinstance(part.geometry, _KNOWS_TILT):
        return ""
    size = loads.largest_force * part.geometry.length
    couple = max(float(np.abs(wrench[:, 3:5]).max()) for wrench in loads.wrenches.values())
    if couple > _COUPLE * size:
        return (
            f"couples out of the plane, up to {couple:.3g} N mm, which no rung of {part.shape} has"
        )
    return ""


def _of_shape(shape: object) -> dict[str, float]:
    match shape:
        case PlateLink():
            return {"length / width": shape.length / shape.width}
        case ToggleBar():
            return {
                "width / wall": shape.width / shape.wall,
                "cut-out / width": shape.cutout_length / shape.width,
                "cut-out corner / wall": shape.cutout_corner / shape.wall,
                "length / width": shape.length / shape.width,
            }
        case PrismaticTube():
            return {"length / width": shape.length / shape.width}
        case SlottedLever():
            rail = (shape.width - shape.slot_width) / 2
            return {
                "rail / slot length": rail / (shape.slot_to - shape.slot_from),
                "thickness / rail": shape.thickness / rail,
                "pivot's ligament / hole": (shape.slot_from - shape.hole / 2) / shape.hole,
                "tip's ligament / hole": (shape.length - shape.slot_to - shape.hole / 2)
                / shape.hole,
                "length / width": shape.length / shape.width,
            }
        case TubeRod():
            wall = shape.tube_diameter / 2 if shape.wall is None else shape.wall
            return {
                "wall / tube": wall / shape.tube_diameter,
                "eye width / eye": shape.eye_width / shape.eye_diameter,
                "fillet / tube": shape.fillet / shape.tube_diameter,
                "length / eye": shape.length / shape.eye_diameter,
            }
        case LeafPack():
            return {
                "leaves": float(shape.leaves),
                "width / thickness": shape.width / shape.thickness,
                "contact / thickness": shape.contact_length / shape.thickness,
                "clamp to contact / thickness": (shape.contact_from - shape.clamp_length / 2)
                / shape.thickness,
            }
        case Pin():
            return pin_proportions(shape)
        case _:
            return {}


def pin_proportions(shape: Pin) -> dict[str, float]:
    """Of a pin: lugs, gaps between them, neck and fillet."""
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
        SHARE + "pulled": max(float(second[:, 0].max()), 0.0) / largest,
        SHARE + "pushed": max(float(-second[:, 0].min()), 0.0) / largest,
        SHARE + "across": across / largest,
        SHARE + "couple over its size": turned / (largest * part.geometry.length),
    }
