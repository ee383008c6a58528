"""The loads as one HTML page that stands alone: moving pictures, charts, gates and extremes."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.result.words import brief, number, place_text, quantity_unit
from geometry.mesh import FloatArray
from reports.charts import curves_chart
from reports.files import plain, write_text
from reports.loads_figures import BlowForceSummary, BlowSummary, Extremes
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
from reports.templating import environment, joined, json_markup, script_hash


def write_loads_page(result: LoadsResult, path: str | Path) -> None:
    """Write the page as a file, which is there whole or not at all."""
    write_text(path, loads_html(result))


def loads_html(result: LoadsResult) -> str:
    """Page as text. The same result gives the same page."""
    script = _script()
    text: str = _template().render(
        result=result,
        said=header_sentences(result),
        broken=broken_by_kind(result.gates),
        cycles=[_cycle(cycle, f"c{number_of}") for number_of, cycle in enumerate(result.cycles)],
        runs=[{"run": run, "chart": Markup(_run_chart(run))} for run in result.runs],
        script=Markup(script),
        script_hash=Markup(script_hash(script)),
    )
    return text


def _cycle(cycle: ShownCycle, prefix: str) -> dict[str, Any]:
    """Data of one cycle for the template, beside the cycle itself."""
    return {
        "cycle": cycle,
        "svg": Markup(mechanism_svg(cycle, prefix)),
        "data": json_markup(plain(mechanism_data(cycle, prefix))),
        "scale": arrow_scale(cycle),
        "chart": Markup(_chart(cycle)),
        "blows": [
            Markup(_blow_chart(cycle, blow, blow.solved))
            for blow in cycle.blows
            if blow.solved is not None
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


def _chart(cycle: ShownCycle) -> str:
    """Forces, torques and reactions over the shown position; of a start or stop over the time.

    In several turns it comes through a place again and again.
    """
    loads = cycle.loads
    phases = [cycle.phase_at(index) for index in range(len(cycle.shown))]
    panels = []
    for title, quantity, angular, curves in (
        (
            "Forces", "force", False,
            {f.name: loads.efforts[f.name] for f in loads.linkage.forces
             if not f.coordinate.angular},
        ),
        (
            "Torques", "torque", True,
            {f.name: loads.efforts[f.name] for f in loads.linkage.forces if f.coordinate.angular}
            | ({} if cycle.motor is None else {"motor, geared": cycle.motor.torque}),
        ),
        (
            "Reactions of the joints", "resultant", False,
            {name: np.hypot(*load.force.T) for name, load in loads.reactions.items()},
        ),
    ):  # fmt: skip
        panels += _panel(title, quantity, angular, curves)
    if cycle.motor is not None:
        speed = cycle.motor.speed * 60.0 / (2.0 * np.pi)
        panels.append(("Speed by the motor", "speed [rpm]", {"angle that sets the pace": speed}))
    at, axis = cycle.shown, f"{brief(cycle.shown_name, 20)} [{cycle.unit}]"
    if cycle.event is not None:
        at, axis = loads.times, "time [s]"
    return curves_chart(f"Loads {brief(cycle.name, 40)}", at, phases, panels, axis)


def _blow_chart(cycle: ShownCycle, blow: BlowSummary, solved: BlowForceSummary) -> str:
    """Force of a blow and reactions of the joints over the time since the touch."""
    loads = cycle.loads
    since = loads.times - blow.time
    rows = np.flatnonzero((since >= 0.0) & (since <= (1.0 + 1e-9) * solved.until))
    panels = _panel(
        "Force of the blow", "force", False, {blow.force: loads.efforts[blow.force][rows]}
    )
    joints = {name: np.hypot(*load.force[rows].T) for name, load in loads.reactions.items()}
    panels += _panel("Reactions of the joints", "resultant", False, joints)
    phases = [cycle.phase_at(index) for index in rows.tolist()]
    title = f"Blow of {brief(blow.force, 30)} in {brief(cycle.name, 40)}"
    return curves_chart(title, since[rows] * 1e3, phases, panels, "time since the touch [ms]")


def _run_chart(run: ShownRun) -> str:
    """Forces and moments that were measured, over the shown position."""
    acting = [(body, load) for body in run.loads.bodies for load in run.loads.body_loads(body)]
    panels = []
    for title, quantity, angular, curves in (
        (
            "Forces on the bodies", "resultant", False,
            {f"{body} at {load.point}": np.hypot(*load.force.T) for body, load in acting},
        ),
        (
            "Moments on the bodies", "moment", True,
            {f"{body} at {load.point}": load.moment for body, load in acting},
        ),
    ):  # fmt: skip
        panels += _panel(title, quantity, angular, curves)
    if not panels:
        return ""
    phases = [run.loads.phases[k] for k in run.loads.phase_of]
    axis = f"{brief(run.shown_name, 20)} [{run.unit}]"
    return curves_chart(f"Loads {brief(run.name, 40)}", run.shown, phases, panels, axis)


def _panel(
    title: str, quantity: str, angular: bool, curves: Mapping[str, FloatArray]
) -> list[tuple[str, str, dict[str, FloatArray]]]:
    """A panel of curves in the unit of their largest value; none where all are 0."""
    curves = {name: values for name, values in curves.items() if np.any(values)}
    if not curves:
        return []
    unit, factor = quantity_unit(angular, max(np.abs(c).max() for c in curves.values()))
    return [(title, f"{quantity} [{unit}]", {n: np.asarray(c * factor) for n, c in curves.items()})]


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


@cache
def _script() -> str:
    return joined("scripts/arrows.js", "templates/loads.js")


@cache
def _template() -> Any:
    found = environment()
    found.filters["extremes"] = extremes_cells
    return found.get_template("loads.html.j2")
