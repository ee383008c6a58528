"""A pin through two plates side by side: what its stress is where their pressures end."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.singularity import pressed_edges
from fem.unit_solutions import solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts.pin import Pin, Seat
from tests.fem.fourier_pin import FourierBar

STEEL = SimpleNamespace(youngs_modulus=210e3, poisson_ratio=0.3, density=7.85e-9)
RADIUS, WIDTH, ARM = 5.0, 10.0, 10.5
PIN = Pin(
    seats=(
        Seat(name="crank", width=WIDTH, single=True),
        Seat(name="rod", at=ARM, width=WIDTH, single=True),
    ),
    diameter=2 * RADIUS,
)
FORCE = 400.0  # N, by cos(theta) pressures; the crank takes the couple, too
EVEN = FORCE / (np.pi * RADIUS * WIDTH)
RISING = FORCE * ARM / (np.pi * RADIUS * WIDTH**3 / 12)  # MPa/mm along the crank's width
JUMP = EVEN + RISING * WIDTH / 2  # MPa, where the crank's pressure ends


@pytest.fixture(scope="module")
def exact():
    """Amplitudes of stress at heights, by the Fourier series."""
    lugs = {seat.name: (low, high) for seat, low, high in PIN.seated()}
    bar = FourierBar(RADIUS, PIN.ends, lugs, STEEL.youngs_modulus, STEEL.poisson_ratio, 0.05)
    load = EVEN * (bar.load("rod", 1, along=False) - bar.load("crank", 1, along=False))
    load -= RISING * bar.load("crank", 1, along=True)
    displacement = bar.solve(1, load)
    return lambda z: bar.surface_stress(1, displacement, np.asarray(z, dtype=float))


@pytest.fixture(scope="module")
def solid():
    """Surface points and their stress on a mesh of a fifth of the radius."""
    mesh = mesh_shape(PIN, fineness=1.0)
    solutions = solve_unit_loads(mesh, STEEL)
    names = [(u.interface.name, name) for u in solutions.interfaces for name in u.names]
    state = np.zeros(solutions.displacement.shape[1])
    state[names.index(("crank", "cos 1"))] = -FORCE
    state[names.index(("rod", "cos 1"))] = FORCE
    state[names.index(("crank", "M_y"))] = ARM * FORCE
    assert np.abs(solutions.reactions(state[:, None])).max() < 1e-6 * FORCE
    return solutions, mesh.nodes[solutions.recovery.points], solutions.basis @ state


def test_the_series_is_a_beam_in_the_middle_of_the_lug(exact):
    """Moment of what presses above z = 0: F (ARM - w/8) of the plates, F ARM/2 of the couple."""
    moment = FORCE * (ARM - WIDTH / 8 - ARM / 2)
    assert_allclose(exact([0.0])["zz"][0], 4 * moment / (np.pi * RADIUS**3), rtol=0.05)


def test_points_at_a_pressed_edge_have_the_stress_beside_it(solid, exact):
    """Of elements that meet the edge the stress is up to half the jump off, on any mesh."""
    solutions, points, stress = solid
    along = points[:, 0] / RADIUS
    on_lug = (np.abs(along) > 0.9) & (points[:, 2] > WIDTH / 5) & (points[:, 2] < WIDTH / 2 + 1e-9)
    on_lug &= np.hypot(*points.T[:2]) > RADIUS - 1e-6
    stands = solutions.recovery.stands_for[on_lug]
    assert (stands != np.flatnonzero(on_lug)).sum() > 20
    away = stress[on_lug, 2] - exact(points[stands, 2])["zz"] * along[stands]
    assert np.abs(away).max() < 0.12 * JUMP
    assert np.sqrt((away**2).mean()) < 0.05 * JUMP
    limit = exact([WIDTH / 2 - 0.06])["zz"][0]
    assert -0.2 * JUMP < np.abs(stress[on_lug, 2]).max() - limit < 0.12 * JUMP


def test_pressed_edges_are_where_a_lug_ends_on_the_bar(solid):
    solutions, _, _ = solid
    heights = solutions.mesh.nodes[pressed_edges(solutions.mesh), 2]
    assert_allclose(np.unique(np.round(heights, 6)), [-5, 5, 5.5, 15.5])
