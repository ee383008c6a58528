"""Findley's criterion: closed forms, public values, and a dense grid as an independent search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fatigue import critical_plane, findley_criterion
from fatigue.shear_planes import divided, half_sphere, longest_edges, middles, smallest_circles
from tests.fatigue.multiaxial_cases import (
    BENDING_LIMIT,
    NISHIHARA_KAWAMOTO,
    TORSION_LIMIT,
    bending_and_torsion,
    random_path,
    random_rotation,
    turned,
)

STEEL = findley_criterion(TORSION_LIMIT / BENDING_LIMIT)
K = STEEL.k
LIMIT = STEEL.limit_ratio * BENDING_LIMIT


def findley_on(normal, stress, k):
    """F of one plane with tensors and a frame of its own, compression without credit."""
    tensor = stress[np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])]
    traction = np.einsum("i,ijt->jt", normal, tensor)
    sigma = normal @ traction
    first, second = np.linalg.svd(normal[None])[2][1:]
    radius = smallest_circles(np.stack([first @ traction, second @ traction])[None])[1][0]
    return radius + k * max(sigma.max(), np.ptp(sigma) / 2.0)


def angle_between_planes(first, second):
    return np.arccos(min(1.0, abs(first @ second)))


def test_the_calibration_of_the_public_steel():
    """Public case FT-12."""
    assert pytest.approx(0.2582866314, abs=1e-10) == K
    assert pytest.approx(202.6387931, abs=1e-7) == LIMIT


def test_reversed_bending_and_torsion_are_at_the_limit():
    """Public case FT-12: F = b/2 (k + sqrt(1 + k^2)) = t sqrt(1 + k^2); search to 1e-6."""
    bent = critical_plane(bending_and_torsion(BENDING_LIMIT, 0.0), K)
    assert bent.value == pytest.approx(LIMIT, rel=1e-8)
    twisted = critical_plane(bending_and_torsion(0.0, TORSION_LIMIT), K)
    assert twisted.value == pytest.approx(LIMIT, rel=1e-8)


def test_the_critical_plane_of_tension_is_inclined_by_half_atan_1_over_k():
    """Public case FT-12: 37.75888745 degrees between normal and axis."""
    plane = critical_plane(bending_and_torsion(BENDING_LIMIT, 0.0), K)
    assert np.degrees(np.arccos(abs(plane.normal[0]))) == pytest.approx(37.75888745, abs=2e-4)
    assert plane.pair == (360, 1080)
    assert plane.shear_amplitude + K * plane.normal_stress == pytest.approx(plane.value, rel=1e-12)


def test_repeated_bending_has_its_closed_form():
    """Public case FT-12: (s_a/2)(2k + sqrt(1 + 4 k^2)) = 164.2116658 for 200 MPa at R = 0."""
    plane = critical_plane(bending_and_torsion(200.0, 0.0, mean=200.0), K)
    assert plane.value == pytest.approx(164.2116658, abs=1e-6)


@pytest.mark.parametrize("test", NISHIHARA_KAWAMOTO)
def test_bending_and_torsion_in_and_out_of_phase_have_their_public_values(test):
    """Public case FT-11. 1440 positions cut an ellipse short by (pi/1440)**2 / 2 = 2.4e-6."""
    plane = critical_plane(bending_and_torsion(test.bending, test.torsion, test.phase), K)
    assert plane.value / LIMIT == pytest.approx(test.expected, rel=5e-6)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.16, 0.6]), st.sampled_from([0.0, 1.0, 5.0]))
def test_no_plane_of_a_dense_grid_exceeds_the_value_or_the_bound(seed, k, static):
    path = random_path(seed, n_positions=40, static=static)
    plane = critical_plane(path, k)
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(300, 3))
    near = plane.normal + 0.02 * rng.normal(size=(60, 3))
    for normal in np.concatenate([normals, near]):
        on_grid = findley_on(normal / np.linalg.norm(normal), path, k)
        assert on_grid <= plane.value * (1.0 + 1e-9)
    assert findley_on(plane.normal, path, k) == pytest.approx(plane.value, rel=1e-9)
    assert plane.value <= plane.bound <= 1.0005 * plane.value + 1e-3 * np.abs(path).max()


def test_planes_that_do_not_reach_a_floor_are_not_searched_and_the_bound_says_so():
    for seed in range(10):
        path = random_path(seed)
        whole = critical_plane(path, K)
        early = critical_plane(path, K, floor=1.2 * whole.value)
        assert whole.value <= early.bound <= 1.2 * whole.value
        assert early.n_planes < whole.n_planes / 2
        late = critical_plane(path, K, floor=0.999 * whole.value)
        assert late.value == pytest.approx(whole.value, rel=1e-9)
        barely = critical_plane(path, K, floor=1.00001 * whole.value)
        assert barely.bound >= whole.value


def test_turning_the_frame_turns_the_plane_with_it():
    """The value to the square of the angle error, 1e-6 rad; the angle to its condition."""
    for seed in range(5):
        path, rotation = random_path(seed), random_rotation(seed)
        before, after = critical_plane(path, K), critical_plane(turned(path, rotation), K)
        assert after.value == pytest.approx(before.value, rel=1e-9)
        assert angle_between_planes(after.normal, rotation @ before.normal) < 1e-4


def test_the_start_of_the_cycle_and_its_direction_do_not_matter():
    path = random_path(7)
    before = critical_plane(path, K)
    assert critical_plane(np.roll(path, 33, axis=1), K).value == pytest.approx(before.value)
    assert critical_plane(path[:, ::-1], K).value == pytest.approx(before.value, rel=1e-9)


def test_compression_earns_no_credit():
    """Far in compression the plane counts as reversed."""
    reversed_ = critical_plane(bending_and_torsion(200.0, 0.0), K)
    pressed = bending_and_torsion(200.0, 0.0, mean=-1000.0)
    assert critical_plane(pressed, K).value == pytest.approx(reversed_.value, rel=1e-8)


def test_principal_axes_that_rotate_at_constant_magnitude_shear_a_whole_circle():
    """(xx - yy)/2 = 100 cos, xy = 100 sin: the plane of their normals sees 100 sin 2(a - t)."""
    turn = 2.0 * np.pi * np.arange(720) / 720
    path = np.zeros((6, 720))
    path[0], path[1], path[3] = 100.0 * np.cos(turn), -100.0 * np.cos(turn), 100.0 * np.sin(turn)
    plane = critical_plane(path, K)
    assert plane.value == pytest.approx(100.0 * (1.0 + K), rel=2e-5)
    assert plane.normal[2] == pytest.approx(0.0, abs=1e-3)


def test_a_spike_of_one_position_counts_in_full():
    path = np.zeros((6, 720))
    path[3, 411] = 80.0
    assert critical_plane(path, 0.0).value == pytest.approx(40.0, rel=1e-9)


@pytest.mark.parametrize("n_positions", [1, 2, 5])
def test_a_stress_that_never_changes_has_its_largest_principal_only(n_positions):
    path = np.repeat(np.array([[100.0], [40.0], [-20.0], [0.0], [0.0], [0.0]]), n_positions, axis=1)
    plane = critical_plane(path, K)
    assert plane.shear_amplitude == pytest.approx(0.0, abs=1e-9)
    assert plane.value == pytest.approx(100.0 * K, rel=1e-9)


def test_no_stress_is_no_parameter():
    plane = critical_plane(np.zeros((6, 4)), K)
    assert (plane.value, plane.bound) == (0.0, 0.0)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_the_parameter_is_linear_in_the_load(scale):
    path = random_path(5)
    expected = scale * critical_plane(path, K).value
    assert critical_plane(scale * path, K).value == pytest.approx(expected, rel=1e-9)


def test_paths_and_limits_that_cannot_be_judged_are_refused():
    path = random_path(4)
    path[2, 17] = np.nan
    with pytest.raises(ValueError, match="not finite at position 17"):
        critical_plane(path, K)
    with pytest.raises(ValueError, match=r"must be \(6, n_positions\), got \(5, 4\)"):
        critical_plane(np.ones((5, 4)), K)
    with pytest.raises(ValueError, match=r"must not be below 0, got -0\.1"):
        critical_plane(np.ones((6, 4)), -0.1)
    for ratio in (0.49, 1.0, np.nan):
        with pytest.raises(ValueError, match=r"0\.5 to below 1 times the bending limit"):
            findley_criterion(ratio)


@pytest.mark.parametrize("n_divisions", [0, 1, 2, 3])
def test_the_grid_covers_every_plane_once(n_divisions):
    """The solid angles of the triangles (Van Oosterom and Strackee) sum to half a sphere."""
    normals, cells = half_sphere(n_divisions)
    assert len(cells) == 10 * 4**n_divisions
    assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-14)
    a, b, c = np.moveaxis(normals[cells], 1, 0)
    volume = np.abs(np.einsum("ni,ni->n", a, np.cross(b, c)))
    sides = 1.0 + sum(np.einsum("ni,ni->n", p, q) for p, q in ((a, b), (b, c), (c, a)))
    assert (2.0 * np.arctan2(volume, sides)).sum() == pytest.approx(2.0 * np.pi, rel=1e-12)
    centres = (a + b + c) / np.linalg.norm(a + b + c, axis=1)[:, None]
    cosines = centres @ centres.T
    assert np.sort(cosines, axis=1)[:, 0].min() > -1.0 + 1e-9  # no two are opposite


def test_divided_triangles_share_their_middles_and_halve_their_edges():
    normals, cells = half_sphere(2)
    edges, four = divided(len(normals), cells)
    finer = np.concatenate([normals, middles(normals, edges)])
    assert len(np.unique(np.sort(four, axis=1), axis=0)) == 4 * len(cells)
    assert len(edges) < 2 * len(cells)
    assert longest_edges(finer, four).max() < 0.51 * longest_edges(normals, cells).max()
