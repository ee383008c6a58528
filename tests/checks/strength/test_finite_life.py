"""Cycles of a finite life: none is hidden by a larger one, and none loses its mean."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.materials import known_materials
from checks.strength.finite_life import (
    LifeTask,
    life_curve,
    lives_of,
    most_used,
    raised_exactly,
    shorter_life,
    shortest_life,
    why_no_curve,
)
from checks.stress.duty_verdict import duty_runs, duty_verdict

STEEL = known_materials()["S355"]
LIMIT = 150.0
XX, YY, XY = (np.eye(6)[k] for k in (0, 1, 3))


def duty_of(*cycles, counts, limit=LIMIT, material=STEEL, **changes):
    """Verdict and task of points under cycles, each (n_positions, 6) MPa at one point."""
    stress = np.concatenate(cycles)
    ends = np.cumsum([0, *(len(cycle) for cycle in cycles)])
    slices = {f"c{k}": slice(a, b) for k, (a, b) in enumerate(pairwise(ends))}
    basis = np.eye(6)[None]
    runs = duty_runs(slices, dict.fromkeys(slices, 1.0))
    verdict = duty_verdict(
        basis, np.ascontiguousarray(stress.T), np.full(1, limit), limit,
        material.ultimate_stress, runs,
    )  # fmt: skip
    stated = {"material": material, "axial": False, "allowed_damage": 1.0} | changes
    return verdict, LifeTask(dict(zip(slices, counts, strict=True)), **stated)


def life_of(*cycles, counts, **changes):
    verdict, task = duty_of(*cycles, counts=counts, **changes)
    (life,) = lives_of(verdict, task, np.array([0]))
    return life


def line(direction, *values):
    return np.outer(values, direction)


def circle(size, count=48):
    """Bending and torsion a quarter of a turn apart, von Mises amplitude `size` throughout."""
    turn = 2 * np.pi * np.arange(count) / count
    return size * (np.outer(np.cos(turn), XX) + np.outer(np.sin(turn), XY) / np.sqrt(3))


def cycles_endured(amplitude, mean=0.0):
    """Basquin through 0.9 S_u at 1e3 and the limit at 1e6 cycles, Goodman; S355, S_u 470 MPa."""
    slope = 3 / np.log10(0.9 * 470 / LIMIT)
    return 1e6 * (amplitude / (1 - max(mean, 0) / 470) / LIMIT) ** -slope


def test_an_overload_in_another_direction_hides_no_frequent_torsion():
    """100 MPa of shear, 173 von Mises, 1e7 times; one overload of 250 MPa in tension."""
    torsion, overload = line(XY, 100, -100), line(XX, 250, -250)
    alone = life_of(torsion, counts=[1e7])
    both = life_of(torsion, overload, counts=[1e7, 1])
    assert_allclose(alone.damage, 1e7 / cycles_endured(100 * 3**0.5), rtol=1e-6)
    assert both.damage >= alone.damage
    assert both.safety <= alone.safety
    assert both.run == "c0"


def test_an_overload_against_the_load_takes_no_mean_from_the_cycles_below_it():
    """0 to 250 MPa 1e5 times; the overload from -260 to 250 has its middle in compression."""
    alone = life_of(line(XX, 0, 250), counts=[1e5])
    both = life_of(line(XX, 0, 250), line(XX, -260, 250), counts=[1e5, 1])
    assert_allclose(alone.damage, 1e5 / cycles_endured(125, 125), rtol=1e-6)
    assert both.damage >= alone.damage * (1 - 1e-9)
    assert both.safety <= alone.safety * (1 + 1e-9)


def test_ripples_on_one_cycle_keep_their_own_mean():
    """20 ripples from 20 to 290 MPa on one cycle of 300: 135 about 155."""
    ripples = [290.0, 20.0] * 20
    life = life_of(line(XX, -300, *ripples, 300), counts=[1.0])
    rows = np.stack([life.cycles.stress_amplitude, life.cycles.mean_stress], axis=1)
    assert np.isclose(rows, [135, 155]).all(axis=1).any()


def test_a_path_that_is_not_proportional_is_raised_by_its_own_ratio():
    """A circle of 140 MPa beside a proportional overload of 260 that has the worst utilisation."""
    path, overload = circle(140.0), line(YY, 260, -260)
    verdict, task = duty_of(path, overload, counts=[1e7, 1])
    ratio = raised_exactly(verdict, "c0", 0)
    assert 1.05 < ratio < 1.3
    alone = life_of(path, counts=[1e7])
    (both,) = lives_of(verdict, task, np.array([0]))
    assert both.safety <= alone.safety
    assert_allclose(alone.safety, LIMIT / (ratio * 140.0), rtol=2e-3)


@pytest.mark.parametrize("seed", range(12))
def test_a_further_cycle_never_makes_a_life_longer(seed):
    """But for peaks that meet other valleys, with other means, as often as the further one runs."""
    rng = np.random.default_rng(seed)

    def cycle():
        ends = rng.normal(size=(rng.integers(2, 7), 6)) * [120, 60, 0, 60, 0, 0]
        return ends + rng.normal() * 60 * XX

    first, second = cycle(), cycle()
    few, many = 10 ** rng.uniform(1, 3), 10 ** rng.uniform(4, 7)
    alone = life_of(first, counts=[many])
    both = life_of(first, second, counts=[many, few])
    assert both.safety <= alone.safety * (1 + 2e-4)


def test_where_earlier_use_has_begun_no_life_is_endless():
    """149 MPa, just below the limit, 1e9 times."""
    cycle = line(XX, 149, -149)
    assert life_of(cycle, counts=[1e9]).damage == 0.0
    begun = life_of(cycle, counts=[1e9], begun=True)
    assert begun.damage > 100.0
    assert begun.safety < 1.0


def test_aluminium_has_no_endless_life():
    aluminium = known_materials()["6082-T6"]
    life = life_of(line(XX, 59, -59), counts=[1e12], limit=60.0, material=aluminium)
    assert life.damage > 1.0
    assert life.safety < 1.0


def test_the_line_meets_the_limit_at_the_cycles_of_a_stated_endurance_ratio():
    """0.34 S_u at 1e6 cycles, by hand at 1e5: 0.9 S_u (0.34/0.9)^(2/3)."""
    iron = replace(STEEL, endurance_ratio=0.34, endurance_cycles=1e6)
    limit = 0.34 * 470
    curve = life_curve(iron, np.array([limit]), axial=False)
    found = curve.cycles_to_failure(np.array([0.9 * 470 * (0.34 / 0.9) ** (2 / 3)]))
    assert_allclose(found, 1e5, rtol=1e-9)
    unstated = replace(iron, endurance_cycles=STEEL.endurance_cycles)
    longer = life_of(line(XX, 250, -250), counts=[1.0], limit=limit, material=unstated).damage
    shorter = life_of(line(XX, 250, -250), counts=[1.0], limit=limit, material=iron).damage
    slope = [np.log(0.9 / 0.34) / np.log(knee / 1e3) for knee in (1e6, 5e8)]
    by_hand = [1e-3 * (250 / (0.9 * 470)) ** (1 / one) for one in slope]
    assert_allclose([shorter, longer], by_hand, rtol=1e-9)


def test_a_limit_above_the_strength_at_a_thousand_cycles_has_no_line():
    good = replace(STEEL, endurance_ratio=0.4)
    assert why_no_curve(good, 0.89 * 470, axial=False) is None
    assert "no S-N line" in why_no_curve(good, 0.91 * 470, axial=False)
    with pytest.raises(ValueError, match="endured 1e3 times"):
        life_curve(good, np.array([0.91 * 470]), axial=False)


def test_a_limit_that_a_slope_of_one_does_not_reach_has_no_line():
    """From 0.9 S_u at 1e3 cycles a slope of 1 falls to 0.9 S_u/1000 at 1e6."""
    weak = replace(STEEL, endurance_ratio=4e-13, endurance_cycles=1e6)
    least = 0.9 * 470 / 1000
    assert why_no_curve(weak, 1.01 * least, axial=False) is None
    assert life_curve(weak, np.array([1.01 * least]), axial=False).slope > 1
    assert "raise its endurance_ratio" in why_no_curve(weak, 0.99 * least, axial=False)
    with pytest.raises(ValueError, match="must be above 1"):
        life_curve(weak, np.array([0.99 * least]), axial=False)


def test_the_pair_of_a_life_is_that_of_the_cycle_that_does_most_damage():
    """One overload of 400 MPa against 1e6 cycles of 200: the overload is the longest chord."""
    verdict, task = duty_of(line(XX, 400, -400), line(XX, 0, 200, -200), counts=[1, 1e6])
    assert verdict.peak.pair == (0, 1)
    (life,) = lives_of(verdict, task, np.array([0]))
    assert life.pair == (3, 4)


def under_waves(seed, count=40):
    """Verdict and task of points of pressure, of mean tension and of circles."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(count, 6, 3)) * rng.uniform(0.2, 1, size=(count, 1, 1))
    basis[:, :3] += rng.normal(size=(count, 1, 3)) * 2  # hydrostatic: in no chord
    turn = 2 * np.pi * np.arange(24) / 24
    waves = [np.cos(turn), np.sin(turn), 1.5 + 0 * turn]
    coefficients = 25 * np.stack(waves)
    runs = duty_runs({"a": slice(0, 24)}, {"a": 1.0})
    verdict = duty_verdict(
        basis, coefficients, np.full(count, LIMIT), LIMIT, STEEL.ultimate_stress, runs
    )
    return verdict, LifeTask({"a": 3e4}, STEEL, False, 0.3)


