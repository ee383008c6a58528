"""Stress over the range of clearances that fits leave, between nodes of bores, and in events."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.machine.runs import solved_runs
from checks.ladder.levels import first_level
from checks.part.loaded_part import LoadedPart
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.clearances import OverClearances, over_clearances, turn_beyond, values_at
from checks.stress.duty_verdict import JOINED
from checks.stress.error_bars import missed_between_nodes
from checks.stress.judged import StaticPeak
from checks.stress.pins_in_bores import LARGEST, LEAST, MIDDLE, PinnedBores, fits_of
from checks.stress.solid_mesh_level import Models, solve_level

from ..small_machine import PLATE, machine
from .machine.test_events import FINE, FLYWHEEL, MOTOR
from .test_stated_fits import rod

BRAKE = 'drive.brake={torque="20 kN m", delay="0 ms"}'
STOP = 'events.stop={cycle="turn", kind="brake", at="420 deg"}'


def swung(folder, *overrides, fit="0 .. 0.06 mm", fineness=0.5):
    """The rod of the small machine: 400 N, whose direction swings by some degrees."""
    text = PLATE.replace("fineness = 0.5", f"fineness = {fineness}")
    stated = f'fits = {{ first = "{fit}", second = "{fit}" }}\n'
    design = machine(folder, text + stated, *overrides)
    design, runs = solved_runs(design, Models(), lambda _: None)
    return LoadedPart.of(design, design.parts["rod"], runs)


def fresh(loaded, level, share):
    """The level with pins of one clearance, solved at all positions of all cycles."""
    alone = {
        name: replace(fit, least=fit.clearance(share), largest=fit.clearance(share))
        for name, fit in fits_of(loaded).items()
    }
    of = level.contact.pins.solutions
    part = loaded.part
    return solve_level(
        of, level.fineness, loaded.loads, endurance_of(part).value, part.material.ultimate_stress,
        loaded.duty.cycles, part.geometry.notch_factors, PinnedBores(of, alone),
    )  # fmt: skip


@pytest.mark.parametrize("scene", [pytest.param("swung", marks=pytest.mark.slow), "pulled"])
def test_the_band_holds_what_a_fresh_solution_has_at_any_clearance(scene, tmp_path):
    """33 clearances. Between nodes a swinging pressure is off by what its own bar says."""
    stated = 'fits = { first = "0 .. 0.04 mm", second = "0 .. 0.04 mm" }'
    loaded = swung(tmp_path) if scene == "swung" else rod(tmp_path, stated)
    level = first_level(loaded, Models())
    judged = [StaticPeak(loaded.loads), fatigue_use(loaded)]
    levels = [fresh(loaded, level, share) for share in np.linspace(0, 1, 33)]
    for what in judged:
        over, value = over_clearances(what, level), what.value(level)
        found = [what.value(other) for other in levels]
        numerical = missed_between_nodes(what, level) + 0.005 * value
        assert max(found) <= value + over.above + numerical
        assert min(found) >= value - over.below - numerical


def test_fatigue_at_the_ends_of_a_fit_has_its_own_worst_positions(tmp_path):
    """On neat pins the rod's worst positions are others than at the middle of the clearances."""
    loaded = swung(tmp_path)
    level = first_level(loaded, Models())
    use = fatigue_use(loaded)
    neat = fresh(loaded, level, LEAST)
    assert set(use.worst(neat).pair) != set(use.worst(level).pair)
    values = values_at(use, level, (LEAST, LARGEST))
    assert values[LEAST] == pytest.approx(use.value(neat), rel=1e-4)
    assert values[LARGEST] == pytest.approx(use.value(fresh(loaded, level, LARGEST)), rel=1e-4)


def test_clearances_are_asked_for_beside_a_stress_that_turns():
    """A valley at a quarter, as a link had it: 40.4, 33.0, 41.7 and 52.6 MPa."""
    seen = {0.0: 40.4, 0.25: 33.0, 0.5: 41.7, 1.0: 52.6}
    assert turn_beyond(seen) == ([], 0.0)
    asked, beyond = turn_beyond({share: -value for share, value in seen.items()})
    assert asked == [0.125, 0.375]
    assert beyond == pytest.approx((40.4 - 33.0) / 2)
    over = OverClearances(seen, 0.0, beyond)
    assert over.above == pytest.approx(52.6 - 41.7)
    assert over.below == pytest.approx(41.7 - 33.0 + 3.7)


