"""A part from CAD: where it is put, what its holes become, and how like a parametric part it is."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.recovery import von_mises
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import MeshError
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parameters import ParameterError
from geometry.parts.step_part import NamedHole, StepPart

from ..fem.blocks import BAR
from .step_files import HOLES, LINK, hole, link_file, link_part, moved, plate_with, write_step

STEEL = Elastic(210_000.0, 0.3, 7.85e-9)
AXIS = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("step")


@pytest.fixture(scope="module")
def link(folder):
    return link_part(link_file(folder))


@pytest.fixture(scope="module")
def turned(folder):
    """The same part, drawn somewhere else: turned by 1.1 rad about a skew axis."""
    (folder / "turned").mkdir()
    return link_part(link_file(folder / "turned", moved(AXIS, 1.1, (100, -200, 30))))


def solved(shape, fineness):
    return solve_unit_loads(mesh_shape(shape, fineness=fineness), STEEL)


def pulled(solutions, names):
    """Lengthening and peak von Mises stress under 1 kN that pulls the holes apart, mm and MPa."""
    wrenches = {name: np.zeros((1, 6)) for name in names}
    wrenches[names[0]][0, 0], wrenches[names[1]][0, 0] = -1000.0, 1000.0
    coefficients, _ = solutions.coefficients(wrenches, np.zeros((1, 4)))
    force, moved_by = solutions.loads @ coefficients, solutions.displacement @ coefficients
    stress = (solutions.basis @ coefficients)[..., 0]
    return float(force[:, 0] @ moved_by[:, 0]) / 1000.0, float(von_mises(stress).max())


def test_a_part_from_cad_stands_where_the_parametric_one_stands(link):
    """The CAD kernel's round-off; mass by the mesh, whose facets leave out up to 1e-3."""
    own, parametric = mesh_shape(link, fineness=0.5), mesh_shape(LINK, fineness=0.5)
    assert_allclose(own.volume_cad, parametric.volume_cad, rtol=1e-12)
    for name, wanted in parametric.interfaces.items():
        found = own.interfaces[name]
        assert (found.kind, found.tilts) == (wanted.kind, wanted.tilts)
        assert_allclose(found.centre, wanted.centre, atol=1e-9)
        assert_allclose([found.radius, found.length], [wanted.radius, wanted.length], rtol=1e-9)
        points = own.nodes[own.surfaces[name]].reshape(-1, 3) - found.centre
        assert_allclose(np.hypot(points[:, 0], points[:, 1]), found.radius, rtol=1e-2)
        assert_allclose(np.ptp(points[:, 2]), 8, rtol=1e-9)
    masses = [mesh.mass_properties(STEEL.density) for mesh in (own, parametric)]
    assert_allclose(masses[0].mass, masses[1].mass, rtol=1e-3)
    assert_allclose(masses[0].centre, masses[1].centre, atol=0.01)
    assert_allclose(masses[0].inertia, masses[1].inertia, rtol=1e-3)
    assert link.interfaces == ("first", "second")
    assert_allclose(link.length, 60, rtol=1e-12)


@pytest.mark.slow
def test_a_part_from_cad_gives_way_and_is_stressed_as_the_parametric_one(link):
    """Other elements, so the mesh's error is left: lengthening 0.2 %, stress 2 %."""
    parametric = pulled(solved(LINK, 1.0), LINK.interfaces)
    own = pulled(solved(link, 1.0), link.interfaces)
    assert_allclose(own[0], parametric[0], rtol=2e-3)
    assert_allclose(own[1], parametric[1], rtol=2e-2)


