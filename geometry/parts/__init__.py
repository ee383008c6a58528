"""The parametric parts, by the name of their shape in a design file."""

from geometry.parts.leaf_pack import LeafPack
from geometry.parts.pin import Pin, Seat
from geometry.parts.plate_link import PlateLink
from geometry.parts.prismatic_tube import PrismaticTube
from geometry.parts.slotted_lever import SlottedLever
from geometry.parts.toggle_bar import ToggleBar
from geometry.parts.tube_rod import TubeRod

Shape = ToggleBar | PrismaticTube | Pin | PlateLink | TubeRod | SlottedLever | LeafPack

SHAPES: dict[str, type[Shape]] = {
    "toggle_bar": ToggleBar,
    "prismatic_tube": PrismaticTube,
    "pin": Pin,
    "plate_link": PlateLink,
    "tube_rod": TubeRod,
    "slotted_lever": SlottedLever,
    "leaf_pack": LeafPack,
}

__all__ = [
    "SHAPES",
    "LeafPack",
    "Pin",
    "PlateLink",
    "PrismaticTube",
    "Seat",
    "Shape",
    "SlottedLever",
    "ToggleBar",
    "TubeRod",
]
