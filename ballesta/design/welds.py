"""Reads the welds of a part: where they stand, on which walls, and their categories."""

from typing import Any

from checks.design.data import Weld
from checks.design.errors import Problems, listed
from checks.design.materials import Material
from checks.design.model import WeldEntry
from checks.handbook.weld_details import HIGHEST, STANDARD, category_of
from geometry.bars import Walls
from geometry.parameters import ParameterError
from geometry.parts import SHAPES
from geometry.shape import Shape

_STEEL = (185e3, 220e3)  # MPa, Young's modulus of steels


def welds_of(
    key: str, entry: Any, geometry: Shape, material: Material, problems: Problems
) -> tuple[Weld, ...]:
    """The welds of a part that are in order; what is wrong with the others is noted."""
    found: list[Weld] = []
    if getattr(entry, "welds", ()) and not _STEEL[0] <= material.youngs_modulus <= _STEEL[1]:
        problems.add(
            f"{key}.welds",
            f"welds are judged by {STANDARD}, which is of steel; {material.name} is none, as its "
            f"Young's modulus of {material.youngs_modulus / 1e3:.4g} GPa says; leave them out",
        )
        return ()
    for index, stated in enumerate(getattr(entry, "welds", ())):
        here = f"{key}.welds[{index}]"
        try:
            new = _weld(stated, geometry)
        except ParameterError as error:
            problems.add(f"{here}.{error.field}", error.problem)
            continue
        if any(one.place == new.place for one in found):
            problems.add(f"{here}.at", f"another weld of the part stands at {new.place}")
        found.append(new)
    return tuple(found)


def _weld(stated: WeldEntry, geometry: Shape) -> Weld:
    """A weld; raises ParameterError where there is no wall, or none that its detail is for."""
    walls = _walls_at(stated.at, geometry)
    if stated.throat is not None and stated.throat > walls.wall:
        raise ParameterError(
            "throat",
            f"{stated.throat:g} mm is more than the wall of {walls.wall:g} mm; it must be at most "
            f"{walls.wall:g} mm; is {stated.throat:g} mm the leg, which is 1.41 times the throat?",
        )
    if (stated.detail is None) == (stated.category is None):
        raise ParameterError("detail", "needs either detail or category, one of the two")
    category, where = _stated_category(stated) if stated.category else _of_detail(stated, walls)
    return Weld(stated.at, walls, category, where, stated.throat, stated.partial_factor)


def _walls_at(at: float, geometry: Shape) -> Walls:
    if not geometry.walls:
        able = sorted(name for name, one in SHAPES.items() if one.walls is not Shape.walls)
        raise ParameterError(
            "at",
            "the part has no stretch with even walls, away from holes, of which the stress at a "
            f"weld is known; shapes that have one are {listed(able)}",
        )
    for walls in geometry.walls:
        if walls.stretch[0] <= at <= walls.stretch[1]:
            return walls
    spans = listed("{:.4g} to {:.4g} mm".format(*one.stretch) for one in geometry.walls)
    raise ParameterError(
        "at", f"at {at:g} mm the stress is not that of even walls; it is from {spans}"
    )


def _stated_category(stated: WeldEntry) -> tuple[float, str]:
    assert stated.category is not None
    if stated.category > HIGHEST:
        raise ParameterError(
            "category",
            f"{stated.category:g} MPa is above {HIGHEST:g} MPa, the highest of {STANDARD}, figure "
            "7.1",
        )
    if stated.length is not None:
        raise ParameterError("length", "is of a detail; a stated category needs none")
    return stated.category, "stated in the design"


def _of_detail(stated: WeldEntry, walls: Walls) -> tuple[float, str]:
    """Category of a named detail, MPa, and where it is from."""
    assert stated.detail is not None
    if walls.outline == "round" and 2 * walls.wall >= walls.size:
        raise ParameterError(
            "detail",
            f"{stated.detail!r}: {STANDARD} has it of tubes, the part is a solid rod there; state "
            "a category of another source",
        )
    try:
        category, row = category_of(stated.detail, walls.outline, walls.wall, stated.length)
    except ValueError as error:
        raise ParameterError("detail", f"{stated.detail!r}: {error}") from None
    if row.throat and stated.throat is None:
        raise ParameterError("throat", "must be stated: the root of a fillet weld carries the load")
    if stated.throat is not None and not row.throat:
        raise ParameterError(
            "throat", f"{stated.detail!r} has no root that carries load; leave it out"
        )
    return category, f"{STANDARD}, {row.where}"
