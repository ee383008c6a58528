"""Parts of any size have the mesh of a part of usual size: gmsh's tolerances are absolute."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.cad_body import cad_body, cad_skin
from geometry.meshing import mesh_shape
from geometry.parts import LeafPack, Pin, PlateLink, Seat, TubeRod
from geometry.parts.step_part import NamedHole
from geometry.shape import Half, in_unit, unit_of
from geometry.sizing import size_field

LINK = PlateLink(length=60, width=24, thickness=8, hole=10, second_hole=12)
PIN = Pin(
    seats=(Seat("lug", at=20, width=6), Seat("eye", width=20, diameter=16)),
    diameter=20,
    step_fillet=1.2,
)
ROD = TubeRod(
    length=110, tube_diameter=20, wall=2.5, eye_diameter=34, eye_width=24, hole=16, fillet=8
)
LEAVES = LeafPack(
    leaves=3,
    width=60,
    thickness=9.6,
    arm=120,
    overhang=25,
    clamp_length=80,
    clamp_factor=1.3,
    rod_length=40,
    contact_from=90,
    contact_to=110,
    contact_length=10,
    length=100,
)


def times(shape, factor):
    """A shape of so many times the size."""
    return in_unit(shape, 1 / factor)


@pytest.mark.parametrize(
    ("largest", "unit"),
    [(3.0, 1.0), (2999.0, 1.0), (2.9, 1e-3), (3000.0, 1e3), (60e-6, 1e-6), (8e6, 1e6)],
)
def test_a_shape_is_three_to_three_thousand_units_large(largest, unit):
    link = times(LINK, largest / LINK.length)
    assert unit_of(link) == unit_of(Half(link)) == unit
    assert 3 <= in_unit(link, unit).length < 3000
    assert in_unit(link, 1.0) is link


def test_what_states_no_length_is_in_millimetres():
    assert unit_of(NamedHole("a", 1e-3)) == unit_of(object()) == 1.0


def test_counts_and_flags_are_in_no_unit():
    small = times(LEAVES, 1e-3)
    assert (small.leaves, small.clamp_factor) == (LEAVES.leaves, LEAVES.clamp_factor)
    assert (small.width, small.arm) == (0.06, 0.12)
    assert times(dataclasses.replace(PIN, step_fillet=0.0), 1e3).seats[1].diameter == 16e3


@pytest.mark.parametrize(
    ("shape", "factor"),
    [(LINK, 1e-3), (Half(LINK), 1e-3), (PIN, 1e3)],
    ids=["link", "half", "pin"],
)
def test_a_thousand_times_as_large_a_part_has_the_mesh_a_thousand_times_as_large(shape, factor):
    """A link of 0.1 um had no mesh, one of 60 um another one: by tolerances in mm."""
    first, other = (mesh_shape(s, fineness=0.5) for s in (shape, times(shape, factor)))
    assert np.array_equal(first.elements, other.elements)
    assert_allclose(other.nodes, factor * first.nodes, rtol=1e-15, atol=0)
    assert_allclose(other.volume_cad, factor**3 * first.volume_cad, rtol=1e-12)
    assert other.unit == factor
    for name, interface in first.interfaces.items():
        found = other.interfaces[name]
        assert_allclose(found.centre, factor * interface.centre, rtol=1e-15)
        assert_allclose(
            [found.radius, found.length, found.patch, *found.travel],
            [factor * v for v in (interface.radius, interface.length, 0.0, *interface.travel)],
        )
        for surface in interface.surfaces:
            assert np.array_equal(first.surfaces[surface], other.surfaces[surface])


@pytest.mark.slow
def test_a_finer_mesh_of_it_has_the_same_sizes():
    """Sizes come in steps of 1 % of the unit that the part is meshed in."""
    finer = []
    for shape in (LINK, times(LINK, 1e-3)):
        mesh = mesh_shape(shape, fineness=0.4)
        wanted = mesh.unit * np.linspace(1.7, 4.1, len(mesh.elements))
        finer.append(mesh_shape(shape, fineness=0.4, sizes=size_field(mesh, wanted)))
    assert np.array_equal(finer[0].elements, finer[1].elements)
    assert_allclose(finer[1].nodes, 1e-3 * finer[0].nodes, rtol=1e-15, atol=0)


@pytest.mark.parametrize("factor", [1e-6, 1e3])
def test_its_body_and_its_skin_are_as_large(factor):
    first, other = cad_body(ROD), cad_body(times(ROD, factor))
    assert_allclose(other.volume, factor**3 * first.volume, rtol=1e-12)
    assert_allclose(other.centre, factor * first.centre, rtol=1e-12)
    assert_allclose(other.second, factor**5 * first.second, rtol=1e-12)
    assert_allclose(other.size, factor * first.size, rtol=1e-12)
    skin, there = cad_skin(ROD), cad_skin(times(ROD, factor))
    assert np.array_equal(skin.triangles, there.triangles)
    assert_allclose(there.nodes, factor * skin.nodes, rtol=1e-15, atol=0)
