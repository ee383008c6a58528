"""Starts and stops of a design: read, counted in the duty, judged and told."""

import re
from math import pi
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.cli import main
from ballesta.commands.loads_command import loads_of_file
from ballesta.machine.solved_cycles import event_figures, solve_cycles, with_events
from ballesta.machine.validity_checks import load_gates
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.design.errors import DesignError
from reports.loads_page import _chart
from reports.loads_text import loads_text

from ...small_machine import MACHINE, PLATE, machine

DOCUMENT = Path(__file__).parents[3] / "docs" / "theory" / "motors.md"
MOTOR = (
    'drive.motor={power="0.37 kW", speed="1370 rpm", free_speed="1500 rpm", breakdown=2.3, '
    'starting=2.0, inertia="0.001 kg m2"}'
)
FLYWHEEL = 'drive.flywheel="0.4 kg m2"'
BRAKE = 'drive.brake={torque="60 N m", delay="50 ms"}'
STOP = 'events.stop={cycle="turn", kind="brake", at="420 deg"}'
FINE = "cycles.turn.positions=91"
ALL = (MOTOR, FLYWHEEL, BRAKE, STOP, FINE)


def solved(design):
    whole = with_events(design, {})
    return whole, solve_cycles(whole, {})


def test_the_example_of_the_document_runs(tmp_path):
    """Four cycles, of which three are events with the counts of the duty; every gate holds."""
    (example,) = re.findall(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE[: MACHINE.index("[duty]")] + example, encoding="utf-8")
    result = loads_of_file(file, [FINE])
    assert [cycle.name for cycle in result.cycles] == ["turn", "start", "stop", "emergency"]
    assert [cycle.duty for cycle in result.cycles] == [1e6, 5000, 4800, 200]
    assert not result.broken
    assert dict(result.assumed)["events.start.at"].startswith("none is stated: crank.angle = ")
    assert "events.stop.at" not in dict(result.assumed)
    said = " ".join(loads_text(result).split())
    assert "to rest by the brake at crank.angle = 200 deg:" in said
    assert "in the steady run" in said
    assert "stands in the duty but is not closed" not in said
    charts = (_chart(index, cycle) for index, cycle in enumerate(result.cycles))
    turn, *events = (chart.svg for (chart,) in charts)
    assert all("time [s]" in chart and "crank.angle [deg]" not in chart for chart in events)
    assert "time [s]" not in turn


def test_a_stop_has_the_way_of_the_delay_and_then_of_its_energy(tmp_path):
    """A rotor of 0.4 + 0.206 kg m2: rod and slider add a hundredth; nothing pushes."""
    free = "cycles.turn.phases[0].forces.push=0 N"
    design, cycles = solved(machine(tmp_path, PLATE, *ALL, free))
    figures = event_figures(design, cycles["stop"])
    speed = np.abs(cycles["stop"].rate("drive"))
    assert figures.shown_name == "crank.angle"
    assert figures.at == pytest.approx(420.0)
    assert figures.tried == 0
    by_hand = 0.05 + 605.8 * speed[0] / 6e4
    assert_allclose(figures.time, by_hand, rtol=0.03)
    assert_allclose(figures.time, cycles["stop"].times[-1])
    assert speed[-1] < 1e-3
    work = cycles["stop"].drive("drive").work
    path = np.trapezoid(cycles["stop"].efforts["drive"] * speed, cycles["stop"].times)
    assert_allclose(work, path, rtol=1e-2)
    gates = {gate.name: gate for gate in load_gates(design, cycles)}
    assert gates["stop: energy of the brake"].holds
    assert "to rest by the brake" in gates["stop: energy of the brake"].meaning
    assert "stop: time of a cycle" not in gates


def test_a_harder_brake_is_seen_by_static_and_fatigue(tmp_path):
    """Forces of the brake on the crank reach the rod as its slider's inertia."""
    heavy = ("bodies.slider.mass=30 kg", "cycles.turn.phases[0].forces.push=0 N")
    counted = "duty.cycles={turn=1e6, stop=1000}"
    found = {}
    for torque in ("60 N m", "3000 N m"):
        brake = f'drive.brake={{torque="{torque}"}}'
        design = machine(tmp_path, PLATE, MOTOR, FLYWHEEL, brake, STOP, FINE, counted, *heavy)
        result = check_design(design, effort=Effort("formula"))
        found[torque] = {check.kind: check for check in result.parts[0].checks}
        assert result.cycles["stop"]["duty"] == 1000
    for kind in ("static", "fatigue"):
        assert found["3000 N m"][kind].value > 2.0 * found["60 N m"][kind].value
        assert found["3000 N m"][kind].cycle in ("stop", "between cycles")


