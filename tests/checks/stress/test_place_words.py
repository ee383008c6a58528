"""Places as an engineer says them."""

import numpy as np
import pytest

from checks.stress.stress_result import depth_of, place_words
from geometry.mesh import Interface

BAR = [
    Interface("knee", "bore", np.zeros(3), 22.0, 12.6),
    Interface("end", "bore", np.array([250.0, 0.0, 0.0]), 22.0, 12.6),
]
PIN = [
    Interface("cylinder", "journal", np.zeros(3), 17.5, 43.0),
    Interface("upper", "journal", np.zeros(3), 20.0, 12.6),
]
CHEEK = (33.7, 40.0)


@pytest.mark.parametrize(
    ("at", "depth", "words"),
    [
        ((22.0, 0.0, 40.0), CHEEK, "knee bore, edge at the outer face, towards end"),
        ((22.0, 0.0, -40.0), CHEEK, "knee bore, edge at the outer face, towards end"),
        ((-22.0, 0.0, 33.7), CHEEK, "knee bore, edge at the inner face, away from end"),
        ((0.0, 22.0, 36.0), CHEEK, "knee bore, 90 deg from the line to end"),
        ((0.0, -22.0, 5.0), (0.0, 5.0), "knee bore, edge at the face, 90 deg from the line to end"),
        ((22.0, 0.0, 0.0), (0.0, 5.0), "knee bore, towards end"),
        ((22.0, 0.0, 40.0), None, "knee bore, towards end"),
    ],
)
def test_a_place_in_a_bore_has_its_edge_and_its_side(at, depth, words):
    assert place_words("knee", np.array(at), depth, BAR) == words


@pytest.mark.parametrize(
    ("name", "at", "words"),
    [
        ("tube", (62.5, 40.0, 40.0), "tube, 25 % of the way from knee to end"),
        ("surface", (-30.0, 40.0, 0.0), "surface"),
        ("end edge", (250.0, 40.0, 40.0), "outer edge beside the end bore"),
        ("fillet/end", (228.0, 0.0, 36.0), "end bore, towards knee"),
    ],
)
def test_a_place_beside_the_bores_is_told_by_the_line_between_them(name, at, words):
    assert place_words(name, np.array(at), None, BAR) == words


def test_a_place_on_a_pin_is_in_a_seat_or_at_its_edge():
    at = np.array([17.5, 0.0, 21.5])
    assert place_words("cylinder on the pin", at, None, PIN) == "seat of cylinder"
    assert place_words("cylinder", at, (0.0, 21.5), PIN) == "seat of cylinder, at its edge"
    assert place_words("pin", at, None, PIN) == "pin"


def test_the_depth_is_that_of_the_side_that_a_point_is_on():
    heights = np.array([-40.0, -33.7, 33.7, 40.0])
    assert depth_of(heights, 36.0) == CHEEK
    assert depth_of(heights, -36.0) == CHEEK
    assert depth_of(np.array([-5.0, 0.0, 5.0]), 5.0) == (0.0, 5.0)
