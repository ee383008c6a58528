"""Loads as text for a terminal or a pipe: reactions, efforts, drives, contacts by cycle."""

from collections.abc import Sequence
from pathlib import Path
from shutil import get_terminal_size

from rich.cells import cell_len

from reports.loads_figures import ContactSummary, Direction, DriveSummary, Extremes
from reports.loads_summary import LoadsResult, ShownCycle
from reports.terminal import labelled, wrap
from reports.verdict import Gate
from reports.words import brief, clean, gate_word, number, place_text, quantity_unit

SIGNS = (
    "Reactions are what a joint does to the body under “on”; the body under “by” gets the "
    "opposite. Axes of the ground: x to the right, y up, moments counter-clockwise."
)
_LONGEST_NAME = 18


def loads_text(
    result: LoadsResult, width: int | None = None, files: Sequence[str | Path] = ()
) -> str:
    """Everything as plain lines of at most `width` columns (paths are never broken).

    Without a width that of the terminal is taken (COLUMNS counts), and 100 when piped.
    """
    width = max(60, width or get_terminal_size((100, 24)).columns)
    lines = labelled("", f"{brief(result.name, 60)} ({brief(result.file, 60)})", width)
    for override in result.overrides:
        lines += labelled("SET", brief(override, 200), width)
    lines += labelled("", SIGNS, width)
    for cycle in result.cycles:
        lines += ["", *_cycle(cycle, width)]
    if result.gates:
        lines += ["", *_gates(result.gates, width)]
    if result.warnings:
        lines.append("")
    for warning in result.warnings:
        lines += labelled("WARNING", brief(warning, 400), width)
    absent = ", ".join(brief(item, 120) for item in result.absent)
    lines += ["", *labelled("NOT IN THESE LOADS", absent, width)]
    if result.assumed:
        items = "; ".join(f"{brief(key, 48)} ({brief(what, 48)})" for key, what in result.assumed)
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
            brief(phase.solve, _LONGEST_NAME),
            "; ".join(phase.given) or "nothing",
        ]
        for phase in cycle.phases
    ]
    unit = f"[{cycle.unit}]"
    lines += table(
        ["phase", f"from {unit}", f"to {unit}", "solves", "given"], phases, {1, 2}, width
    )
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
    lines += ["", *table(headings, rows, {6, 7, 8, 9}, width)]
    rows = [
        [
            brief(effort.quantity, _LONGEST_NAME),
            brief(cycle.role(effort.quantity), 30),
            *_extremes(effort, several, effort.largest),
            number(effort.mean * quantity_unit(effort.angular, effort.largest)[1], 4),
        ]
        for effort in cycle.efforts
    ]
    headings = ["effort", "", "unit", "min", at, "max", at, "mean"]
    lines += ["", *table(headings, rows, {3, 4, 5, 6, 7}, width)]
    if cycle.drives or cycle.contacts:
        lines.append("")
    for drive in cycle.drives:
        lines += labelled("drive", _drive(drive, cycle), width)
    for contact in cycle.contacts:
        lines += labelled("contact", contact_sentence(contact, cycle), width)
    return lines


def _extremes(extremes: Extremes, several: bool, largest: float) -> list[str]:
    """Unit, which the largest value of its kind sets, least, where, largest, where."""
    unit, factor = quantity_unit(extremes.angular, largest)
    cells = [unit]
    for value, at, phase in (
        (extremes.low, extremes.low_at, extremes.low_phase),
        (extremes.high, extremes.high_at, extremes.high_phase),
    ):
        where = place_text(at) + (f" {brief(phase, 9)}" if several else "")
        cells += [number(value * factor, 4), where]
    return cells


def direction_sentence(direction: Direction, angular: bool, cycle: ShownCycle) -> str:
    """The largest effort of a drive in one direction against what is available."""
    unit, factor = quantity_unit(angular, max(direction.needed, direction.available or 0.0))
    said = (
        f"{direction.words} up to {number(direction.needed * factor, 4)} {unit} at "
        f"{brief(cycle.shown_name, 20)} = {place_text(direction.at)} {cycle.unit}"
    )
    if direction.available is None:
        return said
    share = direction.needed / direction.available
    return f"{said} of {number(direction.available * factor, 4)} {unit} available ({share:.1%})"


