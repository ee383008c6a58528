"""Ranges of nominal stress over the duty by EN 1993-1-9:2005: welds, and threads of screws.

A factor on the ranges is sought with which they last the duty; the category over it is a check's
value (docs/theory/welds.md).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from checks.design.errors import DesignError
from checks.handbook.weld_details import STANDARD
from checks.part.derived import Heading
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Column, Derivation, Item, Step, Sum
from checks.result.verdict import Check
from checks.stress.duty_verdict import WHOLE_DUTY
from fatigue.life import AT_CUT_OFF, AT_KNEE, KNEE, Cycles
from geometry.mesh import IntArray

CURVE = f"{STANDARD}, 7.1"
MINER = 0.5  # at failure; EN 1993-1-9, A.6, has 1, which IIW finds not safe for its curve
MINER_SOURCE = "IIW XIII-1965-03, 4.3.1"
REACHED = (("D", "D_a"),)
_CLOSE = 1e-6  # of Miner's sum


def positions_of(run: slice) -> IntArray:
    """The positions of a cycle."""
    return np.arange(run.start, run.stop)


def miner_left(loaded: LoadedPart, of: str) -> float:
    """Miner's sum that earlier use has left; raises DesignError where it has left none."""
    left = MINER - loaded.duty.damage_so_far
    if not left > 0.0:
        raise DesignError(
            loaded.design.file,
            "duty.damage_so_far",
            f"{MINER - left:g} leaves {of} nothing of its Miner's sum of {MINER:g} "
            f"({MINER_SOURCE})",
        )
    return left


def damage_items(symbol: str, of: str, cycles: Cycles) -> list[Item]:
    """Knee and cut-off of a category S_C, and Miner's sum of n times some cycles."""
    formula = f"choose(n*r, S_L, m/{KNEE:.0f}*(n*r/S_D)^choose(n*r, S_D, 3, 5), 0)"
    return [
        Step("S_D", "range at the knee", f"{AT_KNEE:.15g}*S_C", "MPa", CURVE),
        Step("S_L", "cut-off", f"{AT_CUT_OFF:.15g}*S_C", "MPa", CURVE),
        miner_sum(symbol, of, cycles, formula),
    ]


def miner_sum(symbol: str, of: str, cycles: Cycles, formula: str) -> Sum:
    """Miner's sum of cycles, a row for each kind of them."""
    rows = range(len(cycles.cycle_counts))
    return Sum(
        symbol,
        f"Miner's sum of {of} under n times the loads",
        formula,
        tuple(str(row + 1) for row in rows),
        (
            Column("r", "range", "MPa", tuple(cycles.stress_range.tolist())),
            Column("m", "how often in the life", "", tuple(cycles.cycle_counts.tolist())),
        ),
        "",
        f"{STANDARD}, (A.1)",
    )


def reached(damage: float, allowed: float) -> tuple[tuple[str, str], ...]:
    """The pair that agrees in a derivation; none at a cut-off, where damage jumps over its limit.

    >>> reached(0.5, 0.5), reached(0.3, 0.5)
    ((('D', 'D_a'),), ())
    """
    return REACHED if abs(damage - allowed) <= _CLOSE else ()


def over_duty(
    loaded: LoadedPart,
    heading: Heading,
    ends: Sequence[int],
    derivation: Derivation,
    partial_factor: float,
) -> Check:
    """The check of a range between two of all positions, whose least safety is stated."""
    check = loaded.derived(heading, ends[1], derivation)
    names = [loaded.loads.cycle_names[k] for k in ends]
    labels = [loaded.loads.labels[k] for k in ends]
    if names[0] != names[1]:
        labels = [f"{name} {label}" for name, label in zip(names, labels, strict=True)]
    return replace(
        check,
        cycle=names[0] if names[0] == names[1] else WHOLE_DUTY,
        position=" to ".join(labels),
        required=max(check.required, partial_factor),
    )
