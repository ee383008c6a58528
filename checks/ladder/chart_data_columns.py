"""Plain data of a part as a column: where it stands among the column curves, plane by plane."""

from typing import Any

from checks.columns.column_limits import Plane, planes_of
from checks.columns.stability import axial_compression, judged_columns, worst_compression
from checks.design.data import Part
from checks.part.loaded_part import LoadedPart


def column_data(loaded: LoadedPart) -> dict[str, Any] | None:
    """The column of least safety in each plane, under the largest compression of all positions.

    youngs_modulus, yield  MPa
    required     safety against buckling
    curve        Eurocode 3's, if the part states one
    cycle, position  of the largest compression
    force        cycle -> (n,) N, axial compression; below 0 it is tension
    planes       one entry each: section, its area (mm2), slenderness, the least slenderness that
                 stiffer ends could give, effective length (mm), axial stress (MPa), limit (MPa)
                 and its law, eta of Perry and Robertson where it is not 0.003 times the slenderness

    None for a part that has no sections or is never compressed.
    """
    part, loads = loaded.part, loaded.loads
    worst = worst_compression(part, loads)
    if worst is None:
        return None
    force = axial_compression(part, loads)
    return {
        "youngs_modulus": part.material.youngs_modulus,
        "yield": part.material.yield_stress,
        "required": loaded.required.buckling,
        "curve": part.column.curve,
        "cycle": loads.cycle_names[worst],
        "position": loads.labels[worst],
        "force": {name: force[columns].tolist() for name, columns in loads.cycles.items()},
        "planes": [
            _plane_data(part, plane, float(force[worst]))
            for plane in planes_of(loaded.design, part)
        ],
    }


def _plane_data(part: Part, plane: Plane, force: float) -> dict[str, Any]:
    curve = part.column.curve
    judged = judged_columns(part, plane, force)
    case, stress, _ = judged.deciding
    return {
        "plane": plane.name,
        "section": case.section.name,
        "area": case.section.area,
        "slenderness": case.strength.slenderness,
        "stiffest": min(judged.held.strength.slenderness, case.strength.slenderness),
        "length": case.length,
        "stress": stress,
        "limit": case.limit(curve),
        "law": case.law(curve),
        "eta": case.eta,
    }
