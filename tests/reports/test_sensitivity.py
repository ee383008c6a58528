"""Shares of variance from samples that are there, against closed forms."""

import numpy as np
import pytest
from scipy.stats import qmc

from reports.index_page import FEWEST, first_order


def samples(count, inputs):
    return qmc.Sobol(inputs, seed=0).random(count)


def test_ishigami_s_function_has_its_known_indices():
    """y = sin a + 7 sin^2 b + 0.1 c^4 sin a over +-pi; its variances in closed form."""
    a, b, c = (2 * samples(4096, 3).T - 1) * np.pi
    found = first_order(
        {"a": a, "b": b, "c": c}, np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    )
    of_b = 49 / 8
    of_a = 0.1 * np.pi**4 / 5 + 0.01 * np.pi**8 / 50 + 0.5
    whole = of_b + of_a + 0.01 * np.pi**8 * (1 / 18 - 1 / 50)
    assert found["a"] == pytest.approx(of_a / whole, rel=0.02)
    assert found["b"] == pytest.approx(of_b / whole, rel=0.02)
    assert found["c"] < 0.002


def test_words_and_a_grid_of_few_values_are_grouped():
    """y = 3 x + z with x in {0, 1, 2} and z in {-1, 1}: variances 9 * 2/3 and 1."""
    x, z = (grid.ravel() for grid in np.meshgrid(np.tile(np.arange(3.0), 20), [-1.0, 1.0]))
    found = first_order({"x": x, "z": [f"{value}" for value in z]}, 3 * x + z)
    assert found == pytest.approx({"x": 6 / 7, "z": 1 / 7}, abs=0.02)


def test_an_input_without_a_say_has_no_share_though_scatter_fills_every_coefficient():
    x, y = samples(128, 2).T
    found = first_order({"x": x, "y": y}, x)
    assert found["x"] == pytest.approx(1.0, abs=0.01)
    assert found["y"] < 0.05


def test_inputs_that_change_together_have_one_share_and_linked_ones_none():
    x, y = samples(128, 2).T
    word = np.where(x > 0.5, "thick", "thin")
    found = first_order({"x": x, "twice": 2 * x, "y": y}, x + y)
    assert found["x"] == found["twice"] == pytest.approx(0.5, abs=0.06)
    assert "x" not in first_order({"x": x, "near": x + 0.3 * y, "y": y}, x + y)
    assert set(first_order({"size": word, "steel": word, "y": y}, x + y)) == {"size", "steel", "y"}
    three = np.where(x > 0.7, "a", np.where(x > 0.5, "b", "c"))
    assert set(first_order({"size": word, "steel": three, "y": y}, x + y)) == {"y"}


def test_too_few_samples_and_a_result_that_never_changes_tell_nothing():
    x = samples(FEWEST, 1).ravel()
    assert first_order({"x": x}, x)
    assert first_order({"x": x}, np.full(len(x), 2.0)) == {}
    missing = np.where(np.arange(len(x)) == 0, np.nan, x)
    assert first_order({"x": x}, missing) == {}
    assert first_order({"x": [None, *x[1:]]}, x) == {}


def test_scatter_alone_has_its_share_taken_off():
    """Eight of 63 coefficients hold 0.127 of the variance of what does not depend on the input."""
    shares = []
    for seed in range(60):
        x, y = np.random.default_rng(seed).random((2, FEWEST))
        shares.append(first_order({"x": x}, y)["x"])
    assert np.mean(shares) < 0.05
