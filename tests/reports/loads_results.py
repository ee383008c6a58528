"""The toggle press of the tests of `loads` as a result for people, and a hostile one."""

from dataclasses import replace

import numpy as np

from checks.result.verdict import Gate
from loads import GROUND, Angle, Body, Cycle, Force, Linkage, Phase, Revolute, SteadyPace, run_cycle
from reports.loads_figures import ShownPhase
from reports.loads_summary import LoadsResult, ShownCycle

from ..loads.machines import press_cycle, slider_crank, toggle
from .results import HOSTILE


def shown(linkage, cycle, *, available=None, name="x", unit="mm", place=lambda value: 500 - value):
    solved = run_cycle(linkage, cycle)
    phases = tuple(
        ShownPhase(
            phase.name, place(start), place(stop), 0.5, phase.solve, tuple(map(str, phase.given))
        )
        for phase, (start, stop) in zip(cycle.phases, cycle.spans, strict=True)
    )
    return ShownCycle(
        loads=solved,
        shown_name=name,
        unit=unit,
        shown=place(solved.positions),
        pace="cylinder.length at 100 mm/s",
        duty=1.1e7,
        phases=phases,
        available=available or {},
        allowed_irregularity=0.1,
    )


def result(*cycles, gates=(), **changes):
    values = {
        "name": "Toggle press", "file": "designs/toggle_press.toml", "sha256": "ab" * 32,
        "overrides": [], "cycles": cycles, "gates": gates, "warnings": ["the stop is ASSUMED"],
        "absent": ["impact"], "assumed": [("duty", "one shift")],
        "command": "ballesta loads designs/toggle_press.toml",
    } | changes  # fmt: skip
    return LoadsResult(**values)


def press(**friction):
    linkage = toggle(**friction)
    available = {"cylinder": (11310.0, 12060.0)}
    return shown(linkage, press_cycle(linkage), available=available)


def crank(point="O"):
    """A slider-crank that turns once; its torque enters the crank at a point, or at none."""
    linkage = slider_crank(
        50.0, 200.0, crank_body={"mass": 1e-3}, rod_body={"mass": 1e-3}, slider_mass=1e-3
    )
    angle = Angle("crank", point=point)
    linkage = replace(linkage, forces=(Force("drive", angle), linkage.force("push")))
    turn = Phase("turn", 2 * np.pi, {"push": -100.0}, "drive")
    cycle = Cycle("run", angle, 0.0, SteadyPace(angle, 10.0), (turn,), 60)
    return shown(linkage, cycle, name="crank.angle", unit="deg", place=np.degrees)


GATES = (
    Gate("press: joints closed", 1e-13, 1e-6, "widest gap"),
    Gate("press: time of a cycle", 1.24, 1.0, "one cycle takes 3.73 s", binding=False),
    Gate("press: speed irregularity", 5.0, 0.1, "a flywheel of 3 kg m2"),
)


def hostile():
    """A pendulum whose every name is markup."""
    linkage = Linkage(
        bodies=(Body(GROUND, {HOSTILE: (0.0, 0.0)}), Body(HOSTILE, {HOSTILE: (0.0, 0.0)}, 1.0)),
        joints=(Revolute(HOSTILE, GROUND, HOSTILE, HOSTILE),),
        forces=(Force(HOSTILE, Angle(HOSTILE, point=HOSTILE)),),
        assembled={HOSTILE: (0.0, 0.0, 0.0)},
    )
    angle = Angle(HOSTILE)
    cycle = Cycle(
        HOSTILE, angle, 0.0, SteadyPace(angle, 1.0), (Phase(HOSTILE, 1.0, {}, HOSTILE),), 30
    )
    return result(
        shown(linkage, cycle, name=HOSTILE, unit="deg", place=np.degrees),
        name=HOSTILE, file=HOSTILE, warnings=[HOSTILE], absent=[HOSTILE],
        assumed=[(HOSTILE, HOSTILE)], overrides=[HOSTILE], command=HOSTILE,
        gates=[Gate(HOSTILE, 2.0, 1.0, HOSTILE)],
    )  # fmt: skip
