"""Sums of fields with fewer fields, their extremes, and the positions that a page carries."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.result import live_fields
from checks.result.live_fields import largest_principal, von_mises
from reports.live.encode import encode
from reports.live.fitting import (
    FLOOR,
    LENGTH_METRIC,
    NOTHING,
    STRESS_METRIC,
    fewest,
    largest_anywhere,
    largest_principal_stress,
    largest_sizes,
    lost_in_single,
    sizes_with_floor,
    thinned,
)

from .surfaces import live, principal_range, smooth, torus, turning


def largest_of(fields):
    """The largest size of a principal stress of fields, MPa."""
    lost = lost_in_single(fields.stress, fields.coefficients, STRESS_METRIC)
    return largest_principal_stress(fields, lost)


@pytest.fixture(scope="module")
def errors():
    return np.random.default_rng(0).uniform(-1, 1, size=(5, 300, 6))


def test_the_von_mises_metric_is_the_von_mises_stress(errors):
    rows = errors[0] @ STRESS_METRIC.T
    assert_allclose(np.sqrt((rows[:, :5] ** 2).sum(axis=1)), von_mises(errors[0]))
    assert_allclose(rows[:, 5], errors[0, :, :3].mean(axis=1))


def test_largest_sizes_hold_at_every_position_and_between_them(errors):
    path = turning(5, 361)
    found = largest_sizes(errors, path, STRESS_METRIC)
    sums = np.einsum("jnc,jk->knc", errors, path)
    assert_allclose(found[0], von_mises(sums).max(axis=1), rtol=1e-5)
    for k in range(0, 361, 20):
        low, high = principal_range(sums[k])
        assert max(-low, high) <= found[1, k] * (1 + 1e-6)
        assert found[1, k] <= 1.4 * max(-low, high)
    between = np.stack([np.interp(np.arange(360) + 0.5, np.arange(361), row) for row in path])
    half = largest_sizes(errors, between, STRESS_METRIC)
    assert (half <= np.maximum(found[:, 1:], found[:, :-1]) * (1 + 1e-6)).all()


@pytest.mark.parametrize("metric", [STRESS_METRIC, LENGTH_METRIC], ids=["stress", "length"])
@pytest.mark.parametrize("falling", [0.0, 1.0, 6.0])
def test_the_largest_anywhere_is_that_of_all_nodes_and_positions(falling, metric):
    """Of fields that are alike at all nodes, or much smaller at most; paths are smooth or noise."""
    chance = np.random.default_rng(7)
    fields = chance.normal(size=(9, 700, len(metric)))
    fields *= np.exp(-falling * chance.uniform(size=(700, 1)))
    for path in (turning(9, 500), chance.normal(size=(9, 500)), np.zeros((9, 500))):
        found = largest_anywhere(fields, path, metric)
        assert_allclose(found, largest_sizes(fields, path, metric).max(axis=1), rtol=1e-6)


def test_largest_lengths_are_those_of_the_sums(errors):
    path = turning(5, 100)
    found = largest_sizes(errors[:, :, :3], path, LENGTH_METRIC)
    lengths = np.linalg.norm(np.einsum("jnc,jk->knc", errors[:, :, :3], path), axis=2)
    assert_allclose(found[0], lengths.max(axis=1), rtol=1e-5)
    assert not found[1].any()


def test_thinned_positions_keep_ends_what_is_wanted_and_the_bends():
    path = np.interp(np.arange(5000), [0, 700, 705, 710, 4999], [0.0, 0.0, 9.0, 0.0, 1.0])[None]
    kept = thinned(path, [123, 4567], 300)
    assert {0, 123, 700, 705, 710, 4567, 4999} <= set(kept.tolist())
    assert (np.diff(kept) > 0).all()
    assert np.diff(kept).max() <= 68  # 4999 / 74
    assert len(kept) <= 300
    assert_allclose(np.interp(np.arange(5000), kept, path[0, kept]), path[0], atol=1e-12)
    assert thinned(path, [], 5000).tolist() == list(range(5000))


def test_the_fewest_fields_have_the_same_sums_and_are_orthogonal():
    nodes, _ = torus(24, 12)
    fields, c = (
        smooth(nodes, 7),
        {"a": turning(7, 80), "b": 3 * turning(7, 40, seed=4), "c": np.zeros((7, 9))},
    )
    done = fewest(fields, c)
    assert len(done.fields) == 7
    products = np.einsum("inc,jnc->ij", done.fields, done.fields)
    assert_allclose(products, np.diag(np.diag(products)), rtol=0, atol=1e-9 * products.max())
    for name in "abc":
        exact = np.einsum("jnc,jk->knc", fields, c[name])
        again = np.einsum("jnc,jk->knc", done.fields, done.weights[name])
        assert_allclose(again, exact, rtol=0, atol=1e-6 * max(np.abs(exact).max(), 1e-300))


def test_loads_that_cancel_are_one_small_field():
    """Their difference is a millionth of each: it is what acts."""
    nodes, _ = torus(24, 12)
    first, second = smooth(nodes, 1)[0], smooth(nodes, 1, seed=3)[0]
    turn = 1e6 * turning(1, 30)
    c = np.concatenate([-turn, turn])
    done = fewest(np.stack([first, first + 1e-6 * second]), {"a": c})
    assert len(done.fields) == 1
    again = np.einsum("jnc,jk->knc", done.fields, done.weights["a"])
    exact = 1e-6 * turn[0][:, None, None] * second
    assert_allclose(again, exact, rtol=0, atol=1e-8 * np.abs(exact).max())


def test_what_hardly_acts_is_kept_unless_it_is_below_what_may_be_left_out():
    """Of the cycle's size: the third load makes 1e-5 of it, the fourth 1e-12."""
    nodes, _ = torus(24, 12)
    fields = smooth(nodes, 4)
    path = turning(4, 80) * np.array([1.0, 1.0, 1e-5, 1e-12])[:, None]
    done = fewest(fields, {"a": path}, {"a": 1.0})
    assert len(done.fields) == 3
    off = np.einsum("jnc,jk->knc", fields, path)
    off -= np.einsum("jnc,jk->knc", done.fields, done.weights["a"])
    assert von_mises(off).max() <= NOTHING


