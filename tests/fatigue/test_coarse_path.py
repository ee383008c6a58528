"""Positions kept of a path answer for all of it, on every plane, to within their slack."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fatigue import ductile_verdict
from fatigue.shear_planes import critical_plane, findley_criterion
from fatigue.stress_path import with_fewer_loads
from fatigue.verdict import coarse_path

K = findley_criterion().k


def winding(seed: int, n: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Paths of five points that wind smoothly through all six components."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * np.pi, n)
    waves = [f(m * angle) / m**2 for m in range(1, 6) for f in (np.cos, np.sin)]
    return rng.normal(size=(5, 6, 10)), np.array(waves)


@pytest.mark.parametrize("seed", range(4))
def test_no_plane_of_the_whole_path_exceeds_the_kept_positions_and_their_slack(seed):
    basis, coefficients = winding(seed)
    coarse = coarse_path(basis, coefficients, K)
    assert len(coarse.kept) < 50
    beyond = []
    for point, slack in enumerate(coarse.slack):
        path = basis[point] @ coefficients
        few = critical_plane(path[:, coarse.kept], K)
        whole = critical_plane(path, K)
        assert whole.value <= few.bound + slack
        beyond.append(whole.value - few.value)
    assert max(beyond) > 0  # without the slack it would not be a bound


def test_a_spike_of_one_position_at_one_point_is_in_the_slack():
    """One point of many sees a unit load that acts at one position: it is kept, or told."""
    basis, coefficients = winding(0)
    spike = np.zeros((5, 6, 1))
    spike[3, 0] = 1e-3
    basis = np.concatenate([basis, spike], axis=2)
    coefficients = np.vstack([coefficients, np.zeros(300)])
    coefficients[-1, 137] = 5000.0
    coarse = coarse_path(basis, coefficients, K)
    path = basis[3] @ coefficients
    few = critical_plane(path[:, coarse.kept], K)
    assert critical_plane(path, K).value <= few.bound + coarse.slack[3]


def test_of_a_straight_path_its_ends_are_kept_and_nothing_is_missed():
    basis = np.arange(12.0).reshape(2, 6, 1)
    coefficients = np.sin(np.linspace(0, 2 * np.pi, 201))[None]
    coarse = coarse_path(basis, coefficients, K)
    assert {50, 150} <= set(coarse.kept.tolist())
    assert len(coarse.kept) <= 4
    assert_allclose(coarse.slack, 0.0, atol=1e-12 * 12)


def test_the_worst_point_is_that_of_a_search_of_every_plane():
    """Many points whose paths turn: Findley decides, and coarse paths pass no worse point by."""
    rng = np.random.default_rng(5)
    _, coefficients = winding(0)
    basis = rng.normal(size=(60, 6, 10)) * np.linspace(0.9, 1.0, 60)[:, None, None]
    verdict = ductile_verdict(basis, coefficients, 200.0, 600.0, every_point=False)
    limit = findley_criterion().limit_ratio * 200.0
    planes = [critical_plane(b @ coefficients, K).value / limit for b in basis]
    assert verdict.criterion == "Findley"
    assert verdict.critical == int(np.argmax(planes))
    assert verdict.utilisation.max() == max(planes)
    assert (verdict.highest_utilisation >= np.array(planes) * (1 - 1e-9)).all()


def test_loads_that_act_in_step_are_one_load():
    """Ten unit loads of three histories: three are left, and the stress is the same."""
    rng = np.random.default_rng(1)
    basis = rng.normal(size=(1200, 6, 10)) * 10.0 ** np.arange(-5, 5)
    three = rng.normal(size=(3, 400))
    coefficients = rng.normal(size=(10, 3)) @ three / 10.0 ** np.arange(-5, 5)[:, None]
    fewer, their = with_fewer_loads(basis, coefficients)
    assert fewer.shape == (1200, 6, 3)
    stress = basis @ coefficients
    assert_allclose(fewer @ their, stress, rtol=0, atol=1e-12 * np.abs(stress).max())
    same, _ = with_fewer_loads(basis[:300], coefficients)
    assert same.shape == (300, 6, 10)