@pytest.mark.parametrize("seed", [12, 17, 20])
def test_the_worst_of_many_points_is_found_where_tension_and_planes_decide(seed, monkeypatch):
    """Points of pressure, of mean tension and of circles: the bound must cover them all.

    It is asked every four points, as a part's is many times; a bound that leaves out the mean
    tension misses the worst point of each of these seeds.
    """
    monkeypatch.setattr("checks.strength.finite_life._TOGETHER", 4)
    verdict, task = under_waves(seed)
    found = shortest_life(verdict, task)
    each = [lives_of(verdict, task, np.array([k]))[0].safety for k in range(40)]
    assert_allclose(found.safety, min(each), rtol=1e-9)
    assert found.point == int(np.argmin(each))


def test_a_life_that_is_no_shorter_than_one_known_is_not_told(monkeypatch):
    """By 1e-9 of its safety to both sides; what cannot be shorter is not read."""
    verdict, task = under_waves(12)
    found = shortest_life(verdict, task)
    assert shorter_life(verdict, task, (1 + 1e-9) * found.safety).safety == found.safety
    assert shorter_life(verdict, task, (1 - 1e-9) * found.safety) is None
    monkeypatch.delattr("checks.strength.finite_life.readings_of")
    assert shorter_life(verdict, task, 1e-3 * found.safety) is None


