"""Plain data of a part's convergence: what is judged, on every mesh, with its error bar."""

from collections.abc import Mapping, Sequence
from typing import Any

from checks.stress.error_bars import Judged, mesh_bar
from checks.stress.solid_mesh_level import Level


def convergence_data(
    levels: Sequence[Level], judged: Mapping[str, Judged]
) -> dict[str, list[dict[str, Any]]]:
    """Kind of check -> one entry per mesh, coarse to fine.

    unknowns  of the mesh
    half      whether the mesh is half of the part
    value     MPa
    bar       MPa, what a finer mesh makes smaller of the numerical error; None on the first mesh
    """
    return {
        kind: [
            {
                "unknowns": level.unknowns,
                "half": level.half,
                "value": what.value(level),
                "bar": mesh_bar(what, levels[: k + 1]) * abs(what.value(level)) if k else None,
            }
            for k, level in enumerate(levels)
        ]
        for kind, what in judged.items()
    }
