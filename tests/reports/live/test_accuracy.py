"""The bound of an error over paths of weights, and the corners that prove it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import reports.live.fields
from reports.live.accuracy import (
    LENGTH_METRIC,
    STRESS_METRIC,
    corners,
    error_bound,
    largest_sizes,
)
from reports.live.combine import combine
from reports.live.extremes import largest_size
from reports.live.fields import largest_principal, principal_range, von_mises
from reports.live.fitting import FLOOR, sizes_with_floor
from reports.live.sampling import looked_at

from .surfaces import live, smooth, torus, turning


@pytest.fixture(scope="module")
def errors():
    return np.random.default_rng(0).uniform(-1, 1, size=(5, 300, 6))


def test_the_von_mises_metric_is_the_von_mises_stress(errors):
    rows = errors[0] @ STRESS_METRIC.T
    assert_allclose(np.sqrt((rows[:, :5] ** 2).sum(axis=1)), von_mises(errors[0]))
    assert_allclose(rows[:, 5], errors[0, :, :3].mean(axis=1))


@pytest.mark.parametrize("most", [3, 10, 60, 400])
def test_the_bound_holds_for_every_position_and_between_them(errors, most):
    path = turning(5, 361)
    bound = error_bound(errors, corners([path], most), STRESS_METRIC)
    fine = np.stack([np.interp(np.arange(0, 360, 0.25), np.arange(361), row) for row in path])
    sums = np.einsum("jnc,jk->knc", errors, fine)
    true = von_mises(sums).max()
    low, high = principal_range(sums)
    assert true <= bound.norm
    assert max(-low, high) <= bound.principal
    if most >= 60:
        assert bound.norm <= 1.15 * true
        assert bound.principal <= 1.4 * max(-low, high)


def test_the_bound_of_a_length_holds(errors):
    path = turning(5, 100)
    bound = error_bound(errors[:, :, :3], corners([path], 40), LENGTH_METRIC)
    lengths = np.linalg.norm(np.einsum("jnc,jk->knc", errors[:, :, :3], path), axis=2)
    assert lengths.max() <= bound.norm <= 1.15 * lengths.max()
    assert bound.principal == 0.0


def test_corners_keep_ends_and_what_is_wanted_and_tell_how_far_the_path_leaves_them():
    path = turning(3, 500)
    chosen = corners([path, path[:, :1]], 30, wanted=[[123], []])
    kept, single = chosen.kept
    assert {0, 123, 499} <= set(kept.tolist())
    assert single.tolist() == [0]
    assert len(kept) + len(single) == 30
    line = np.stack([np.interp(np.arange(500), kept, row[kept]) for row in path])
    away = np.linalg.norm(path - line, axis=0).max()
    assert_allclose(chosen.distance, away, rtol=1e-12)
    assert corners([path], 500).distance == 0.0
    few = corners([path], 500, tolerance=0.05)
    assert len(few.kept[0]) < 200
    assert few.distance <= 0.05


def test_largest_size_is_not_below_any_sum_of_weights_of_length_one(errors):
    weights = np.random.default_rng(1).normal(size=(5, 1000))
    weights /= np.linalg.norm(weights, axis=0)
    true = von_mises(np.einsum("jnc,jk->knc", errors, weights)).max()
    sums = np.einsum("jnc,jk->knc", errors, weights)
    low, high = principal_range(sums)
    bound, plain = largest_sizes(errors, STRESS_METRIC)
    assert true <= bound.norm
    assert max(-low, high) <= bound.principal
    assert np.linalg.norm(sums, axis=2).max() <= plain


def test_combined_fields_have_the_same_sums_and_weights_in_the_unit_ball():
    nodes, _ = torus(24, 12)
    fields, c = (
        smooth(nodes, 7),
        {"a": turning(7, 80), "b": 3 * turning(7, 40, seed=4), "c": np.zeros((7, 9))},
    )
    sizes = {"a": 50.0, "b": 80.0, "c": 0.0}
    done = combine(fields, c, sizes, STRESS_METRIC)
    lengths = np.concatenate([np.linalg.norm(done.weights[q], axis=0) for q in "ab"])
    assert lengths.max() <= 1 + 1e-12
    assert (lengths > 0.9).sum() >= 7  # the ball is no larger than it must be
    for name in "abc":
        exact = np.einsum("jnc,jk->knc", fields, c[name])
        again = sizes[name] * np.einsum("jnc,jk->knc", done.fields, done.weights[name])
        assert_allclose(again, exact, rtol=0, atol=1e-6 * max(sizes[name], 1e-300))


def test_loads_in_proportion_become_one_field_and_idle_ones_none():
    nodes, _ = torus(24, 12)
    alike = turning(1, 50)
    c = np.concatenate([alike, -2 * alike, 5 * alike, 0 * alike])
    done = combine(smooth(nodes, 4), {"a": c}, {"a": 1.0}, STRESS_METRIC)
    assert len(done.fields) == 1
    nothing = combine(np.zeros((4, len(nodes), 6)), {"a": c}, {"a": 1.0}, STRESS_METRIC)
    assert nothing.fields.shape == (0, len(nodes), 6)
    assert nothing.weights["a"].shape == (0, 50)


def test_small_cycles_are_as_exact_as_large_ones_down_to_a_floor():
    sizes = sizes_with_floor({"a": 100.0, "b": 1.0, "c": 1e-9, "d": 0.0})
    assert sizes == {"a": 100.0, "b": 1.0, "c": FLOOR * 100.0, "d": 0.0}


def test_the_range_of_principal_stresses_is_exact():
    stress = np.random.default_rng(2).normal(size=(4000, 6))
    tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    values = np.linalg.eigvalsh(tensor)
    assert principal_range(stress) == (values.min(), values.max())
    assert principal_range(np.zeros((300, 6))) == (0.0, 0.0)
    assert largest_principal(stress, 0.99 * values.max()) == values.max()
    assert largest_principal(stress, 1e3) == 1e3


def test_a_bar_that_is_pushed_all_over_is_not_searched_for_the_pull_that_it_lacks(monkeypatch):
    """The bound on its pull, a third of its push, is loose at every node and position."""
    surface = torus(60, 60)
    pushed = np.zeros((2, 3600, 6))
    pushed[0, :, 0] = -np.linspace(99.0, 100.0, 3600)
    pushed[1, :, 1] = 1e-3
    angle = np.linspace(0.0, np.pi, 400)
    fields = live(pushed, {"work": np.stack([np.sin(angle), angle])}, surface)
    looked, highest = [], reports.live.fields._highest

    def counted(rows):
        looked.append(len(rows))
        return highest(rows)

    monkeypatch.setattr(reports.live.fields, "_highest", counted)
    most = largest_size(fields, looked_at(fields), {"work": np.arange(400)})
    assert most == pytest.approx(100.0, rel=1e-4)
    assert sum(looked) < 3 * 3600, "of 1 440 000 nodes at positions"
