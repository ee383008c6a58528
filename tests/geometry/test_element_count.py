"""Number of a mesh's elements, estimated before it is made, within a factor."""

from dataclasses import replace

import pytest

from checks.part.loaded_part import FIRST
from geometry.cad_body import cad_skin
from geometry.element_count import SURE, skin_triangles, solid_elements, solid_unknowns
from geometry.mesh import TooFineError, TooManyUnknownsError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import LeafPack, Pin, PlateLink, TubeRod
from geometry.parts.pin import Seat

from .bars import PRESS_BAR

PLATES = [
    PlateLink(length=150.0, width=20.0, thickness=10.0, hole=10.0),
    PlateLink(length=150.0, width=20.0, thickness=10.0, hole=3.0),
]
PIN = Pin(
    diameter=10.0,
    seats=(Seat("a", at=0.0, width=10.0, single=True), Seat("b", at=10.5, width=10.0, single=True)),
)


def counted(shape, fineness):
    with gmsh_session() as gmsh:
        body = shape.build(gmsh)
        return skin_triangles(gmsh, (0.0, 1.5 * body.size), 20), solid_elements(
            gmsh, body, fineness
        )


@pytest.mark.parametrize("shape", [*PLATES, PIN])
def test_the_counts_are_those_of_the_mesh_within_a_factor_of_three(shape):
    """Measured on all shipped parts: skins 0.55 to 0.99 of the real, solids 0.2 to 2.8 of it."""
    triangles, elements = counted(shape, 0.5)
    assert 0.5 < triangles / len(cad_skin(shape).triangles) < 1.5
    assert 1 / 3 < elements / len(mesh_shape(shape, fineness=0.5).elements) < 3


def test_a_finer_region_counts():
    """A hole of 0.01 mm through 10 mm takes nearly all elements: the general ones are 2000."""
    fine = PlateLink(length=150.0, width=20.0, thickness=10.0, hole=0.01)
    _, elements = counted(fine, 1.0)
    assert elements > 1_000_000
    with pytest.raises(TooFineError, match=r"would need about \S+ elements of"):
        mesh_shape(fine)


TUBE = TubeRod(
    length=200.0, tube_diameter=30.0, wall=3.0, eye_diameter=45.0, eye_width=34.0, hole=16.0
)
BAR = replace(PRESS_BAR, length=325.0)
LEAVES = LeafPack(
    length=460.0,
    leaves=3,
    width=60.0,
    thickness=9.6,
    arm=453.5,
    overhang=26.5,
    clamp_length=80.0,
    rod_length=40.0,
    contact_from=426.0,
    contact_to=448.5,
    contact_length=10.0,
    clamp_factor=1.3,
)
SHAPES = [
    PLATES[0],
    PIN,
    PlateLink(length=90.0, width=60.0, thickness=8.0, hole=30.0),
    PlateLink(length=700.0, width=60.0, thickness=8.0, hole=12.0),
    PlateLink(length=60.0, width=40.0, thickness=20.0, hole=18.0),
    Pin(diameter=10.0, seats=(Seat("a", at=0.0, width=12.0), Seat("b", at=16.0, width=16.0))),
    TUBE,
    BAR,
    LEAVES,
    PlateLink(length=100.0, width=30.0, thickness=6.0, hole=14.0),
]


@pytest.mark.parametrize("shape", SHAPES)
def test_the_unknowns_of_a_first_mesh_are_estimated_to_a_factor_of_two(shape):
    with gmsh_session() as gmsh:
        estimate = solid_unknowns(gmsh, shape.build(gmsh), FIRST)
    assert 1 / SURE < estimate / (3 * len(mesh_shape(shape, fineness=FIRST).nodes)) < SURE


def test_a_mesh_of_surely_too_many_unknowns_is_not_made(monkeypatch):
    """Leaves of 6 m: 612 121 nodes at 3 m, 314 265 at 1.5 m, so 198.6 per mm and 1.21e6 at 6 m."""
    monkeypatch.setattr("geometry.meshing._generate", lambda _: pytest.fail("it is meshed"))
    with pytest.raises(TooManyUnknownsError) as refused:
        mesh_shape(replace(LEAVES, width=6000.0), fineness=FIRST, most_unknowns=300_000)
    assert refused.value.unknowns == pytest.approx(3.62e6, rel=0.5)