def test_where_and_how_the_part_was_drawn_does_not_matter(link, turned):
    """Round-off of the drawing; the mesher follows its last bits, so the meshes differ a little."""
    assert_allclose(turned.length, 60, rtol=1e-9)
    assert_allclose(turned.centre("second"), [60, 0, 0], atol=1e-9)
    assert_allclose(turned.stressed_section, link.stressed_section, rtol=1e-9)
    here, there = (solved(part, 0.7) for part in (link, turned))  # both by HXT
    masses = [s.mesh.mass_properties(STEEL.density) for s in (here, there)]
    assert_allclose(masses[1].mass, masses[0].mass, rtol=1e-5)
    assert_allclose(masses[1].centre, masses[0].centre, atol=1e-3)
    own, other = pulled(here, link.interfaces), pulled(there, link.interfaces)
    assert_allclose(other[0], own[0], rtol=1e-3)
    assert_allclose(other[1], own[1], rtol=2e-2)


def three_holes(folder, name="three.step"):
    path = folder / name
    if not path.exists():
        write_step(path, plate_with(hole(0, 0, 10), hole(60, 0, 10), hole(40, 10, 6)))
    return path


PAIR = (NamedHole("a", 10, at=(0, 0, 0)), NamedHole("b", 10, at=(60, 0, 5)))
THIRD = NamedHole("c", 6)


def test_a_point_of_its_axis_says_which_of_equal_holes_is_meant(folder):
    part = StepPart(three_holes(folder), (*PAIR, THIRD))
    assert_allclose(part.centre("b"), [60, 0, 0], atol=1e-9)
    assert_allclose(part.centre("c"), [40, 10, 0], atol=1e-9)
    swapped = StepPart(three_holes(folder), (*PAIR[::-1], THIRD))
    assert_allclose(swapped.centre("c"), [20, -10, 0], atol=1e-9)


def test_a_flipped_part_has_its_other_side_up(folder):
    part = StepPart(three_holes(folder), (*PAIR, THIRD), flip=True)
    assert_allclose(part.centre("b"), [60, 0, 0], atol=1e-9)
    assert_allclose(part.centre("c"), [40, -10, 0], atol=1e-9)
    assert_allclose(part.axes[2], [0, 0, -1], atol=1e-12)
    nodes = mesh_shape(part, fineness=0.4).nodes
    assert_allclose([nodes[:, 1].min(), nodes[:, 1].max()], [-20, 20], atol=1e-9)
    assert_allclose([nodes[:, 0].min(), nodes[:, 0].max()], [-20, 80], atol=1e-9)


def test_a_hole_beside_the_plane_of_the_first_keeps_its_height(folder):
    """An 8 mm plate on which the second hole goes through a pad too, 8 + 12 mm: 6 mm higher."""

    def pad(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -20, 0, 100, 40, 8)
        occ.fuse([(3, 1)], [(3, occ.addCylinder(60, 0, 8, 0, 0, 12, 15))])
        occ.cut([(3, 1)], [(3, occ.addCylinder(x, 0, -1, 0, 0, 30, 5)) for x in (0, 60)])

    part = StepPart(write_step(folder / "pad.step", pad), PAIR)
    assert part.heights == pytest.approx({"a": 0, "b": 6}, abs=1e-9)
    assert any("the middle of b is 6 mm out of the plane of a's" in said for said in part.told)
    volumes = 100 * 40 * 8, np.pi * 15**2 * 12, -np.pi * 25 * 8, -np.pi * 25 * 20
    lever = np.dot(volumes, [0, 10, 0, 6]) / sum(volumes)
    assert any(f"centre of mass is {lever:.3g} mm out" in said for said in part.told)
    mesh = mesh_shape(part, fineness=0.3)
    assert_allclose(mesh.interfaces["b"].centre, [60, 0, 6], atol=1e-9)
    assert_allclose(mesh.mass_properties(1.0).centre[2], lever, rtol=5e-3)