def test_findleys_planes_are_searched_only_where_the_worst_point_may_be(monkeypatch):
    """A plane takes 20 ms of the second that a part's life would; 32 points are bounded at once."""
    verdict, task = under_waves(12)
    searched = []

    def searching(verdict, run, point):
        searched.append(point)
        return raised_exactly(verdict, run, point)

    monkeypatch.setattr("checks.strength.finite_life.raised_exactly", searching)
    shortest_life(verdict, task)
    assert len(searched) < 8  # lives by brute force, above, need those of all 40


@pytest.mark.parametrize("factor", [0.5, 1.2, 3.0])
def test_findleys_plane_raises_cycles_by_the_same_share_whatever_the_size_of_the_loads(factor):
    """The proof of the safety multiplies all loads by it: their path keeps its shape."""
    verdict, task = duty_of(circle(200.0), counts=[1e5])
    at_all = np.array([0])
    (life,) = lives_of(verdict, task, at_all)
    assert life.raised > 1.05
    (scaled,) = lives_of(verdict, task, at_all, factor)
    assert_allclose(scaled.raised, life.raised, rtol=1e-9)
    assert_allclose(scaled.safety * factor, life.safety, rtol=1e-6)


@pytest.mark.parametrize("count", [2e3, 3e5, 1e8])
def test_the_bound_of_a_push_that_comes_and_goes_is_its_life_and_a_tension(count):
    """One cycle of -80 +- 80 MPa a run, whose path is there and back, on all of the curve."""
    verdict, task = duty_of(
        line(XX, *(-160 * np.sin(np.linspace(0, np.pi, 9)) ** 2)), counts=[count]
    )
    task = replace(task, begun=True)
    (life,) = lives_of(verdict, task, np.array([0]))
    tension = 160 / 3 / STEEL.ultimate_stress  # p + 2/3 of the von Mises stress, of a push
    assert_allclose(most_used(verdict, task), 1 / life.safety + tension, rtol=1e-6)


@pytest.mark.parametrize("seed", range(12, 18))
def test_no_point_is_used_more_than_its_bound(seed):
    verdict, task = under_waves(seed)
    used = [1 / life.safety for life in lives_of(verdict, task, np.arange(40))]
    assert (most_used(verdict, task) >= used).all()


def test_a_range_between_the_cycles_of_a_duty_is_in_the_bound():
    """A pull and a push, each still for itself: only between them is a range."""
    pull, push = line(XX, 200, 200), line(XX, -200, -200)
    verdict, task = duty_of(pull, push, counts=[1e5, 1e5])
    (life,) = lives_of(verdict, task, np.array([0]))
    assert most_used(verdict, task)[0] >= 1 / life.safety > 0.9
