"""Doubts about the loads as pairs of load histories, and the one about friction.

A doubt that has a pair needs no validity check: the loads at its ends are in the bars of every
check of the parts.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import loads
from checks.design.data import Design
from checks.result.verdict import Gate

Solved = Mapping[str, loads.CycleLoads]
_FRICTION = 1.0 / 3.0  # of a coefficient: a stated one is known to a third at best


@dataclass(frozen=True, eq=False)
class LoadPair:
    """A doubt about the loads, by the cycles at its two ends.

    gate  name of the validity check that the pair takes the place of; empty for none
    """

    words: str
    ends: tuple[Solved, Solved]
    gate: str = ""


def friction_gate(cycle: str) -> str:
    """Name of the validity check of a cycle's friction."""
    return f"{cycle}: share of friction"


def friction_pairs(design: Design, solved: Solved) -> tuple[list[LoadPair], list[Gate]]:
    """The loads of every cycle with friction a third lower and a third higher than stated.

    All coefficients go the same way. Where no loads balance the higher ones (self-locking), no bar
    tells anything: a validity check that does not hold stands for that cycle.
    """
    pairs, gates = [], []
    for name, cycle in solved.items():
        if not any(one.coefficient for one in cycle.linkage.friction.values()):
            continue
        run = design.cycles[name].run
        try:
            low, high = (
                loads.run_cycle(_with_friction(cycle.linkage, factor), run)
                for factor in (1.0 - _FRICTION, 1.0 + _FRICTION)
            )
        except loads.LinkageError as error:
            gates.append(_unbalanced(name, str(error)))
            continue
        words = f"{name}: coefficients of friction a third lower or higher"
        ends = ({**solved, name: low}, {**solved, name: high})
        pairs.append(LoadPair(words, ends, friction_gate(name)))
    return pairs, gates


def _with_friction(linkage: loads.Linkage, factor: float) -> loads.Linkage:
    scaled = {
        joint: replace(one, coefficient=factor * one.coefficient)
        for joint, one in linkage.friction.items()
    }
    return replace(linkage, friction=scaled)


def _unbalanced(cycle: str, problem: str) -> Gate:
    return Gate(
        f"{cycle}: friction a third from its stated coefficients",
        1.0,
        0.0,
        "cycles that cannot be solved there, and a coefficient of friction is known to a third at "
        f"best: {problem}",
        cure="Less friction, or a mechanism farther from self-locking",
    )
