"""Outlines from SVG paths."""

import math

import pytest
from numpy.testing import assert_allclose

from geometry.drawings import DrawingError
from geometry.dxf_file import read_svg_path


def area(text: str, scale: float = 1.0) -> float:
    return read_svg_path(text, scale).outline.moments.area


def test_lines_and_round_holes_with_y_turned_up():
    text = "M 0 0 H 100 V 50 H 0 Z M 40 20 A 10 10 0 1 0 20 20 A 10 10 0 1 0 40 20 Z"
    found = read_svg_path(text, 2.0).outline
    assert_allclose(found.moments.area, 4 * (5000 - math.pi * 100), rtol=1e-9)
    assert_allclose(found.inner[0].circle, (60 - 40j, 20))


def test_relative_commands_repeat_and_curves_are_followed():
    assert_allclose(area("m 10 10 30 0 0 20 -30 0 z"), 600)
    assert_allclose(area("M0,0L30,0l0,20h-30v-20z"), 600)
    # the area over the chord of a cubic's arch, as in the DXF test, and of a parabola: 2/3
    assert_allclose(area("M 0 0 C 0 60 90 60 90 0 Z"), 90 * 180 * 6 / 30, rtol=2e-5)
    assert_allclose(area("M 0 0 Q 45 60 90 0 Z"), 2 / 3 * 90 * 30, rtol=2e-5)
    assert_allclose(area("M 0 0 C 0 30 20 40 40 40 S 80 30 80 0 Z"),
                    area("M 0 0 C 0 30 20 40 40 40 C 60 40 80 30 80 0 Z"), rtol=1e-12)  # fmt: skip
    ellipse = "M 50 0 A 50 25 0 0 1 -50 0 A 50 25 0 0 1 50 0"
    assert_allclose(area(ellipse), math.pi * 1250, rtol=3e-5)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("M 0 0 L 10 10 L 10 0 L 0 11 Z", r"through itself at \(5\.\d+, -5\.\d+\) mm \(subpath 1"),
        ("M 0 0 L 10 0 Z", "encloses no area"),
        ("L 3 4", "begins with 'L'"),
        ("M 0 0 X 3", "'X', which is no command"),
        ("M 0 0 L 3", "'L' with 1 numbers, it takes 2"),
        ("M 0 0 & 3", r"cannot be read from letter 6 on: ' & 3'"),
        ("M 5 5", r"subpath 1 of one point at \(5, -5\) mm"),
        ("M 0 0 A 5 5 0 10 9 9 9", "flags of an arc are 0 or 1"),
    ],
)  # fmt: skip
def test_broken_paths_are_refused(text, told):
    with pytest.raises(DrawingError, match=told):
        read_svg_path(text)