@pytest.mark.parametrize("seed", range(4))
def test_fields_that_are_left_out_make_less_than_may_be_left_out(seed):
    """Ten loads, each a tenth of the one before, in a large cycle and in a small one."""
    nodes, _ = torus(24, 12)
    fields = smooth(nodes, 10, seed)
    graded = 10.0 ** -np.arange(10.0)[:, None]
    paths = {"a": 1e3 * graded * turning(10, 80, seed), "b": graded * turning(10, 40, seed + 9)}
    done = fewest(fields, paths)
    assert 5 <= len(done.fields) < 10
    for name, path in paths.items():
        exact = np.einsum("jnc,jk->knc", fields, path)
        off = exact - np.einsum("jnc,jk->knc", done.fields, done.weights[name])
        size = np.sqrt((exact**2).mean(axis=(1, 2))).max()
        assert np.linalg.norm(off, axis=2).max() <= NOTHING * size


def test_loads_in_proportion_become_one_field_and_idle_ones_none():
    nodes, _ = torus(24, 12)
    alike = turning(1, 50)
    c = np.concatenate([alike, -2 * alike, 5 * alike, 0 * alike])
    done = fewest(smooth(nodes, 4), {"a": c})
    assert len(done.fields) == 1
    nothing = fewest(np.zeros((4, len(nodes), 6)), {"a": c})
    assert nothing.fields.shape == (0, len(nodes), 6)
    assert nothing.weights["a"].shape == (0, 50)


def test_small_cycles_are_as_exact_as_large_ones_down_to_a_floor():
    sizes = sizes_with_floor({"a": 100.0, "b": 1.0, "c": 1e-9, "d": 0.0})
    assert sizes == {"a": 100.0, "b": 1.0, "c": FLOOR * 100.0, "d": 0.0}


def test_the_largest_size_of_a_principal_stress_is_exact():
    stress = np.random.default_rng(2).normal(size=(4000, 6))
    tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    values = np.linalg.eigvalsh(tensor)
    most = max(-values.min(), values.max())
    assert largest_principal(stress) == most
    assert largest_principal(-stress) == most
    assert largest_principal(np.zeros((300, 6))) == 0.0
    assert largest_principal(stress, 0.99 * most) == most
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
    most = largest_of(fields)
    assert most == pytest.approx(100.0, rel=1e-4)
    assert sum(looked) < 3 * 3600, "of 1 440 000 nodes at positions"


def test_the_bound_of_a_principal_stress_holds_for_a_hydrostatic_error(errors):
    """It has no von Mises stress at all: the mean must be counted, too."""
    even = np.repeat(errors[:, :, :1], 3, axis=2)
    pushed = np.concatenate([even, np.zeros_like(even)], axis=2)
    path = turning(5, 361)
    norm, principal = largest_sizes(pushed, path, STRESS_METRIC).max(axis=1)
    low, high = principal_range(np.einsum("jnc,jk->knc", pushed, path))
    assert principal == pytest.approx(max(-low, high), rel=1e-5)
    assert norm < 1e-3 * principal


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_principal_stress_is_found_where_the_mean_stress_is_small(sign):
    """A pull of 80 MPa from all sides is looked at first; 100 MPa along a bar is more."""
    surface = torus(12, 8)
    fields = np.zeros((2, len(surface[0]), 6))
    fields[0, 5, :3] = 80.0, 79.0, 79.0
    fields[1, 40, 0] = 100.0
    pulled = live(fields, {"work": sign * np.eye(2)}, surface)
    assert largest_of(pulled) == pytest.approx(100.0)


def test_the_largest_push_is_found_where_another_node_is_pulled_at_the_same_position():
    surface = torus(12, 8)
    fields = np.zeros((2, len(surface[0]), 6))
    fields[0, 5, :3] = 60.0, 59.0, 59.0
    fields[1, 40, :3] = -100.0, -99.0, -99.0
    fields[1, 7, :3] = 10.0, 9.0, 9.0
    pushed = live(fields, {"work": np.eye(2)}, surface)
    assert largest_of(pushed) == pytest.approx(100.0)


def test_no_size_of_a_principal_stress_at_any_node_and_position_is_above_the_largest():
    surface = torus(16, 10)
    for seed in range(12):
        random = np.random.default_rng(seed)
        fields = smooth(surface[0], 3, seed) * random.uniform(0.1, 3, size=(3, 1, 6))
        fields[:, :, :3] += random.normal(size=(3, 1, 1)) * smooth(surface[0], 3, seed + 50, 1) * 3
        made = live(fields, {"work": turning(3, 40, seed)}, surface)
        low, high = principal_range(np.stack([made.at("work", k) for k in range(40)]))
        most = largest_of(made)
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
    most = largest_of(made)
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
    scale = encode(made, ["work"]).head["scale"]
    assert scale["displacement"]["to"] == pytest.approx(share.max(), rel=1e-6)
