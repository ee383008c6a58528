"""Williams' fields at a sharp edge: their orders, and that they are stress at all."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.notch_intensity import face_loads, modes, stress_of
from fem.singularity import singular_exponent

OPENINGS = (30, 60, 90, 120, 135, 150, 160)


@pytest.mark.parametrize(
    ("opening", "orders"),
    [
        (60, (0.5122, 0.7309, 0.6000)),
        (90, (0.5445, 0.9085, 0.6667)),
        (120, (0.6157, 1.1489, 0.7500)),
        (135, (0.6736, 1.3021, 0.8000)),
        (150, (0.7520, 1.4858, 0.8571)),
    ],
)
def test_the_leading_orders_solve_the_characteristic_equations(opening, orders):
    """sin(l w) = -+ l sin w, w = 360 deg - opening; out of the plane pi / w. Four digits."""
    angle = np.radians(360 - opening)
    found = [mode.order.real for mode in modes(angle, 3.2)[:3]]
    assert_allclose(found, orders, atol=5e-5)
    for order, sign in zip(found[:2], (1, -1), strict=True):
        assert_allclose(np.sin(order * angle), -sign * order * np.sin(angle), atol=1e-9)
    assert_allclose(found[0] - 1, -singular_exponent(angle), atol=1e-9)


@pytest.mark.parametrize("opening", OPENINGS)
def test_every_field_leaves_both_faces_free(opening):
    angle = np.radians(360 - opening)
    faces = np.array([angle / 2, -angle / 2])
    for mode in modes(angle, 3.2):
        stress = stress_of(mode, angle, np.array([1.7, 1.7]), faces)
        assert_allclose(stress[:, [1, 2, 4]], 0, atol=1e-8)


@pytest.mark.parametrize("opening", OPENINGS)
def test_every_field_is_in_balance_and_compatible(opening):
    """Divergence in polar coordinates, and Laplace's equation of rr + tt, by differences."""
    angle = np.radians(360 - opening)
    r, theta, step = 1.3, 0.2 * angle, 1e-3
    for mode in (*modes(angle, 3.2), *face_loads()):

        def at(dr, dt, mode=mode):
            place = np.array([r + dr * step]), np.array([theta + dt * step])
            return stress_of(mode, angle, *place)[0]

        by_r = (at(1, 0) - at(-1, 0)) / (2 * step)
        by_t = (at(0, 1) - at(0, -1)) / (2 * step)
        rr, tt, rt, zr, _ = at(0, 0)
        assert_allclose(by_r[0] + by_t[2] / r + (rr - tt) / r, 0, atol=1e-5)
        assert_allclose(by_r[2] + by_t[1] / r + 2 * rt / r, 0, atol=1e-5)
        assert_allclose(by_r[3] + by_t[4] / r + zr / r, 0, atol=1e-5)
        trace = {
            place: at(*place)[:2].sum() for place in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
        }
        curved = (trace[1, 0] - 2 * trace[0, 0] + trace[-1, 0]) / step**2
        curved += (trace[1, 0] - trace[-1, 0]) / (2 * step) / r
        curved += (trace[0, 1] - 2 * trace[0, 0] + trace[0, -1]) / step**2 / r**2
        assert_allclose(curved, 0, atol=1e-3)


def test_the_leading_fields_are_scaled_on_the_bisector():
    """K / sqrt(2 pi) r^(lambda - 1): the hoop stress, the shear in the plane and out of it."""
    angle = 1.5 * np.pi
    for mode, component in zip(modes(angle, 2.0)[:3], (1, 2, 4), strict=True):
        stress = stress_of(mode, angle, np.array([0.25]), np.zeros(1))[0]
        wanted = 0.25 ** (mode.order.real - 1) / np.sqrt(2 * np.pi)
        assert_allclose(stress[component], wanted, rtol=1e-12)


def test_an_angle_without_a_reentrant_edge_is_refused():
    with pytest.raises(ValueError, match="interior angle above pi"):
        modes(np.pi, 2.0)


def test_any_even_load_of_both_faces_is_a_sum_of_the_six_fields_for_it():
    """Normal and shear stresses on two faces, in the plane and out of it: rank 6."""
    angle = 1.5 * np.pi
    faces = np.array([angle / 2, -angle / 2])
    fields = [stress_of(mode, angle, np.ones(2), faces)[:, [1, 2, 4]] for mode in face_loads()]
    assert np.linalg.matrix_rank(np.reshape(fields, (6, 6)), tol=1e-6) == 6
