"""Bushes: mean pressure, and pressure times sliding speed over the cycle."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from checks.by_formula import formula_checks, not_checked
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.result.verdict import Status

from ...small_machine import machine, solved

DESIGNS = Path(__file__).parents[3] / "designs"
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


def bush_checks(loaded):
    """Pressures of all bushes, then what slides in them."""
    return [check for check in formula_checks(loaded) if check.kind == "bush"]


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
    pressure, product = bush_checks(LoadedPart(design, part, loads, cycles))
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


def test_the_bars_of_few_positions_hold_the_peaks_of_many(tmp_path):
    def at(count):
        design = machine(tmp_path, text, f"cycles.turn.positions={count}")
        cycles = solved(design)
        part = design.parts["pin_A"]
        return bush_checks(LoadedPart(design, part, loads_on(design, part, cycles), cycles))

    text = PIN.replace("BEARS", 'allowable = "40 MPa", pv = "1 MPa m/s"')
    for few, many in zip(at(18), at(273), strict=True):
        assert few.value * (1 + 1e-4) < many.value <= few.upper
        assert many.sampling < 1e-4 * many.value


def test_p_v_above_the_allowable_fails_and_below_it_passes(tmp_path):
    value = bush_checks(_loaded(bushes(tmp_path)))[1].value
    for factor, status in ((1.01, Status.PASS), (0.99, Status.FAIL)):
        found = bush_checks(_loaded(bushes(tmp_path, f', pv = "{factor * value} MPa m/s"')))[1]
        assert found.status is status


def _loaded(found):
    design, part, cycles, loads = found
    return LoadedPart(design, part, loads, cycles)


def test_a_bush_in_the_body_that_the_pin_turns_with_has_no_p_v(tmp_path):
    """It had 0, and passed: a pin that is fixed to the wrong body by mistake slides elsewhere."""
    with pytest.raises(DesignError, match=r"stack\[1\]\.bush\.pv: the pin turns with rod"):
        bushes(tmp_path, **{'fixed_to = "crank"': 'fixed_to = "rod"'})
    (pressure,) = bush_checks(_loaded(bushes(tmp_path, "", **{'"crank"\nmat': '"rod"\nmat'})))
    assert pressure.value > 0


def test_without_p_v_only_the_pressure_is_checked(tmp_path):
    assert len(bush_checks(_loaded(bushes(tmp_path, "")))) == 1


def test_one_lug_beside_the_middle_carries_the_whole_force(tmp_path):
    """Not half of it, as one of a pair does."""
    single = {'at = "0 mm", width = "10 mm"': 'at = "0.5 mm", single = true, width = "10 mm"'}
    beside = bush_checks(_loaded(bushes(tmp_path, "", **single)))[0]
    middle = bush_checks(_loaded(bushes(tmp_path, "")))[0]
    assert_allclose(beside.value, middle.value, rtol=1e-9)
    assert beside.model == 0


def test_the_bushes_of_a_fork_carry_half_each_and_5_percent_for_what_is_out_of_square(tmp_path):
    crank, rod = ('body = "crank", at = ', 'body = "rod", at = ')
    fork = {f'{crank}"12 mm"': f'{crank}"0 mm"', f'{rod}"0 mm"': f'{rod}"10 mm"'}
    one = bush_checks(_loaded(bushes(tmp_path)))
    two = bush_checks(_loaded(bushes(tmp_path, **fork)))
    for alone, shared in zip(one, two, strict=True):
        assert_allclose(shared.value, alone.value / 2, rtol=1e-9)
        assert_allclose(shared.model, 0.05 * shared.value, rtol=1e-9)


def test_a_pressure_speed_is_written_with_its_unit(tmp_path):
    """1 MPa m/s is 1 W/mm2; a pressure alone is refused by name."""
    design, *_ = bushes(tmp_path, ', pv = "1.5 W/mm2"')
    assert_allclose(design.parts["pin_A"].stack[1].bush.pv, 1500.0)
    with pytest.raises(DesignError, match=r"a pressure times a speed .* which is a stress"):
        bushes(tmp_path, ', pv = "1 MPa"')


def with_measured_run(loads):
    """The same loads, and three rows of a run whose speeds are not known."""
    n = len(loads.labels)

    def more(values):
        return np.concatenate([values, values[:3]])

    return replace(
        loads,
        wrenches={name: more(wrench) for name, wrench in loads.wrenches.items()},
        accelerations=more(loads.accelerations),
        cycles={**loads.cycles, "run": slice(n, n + 3)},
        labels=(*loads.labels, "1", "2", "3"),
        cycle_names=(*loads.cycle_names, "run", "run", "run"),
        stretch_of=None,
        path=np.append(loads.path, [np.nan] * 3),
        spins={name: np.append(spin, [np.nan] * 3) for name, spin in loads.spins.items()},
    )


def test_runs_that_were_measured_are_said_not_to_be_in_it(tmp_path):
    design, part, cycles, loads = bushes(tmp_path)
    loaded = LoadedPart(design, part, loads, cycles)
    assert not_checked(loaded) == []
    run = SimpleNamespace(times=np.arange(3.0))
    both = replace(loaded, loads=with_measured_run(loads), runs={**cycles, "run": run})
    assert not_checked(both) == [
        "NOT CHECKED: p v of the bush of rod in run: measured loads tell no relative speeds"
    ]
    alone, beside = bush_checks(loaded)[1], bush_checks(both)[1]
    assert (beside.value, beside.note) == (alone.value, alone.note)
    unknown = {name: np.full(len(spin), np.nan) for name, spin in loads.spins.items()}
    nowhere = np.full(len(loads.labels), np.nan)
    measured = replace(loaded, loads=replace(loads, spins=unknown, path=nowhere))
    assert [check.quantity for check in bush_checks(measured)] == ["bush of rod"]


def test_a_peak_of_p_v_between_positions_is_found_where_force_and_speed_go_straight(tmp_path):
    """F (1 - s) times w s has its peak of 1/4 at 1/2; of s = 0, 1/3, 2/3, 1 the largest is 2/9.

    The rise is added with its margin of 2.
    """
    design, part, _, loads = bushes(tmp_path)
    share = np.linspace(0.0, 1.0, 4)
    wrenches = {name: np.zeros((4, 6)) for name in loads.wrenches}
    wrenches["rod"][:, 0] = 4e3 * (1 - share)
    straight = replace(
        loads,
        wrenches=wrenches,
        accelerations=np.zeros((4, 4)),
        cycles={"turn": slice(0, 4)},
        labels=("0", "1", "2", "3"),
        cycle_names=("turn",) * 4,
        stretch_of=None,
        path=share,
        spins={"rod": 10.0 * share},
    )
    runs = {"turn": SimpleNamespace(times=share)}
    _, product = bush_checks(LoadedPart(design, part, straight, runs))
    whole = 40.0 * 0.05  # MPa and m/s
    assert_allclose(product.value, 2 / 9 * whole)
    assert_allclose(product.sampling, 2 * (1 / 4 - 2 / 9) * whole)


def test_the_eye_of_a_force_turns_with_the_line_that_the_force_acts_along():
    """The cylinder's swing from its ends' places by differences in time, less the lower bar's.

    601 positions over two strokes from rest to rest: 2 % in the peak.
    """
    bush = '{length="43 mm", allowable="140 MPa", pv="1 MPa m/s"}'
    cheek = '{length="6.3 mm", allowable="140 MPa"}'
    lugs = [
        f'{{body="upper", at="42.95 mm", width="6.3 mm", bush={cheek}}}',
        f'{{body="lower", at="32.65 mm", width="6.3 mm", bush={cheek}}}',
        f'{{force="cylinder", at="0 mm", width="43 mm", bush={bush}}}',
    ]
    masses = [
        f"bodies.{body}.{key}"
        for body in ("lower", "upper")
        for key in ('mass="4 kg"', 'inertia="0.02 kg m2"', 'centre="125, 0 mm"')
    ]
    stack = f"parts.pin_B.stack=[{', '.join(lugs)}]"
    more = [stack, "cycles.press.positions=601", *masses]
    design = read_design(DESIGNS / "toggle_press.toml", more)
    cycles = solved(design)
    part = design.parts["pin_B"]
    loads = loads_on(design, part, cycles)
    product = bush_checks(LoadedPart(design, part, loads, cycles))[-1]
    assert product.quantity == "p v of the bush of cylinder"
    cylinder, by_hand = design.forces["cylinder"].coordinate, []
    for name, cycle in cycles.items():
        times, first = np.unique(cycle.times, return_index=True)  # phases share their ends
        front = cycle.point(cylinder.body_a, cylinder.point_a)
        reach = (front - cycle.point(cylinder.body_b, cylinder.point_b))[first]
        own = cycle.poses[first, cycle.body_index("lower"), 2]
        turned = np.unwrap(np.arctan2(reach[:, 1], reach[:, 0])) - own
        speed = np.abs(np.gradient(turned, times)) * 20.0
        force = loads.resultant("cylinder")[loads.cycles[name]][first]
        by_hand.append((force / (40 * 43) * speed / 1e3).max())
    assert 0.03 < max(by_hand) < 0.07  # 11 kN on 1720 mm2, 0.1 m/s on 250 mm, 20 mm: 0.05
    assert_allclose(product.value, max(by_hand), rtol=0.02)


@pytest.mark.parametrize("at", [0, 4])
def test_p_v_is_told_where_it_is_largest_also_at_the_first_position(tmp_path, at):
    design, part, cycles, loads = bushes(tmp_path)
    speeds = np.zeros(len(loads.labels))
    speeds[at] = -3.0
    turned = replace(loads, spins={**loads.spins, "rod": speeds})
    derivation = bush_checks(LoadedPart(design, part, turned, cycles))[1].derivation
    assert derivation.cases[0].index == at
    assert derivation.number("omega") == 3.0
