"""Bushes: mean pressure, and pressure times sliding speed over the cycle."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.bushes import bush_checks, bushes_not_checked
from ballesta.errors import DesignError
from ballesta.part_loads import loads_on
from reports.verdict import Status

from .small_machine import machine, solved

PIN = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "10 mm"
stack = [
  { body = "crank", at = "12 mm", width = "8 mm" },
  { body = "rod", at = "0 mm", width = "10 mm", bush = { length = "10 mm", BEARS } },
]
"""


def bushes(folder, pv=', pv = "1 MPa m/s"', **changes):
    text = PIN.replace("BEARS", f'allowable = "40 MPa"{pv}')
    for old, new in changes.items():
        text = text.replace(old, new)
    design = machine(folder, text)
    cycles = solved(design)
    part = design.parts["pin_A"]
    loads = loads_on(design, part, cycles)
    return design, part, cycles, loads


def test_p_v_is_pressure_times_the_speed_of_the_pin_in_the_lug(tmp_path):
    """The crank turns with 10 rad/s, the rod swings with (60 cos) / (l cos) of it: v = w d / 2."""
    design, part, cycles, loads = bushes(tmp_path)
    pressure, product = bush_checks(design, part, loads, cycles)
    cycle = cycles["turn"]
    rod = cycle.point("rod", "B") - cycle.point("rod", "A")
    crank = cycle.point("crank", "A")
    # x and y of B do not change along y: omega_rod = -omega_crank x_A / x_AB
    turning = -10.0 * crank[:, 0] / rod[:, 0]
    speed = np.abs(10.0 - turning) * 5.0
    p = loads.resultant("rod") / 100.0
    assert_allclose(pressure.value, p.max())
    assert_allclose(product.value, (p * speed).max() / 1e3, rtol=1e-9)
    assert_allclose(product.limit, 1.0)
    assert product.unit == "MPa m/s"
    assert "p v of the bush of rod" in product.quantity
    mean = np.trapezoid(p * speed, cycle.times) / np.ptp(cycle.times) / 1e3
    assert f"turn {mean:.3g}" in product.note


def test_p_v_above_the_allowable_fails_and_below_it_passes(tmp_path):
    value = bush_checks(*_arguments(bushes(tmp_path)))[1].value
    for factor, status in ((1.01, Status.PASS), (0.99, Status.FAIL)):
        found = bush_checks(*_arguments(bushes(tmp_path, f', pv = "{factor * value} MPa m/s"')))[1]
        assert found.status is status


def _arguments(found):
    design, part, cycles, loads = found
    return design, part, loads, cycles


def test_a_bush_in_the_body_that_the_pin_turns_with_does_not_slide(tmp_path):
    found = bush_checks(*_arguments(bushes(tmp_path, **{'fixed_to = "crank"': 'fixed_to = "rod"'})))
    assert found[1].value == 0


def test_without_p_v_only_the_pressure_is_checked(tmp_path):
    assert len(bush_checks(*_arguments(bushes(tmp_path, "")))) == 1


def test_one_lug_beside_the_middle_carries_the_whole_force(tmp_path):
    """Not half of it, as one of a pair does."""
    single = {'at = "0 mm", width = "10 mm"': 'at = "0.5 mm", single = true, width = "10 mm"'}
    beside = bush_checks(*_arguments(bushes(tmp_path, "", **single)))[0]
    middle = bush_checks(*_arguments(bushes(tmp_path, "")))[0]
    assert_allclose(beside.value, middle.value, rtol=1e-9)
    assert beside.model == 0


def test_a_pressure_speed_is_written_with_its_unit(tmp_path):
    """1 MPa m/s is 1 W/mm2; a pressure alone is refused by name."""
    design, *_ = bushes(tmp_path, ', pv = "1.5 W/mm2"')
    assert_allclose(design.parts["pin_A"].stack[1].bush.pv, 1500.0)
    with pytest.raises(DesignError, match=r"a pressure times a speed .* which is a stress"):
        bushes(tmp_path, ', pv = "1 MPa"')


def test_runs_that_were_measured_are_said_not_to_be_in_it(tmp_path):
    design, part, cycles, loads = bushes(tmp_path)
    assert bushes_not_checked(part, cycles) == []
    measured = {"run": object()}
    (told,) = bushes_not_checked(part, {**cycles, **measured})
    assert told.startswith("NOT CHECKED: p v of the bush of rod in run")
    both = replace(loads, cycles={**loads.cycles, "run": slice(0, 3)})
    assert len(bush_checks(design, part, both, {**cycles, **measured})) == 2
    assert len(bush_checks(design, part, both, measured)) == 1
