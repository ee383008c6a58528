"""Number of a mesh's elements, estimated before it is made, within a factor."""

from dataclasses import replace

import pytest

from checks.ladder.levels import first_mesh
from checks.part.loaded_part import FIRST
from checks.stress.kept_models import Models, told_of_size
from fem.assembly import Elements
from fem.unit_loads import interface_loads
from geometry.cad_body import cad_skin
from geometry.mesh import TooFineError, TooManyElementsError, TooManyUnknownsError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import LeafPack, Pin, PlateLink, TubeRod
from geometry.parts.pin import Seat
from geometry.sizing import SURE, skin_triangles, solid_elements, solid_unknowns

from ..small_machine import PLATE, machine
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
    length=100.0, tube_diameter=30.0, wall=3.0, eye_diameter=45.0, eye_width=34.0, hole=16.0
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


def with_narrow_lug(width):
    """A pin of 8 mm with a pair of lugs that are too narrow for elements of its size, 1.4 mm."""
    seats = (Seat("sheet", at=15.5, width=width), Seat("eye", at=0.0, width=20.0))
    return Pin(diameter=8.0, seats=seats)


def test_a_narrow_lug_has_elements_that_carry_its_force():
    """Elements of 1.4 mm on 0.1 mm fold, and their load missed its resultant by up to 77 %."""
    mesh = mesh_shape(with_narrow_lug(0.1), fineness=FIRST)
    assert interface_loads(Elements(mesh), mesh.interfaces["sheet"]).raw_deviation < 1e-4


def test_a_lug_too_narrow_for_a_mesh_is_refused_before_with_its_key_and_the_least(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("geometry.meshing._generate", lambda *_, **__: pytest.fail("it is meshed"))
    pin = """
[parts.pin]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "C45"
diameter = "12 mm"
stack = [
  { body = "crank", at = "9 mm", width = "WIDE" },
  { body = "rod", at = "0 mm", width = "8 mm" },
]
"""
    design = machine(tmp_path, PLATE + pin.replace("WIDE", "0.002 mm"))
    part = design.parts["pin"]
    with pytest.raises(TooManyElementsError) as refused:
        first_mesh(part, part.geometry, FIRST, Models())
    told = told_of_size(design, part, refused.value)
    assert told.key == "parts.pin.stack[0].width"
    assert "a lug of 0.002 mm on a pin of 12 mm takes about" in told.problem
    least = float(told.problem.split("at least about ")[1].split(" mm")[0])
    assert 0.004 < least < 0.1
    wider = machine(tmp_path, PLATE + pin.replace("WIDE", f"{least:g} mm")).parts["pin"].geometry
    with gmsh_session() as gmsh:
        assert solid_unknowns(gmsh, wider.build(gmsh), FIRST) < SURE * part.most_unknowns
