"""The verdict of ductile metals: Goodman where paths are straight, the worse of both elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fatigue import critical_plane, ductile_verdict, findley_criterion, goodman
from tests.fatigue.multiaxial_cases import (
    bending_and_torsion,
    random_path,
    random_rotation,
    turned,
)

DUCTILE = findley_criterion()


def of_path(path, endurance=200.0, ultimate=400.0, **options):
    return ductile_verdict(np.eye(6)[None], path, endurance, ultimate, **options)


def many_points(seed, n_points=60):
    """Points under the same non-proportional cycle; a third of them see one unit load only."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(n_points, 6, 6)) * rng.uniform(0.3, 1.0, size=(n_points, 1, 1))
    basis[::3, :, 1:] = 0.0
    return basis, random_path(seed, static=0.4)


def every_utilisation(basis, coefficients, endurance, ultimate):
    """Goodman and Findley at every point with no pass before: an independent maximum."""
    by_chord = goodman(basis, coefficients, endurance, ultimate)
    limit = DUCTILE.limit_ratio * endurance
    planes = [critical_plane(point @ coefficients, DUCTILE.k).value for point in basis]
    return by_chord.utilisation, np.array(planes) / limit


@pytest.mark.parametrize("mean", [-300.0, 0.0, 50.0, 300.0])
def test_uniaxial_stress_is_the_textbook_s_goodman_line(mean):
    verdict = of_path(bending_and_torsion(100.0, 0.0, mean=mean))
    expected = 100.0 / 200.0 + max(mean, 0.0) / 400.0
    assert verdict.safety == pytest.approx(1.0 / expected, rel=1e-12)
    assert (verdict.criterion, verdict.n_searched, verdict.plane) == ("Goodman", 0, None)


def test_alternating_torsion_endures_the_limit_over_root_3():
    verdict = of_path(bending_and_torsion(0.0, 200.0 / np.sqrt(3.0)))
    assert verdict.safety == pytest.approx(1.0, rel=1e-12)


def test_both_criteria_agree_on_reversed_tension_and_torsion():
    """So that a utilisation of one is one of the other: no jump where the second comes in."""
    for path in (bending_and_torsion(200.0, 0.0), bending_and_torsion(0.0, 200.0 / np.sqrt(3.0))):
        plane = critical_plane(path, DUCTILE.k)
        assert plane.value / (DUCTILE.limit_ratio * 200.0) == pytest.approx(1.0, rel=1e-8)


def test_in_phase_bending_and_torsion_differ_by_3_5_percent_at_most():
    """The jump at the border of proportional paths, fully reversed, by hand.

    bending = b cos a, torsion = b sin a/sqrt(3), k = 0.15659, f = 0.58439 b: at a = 60 degrees
    F = (sqrt(1/16 + 1/4) * 1.01219 + k/4) b = 0.60498 b, 1.0352 of f.
    """
    ratios = []
    for mix in np.linspace(0.0, np.pi / 2.0, 31):
        path = bending_and_torsion(200.0 * np.cos(mix), 200.0 * np.sin(mix) / np.sqrt(3.0))
        value = critical_plane(path, DUCTILE.k).value
        ratios.append(value / (DUCTILE.limit_ratio * 200.0))
    assert min(ratios) >= 1.0 - 1e-8
    assert max(ratios) == pytest.approx(1.0352, abs=5e-5)


def test_out_of_phase_bending_and_torsion_are_decided_by_the_shear_plane():
    """A circle in the von Mises norm: Goodman sees its diameter only."""
    path = bending_and_torsion(150.0, 150.0 / np.sqrt(3.0), 90.0)
    verdict = of_path(path, ultimate=600.0)
    by_chord = goodman(np.eye(6)[None], path, 200.0, 600.0)
    assert verdict.criterion == "Findley"
    assert by_chord.utilisation[0] < verdict.utilisation[0]
    expected = critical_plane(path, DUCTILE.k)
    assert verdict.utilisation[0] == pytest.approx(
        expected.value / (DUCTILE.limit_ratio * 200.0), rel=1e-9
    )
    assert verdict.pair == expected.pair
    assert_allclose(verdict.plane.normal, expected.normal)


@pytest.mark.parametrize("seed", range(8))
def test_the_worst_point_is_that_of_searching_every_point(seed):
    basis, coefficients = many_points(seed)
    endurance = np.random.default_rng(seed).uniform(150.0, 250.0, len(basis))
    ultimate = 300.0 + 600.0 * (seed % 3)
    verdict = ductile_verdict(basis, coefficients, endurance, ultimate)
    chords, planes = every_utilisation(basis, coefficients, endurance, ultimate)
    worse = np.where(verdict.proportional, chords, np.maximum(chords, planes))
    assert verdict.utilisation.max() == pytest.approx(worse.max(), rel=1e-9)
    assert verdict.critical == worse.argmax()
    assert (worse <= verdict.highest_utilisation * (1.0 + 1e-9)).all()
    assert (verdict.utilisation <= worse * (1.0 + 1e-9)).all()
    assert verdict.proportional[::3].all()
    assert not verdict.proportional[1::3].any()


