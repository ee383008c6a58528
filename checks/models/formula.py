"""The rung `formula`: handbook models of the parts, vectorised over positions."""

from checks.design.data import Part
from checks.models.shapes import shape_model
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula; None for one that no formula is known for."""
    model = shape_model(part.geometry)
    return None if model is None else model.stress(part, part.geometry, loads)


def family_of(part: Part, loads: PartLoads, kind: str) -> str:
    """Name of the solids that a kind of check is compared with: those that carry loads alike.

    It begins with the part's shape.
    """
    model = shape_model(part.geometry)
    return part.shape if model is None else model.family(part, part.geometry, loads, kind)