def test_a_boss_can_be_named_as_a_journal(folder):
    def pegs(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -20, 0, 100, 40, 8)
        occ.fuse([(3, 1)], [(3, occ.addCylinder(x, 0, 8, 0, 0, 12, 5)) for x in (0, 60)])

    path = write_step(folder / "pegs.step", pegs)
    with pytest.raises(ParameterError, match="no bore of 10 mm"):
        StepPart(path, PAIR)
    named = tuple(NamedHole(h.name, 10, h.at, kind="journal") for h in PAIR)
    mesh = mesh_shape(StepPart(path, named), fineness=0.2)
    assert {i.kind for i in mesh.interfaces.values()} == {"journal"}
    assert_allclose(mesh.interfaces["b"].centre, [60, 0, 0], atol=1e-9)
    assert_allclose(mesh.nodes[:, 2].min(), -14, atol=1e-9)


def test_a_shank_between_thin_eyes_is_as_thick_as_itself(folder):
    """30 x 30 mm over 40 mm between eyes of 6: its section is 4 A/P = 30 mm, 4 V/A is 18."""

    def thick(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -15, -3, 160, 30, 6)
        occ.fuse([(3, 1)], [(3, occ.addBox(40, -15, -15, 40, 30, 30))])
        occ.cut([(3, 1)], [(3, occ.addCylinder(x, 0, -4, 0, 0, 8, 5)) for x in (0, 120)])

    part = StepPart(
        write_step(folder / "thick.step", thick),
        (NamedHole("a", 10, (0, 0, 0)), NamedHole("b", 10, (120, 0, 0))),
    )
    assert 2 * part.solid.wall < 25
    assert part.stressed_section[1] == pytest.approx(30, rel=1e-6)


def test_the_section_is_estimated_from_the_body_unless_it_is_stated(monkeypatch, link):
    """24 x 8 mm: 4 V/A is 9.9 mm, more than the plate is thick."""
    assert_allclose(link.stressed_section, (24, 8), rtol=1e-9)
    assert any("is 24 x 8 mm: the solid's height" in said for said in link.told)
    uncut = replace(link)

    def gives_up(_shape):
        raise MeshError("not closed")

    monkeypatch.setattr("geometry.parts.step_part.bar_slices", gives_up)
    assert_allclose(uncut.stressed_section, (24, 8), rtol=1e-9)
    assert any("its whole thickness, as it could not be cut: not closed" in t for t in uncut.told)
    stated = link_part(link.path, section=(24.0, 7.0))
    assert stated.stressed_section == (24, 7)
    assert not any("size factor" in said for said in stated.told)


def test_strengths_are_those_of_a_shank_thicker_than_its_eyes(folder):
    """A bar of 30 mm between eyes of 8 mm had those of 8 mm; 4 V/A is that of both together."""

    def rod(gmsh):
        occ = gmsh.model.occ
        eyes = [(3, occ.addBox(x - 15, -15, -4, 30, 30, 8)) for x in (0, 160)]
        occ.fuse([(3, occ.addCylinder(15, 0, 0, 130, 0, 0, 15))], eyes)
        holes = [(3, occ.addCylinder(x, 0, -5, 0, 0, 10, 5)) for x in (0, 160)]
        occ.cut(occ.getEntities(3), holes)

    near, far = (NamedHole(name, 10, (x, 0, 0)) for name, x in (("a", 0), ("b", 160)))
    part = StepPart(write_step(folder / "shank.step", rod), (near, far))
    assert_allclose([one.size for one in part.ruling_sections[:2]], 8, rtol=1e-9)
    assert 16 < part.ruling_sections[2].size < 30


