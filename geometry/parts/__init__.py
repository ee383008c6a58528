"""The parametric parts, by the name of their shape in a design file."""

from geometry.parts.pin import Pin, Seat
from geometry.parts.prismatic_tube import PrismaticTube
from geometry.parts.toggle_bar import ToggleBar

SHAPES: dict[str, type[ToggleBar] | type[PrismaticTube] | type[Pin]] = {
    "toggle_bar": ToggleBar,
    "prismatic_tube": PrismaticTube,
    "pin": Pin,
}

__all__ = ["SHAPES", "Pin", "PrismaticTube", "Seat", "ToggleBar"]