def power_sentence(drive: DriveSummary) -> str:
    """Mean and peak power of a drive and its work."""
    return (
        f"mean power {number(drive.mean_power * 1e-3)} W, "
        f"peak {number(drive.peak_power * 1e-3)} W, work {number(drive.work * 1e-3)} J a cycle"
    )


def flywheel_sentence(drive: DriveSummary) -> str:
    """How unevenly a closed crank cycle would turn; "" where that does not apply."""
    if drive.irregularity is None or drive.flywheel is None:
        return ""
    assert drive.reduced_inertia is not None
    assert drive.ripple is not None
    return (
        f"reduced inertia {number(drive.reduced_inertia * 1e-3)} kg m2 in the mean; the torque's "
        f"ripple of {number(drive.ripple * 1e-3)} J would make the speed irregular by "
        f"{number(drive.irregularity)}; {number(drive.allowed)} needs "
        f"{number(drive.flywheel * 1e-3)} kg m2 in all"
    )


def contact_sentence(contact: ContactSummary, cycle: ShownCycle) -> str:
    """Where a contact touches, how hard and how fast."""
    name, shown = brief(contact.name, 30), brief(cycle.shown_name, 20)
    if contact.first_at is None or contact.last_at is None:
        return f"{name}: does not touch in this cycle"
    unit, factor = quantity_unit(contact.angular, contact.largest)
    length, speed = ("rad", "rad/s") if contact.angular else ("mm", "mm/s")
    return (
        f"{name}: touches from {shown} = {place_text(contact.first_at)} to "
        f"{place_text(contact.last_at)} {cycle.unit} (first in {brief(contact.phase, 20)}), up to "
        f"{number(contact.largest * factor, 4)} {unit}, the linkage gives way by "
        f"{number(contact.deflection)} {length}; met at {number(contact.approach_speed)} {speed} "
        f"with {number(contact.energy * 1e-3)} J: the impact is not in these loads"
    )


def _drive(drive: DriveSummary, cycle: ShownCycle) -> str:
    directions = [direction_sentence(d, drive.angular, cycle) for d in drive.directions]
    sentences = [*directions, power_sentence(drive), flywheel_sentence(drive)]
    return f"{brief(drive.name, 30)}: " + "; ".join(text for text in sentences if text)


def _gates(gates: Sequence[Gate], width: int) -> list[str]:
    broken = [gate for gate in gates if not gate.holds]
    rows = [
        [gate_word(gate), brief(gate.name, 60), number(gate.value), number(gate.limit)]
        for gate in gates
    ]
    lines = table(["gate", "", "value", "limit"], rows, {2, 3}, width)
    for gate in broken:
        lines += labelled(gate_word(gate), f"{brief(gate.name, 60)}: {gate.meaning}", width)
    return lines


def table(
    headings: Sequence[str], rows: Sequence[Sequence[str]], right: set[int], width: int
) -> list[str]:
    """Aligned columns of at most `width` together; `right` are set to the right.

    Where they are too wide, the widest columns wrap.
    """
    columns = range(len(headings))
    widths = [max(cell_len(row[i]) for row in (headings, *rows)) for i in columns]
    room = width - 2 - 2 * (len(widths) - 1)
    while sum(widths) > room:
        widest = max(columns, key=lambda i: widths[i])
        if widths[widest] <= 8:
            break
        widths[widest] -= 1
    lines = []
    for row in (headings, *rows):
        wrapped = [wrap(cell, wide) for cell, wide in zip(row, widths, strict=True)]
        for level in range(max(map(len, wrapped))):
            cells = []
            for i, cell in enumerate(wrapped):
                text = cell[level] if level < len(cell) else ""
                gap = " " * (widths[i] - cell_len(text))
                cells.append(gap + text if i in right else text + gap)
            lines.append(("  " + "  ".join(cells)).rstrip())
    return lines
