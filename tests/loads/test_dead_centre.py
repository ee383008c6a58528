"""Drives that pull through a dead centre, against dense scans of closed-form statics."""

from dataclasses import replace
from math import asin, pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Force,
    Linkage,
    PointCoordinate,
    Revolute,
    Slot,
    pull_through,
)

from .machines import slider_crank

CRANK, ROD = 50.0, 200.0


def just_overcome(pull, torque_per_stiffness):
    """The stiffness at which the largest torque needed is the pull."""
    return pull / torque_per_stiffness.max()


def along_the_slider(angles):
    """Place of the slider and its derivative by the crank angle."""
    lean = np.sqrt(ROD**2 - (CRANK * np.sin(angles)) ** 2)
    place = CRANK * np.cos(angles) + lean
    return place, -CRANK * np.sin(angles) - CRANK**2 * np.sin(angles) * np.cos(angles) / lean


@pytest.mark.parametrize(
    ("counted", "sign", "turning", "touch"),
    [
        *((counted, sign, turning, 240.0) for counted in (1, -1) for sign in (1, -1)
          for turning in (1, -1)),
        (1, 1, 1, 249.0),
        (1, 1, -1, 230.0),
    ],
)  # fmt: skip
def test_a_crank_pulls_its_slider_through_however_forces_are_counted(counted, sign, turning, touch):
    """Torque k (x - touch) dx / d angle, the largest of a scan.

    The scan is good to 1e-9; the engine's 400 positions alone would be to 1e-6.
    """
    angles = np.linspace(-1.0, 0.0, 200_001)
    place, slope = along_the_slider(angles)
    expected = just_overcome(5e4, np.maximum(place - touch, 0.0) * slope)
    linkage = slider_crank(CRANK, ROD, at=-turning)
    push = PointCoordinate("slider", "B", (float(counted), 0.0))
    drive = Force("drive", Angle("crank", point="O"), sign)
    linkage = replace(linkage, forces=(drive, Force("push", push, sign)))
    found = pull_through(linkage, "drive", sign * turning * 5e4, "push", counted * touch)
    assert_allclose(found.stiffness, expected, rtol=2e-8)
    assert_allclose(found.force, expected * (CRANK + ROD - touch), rtol=2e-8)
    assert_allclose(found.dead_centre, 0.0, atol=1e-7)


REACH, APART = 75.0, 100.0  # crank, and its pivot above the lever's


def slotted_lever(at):
    """A crank whose pin slides along a lever pivoted below: it swings between two tangents."""
    pin = (REACH * np.cos(at), APART + REACH * np.sin(at))
    return Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, APART), "Q": (0.0, 0.0)}),
            Body("crank", {"O": (0.0, 0.0), "A": (REACH, 0.0)}),
            Body("lever", {"Q": (0.0, 0.0)}),
        ),
        joints=(
            Revolute("O", GROUND, "crank", "O"),
            Revolute("Q", GROUND, "lever", "Q"),
            Slot("slot", "lever", "crank", "Q", "A", (1.0, 0.0)),
        ),
        forces=(
            Force("drive", Angle("crank", point="O")),
            Force("work", Angle("lever", point="Q")),
        ),
        assembled={
            "crank": (0.0, APART, at),
            "lever": (0.0, 0.0, float(np.arctan2(pin[1], pin[0]))),
        },
        gravity=(0.0, 0.0),
    )


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("before", [1.0, 3.3, 3.6])
def test_the_first_of_two_near_dead_centres_is_the_one_that_is_met(way, before):
    """Dead centres where the crank is at right angles to the lever: 83 degrees apart, then 277.

    Seen from the first, the second lies a half to a tenth of the way ahead.
    """
    short = asin(REACH / APART)
    first = pi + short if way > 0 else -short
    linkage = slotted_lever(first - way * before)
    angles = np.linspace(first - way * min(before, 1.2), first, 100_001)
    x, y = REACH * np.cos(angles), APART + REACH * np.sin(angles)
    swing = np.arctan2(y, x)
    slope = (REACH**2 + APART * REACH * np.sin(angles)) / (x**2 + y**2)
    end = pi / 2 + way * short
    touch = end - way * 0.05
    depth = np.maximum(way * (swing - touch), 0.0)
    expected = just_overcome(2e4, depth * slope)
    found = pull_through(linkage, "drive", way * 2e4, "work", touch)
    assert_allclose(found.dead_centre, first, atol=1e-7)
    assert_allclose(found.stiffness, expected, rtol=2e-8)


@pytest.mark.parametrize("mu", [0.1, 0.5])
def test_friction_of_the_guide_asks_more_of_the_drive(mu):
    """Rod force N from N (cos - mu |sin|) = k (x - touch), its moment about the crank's pivot."""
    angles = np.linspace(-1.0, 0.0, 200_001)
    sine = -CRANK * np.sin(angles) / ROD
    cosine = np.sqrt(1.0 - sine**2)
    place, _ = along_the_slider(angles)
    rod = np.maximum(place - 240.0, 0.0) / (cosine - mu * np.abs(sine))
    moment = rod * (CRANK * np.cos(angles) * sine - CRANK * np.sin(angles) * cosine)
    expected = just_overcome(5e4, moment)
    found = pull_through(slider_crank(CRANK, ROD, at=-1.0, mu_slider=mu), "drive", 5e4, "push", 240)
    assert_allclose(found.stiffness, expected, rtol=2e-8)


@pytest.mark.parametrize("touch", [CRANK + ROD + 1.0, sqrt(ROD**2 - CRANK**2)])
def test_a_touch_beyond_the_dead_centre_or_behind_the_linkage_is_none(touch):
    """The slider stands at 240 mm and comes to 250; at a right angle of the crank it is at 194."""
    assert pull_through(slider_crank(CRANK, ROD, at=-0.5), "drive", 5e4, "push", touch) is None
