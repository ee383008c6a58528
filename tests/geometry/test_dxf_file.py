"""Ten drawings that are read, and broken ones that are refused with the entity and its place."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.drawings import DrawingError
from geometry.dxf_file import read_dxf

from .drawn_plates import drawing, stadium_with_holes

LINK = 100 * 40 + math.pi * (20**2 - 6**2 - 8**2)  # mm2


def outline(file, **how):
    return read_dxf(file, **how).drawn.outline


def test_a_polyline_with_bulges_and_circles(tmp_path):
    found = read_dxf(stadium_with_holes(tmp_path / "link.dxf"))
    assert_allclose(found.drawn.outline.moments.area, LINK, rtol=1e-9)
    assert found.told == ("drawn in mm, by its header", "3 contours of 3 entities")


def test_inches(tmp_path):
    file = stadium_with_holes(tmp_path / "link.dxf", scale=25.4, units=1)
    assert_allclose(outline(file).moments.area, LINK, rtol=1e-9)


def test_a_unit_that_the_file_does_not_state(tmp_path):
    file = stadium_with_holes(tmp_path / "link.dxf", units=0)
    with pytest.raises(DrawingError, match=r"no unit that is read \(\$INSUNITS = 0\).*mm, cm, m"):
        read_dxf(file)
    assert_allclose(outline(file, unit="cm").moments.area, 100 * LINK, rtol=1e-9)
    stated = stadium_with_holes(tmp_path / "other.dxf")
    with pytest.raises(DrawingError, match=r"drawn in mm by its header .* and in in by `unit`"):
        read_dxf(stated, unit="in")


def test_lines_and_arcs_in_any_order_and_sense(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf")
    space.add_line((100, 20), (0, 20))
    space.add_arc((0, 0), 20, 90, 270)
    space.add_line((100, -20), (0, -20))  # drawn back
    space.add_arc((100, 0), 20, 270, 90)
    assert_allclose(outline(saved()).moments.area, 4000 + math.pi * 400, rtol=1e-9)


def test_an_inner_contour_of_lines_and_a_slot(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf")
    space.add_lwpolyline([(0, 0), (200, 0), (200, 80), (0, 80)], close=True)
    space.add_lwpolyline([(20, 20), (60, 20), (60, 60), (20, 60), (20, 20)])  # closed by its ends
    slot = [(100, 30, 0), (160, 30, 1), (160, 50, 0), (100, 50, 1)]
    space.add_lwpolyline(slot, format="xyb", close=True)
    found = outline(saved())
    assert_allclose(found.moments.area, 16000 - 1600 - (60 * 20 + math.pi * 100), rtol=1e-9)
    assert len(found.inner) == 2


def test_splines_within_their_tolerance(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf")
    # a Bezier curve whose area over its chord is 3/20 (2 x1 (..)): here (0,0) (0,60) (90,60) (90,0)
    space.add_open_spline([(0, 0), (0, 60), (90, 60), (90, 0)], degree=3)
    space.add_line((90, 0), (0, 0))
    # the curve is y = 180 u (1 - u), x = 90 (3 u^2 - 2 u^3): its area is 90 x 180 x 6/30
    found = outline(saved())
    assert_allclose(found.moments.area, 90 * 180 * 6 / 30, rtol=2e-5)
    assert len(found.outer.corners) < 40


def test_an_ellipse_and_an_arc_of_one(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf")
    space.add_ellipse((0, 0), (0, 50), 0.5)
    space.add_ellipse((0, 0), (12, 0), 0.75, 0, math.pi)
    space.add_line((-12, 0), (12, 0))
    area = math.pi * 50 * 25 - math.pi * 12 * 9 / 2
    assert_allclose(outline(saved()).moments.area, area, rtol=2e-5)


def test_blocks_turned_scaled_and_within_blocks(tmp_path):
    document, space, saved = drawing(tmp_path / "a.dxf", HOLES={})
    hole = document.blocks.new("HOLE")
    hole.add_circle((0, 0), 5)
    pair = document.blocks.new("PAIR")
    pair.add_blockref("HOLE", (0, 0))
    pair.add_blockref("HOLE", (30, 0), dxfattribs={"xscale": 2, "yscale": 2})
    space.add_lwpolyline([(0, 0), (200, 0), (200, 90), (0, 90)], close=True)
    space.add_blockref("PAIR", (100, 40), dxfattribs={"rotation": 90, "layer": "HOLES"})
    found = read_dxf(saved()).drawn
    circles = sorted(contour.circle[1] for contour in found.outline.inner)
    assert_allclose(circles, [5, 10])
    large = max(found.outline.inner, key=lambda contour: contour.circle[1])
    assert_allclose(large.circle[0], 100 + 70j, atol=1e-9)
    assert found.layers == ("0", "HOLES", "HOLES")


def test_a_mirrored_block_keeps_its_arcs(tmp_path):
    document, space, saved = drawing(tmp_path / "a.dxf")
    half = document.blocks.new("HALF")
    half.add_lwpolyline([(0, 0, 0), (80, 0, 0.5), (80, 30, 0), (0, 30, 0)], format="xyb")
    space.add_blockref("HALF", (0, 0))
    space.add_blockref("HALF", (0, 0), dxfattribs={"xscale": -1})
    quarter = 4 * math.atan(0.5)
    radius = 15 / math.sin(quarter / 2)
    area = 2 * (80 * 30 + radius**2 / 2 * (quarter - math.sin(quarter)))
    assert_allclose(outline(saved()).moments.area, area, rtol=1e-9)


def test_layers_texts_and_what_is_off(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf", CENTRE={"color": 1}, OFF={})
    document = space.doc
    document.layers.get("OFF").off()
    space.add_circle((0, 0), 50)
    space.add_text("PLATE 10", height=5)
    space.add_line((-60, 0), (60, 0), dxfattribs={"layer": "CENTRE"})
    space.add_line((0, -60), (0, 60), dxfattribs={"layer": "OFF"})
    file = saved()
    with pytest.raises(DrawingError, match=r"LINE \w+ on layer CENTRE ends at \(-60, 0\) mm"):
        read_dxf(file)
    found = read_dxf(file, layers=["0"])
    assert_allclose(found.drawn.outline.moments.area, math.pi * 2500, rtol=1e-9)
    assert found.told[-1] == "not read, as they bound nothing: 1 TEXT"
    with pytest.raises(DrawingError, match="has no layer 'PLATE'; it has"):
        read_dxf(file, layers=["PLATE"])
    space.add_circle((0, 0), 20, dxfattribs={"layer": "Cut"})  # of which the table does not know
    found = read_dxf(saved(), layers=["0", "CUT"])
    assert_allclose(found.drawn.outline.moments.area, math.pi * 2100, rtol=1e-9)


def test_an_arc_that_is_drawn_from_below(tmp_path):
    _, space, saved = drawing(tmp_path / "a.dxf")
    space.add_line((0, 0), (40, 0))
    # seen along -z angles run the other way round, and x is mirrored
    space.add_arc((-20, 0), 20, 0, 180, dxfattribs={"extrusion": (0, 0, -1)})
    assert_allclose(outline(saved()).moments.centre.imag, 4 * 20 / (3 * math.pi), rtol=1e-9)


BROKEN = {
    "open": (
        lambda space: space.add_lwpolyline([(0, 0), (9, 0), (9, 9)]),
        r"LWPOLYLINE \w+ on layer 0 ends at \(0, 0\) mm, where nothing goes on; the nearest end is",
    ),
    "gap": (
        lambda space: [
            space.add_line(*ends)
            for ends in (((0, 0), (9, 0)), ((9, 0.02), (0, 9)), ((0, 9), (0, 0)))
        ],
        r"LINE \w+ on layer 0 ends at \(9, 0\) mm, where .* end is 0\.02 mm away, of LINE",
    ),
    "twice": (
        lambda space: [
            space.add_line(*ends)
            for ends in (((0, 0), (9, 0)), ((9, 0), (0, 9)), ((0, 9), (0, 0)), ((0, 0), (9, 0)))
        ],
        r"3 ends meet at \(0, 0\) mm: LINE \w+ on layer 0, LINE",
    ),
    "itself": (
        lambda space: space.add_lwpolyline([(0, 0), (10, 10), (10, 0), (0, 11)], close=True),
        r"goes through itself at \(5\.\d+, 5\.\d+\) mm \(LWPOLYLINE \w+ on layer 0\)",
    ),
    "beside": (
        lambda space: [space.add_circle((0, 0), 9), space.add_circle((30, 0), 5)],
        r"lies outside of the outermost one at \(35, 0\) mm \(CIRCLE \w+ on layer 0\)",
    ),
    "out of plane": (
        lambda space: space.add_line((0, 0, 0), (9, 4, 3)),
        r"LINE \w+ stands out of the drawing's plane, by z = 3 mm at \(9, 4\) mm",
    ),
    "no size": (
        lambda space: space.add_circle((3, 4), 0),
        r"CIRCLE \w+ at \(3, 4\) mm has a radius of 0 mm",
    ),
    "another entity": (
        lambda space: space.add_solid([(1, 2), (3, 2), (3, 4)]),
        r"the SOLID \w+ on layer 0 at \(1, 2\) mm is nothing that bounds a plate",
    ),
    "corner": (
        lambda space: space.add_open_spline([(0, 0), (5, 5), (5, 5), (5, 5), (0, 9)], degree=2),
        r"the SPLINE \w+ at \(0, 0\) mm cannot be followed: it",
    ),
    "nothing": (lambda space: None, "has no lines that bound a plate"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_drawings_name_the_entity_and_its_place(tmp_path, name):
    draw, told = BROKEN[name]
    _, space, saved = drawing(tmp_path / "a.dxf")
    draw(space)
    with pytest.raises(DrawingError, match=told):
        read_dxf(saved())


def test_damaged_files_are_refused(tmp_path):
    whole = stadium_with_holes(tmp_path / "link.dxf").read_text()
    file = tmp_path / "cut.dxf"
    for text in (whole[: len(whole) // 2], "no drawing", "", whole.replace("ENTITIES", "ENTITIE")):
        file.write_text(text)
        with pytest.raises(DrawingError):
            read_dxf(file)
    with pytest.raises(DrawingError, match="cannot be read"):
        read_dxf(tmp_path / "none.dxf")


def test_biarcs_follow_a_curve_within_their_tolerance():
    from geometry.drawings import ENOUGH, as_arcs
    from geometry.outlines import Edges

    def curve(t):
        return complex(40 * t, 15 * np.sin(3 * t)), complex(40, 45 * np.cos(3 * t))

    starts, ends, bulges = (np.array(column) for column in zip(*as_arcs(curve, 0, 2), strict=True))
    points = Edges(starts, ends, bulges).at(np.linspace(0, 1, 21)).ravel()
    # the curve is a graph: its height at the arcs' x, and the distance across its slope
    t = points.real / 40
    beside = np.abs(points.imag - 15 * np.sin(3 * t)) * np.cos(np.arctan(45 * np.cos(3 * t) / 40))
    assert beside.max() < 1.2 * ENOUGH
    turns = (ends - starts) / np.abs(ends - starts)
    angles = 4 * np.arctan(bulges)
    before, after = turns * np.exp(0.5j * angles), turns * np.exp(-0.5j * angles)
    assert np.abs(np.angle(after[1:] / before[:-1])).max() < 1e-6
