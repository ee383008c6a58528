"""A leaf pack between its two bounds: leaves that slide on each other freely, and glued together.

The model's leaves slide without friction: the pack has n times the stiffness of one leaf. Friction
between them stiffens it, at the most as far as a bonded pack, n^3 times: n^2 times stiffer, and
under an equal bending moment with 1/n of the stress, M (n t/2) / (n^3 I) against M (t/2) / (n I).
Where a deflection is imposed the moment is n^2 times as large, and so the stress n times.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

import loads
from ballesta.design_data import Design, Part
from ballesta.levels import Level, Models, solve_level
from ballesta.machine import cycle_of
from ballesta.part_loads import PartLoads, loads_on
from ballesta.solid import FIRST, elastic_of, endurance_of
from fem.tie_tension import tie_tension
from geometry.parts import LeafPack
from reports.verdict import Check, Gate, PartResult

# Tension over compression: worth telling; and where ties pull as hard as they press.
_GAPS, _OPEN = 0.25, 1.0

_Compliance = loads.BeamCompliance | loads.MatrixCompliance | loads.JointCompliance
Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


def with_leaf_checks(
    design: Design,
    part: Part,
    result: PartResult,
    part_loads: PartLoads,
    solved: Solved,
    models: Models,
) -> PartResult:
    """Return a pack's result with its gaps' gate and the model bands of bonded leaves."""
    shape = part.geometry
    if not isinstance(shape, LeafPack) or shape.leaves == 1:
        return result
    free = _level(design, part, part_loads, models)
    bonded = _bonded(design, part, shape, free, solved, models)
    return replace(
        result,
        checks=[_banded(check, bonded) for check in result.checks],
        gates=[*result.gates, gap_gate(part, shape, free)],
    )


def gap_gate(part: Part, shape: LeafPack, level: Level) -> Gate:
    """How far the ties between leaves pull beside the clamps, over how far they press.

    Inside a clamp the leaves are squeezed together, which is in no load. Beside it a little tension
    comes with bending near a load; where it is more than the compression the ties carry the pack.
    """
    clamps = [
        (centre - length / 2, centre + length / 2)
        for centre, length in ((0.0, shape.clamp_length), (shape.length, shape.rod_length))
    ]
    tension, compression = tie_tension(level.solutions, level.coefficients, clamps)
    share = tension / compression if compression else (inf if tension else 0.0)
    return Gate(
        f"{part.name}: gaps between leaves",
        share,
        _GAPS,
        f"largest tension beside the clamps, {tension:.3g} MPa, between leaves that must not part, "
        f"over the largest compression, {compression:.3g} MPa, on the first mesh; the verdict "
        f"depends on it above {_OPEN:g}",
        binding=share > _OPEN,
    )


@dataclass(frozen=True)
class _Bonded:
    """Stress of the bonded pack over that of the separate leaves, and under what.

    static, fatigue  1; infinite if the bonded pack's loads could not be found
    """

    static: float
    fatigue: float
    words: str


def _bonded(
    design: Design, part: Part, shape: LeafPack, free: Level, solved: Solved, models: Models
) -> _Bonded:
    """Stress of a bonded pack under its own loads, those of an n^2 times stiffer body."""
    count = shape.leaves
    stiffer = [
        name
        for name, cycle in solved.items()
        if isinstance(cycle, loads.CycleLoads) and _gives(part, cycle)
    ]
    if not stiffer:
        return _Bonded(
            1 / count,
            1 / count,
            f"forces are imposed on it, so a bonded pack has 1/{count} of the stress",
        )
    try:
        other = dict(solved) | {
            name: _stiffened(design, part, solved[name], count**2) for name in stiffer
        }
        again = _level(design, part, loads_on(design, part, other), models)
    except loads.LinkageError as error:
        return _Bonded(inf, inf, f"a bonded pack's loads cannot be found: {error}")
    static = again.peak.value / free.peak.value / count if free.peak.value else 1.0
    fatigue = static
    if free.fatigue is not None and again.fatigue is not None and free.fatigue.value:
        fatigue = again.fatigue.value / free.fatigue.value / count
    return _Bonded(
        static,
        fatigue,
        f"contacts impose a deflection on it in {', '.join(stiffer)}, solved again with {count**2} "
        "times its bending stiffness",
    )


def _gives(part: Part, cycle: loads.CycleLoads) -> bool:
    """Whether the part's body gives way in front of a contact of the cycle."""
    return bool(cycle.touches) and any(
        isinstance(entry, loads.BeamCompliance | loads.MatrixCompliance) and entry.body == part.body
        for entry in cycle.linkage.compliance
    )


def _stiffened(
    design: Design, part: Part, cycle: loads.CycleLoads | loads.MeasuredLoads, factor: float
) -> loads.CycleLoads:
    """Solve a cycle again with a body that bends `factor` times less."""
    assert isinstance(cycle, loads.CycleLoads)

    def stiffer(entry: _Compliance) -> _Compliance:
        if isinstance(entry, loads.JointCompliance) or entry.body != part.body:
            return entry
        if isinstance(entry, loads.MatrixCompliance):
            return replace(entry, matrix=entry.matrix / factor)
        bending = None if entry.bending is None else factor * entry.bending
        return replace(entry, bending=bending)

    linkage = replace(
        cycle.linkage, compliance=tuple(stiffer(entry) for entry in cycle.linkage.compliance)
    )
    return loads.run_cycle(linkage, cycle_of(design, design.cycles[cycle.name]))


def _level(design: Design, part: Part, part_loads: PartLoads, models: Models) -> Level:
    """Solve a part on its first mesh under some loads."""
    fineness = FIRST * part.fineness
    solutions = models.solutions(part.geometry, fineness, elastic_of(part))
    return solve_level(
        solutions,
        fineness,
        part_loads,
        endurance_of(part).value,
        part.material.ultimate_stress,
        design.duty.cycles,
        part.geometry.notch_factors,
    )


def _banded(check: Check, bonded: _Bonded) -> Check:
    """Widen the model band of a stress check to the bonded pack's stress."""
    if check.kind not in ("static", "fatigue"):
        return check
    ratio = bonded.static if check.kind == "static" else bonded.fatigue
    above = max(0.0, ratio - 1) * check.value
    below = max(0.0, 1 - ratio) * check.value if np.isfinite(ratio) else 0.0
    told = f"bonded {ratio * check.value:.4g} MPa" if np.isfinite(ratio) else "bonded: unknown"
    return replace(
        check,
        model=check.model + above,
        model_below=check.below + below,
        note=f"{check.note}{'; ' if check.note else ''}leaves slide freely; {told}: {bonded.words}",
    )
