"""The Goodman verdict on stress paths: closed forms, tendencies, and brute force."""

from itertools import combinations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fatigue.stress_path
from fatigue import FatigueResult, chord_path, goodman, goodman_utilisation
from fatigue.stress_path import principal_stresses

# The components of a sum of 25 products, and distances of them, are known to some hundred eps.
ROUND_OFF = 1e-12


def one_point(component, history):
    """A point under one stress component that follows the history."""
    basis = np.zeros((1, 6, 1))
    basis[0, component, 0] = 1.0
    return basis, np.asarray(history, dtype=float)[None, :]


def random_paths(seed, n_points=40, n_basis=7, n_positions=60):
    """Smooth closed paths that are far from proportional, with a static part."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0.0, 2.0 * np.pi, n_positions, endpoint=False)
    coefficients = rng.normal(size=(n_basis, 1)) + sum(
        rng.normal(size=(n_basis, 1)) * wave(k * angle) / k
        for k in (1, 2, 3)
        for wave in (np.cos, np.sin)
    )
    return 50.0 * rng.normal(size=(n_points, 6, n_basis)), coefficients


def von_mises_by_the_book(s):
    """The textbook formula, component by component, as an independent reference."""
    xx, yy, zz, xy, yz, zx = s
    return np.sqrt(
        0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy**2 + yz**2 + zx**2)
    )


def brute_force(basis, coefficients):
    """Amplitude and mean of one point by comparing all pairs of positions."""
    stress = basis @ coefficients
    n = stress.shape[1]
    chords = {
        (k, m): von_mises_by_the_book(stress[:, k] - stress[:, m])
        for k, m in combinations(range(n), 2)
    }
    longest = max(chords.values())
    means = []
    for (k, m), chord in chords.items():
        if chord >= longest * (1.0 - 1e-9):
            xx, yy, zz, xy, yz, zx = (stress[:, k] + stress[:, m]) / 2.0
            tensor = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]
            means.append(np.linalg.eigvalsh(tensor)[-1])
    return longest / 2.0, max(0.0, *means)


@pytest.mark.parametrize("component", [0, 1, 2])
def test_pulsating_tension_is_half_amplitude_and_half_mean(component):
    result = goodman(*one_point(component, [0.0, 50.0, 100.0, 20.0]), 200.0, 400.0)
    assert_allclose([result.amplitude[0], result.mean[0]], [50.0, 50.0], rtol=ROUND_OFF)
    assert result.safety == pytest.approx(1.0 / (50.0 / 200.0 + 50.0 / 400.0), rel=ROUND_OFF)
    assert result.pair.tolist() == [[0, 2]]


def test_alternating_tension_has_no_mean():
    result = goodman(*one_point(0, [-80.0, 10.0, 80.0]), 200.0, 400.0)
    assert_allclose([result.amplitude[0], result.mean[0]], [80.0, 0.0], atol=1e-10)
    assert result.safety == pytest.approx(2.5, rel=ROUND_OFF)


@pytest.mark.parametrize("component", [3, 4, 5])
def test_alternating_torsion_endures_the_limit_over_root_3(component):
    """Distortion energy: tau = Se/sqrt(3)."""
    tau = 200.0 / np.sqrt(3.0)
    result = goodman(*one_point(component, [tau, -tau]), 200.0, 400.0)
    assert result.safety == pytest.approx(1.0, rel=ROUND_OFF)


def test_static_torsion_is_a_mean_of_its_principal_stress():
    result = goodman(*one_point(3, [90.0, 110.0]), 200.0, 400.0)
    assert result.mean[0] == pytest.approx(100.0, rel=ROUND_OFF)


def test_the_leaf_of_the_power_hammer_has_its_reference_safety():
    """Independent closed form, rounded to seven digits: s from -87.34 to 158.1 MPa."""
    result = goodman(*one_point(0, [-87.34, 0.0, 158.1, 40.0]), 117.2, 430.0)
    assert result.safety == pytest.approx(0.8854431, abs=5e-8)


def test_repeated_axial_load_of_example_6_10():
    """Shigley 9th ed., example 6-10, modified Goodman; closed form 3.0211696, rounded."""
    result = goodman(*one_point(0, [0.0, 2 * 8.38]), 33.9, 100.0)
    assert result.safety == pytest.approx(3.0211696, abs=5e-8)


@pytest.mark.parametrize(
    ("mean", "reversed_amplitude"), [(0.0, 100.0), (50.0, 106.66667), (200.0, 133.33333)]
)
def test_the_equivalent_reversed_amplitude_is_goodman_s(mean, reversed_amplitude):
    """Su = 800, amplitude 100: a part that just endures s_a/(1 - s_m/Su) is just used up."""
    used = goodman_utilisation(100.0, mean, reversed_amplitude, 800.0)
    assert used == pytest.approx(1.0, abs=1e-7)


def test_compression_earns_no_credit():
    pulled = goodman(*one_point(0, [-50.0, 50.0]), 200.0, 400.0)
    pressed = goodman(*one_point(0, [-150.0, -50.0]), 200.0, 400.0)
    assert pressed.mean[0] == 0.0
    assert pressed.safety == pytest.approx(pulled.safety, rel=ROUND_OFF)


def test_a_negative_mean_counts_as_none():
    assert goodman_utilisation(50.0, -300.0, 200.0, 400.0) == 0.25


def test_a_mean_beyond_the_ultimate_strength_is_used_up_and_not_negative():
    for mean in (400.0, 4000.0):
        result = goodman(*one_point(0, [mean - 1.0, mean + 1.0]), 200.0, 400.0)
        assert result.utilisation[0] > 1.0
        assert 0.0 < result.safety < 1.0


def test_the_pair_names_positions_of_the_whole_cycle_although_dwells_are_left_out():
    result = goodman(*one_point(0, [0.0, 0.0, 0.0, 40.0, 40.0, -10.0, 100.0, 0.0]), 200.0, 400.0)
    assert result.pair.tolist() == [[5, 6]]


def test_one_position_has_no_amplitude():
    result = goodman(*one_point(0, [120.0]), 200.0, 400.0)
    assert (result.amplitude[0], result.pair.tolist()) == (0.0, [[0, 0]])
    assert result.safety == pytest.approx(400.0 / 120.0, rel=ROUND_OFF)


def test_a_stress_that_never_changes_has_no_amplitude_however_many_positions():
    basis, coefficients = random_paths(1)
    result = goodman(basis, np.repeat(coefficients[:, :1], 50, axis=1), 200.0, 400.0)
    assert result.amplitude.tolist() == [0.0] * len(basis)
    largest = principal_stresses(basis @ coefficients[:, 0])[:, 2]
    assert_allclose(result.mean, np.maximum(largest, 0.0), rtol=1e-9)


def test_an_unloaded_part_has_infinite_safety():
    result = goodman(np.zeros((3, 6, 2)), np.ones((2, 5)), 200.0, 400.0)
    assert result.safety == float("inf")


def test_pure_pressure_changes_have_a_mean_only():
    """A hydrostatic stress has no von Mises norm; its highest value is the mean."""
    basis = np.zeros((1, 6, 1))
    basis[0, :3, 0] = 1.0
    result = goodman(basis, np.array([[10.0, 90.0, -40.0]]), 200.0, 400.0)
    assert result.amplitude[0] == 0.0
    assert result.mean[0] == pytest.approx(90.0, rel=ROUND_OFF)


@pytest.mark.parametrize("seed", range(6))
def test_the_longest_chord_is_that_of_brute_force(seed):
    """Non-proportional paths; every point, so the critical one is never missed."""
    basis, coefficients = random_paths(seed)
    result = goodman(basis, coefficients, 200.0, 400.0)
    expected = np.array([brute_force(point, coefficients) for point in basis])
    assert_allclose(result.amplitude, expected[:, 0], rtol=ROUND_OFF)
    assert_allclose(result.mean, expected[:, 1], rtol=ROUND_OFF, atol=1e-9)
    used = expected[:, 0] / 200.0 + expected[:, 1] / 400.0
    assert result.critical == used.argmax()


@pytest.mark.parametrize("corners", [3, 4, 5, 8, 30])
def test_paths_on_which_few_positions_can_be_left_out_are_exact_too(corners):
    """Polygons in the plane of two shear stresses, at every size of the search."""
    turn = 2.0 * np.pi * np.arange(corners + 1) / corners
    corner = np.stack([np.cos(turn), np.sin(turn)])
    sides = [np.linspace(corner[:, i], corner[:, i + 1], 12) for i in range(corners)]
    basis = np.zeros((3, 6, 2))
    basis[:, 3, 0], basis[:, 4, 1] = 70.0, [70.0, 71.0, 7.0]
    coefficients = np.concatenate(sides).T
    result = goodman(basis, coefficients, 200.0, 400.0)
    expected = np.array([brute_force(point, coefficients) for point in basis])
    assert_allclose(result.amplitude, expected[:, 0], rtol=ROUND_OFF)
    assert_allclose(result.mean, expected[:, 1], rtol=ROUND_OFF, atol=1e-9)


def test_more_points_and_positions_than_one_block_change_nothing():
    basis, coefficients = random_paths(11, n_points=1200, n_positions=400)
    assert basis.shape[0] * 5 * 400 > 2 * fatigue.stress_path.BLOCK
    together = goodman(basis, coefficients, 200.0, 400.0)
    for point in (0, 199, 200, 201, 777, 1199):
        alone = goodman(basis[point : point + 1], coefficients, 200.0, 400.0)
        assert together.pair[point].tolist() == alone.pair[0].tolist()
        assert together.utilisation[point] == pytest.approx(alone.utilisation[0], rel=ROUND_OFF)


def test_pairs_compared_in_blocks_of_rows_give_the_same(monkeypatch):
    """A round path keeps all its positions, so the search is forced to split its rows."""
    turn = np.linspace(0.0, 2.0 * np.pi, 101)
    basis = np.zeros((2, 6, 3))
    basis[:, 3, 0], basis[:, 4, 1], basis[:, 0, 2] = 70.0, 70.0, 40.0
    coefficients = np.stack([np.cos(turn), np.sin(turn), np.cos(turn) ** 2])
    whole = goodman(basis, coefficients, 200.0, 400.0)
    monkeypatch.setattr("fatigue.stress_path._PAIRS", 700)
    split = goodman(basis, coefficients, 200.0, 400.0)
    assert split.pair.tolist() == whole.pair.tolist()
    assert split.utilisation.tolist() == pytest.approx(whole.utilisation.tolist(), rel=ROUND_OFF)


def test_turning_the_frame_changes_nothing():
    basis, coefficients = random_paths(3)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    index = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
    tensors = np.moveaxis(basis[:, index, :], 3, 1)
    turned = np.moveaxis(turn @ tensors @ turn.T, 1, 3)
    picked = [turned[:, i, j] for i, j in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]]
    before = goodman(basis, coefficients, 200.0, 400.0)
    after = goodman(np.stack(picked, axis=1), coefficients, 200.0, 400.0)
    assert_allclose(after.utilisation, before.utilisation, rtol=1e-11)


def test_the_order_of_the_positions_does_not_matter():
    basis, coefficients = random_paths(4)
    before = goodman(basis, coefficients, 200.0, 400.0)
    rng = np.random.default_rng(6)
    for order in (np.roll(np.arange(60), 17), np.arange(60)[::-1], rng.permutation(60)):
        after = goodman(basis, coefficients[:, order], 200.0, 400.0)
        assert_allclose(after.utilisation, before.utilisation, rtol=ROUND_OFF)
        assert np.sort(order[after.pair], axis=1).tolist() == before.pair.tolist()


@pytest.mark.parametrize("turn", range(4))
def test_of_equally_long_chords_under_different_pressure_the_higher_mean_decides(turn):
    """A hydrostatic stress does not lengthen a chord, so it tells two equal chords apart.

    Shear in xy reverses under a hydrostatic 0 MPa, then shear in yz under 100 MPa: two chords of
    2 * 50 sqrt(3), means 0 and 100 MPa. The sides of the square are shorter.
    """
    stress = np.zeros((6, 4))
    stress[3, :2] = [50.0, -50.0]
    stress[4, 2:] = [50.0, -50.0]
    stress[:3, 2:] = 100.0
    result = goodman(np.eye(6)[None], np.roll(stress, turn, axis=1), 200.0, 400.0)
    assert result.amplitude[0] == pytest.approx(50.0 * np.sqrt(3.0), rel=ROUND_OFF)
    assert result.mean[0] == pytest.approx(100.0, rel=ROUND_OFF)
    assert set(result.pair[0]) == {(2 + turn) % 4, (3 + turn) % 4}


def test_the_longest_chord_decides_even_where_a_shorter_one_is_used_more():
    """The stated definition: reversed shear of 2*100 sqrt(3) beside a pull of 0 to 340 MPa."""
    stress = np.zeros((6, 4))
    stress[3, :2] = [100.0, -100.0]
    stress[0, 3] = 340.0
    result = goodman(np.eye(6)[None], stress, 200.0, 400.0)
    shear_to_pull = von_mises_by_the_book(stress[:, 3] - stress[:, 0])
    assert result.amplitude[0] == pytest.approx(shear_to_pull / 2.0, rel=ROUND_OFF)
    assert shear_to_pull > 200.0 * np.sqrt(3.0) > 340.0


def test_double_the_load_halves_the_safety():
    basis, coefficients = random_paths(7)
    once = goodman(basis, coefficients, 200.0, 400.0)
    twice = goodman(basis, 2.0 * coefficients, 200.0, 400.0)
    assert twice.safety == pytest.approx(once.safety / 2.0, rel=ROUND_OFF)


def test_the_safety_is_proved_by_scaling_the_load_with_it():
    basis, coefficients = random_paths(8)
    safety = goodman(basis, coefficients, 200.0, 400.0).safety
    proof = goodman(basis, safety * coefficients, 200.0, 400.0)
    assert proof.safety == pytest.approx(1.0, rel=ROUND_OFF)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_no_size_of_load_is_lost_in_a_fixed_tolerance(scale):
    basis, coefficients = random_paths(9)
    before = goodman(basis, coefficients, 200.0, 400.0)
    after = goodman(basis, scale * coefficients, 200.0, 400.0)
    assert_allclose(after.utilisation, scale * before.utilisation, rtol=1e-11)


def test_a_small_amplitude_on_a_large_static_stress_keeps_its_digits():
    """1e-4 on 1000 MPa; the sum of both is stored to 1e-16 * 1000, 1e-9 of the amplitude."""
    basis = np.zeros((1, 6, 2))
    basis[0, 0] = 1.0
    coefficients = np.array([[1000.0] * 9, np.linspace(-1e-4, 1e-4, 9)])
    assert goodman(basis, coefficients, 1.0, 1e6).amplitude[0] == pytest.approx(1e-4, rel=5e-9)


def test_more_endurance_never_shortens_the_life_and_may_differ_by_point():
    basis, coefficients = random_paths(10)
    limits = np.linspace(100.0, 300.0, len(basis))
    result = goodman(basis, coefficients, limits, 400.0)
    assert_allclose(result.utilisation, result.amplitude / limits + result.mean / 400.0, rtol=1e-15)
    weaker = goodman(basis, coefficients, 100.0, 400.0)
    assert (weaker.utilisation >= result.utilisation).all()
    assert result.endurance_limit.tolist() == limits.tolist()


def test_the_result_carries_the_name_of_its_cycle():
    assert goodman(*one_point(0, [0.0, 1.0]), 200.0, 400.0, cycle="press").cycle == "press"


def test_the_input_is_left_alone():
    basis, coefficients = random_paths(12)
    copies = basis.copy(), coefficients.copy()
    goodman(basis, coefficients, 200.0, 400.0)
    assert (basis == copies[0]).all()
    assert (coefficients == copies[1]).all()


def critical_path(result, basis, coefficients):
    """Path of the critical point along its longest chord."""
    first, second = result.pair[result.critical]
    return chord_path(basis[result.critical], coefficients, (int(first), int(second)))


@pytest.mark.parametrize(
    "history", [[-30.0, 10.0, 90.0], [90.0, 10.0, -30.0], [-90.0, -10.0, -40.0], [5.0, 5.0]]
)
def test_along_its_chord_a_uniaxial_stress_is_itself(history):
    basis, coefficients = one_point(1, history)
    result = goodman(basis, coefficients, 200.0, 400.0)
    path = critical_path(result, basis, coefficients)
    assert_allclose(path.along, history, rtol=ROUND_OFF)


def test_the_chord_path_spans_the_amplitude_and_repeats_the_verdict():
    basis, coefficients = random_paths(13)
    result = goodman(basis, coefficients, 200.0, 400.0)
    for point, pair in enumerate(result.pair):
        path = chord_path(basis[point], coefficients, tuple(pair))
        assert np.ptp(path.along) == pytest.approx(2.0 * result.amplitude[point], rel=1e-10)
        assert path.amplitude == pytest.approx(result.amplitude[point], rel=1e-10)
        assert path.mean == pytest.approx(result.mean[point], rel=1e-10, abs=1e-9)
    critical = critical_path(result, basis, coefficients)
    assert critical.amplitude == pytest.approx(result.amplitude[result.critical], rel=1e-10)


@pytest.mark.parametrize("history", [[-10.0, 30.0, 20.0], [30.0, 20.0, -10.0]])
def test_torsion_along_its_chord_has_both_signs_and_its_mean_up(history):
    basis, coefficients = one_point(3, history)
    path = critical_path(goodman(basis, coefficients, 200.0, 400.0), basis, coefficients)
    assert_allclose(path.along, np.sqrt(3.0) * np.array(history), rtol=ROUND_OFF)


def test_a_point_that_is_not_finite_is_named():
    basis, coefficients = random_paths(14)
    basis[23, 4, 1] = np.nan
    with pytest.raises(ValueError, match=r"not finite at point 23 \(1 of 40 points\)"):
        goodman(basis, coefficients, 200.0, 400.0)


def test_a_position_that_is_not_finite_is_named():
    basis, coefficients = random_paths(15)
    coefficients[2, 31] = np.inf
    with pytest.raises(ValueError, match="not finite at position 31"):
        goodman(basis, coefficients, 200.0, 400.0)


@pytest.mark.parametrize("bad", [0.0, -117.2, np.nan, np.inf])
def test_impossible_strengths_are_refused(bad):
    history = one_point(0, [0.0, 1.0])
    with pytest.raises(ValueError, match="endurance limit must be above 0 MPa"):
        goodman(*history, bad, 430.0)
    with pytest.raises(ValueError, match="ultimate strength must be above 0 MPa"):
        goodman(*history, 117.2, bad)


def test_an_impossible_endurance_limit_is_named_by_its_point():
    basis, coefficients = random_paths(16)
    limits = np.full(40, 200.0)
    limits[7] = -1.0
    with pytest.raises(ValueError, match="above 0 MPa, got -1 at point 7"):
        goodman(basis, coefficients, limits, 400.0)


@pytest.mark.parametrize(
    ("basis", "coefficients", "words"),
    [
        ((4, 5, 2), (2, 3), "needs a basis"),
        ((4, 6, 2), (3, 3), "2 unit loads, the coefficients 3"),
        ((0, 6, 2), (2, 3), "at least one point"),
        ((4, 6, 2), (2, 0), "at least one point and one position"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(basis, coefficients, words):
    with pytest.raises(ValueError, match=words):
        goodman(np.ones(basis), np.ones(coefficients), 200.0, 400.0)


def test_endurance_limits_for_other_points_are_refused():
    with pytest.raises(ValueError, match=r"one per point, \(1,\), got \(2,\)"):
        goodman(*one_point(0, [0.0, 1.0]), [200.0, 200.0], 400.0)


def test_a_result_of_unequal_lengths_is_refused():
    one, two = np.ones(1), np.ones(2)
    with pytest.raises(ValueError, match="fatigue of 1 points"):
        FatigueResult("press", one, two, np.zeros((1, 2), dtype=np.intp), one, 1.0, one)
