"""A motor in a design: from its plate to the speed, the checks and the sentences of a cycle."""

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads
from ballesta.cli import main
from ballesta.machine.drive_speed import evenness_of, motor_figures, shown_cycle
from ballesta.machine.validity_checks import load_gates
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.design.errors import DesignError
from reports.loads_words import drive_sentences

from ...small_machine import MACHINE, PLATE, machine, solved

MOTOR = (
    'drive={motor={power="2.2 kW", speed="1430 rpm", free_speed="1500 rpm", breakdown=2.6, '
    'inertia="0.005 kg m2"}, flywheel="0.4 kg m2"}'
)


def test_a_plate_becomes_a_motor_whose_gear_gives_the_cycles_speed(tmp_path):
    """2.2 kW at 1430 rpm are 14.69 N m; 10 rad/s of the crank ask for a ratio of 14.97."""
    pace = machine(tmp_path, PLATE, MOTOR).cycles["turn"].run.pace
    assert isinstance(pace, loads.MotorPace)
    assert_allclose(pace.motor.motor.rated_torque, 2.2e6 / (1430 * pi / 30), rtol=1e-12)
    assert_allclose(pace.motor.ratio, 1430 * pi / 30 / 10.0)
    assert_allclose(pace.motor.inertia, 5.0)  # 0.005 kg m2 in t mm2
    assert_allclose(pace.inertia, 400.0)
    own = MOTOR.replace("breakdown=2.6", "breakdown=2.6, ratio=20.0, efficiency=0.9")
    geared = machine(tmp_path, PLATE, own).cycles["turn"].run.pace.motor
    assert (geared.ratio, geared.efficiency) == (20.0, 0.9)
    line = MOTOR.replace("breakdown=2.6", 'torque_limit="20 N m"')
    assert machine(tmp_path, PLATE, line).cycles["turn"].run.pace.motor.motor.most == 2e4


@pytest.mark.parametrize(
    ("text", "key", "said"),
    [
        (MOTOR.replace("flywheel=", 'control="constant", flywheel='), "drive", "states"),
        (MOTOR.replace("1430", "1510"), "drive.motor", "without load lies above its rated"),
        (MOTOR.replace("breakdown=2.6", 'breakdown=2.6, torque_limit="20 N m"'), "drive.motor",
         "not both"),
        (MOTOR.replace("2.2 kW", "2.2 N m"), "drive.motor.power", "must be a power such as"),
        (MOTOR.replace("breakdown", "breakdwon"), "drive.motor", "breakdown"),
    ],
)  # fmt: skip
def test_a_motor_that_cannot_be_is_refused_by_its_key(tmp_path, text, key, said):
    with pytest.raises(DesignError, match=said) as caught:
        machine(tmp_path, PLATE, text)
    assert key in str(caught.value)


def test_a_cycle_led_from_rest_to_rest_has_no_motor(tmp_path):
    law = 'cycles.turn.pace={coordinate="crank.angle", law="harmonic", time="1 s"}'
    with pytest.raises(DesignError, match=r"turn\.pace: must be the speed of an angle"):
        machine(tmp_path, PLATE, MOTOR, law)


