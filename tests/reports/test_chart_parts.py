"""What charts are made of: thinning, axes over a cycle, places for names, small SVG."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reports.charts.chart import Chart, swatch
from reports.charts.cycle_axis import cycle_axis
from reports.charts.labels import Room, dense
from reports.charts.thin import gapless, thinned
from reports.svg import draw, place
from reports.svg_compact import compact, short_path


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=200),
    st.floats(1e-3, 100.0),
)
def test_a_thinned_curve_misses_nothing_by_more_than_the_tolerance(values, tolerance):
    values = np.array(values)
    across = np.cumsum(1.0 + np.abs(np.sin(np.arange(len(values)))))
    kept = thinned(values, tolerance, across)
    for axis in (np.arange(len(values), dtype=float), across):
        read = np.interp(axis, axis[kept], values[kept])
        assert np.abs(read - values).max() <= tolerance * (1 + 1e-9)
    assert values[kept].max() == values.max()
    assert values[kept].min() == values.min()


def test_a_straight_line_keeps_its_ends_only():
    assert thinned(np.linspace(0, 5, 3600), 1e-9).tolist() == [0, 3599]


def test_gaps_part_a_run():
    values = np.array([1.0, np.nan, 2.0, 3.0, np.nan])
    assert [piece.tolist() for piece in gapless(values, np.arange(5))] == [[0], [2, 3]]


def test_positions_go_left_to_right_in_the_order_in_which_they_are_run_through():
    cycle = {"position": [200, 100, 7, 7, 4, 2, 2, 90, 200], "shown_name": "x", "unit": "mm",
             "phase": ["down"] * 3 + ["press"] * 3 + ["up"] * 3}  # fmt: skip
    axis = cycle_axis(0, cycle)
    assert (np.diff(axis.across) > 0).all()
    assert axis.across[0] == 0
    assert axis.across[-1] == pytest.approx(1)
    shown = [text for _, text in axis.ticks]
    assert shown[0] == shown[-1] == "200"
    assert shown.count("7") == 1  # where one phase ends and the next begins
    assert axis.at(1) == "x = 100 mm"


def test_a_turn_is_marked_by_parts_of_a_right_angle():
    axis = cycle_axis(0, {"position": np.linspace(0, 360, 37), "unit": "deg"})
    assert {"0", "90", "180", "360"} <= {text for _, text in axis.ticks}


def test_a_cycle_without_positions_has_no_axis():
    assert cycle_axis(0, {"position": []}) is None


def test_names_do_not_cover_each_other():
    room = Room(200.0, 100.0)
    line = np.array([[0.0, 50.0], [200.0, 50.0]])
    room.lines.append(dense(line))
    for name in ("first", "second", "third"):
        assert room.put(name, line) is not None
    for k, one in enumerate(room.taken):
        for other in room.taken[k + 1 :]:
            apart = one[2] <= other[0] or other[2] <= one[0]
            assert apart or one[3] <= other[1] or other[3] <= one[1]


def test_a_name_without_room_is_left_out():
    room, point = Room(20.0, 30.0), np.array([[10.0, 15.0]])
    while room.put("a name that is too long", point):
        assert len(room.taken) < 9
    assert room.taken


def test_places_in_the_drawing_are_where_the_line_is():
    found = {}

    def plot(figure):
        axes = figure.add_subplot()
        axes.set_xlim(0, 2)
        axes.set_ylim(0, 10)
        axes.plot([0.5, 1.5], [2, 8], color="red", gid="mine")

        def marks():
            found["ends"] = [place(axes, 0.5, 2), place(axes, 1.5, 8)]
            return {"mine": {"class": "mine"}, "": {"data-cycle": "3"}}

        return marks

    root = ET.fromstring(draw(plot, (4, 3), "A line"))
    assert root.get("data-cycle") == "3"
    group = next(node for node in root.iter() if node.get("class") == "mine")
    drawn = next(node.get("d") for node in group.iter() if node.tag.endswith("path"))
    (x0, y0), (x1, y1) = found["ends"]
    assert drawn == short_path(f"M {x0} {y0} L {x1} {y1}")


def test_a_drawing_that_is_no_xml_is_refused():
    with pytest.raises(ValueError, match="not well-formed"):
        compact("<svg><g></svg>", {}, {})


def test_a_line_beyond_its_frame_stays_clipped_and_one_inside_is_not():
    def plot(figure):
        axes = figure.add_subplot()
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1)
        axes.grid(visible=False)
        axes.plot([0.1, 0.9], [0.2, 0.3], color="red", gid="inside")
        axes.plot([0.1, 0.9], [0.2, 5.0], color="red", gid="beyond")
        return lambda: {name: {"class": name} for name in ("inside", "beyond")}

    root = ET.fromstring(draw(plot, (4, 3), "Two lines"))
    clipped = {
        node.get("class"): any(inner.get("clip-path") for inner in node.iter())
        for node in root.iter()
        if node.get("class")
    }
    assert clipped == {"inside": False, "beyond": True}


def test_a_table_of_uneven_rows_is_refused():
    with pytest.raises(ValueError, match="2 cells"):
        Chart("x", "X", "", "<svg/>", ["a", "b"], [["1"]])


def test_strokes_of_the_readout_are_told_apart_without_colour():
    dashes = {swatch(k).partition("dasharray:")[2].partition('"')[0] for k in range(6)}
    assert len(dashes) == 6
