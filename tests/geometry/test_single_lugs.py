"""Pins of plates side by side: lugs on one side of the mid-plane only."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.meshing import mesh_shape
from geometry.parts import Pin, Seat

from .facets import area

SHEAR = Pin(
    seats=(
        Seat("crank", at=5, width=10, single=True),
        Seat("rod", at=-3.5, width=6, diameter=8, single=True),
    ),
    diameter=10,
    overhang=2,
    step_fillet=0.5,
)
PAIR = Pin(seats=(Seat("lug", at=10, width=6),), diameter=10, overhang=2)


@pytest.fixture(scope="module")
def shear():
    return mesh_shape(SHEAR, fineness=0.7)


def test_a_pin_reaches_from_its_lowest_to_its_highest_lug():
    assert SHEAR.ends == (-8.5, 12)
    assert SHEAR.length == 20.5
    assert [(seat.name, lower, upper) for seat, lower, upper in SHEAR.seated()] == [
        ("rod", -6.5, -0.5),
        ("crank", 0, 10),
    ]


def test_a_pin_in_pairs_of_lugs_stays_symmetric():
    assert PAIR.ends == (-15, 15)
    assert [lower for _, lower, _ in PAIR.seated()] == [-13, 7]


def test_a_single_lug_presses_only_where_it_is(shear):
    """Pi d w of one lug each; quadratic facets, 1e-3."""
    for name, diameter, start, stop in (("crank", 10, 0, 10), ("rod", 8, -6.5, -0.5)):
        facets = shear.surfaces[name]
        assert_allclose(area(shear, facets), np.pi * diameter * (stop - start), rtol=1e-3)
        z = shear.nodes[facets][..., 2]
        assert_allclose([z.min(), z.max()], [start, stop], atol=1e-9)
        assert shear.interfaces[name].length == stop - start


def test_wrenches_of_a_single_lug_are_stated_in_its_own_middle(shear):
    assert_allclose(shear.interfaces["crank"].centre, [0, 0, 5])
    assert_allclose(shear.interfaces["rod"].centre, [0, 0, -3.5])
    assert all(interface.tilts for interface in shear.interfaces.values())


def test_a_pair_beside_a_single_lug_tilts_too_about_the_mid_plane():
    pin = replace(PAIR, seats=(*PAIR.seats, Seat("arm", at=20, width=4, single=True)))
    lug = mesh_shape(pin, fineness=0.5).interfaces["lug"]
    assert lug.tilts
    assert_allclose(lug.centre, 0)
    assert lug.length == 12


def test_a_pin_in_pairs_does_not_tilt():
    assert not mesh_shape(PAIR, fineness=0.5).interfaces["lug"].tilts


def test_two_single_lugs_make_the_pin_of_a_pair():
    """The same solid to the last bit, with two names for its journals."""
    two = (Seat("a", at=-10, width=6, single=True), Seat("b", at=10, width=6, single=True))
    single, pair = (mesh_shape(pin, fineness=0.5) for pin in (replace(PAIR, seats=two), PAIR))
    assert np.array_equal(single.nodes, pair.nodes)
    both = np.concatenate([single.surfaces["a"], single.surfaces["b"]])
    assert np.array_equal(np.unique(both), np.unique(pair.surfaces["lug"]))
