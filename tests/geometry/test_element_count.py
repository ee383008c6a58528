"""Number of a mesh's elements, estimated before it is made, within a factor."""

import pytest

from geometry.cad_body import cad_skin
from geometry.element_count import skin_triangles, solid_elements
from geometry.mesh import TooFineError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import Pin, PlateLink
from geometry.parts.pin import Seat

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
