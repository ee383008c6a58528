"""Fatigue over a duty: ranges between its cycles, finite life, and the proof of the safety."""

from math import log10

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.design.materials import known_materials
from checks.strength.finite_life import LifeTask, life_curve, lives_of, shortest_life
from checks.stress import duty_verdict as duty
from checks.stress.duty_verdict import JOINED, duty_runs, duty_verdict, most_used
from fatigue import ductile_verdict, goodman

STEEL = known_materials()["S355"]
LIMIT = 150.0


def verdict_on(basis, coefficients, cycles, limit=LIMIT):
    limits = np.full(len(basis), limit)
    runs = duty_runs(cycles, dict.fromkeys(cycles, 1.0))
    return duty_verdict(basis, coefficients, limits, limit, STEEL.ultimate_stress, runs)


def uniaxial(*histories):
    """One point in tension, MPa, and the slices of its cycles, named a, b, ..."""
    basis = np.array([[[1.0], [0], [0], [0], [0], [0]]])
    ends = np.cumsum([0, *(len(h) for h in histories)])
    cycles = {name: slice(a, b) for name, a, b in zip("abc", ends[:-1], ends[1:], strict=False)}
    return basis, np.concatenate(histories)[None], cycles


def out_of_phase(seed, points=60, positions=24, unit_loads=4):
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(unit_loads, positions)).cumsum(axis=1)
    return 20.0 * rng.normal(size=(points, 6, unit_loads)), coefficients


def test_the_range_between_two_cycles_of_a_duty_decides():
    """0 to 100 and 200 to 300 MPa: together 0 to 300, amplitude and mean 150."""
    verdict = verdict_on(*uniaxial([0.0, 100.0], [200.0, 300.0]))
    peak = verdict.peak
    assert peak.cycle == JOINED
    assert peak.pair == (0, 3)
    assert_allclose(peak.value, LIMIT * (150 / LIMIT + 150 / 470))


@pytest.mark.parametrize("scale", [1.0, 0.2])
@pytest.mark.parametrize("seed", range(4))
def test_how_much_points_are_used_is_what_the_verdict_has(seed, scale):
    """Without the verdict's name of the path. With small stresses no mean counts: Findley decides.

    Each value known of one is within the bound of the other, and the worst is the same.
    """
    basis, coefficients = out_of_phase(seed)
    basis = scale * basis
    runs = duty_runs({"a": slice(0, 9), "b": slice(9, 24)}, {"a": 1.0, "b": 1.0})
    limits = np.linspace(0.9, 1.1, 60) * LIMIT
    verdict = duty_verdict(basis, coefficients, limits, LIMIT, 470.0, runs)
    known, bound = most_used(basis, coefficients, limits, 470.0, runs)
    assert_allclose(known.max(), verdict.known.max(), rtol=1e-9)
    assert known.argmax() == verdict.known.argmax()
    assert (known <= bound * (1 + 1e-12)).all()
    assert (known <= verdict.bound * (1 + 1e-9)).all()
    assert (verdict.known <= bound * (1 + 1e-9)).all()


def test_a_cycle_with_a_larger_mean_is_used_more_than_the_path_that_holds_it():
    """0 to 300 MPa beside -310 to -5: their longest chord, from -310 to 300, has a mean below 0."""
    basis, coefficients, cycles = uniaxial([0.0, 300.0], [-310.0, -5.0])
    runs = duty_runs(cycles, dict.fromkeys(cycles, 1.0))
    known, _ = most_used(basis, coefficients, np.array([LIMIT]), 310.0, runs)
    assert_allclose(known, max(305 / LIMIT, 150 / LIMIT + 150 / 310))
    low, _ = most_used(basis, coefficients, np.array([1e4]), 310.0, runs)
    assert_allclose(low, 150 / 1e4 + 150 / 310)


def test_a_duty_of_one_cycle_is_that_cycle():
    verdict = verdict_on(*uniaxial([0.0, 100.0, 50.0]))
    assert list(verdict.verdicts) == ["a"]
    assert verdict.peak.cycle == "a"


