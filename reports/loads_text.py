"""Loads as text for a terminal or a pipe: reactions, efforts, drives, contacts by cycle."""

from collections.abc import Sequence
from pathlib import Path

from checks.result.verdict import Gate
from checks.result.words import brief, clean, gate_word, number, place_text, quantity_unit
from reports.loads_figures import Extremes
from reports.loads_summary import LoadsResult, ShownCycle, ShownRun
from reports.loads_words import (
    blow_sentence,
    broken_by_kind,
    contact_sentence,
    drive_sentences,
    event_sentence,
    header_sentences,
)
from reports.terminal import labelled, line_width, table

_LONGEST_NAME = 18
_MOST_PHASES = 12  # more are turns of a start or a stop


def loads_text(
    result: LoadsResult, width: int | None = None, files: Sequence[str | Path] = ()
) -> str:
    """All loads as plain lines of at most `width` columns (paths are never broken).

    width  None: the terminal's width (COLUMNS counts), and 100 when piped
    """
    width = line_width(width)
    lines = labelled("", f"{brief(result.name, 60)} ({brief(result.file, 60)})", width)
    for override in result.overrides:
        lines += labelled("SET", brief(override, 200), width)
    for sentence in header_sentences(result):
        lines += labelled("", sentence, width)
    for cycle in result.cycles:
        lines += ["", *_cycle(cycle, width)]
    for run in result.runs:
        lines += ["", *_run(run, width)]
    if result.gates:
        lines += ["", *_gates(result.gates, width)]
    if result.warnings:
        lines.append("")
    for warning in result.warnings:
        lines += labelled("WARNING", brief(warning, 400), width)
    absent = ", ".join(brief(item, 120) for item in result.absent)
    lines += ["", *labelled("NOT IN THESE LOADS", absent, width)]
    if result.assumed:
        items = "; ".join(f"{brief(key, 48)} ({brief(what, 200)})" for key, what in result.assumed)
        lines += labelled("ASSUMED", f"{len(result.assumed)}: {items}", width)
    lines += [f"written: {clean(file)}" for file in files]
    return "\n".join(lines) + "\n"


def _cycle(cycle: ShownCycle, width: int) -> list[str]:
    at = f"at [{cycle.unit}]"
    duty = f"{number(cycle.duty)} times in its life" if cycle.duty else "in no duty"
    lines = labelled(
        "",
        f"CYCLE {brief(cycle.name, 40)}: {cycle.duration:.4g} s, {len(cycle.shown)} positions of "
        f"{brief(cycle.shown_name, 30)} [{cycle.unit}], {duty}; pace {brief(cycle.pace, 100)}",
        width,
    )
    phases = [
        [
            brief(phase.name, _LONGEST_NAME),
            place_text(phase.start),
            place_text(phase.stop),
            number(phase.time),
            brief(phase.solve, _LONGEST_NAME),
            "; ".join(phase.given) or "nothing",
        ]
        for phase in cycle.phases
    ]
    if len(phases) > _MOST_PHASES:
        left = len(phases) - 6
        phases[3:-3] = [[f"{left} more", "", "", "", "", "between these, turn by turn"]]
    unit = f"[{cycle.unit}]"
    heads = ["phase", f"from {unit}", f"to {unit}", "time [s]", "solves", "given"]
    lines += table(heads, phases, {1, 2, 3}, width, between="  ")
    several = len(cycle.phases) > 1
    rows = []
    for joint in cycle.joints:
        first = [f"{brief(joint.name, _LONGEST_NAME)}", joint.kind]
        first += [brief(joint.on, _LONGEST_NAME), brief(joint.by, _LONGEST_NAME)]
        for extremes in joint.extremes:
            cells = _extremes(extremes, several, joint.largest(extremes.angular))
            rows.append([*first, extremes.quantity, *cells])
            first = ["", "", "", ""]
    headings = ["joint", "kind", "on", "by", "", "unit", "min", at, "max", at]
    lines += ["", *table(headings, rows, {6, 7, 8, 9}, width, between="  ")]
    rows = [
        [
            brief(effort.quantity, _LONGEST_NAME),
            brief(cycle.role(effort.quantity), 30),
            *_extremes(effort, several, effort.largest),
            number(effort.mean * quantity_unit(effort.angular, effort.largest)[1], 4),
        ]
        for effort in cycle.efforts
    ]
    headings = ["effort", "", "unit", "min", at, "max", at, "mean over time"]
    lines += ["", *table(headings, rows, {3, 4, 5, 6, 7}, width, between="  ")]
    if cycle.drives or cycle.contacts:
        lines.append("")
    for drive in cycle.drives:
        said = "; ".join(drive_sentences(drive, cycle))
        lines += labelled("drive", f"{brief(drive.name, 30)}: {said}", width)
    if cycle.event is not None:
        lines += labelled("event", event_sentence(cycle.event), width)
    for contact in cycle.contacts:
        lines += labelled("contact", contact_sentence(contact, cycle), width)
    for blow in cycle.blows:
        lines += labelled("blow", blow_sentence(blow, cycle), width)
    return lines


def _run(run: ShownRun, width: int) -> list[str]:
    at = f"at [{run.unit}]"
    duty = f"{number(run.duty)} times in its life" if run.duty else "in no duty"
    time = "without times" if run.duration is None else f"{run.duration:.4g} s"
    lines = labelled(
        "",
        f"RUN {brief(run.name, 40)}: measured in {brief(run.file, 60)}; {time}, {len(run.shown)} "
        f"positions of {brief(run.shown_name, 30)} [{run.unit}] from {place_text(run.shown[0])} to "
        f"{place_text(run.shown[-1])}, {duty}",
        width,
    )
    rows = []
    for point in run.points:
        first = [brief(point.body, _LONGEST_NAME), brief(point.point, _LONGEST_NAME)]
        for extremes in point.extremes:
            cells = _extremes(extremes, False, point.largest(extremes.angular))
            rows.append([*first, extremes.quantity, *cells])
            first = ["", ""]
    headings = ["on", "at", "", "unit", "min", at, "max", at]
    return [*lines, *table(headings, rows, {4, 5, 6, 7}, width, between="  ")]


def _extremes(extremes: Extremes, several: bool, largest: float) -> list[str]:
    """Unit, which the largest value of its kind sets, least, where, largest, where."""
    unit, factor = quantity_unit(extremes.angular, largest)
    cells = [unit]
    for value, at, phase in (
        (extremes.low, extremes.low_at, extremes.low_phase),
        (extremes.high, extremes.high_at, extremes.high_phase),
    ):
        where = place_text(at) + (f" {brief(phase, 14)}" if several else "")
        cells += [number(value * factor, 4), where]
    return cells


def _gates(gates: Sequence[Gate], width: int) -> list[str]:
    rows = [
        [gate_word(gate), brief(gate.name, 60), number(gate.value), number(gate.limit)]
        for gate in gates
    ]
    lines = table(["", "validity check", "value", "limit"], rows, {2, 3}, width, between="  ")
    for broken in broken_by_kind(gates):
        word = "BROKEN" if broken.binding else "DOES NOT HOLD"
        lines += labelled(word, f"{brief(broken.sentence, 300)}. {broken.told}", width)
    return lines
