"""Travels that end beside a dead centre: the loads at both ends of the stop's tolerance."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.runs import length_doubts, stop_doubts
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.validity_checks import load_gates
from ballesta.pipeline import check_design
from checks.design.data import Stop
from checks.design.effort import Effort
from checks.result.verdict import Status
from loads import run_cycle, with_places_off, worst_shifts

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
BAR = (4.14134e-3, (125.0, 0.0), 21.56947917)
FEW = "cycles.press.positions=61"


def press(x, tolerance="0.05 mm"):
    """The press with the end of its stroke at x mm from straight bars, without the capacity."""
    given = (f'cycles.press.phases[1].to="{500 - x} mm"',
             f'cycles.press.stop.tolerance="{tolerance}"', FEW)  # fmt: skip
    design = read_design(PRESS, given)
    solved = solve_cycles(design, dict.fromkeys(("lower", "upper"), BAR))
    return design, {"press": solved["press"]}


def dead_centre(design, solved, doubted=()):
    (gate,) = [g for g in load_gates(design, solved, doubted) if "dead centre" in g.name]
    return gate


def largest(cycle):
    return float(np.abs(cycle.efforts["process"]).max())


@pytest.fixture(scope="module")
def near():
    return press(0.2)


def test_a_dead_centre_beside_a_stop_of_known_tolerance_is_a_pair_of_load_histories(near):
    """The process force of a toggle goes with 1/sqrt(x): 0.15 and 0.25 mm instead of 0.2 mm."""
    design, solved = near
    ((doubt,), _) = stop_doubts(design, solved)
    assert doubt.words == "press: end of its travel off by up to 0.05 mm"
    low, high = (largest(end["press"]) for end in doubt.ends)
    here = largest(solved["press"])
    assert low / here == pytest.approx((0.2 / 0.25) ** 0.5, rel=0.01)
    assert high / here == pytest.approx((0.2 / 0.15) ** 0.5, rel=0.01)
    written = press(0.15)[1]["press"]
    assert high == pytest.approx(largest(written), rel=1e-9)


def test_its_gate_does_not_bind_then_and_without_the_pair_says_what_to_state(near):
    design, solved = near
    gate = dead_centre(design, solved, {"press: nearness to a dead centre"})
    assert not gate.holds
    assert not gate.binding
    assert "the loads at both ends are in the error bars" in gate.told
    alone = dead_centre(design, solved)
    assert alone.binding
    assert "state cycles.press.stop.tolerance, so that" in alone.cure
    cycle = replace(design.cycles["press"], stop=None)
    alone = dead_centre(replace(design, cycles={"press": cycle}), solved)
    stop = alone.cure.partition(", or state ")[2].partition(", say")[0]
    assert read_design(PRESS, (stop,)).cycles["press"].stop == Stop("mechanical", 0.1)


def test_a_tolerance_that_reaches_the_dead_centre_leaves_the_gate_binding():
    assert stop_doubts(*press(0.2, tolerance="0.2 mm")) == ([], [])
    assert stop_doubts(*press(0.2, tolerance="0.195 mm")) == ([], [])


def test_a_travel_that_ends_far_from_it_at_an_assumed_stop_has_no_such_doubt():
    design, solved = press(2.0)
    assert dead_centre(design, solved).holds
    assert stop_doubts(design, solved) == ([], [])


def test_an_assumed_stop_is_in_the_bars_where_its_tolerance_comes_near_and_binds_beyond():
    """At 0.5 mm: 0.1 mm does sqrt(5/4) and is warned of, 0.3 mm sqrt(5/2); 1 mm is too much."""
    assert stop_doubts(*press(0.5, tolerance="0.1 mm")) == ([], [])
    ((doubt,), gates) = stop_doubts(*press(0.5, tolerance="0.3 mm"))
    assert (doubt.gates, gates) == ((), [])
    pairs, (gate,) = stop_doubts(*press(0.5, tolerance="1 mm"))
    assert pairs == []
    assert gate.binding
    assert not gate.holds


CUTTER = """
name = "Bolt cutter"
ground = ["A"]
gravity = "0, 0 m/s2"
points = { A = "0, 15 mm", J = "-25, 3 mm", D = "70, 25 mm", C = "80, 0 mm", H = "600, 250 mm" }
bodies.blade = { pins = ["A", "D", "J"], mass = "1 kg", inertia = "1e-3 kg m2", centre = "0, 0 mm" }
bodies.handle = { pins = ["C", "D", "H"], mass = "1 kg", inertia = "0.1 kg m2", centre = "0, 0 mm" }
bodies.hinge = { pins = ["C"], mass = "0.05 kg", guide = { along = "1, 0" } }
forces.hand = { body = "handle", at = "H", direction = "0, -1" }
forces.bolt = { body = "blade", at = "J", direction = "0, 1" }
[cycles.cut]
coordinate = "handle.angle"
start = "112 deg"
pace = { coordinate = "handle.angle", speed = "20 deg/s" }
phases = [ { name = "cut", to = "104 deg", forces = { hand = "120 N" }, solve = "bolt" } ]
"""


@pytest.fixture(scope="module")
def cutter(tmp_path_factory):
    file = tmp_path_factory.mktemp("cutter") / "cutter.toml"
    file.write_text(CUTTER, encoding="utf-8")

    def cut(to, *given):
        design = read_design(file, (f'cycles.cut.phases[0].to="{to} deg"', *given))
        return design, solve_cycles(design, {})

    return cut


def cutting(cycle):
    return float(np.abs(cycle.efforts["bolt"]).max())


def test_a_cutter_of_high_ratio_far_from_its_dead_centre_is_not_near_it(cutter):
    """The bolt takes 237 times the hand; the short arm of 27 mm is 14 deg from in line."""
    design, solved = cutter(104)
    assert cutting(solved["cut"]) / 120.0 == pytest.approx(237.0, rel=0.01)
    assert dead_centre(design, solved).value < 0.05
    assert length_doubts(design, solved) == ([], [])


def test_lengths_near_a_dead_centre_are_a_pair_that_holds_every_linkage_within_them(cutter):
    design, solved = cutter(94)
    ((pair,), assumed) = length_doubts(design, solved)
    assert pair.words == "cut: lengths and position off by general tolerances"
    assert dict(assumed)["points"].endswith("both ends in cut")
    assert not dead_centre(design, solved, set(pair.gates)).binding
    low, high = (cutting(end["cut"]) for end in pair.ends)
    known = solved["cut"]
    sizes = {at: np.hypot(*own) for at, own in worst_shifts(known, known.sensitivity.row).items()}
    rng = np.random.default_rng(4)
    for _ in range(12):
        turns = rng.uniform(0.0, 2.0 * np.pi, len(sizes))
        off = {
            at: (size * np.cos(turn), size * np.sin(turn))
            for (at, size), turn in zip(sizes.items(), turns, strict=True)
        }
        built = run_cycle(with_places_off(known.linkage, off), design.cycles["cut"].run)
        assert low < cutting(built) < high


def test_lengths_that_reach_the_dead_centre_leave_the_gate_binding(cutter):
    design, solved = cutter(90.3)
    assert length_doubts(design, solved) == ([], [])
    gate = dead_centre(design, solved)
    assert gate.binding
    assert not gate.holds


def mechanical(tolerance, *given):
    """Both cycles of the press, which end at one stop 2 mm from straight bars."""
    design = read_design(PRESS, (
        "cycles.press.stop.basis=mechanical", f'cycles.press.stop.tolerance="{tolerance}"',
        FEW, "cycles.capacity.positions=31", *given,
    ))  # fmt: skip
    return design, solve_cycles(design, dict.fromkeys(("lower", "upper"), BAR))


def test_a_mechanical_stop_far_from_it_moves_all_cycles_that_end_there():
    design, solved = mechanical("1 mm")
    ((doubt,), gates) = stop_doubts(design, solved)
    assert (doubt.words, doubt.gates) == ("press: end of its travel off by up to 1 mm", ())
    assert gates == []
    for name in ("press", "capacity"):
        ends = [largest(end[name]) / largest(solved[name]) for end in doubt.ends]
        assert ends == pytest.approx([(2 / 3) ** 0.5, 2**0.5], rel=0.01)


def test_a_mechanical_stop_of_a_machine_with_its_vibration_applied_binds_unless_it_has_none():
    pairs, (gate,) = stop_doubts(*mechanical("1 mm", "dynamics.apply=true"))
    assert pairs == []
    assert not gate.holds
    assert "vibration is on the loads" in gate.told
    assert stop_doubts(*mechanical("0 mm", "dynamics.apply=true")) == ([], [])


def test_cycles_that_end_at_other_stops_are_doubted_one_by_one():
    pairs, _ = stop_doubts(*mechanical("1 mm", "cycles.capacity.stop.tolerance=0.5 mm"))
    assert [pair.words.partition(":")[0] for pair in pairs] == ["press", "capacity"]


def test_a_mechanical_stop_whose_tolerance_reaches_it_binds():
    pairs, (gate,) = stop_doubts(*mechanical("2 mm"))
    assert pairs == []
    assert gate.binding
    assert not gate.holds
    assert "cycles.press.stop.tolerance" in gate.cure


PUSHED = """
name = "Two sliders"
points = { A = "-200, 0 mm", B = "0, 0 mm" }
bodies.left = { pins = ["A"], mass = "1 kg", guide = { along = "1, 0" } }
bodies.rod = { pins = ["A", "B"] }
bodies.right = { pins = ["B"], mass = "1 kg", guide = { along = "1, 0" } }
forces.drive = { body = "left", at = "A", direction = "1, 0" }
forces.pad = { body = "right", at = "B", direction = "-1, 0" }
[cycles.press]
coordinate = "B.x"
start = "0 mm"
pace = { coordinate = "B.x", speed = "10 mm/s" }
stop = { basis = "mechanical", tolerance = "8.9 mm" }
[[cycles.press.phases]]
name = "in"
to = "100 mm"
solve = "drive"
forces.pad = { over = "B.x", at = ["0 mm", "99 mm", "109 mm"], force = ["0 N", "0 N", "50 kN"] }
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "A", second = "B" }
material = "S355"
width = "30 mm"
thickness = "10 mm"
hole = "12 mm"
"""


PULLED_BEFORE = (
    'cycles.press.phases[0].forces.pad.at=["0 mm", "95 mm", "99 mm", "109 mm"]',
    'cycles.press.phases[0].forces.pad.force=["-60 kN", "-60 kN", "0 N", "50 kN"]',
)


@pytest.mark.parametrize("given", [(), PULLED_BEFORE])
def test_buckling_of_a_linkage_that_is_hardly_used_has_what_a_stop_may_multiply(tmp_path, given):
    """5 kN at the stop, 9.9 times as much 8.9 mm behind: 0.039 of the load becomes 0.384.

    A pull on the way there that is more than both hides nothing.
    """
    (tmp_path / "sliders.toml").write_text(PUSHED, encoding="utf-8")
    result = check_design(read_design(tmp_path / "sliders.toml", given), effort=Effort("formula"))
    (linkage,) = result.linkage
    assert linkage.utilisation < 0.2
    assert linkage.loads == pytest.approx(8.9 * linkage.value, rel=0.01)
    assert linkage.status is Status.UNDECIDED


def test_a_linkage_that_only_the_end_of_a_doubt_presses_has_its_buckling(tmp_path):
    """49.4 kN 8.9 mm behind the stop, where it is pulled: 0.384 of the load, of 1/3; or none."""
    (tmp_path / "sliders.toml").write_text(PUSHED, encoding="utf-8")
    pulled = (
        PULLED_BEFORE[0].replace("99 mm", "100.5 mm"),
        PULLED_BEFORE[1],
    )
    result = check_design(read_design(tmp_path / "sliders.toml", pulled), effort=Effort("formula"))
    (linkage,) = result.linkage
    assert linkage.value == pytest.approx(0.384, rel=0.01)
    assert linkage.value - linkage.below == 0.0
    assert "; only at: press: end of its travel off by up to 8.9 mm" in linkage.note
    assert linkage.status is Status.UNDECIDED


@pytest.mark.slow
def test_the_bars_of_a_whole_check_reach_to_both_ends():
    """Between both written designs' own values, by formula."""
    given = (FEW, "cycles.capacity.positions=31", 'cycles.press.stop.tolerance="0.05 mm"')

    def static(x):
        to = (f'cycles.press.phases[1].to="{500 - x} mm"',)
        result = check_design(read_design(PRESS, (*given, *to)), effort=Effort("formula"))
        (bar,) = [part for part in result.parts if part.name == "bar_upper"]
        return next(check for check in bar.checks if check.kind == "fatigue")

    middle, low, high = (static(x) for x in (0.2, 0.25, 0.15))
    assert middle.value + middle.loads == pytest.approx(high.value, rel=0.01)
    assert middle.value - middle.loads_below == pytest.approx(low.value, rel=0.01)
