"""The verdict of both criteria: what must not matter to it, and what must."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import (
    critical_plane,
    ductile_verdict,
    findley_criterion,
    goodman,
    von_mises,
)
from tests.fatigue.multiaxial_cases import (
    random_path,
    random_rotation,
    turned,
)

FINDLEY = findley_criterion()
SEED = st.integers(0, 100_000)
STRENGTHS = st.sampled_from([(200.0, 300.0), (200.0, 900.0), (120.0, 2400.0)])
COMMON = settings(max_examples=25, deadline=None, derandomize=True)
SAME = (
    1e-9  # the search for the plane ends at edges of 1e-6 rad: 1e-12 of the stress, and round-off
)


def history(seed, n_points=12, static=0.4):
    """Points under a non-proportional cycle: a third see one unit load, a third nearly only one."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(n_points, 6, 6)) * rng.uniform(0.3, 1.0, size=(n_points, 1, 1))
    basis[::3, :, 1:] = 0.0
    basis[1::3, :, 1:] *= 0.02
    return basis, random_path(seed, static=static)


def same(one, other):
    """Whether two verdicts name the same point and criterion, with the same safety."""
    assert other.safety == pytest.approx(one.safety, rel=SAME)
    assert (other.critical, other.criterion) == (one.critical, one.criterion)


def test_these_histories_are_decided_by_both_criteria():
    found = {ductile_verdict(*history(seed), 200.0, 900.0).criterion for seed in range(12)}
    assert found == {"Findley", "Goodman"}


@COMMON
@given(SEED, STRENGTHS, st.floats(0.01, 100.0))
@example(0, (200.0, 900.0), 2.0)
@example(1, (200.0, 300.0), 2.0)
def test_the_safety_goes_down_as_the_load_goes_up(seed, strengths, factor):
    """Both criteria are linear in the load: double it, and the safety is half."""
    basis, coefficients = history(seed)
    before = ductile_verdict(basis, coefficients, *strengths)
    after = ductile_verdict(basis, factor * coefficients, *strengths)
    assert after.safety * factor == pytest.approx(before.safety, rel=SAME)
    assert (after.critical, after.criterion) == (before.critical, before.criterion)


@pytest.mark.parametrize("criterion", ["Goodman", "Findley"])
@pytest.mark.parametrize("every_point", [True, False])
def test_the_safety_is_proved_by_scaling_whichever_criterion_decides(criterion, every_point):
    proofs = 0
    for seed in range(12):
        basis, coefficients = history(seed)
        verdict = ductile_verdict(basis, coefficients, 200.0, 900.0, every_point=every_point)
        if verdict.criterion != criterion:
            continue
        proofs += 1
        scaled = verdict.safety * coefficients
        again = ductile_verdict(basis, scaled, 200.0, 900.0, every_point=every_point)
        assert again.safety == pytest.approx(1.0, rel=SAME)
        assert (again.critical, again.criterion) == (verdict.critical, criterion)
    assert proofs >= 3


@COMMON
@given(SEED, STRENGTHS, st.integers(0, 89))
def test_turned_axes_and_another_start_of_the_cycle_change_nothing(seed, strengths, start):
    basis, coefficients = history(seed)
    before = ductile_verdict(basis, coefficients, *strengths)
    frame = np.stack([turned(point, random_rotation(seed)) for point in basis])
    after = ductile_verdict(frame, np.roll(coefficients, start, axis=1), *strengths)
    same(before, after)
    moved = (np.array(before.pair) + start) % coefficients.shape[1]
    assert sorted(after.pair) == sorted(moved.tolist())
    # the line through a path far from straight is found roughly: any would serve for the bounds
    assert (after.proportional == before.proportional).all()
    slender = before.bounds.width < 0.1
    width = after.bounds.width[slender]
    assert_allclose(width, before.bounds.width[slender], rtol=1e-9, atol=1e-12)
    assert 4 <= slender.sum() < 12


@COMMON
@given(SEED, STRENGTHS)
def test_the_cycle_run_backwards_changes_nothing(seed, strengths):
    basis, coefficients = history(seed)
    verdicts = [
        ductile_verdict(basis, c, *strengths) for c in (coefficients, coefficients[:, ::-1])
    ]
    same(*verdicts)


@COMMON
@given(SEED, STRENGTHS, st.sampled_from([1e6, 1e-3, 145.0377]))
def test_other_units_of_stress_and_of_load_change_nothing(seed, strengths, unit):
    """Pa, GPa and psi instead of MPa; utilisations have no unit, amplitudes have."""
    basis, coefficients = history(seed)
    before = ductile_verdict(basis, coefficients, *strengths)
    endurance, ultimate = strengths
    after = ductile_verdict(unit * basis, coefficients, unit * endurance, unit * ultimate)
    same(before, after)
    assert_allclose(after.goodman.utilisation, before.goodman.utilisation, rtol=SAME)
    assert_allclose(after.goodman.amplitude, unit * before.goodman.amplitude, rtol=SAME)
    assert_allclose(after.highest_utilisation, before.highest_utilisation, rtol=1e-6)
    same(before, ductile_verdict(basis * unit, coefficients / unit, *strengths))


