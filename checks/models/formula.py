"""The rung `formula`: handbook models of the parts, vectorised over positions."""

from checks.design.data import Part
from checks.models.formula_cad import step_part_model
from checks.models.formula_leaves import leaf_pack_model
from checks.models.formula_levers import slotted_lever_model
from checks.models.formula_pins import pin_model
from checks.models.formula_plates import plate_link_model
from checks.models.formula_rods import tube_rod_model
from checks.models.formula_tubes import prismatic_tube_model, toggle_bar_model
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel
from geometry.parts import (
    LeafPack,
    Pin,
    PlateLink,
    PrismaticTube,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.parts.step_part import StepPart


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula; None for one that no formula is known for."""
    match part.geometry:
        case PlateLink() as shape:
            return plate_link_model(part, shape, loads)
        case ToggleBar() as shape:
            return toggle_bar_model(part, shape, loads)
        case PrismaticTube() as shape:
            return prismatic_tube_model(part, shape, loads)
        case Pin() as shape:
            return pin_model(part, shape, loads)
        case SlottedLever() as shape:
            return slotted_lever_model(part, shape, loads)
        case TubeRod() as shape:
            return tube_rod_model(part, shape, loads)
        case LeafPack() as shape:
            return leaf_pack_model(part, shape, loads)
        case StepPart() as shape:
            return step_part_model(part, shape, loads)
        case _:
            return None