def test_of_equal_utilisations_the_cycle_itself_decides():
    verdict = verdict_on(*uniaxial([-150.0, 100.0], [0.0, 100.0]))
    assert verdict.peak.cycle == "a"


def test_cycles_that_stand_in_no_duty_are_left_out():
    runs = duty_runs({"a": slice(0, 3), "b": slice(3, 5)}, {"b": 10.0})
    assert list(runs) == ["b"]
    assert runs["b"].tolist() == [3, 4]
    assert duty_verdict(np.zeros((1, 6, 1)), np.zeros((1, 5)), np.ones(1), 1.0, 1.0, {}) is None


@pytest.mark.parametrize("seed", range(4))
def test_all_loads_times_the_safety_use_up_just_all_of_the_limit(seed):
    verdict = verdict_on(*out_of_phase(seed), {"a": slice(0, 24)})
    assert verdict.safety_missed() < 1e-9
    assert verdict.worst.safety != pytest.approx(1.0, rel=0.01)


def test_utilisation_at_points_is_that_of_the_worst_point_there():
    verdict = verdict_on(*out_of_phase(1), {"a": slice(0, 24)})
    used = verdict.utilisation_at(np.arange(60))
    assert used.argmax() == verdict.peak.point
    assert_allclose(used.max() * LIMIT, verdict.peak.value)


def two_places_two_cycles():
    """Point 0 is loaded by the first cycle alone, point 1 by the second: 100 and 90 MPa."""
    basis = np.zeros((2, 6, 2))
    basis[0, 0, 0] = basis[1, 0, 1] = 1.0
    coefficients = np.array([[100.0, -100, 0, 0, 0, 0], [0, 0, 0, 90, -90, 30]])
    return verdict_on(basis, coefficients, {"a": slice(0, 3), "b": slice(3, 6)})


def test_everywhere_a_point_that_another_cycle_loads_has_that_ones_utilisation():
    found = two_places_two_cycles().everywhere
    assert_allclose(found.utilisation, [100 / LIMIT, 90 / LIMIT])
    assert_allclose(found.amplitude, [100, 90])
    assert_allclose(found.mean, [0, 0], atol=1e-12)
    assert found.goodman_only == 0


@pytest.mark.parametrize("seed", range(3))
def test_everywhere_is_the_worst_of_all_paths_with_amplitude_and_mean_of_that_path(seed):
    basis, coefficients = out_of_phase(seed)
    verdict = verdict_on(basis, coefficients, {"a": slice(0, 9), "b": slice(9, 24)})
    found = verdict.everywhere
    assert len(verdict.runs) == 3
    each = []
    for run in verdict.runs.values():
        path = np.ascontiguousarray(coefficients[:, run])
        each.append(goodman(basis, path, LIMIT, STEEL.ultimate_stress))
    planes = [v.plane_utilisation for v in verdict.verdicts.values()]
    used = np.fmax([one.utilisation for one in each], planes)
    assert_allclose(found.utilisation, used.max(axis=0), rtol=1e-12)
    rows = np.arange(len(basis))
    assert_allclose(found.amplitude, np.array([e.amplitude for e in each])[used.argmax(0), rows])
    assert_allclose(found.mean, np.array([e.mean for e in each])[used.argmax(0), rows])
    assert found.utilisation.max() * LIMIT == pytest.approx(verdict.peak.value)


def test_places_that_findley_may_use_more_than_is_told_are_counted():
    """Point 1 turns out of phase at two thirds of what decides: its plane was not needed."""
    turn = 2 * np.pi * np.arange(36) / 36
    basis = np.zeros((2, 6, 3))
    basis[0, 0, 0] = basis[1, 0, 1] = 1.0
    basis[1, 3, 2] = 3**-0.5
    paths = np.stack([150 * np.cos(turn), 100 * np.cos(turn), 100 * np.sin(turn)])
    verdict = verdict_on(basis, paths, {"a": slice(0, 36)})
    assert np.isnan(verdict.worst.plane_utilisation[1])
    assert verdict.everywhere.goodman_only == 1


