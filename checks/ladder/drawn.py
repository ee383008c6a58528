"""Stress to look at of a part whose checks needed no mesh: one solid of it, which decides nothing.

`ballesta check --fields`: designers want to see where a part is stressed, also where a formula has
settled its verdict. One mesh is enough for that; it has no error bar, and the page says so.
"""

from collections.abc import Sequence
from dataclasses import replace

from checks.ladder.levels import Say, first_level
from checks.ladder.part_fields import solid_fields
from checks.part.loaded_part import LoadedPart
from checks.result.live_fields import LiveFields
from checks.result.verdict import PartResult
from checks.strength.fatigue_assessment import FatigueUse
from checks.stress.solid_mesh_level import Models
from checks.stress.symmetry import shown_surface
from fem.solvers import SolverError
from geometry.mesh import MeshError, TooManyElementsError

TO_LOOK_AT = ", to look at"  # ends the names of its fields
_UNDRAWN = "no mesh to look at: "


def with_drawn_fields(
    loaded: LoadedPart, use: FatigueUse | None, result: PartResult, models: Models, say: Say
) -> PartResult:
    """The result of a part with fields of one mesh, if its own model has none all over it.

    use  how its fatigue is judged; None where it is not

    A part that cannot be meshed or solved stays as it is, and the page says why.
    """
    loads = loaded.loads
    live = result.live
    if not isinstance(live, LiveFields) or (live.n_fields and not live.estimated):
        return result
    say(f"{loaded.part.name}: meshing, to draw its stress")
    try:
        level = first_level(loaded, models)
    except (MeshError, SolverError, TooManyElementsError) as error:
        return replace(result, live=undrawn(live, str(error)))
    methods = ", ".join(dict.fromkeys(check.method for check in result.checks))
    note = (
        "drawn from one mesh, to be looked at: its stress has no error bar and decides no check; "
        f"the checks are decided by {methods}"
    )
    drawn = solid_fields(loads, level, use)
    drawn = replace(drawn, decides=False, judged=False, notes=(note, *drawn.notes))
    surface = shown_surface(loads, level)
    named = {f"{name}{TO_LOOK_AT}": values for name, values in surface.fields.items()}
    return replace(result, live=drawn, surface=replace(surface, fields=named))


def undrawn(live: LiveFields, why: str) -> LiveFields:
    """The fields that a part has without a mesh, and why there is none."""
    told = _UNDRAWN + why
    return replace(live, missing=dict.fromkeys(live.missing, told), notes=(told, *live.notes))


def undrawn_warnings(results: Sequence[PartResult]) -> list[str]:
    """Parts whose stress was asked for and could not be drawn, and why."""
    return [
        f"{result.name}: {note}"
        for result in results
        if isinstance(result.live, LiveFields)
        for note in result.live.notes
        if note.startswith(_UNDRAWN)
    ]