def test_what_nodes_miss_of_a_part_used_before_is_no_less_after_many_runs(tmp_path):
    """1e12 runs allow a third of what the endurance limit does; 3.46 of endless life miss 1.93."""
    loaded = swung(tmp_path, fineness=1.0)
    level = first_level(loaded, Models())
    loose = fresh(loaded, level, 0.35)
    missed = []
    for changes in ({}, {"life": "finite", "damage_so_far": 1e-6, "cycles": {"turn": 1e12}}):
        duty = replace(loaded.duty, **changes)
        use = fatigue_use(replace(loaded, design=replace(loaded.design, duty=duty)))
        missed.append(missed_between_nodes(use, loose) / use.value(loose))
    assert missed[0] > 0.5
    assert missed[1] > missed[0]  # more of it is amplitude, less is tension


@pytest.mark.slow
def test_what_nodes_miss_of_a_swinging_pressure_stands_in_the_bar(tmp_path):
    """Against a mesh with 18 times the unknowns and 60 hats in the arc: 3.43, 5.05, 6.08 MPa.

    Nodes some 6 degrees apart, arcs of 42, 28 and 19 degrees, whose ends move by a degree or two.
    """
    loaded = swung(tmp_path, fineness=1.0)
    level = first_level(loaded, Models())
    use = fatigue_use(loaded)
    missed = []
    for share, exact in ((0.15, 3.43), (0.35, 5.05), (0.8, 6.08)):
        loose = fresh(loaded, level, share)
        value, bar = use.value(loose), missed_between_nodes(use, loose)
        assert abs(value - exact) <= bar + 0.05 * exact
        missed.append(abs(value - exact) / exact)
        assert bar <= 2 * max(abs(value - exact), 0.1 * exact)
    assert max(missed) > 0.3


def test_pins_of_a_stop_in_the_duty_press_by_its_own_loads(tmp_path):
    """Brakes of 20 kN m make the stop's inertia the largest load; its pins press as that says."""
    loaded = swung(
        tmp_path, MOTOR, FLYWHEEL, BRAKE, STOP, FINE, "duty.cycles={turn=1e6, stop=5000.0}"
    )
    level = first_level(loaded, Models())
    stop, peak = loaded.loads.cycles["stop"], level.peak.position
    assert stop.start <= peak < stop.stop
    assert level.contact.residual < 1e-6
    loads = loaded.loads
    one = slice(peak, peak + 1)
    alone = replace(
        loads,
        wrenches={name: wrench[one] for name, wrench in loads.wrenches.items()},
        accelerations=loads.accelerations[one],
        reaches={},
        cycles={"stop": slice(0, 1)},
        labels=loads.labels[one],
        cycle_names=("stop",),
        stretch_of=None,
        path=None,
        spins={},
        doubts=(),
    )
    by_itself = first_level(loaded.under(alone), Models())
    assert by_itself.peak.value == pytest.approx(level.peak.value, rel=1e-4)
    pressure = level.contact.cycle.bores["second"].pressures[:, peak]
    assert_allclose(
        by_itself.contact.cycle.bores["second"].pressures[:, 0], pressure,
        atol=1e-6 * pressure.max(),
    )  # fmt: skip

    use = fatigue_use(loaded)
    assert set(level.duty.verdicts) == {"turn", "stop", JOINED}
    turn = replace(loaded.duty, cycles={"turn": 1e6})
    without = first_level(replace(loaded, design=replace(loaded.design, duty=turn)), Models())
    assert use.value(level) > 1.05 * without.fatigue.value
    for what in (StaticPeak(loads), use):
        found = values_at(what, level, (LARGEST, MIDDLE))
        assert found[MIDDLE] == what.value(level)
        expected = what.value(fresh(loaded, level, LARGEST))
        assert found[LARGEST] == pytest.approx(expected, rel=0.03)
