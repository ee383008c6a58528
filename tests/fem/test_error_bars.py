"""Error bars of peaks and the edges at which there is no peak to have an error."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.convergence import (
    ErrorBar,
    discretisation_error,
    growth_exponent,
    moves_like_singular,
)
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


def test_two_meshes_give_one_and_a_half_times_the_extrapolated_error():
    """1.5 |102 - 100| / (2^2 - 1) = 1; of more meshes the last two count."""
    assert_allclose(discretisation_error([100, 102], [1, 0.5]), 1.0)
    assert_allclose(discretisation_error([80, 100, 102], [2, 1, 0.5]), 1.0)


def test_two_meshes_that_are_alike_leave_a_wide_bar():
    """The step of 2 counts as if the elements were a tenth smaller: 1.5 x 2 / 0.21."""
    assert_allclose(discretisation_error([100, 102], [1, 0.99]), 1.5 * 2 / 0.21)


def test_meshes_that_agree_leave_no_discretisation_error():
    assert discretisation_error([101, 101, 101], [1, 0.5, 0.25]) == 0.0


def test_a_peak_that_keeps_growing_like_a_power_is_singular():
    """Stress ~ size^-0.4555, as at a square corner; half of it is no corner but still grows."""
    sizes = [1, 0.6, 0.35]
    grown = [100 * h**-0.4555 for h in sizes]
    assert_allclose(growth_exponent(grown, sizes), 0.4555, rtol=1e-9)
    assert_allclose(growth_exponent([100 * h**-0.2 for h in sizes], sizes), 0.2, rtol=1e-9)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_a_peak_that_converges_is_not_singular(order):
    sizes = [1, 0.6, 0.35]
    assert growth_exponent([100 - 30 * h**order for h in sizes], sizes) == 0.0


def test_growth_needs_three_meshes_that_differ_at_the_point():
    assert growth_exponent([100, 137], [1, 0.5]) == 0.0
    assert growth_exponent([100, 137, 188], [1, 0.5, 0.49]) == 0.0
    assert growth_exponent([0, 137, 188], [1, 0.5, 0.25]) == 0.0


def test_one_mesh_has_no_error_bar():
    with pytest.raises(ValueError, match="at least two meshes"):
        discretisation_error([100], [1])


def test_the_bar_takes_the_larger_of_mesh_and_nearly_half_the_scatter_and_adds_the_rest():
    assert ErrorBar(2.0, 3.0, 0.5).value == 2.5
    assert_allclose(ErrorBar(1.0, 4.0, 0.5).value, 2.3)
    assert_allclose(ErrorBar(2.0, 3.0, 0.5, size=100.0).value, 2.75)
    assert_allclose(ErrorBar(2.0, 3.0, 0.5, size=100.0).mesh, 2.25)


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
