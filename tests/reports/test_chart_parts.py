"""Pieces of charts: thinning, axes over a cycle, places for names, small SVG."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from reports.charts.chart import Chart, Room, dense, gapless, swatch, thinned
from reports.charts.over_cycle import cycle_axis
from reports.svg import draw, round_ticks


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


def drawing(*lines, logarithmic="", label="A line"):
    """A drawing whose frame, 200 by 100 at (20, 10), goes from 1 to 100 both ways."""

    def plot(made):
        frame = made.frame((20, 10, 200, 100), (1, 100), (1, 100), logarithmic=logarithmic)
        for line, style in lines:
            frame.line(line, color="red", **style)
        return {"data-cycle": "3"}

    return ET.fromstring(draw(plot, (240, 140), label))


def paths(root, words):
    return [node for node in root if node.get("d") and words in node.get("style")]


def test_lines_are_where_the_axes_put_them():
    """Of a linear axis 50.5 is its middle, of a logarithmic one 10."""
    linear = drawing(([[1, 1], [50.5, 100], [50.5, 100], [100, 50.5]], {}))
    assert [path.get("d") for path in paths(linear, "red")] == ["M20 110L120 10 220 60"]
    assert linear.get("data-cycle") == "3"
    assert linear.get("viewBox") == "0 0 240 140"
    both = drawing(([[1, 1], [10, 10], [100, 100]], {}), logarithmic="xy")
    assert [path.get("d") for path in paths(both, "red")] == ["M20 110L120 60 220 10"]


def test_a_line_with_a_gap_goes_on_behind_it():
    root = drawing(([[1, 1], [50.5, 1], [60, np.nan], [50.5, 100], [100, 100]], {}))
    assert [path.get("d") for path in paths(root, "red")] == ["M20 110L120 110M120 10L220 10"]


@pytest.mark.parametrize("marker", [*"osD^v<>Px_|."])
def test_marks_stand_about_their_places_and_have_their_size(marker):
    [mark] = paths(drawing(([[50.5, 50.5]], {"marker": marker, "markersize": 10})), "red")
    if marker in "o.":
        left, wide = re.findall(r"^M([\d.]+) 60a[\d. ]+ 0 1 0 ([\d.]+) 0", mark.get("d"))[0]
        places = np.array([[float(left), 60], [float(left) + float(wide), 60]])
    else:
        places = np.array(re.findall(r"([\d.]+) ([\d.]+)", mark.get("d")), dtype=float)
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    assert_allclose(middle, (120, 60), atol=0.01)
    wanted = 5 if marker == "." else 14 if marker == "D" else 10
    assert np.ptp(places, axis=0).max() == pytest.approx(wanted)


def test_a_line_beyond_its_frame_stays_clipped_and_one_inside_is_not():
    """By the frame's own box, which no other drawing has."""
    root = drawing(([[1, 2], [90, 30]], {}), ([[1, 2], [90, 500]], {"linewidth": 3}))
    inside, beyond = (path.get("clip-path") for path in paths(root, "red"))
    assert inside is None
    [clip] = [node for node in root.iter() if node.tag.endswith("clipPath")]
    assert beyond == f"url(#{clip.get('id')})"
    assert [clip[0].get(key) for key in ("x", "y", "width", "height")] == ["20", "10", "200", "100"]
    other = drawing(
        ([[1, 2], [90, 30]], {}), ([[1, 2], [90, 500]], {"linewidth": 3}), label="Alike"
    )
    [another] = [node for node in other.iter() if node.tag.endswith("clipPath")]
    assert another.get("id") != clip.get("id")


def test_numbers_stand_beside_their_places_on_the_axes():
    root = drawing(([[1, 1], [100, 100]], {}))
    numbers = {
        node.text: (float(node.get("x")), float(node.get("y")))
        for node in root.iter()
        if node.tag.endswith("text") and float(node.get("y")) > 115
    }
    assert set(numbers) == {"20", "40", "60", "80", "100"}
    for text, (x, _) in numbers.items():
        assert x == pytest.approx(20 + 200 * (float(text) - 1) / 99, abs=0.01)
    decades = drawing(([[1, 1], [100, 100]], {}), logarithmic="x")
    below = [n for n in decades.iter() if n.tag.endswith("text") and float(n.get("y")) > 115]
    assert [(n.text, n.get("x")) for n in below] == [("1", "20"), ("10", "120"), ("100", "220")]


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (-1500, 1200, ["−1000", "0", "1000"]),
        (0, 0.6, ["0.0", "0.2", "0.4", "0.6"]),
        (0, 1.2, ["0.00", "0.25", "0.50", "0.75", "1.00"]),
        (199.0, 199.4, ["199.0", "199.1", "199.2", "199.3", "199.4"]),
    ],
)
def test_round_numbers_have_the_digits_that_tell_them_apart(low, high, told):
    assert [text for _, text in round_ticks(low, high)] == told


def test_texts_are_written_as_text():
    root = ET.fromstring(draw(lambda made: made.text(1, 2, "<b> & \0 #"), (9, 9), '"a" & <b>'))
    told = [node.text for node in root if node.tag.endswith("text")]
    assert told[0].startswith("<b> & ")
    assert root.get("aria-label") == '"a" & <b>'


def test_a_table_of_uneven_rows_is_refused():
    with pytest.raises(ValueError, match="2 cells"):
        Chart("x", "X", "", "<svg/>", ["a", "b"], [["1"]])


def test_strokes_of_the_readout_are_told_apart_without_colour():
    dashes = {swatch(k).partition("dasharray:")[2].partition('"')[0] for k in range(6)}
    assert len(dashes) == 6
