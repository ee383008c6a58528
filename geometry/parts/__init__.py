"""The parametric parts, by the name of their shape in a design file.

Modules here have shapes, subclasses of `Shape` with a name, that are found by being here; one
of another package is named by an entry point of the group `ballesta.shapes` (docs/extending.md).
Own shapes come in the order of their names, then those of others.
"""

from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules

from geometry.parts.beams import Beam, IBeam, PinHole, RhsBeam
from geometry.parts.leaf_pack import LeafPack
from geometry.parts.pin import Pin, Seat
from geometry.parts.plate_link import PlateLink
from geometry.parts.prismatic_tube import PrismaticTube
from geometry.parts.slotted_lever import SlottedLever
from geometry.parts.toggle_bar import ToggleBar
from geometry.parts.tube_rod import TubeRod
from geometry.shape import Shape

GROUP = "ballesta.shapes"


def _found() -> Iterator[type[Shape]]:
    modules = [vars(import_module(f"{__name__}.{one.name}")) for one in iter_modules(__path__)]
    known = (one for names in modules for one in names.values() if isinstance(one, type))
    own = {one for one in known if issubclass(one, Shape) and one.name}
    yield from sorted(own, key=lambda one: one.name)
    for point in sorted(entry_points(group=GROUP)):
        yield point.load()


SHAPES: dict[str, type[Shape]] = {shape.name: shape for shape in _found()}

__all__ = [
    "SHAPES",
    "Beam",
    "IBeam",
    "LeafPack",
    "Pin",
    "PinHole",
    "PlateLink",
    "PrismaticTube",
    "RhsBeam",
    "Seat",
    "Shape",
    "SlottedLever",
    "ToggleBar",
    "TubeRod",
]