def test_findley_decides_some_of_these_and_goodman_others():
    criteria = {ductile_verdict(*many_points(seed), 200.0, 2000.0).criterion for seed in range(12)}
    assert criteria == {"Findley", "Goodman"}


def test_points_whose_bound_shows_that_they_cannot_govern_are_not_searched():
    basis, coefficients = many_points(1, n_points=400)
    verdict = ductile_verdict(basis, coefficients, 200.0, 400.0)
    assert verdict.n_searched < 40
    weak = basis * np.where(np.arange(400) == 211, 20.0, 1.0)[:, None, None]
    alone = ductile_verdict(weak, coefficients, 200.0, 2000.0)
    assert (alone.critical, alone.n_searched) == (211, 1)


def test_a_point_that_governs_by_a_little_is_not_skipped():
    """Mixed reversed loads use Findley 1.0352 times the amplitude; the other point's is 1.02."""
    turn = 2.0 * np.pi * np.arange(360) / 360
    basis = np.zeros((2, 6, 2))
    basis[0, 0, 0] = 204.0
    basis[1, [0, 3], 0] = 100.0
    basis[1, 0, 1] = 100.0
    verdict = ductile_verdict(basis, np.stack([np.cos(turn), 0.05 * np.sin(turn)]), 200.0, 400.0)
    assert verdict.goodman.utilisation[0] == pytest.approx(1.02, rel=1e-12)
    assert (verdict.critical, verdict.criterion, verdict.n_searched) == (1, "Findley", 1)
    assert verdict.utilisation[1] == pytest.approx(1.0352, abs=2e-3)


def test_the_safety_is_proved_by_scaling_the_loads_with_it():
    for seed in (0, 3, 5):
        basis, coefficients = many_points(seed)
        safety = ductile_verdict(basis, coefficients, 200.0, 900.0).safety
        proof = ductile_verdict(basis, safety * coefficients, 200.0, 900.0)
        assert proof.safety == pytest.approx(1.0, rel=1e-9)
        twice = ductile_verdict(basis, 2.0 * coefficients, 200.0, 900.0)
        assert twice.safety == pytest.approx(safety / 2.0, rel=1e-9)


def test_turning_the_frame_and_starting_elsewhere_change_nothing():
    basis, coefficients = many_points(5)
    before = ductile_verdict(basis, coefficients, 200.0, 2000.0)
    frame = np.stack([turned(point, random_rotation(5)) for point in basis])
    after = ductile_verdict(frame, np.roll(coefficients, 13, axis=1), 200.0, 2000.0)
    assert after.critical == before.critical
    assert after.safety == pytest.approx(before.safety, rel=1e-9)


def test_a_finer_cycle_changes_the_verdict_by_its_sampling_error_only():
    """Half a step from the extreme of a harmonic: 1 - cos(pi/90) = 6e-4 at 90 positions."""
    coarse, fine = (
        of_path(bending_and_torsion(150.0, 90.0, 70.0, n_positions=n)).safety for n in (90, 5760)
    )
    assert 0.0 <= coarse / fine - 1.0 < 6.1e-4


def test_the_mean_sensitivity_of_findley_may_exceed_goodman_s_only_off_the_straight_line():
    """S_e/S_u = 0.05: static tension on torsion with a little out of phase."""
    path = bending_and_torsion(10.0, 60.0, 90.0, mean=300.0)
    verdict = of_path(path, ultimate=4000.0)
    assert verdict.criterion == "Findley"
    straight = of_path(bending_and_torsion(0.0, 60.0, mean=300.0), ultimate=4000.0)
    assert straight.criterion == "Goodman"


