"""The bound of an error over paths of weights, and the corners that prove it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.result import live_fields
from checks.result.live_fields import largest_principal, principal_range, von_mises
from reports.live.accuracy import (
    LENGTH_METRIC,
    STRESS_METRIC,
    corners,
    error_bound,
    largest_sizes,
)
from reports.live.combine import NOTHING, combine
from reports.live.extremes import displacements, largest_size
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


def test_what_hardly_acts_is_kept_unless_it_is_below_what_may_be_left_out():
    """Of the cycle's size: the third load makes 1e-6 of it, the fourth 1e-12."""
    nodes, _ = torus(24, 12)
    fields = smooth(nodes, 4)
    path = turning(4, 80) * np.array([1.0, 1.0, 1e-7, 1e-12])[:, None]
    done = combine(fields, {"a": path}, {"a": 1.0}, STRESS_METRIC)
    assert len(done.fields) == 3
    off = np.einsum("jnc,jk->knc", fields, path)
    off -= np.einsum("jnc,jk->knc", done.fields, done.weights["a"])
    assert von_mises(off).max() <= NOTHING


def test_the_peak_of_every_cycle_is_looked_at():
    surface = torus(12, 8)
    fields = live(smooth(surface[0], 3), {"a": turning(3, 997), "b": turning(3, 499, 5)}, surface)
    sample = looked_at(fields)
    for name, peaks in fields.peaks.items():
        at = sample.positions[name].tolist()
        assert int(peaks.argmax()) in at
        assert sample.mises[name][:, at.index(int(peaks.argmax()))].max() == pytest.approx(
            sample.peaks[name], rel=1e-6
        )


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
    looked, highest = [], live_fields._highest

    def counted(rows):
        looked.append(len(rows))
        return highest(rows)

    monkeypatch.setattr(live_fields, "_highest", counted)
    most = largest_size(fields, looked_at(fields), {"work": np.arange(400)})
    assert most == pytest.approx(100.0, rel=1e-4)
    assert sum(looked) < 3 * 3600, "of 1 440 000 nodes at positions"


@pytest.mark.parametrize("most", [3, 10])
def test_the_bound_of_a_principal_stress_holds_between_corners_of_a_hydrostatic_error(errors, most):
    """It has no von Mises stress at all: the mean must be followed between the corners, too."""
    even = np.repeat(errors[:, :, :1], 3, axis=2)
    pushed = np.concatenate([even, np.zeros_like(even)], axis=2)
    path = turning(5, 361)
    bound = error_bound(pushed, corners([path], most), STRESS_METRIC)
    low, high = principal_range(np.einsum("jnc,jk->knc", pushed, path))
    assert max(-low, high) <= bound.principal
    assert bound.norm < 1e-3 * bound.principal


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_principal_stress_is_found_where_the_mean_stress_is_small(sign):
    """A pull of 80 MPa from all sides is looked at first; 100 MPa along a bar is more."""
    surface = torus(12, 8)
    fields = np.zeros((2, len(surface[0]), 6))
    fields[0, 5, :3] = 80.0, 79.0, 79.0
    fields[1, 40, 0] = 100.0
    pulled = live(fields, {"work": sign * np.eye(2)}, surface)
    assert largest_size(pulled, looked_at(pulled), {"work": np.arange(2)}) == pytest.approx(100.0)


def test_the_largest_push_is_found_where_another_node_is_pulled_at_the_same_position():
    surface = torus(12, 8)
    fields = np.zeros((2, len(surface[0]), 6))
    fields[0, 5, :3] = 60.0, 59.0, 59.0
    fields[1, 40, :3] = -100.0, -99.0, -99.0
    fields[1, 7, :3] = 10.0, 9.0, 9.0
    pushed = live(fields, {"work": np.eye(2)}, surface)
    assert largest_size(pushed, looked_at(pushed), {"work": np.arange(2)}) == pytest.approx(100.0)


def test_no_size_of_a_principal_stress_at_any_node_and_position_is_above_the_largest():
    surface = torus(16, 10)
    for seed in range(12):
        random = np.random.default_rng(seed)
        fields = smooth(surface[0], 3, seed) * random.uniform(0.1, 3, size=(3, 1, 6))
        fields[:, :, :3] += random.normal(size=(3, 1, 1)) * smooth(surface[0], 3, seed + 50, 1) * 3
        made = live(fields, {"work": turning(3, 40, seed)}, surface)
        kept = np.arange(0, 40, 2)
        low, high = principal_range(np.stack([made.at("work", k) for k in kept.tolist()]))
        most = largest_size(made, looked_at(made), {"work": kept})
        assert most == pytest.approx(max(-low, high), rel=1e-9)


def test_single_precision_of_unit_loads_that_cancel_hides_no_largest_principal_stress():
    """Of 2^23 + 100 MPa along a bar the mean stress is a third of 1 MPa off, 2^23 being one unit.

    The bound of that node, 99.67 MPa, would be below what is known from another position.
    """
    surface = torus(12, 8)
    fields = np.zeros((3, len(surface[0]), 6))
    fields[0, 5, :3] = 99.8, 99.75, 99.75
    fields[1:, :, :3] = 2.0**23
    fields[1, 40, 0] += 100.0
    made = live(fields, {"work": np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])}, surface)
    most = largest_size(made, looked_at(made), {"work": np.arange(2)})
    assert most == pytest.approx(100.0, rel=1e-9)


def test_single_precision_of_unit_loads_that_cancel_hides_no_largest_displacement():
    surface = torus(12, 8)
    moved = np.zeros((2, len(surface[0]), 3))
    moved[:, :, 0] = 5000011.0
    moved[0, 40, 0] += 1.0
    share = np.linspace(0.9, 1.0, 41) / 7
    made = live(
        np.ones((2, len(surface[0]), 6)) * np.arange(1, 7),
        {"work": np.stack([share, -share])}, surface, displacement=moved,
    )  # fmt: skip
    found = displacements(made, {"work": np.arange(41)})
    assert found["work"] == pytest.approx(share.max(), rel=1e-9)