def test_the_pair_is_of_all_positions_of_all_cycles():
    verdict = verdict_on(*uniaxial([0.0, 10.0], [0.0, 5.0, 300.0]))
    assert verdict.peak.cycle == "b"
    assert verdict.peak.pair == (2, 4)


def test_on_a_circle_of_bending_and_torsion_findley_decides_here_too():
    turn = 2 * np.pi * np.arange(48) / 48
    basis = np.zeros((2, 6, 2))
    basis[:, 0, 0], basis[:, 3, 1] = 1.0, 3**-0.5
    basis[1] *= 0.5
    verdict = verdict_on(basis, 100 * np.stack([np.cos(turn), np.sin(turn)]), {"a": slice(0, 48)})
    assert verdict.peak.criterion == "Findley"
    by_chord = float(verdict.worst.goodman.utilisation.max())
    assert verdict.utilisation_at(np.array([0]))[0] * LIMIT == pytest.approx(verdict.peak.value)
    assert verdict.peak.value > 1.1 * by_chord * LIMIT


def task(counts, **changes):
    stated = {"material": STEEL, "axial": False, "allowed_damage": 1.0} | changes
    return LifeTask(counts, **stated)


def cycles_by_hand(amplitude, mean):
    """Cycles to failure of S355 by Goodman and Basquin, f = 0.9 below 482 MPa, Haibach below."""
    reversed_amplitude = amplitude / (1 - mean / 470)
    slope = 3 / log10(0.9 * 470 / LIMIT)
    if reversed_amplitude < LIMIT:
        slope = 2 * slope - 1
    return 1e6 * (reversed_amplitude / LIMIT) ** -slope


def test_cycles_of_a_duty_are_counted_with_those_between_them_and_added_up():
    """Peaks 300 (10 times) and 100 (10 000), valleys -100 (10 000) and 0 (10), the highest with
    the lowest: 10 x 300/-100, 9 990 x 100/-100, 10 x 100/0.
    """
    verdict = verdict_on(*uniaxial([-100.0, 100.0], [0.0, 300.0]))
    (life,) = lives_of(verdict, task({"a": 1e4, "b": 10.0}), np.array([0]))
    table = np.stack(
        [life.cycles.stress_amplitude, life.cycles.mean_stress, life.cycles.cycle_counts], axis=1
    )
    assert_allclose(table, [[200, 100, 10], [100, 0, 9990], [50, 50, 10]])
    assert_allclose(life.damage, sum(n / cycles_by_hand(a, max(m, 0)) for a, m, n in table))
    assert life.pair == (0, 3)


def test_means_are_those_of_the_normal_stress_and_not_of_the_von_mises_chord():
    """Equal biaxial tension 0 to 100: the chord is 100 von Mises, the mean 50, as Goodman's.

    With a static hydrostatic stress of 60 the mean is 110, which the chord does not see.
    """
    basis = np.zeros((1, 6, 2))
    basis[0, :2, 0] = 1.0
    basis[0, :3, 1] = 1.0
    coefficients = np.array([[0.0, 100.0], [60.0, 60.0]])
    verdict = verdict_on(basis, coefficients, {"a": slice(0, 2)})
    (life,) = lives_of(verdict, task({"a": 1.0}), np.array([0]))
    assert_allclose(life.cycles.stress_amplitude, [50.0])
    assert_allclose(life.cycles.mean_stress, [110.0])
    assert_allclose(verdict.worst.goodman.mean, [110.0])


@pytest.mark.parametrize(("seed", "allowed"), [(0, 1e-3), (1, 1.0), (2, 1.0)])
def test_the_worst_point_is_found_without_counting_all(seed, allowed, monkeypatch):
    """Of 20 points four are counted before the bound is asked again."""
    monkeypatch.setattr("checks.strength.finite_life._TOGETHER", 4)
    basis, coefficients = out_of_phase(seed, points=20, positions=30)
    basis *= np.linspace(0.2, 1.0, 20)[:, None, None]
    verdict = verdict_on(basis, coefficients, {"a": slice(0, 12), "b": slice(12, 30)})
    asked = task({"a": 1e5, "b": 3e3}, allowed_damage=allowed)
    found = shortest_life(verdict, asked)
    each = lives_of(verdict, asked, np.arange(20))
    worst = min(each, key=lambda life: life.safety)
    assert found.point == worst.point
    assert_allclose(found.safety, worst.safety, rtol=1e-12)