def test_another_torsion_limit_moves_the_plane_s_verdict():
    path = bending_and_torsion(120.0, 100.0, 90.0)
    for ratio in (0.55, 0.65):
        verdict = of_path(path, ultimate=2000.0, torsion_ratio=ratio)
        plane = critical_plane(path, findley_criterion(ratio).k)
        expected = plane.value / (findley_criterion(ratio).limit_ratio * 200.0)
        assert verdict.plane_utilisation[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("n_positions", [1, 2, 30])
def test_no_stress_has_infinite_safety(n_positions):
    verdict = of_path(np.zeros((6, n_positions)))
    assert (verdict.safety, verdict.criterion) == (float("inf"), "Goodman")


def test_stress_beyond_the_ultimate_strength_is_used_up_and_not_negative():
    verdict = of_path(bending_and_torsion(900.0, 500.0, 60.0, mean=4000.0))
    assert 0.0 < verdict.safety < 0.1


def test_fully_compressive_cycles_are_no_better_than_reversed_ones():
    pressed = bending_and_torsion(150.0, 80.0, 90.0, mean=-2000.0)
    assert of_path(pressed).safety == pytest.approx(
        of_path(bending_and_torsion(150.0, 80.0, 90.0)).safety, rel=1e-6
    )


def test_what_is_not_finite_is_refused_with_its_place():
    basis, coefficients = many_points(2)
    basis[23, 1, 1] = np.nan
    with pytest.raises(ValueError, match="not finite at point 23"):
        ductile_verdict(basis, coefficients, 200.0, 400.0)


@pytest.mark.parametrize("seed", range(8))
def test_goodman_where_he_can_govern_gives_the_same_worst_point(seed):
    basis, coefficients = many_points(seed, n_points=500)
    ultimate = 300.0 + 800.0 * (seed % 3)
    whole = ductile_verdict(basis, coefficients, 200.0, ultimate)
    quick = ductile_verdict(basis, coefficients, 200.0, ultimate, every_point=False)
    assert quick.safety == pytest.approx(whole.safety, rel=1e-12)
    assert (quick.critical, quick.criterion) == (whole.critical, whole.criterion)
    assert quick.pair == whole.pair
    assert len(quick.points) < 200
    assert whole.points.tolist() == list(range(500))
    assert (quick.highest_utilisation >= whole.utilisation * (1.0 - 1e-12)).all()
    assert_allclose(quick.goodman_bound[quick.points], whole.goodman_bound[quick.points])


def test_the_plane_of_a_point_that_goodman_decides_is_sought_only_where_every_point_is_asked():
    """A little torsion out of phase: not proportional, and Findley far below Goodman."""
    path = bending_and_torsion(150.0, 10.0, 90.0, mean=300.0)
    whole = of_path(path)
    quick = ductile_verdict(np.eye(6)[None], path, 200.0, 400.0, every_point=False)
    assert whole.plane is not None
    assert quick.plane is None
    assert (quick.criterion, quick.pair) == (whole.criterion, whole.pair)
    assert quick.safety == whole.safety
    assert quick.plane_bound[0] >= whole.plane_utilisation[0]


def test_goodman_goes_on_while_a_bound_is_above_the_worst_by_a_little():
    """64 triangles, one lot, use 1.00 with higher bounds; a tension of 1.08 comes after them."""
    third = 2.0 * np.pi * np.arange(3) / 3
    basis = np.zeros((65, 6, 2))
    basis[:64, 0, 0], basis[:64, 3, 1] = 1.0, 1.0 / np.sqrt(3.0)
    basis[64, 0, 0] = 1.08
    coefficients = 400.0 / np.sqrt(3.0) * np.stack([np.sin(third), np.cos(third)])
    verdict = ductile_verdict(basis, coefficients, 200.0, 1e9, every_point=False)
    assert 64 in verdict.points
    assert verdict.goodman.utilisation.max() == pytest.approx(1.08, rel=1e-6)


def test_a_point_that_findley_alone_finds_gets_goodman_s_value_too():
    """128 tensions of 1.02 fill Goodman's two lots; the mixed point's bound is below them."""
    turn = 2.0 * np.pi * np.arange(360) / 360
    basis = np.zeros((129, 6, 2))
    basis[:, 0, 0] = 204.0
    basis[77, [0, 3], 0] = 100.0
    basis[77, 0, 1] = 100.0
    coefficients = np.stack([np.cos(turn), 0.05 * np.sin(turn)])
    quick = ductile_verdict(basis, coefficients, 200.0, 400.0, every_point=False)
    assert (quick.critical, quick.criterion) == (77, "Findley")
    assert 77 in quick.points
    alone = goodman(basis[77:78], coefficients, 200.0, 400.0).utilisation[0]
    assert quick.goodman_bound[77] == pytest.approx(alone, rel=1e-12)


def test_endurance_limits_of_other_points_or_none_are_refused():
    with pytest.raises(ValueError, match=r"one per point, \(1,\), got \(2,\)"):
        of_path(random_path(1), endurance=[200.0, 200.0])
    with pytest.raises(ValueError, match="endurance limit must be above 0 MPa, got -1"):
        of_path(random_path(1), endurance=-1.0)


def test_a_verdict_of_unequal_lengths_is_refused():
    verdict = of_path(random_path(1))
    with pytest.raises(ValueError, match="a verdict on 1 points"):
        replace(verdict, plane_bound=np.ones(2))
    with pytest.raises(ValueError, match="a verdict on 1 points"):
        replace(verdict, points=np.arange(2))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_exceeds_a_floor_is_as_without_one_and_below_it_nothing_is_sought(seed):
    basis, coefficients = many_points(seed)
    limits = np.full(len(basis), 200.0)
    whole = ductile_verdict(basis, coefficients, limits, 400.0, every_point=False)
    worst = whole.utilisation.max()
    less, more = (
        ductile_verdict(basis, coefficients, limits, 400.0, every_point=False, floor=share * worst)
        for share in (0.99, 2.0)
    )
    assert less.utilisation.max() == pytest.approx(worst, rel=1e-9)
    assert (less.critical, less.pair) == (whole.critical, whole.pair)
    assert (more.highest_utilisation >= more.utilisation).all()
    assert (whole.n_searched > 0, more.n_searched, len(more.points)) == (True, 0, 1)
