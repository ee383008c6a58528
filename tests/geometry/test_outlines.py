"""Plane outlines against closed forms: moments, sections, sides, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry.outlines import Contour, Edges, Moments, OutlineError, PlateOutline

SQUARE = Contour.of((0, 100, 100 + 50j, 50j), (0.0, 0.0, 0.0, 0.0))


def moments(contour: Contour) -> Moments:
    return Moments.of(contour.edges.integrals())


def test_moments_of_a_circle_anywhere():
    found, area = moments(Contour.round(3 + 4j, 5.0)), np.pi * 25
    assert_allclose(found.area, area, rtol=1e-11)
    assert_allclose(found.centre, 3 + 4j, rtol=1e-11)
    assert_allclose(found.polar, np.pi * 625 / 2, rtol=1e-11)
    # about the axes: I + A d^2, and A x y
    wanted = (np.pi * 625 / 4 + 9 * area, 12 * area, np.pi * 625 / 4 + 16 * area)
    assert_allclose(found.second, wanted, rtol=1e-11)


def test_moments_of_a_rectangle_and_of_a_segment_of_a_circle():
    found = moments(SQUARE)
    assert_allclose(found.second, (100**3 * 50 / 3, 100**2 * 50**2 / 4, 100 * 50**3 / 3))
    # a circle's segment of the angle t: r^2 (t - sin t)/2, centre 4 r sin^3(t/2)/(3 (t - sin t))
    for angle in (0.3, 2.0, 4.0, 6.0):
        ends = 10 * np.exp(1j * np.array([-angle / 2, angle / 2]))
        segment = moments(Contour.of(ends.tolist(), (np.tan(angle / 4), 0.0)))
        assert_allclose(segment.area, 50 * (angle - np.sin(angle)), rtol=1e-9)
        middle = 40 * np.sin(angle / 2) ** 3 / (3 * (angle - np.sin(angle)))
        assert_allclose(segment.centre, middle, rtol=1e-9, atol=1e-9)


def test_a_section_and_what_lies_ahead_of_it():
    plate = PlateOutline(SQUARE, (Contour.round(30 + 25j, 10),))
    cut = plate.cut(30 + 25j, 1)
    assert_allclose(cut.spans, [[-25, -10], [10, 25]], atol=1e-6)
    assert_allclose(cut.ahead.area, 70 * 50 - np.pi * 50, rtol=1e-9)
    # half of the disc ahead has its centre 4 r/(3 pi) beyond the section
    first = 3500 * 65 - np.pi * 50 * (30 + 40 / (3 * np.pi))
    assert_allclose(cut.ahead.first, (first, 3500 * 25 - np.pi * 50 * 25), rtol=1e-9)
    assert cut.is_ahead(90 + 10j)
    assert not cut.is_ahead(3 + 1j)
    assert plate.cut(-1 + 3j, 1) is None


@pytest.mark.parametrize("angle", np.radians([0.0, 17.0, 90.0, 163.0, -71.0]))
def test_both_sides_of_a_slanted_section_make_up_the_plate(angle):
    inner = (Contour.round(30 + 25j, 10), Contour.of((60 + 10j, 80 + 10j, 70 + 40j), (0.3, 0, 0)))
    plate, way = PlateOutline(SQUARE, inner), np.exp(1j * angle)
    for point in (33 + 20j, 66 + 22j, 10 + 4j):
        there, back = plate.cut(point, way), plate.cut(point, -way)
        assert_allclose(there.spans, -back.spans[::-1, ::-1], atol=1e-6)
        for kind in ("area", "first", "second"):
            total = np.add(getattr(there.ahead, kind), getattr(back.ahead, kind))
            assert_allclose(total, getattr(plate.moments, kind), rtol=1e-9)


@pytest.mark.parametrize("along", [1, -1])
@pytest.mark.parametrize("wide_first", [True, False])
def test_a_section_where_the_width_steps_is_the_narrower_one(along, wide_first):
    corners = (0, 50, 50 + 10j, 100 + 10j, 100 + 30j, 50 + 30j, 50 + 40j, 40j)
    if not wide_first:
        corners = tuple(100 - complex(at).conjugate() for at in corners)[::-1]
    stepped = PlateOutline(Contour.of(corners, (0.0,) * 8))
    cut = stepped.cut(50 + 20j, along)
    assert_allclose(np.sort(cut.ends), [-10, 10], rtol=1e-12)


def test_an_arm_that_folds_back_beyond_the_line_is_on_its_own_side():
    corners = (0, 100, 100 + 60j, 30 + 60j, 30 + 40j, 80 + 40j, 80 + 20j, 20j)
    hook = PlateOutline(Contour.of(corners, (0.0,) * 8))
    cut = hook.cut(50 + 10j, 1)  # through the lower arm; the upper one hangs on the part ahead
    assert_allclose(cut.spans, [[-10, 10]], atol=1e-6)
    assert cut.is_ahead(40 + 50j)
    assert not cut.is_ahead(5 + 5j)
    assert_allclose(cut.ahead.area, 50 * 20 + 20 * 20 + 70 * 20, rtol=1e-9)


def test_a_mirrored_and_turned_outline_has_the_same_moments():
    plate = PlateOutline(SQUARE, (Contour.of((60 + 10j, 80 + 10j, 70 + 40j), (0.3, 0, -0.1)),))
    moved = plate.placed(13 - 4j, np.exp(0.7j), mirrored=True)
    assert_allclose(moved.moments.area, plate.moments.area, rtol=1e-12)
    assert_allclose(moved.moments.polar, plate.moments.polar, rtol=1e-12)
    centre = ((plate.moments.centre - (13 - 4j)) / np.exp(0.7j)).conjugate()
    assert_allclose(moved.moments.centre, centre, rtol=1e-12)


def test_a_contour_that_is_given_clockwise_is_turned():
    there = Contour.either_way([0, 10, 10 + 10j], [0.0, 0.4, 0.0])
    back = Contour.either_way([10 + 10j, 10, 0], [-0.4, 0.0, 0.0])
    assert_allclose(there.area, back.area, rtol=1e-14)
    assert_allclose(sorted(there.bulges), sorted(back.bulges))


def test_crossings_of_an_arc_are_on_it():
    edges = Edges(np.array([10 + 0j]), np.array([-10 + 0j]), np.array([1.0]))
    places, _, shares = edges.crossings(3 + 0j, 1)
    assert_allclose(places, [np.sqrt(91)])
    assert_allclose(edges.at(shares)[0], 3 + 1j * np.sqrt(91))


def test_what_bounds_no_plate_is_refused_with_its_place():
    bow = Contour.either_way([0, 10 + 10j, 10, 11j], [0.0] * 4)
    with pytest.raises(OutlineError, match=r"goes through itself at \(5\.\d+, 5\.\d+\) mm"):
        PlateOutline(bow)
    with pytest.raises(OutlineError, match=r"lies outside of the outermost one at \(210, 20\) mm"):
        PlateOutline(SQUARE, (Contour.round(200 + 20j, 10),))
    with pytest.raises(OutlineError, match=r"two contours cross at \("):
        PlateOutline(SQUARE, (Contour.round(30 + 45j, 10),))
    with pytest.raises(OutlineError, match="lies inside of one that is cut out"):
        PlateOutline(SQUARE, (Contour.round(30 + 25j, 10), Contour.round(30 + 25j, 3)))
    with pytest.raises(OutlineError, match="encloses no area"):
        Contour.of((0, 10), (0.0, 0.0))


def test_an_equal_outline_that_is_cut_alike_is_not_cut_again():
    one, other = (PlateOutline(SQUARE, (Contour.round(30 + 25j, 10),)) for _ in range(2))
    cut = one.cut(complex(20, -0.0) + 25j, 2)
    assert other.cut(20 + 25j, complex(1, -0.0)) is cut
    assert other.cut(20 + 25j, 1j) is not cut
