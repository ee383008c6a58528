"""The parametric parts as sheets."""

from collections.abc import Callable
from typing import Any

from geometry.parts import (
    LeafPack,
    PlateLink,
    PrismaticTube,
    Shape,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.plane_outlines import PlaneOutline
from geometry.plane_plates import leaf_pack, plate_link, slotted_lever
from geometry.plane_tubes import prismatic_tube, toggle_bar, tube_rod

_MAKERS: dict[type, Callable[[Any], PlaneOutline]] = {
    PlateLink: plate_link,
    ToggleBar: toggle_bar,
    SlottedLever: slotted_lever,
    TubeRod: tube_rod,
    PrismaticTube: prismatic_tube,
    LeafPack: leaf_pack,
}


def outline_of(shape: Shape) -> PlaneOutline | None:
    """The sheet that stands for a shape seen along z, None for a pin or a part from a STEP file."""
    maker = _MAKERS.get(type(shape))
    return None if maker is None else maker(shape)
