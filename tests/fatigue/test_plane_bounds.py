"""Bounds of many paths at once are those of the search of each: proven, and as low as a floor."""

import numpy as np
import pytest

from fatigue.shear_planes import critical_plane, findley_criterion
from fatigue.verdict import plane_bounds

K = findley_criterion().k


@pytest.fixture(scope="module")
def paths() -> np.ndarray:
    """Forty paths of thirty positions: round ones, flat ones, and pressure alone."""
    rng = np.random.default_rng(3)
    paths = rng.normal(size=(40, 6, 30)) * 100.0
    paths[10:20, 3:] = 0.0
    paths[20:30] *= np.linspace(1.0, 1e-3, 6)[:, None]
    paths[30] = np.repeat([[1.0]] * 3 + [[0.0]] * 3, 30, axis=1) * rng.normal(size=30) * 50.0
    return paths


@pytest.fixture(scope="module")
def worst(paths) -> np.ndarray:
    """Parameter of the worst plane of each path."""
    return np.array([critical_plane(path, K).value for path in paths])


@pytest.mark.parametrize("more", [1.02, 1.1, 1.5])
def test_a_bound_is_above_the_worst_plane_and_not_above_the_floor(paths, worst, more):
    floors = more * worst
    bounds = plane_bounds(paths, K, floors)
    told = np.isfinite(bounds)
    assert (bounds[told] >= worst[told] * (1 - 1e-9)).all()
    assert (bounds[told] <= floors[told]).all()
    if more >= 1.5:
        assert told.all()


def test_a_path_that_reaches_its_floor_is_left_to_the_search(paths, worst):
    assert np.isinf(plane_bounds(paths, K, 0.999 * worst)).all()


def test_one_path_has_the_same_bound_alone(paths, worst):
    """Paths that are looked at together do not know of each other."""
    together = plane_bounds(paths, K, 1.1 * worst)
    alone = [plane_bounds(paths[[k]], K, 1.1 * worst[[k]])[0] for k in range(len(paths))]
    np.testing.assert_allclose(together, alone, rtol=1e-12)
