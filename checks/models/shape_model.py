"""The model of a shape by formula: what a module of `checks.models.shapes` states of its shape."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from geometry.shape import Shape

S = TypeVar("S", bound=Shape)


def _by_name(part: Part, _shape: Shape, _loads: PartLoads, _kind: str) -> str:
    return part.shape


@dataclass(frozen=True)
class ShapeModel(Generic[S]):
    """A shape's stress by formula over all positions, and what its error bars depend on.

    shape   the class in `geometry.parts`
    stress  of a part, its shape and loads: the rung `formula`; None where no formula is known
    family  of a part, its shape, loads and a kind of check: name of the solids that error bars are
            from, which carry their loads as it does; the shape's name where nothing else is said
    tilts   True if couples out of the linkage's plane are in the stress
    statics True if it has the inertia of its own bending, and stress by statics alone, whatever
            balances that: solids lie as near under other shares of loads across it
    press_fits  True if bushes that are pressed into its bores are in the stress; without it a part
            with such a bush has no formula
    arcs    True if its bores are solved for the pressure on the arc of `PartLoads.arc`
    """

    shape: type[S]
    stress: Callable[[Part, S, PartLoads], RungModel | None]
    family: Callable[[Part, S, PartLoads, str], str] = _by_name
    tilts: bool = False
    statics: bool = False
    press_fits: bool = False
    arcs: bool = False
