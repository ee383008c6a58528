"""Puts the cylinders of a design together."""

from collections.abc import Mapping

import loads
from checks.design.data import Cylinder
from checks.design.errors import Problems, no_such
from checks.design.materials import Material
from checks.design.model import DesignFile
from checks.design.tables import Available, CylinderEntry
from geometry.bars import RulingSection
from geometry.parameters import ParameterError

_SAME = 1e-9  # a length that is stated twice


def cylinders_of(
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    materials: Mapping[str, Material],
    problems: Problems,
) -> dict[str, Cylinder]:
    """Return the cylinders whose entries are in order."""
    found = {}
    for name, entry in file.cylinders.items():
        before = len(problems)
        key = f"cylinders.{name}"
        between = [one for one in file.forces if file.forces[one].between is not None]
        if entry.force not in between:
            problems.add(f"{key}.force", no_such("force between two points", entry.force, between))
        own = {
            field: _material(f"{key}.{field}", getattr(entry, field), section, materials, problems)
            for field, section in (
                ("material", RulingSection(entry.rod, round=True)),
                ("tube_material", RulingSection(entry.wall)),
            )
        }
        _check_sizes(key, entry, file, problems)
        rod, tube = own["material"], own["tube_material"]
        if len(problems) > before or rod is None or tube is None or entry.force not in forces:
            continue
        available = file.forces[entry.force].available
        pressure = available.pressure if isinstance(available, Available) else None
        found[name] = Cylinder(
            entry.force, entry.rod, entry.bore, entry.bore + 2 * entry.wall, entry.closed,
            entry.stroke, entry.tube, rod, tube, entry.guide or 0.0, entry.play or 0.0,
            pressure or 0.0,
        )  # fmt: skip
    return found


def _material(
    key: str,
    name: str,
    section: RulingSection,
    materials: Mapping[str, Material],
    problems: Problems,
) -> Material | None:
    if name not in materials:
        problems.add(key, no_such("material", name, materials))
        return None
    if not materials[name].ductile:
        problems.add(key, f"{name} is brittle; only ductile metals can be checked")
        return None
    try:
        return materials[name].of((section,))
    except ParameterError as error:
        problems.add(key, error.problem)
        return None


def _check_sizes(key: str, entry: CylinderEntry, file: DesignFile, problems: Problems) -> None:
    if entry.rod >= entry.bore:
        problems.add(f"{key}.rod", f"must be thinner than the bore of {entry.bore:g} mm")
    if entry.tube >= entry.closed:
        problems.add(
            f"{key}.tube", f"must be shorter than closed, {entry.closed:g} mm: the rod's eye is out"
        )
    if entry.stroke >= entry.tube:
        problems.add(
            f"{key}.stroke",
            f"must be shorter than the tube, {entry.tube:g} mm, that it comes from",
        )
    if (entry.guide is None) != (entry.play is None):
        problems.add(key, "guide and play tell together how far the rod tilts in its tube")
    elif entry.guide is not None and entry.guide + entry.stroke > entry.tube:
        problems.add(
            f"{key}.guide", f"with the stroke must find room in the tube of {entry.tube:g} mm"
        )
    force = file.forces.get(entry.force)
    if force is None or not isinstance(force.available, Available):
        return
    for field in ("bore", "rod"):
        stated = getattr(force.available, field)
        if stated is not None and abs(stated - getattr(entry, field)) > _SAME * stated:
            problems.add(
                f"{key}.{field}",
                f"is {getattr(entry, field):g} mm, but forces.{entry.force}.available.{field} is "
                f"{stated:g} mm",
            )