def test_elements_are_small_at_named_holes_and_in_hollow_fillets(folder):
    """An angle of 10 mm plates with 2 mm in its corner: elements there of 2 / 1.5 mm or less."""

    def angle(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -20, 0, 100, 40, 10)
        occ.fuse([(3, 1)], [(3, occ.addBox(30, -20, 10, 10, 40, 40))])
        occ.cut([(3, 1)], [(3, occ.addCylinder(x, 0, -1, 0, 0, 30, 5)) for x in (0, 60)])
        occ.synchronize()
        inner = [
            tag
            for _, tag in occ.getEntities(1)
            if np.allclose(gmsh.model.getBoundingBox(1, tag), (30, -20, 10, 30, 20, 10), atol=1e-3)
        ]
        occ.fillet([1], inner, [2.0])

    part = StepPart(write_step(folder / "angle.step", angle), PAIR)
    with gmsh_session() as gmsh:
        body = part.build(gmsh)
    assert [region.size for region in body.regions] == pytest.approx(
        [5 / 9, 5 / 9, 2 / 1.5], rel=1e-3
    )
    assert 10 * 2 / 3 < body.size < 10, "the walls have 10 mm, and rims"
    mesh = mesh_shape(part, fineness=0.6)
    corners = mesh.nodes[mesh.elements[:, :4]]
    middles, lengths = corners.mean(axis=1), np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)
    # the fillet's axis stands at x = 28, 7 mm above the plate's middle
    near = np.hypot(middles[:, 0] - 28, middles[:, 2] - 7) < 3
    assert lengths[near].mean() < 3
    assert lengths[middles[:, 2] > 20].mean() > 8


def test_a_straight_bar_has_the_sections_of_its_parametric_twin_as_a_column(link, turned):
    (own,) = LINK.sections
    for part, within in ((link, 1e-6), (turned, 1e-3)):
        (found,) = part.sections
        names = ("area", "inertia_in_plane", "inertia_out_of_plane", "depth_in_plane",
                 "depth_out_of_plane")  # fmt: skip
        assert_allclose([getattr(found, name) for name in names],
                        [getattr(own, name) for name in names], rtol=within)  # fmt: skip
        assert found.stretch == pytest.approx((0.0, 60.0))


def test_a_stepped_bar_has_a_stretch_for_each_section(folder):
    """8 mm high from x = 20 to 40 mm, 40 mm elsewhere; 8 mm thick; pins at 0 and 60 mm."""

    def build(gmsh):
        plate_with(hole(0, 0, 10), hole(60, 0, 10))(gmsh)
        occ, bars = gmsh.model.occ, gmsh.model.occ.getEntities(3)
        occ.cut(bars, [(3, occ.addBox(20, y, -1, 20, 26, 10)) for y in (4, -30)])

    holes = (NamedHole("a", 10, (0, 0, 4)), NamedHole("b", 10, (60, 0, 4)))
    part = StepPart(write_step(folder / "stepped.step", build), holes)
    found = part.sections
    assert_allclose([one.stretch for one in found], [(0, 20), (20, 40), (40, 60)], atol=0.5)
    assert_allclose([one.area for one in found], [320, 64, 320], rtol=1e-6)
    assert_allclose([one.inertia_in_plane for one in found],
                    [8 * 40**3 / 12, 8 * 8**3 / 12, 8 * 40**3 / 12], rtol=1e-6)  # fmt: skip


def _box(*corner_and_size):
    def build(gmsh):
        occ, parts = gmsh.model.occ, gmsh.model.occ.getEntities(3)
        occ.cut(parts, [(3, occ.addBox(*corner_and_size))])

    return build


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (_box(-30, 16, -1, 120, 20, 10), "2 mm beside the line of its holes"),
        (_box(-30, 8, -1, 120, 20, 10), "a hole with one thin side"),
        (_box(20, -5, -1, 20, 10, 10), "of several bodies"),
    ],
)
def test_a_part_that_is_no_straight_bar_says_why_it_is_no_column(folder, change, why):
    holes = (NamedHole("a", 10, (0, 0, 4)), NamedHole("b", 10, (60, 0, 4)))
    bar = plate_with(hole(0, 0, 10), hole(60, 0, 10), size=(100, 40, 8))
    part = StepPart(write_step(folder / f"{why.split()[-1]}.step", bar, change), holes)
    assert not part.sections
    assert any("yield was not checked" in said and why in said for said in part.told)