def test_a_motor_that_stalls_is_an_input_that_is_wrong(tmp_path, capsys):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    weak = MOTOR.replace("2.2 kW", "2.2 W").replace("0.4 kg", "1e-9 kg").replace("0.005", "1e-9")
    against = 'cycles.turn.phases[0].forces.push={dry="400 N"}'
    assert main(["loads", str(path), "--set", weak, "--set", against]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "cycles.turn: the motor stalls at crank.angle =" in said
    assert "N m are missing" in said


def test_what_the_integration_cannot_follow_ends_as_numerics_that_gave_up_with_the_place(
    tmp_path, capsys
):
    """1 GW at a slip of 7e-8."""
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    stiff = MOTOR.replace("2.2 kW", "1 GW").replace("1430", "1499.9999").replace("2.6", "50.0")
    assert main(["loads", str(path), "--set", stiff]) == 3
    said = " ".join(capsys.readouterr().err.split())
    assert "cycles.turn" in said
    assert "rounding leaves of it, at crank.angle =" in said


def test_the_speed_is_the_motors_and_no_doubt_about_it_is_left(tmp_path):
    design = machine(tmp_path, PLATE, MOTOR)
    cycles = solved(design)
    figures = motor_figures(design, cycles["turn"])
    assert evenness_of(design, cycles) == {}
    speed = cycles["turn"].rate("drive")
    assert figures.slowest == speed.min() < speed.max() == figures.fastest
    # the drive's work over a turn is the push's: 400 N there and back, none in all; the motor
    # gives what it takes: nothing, but for what the positions miss
    assert abs(figures.power) < 1e-3 * np.abs(figures.torque).max() * figures.fastest
    even = machine(tmp_path, PLATE)
    assert motor_figures(even, solved(even)["turn"]) is None
    gates = {gate.name: gate for gate in load_gates(design, cycles)}
    assert gates["turn: energy of the motor"].holds
    assert "turn: effective torque of the motor" not in gates


def test_the_effective_torque_is_the_root_mean_square_of_the_motors(tmp_path):
    """By Kloss' formula over the speeds of the cycle; loads of 400 N against the motion."""
    against = 'cycles.turn.phases[0].forces.push={dry="400 N"}'
    design = machine(tmp_path, PLATE, MOTOR, against, "cycles.turn.positions=361")
    cycle = solved(design)["turn"]
    figures = motor_figures(design, cycle)
    slip = 1 - np.abs(cycle.rate("drive")) * (1430 * pi / 30 / 10) / (1500 * pi / 30)
    most = (1 - 1430 / 1500) * (2.6 + np.sqrt(2.6**2 - 1))
    torque = 2 * 2.6 * 2.2e6 / (1430 * pi / 30) / (slip / most + most / slip)
    mean_square = np.trapezoid(torque**2, cycle.times) / cycle.times[-1]
    assert_allclose(figures.effective, np.sqrt(mean_square), rtol=1e-3)
    assert_allclose(figures.largest, torque.max(), rtol=1e-9)
    work = 400.0 * 2 * np.ptp(cycle.coordinate("push"))
    assert_allclose(figures.power, work / cycle.times[-1], rtol=1e-3)


def test_a_motor_that_gets_too_hot_is_told_but_does_not_bind(tmp_path):
    weak = MOTOR.replace("2.2 kW", "0.05 kW").replace("0.4 kg", "0.02 kg")
    design = machine(tmp_path, PLATE, weak)
    gates = {gate.name: gate for gate in load_gates(design, solved(design))}
    gate = gates["turn: effective torque of the motor"]
    assert not gate.holds
    assert not gate.binding


def test_the_drive_says_how_the_motor_turns_it(tmp_path):
    design = machine(tmp_path, PLATE, MOTOR)
    shown = shown_cycle(design, solved(design)["turn"])
    (drive,) = shown.drives
    (said,) = [text for text in drive_sentences(drive, shown) if text.startswith("the motor")]
    mean = 2 * pi / shown.duration * 30 / pi
    assert f"the motor, geared 15.0 : 1, turns it at {mean:.4g} rpm in the mean" in said
    assert "14.7 N m rated" in said
    assert shown.to_dict()["motor"]["rated"] == pytest.approx(14_691, rel=1e-4)
    assert "speed" not in shown.to_dict()["motor"]
    assert shown.pace == "crank.angle by drive.motor"


def test_a_check_judges_the_loads_of_the_motors_speed(tmp_path):
    """By formula; a heavy flywheel is a constant speed of the same mean."""
    motored = check_design(
        machine(tmp_path, PLATE, MOTOR.replace("0.4 kg m2", "4000 kg m2")),
        effort=Effort("formula"),
    )
    mean = np.asarray(motored.cycles["turn"]["time"])[-1]
    even = check_design(
        machine(tmp_path, PLATE, 'drive={control="constant"}',
                f"cycles.turn.pace.speed={2 * pi / mean:.17g} rad/s"),
        effort=Effort("formula"),
    )  # fmt: skip
    for a, b in zip(motored.parts[0].checks, even.parts[0].checks, strict=True):
        assert a.kind == b.kind
        assert_allclose(a.value, b.value, rtol=1e-4)


def test_cycles_of_two_speeds_do_not_say_which_gear_the_machine_has(tmp_path):
    pace = '{ coordinate = "crank.angle", speed = "5 rad/s" }'
    second = f'\n[cycles.slow]\nlike = "turn"\npace = {pace}\n'
    with pytest.raises(DesignError, match=r"drive\.motor\.ratio: must be stated .* 29\.9 for 5"):
        machine(tmp_path, second + PLATE, MOTOR)
    geared = machine(tmp_path, second + PLATE, MOTOR, "drive.motor.ratio=20.0")
    assert {cycle.run.pace.motor.ratio for cycle in geared.cycles.values()} == {20.0}
