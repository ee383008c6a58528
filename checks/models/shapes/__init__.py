"""Models of the shapes by formula: every module here is the model of one shape of `geometry.parts`.

A module has a `ShapeModel` as `MODEL`. It is found by being here, or by the entry point group
`ballesta.shape_models` of another package, whose entries name a `ShapeModel` (docs/extending.md).
A shape without a model is checked as a solid only.
"""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import cast

from checks.models.shape_model import S, ShapeModel
from geometry.shape import Shape

GROUP = "ballesta.shape_models"


@cache
def registered() -> Mapping[type[Shape], object]:
    """Shape -> its model; raises ImportError for a module that is not there."""
    own = [import_module(f"{__name__}.{one.name}").MODEL for one in iter_modules(__path__)]
    others = [point.load() for point in entry_points(group=GROUP)]
    return {model.shape: model for model in (*own, *others)}


def shape_model(shape: S) -> ShapeModel[S] | None:
    """Return the model of a part's shape; None for one that has none."""
    return cast(ShapeModel[S] | None, registered().get(type(shape)))
