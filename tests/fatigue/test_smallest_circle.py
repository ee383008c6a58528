"""Smallest circles and balls: closed forms, and all pairs and triples as a second way."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue.shear_planes import smallest_circles

TURN = np.linspace(0.0, 2.0 * np.pi, 361)
THIRDS = np.radians([0.0, 120.0, 240.0])

# Public case FT-13: plane paths and the radius of the smallest circle around them, MPa.
CLOSED_FORMS = {
    "equilateral triangle on a circle of radius 100": (
        [100.0 * np.cos(THIRDS), 100.0 * np.sin(THIRDS)],
        100.0,
    ),
    "right triangle": ([[0, 60, 0], [0, 0, 80]], 50.0),
    "obtuse triangle, carried by two": ([[0, 100, 50], [0, 0, 10]], 50.0),
    "ellipse": ([80.0 * np.cos(TURN), 30.0 * np.sin(TURN)], 80.0),
    "rectangle": ([[0, 60, 60, 0], [0, 0, 80, 80]], 50.0),
    "one repeated point": ([[7, 7, 7], [-3, -3, -3]], 0.0),
    "one point": ([[7], [-3]], 0.0),
    "two points": ([[0, 6], [0, 8]], 5.0),
    "collinear": ([np.linspace(-3, 3, 50), np.linspace(-4, 4, 50)], 5.0),
}


def by_all_pairs_and_triples(path):
    """The least circle through two (as a diameter) or three positions that holds all of them."""
    points = np.asarray(path).T
    best = np.inf
    candidates = [(a + b) / 2.0 for a, b in combinations(points, 2)]
    for a, b, c in combinations(points, 3):
        system = 2.0 * np.array([b - a, c - a])
        if abs(np.linalg.det(system)) > 1e-9 * np.linalg.norm(system) ** 2:
            candidates.append(np.linalg.solve(system, [b @ b - a @ a, c @ c - a @ a]))
    for centre in candidates:
        best = min(best, np.linalg.norm(points - centre, axis=1).max())
    return best


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms_of_plane_paths(name):
    path, radius = CLOSED_FORMS[name]
    path = np.array(path, dtype=float)
    assert smallest_circles(path[None])[1] == pytest.approx([radius], abs=1e-9)


def test_the_circle_is_not_half_the_longest_chord():
    path, _ = CLOSED_FORMS["equilateral triangle on a circle of radius 100"]
    x, y = path
    chord = max(np.hypot(x[i] - x[j], y[i] - y[j]) for i, j in combinations(range(3), 2))
    assert chord / 2.0 == pytest.approx(86.60254, abs=1e-5)
    assert smallest_circles(np.array([path]))[1][0] == pytest.approx(chord / np.sqrt(3.0))


coordinates = st.integers(-6, 6).map(float) | st.floats(-100.0, 100.0, width=32)


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=9))
def test_any_few_points_have_the_circle_of_all_pairs_and_triples(points):
    """Whole numbers make many equal and collinear points."""
    path = np.array(points).T
    expected = by_all_pairs_and_triples(path)
    centre, radius, _ = smallest_circles(path[None])
    assert radius[0] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert np.hypot(*(path - centre[0][:, None])).max() <= radius[0] * (1.0 + 1e-12) + 1e-12


def test_paths_together_are_as_each_alone_and_in_any_order():
    paths = np.random.default_rng(1).normal(size=(60, 2, 200)).cumsum(axis=2)
    together = smallest_circles(paths)[1]
    turned = np.roll(paths, 77, axis=2)[:, :, ::-1]
    assert_allclose(smallest_circles(turned)[1], together, rtol=1e-12)
    for path, radius in zip(paths, together, strict=True):
        assert smallest_circles(path[None])[1][0] == pytest.approx(radius, rel=1e-12)


def test_the_carriers_alone_have_the_same_circle():
    paths = np.random.default_rng(2).normal(size=(40, 2, 100))
    _, radii, carriers = smallest_circles(paths)
    few = np.take_along_axis(paths, carriers[:, None, :], axis=2)
    assert_allclose(smallest_circles(few)[1], radii, rtol=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_ten_thousand_positions_with_duplicates_far_from_the_origin(scale):
    angle = np.linspace(0.0, 6.0 * np.pi, 10_000)
    path = scale * np.array([80.0 * np.cos(angle) + 300.0, 30.0 * np.sin(angle) - 200.0])
    path = np.concatenate([path, path[:, :100]], axis=1)
    assert smallest_circles(path[None])[1][0] == pytest.approx(80.0 * scale, rel=1e-6)
