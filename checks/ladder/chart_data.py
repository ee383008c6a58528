"""Plain data of a part's charts, whatever model its stress comes from.

    peaks        cycle -> (n,) MPa, largest von Mises stress at each position
    by           the model of these: "formula", "beam" or "solid"
    haigh        diagram of the critical point by Goodman's line (checks.ladder.chart_data_fatigue)
    fkm          the same by the FKM guideline's
    sn           S-N line and the duty's cycles, of either chain
    column       stress and slenderness as a column (checks.by_formula.column)
    convergence  the judged stresses on every mesh (checks.ladder.chart_data_meshes)

Keys without data are left out; the pages say why.
"""

from collections.abc import Sequence
from typing import Any

from checks import by_formula
from checks.ladder.chart_data_fatigue import fkm_data, haigh_data, life_data
from checks.ladder.chart_data_meshes import convergence_data
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.strength.fatigue_assessment import FatigueUse, FkmUse
from checks.strength.part_strength import life_task
from checks.stress.error_bars import Judged, StaticPeak
from checks.stress.part_model import RungLevel
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed

SOLID = "solid"


def charts_of(
    loaded: LoadedPart,
    level: Stressed,
    use: FatigueUse | None,
    levels: Sequence[Level] = (),
) -> dict[str, Any]:
    """Plain data of a part's charts.

    level   whose stress is reported
    use     how its fatigue is judged, None without a cycle of the duty
    levels  of its meshes, coarse to fine; none of a part that was not meshed
    """
    part, loads = loaded.part, loaded.loads
    charts: dict[str, Any] = {
        "peaks": {
            name: level.peaks_by_position[columns].tolist()
            for name, columns in loads.cycles.items()
        },
        "by": level.model.rung if isinstance(level, RungLevel) else SOLID,
    }
    if isinstance(use, FkmUse):
        charts["fkm"], charts["sn"] = fkm_data(loaded, level, use)
    elif use is not None:
        peak = use.worst(level)
        charts["haigh"] = haigh_data(part, level, peak)
        charts["sn"] = life_data(loaded, level, peak, life_task(part, loaded.duty))
    charts |= by_formula.charts(loaded)
    if len(levels) > 1:
        charts["convergence"] = convergence_data(levels, _judged(loads, use))
    return charts


def _judged(loads: PartLoads, use: FatigueUse | None) -> dict[str, Judged]:
    static: dict[str, Judged] = {"static": StaticPeak(loads)}
    return static if use is None else static | {"fatigue": use}
