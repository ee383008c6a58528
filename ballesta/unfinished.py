"""Partial result of a check that was stopped, from the parts that it had finished."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from checks.result.verdict import DesignResult, Gate, PartResult, RungTried

FRAME, PART = "frame", "part "  # names under which a check keeps things
Keep = Callable[[str, Any], None]


@dataclass(frozen=True, eq=False)
class KeptPart:
    """Result of a part so far.

    left      kinds of checks that a better model may still settle; none of a final result
    warnings  that belong to it
    """

    result: PartResult
    left: Sequence[str]
    warnings: Sequence[str]


def with_parts(
    frame: DesignResult, parts: Sequence[PartResult], warnings: Sequence[str]
) -> DesignResult:
    """The result of a design from what is known of its loads, and the results of its parts."""
    cycles = {}
    for name, data in frame.cycles.items():
        peaks = {p.name: p.charts["peaks"][name] for p in parts if name in p.charts["peaks"]}
        cycles[name] = {**data, "peaks": peaks}
    solvers = sorted({mesh["solver"] for part in parts for mesh in part.meshes})
    return replace(
        frame,
        parts=parts,
        cycles=cycles,
        warnings=[*warnings, *frame.warnings],
        versions={**frame.versions, **({"solver": ", ".join(solvers)} if solvers else {})},
    )


def without_live(result: PartResult) -> PartResult:
    """The result without the fields of the live view, which may be large."""
    return replace(result, live=None)


def unfinished(recovered: Callable[[str], Any], why: str) -> DesignResult | None:
    """The result of a check that was ended; None if no part of it was known.

    recovered  what was kept under a name, None for nothing
    why        it was ended

    What was left open stays open: a rung that was not finished is named with what it may settle,
    and a part of which nothing is known breaks a gate.
    """
    if recovered(FRAME) is None:
        return None
    frame, names = recovered(FRAME)
    parts, warnings, gates = [], [], []
    for name in names:
        kept: KeptPart | None = recovered(f"{PART}{name}")
        if kept is None:
            warnings.append(f"{name}: not checked at all: {why}")
            gates.append(Gate(f"{name}: every check was made", 1.0, 0.0, f"none was: {why}"))
            continue
        warnings += kept.warnings
        result = kept.result
        if kept.left:
            said = f"{why} before it was finished; it may settle {', '.join(kept.left)}"
            warnings.append(f"{name}: a better model than {result.rungs[-1].rung}: {said}")
            result = replace(result, rungs=[*result.rungs, RungTried("solid", 0.0, 0, [], said)])
        parts.append(result)
    if not parts:
        return None
    warnings.append(f"{why}: the report has no pictures and no live view")
    whole = with_parts(frame, parts, warnings)
    return replace(whole, gates=[*whole.gates, *gates])
