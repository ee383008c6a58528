"""A plate from CAD with another thickness: what it becomes, and what has none."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.carrying import Carrier
from geometry.closed_form import closed_body
from geometry.mesh import MeshError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parameters import ParameterError
from geometry.parts.step_part import NamedHole, StepPart

from .step_files import HOLES, LINK, hole, link_file, link_part, moved, plate_with, write_step

AXIS = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
PAIR = (NamedHole("a", 10, at=(0, 0, 0)), NamedHole("b", 10, at=(60, 0, 5)))


BLANK = plate_with(hole(0, 0, 10), hole(60, 0, 10))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("plate")


@pytest.fixture(scope="module")
def file(folder):
    """The link of 8 mm, drawn somewhere else: turned by 1.1 rad about a skew axis."""
    return link_file(folder, moved(AXIS, 1.1, (100, -200, 30)))


@pytest.mark.parametrize(("thickness", "flip"), [(2.4, False), (8.0, False), (12.0, True)])
def test_a_plate_of_another_thickness_is_the_parametric_one(file, thickness, flip):
    """Volume, faces, bores and sections to the digits that the file has."""
    part = link_part(file, thickness=thickness, flip=flip)
    twin = replace(LINK, thickness=thickness)
    assert_allclose(part.solid.volume, closed_body(twin).volume, rtol=1e-9)
    assert_allclose(part.solid.area, 2 * part.solid.volume / thickness
                    + (part.drawn.area - 2 * part.drawn.volume / 8) * thickness / 8)  # fmt: skip
    assert_allclose(part.length, 60, rtol=1e-9)
    for own, wanted in zip(part.placed_interfaces, twin.placed_interfaces, strict=True):
        assert_allclose([own.radius, own.length], [wanted.radius, thickness], rtol=1e-9)
        assert_allclose(own.centre, wanted.centre, atol=1e-9)
    assert_allclose(part.stressed_section[0], 24, rtol=1e-9)
    (own,), (wanted,) = part.sections, twin.sections
    assert_allclose(own.inertia_out_of_plane, wanted.inertia_out_of_plane, rtol=1e-3)
    assert_allclose([size.size for size in part.ruling_sections], thickness, rtol=1e-9)
    with gmsh_session() as gmsh:
        body = part.build(gmsh)
        kinds = [gmsh.model.getType(2, face) for faces in body.surfaces.values() for face in faces]
        _, _, low, _, _, high = gmsh.model.getBoundingBox(3, part.solid.tag)
    assert set(kinds) == {"Cylinder"}
    assert_allclose([low, high], [-thickness / 2, thickness / 2], atol=1e-5)


def test_a_plate_that_is_drawn_far_away_is_one(folder):
    """A kilometre off: a file has 15 digits, so 1e-9 of the thickness."""
    (folder / "far").mkdir()
    far = link_part(link_file(folder / "far", moved(AXIS, 1.1, (8e5, -6e5, 0))), thickness=5.0)
    assert_allclose(far.solid.volume, closed_body(replace(LINK, thickness=5)).volume, rtol=1e-6)
    assert_allclose(far._extents[2], 5, rtol=1e-8)


def marked(*sides):
    """Builder: circles of 5 mm are drawn on faces of the plate, which they divide."""

    def build(gmsh):
        occ = gmsh.model.occ
        discs = [occ.addDisk(30, 10, z, 5, 5) for z in sides]
        occ.fragment(occ.getEntities(3), [(2, disc) for disc in discs])

    return build


def test_a_flat_face_in_pieces_is_left_to_the_other_one(folder):
    path = write_step(folder / "marked.step", BLANK, marked(8.0))
    part = StepPart(path, PAIR, thickness=4.0)
    assert_allclose(part.solid.volume, part.drawn.volume / 2, rtol=1e-9)
    path = write_step(folder / "twice.step", BLANK, marked(0.0, 8.0))
    with pytest.raises(ParameterError, match=r"both flat faces are in pieces \(2 and 2\)"):
        StepPart(path, PAIR, thickness=4.0)


def test_another_thickness_is_another_part(file):
    parts = [link_part(file), *(link_part(file, thickness=size) for size in (8.0, 9.0))]
    assert len(set(parts)) == 3
    assert any("it is 9 mm thick along its pins; link.step has 8 mm" in s for s in parts[2].told)


def test_a_file_that_changes_has_no_plate_of_the_one_before(folder):
    path = folder / "changing.step"
    for size in (8, 6):
        write_step(path, plate_with(hole(0, 0, size), hole(60, 0, size)))
        holes = tuple(replace(one, diameter=size) for one in PAIR)
        assert_allclose(StepPart(path, holes, thickness=12.0).bore("a"), size, rtol=1e-9)


@pytest.mark.parametrize("thickness", [0.3, 3.0])
def test_its_mesh_is_carried_over_and_stands_on_its_faces(file, thickness):
    """0.3 and 3 times as thick: the CAD kernel's digits on faces, 1e-3 of the thickness between."""
    part = link_part(file, thickness=8.0)
    mesh, size = mesh_shape(part, fineness=0.3), 8.0 * thickness
    found = Carrier(mesh, part).to(link_part(file, thickness=size))
    flat = np.abs(np.abs(mesh.nodes[:, 2]) - 4.0) < 1e-6
    assert_allclose(np.abs(found.nodes[flat, 2]), size / 2, rtol=0, atol=1e-6)
    for name, x, radius in (("first", 0.0, 5.0), ("second", 60.0, 6.0)):
        bore = found.nodes[np.unique(found.surfaces[name])]
        assert_allclose(np.hypot(bore[:, 0] - x, bore[:, 1]), radius, rtol=0, atol=1e-6)
    assert_allclose(found.nodes[:, 2], thickness * mesh.nodes[:, 2], rtol=0, atol=1e-3 * size)
    assert found.jacobian_minimum > 0
    assert_allclose(found.volume_cad, thickness * mesh.volume_cad, rtol=1e-9)


