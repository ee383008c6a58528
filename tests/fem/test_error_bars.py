"""Error bars of peaks and the edges at which there is no peak to have an error."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.convergence import ErrorBar, discretisation_error, moves_like_singular
from fem.recovery import von_mises
from fem.singularity import reentrant_edges, singular_exponent
from fem.stress_history import StressHistory
from geometry.meshing import mesh_shape
from geometry.parts import Seat

from .blocks import BAR, PIN, TUBE, block


def stepped(fillet, fineness=0.4):
    seats = (PIN.seats[0], Seat("eye", width=20, diameter=16))
    return mesh_shape(replace(PIN, seats=seats, step_fillet=fillet), fineness=fineness)


@pytest.mark.parametrize(("degrees", "exponent"), [(90, 0), (180, 0), (270, 0.4555), (360, 0.5)])
def test_the_exponent_of_an_edge_is_that_of_williams(degrees, exponent):
    """M. L. Williams (1952): 0.5445 - 1 at 270 degrees, the square root of a crack at 360.

    Four printed digits.
    """
    assert_allclose(singular_exponent(np.radians(degrees)), exponent, atol=5e-5)


def test_the_steps_of_a_sharp_pin_are_found():
    """Both ends of the neck, r = 8 mm at z = +-10 mm: 270 degrees of steel."""
    mesh = stepped(0.0)
    edges = reentrant_edges(mesh)
    nodes = mesh.nodes[edges.nodes]
    assert_allclose(np.hypot(nodes[:, 0], nodes[:, 1]), 8, rtol=2e-3)
    assert set(np.round(nodes[:, 2], 6)) == {-10.0, 10.0}
    assert_allclose(np.degrees(edges.angles), 270, atol=3)  # facets around the circle


def test_the_inner_corners_of_a_sharp_tube_are_found():
    mesh = mesh_shape(TUBE, fineness=0.3)
    edges = reentrant_edges(mesh)
    assert_allclose(np.abs(mesh.nodes[edges.nodes][:, 1:]), 4.9, atol=1e-9)
    assert_allclose(np.degrees(edges.angles), 270, atol=1e-6)


@pytest.mark.parametrize("name", ["pin", "bar", "block"])
def test_a_fillet_and_convex_edges_are_no_singularity(name):
    """Quadratic facets turn little along an edge; a pin at 0.4 is too coarse for that."""
    make = {
        "pin": lambda: stepped(1.2, 0.7),
        "bar": lambda: mesh_shape(BAR, fineness=0.4),
        "block": lambda: block((2, 2, 2), (1.0, 1.0, 1.0)),
    }
    assert len(reentrant_edges(make[name]()).nodes) == 0


def test_a_peak_that_grows_like_its_edge_is_singular_and_one_that_settles_is_not():
    """Stress ~ h^-0.4555: half the element, 1.37 times the stress."""
    grown = [100.0, 100.0 * 2**0.4555]
    assert moves_like_singular(grown, [1.0, 0.5], 0.4555)
    assert moves_like_singular([100.0, 90.0], [1.0, 0.5], 0.4555), "coarse meshes scatter"
    assert not moves_like_singular([100.0, 101.0], [1.0, 0.5], 0.4555)
    assert not moves_like_singular([100.0, 100.0], [1.0, 0.5], 0.4555)
    assert not moves_like_singular(grown, [1.0, 0.5], 0.0)
    assert not moves_like_singular([100.0], [1.0], 0.4555)


def test_two_meshes_give_three_times_the_extrapolated_error():
    """Roache: 3 |102 - 100| / (2^2 - 1) = 2."""
    assert_allclose(discretisation_error([100, 102], [1, 0.5]), 2.0)


def test_three_meshes_that_converge_give_the_extrapolated_error_with_their_order():
    """First order: 100, 104, 106 with h halved; 1.25 x 2 / (2 - 1). Second: 1.25 x 1 / 3."""
    assert_allclose(discretisation_error([100, 104, 106], [1, 0.5, 0.25]), 2.5)
    assert_allclose(discretisation_error([100, 104, 105], [1, 0.5, 0.25]), 1.25 / 3)


def test_a_suspiciously_fast_convergence_is_taken_as_second_order():
    assert_allclose(discretisation_error([100, 108, 109], [1, 0.5, 0.25]), 1.25 / 3)


@pytest.mark.parametrize("values", [[100, 101, 103], [100, 101, 102], [100, 100, 103]])
def test_three_meshes_that_do_not_converge_give_three_times_their_spread(values):
    assert_allclose(discretisation_error(values, [1, 0.5, 0.25]), 3 * np.ptp(values))


def test_meshes_that_agree_leave_no_discretisation_error():
    assert discretisation_error([101, 101, 101], [1, 0.5, 0.25]) == 0.0


def test_two_meshes_that_agree_by_chance_keep_a_bar_from_the_step_before():
    """Step 20, then 0: a second-order rest of 20/4/3 with 1.25; a change of sign likewise."""
    assert_allclose(discretisation_error([100, 120, 120], [1, 0.5, 0.25]), 1.25 * 20 / 4 / 3)
    assert discretisation_error([100, 120, 119.9], [1, 0.5, 0.25]) > 2


def test_one_mesh_has_no_error_bar():
    with pytest.raises(ValueError, match="at least two meshes"):
        discretisation_error([100], [1])


def test_the_bar_takes_the_larger_of_mesh_and_scatter_and_adds_the_truncation():
    assert ErrorBar(2.0, 3.0, 0.5).value == 3.5
    assert ErrorBar(4.0, 3.0, 0.5).value == 4.5


def test_the_bar_of_a_singular_peak_is_infinite():
    assert ErrorBar(0.0, 0.0, 0.0, singular=0.4555).value == inf


def history(n_points):
    random = np.random.default_rng(5)
    return StressHistory(
        np.arange(n_points),
        np.zeros((n_points, 3)),
        random.standard_normal((n_points, 6, 4)),
        random.standard_normal((4, 7)),
    )


def test_peaks_by_position_are_those_of_the_plain_calculation():
    """More points than one chunk of 2000, so that peaks of several chunks compete."""
    stresses = history(4500)
    peaks, points = stresses.peaks_by_position()
    for k in range(7):
        plain = von_mises(stresses.at(k))
        assert_allclose(peaks[k], plain.max(), rtol=1e-12)
        assert points[k] == plain.argmax()


def test_part_of_a_history_is_the_same_stress_at_fewer_positions():
    stresses = history(20)
    part = stresses.between(slice(2, 5))
    assert_allclose(part.at(1), stresses.at(3))
    assert part.coefficients.shape == (4, 3)


def test_a_history_whose_arrays_do_not_fit_is_refused():
    stresses = history(20)
    with pytest.raises(ValueError, match=r"20 points and 3 coefficients need .* basis .20, 6, 3."):
        replace(stresses, coefficients=stresses.coefficients[:3])