def test_an_event_outside_the_duty_is_judged_statically_alone(tmp_path):
    heavy = ("bodies.slider.mass=30 kg", 'drive.brake={torque="3000 N m"}')
    design = machine(tmp_path, PLATE, *ALL, *heavy)
    checks = {c.kind: c for c in check_design(design, effort=Effort("formula")).parts[0].checks}
    assert checks["static"].cycle == "stop"
    assert checks["fatigue"].cycle == "turn"


def test_nothing_is_between_two_turns_of_an_event(tmp_path):
    """The second turn begins where the first one ends: loads go on there, over no way at all."""
    event = 'events.start={cycle="turn", kind="start", turns=2.5}'
    turn = "cycles.turn.start=200 deg", "cycles.turn.phases[0].to=560 deg"
    counted = "duty.cycles={turn=1e6, start=1000}"
    design = machine(tmp_path, PLATE, MOTOR, FLYWHEEL, FINE, event, counted, *turn)
    checks = {c.kind: c for c in check_design(design, effort=Effort("formula")).parts[0].checks}
    for kind in ("fatigue", "bearing"):  # 0.7 and 0.2 times the value, did they go back by a turn
        assert 0.0 < checks[kind].sampling < 0.01 * checks[kind].value


def test_a_start_tells_how_long_it_takes(tmp_path):
    """J w / T with T between standstill and breakdown, 2 to 2.3 times rated, less the load."""
    event = 'events.start={cycle="turn", kind="start", at="90 deg"}'
    free = "cycles.turn.phases[0].forces.push=0 N"
    design, cycles = solved(machine(tmp_path, PLATE, MOTOR, FLYWHEEL, FINE, event, free))
    figures = event_figures(design, cycles["start"])
    torque = 14.347 * 0.37e6 / (1370 * pi / 30)  # rated, on the crank
    whole = 400.0 + 1.0 * 14.347**2
    low, high = (whole * 10.0 / (share * torque) for share in (2.3, 1.4))
    assert low < figures.time < high
    assert cycles["start"].phases[0] == "round 1"


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        ((MOTOR.replace("starting=2.0, ", ""), FLYWHEEL, 'events.a={cycle="turn", kind="start"}'),
         r"drive.motor.starting: must be stated for events.a"),
        ((MOTOR, FLYWHEEL, STOP), r"drive.brake: must be stated for events.stop"),
        ((BRAKE,), r"drive.brake: needs drive.motor"),
        (('events.a={cycle="turn", kind="coast"}',), r"events.a: needs drive.motor"),
        ((*ALL, 'events.stop.cycle="turm"'), r"events.stop.cycle: .*did you mean"),
        ((*ALL, "events.stop.turns=2.0"), r"events.stop.turns: is of a start"),
        ((MOTOR, 'events.turn={cycle="turn", kind="coast"}'), r"events.turn: turn is the name"),
        ((*ALL, 'events.stop.at="3 mm"'), r"events.stop.at: must be an angle"),
        ((MOTOR, 'events.a={cycle="turn", kind="coast", motor="on"}'), r"events.a.motor: is of"),
        ((MOTOR.replace("starting=2.0", "starting=2.5"), ), r"is at most its breakdown torque"),
    ],
)  # fmt: skip
def test_an_event_that_does_not_fit_is_refused_by_its_key(tmp_path, overrides, said):
    with pytest.raises(DesignError, match=said):
        machine(tmp_path, PLATE, *overrides)


def test_a_start_that_stalls_is_an_input_that_is_wrong(tmp_path, capsys):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    start = 'events.start={cycle="turn", kind="start", at="270 deg"}'
    weak = MOTOR.replace("starting=2.0", "starting=0.2")
    heavy = 'drive.flywheel="4 kg m2"'
    sets = [part for one in (weak, heavy, start, FINE) for part in ("--set", one)]
    assert main(["loads", str(path), *sets]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "events.start: the start from rest at crank.angle = 270 deg stalls at" in said
    assert "N m are missing" in said