def test_the_part_as_drawn_takes_no_mesh_of_its_plate(file):
    """Edges of the file and of the extrusion may run in another order."""
    plate = link_part(file, thickness=8.0)
    carrier = Carrier(mesh_shape(plate, fineness=0.3), plate)
    with pytest.raises(MeshError, match="other faces and edges"):
        carrier.to(link_part(file))


def on_edges(change):
    """Builder: a fillet or chamfer of 1 mm along the upper edge at y = -20 mm."""

    def build(gmsh):
        occ = gmsh.model.occ
        occ.synchronize()
        (edge,) = (
            tag
            for _, tag in occ.getEntities(1)
            if np.allclose(gmsh.model.getBoundingBox(1, tag), (-20, -20, 8, 80, -20, 8), atol=1e-3)
        )
        change(occ, edge)

    return build


def pocket(gmsh):
    occ = gmsh.model.occ
    occ.cut(occ.getEntities(3), [(3, occ.addBox(20, -5, 6, 20, 10, 10))])


def slant(gmsh):
    """One side leans by 0.01 deg."""
    occ = gmsh.model.occ
    wedge = occ.addBox(79, -30, -10, 20, 60, 30)
    occ.rotate([(3, wedge)], 79, 0, 0, 0, 1, 0, np.radians(0.01))
    occ.cut(occ.getEntities(3)[:1], [(3, wedge)])


ASKEW = "neither square to the pins nor parallel to them"


@pytest.mark.parametrize(
    ("builders", "said"),
    [
        ((BLANK, on_edges(lambda occ, edge: occ.fillet([1], [edge], [1.0]))), ASKEW),
        ((BLANK, on_edges(lambda occ, edge: occ.chamfer([1], [edge], [4], [1.0]))), ASKEW),
        ((plate_with(hole(0, 0, 10), hole(60, 0, 10), (30, -30, 4, 0, 60, 0, 1)),), ASKEW),
        ((BLANK, slant), ASKEW),
        ((BLANK, pocket), "stand at 3 heights (0, 6, 8 mm), those of a plate at two"),
        ((plate_with(hole(0, 0, 10), hole(60, 0, 10), (30, 0, 4, 0, 0, 9, 3)),), "at 3 heights"),
    ],
    ids=["fillet", "chamfer", "cross hole", "draft", "pocket", "blind hole"],
)
def test_what_is_no_plate_has_no_other_thickness(folder, request, builders, said):
    path = write_step(folder / f"{request.node.callspec.id}.step", *builders)
    StepPart(path, PAIR)
    with pytest.raises(ParameterError) as refused:
        StepPart(path, PAIR, thickness=8.0)
    assert refused.value.field == "thickness"
    assert said in refused.value.problem


def test_a_plate_with_an_outline_of_splines_is_one(folder):
    def build(gmsh):
        occ = gmsh.model.occ
        places = [(-20, 0), (0, -20), (60, -14), (80, 0), (60, 17), (0, 20)]
        points = [occ.addPoint(x, y, 0) for x, y in places]
        loop = occ.addCurveLoop([occ.addBSpline([*points, points[0]])])
        holes = [occ.addCurveLoop([occ.addCircle(x, 0, 0, 5)]) for x in (0, 60)]
        occ.extrude([(2, occ.addPlaneSurface([loop, *holes]))], 0, 0, 8)
        occ.remove(occ.getEntities(2), recursive=False)

    part = StepPart(write_step(folder / "spline.step", build), PAIR, thickness=13.0)
    assert_allclose(part.solid.volume, part.drawn.volume * 13 / 8, rtol=1e-9)


@pytest.mark.parametrize(
    ("values", "field", "said"),
    [
        ({"thickness": 0.0}, "thickness", "must be above 0 mm"),
        ({"thickness": 8000.0}, "thickness", "more than 100 times away from the 8 mm"),
        ({"thickness": 0.079}, "thickness", "is its unit wrong?"),
        ({"thickness": 9.0, "section": (24.0, 8.0)}, "section", "8 mm thick along the pins, but"),
    ],
)
def test_a_thickness_that_cannot_be_meant_is_refused(file, values, field, said):
    with pytest.raises(ParameterError) as refused:
        StepPart(file, HOLES, **values)
    assert refused.value.field == field
    assert said in refused.value.problem