@COMMON
@given(SEED, STRENGTHS, st.integers(2, 5))
def test_positions_put_on_the_straight_way_between_two_change_nothing(seed, strengths, parts):
    """Longest chord, smallest circle and highest stress of a polygon rest on its corners."""
    basis, coefficients = history(seed)
    following = np.roll(coefficients, -1, axis=1)
    steps = np.arange(parts) / parts
    finer = coefficients[:, :, None] * (1.0 - steps) + following[:, :, None] * steps
    before = ductile_verdict(basis, coefficients, *strengths)
    after = ductile_verdict(basis, finer.reshape(6, -1), *strengths)
    same(before, after)
    assert [index // parts for index in after.pair] == list(before.pair)
    assert [index % parts for index in after.pair] == [0, 0]


def harmonics(seed, n_positions):
    """A path x = sum A_n cos(n t + s_n) without mean, and sums of n^2 |A_n| in two norms, MPa.

    The norms, von Mises' and Frobenius', bound the second derivative of the path.
    """
    rng = np.random.default_rng(seed)
    turn = 2.0 * np.pi * np.arange(n_positions) / n_positions
    path, bends = np.zeros((6, n_positions)), np.zeros(2)
    for n, shift in ((1, 0.0), (1, 1.5), (2, 0.3), (3, 0.7)):
        tensor = 100.0 / n**2 * rng.normal(size=6)
        path += tensor[:, None] * np.cos(n * turn + shift)
        size = np.sqrt((tensor[:3] ** 2).sum() + 2.0 * (tensor[3:] ** 2).sum())
        bends += n**2 * np.array([von_mises(tensor), size])
    return path, bends


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("n_positions", [24, 90, 360])
def test_a_finer_smooth_cycle_changes_no_more_than_its_chords_leave_out(seed, n_positions):
    """A step h of a path with |x''| <= B stays within B h^2/8 of its chord.

    The polygon of the chords has the verdict of its corners (see above), and the smooth path lies
    within d = B h^2/8 of it, in von Mises' norm d_v, in Frobenius' d_f. So half the longest chord
    grows by d_v at most; on any plane the circle by d_v/sqrt(3) and the normal stress by d_f.
    More positions of the same path can only make the values larger.
    """
    fine, (bend, bend_of_tensor) = harmonics(seed, 5760)
    coarse = fine[:, :: 5760 // n_positions]
    step = 2.0 * np.pi / n_positions
    left_out, left_out_of_tensor = bend * step**2 / 8.0, bend_of_tensor * step**2 / 8.0
    amplitudes = [
        goodman(np.eye(6)[None], path, 200.0, 400.0).amplitude[0] for path in (coarse, fine)
    ]
    planes = [critical_plane(path, FINDLEY.k).value for path in (coarse, fine)]
    growth = np.diff(amplitudes)[0]
    assert -1e-9 <= growth <= left_out
    plane_growth = np.diff(planes)[0]
    assert -1e-6 <= plane_growth <= left_out / np.sqrt(3.0) + FINDLEY.k * left_out_of_tensor
    if n_positions >= 90:
        assert left_out < 0.005 * amplitudes[1]  # the bound says something


@COMMON
@given(SEED, STRENGTHS, st.floats(0.0, 3.0), st.integers(1, 200))
def test_judging_only_where_it_can_matter_gives_the_same_verdict(seed, strengths, static, n_points):
    basis, coefficients = history(seed, n_points, static)
    endurance = strengths[0] * np.random.default_rng(seed).uniform(0.7, 1.3, n_points)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fatigue.verdict._TOGETHER", 1)  # only the bounds may end the search
        whole, quick = (
            ductile_verdict(basis, coefficients, endurance, strengths[1], every_point=every)
            for every in (True, False)
        )
    assert quick.safety == pytest.approx(whole.safety, rel=1e-12)
    assert (quick.critical, quick.criterion, quick.pair) == (
        whole.critical,
        whole.criterion,
        whole.pair,
    )
    assert (quick.highest_utilisation >= whole.utilisation * (1.0 - 1e-12)).all()


@COMMON
@given(SEED, STRENGTHS, st.floats(0.0, 3.0))
def test_no_point_is_worse_than_the_verdict_says(seed, strengths, static):
    """Every point by both criteria in full, against the verdict that skips what cannot govern."""
    basis, coefficients = history(seed, static=static)
    endurance, ultimate = strengths
    verdict = ductile_verdict(basis, coefficients, endurance, ultimate, every_point=False)
    worst = goodman(basis, coefficients, endurance, ultimate).utilisation
    for point in np.flatnonzero(~verdict.proportional):
        plane = critical_plane(basis[point] @ coefficients, FINDLEY.k).value
        worst[point] = max(worst[point], plane / (FINDLEY.limit_ratio * endurance))
    assert 1.0 / verdict.safety == pytest.approx(worst.max(), rel=SAME)
    assert verdict.critical == worst.argmax()
    assert (worst <= verdict.highest_utilisation * (1.0 + SAME)).all()


@pytest.mark.parametrize("every_point", [True, False])
def test_what_is_not_a_number_is_refused_with_its_place(every_point):
    basis, coefficients = history(3)
    for bad in (np.nan, np.inf, -np.inf):
        broken = coefficients.copy()
        broken[2, 17] = bad
        with pytest.raises(ValueError, match=r"not finite at position 17 \(1 of 90 positions\)"):
            ductile_verdict(basis, broken, 200.0, 400.0, every_point=every_point)
        broken = basis.copy()
        broken[5, 1, 1] = bad
        with pytest.raises(ValueError, match=r"not finite at point 5 \(1 of 12 points\)"):
            ductile_verdict(broken, coefficients, 200.0, 400.0, every_point=every_point)
    limits = np.where(np.arange(12) == 4, np.nan, 200.0)
    with pytest.raises(ValueError, match="endurance limit must be above 0 MPa, got nan at point 4"):
        ductile_verdict(basis, coefficients, limits, 400.0, every_point=every_point)
