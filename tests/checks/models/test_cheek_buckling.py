"""Cheeks beside a pin: plates against closed forms, and the whole against solids."""

from dataclasses import replace

import numpy as np
import pytest

from checks.models.shapes.toggle_bar import _ACROSS, _grid, _matrices, spreading
from geometry.parts import ToggleBar

E, NU = 210e3, 0.3
BAR = ToggleBar(
    length=250.0,
    width=40.0,
    wall=3.0,
    hole=22.0,
    overhang=20.0,
    inner_radius=1.5,
    cutout_length=35.0,
    cutout_corner=3.0,
)


def lowest(shape, grid, stress):
    elastic, loaded = _matrices(shape, grid, stress, NU)
    free = grid.free
    half = np.linalg.inv(np.linalg.cholesky(elastic[np.ix_(free, free)]))
    return np.linalg.eigvalsh(-half @ loaded[np.ix_(free, free)] @ half.T)[-1] / E


def test_an_even_tube_buckles_as_long_plates_do():
    """4 pi^2 D/(b^2 t) where all four walls are pressed alike (Timoshenko and Gere, 9.2).

    The far end is held and the near one free, so that it lies between that plate's load and the
    (3 + nu)(1 - nu) pi^2 D/(b^2 t) of an edge that is free (prismatic_tube.pressed_edge_stress).
    """
    tube = replace(BAR, hole=0.2, cutout_length=1.0, cutout_corner=0.5, overhang=100.0)
    grid = _grid(tube)
    grid = replace(grid, held=-1e9)

    def even(x, _):
        return np.tile([-1.0, 0.0, 0.0], (len(x), 1))

    side = tube.width - tube.wall
    plate = np.pi**2 * E / 12 / (1 - NU**2) * (tube.wall / side) ** 2
    assert 1 / lowest(tube, grid, even) == pytest.approx((3 + NU) * (1 - NU) * plate, rel=0.02)


def test_a_long_free_stretch_of_the_cheeks_is_a_cantilever():
    """pi^2 D b/(4 l^2), both edges free, under a pull-free even pressure from its end to its root.

    It bends as a plate strip, between E and E/(1 - nu^2); the root turns a little.
    """
    long = replace(BAR, hole=0.2, cutout_length=180.0, overhang=1.0, wall=2.0)
    grid = _grid(long)

    def even(x, _):
        found = np.zeros((len(x), 3))
        found[x < grid.held, 0] = -1.0
        return found

    reach = grid.held + 1.0
    strip = np.pi**2 * E / 12 * (long.wall / (2 * reach)) ** 2
    assert 0.9 * strip < 1 / lowest(long, grid, even) < 1.1 * strip


def test_the_edge_stands_still_behind_the_cut_out_only():
    grid = _grid(BAR)
    free = set(grid.free.tolist())
    for i, x in enumerate(grid.along[:-1]):
        assert (4 * (i * len(grid.across) + _ACROSS) in free) == (x < grid.held)


def test_a_hole_that_leaves_no_plate_beside_it_has_no_share():
    wide = replace(BAR, hole=29.0)
    assert spreading(wide, E, NU) is None


@pytest.mark.parametrize(
    ("changes", "more"), [({"cutout_length": 45.0}, 1), ({"wall": 3.6}, -1), ({"hole": 18.0}, 1)]
)
def test_a_longer_cut_out_softens_and_a_thicker_wall_stiffens(changes, more):
    own = spreading(BAR, E, NU)
    other = replace(BAR, **changes)
    changed = spreading(other, E, NU)
    assert (changed - own) * more > 0
