"""The loads as one HTML page that stands alone: moving pictures, charts, gates and extremes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.result.words import brief, number, place_text, quantity_unit
from geometry.mesh import FloatArray
from reports.charts.chart import Chart, largest
from reports.charts.over_cycle import Curve, CycleAxis, Panel, cycle_axis, cycle_table, over_cycle
from reports.files import plain, write_text
from reports.loads_figures import BlowSummary, Extremes
from reports.loads_summary import LoadsResult, ShownCycle, ShownRun
from reports.loads_words import (
    blow_sentence,
    broken_by_kind,
    contact_sentence,
    drive_sentences,
    event_sentence,
    header_sentences,
)
from reports.mechanism_panel import arrow_scale, mechanism_data, mechanism_svg
from reports.templating import joined, json_markup, page_template, script_hash


def write_loads_page(result: LoadsResult, path: str | Path) -> None:
    """Write the page as a file, which is there whole or not at all."""
    write_text(path, loads_html(result))


def loads_html(result: LoadsResult) -> str:
    """Page as text. The same result gives the same page."""
    script = joined("scripts/arrows.js", "templates/loads.js")
    return page_template("loads", extremes=extremes_cells).render(
        result=result,
        said=header_sentences(result),
        broken=broken_by_kind(result.gates),
        cycles=[_cycle(index, cycle) for index, cycle in enumerate(result.cycles)],
        runs=[
            {"run": run, "charts": _run_chart(index, run)}
            for index, run in enumerate(result.runs, start=len(result.cycles))
        ],
        script=Markup(script),
        script_hash=Markup(script_hash(script)),
    )


def _cycle(index: int, cycle: ShownCycle) -> dict[str, Any]:
    """Data of one cycle for the template, beside the cycle itself."""
    prefix = f"c{index}"
    return {
        "cycle": cycle,
        "svg": Markup(mechanism_svg(cycle, prefix)),
        "data": json_markup(plain(mechanism_data(cycle, prefix))),
        "scale": arrow_scale(cycle),
        "charts": [
            *_chart(index, cycle),
            *(chart for blow in cycle.blows for chart in _blow_chart(index, cycle, blow)),
        ],
        "drives": [
            (drive.name, drive_sentences(drive, cycle)) for drive in cycle.drives
        ],
        "contacts": [
            *([] if cycle.event is None else [f"Event: {event_sentence(cycle.event)}"]),
            *(contact_sentence(contact, cycle) for contact in cycle.contacts),
            *(f"Blow of {blow_sentence(blow, cycle)}" for blow in cycle.blows),
        ],
        "joints": cycle.joints,
        "efforts": cycle.efforts,
    }  # fmt: skip


def _chart(index: int, cycle: ShownCycle) -> list[Chart]:
    """Forces, torques and reactions over the shown position; of a start or stop over the time.

    In several turns it comes through a place again and again.
    """
    loads = cycle.loads
    forces = loads.linkage.forces
    panels = [
        *_panel("forces", False, {f.name: loads.efforts[f.name] for f in forces
                                  if not f.coordinate.angular}),
        *_panel("torques", True, {f.name: loads.efforts[f.name] for f in forces
                                  if f.coordinate.angular}
                | ({} if cycle.motor is None else {"motor, geared": cycle.motor.torque})),
        *_panel("reactions of the joints", False, _reactions(cycle)),
    ]  # fmt: skip
    if cycle.motor is not None:
        speed = cycle.motor.speed * 60.0 / (2.0 * np.pi)
        panels.append(
            Panel("speed by the motor", "rpm", [Curve("angle that sets the pace", speed)])
        )
    at, name, unit = cycle.shown, cycle.shown_name, cycle.unit
    if cycle.event is not None:
        at, name, unit = loads.times, "time", "s"
    phases = [cycle.phase_at(k) for k in range(len(cycle.shown))]
    axis = _axis(index, at, name, unit, phases, loads.times)
    return _drawn(f"Loads over cycle {brief(cycle.name, 40)}", axis, panels, "")


def _blow_chart(index: int, cycle: ShownCycle, blow: BlowSummary) -> list[Chart]:
    """Force of a blow and reactions of the joints over the time since the touch."""
    if blow.solved is None:
        return []
    since = cycle.loads.times - blow.time
    rows = np.flatnonzero((since >= 0.0) & (since <= (1.0 + 1e-9) * blow.solved.until))
    panels = [
        *_panel("force of the blow", False, {blow.force: cycle.loads.efforts[blow.force][rows]}),
        *_panel(
            "reactions of the joints", False, {k: v[rows] for k, v in _reactions(cycle).items()}
        ),
    ]
    phases = [cycle.phase_at(k) for k in rows.tolist()]
    axis = _axis(index, since[rows] * 1e3, "time since the touch", "ms", phases)
    title = f"Blow of {brief(blow.force, 30)} in {brief(cycle.name, 40)}"
    return _drawn(title, axis, panels, "A blow, as far as it is followed.")


def _reactions(cycle: ShownCycle) -> dict[str, FloatArray]:
    return {name: np.hypot(*load.force.T) for name, load in cycle.loads.reactions.items()}


def _run_chart(index: int, run: ShownRun) -> list[Chart]:
    """Forces and moments that were measured, over the shown position."""
    acting = [(body, load) for body in run.loads.bodies for load in run.loads.body_loads(body)]
    forces = {f"{body} at {load.point}": np.hypot(*load.force.T) for body, load in acting}
    moments = {f"{body} at {load.point}": load.moment for body, load in acting}
    panels = [
        *_panel("forces on the bodies", False, forces),
        *_panel("moments on the bodies", True, moments),
    ]
    phases = [run.loads.phases[k] for k in run.loads.phase_of]
    axis = _axis(index, run.shown, run.shown_name, run.unit, phases, run.loads.times)
    return _drawn(f"Loads of run {brief(run.name, 40)}", axis, panels, "")


def _axis(
    index: int,
    at: FloatArray,
    name: str,
    unit: str,
    phases: Sequence[str],
    times: FloatArray | None = None,
) -> CycleAxis | None:
    said = {"position": at, "shown_name": name, "unit": unit, "phase": phases, "time": times}
    return cycle_axis(index, said)


def _drawn(title: str, axis: CycleAxis | None, panels: Sequence[Panel], told: str) -> list[Chart]:
    """The chart with its table; none without positions, or where all is 0."""
    if axis is None or not panels:
        return []
    svg, series = over_cycle(title, axis, panels)
    columns, rows = cycle_table(axis, panels)
    told = f"{told} {axis.scales_told}".strip()
    return [Chart("loads", title, told, svg, columns, rows, series)]


def _panel(quantity: str, angular: bool, curves: Mapping[str, FloatArray]) -> list[Panel]:
    """A panel of curves in the unit of their largest value; none where all are 0."""
    curves = {name: values for name, values in curves.items() if np.any(values)}
    if not curves:
        return []
    unit, factor = quantity_unit(angular, largest(curves))
    return [Panel(quantity, unit, [Curve(name, factor * c) for name, c in curves.items()])]


def extremes_cells(extremes: Extremes, largest: float) -> list[str]:
    """Least, where, largest, where, mean, and the unit that the largest of its kind sets."""
    unit, factor = quantity_unit(extremes.angular, largest)
    return [
        number(extremes.low * factor, 4),
        f"{place_text(extremes.low_at)}, {brief(extremes.low_phase, 24)}",
        number(extremes.high * factor, 4),
        f"{place_text(extremes.high_at)}, {brief(extremes.high_phase, 24)}",
        number(extremes.mean * factor, 4),
        unit,
    ]
