"""The drive's speed: how it is stated, and the bars of the loads where it is not even."""

from dataclasses import replace
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads
from ballesta.machine.drive_speed import evenness_of, speed_doubts, speed_gates, speed_warnings
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.ladder.climb import start_climb
from checks.ladder.result import _buckling_doubted
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import Doubt, PartDoubt, loads_on
from checks.result.verdict import Status
from checks.strength.load_doubts import LoadBars, load_bars

from ...misses import misses
from ...reports.results import check as result_check
from ...small_machine import loads_of, machine, solved

ROD = """
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "A", second = "B" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
"""
INERTIA_ALONE = ("gravity=0, 0 m/s2", "cycles.turn.phases[0].forces.push=0 N",
                 "cycles.turn.pace.speed=100 rad/s")  # fmt: skip


def evenness(folder, *overrides):
    design = machine(folder, ROD, *overrides)
    return evenness_of(design, solved(design))["turn"]


def test_loads_at_another_speed_are_those_of_a_cycle_run_at_it(tmp_path):
    """At the positions of the slow one; inertia goes with the square, the push does not change."""
    slow = machine(tmp_path)
    fast = machine(tmp_path, "", "cycles.turn.pace.speed=20 rad/s")
    known, there = solved(slow)["turn"], solved(fast)["turn"]
    again = loads.run_at_rates(known, slow.cycles["turn"].run, 2.0)
    for joint in again.reactions:
        for axis in (0, 1):
            expected = np.interp(
                known.positions, there.positions, there.reactions[joint].force[:, axis]
            )
            assert_allclose(again.reactions[joint].force[:, axis], expected, atol=2.0)
    assert_allclose(again.times[-1], known.times[-1] / 2)


def test_a_surge_is_the_acceleration_of_a_pace_that_rises(tmp_path):
    """5 rad/s2 at 10 rad/s are 0.5 1/s over the speed; at the start the speeds are the same."""
    even = machine(tmp_path)
    rising = machine(tmp_path, "", "cycles.turn.pace.acceleration=5 rad/s2")
    known, there = solved(even)["turn"], solved(rising)["turn"]
    surge = np.full(len(known.positions), 0.5)
    again = loads.run_at_rates(known, even.cycles["turn"].run, 1.0, surge)
    for joint in again.reactions:
        start = there.reactions[joint].force[0]
        assert_allclose(again.reactions[joint].force[0], start, rtol=1e-9, atol=1e-9)
        assert np.abs(start - known.reactions[joint].force[0]).max() >= 0.0
    assert np.abs(again.efforts["drive"][0] - known.efforts["drive"][0]) > 1.0


def test_a_flywheel_leaves_the_ripple_over_its_energy(tmp_path):
    design = machine(tmp_path, ROD)
    figures = solved(design)["turn"].drive("drive")
    bare, ripple = figures.mean_reduced_mass, figures.energy_ripple
    found = evenness(tmp_path, "drive.flywheel=2 kg m2")
    assert found.irregularity == pytest.approx(ripple / ((bare + 2000.0) * 100.0), rel=1e-9)
    assert not found.assumed
    assert speed_gates({"turn": found}) == []
    (gate,) = speed_gates({"turn": evenness(tmp_path, "drive.flywheel=0.1 kg m2")})
    assert gate.binding
    assert not gate.holds
    for key in ("drive.flywheel", "drive.control", "drive.irregularity"):
        assert key in gate.cure
    told = float(gate.cure.split("=")[1].split()[0])
    cured = evenness(tmp_path, f"drive.flywheel={told} kg m2")
    assert cured.irregularity == pytest.approx(0.1, rel=0.01)


def test_a_drive_that_its_flywheel_lets_stop_has_a_gate_and_no_slowest_speed(tmp_path):
    """It had been an error of the linkage, "the speed of crank.angle must be above 0"."""
    design = machine(tmp_path, ROD, "drive.flywheel=1e-3 kg m2")
    cycles = solved(design)
    found = evenness_of(design, cycles)
    assert found["turn"].irregularity > 2.0
    assert speed_doubts(design, cycles, found) == []
    (gate,) = speed_gates(found)
    assert not gate.holds


def test_a_silent_drive_is_an_assumption_with_its_keys_and_no_gate(tmp_path):
    found = evenness(tmp_path)
    assert found.assumed
    assert found.irregularity == 0.1
    assert found.alone > 0.1
    assert speed_gates({"turn": found}) == []
    (said,) = speed_warnings({"turn": found})
    for key in ("drive.control", "drive.flywheel", "drive.irregularity"):
        assert key in said


def test_a_heavy_crank_needs_no_assumption(tmp_path):
    found = evenness(tmp_path, "bodies.crank.inertia=20 kg m2")
    assert not found.assumed
    assert 0.0 < found.irregularity < 0.1
    assert speed_warnings({"turn": found}) == []


def test_a_drive_of_constant_speed_has_no_doubt(tmp_path):
    design = machine(tmp_path, ROD, 'drive.control="constant"')
    cycles = solved(design)
    found = evenness_of(design, cycles)
    assert found["turn"].irregularity == 0.0
    assert speed_doubts(design, cycles, found) == []
    assert speed_warnings(found) == []