def test_a_bar_with_cheeks_is_no_column_of_its_tube_alone(folder):
    holes = [NamedHole(name, BAR.hole) for name in BAR.interfaces]
    holes = [replace(one, at=(x, 0, 0)) for one, x in zip(holes, (0, BAR.length), strict=True)]
    part = StepPart(write_step(folder / "bar.step", BAR.build), tuple(holes))
    assert not part.sections
    assert any("forks" in said for said in part.told)
    bore = part.placed_interfaces[0]
    assert_allclose((bore.length, bore.piece), (2 * BAR.wall, BAR.wall))


def test_equal_files_are_the_same_part_wherever_they_lie(folder, link):
    copy = folder / "copy.step"
    shutil.copy(link.path, copy)
    same, other = link_part(copy), link_part(link.path, flip=True)
    assert (same == link, hash(same) == hash(link)) == (True, True)
    assert other != link
    copy.write_text(copy.read_text() + "\n")
    assert link_part(copy) != link


def test_a_file_that_changes_after_it_was_read_is_not_meshed(folder):
    path = folder / "changing.step"
    shutil.copy(link_file(folder), path)
    part = link_part(path)
    path.write_text(path.read_text() + "\n")
    with pytest.raises(MeshError, match=r"changing.step has changed since it was first read"):
        mesh_shape(part)


def test_the_linkage_may_differ_from_the_file_by_the_tolerance(folder, link):
    part = link_part(link.path, places=((0, 0), (60.04, 0)))
    assert part.shifts == {"first": (0, 0), "second": pytest.approx((-0.04, 0))}
    assert any("second is 0.04 mm from where the linkage has it" in said for said in part.told)
    with pytest.raises(ParameterError) as refused:
        link_part(link.path, places=((0, 0), (60.06, 0)))
    assert (refused.value.field, refused.value.problem) == (
        "holes.second",
        "is 60 mm from first in link.step and 60.06 mm in the linkage, more than 0.05 mm apart",
    )
    link_part(link.path, places=((0, 0), (60.06, 0)), tolerance=0.1)


def test_a_distance_in_another_unit_is_asked_about(link):
    with pytest.raises(ParameterError, match="10 times apart: were centimetres and mm mixed up"):
        link_part(link.path, places=((0, 0), (6, 0)))


def test_a_third_hole_on_the_wrong_side_is_told_how_to_get_there(folder):
    places = ((0.0, 0.0), (60.0, 0.0), (40.0, -10.0))
    holes = (*PAIR, THIRD)
    said = (
        "is at (40, 10) mm in three.step and at (40, -10) mm in the linkage, from a with x towards "
        "b; flip = true puts it there"
    )
    with pytest.raises(ParameterError, match=re.escape(said)):
        StepPart(three_holes(folder), holes, places)
    part = StepPart(three_holes(folder), holes, places, flip=True)
    assert_allclose(part.shifts["c"], (0, 0), atol=1e-9)
    with pytest.raises(ParameterError, match=r"towards b$"):
        StepPart(three_holes(folder), holes, (*places[:2], (41.0, -10.0)))


FOUND = (
    "there are bore of 6 mm through (40, 10, 4) mm along (0, 0, 1), 8 mm long; bore of 10 mm "
    "through (0, 0, 4) mm along (0, 0, 1), 8 mm long; bore of 10 mm through (60, 0, 4) mm along "
    "(0, 0, 1), 8 mm long"
)


