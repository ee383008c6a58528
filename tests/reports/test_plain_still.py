"""Pictures of a part that was not meshed, against what a sphere and a box look like."""

import sys
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from reports.pictures_worker import still
from reports.plain_still import plain_still, use_colours

SIZE = (300, 200)
FRONT = np.array([0.0, -1.0, 0.0])
# A box of 40 x 20 x 10 mm with outward faces.
CORNERS = np.array([[x, y, z] for x in (0.0, 40.0) for y in (0.0, 20.0) for z in (0.0, 10.0)])
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


def picture(nodes, triangles, direction=FRONT, scene=1.0):
    png = plain_still(nodes, triangles, direction, SIZE, scene)
    return np.asarray(Image.open(BytesIO(png))).astype(int)


def test_a_box_from_the_front_is_a_rectangle_of_its_sides():
    pixels = picture(CORNERS, FACES)
    assert pixels.shape == (SIZE[1], SIZE[0])
    rows, columns = np.nonzero(pixels < 250)
    width, height = np.ptp(columns) + 1, np.ptp(rows) + 1
    lines = 1  # pixels, of half an edge's width on both sides together
    assert width - lines == pytest.approx(SIZE[0] / 1.12, abs=1.5)
    assert height - lines == pytest.approx(SIZE[0] / 1.12 / 4, abs=1.5)
    assert (pixels[rows.min() : rows.max(), columns.min() : columns.max()] < 250).all()
    inner = pixels[rows.min() + 3 : rows.max() - 2, columns.min() + 3 : columns.max() - 2]
    assert np.ptp(inner) == 0  # no edge of the back, no diagonal of a face
    assert pixels[rows.min(), 150] < inner[0, 0]  # an edge is darker


def test_utilisations_are_painted_with_one_hard_change_at_1():
    """From 0 at the left to 2 at the right: the middle is the limit, 1/4 across is 0.5."""
    png = plain_still(CORNERS, FACES, FRONT, SIZE, 0.8, CORNERS[:, 0] / 20.0)
    row = np.asarray(Image.open(BytesIO(png))).astype(int)[SIZE[1] // 2]
    part = np.flatnonzero((row < 250).any(axis=1)[: int(0.8 * SIZE[0])])
    first, last = part.min(), part.max()
    red = row[:, 0] > row[:, 2]
    middle = (first + last) / 2
    assert not red[first + 3 : int(middle) - 1].any()
    assert red[int(middle) + 2 : last - 2].all()
    for share in (0.25, 0.75):
        shown = row[round(first + share * (last - first))]
        colour = use_colours(np.array([2 * share]), 2.0)[0]
        assert shown / colour == pytest.approx(
            (shown / colour).mean(), abs=0.03
        )  # but for the light
    low, below, above = use_colours(np.array([0.0, 1.0, 1.0 + 1e-9]), 2.0)
    assert low.min() > 230
    assert np.abs(above - below).max() > 100


def test_the_nearer_of_two_boxes_hides_the_farther_whatever_their_order():
    small = CORNERS * [0.25, 1.0, 0.5] + [15.0, -40.0, 2.5]
    nodes = np.vstack([CORNERS, small])
    one = picture(nodes, np.vstack([FACES, FACES + 8]))
    other = picture(nodes, np.vstack([FACES + 8, FACES]))
    assert (one == other).all()
    alone = picture(CORNERS, FACES)
    assert (one != alone).any()  # its edges are seen before the large one
    small[:, 1] += 100.0
    behind = picture(np.vstack([CORNERS, small]), np.vstack([FACES, FACES + 8]))
    assert (behind == alone).all()


def test_a_box_from_above_its_corner_shows_three_shades():
    direction = np.array([1.0, -1.3, 0.9]) / np.linalg.norm([1.0, -1.3, 0.9])
    shades, counts = np.unique(picture(CORNERS, FACES, direction), return_counts=True)
    assert (counts[shades < 250] > 500).sum() == 3


def test_the_scene_keeps_to_its_share_of_the_width():
    pixels = picture(CORNERS, FACES, scene=0.5)
    assert (pixels[:, 150:] == 255).all()
    assert (pixels[:, :150] < 250).any()


def test_a_part_that_was_not_meshed_is_drawn_without_graphics_libraries(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "vtk", None)
    data = {"nodes": CORNERS, "triangles": FACES, "values": np.zeros(8), "peak": 0}
    assert Image.open(BytesIO(still(data, "not meshed", "plain"))).size == (900, 600)
    with pytest.raises(ImportError):
        still(data, "not meshed", "whole")
