"""Stress to look at of a part whose checks needed no mesh: one solid of it, which decides nothing.

`ballesta check --fields`: designers want to see where a part is stressed, also where a formula has
settled its verdict. One mesh is enough for that; it has no error bar, and the page says so.
"""

from dataclasses import replace

from ballesta.design_data import Design, Part
from ballesta.judged_fatigue import FatigueUse
from ballesta.levels import Models, solve_level
from ballesta.live_fields import solid_fields
from ballesta.part_loads import PartLoads
from ballesta.part_strength import elastic_of, endurance_of
from ballesta.solid import FIRST, Say, check_first_mesh
from fem.solvers import SolverError
from geometry.mesh import MeshError, TooManyElementsError
from reports.live.fields import LiveFields
from reports.verdict import PartResult

UNDRAWN = "no stress to look at: "


def with_drawn_fields(
    design: Design,
    part: Part,
    loads: PartLoads,
    use: FatigueUse | None,
    result: PartResult,
    models: Models,
    say: Say,
) -> PartResult:
    """The result of a part with fields of one mesh, if its own model has none all over it.

    use  how its fatigue is judged; None where it is not

    A part that cannot be meshed or solved stays as it is, and the page says why.
    """
    live = result.live
    if not isinstance(live, LiveFields) or live.n_fields:
        return result
    say(f"{part.name}: meshing, to draw its stress")
    try:
        drawn = _fields(design, part, loads, use, models)
    except (MeshError, SolverError, TooManyElementsError) as error:
        return replace(result, live=undrawn(live, str(error)))
    methods = ", ".join(dict.fromkeys(check.method for check in result.checks))
    note = (
        "drawn from one mesh, to be looked at: its stress has no error bar and decides no check; "
        f"the checks are decided by {methods}"
    )
    drawn = replace(drawn, decides=False, judged=False, notes=(note, *drawn.notes))
    return replace(result, live=drawn)


def undrawn(live: LiveFields, why: str) -> LiveFields:
    """The bare surface of a part, and why it cannot be drawn with its stress."""
    told = UNDRAWN + why
    return replace(live, missing=dict.fromkeys(live.missing, told), notes=(*live.notes, told))


def _fields(
    design: Design, part: Part, loads: PartLoads, use: FatigueUse | None, models: Models
) -> LiveFields:
    fineness = FIRST * part.fineness
    check_first_mesh(part, 3 * len(models.mesh(part.geometry, fineness).nodes))
    solutions = models.solutions(part.geometry, fineness, elastic_of(part))
    level = solve_level(
        solutions,
        fineness,
        loads,
        endurance_of(part).value,
        part.material.ultimate_stress,
        design.duty.cycles,
        part.geometry.notch_factors,
    )
    return solid_fields(loads, level, use)