@pytest.mark.parametrize(
    ("holes", "field", "said"),
    [
        (
            (NamedHole("a", 10), PAIR[1]),
            "holes.a",
            "2 holes of three.step are a bore of 10 mm: `at` must say which, by a point of its "
            "axis in the file's frame; " + FOUND,
        ),
        (
            (PAIR[0], NamedHole("b", 12)),
            "holes.b",
            "no bore of 12 mm is in three.step within 0.05 mm; " + FOUND,
        ),
        (
            (PAIR[0], NamedHole("b", 10, at=(60, 0.06, 0))),
            "holes.b",
            "no bore of 10 mm through (60, 0.06, 0) mm is in three.step within 0.05 mm; " + FOUND,
        ),
        (
            (PAIR[0], NamedHole("b", 254.0)),
            "holes.b",
            "no bore of 254 mm is in three.step within 0.05 mm; 25.4 times apart: were inches "
            "and mm mixed up?; " + FOUND,
        ),
        (
            (PAIR[0], NamedHole("b", 10, at=(0, 0, 3))),
            "holes.b",
            "is the same hole as a: bore of 10 mm through (0, 0, 4) mm along (0, 0, 1), 8 mm long; "
            + FOUND,
        ),
        ((PAIR[0],), "holes", "needs at least two holes, got 1"),
        ((PAIR[0], PAIR[0]), "holes", "two have the same name among a, a"),
    ],
)
def test_holes_that_cannot_be_meant_are_refused_with_what_there_is(folder, holes, field, said):
    with pytest.raises(ParameterError) as refused:
        StepPart(three_holes(folder), holes)
    assert (refused.value.field, refused.value.problem) == (field, said)


def test_a_hole_that_does_not_go_round_is_named_as_such(folder):
    """An edge of the plate cuts the hole of 16 mm at 120 deg to both sides of its middle."""
    path = write_step(folder / "edge.step", plate_with(hole(0, 0, 10), hole(60, 16, 16)))
    with pytest.raises(ParameterError, match="only a bore of 16 mm that goes 240 deg round"):
        StepPart(path, (NamedHole("a", 10), NamedHole("b", 16)))


def test_a_hole_that_something_cuts_into_is_refused(folder):
    cut = (0, -30, 4, 0, 30, 0, 1.5)
    path = write_step(folder / "oil.step", plate_with(hole(0, 0, 10), hole(60, 0, 12), cut))
    with pytest.raises(ParameterError, match=r"something cuts into the bore of 10 mm .* keyway"):
        StepPart(path, (NamedHole("a", 10), NamedHole("b", 12)))


@pytest.mark.parametrize(("degrees", "fits"), [(0.09, True), (0.2, False)])
def test_holes_are_parallel_within_a_tenth_of_a_degree(folder, degrees, fits):
    tilt = np.tan(np.radians(degrees))
    skew = (60 - tilt * 5, 0, -1, 10 * tilt, 0, 10, 6)
    path = write_step(folder / f"skew{degrees}.step", plate_with(hole(0, 0, 10), skew))
    holes = (NamedHole("a", 10), NamedHole("b", 12))
    if fits:
        assert_allclose(StepPart(path, holes).length, 60, atol=1e-2)
        return
    with pytest.raises(ParameterError, match=r"stands at 0.2 deg to a: the pins of a plane"):
        StepPart(path, holes)


def test_two_holes_on_one_axis_make_no_frame(folder):
    stepped = [hole(0, 0, 10), (0, 0, 4, 0, 0, 10, 8)]
    path = write_step(folder / "stepped.step", plate_with(*stepped))
    with pytest.raises(ParameterError, match="has the same axis as a: there is no x axis"):
        StepPart(path, (NamedHole("a", 10), NamedHole("b", 16)))


def test_sizes_that_are_none_are_refused(link):
    for change, field in (
        ({"tolerance": 0.0}, "hole_tolerance"),
        ({"section": (24.0, 0.0)}, "section"),
    ):
        with pytest.raises(ParameterError) as refused:
            link_part(link.path, **change)
        assert refused.value.field == field
    with pytest.raises(ParameterError, match=r"holes.a.diameter: must be above 0 mm"):
        NamedHole("a", 0.0)
    with pytest.raises(ParameterError, match="must be bore or journal, got 'hub'"):
        NamedHole("a", 1.0, kind="hub")
    with pytest.raises(ValueError, match="2 holes need as many places"):
        StepPart(link.path, HOLES, ((0, 0),))