def test_loads_times_the_finite_life_safety_do_the_allowed_damage():
    verdict = verdict_on(*out_of_phase(2), {"a": slice(0, 24)})
    asked = task({"a": 5e4}, allowed_damage=0.3)
    life = shortest_life(verdict, asked)
    (again,) = lives_of(verdict, asked, np.array([life.point]), life.safety)
    assert_allclose(again.safety, 1.0, rtol=1e-9)
    assert_allclose(again.damage, 0.3, rtol=1e-6)


def test_a_life_without_a_cycle_above_the_limit_is_infinite_however_often_it_runs():
    """0 to 120 MPa: 60/150 + 60/470; 420 MPa a thousand times begins damage."""
    verdict = verdict_on(*uniaxial([0.0, 120.0], [0.0, 420.0]))
    often = task({"a": 1e9, "b": 1e3})
    (alone,) = lives_of(verdict_on(*uniaxial([0.0, 120.0])), often, np.array([0]))
    assert alone.damage == 0.0
    assert_allclose(alone.safety, 1 / (60 / LIMIT + 60 / 470), rtol=1e-9)
    (both,) = lives_of(verdict, often, np.array([0]))
    assert_allclose(both.damage, 1e3 / cycles_by_hand(210, 210) + 1e9 / cycles_by_hand(60, 60))
    assert 1e9 / cycles_by_hand(60, 60) > 0.05


def test_more_runs_in_a_life_leave_less_safety():
    verdict = verdict_on(*out_of_phase(3), {"a": slice(0, 24)})
    safeties = [shortest_life(verdict, task({"a": n})).safety for n in (1e2, 1e3, 1e4, 1e5)]
    assert safeties == sorted(safeties, reverse=True)
    assert len(set(safeties)) == 4
    endless = shortest_life(verdict, task({"a": 1e12})).safety
    assert_allclose(endless, verdict.worst.safety, rtol=0.05)  # rainflow's means, chord's means


def test_axial_force_starts_lower_at_a_thousand_cycles():
    """0.75 instead of 0.9 of the ultimate strength."""
    start = [
        float(life_curve(STEEL, np.array(LIMIT), axial=axial).cycles_to_failure(0.75 * 470))
        for axial in (False, True)
    ]
    assert start[1] == pytest.approx(1e3, rel=1e-9)
    assert start[0] > 2e3


def test_aluminium_has_its_limit_at_five_hundred_million_cycles():
    aluminium = known_materials()["6082-T6"]
    curve = life_curve(aluminium, np.array(60.0), axial=False)
    assert float(curve.cycles_to_failure(60.0)) == pytest.approx(5e8)
    assert float(curve.cycles_to_failure(0.9 * 295)) == pytest.approx(1e3)


def test_a_small_verdict_is_judged_once_and_another_of_other_numbers_anew(monkeypatch):
    asked = []

    def counted(*arguments, **options):
        asked.append(len(arguments[0]))
        return ductile_verdict(*arguments, **options)

    monkeypatch.setattr(duty, "ductile_verdict", counted)
    basis, coefficients = out_of_phase(17)
    runs = {"a": slice(0, 24)}
    first = verdict_on(basis, coefficients, runs)
    assert verdict_on(basis.copy(), coefficients.copy(), runs).peak == first.peak
    assert len(asked) == 1
    other = verdict_on(1.1 * basis, coefficients, runs)
    assert len(asked) == 2
    assert other.peak.value > first.peak.value
    assert verdict_on(basis, coefficients, runs, limit=2 * LIMIT).peak.value != first.peak.value
    assert len(asked) == 3