def test_how_a_drive_holds_its_speed_is_stated_once(tmp_path):
    with pytest.raises(DesignError, match="control and irregularity"):
        machine(tmp_path, ROD, 'drive.control="constant"', "drive.irregularity=0.1")


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Checks by formula of a rod that only its inertia loads, by what is stated of the drive."""
    folder = tmp_path_factory.mktemp("speed")

    def of(*overrides):
        design = machine(folder, ROD, *INERTIA_ALONE, *overrides)
        result = check_design(design, effort=Effort(fidelity="formula"))
        return {(check.kind, check.quantity): check for check in result.checks}, result

    return {
        "constant": of('drive.control="constant"'),
        "uneven": of("drive.irregularity=0.2"),
        "silent": of(),
    }


def test_loads_bars_reach_the_stress_at_the_fastest_and_slowest_speed(checked):
    """Inertia alone: 1.1^2 and 0.9^2 of the stress; changes of speed come on top."""
    even, _ = checked["constant"]
    uneven, _ = checked["uneven"]
    (name,) = [name for name in uneven if name[0] == "bearing"]
    check = uneven[name]
    assert even[name].loads == even[name].loads_below == 0.0
    assert check.value == pytest.approx(even[name].value)
    assert 0.21 <= check.loads / check.value < 1.0
    assert 0.19 <= check.loads_below / check.value < 1.0
    assert check.model - check.loads == pytest.approx(even[name].model, abs=1e-9)
    assert check.below - check.loads_below == pytest.approx(even[name].below, abs=1e-9)
    assert "speed up to 10 % slower or faster" in check.note


def test_a_rung_s_stress_goes_with_the_square_of_the_speed(tmp_path):
    """Also of fatigue, whose swing does, and of the load share of buckling."""
    design = machine(tmp_path, ROD, *INERTIA_ALONE, "drive.irregularity=0.2")
    cycles = solved(design)
    part = design.parts["rod"]
    doubts = [
        Doubt(d.words, d.ends) for d in speed_doubts(design, cycles, evenness_of(design, cycles))
    ]
    part_loads = loads_on(design, part, cycles, doubts)
    climb = start_climb(LoadedPart(design, part, part_loads, cycles))
    shares = load_bars(part_loads, climb._values).shares
    for kind in ("static", "fatigue", "buckling"):
        assert shares[kind][doubts[0].words] == pytest.approx([0.81, 1.21], rel=1e-6)
        assert shares[kind][doubts[1].words] != pytest.approx([1.0, 1.0], rel=1e-3)


def test_a_silent_drive_has_the_bars_of_the_irregularity_that_is_assumed(checked):
    silent, result = checked["silent"]
    uneven, _ = checked["uneven"]
    for name, check in silent.items():
        if uneven[name].loads:
            assert 0.0 < check.loads < uneven[name].loads
    assert not [gate for gate in result.all_gates if "irregularity" in gate.name]
    assert [what for key, what in result.assumed if key == "drive"]


def test_load_bars_stand_in_the_derivations(checked):
    uneven, _ = checked["uneven"]
    found = [check for check in uneven.values() if check.loads]
    assert found
    for check in found:
        assert misses(check.derivation, check) == ""
        assert check.derivation.number("e_load") == pytest.approx(check.loads)


def test_a_solids_buckling_goes_with_its_compression_where_a_pull_is_the_largest_force(tmp_path):
    """The push of 10 N may be 30; the pull of 100 N stays."""
    design = machine(tmp_path, ROD)

    def pulled_and_pushed_by(push):
        along = [[-100.0, 0.0, 0.0], [push, 0.0, 0.0]]
        return loads_of({"first": along, "second": [[-x, 0.0, 0.0] for x, *_ in along]})

    own = pulled_and_pushed_by(10.0)
    doubts = (PartDoubt("stop", (own, pulled_and_pushed_by(30.0))),)
    climb = start_climb(LoadedPart(design, design.parts["rod"], replace(own, doubts=doubts)))
    check = result_check(kind="buckling", value=0.1, method="solid (one mesh)")
    assert _buckling_doubted(climb, check).loads == pytest.approx(0.2)


def test_a_check_of_a_part_that_only_the_end_of_a_doubt_loads_is_open():
    """Nothing to widen in proportion, and no pass either; round-off is no load."""
    none = (0.0, 0.0)  # friction
    parts = [SimpleNamespace(value=v, rubs=none) for v in (0.0, 300.0, 1e-12)]
    parts[0].doubts = tuple(SimpleNamespace(words=f"{x.value}", ends=[x]) for x in parts[1:])
    bars = load_bars(parts[0], lambda some: {"static": getattr(some, "value", 0.0)})
    check = bars(result_check(value=0.0))
    assert check.status is Status.UNDECIDED
    assert check.model == inf
    assert check.note.endswith("the part is loaded only at the ends of: 300.0")


def test_a_check_without_a_model_band_above_still_has_what_loads_may_lack_below():
    """What fails at half of an estimate must do so with the least loads, too."""
    bars = LoadBars({"static": {"speed": [0.8, 1.3]}})
    check = bars(result_check(value=100.0, model=inf, model_below=50.0))
    assert check.below == pytest.approx(70.0)
    assert check.model == inf
    unknown = result_check(value=100.0, model=inf)
    assert bars(unknown) == unknown
