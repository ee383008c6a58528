"""Survey of a STEP file: one solid in mm, its holes and journals, or a refusal."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.meshing import gmsh_session
from geometry.parameters import ParameterError
from geometry.parts import ToggleBar
from geometry.step_file import file_hash, import_solid, survey_step

from .step_files import (
    hole,
    in_inches,
    in_metres,
    link_file,
    plate_with,
    scaled_link,
    write_step,
)

_EMPTY = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
# stadium of 60 x 24 mm between the arcs' middles, less the two holes, 8 mm thick
VOLUME = 8 * (60 * 24 + np.pi * 12**2 - np.pi * (5**2 + 6**2))
BAR = ToggleBar(
    length=60,
    width=40,
    wall=6,
    hole=16,
    overhang=16,
    inner_radius=2,
    cutout_length=22,
    cutout_corner=3,
)


def box(gmsh):
    gmsh.model.occ.addBox(0, 0, 0, 10, 20, 30)


def test_a_plate_has_the_volume_surface_and_holes_that_it_was_drawn_with(tmp_path):
    """Closed form; the CAD kernel integrates exactly on planes and cylinders: round-off."""
    solid = survey_step(link_file(tmp_path))
    area = 2 * VOLUME / 8 + 8 * (2 * 60 + 2 * np.pi * (12 + 5 + 6))
    assert_allclose([solid.volume, solid.area], [VOLUME, area], rtol=1e-9)
    assert_allclose(solid.wall, 2 * VOLUME / area, rtol=1e-9)
    first, second = solid.holes
    assert_allclose([first.diameter, first.length, second.diameter], [10, 8, 12], rtol=1e-9)
    assert_allclose([first.centre, second.centre], [[0, 0, 0], [60, 0, 0]], atol=1e-9)
    assert_allclose([first.direction, second.direction], [[0, 0, 1]] * 2, atol=1e-9)
    assert (first.kind, second.kind, first.plain, second.plain) == ("bore", "bore", True, True)
    assert set(solid.partial) == {"journal of 24 mm that goes 180 deg round"}, "the round ends"


@pytest.mark.parametrize(("unit", "factor"), [(in_inches, 25.4), (in_metres, 1000.0)])
def test_a_file_in_another_unit_comes_out_in_millimetres(tmp_path, unit, factor):
    """The same part, drawn in inches or metres: round-off of the scaling, 1e-9."""
    solid = survey_step(unit(write_step(tmp_path / "link.step", scaled_link(1 / factor))))
    assert_allclose(solid.volume, VOLUME, rtol=1e-9)
    assert_allclose([h.diameter for h in solid.holes], [10, 12], rtol=1e-9)
    assert_allclose(solid.holes[1].centre, [60, 0, 0], atol=1e-6)


def test_two_cheeks_are_one_hole_with_the_length_of_both(tmp_path):
    solid = survey_step(write_step(tmp_path / "bar.step", BAR.build))
    assert_allclose([h.length for h in solid.holes], [12, 12], rtol=1e-9)
    assert_allclose([h.centre for h in solid.holes], [[0, 0, 0], [60, 0, 0]], atol=1e-9)
    assert [len(h.faces) for h in solid.holes] == [2, 2]


def test_a_hole_of_two_half_shells_is_one_hole(tmp_path):
    def build(gmsh):
        occ = gmsh.model.occ
        halves = [(3, occ.addBox(-20, y, 0, 80, 20, 8)) for y in (-20, 0)]
        occ.cut(halves, [(3, occ.addCylinder(*hole(0, 0, 12)))])
        occ.fragment([halves[0]], [halves[1]])
        occ.fuse([halves[0]], [halves[1]])

    (found,) = survey_step(write_step(tmp_path / "halves.step", build)).holes
    assert found.plain
    assert_allclose([found.diameter, found.length], [12, 8], rtol=1e-9)


def test_the_round_ends_of_a_slot_are_no_holes(tmp_path):
    def build(gmsh):
        occ = gmsh.model.occ
        plate = occ.addBox(-20, -20, 0, 80, 40, 8)
        ends = [(3, occ.addCylinder(*hole(x, 0, 12))) for x in (0, 20)]
        occ.cut([(3, plate)], [*ends, (3, occ.addBox(0, -6, -1, 20, 12, 10))])

    solid = survey_step(write_step(tmp_path / "slot.step", build))
    assert solid.holes == ()
    assert solid.partial == ("bore of 12 mm that goes 180 deg round",) * 2


def test_a_boss_is_a_journal_and_the_fillet_at_its_foot_is_hollow(tmp_path):
    """A boss of 12 mm on a plate, 20 mm high; the fillet of 2 mm takes the lowest 2 mm."""

    def build(gmsh):
        occ = gmsh.model.occ
        plate = occ.addBox(-20, -20, 0, 40, 40, 8)
        joined, _ = occ.fuse([(3, plate)], [(3, occ.addCylinder(0, 0, 8, 0, 0, 20, 6))])
        occ.synchronize()
        boxes = {tag: gmsh.model.getBoundingBox(1, tag) for _, tag in occ.getEntities(1)}
        foot = [
            tag
            for tag, found in boxes.items()
            if gmsh.model.getType(1, tag) == "Circle" and abs(found[5] - 8) < 1e-3
        ]
        occ.fillet([joined[0][1]], foot, [2.0])

    solid = survey_step(write_step(tmp_path / "boss.step", build))
    (boss,) = solid.holes
    assert boss.kind == "journal"
    assert_allclose([boss.diameter, boss.length, *boss.centre], [12, 18, 0, 0, 19], atol=1e-9)
    (fillet,) = solid.curved
    assert fillet.concave
    assert_allclose(fillet.radius, 2, rtol=1e-9)


def test_holes_of_spline_surfaces_are_found_too(tmp_path):
    """Rational B-splines are exact cylinders: round-off."""

    def as_splines(gmsh):
        gmsh.model.occ.convertToNURBS(gmsh.model.occ.getEntities(3))

    path = link_file(tmp_path, as_splines)
    assert "CYLINDRICAL_SURFACE" not in path.read_text()
    first, second = survey_step(path).holes
    assert_allclose([first.diameter, second.diameter, first.length], [10, 12, 8], rtol=1e-9)
    assert first.plain


@pytest.mark.parametrize(
    ("cut", "plain"),
    [
        ((0, -30, 4, 0, 25.5, 0, 1.5), False),  # ends 0.5 mm inside the hole's wall
        ((0, -30, 4, 0, 20, 0, 1.5), True),  # ends in the material
    ],
)
def test_a_hole_into_which_another_runs_is_not_plain(tmp_path, cut, plain):
    path = write_step(tmp_path / "cross.step", plate_with(hole(0, 0, 10), cut))
    found = {round(h.diameter): h for h in survey_step(path).holes}
    assert found[10].plain is plain


def test_a_keyway_leaves_a_hole_that_is_not_plain(tmp_path):
    """1 mm wide in a circle of 20 mm: 5.7 deg are missing, so it still goes all the way round."""

    def keyway(gmsh):
        occ = gmsh.model.occ
        occ.cut([(3, 1)], [(3, occ.addBox(0, -0.5, -1, 12, 1, 10))])

    (found,) = survey_step(
        write_step(tmp_path / "key.step", plate_with(hole(0, 0, 20)), keyway)
    ).holes
    assert not found.plain


def loose_ends(gmsh):
    occ = gmsh.model.occ
    occ.addDisk(50, 0, 0, 3, 3)
    occ.addLine(occ.addPoint(0, 0, 99), occ.addPoint(1, 0, 99))


def test_what_does_not_belong_to_the_solid_is_told_and_left_out(tmp_path):
    path = write_step(tmp_path / "loose.step", box, loose_ends)
    solid = survey_step(path)
    assert solid.told == ("loose.step also has 1 loose face and 1 loose curve, which are left out",)
    with gmsh_session() as gmsh:
        import_solid(gmsh, path)
        assert [len(gmsh.model.getEntities(d)) for d in range(4)] == [8, 12, 6, 1]
    assert survey_step(write_step(tmp_path / "box.step", box)).told == ()


def surfaces_only(gmsh):
    gmsh.model.occ.addDisk(0, 0, 0, 3, 3)


def two_boxes(gmsh):
    box(gmsh)
    gmsh.model.occ.addBox(50, 0, 0, 10, 10, 10)


def bow_tie(gmsh):
    occ = gmsh.model.occ
    corners = [occ.addPoint(*p) for p in [(0, 0, 0), (10, 10, 0), (10, 0, 0), (0, 10, 0)]]
    lines = [occ.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, 0, 5)


def cavity_through_the_wall(gmsh):
    """A box with a hollow inside that sticks out of its wall."""
    occ = gmsh.model.occ
    occ.addBox(0, 0, 0, 10, 10, 10)
    occ.addBox(5, 3, 3, 10, 4, 4)
    faces = [tag for _, tag in occ.getEntities(2)]
    occ.addVolume([occ.addSurfaceLoop(faces[:6]), occ.addSurfaceLoop(faces[6:])])
    occ.remove([(3, 1), (3, 2)])


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (surfaces_only, "'part.step' has no solid, only 1 face; close the part in CAD"),
        (two_boxes, "has 2 solids of 6 cm3, 1 cm3, a part is one; export the part alone"),
        (bow_tie, "has a solid without a volume: its faces cross; repair it in CAD"),
        (cavity_through_the_wall, "crosses itself: 5 faces cut by others, about (10, 5, 5)"),
    ],
)
def test_a_file_without_one_valid_solid_is_refused(tmp_path, build, said):
    with pytest.raises(ParameterError, match=re.escape(said)) as refused:
        survey_step(write_step(tmp_path / "part.step", build))
    assert refused.value.field == "shape"


def test_a_shell_with_a_missing_face_is_no_solid(tmp_path):
    path = write_step(tmp_path / "open.step", box)
    text = path.read_text()
    (faces,) = re.findall(r"CLOSED_SHELL\('',\(([^)]*)\)\)", text)
    path.write_text(text.replace(faces, faces.rpartition(",")[0]))
    with pytest.raises(ParameterError, match="has no solid, only 5 faces"):
        survey_step(path)


def test_a_file_that_is_no_step_file_is_refused_without_a_word_on_standard_output(tmp_path, capfd):
    path = tmp_path / "part.step"
    for content, said in (
        ("solid stl", "'part.step' is no STEP file, which would begin with 'ISO-10303-21;'"),
        (link_file(tmp_path).read_text()[:9000], "is damaged or cut off; export it from CAD again"),
        (_EMPTY, "has no geometry"),
    ):
        path.write_text(content)
        capfd.readouterr()
        with pytest.raises(ParameterError, match=said):
            survey_step(path)
        assert capfd.readouterr().out == ""


def test_a_file_that_cannot_be_opened_is_refused(tmp_path):
    for look in (file_hash, survey_step):
        with pytest.raises(ParameterError, match=r"'none.step' cannot be read: no such file"):
            look(tmp_path / "none.step")


def test_where_crossing_faces_cannot_be_looked_for_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("geometry.step_file._MOST_FACES", 5)
    solid = survey_step(write_step(tmp_path / "box.step", box))
    assert solid.told == (
        "whether faces of box.step cross was not found out: it has 6 faces; a mesh could not be "
        "made if they did",
    )
