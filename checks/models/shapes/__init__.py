"""The rung `formula`, vectorised over positions: every module here models a shape or several alike.

A module has a `ShapeModel` of each. It is found by being here, or by the entry point group
`ballesta.shape_models` of another package, whose entries name a `ShapeModel` (docs/extending.md).
A shape without a model is checked as a solid only.
"""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import cast

from checks.design.data import Part
from checks.models.shape_model import S, ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from geometry.shape import Shape

GROUP = "ballesta.shape_models"


@cache
def registered() -> Mapping[type[Shape], object]:
    """Shape -> its model; raises ImportError for a module that is not there."""
    modules = [import_module(f"{__name__}.{one.name}") for one in iter_modules(__path__)]
    stated = [thing for module in modules for thing in vars(module).values()]
    own = [thing for thing in stated if isinstance(thing, ShapeModel)]
    others = [point.load() for point in entry_points(group=GROUP)]
    return {model.shape: model for model in (*own, *others)}


def shape_model(shape: S) -> ShapeModel[S] | None:
    """Return the model of a part's shape; None for one that has none."""
    return cast(ShapeModel[S] | None, registered().get(type(shape)))


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula; None for one that no formula is known for."""
    model = shape_model(part.geometry)
    if model is None or (loads.press_fits and not model.press_fits):
        return None
    return model.stress(part, part.geometry, loads)


def why_none(part: Part, loads: PartLoads) -> str:
    """Why no formula is known for a part, in words."""
    model = shape_model(part.geometry)
    if model is not None and loads.press_fits and not model.press_fits:
        return "the formula of this shape knows no bush that is pressed in"
    return "there is no formula of this shape"


def family_of(part: Part, loads: PartLoads, kind: str) -> str:
    """Name of the solids that a kind of check is compared with: those that carry loads alike.

    It begins with the part's shape.
    """
    model = shape_model(part.geometry)
    return part.shape if model is None else model.family(part, part.geometry, loads, kind)
