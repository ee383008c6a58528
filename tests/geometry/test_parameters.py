"""Shapes that cannot be built are refused, in the words of their parameters."""

import pickle
from dataclasses import replace

import pytest

from geometry.parameters import ParameterError
from geometry.parts import Pin, PrismaticTube, Seat, ToggleBar

BAR = ToggleBar(
    length=250,
    width=80,
    wall=6.3,
    hole=44,
    overhang=40,
    inner_radius=3,
    cutout_length=56,
    cutout_corner=5,
)
TUBE = PrismaticTube(length=250, width=13, wall=1.6)
PIN = Pin(
    seats=(Seat("lug", at=30, width=6), Seat("eye", width=40, diameter=35)),
    diameter=40,
    step_fillet=1.0,
)


@pytest.mark.parametrize(
    ("shape", "change", "field", "says"),
    [
        (BAR, {"length": 0}, "length", "above 0 mm, got 0 mm"),
        (BAR, {"wall": 40}, "wall", "two walls fill the width of 80 mm"),
        (BAR, {"wall": float("nan")}, "wall", "above 0"),
        (BAR, {"inner_radius": -1}, "inner_radius", "at least 0"),
        (BAR, {"inner_radius": 34}, "inner_radius", "below 33.7 mm"),
        (BAR, {"hole": 80}, "hole", "larger than the bar's width of 80 mm"),
        (BAR, {"hole": 62}, "hole", "cuts into the side walls; it must be below 61.4 mm"),
        (BAR, {"length": 44}, "hole", "the holes meet"),
        (BAR, {"overhang": 22}, "overhang", "above 22 mm"),
        (BAR, {"cutout_length": 0}, "cutout_length", "above 0"),
        (BAR, {"cutout_length": 330}, "cutout_length", "longer than the bar, which is 330 mm"),
        (BAR, {"cutout_corner": 34}, "cutout_corner", "below 33.7 mm"),
        (TUBE, {"width": 3}, "wall", "below 1.5 mm"),
        (TUBE, {"width": -13}, "width", "above 0"),
        (PIN, {"diameter": 0}, "diameter", "above 0"),
        (PIN, {"diameter": 34}, "seats", "'eye': a neck of 35 mm is thicker than the pin"),
        (PIN, {"overhang": -1}, "overhang", "at least 0"),
        (PIN, {"step_fillet": 3}, "step_fillet", "larger than the step of 2.5 mm at 'eye'"),
        (PIN, {"seats": ()}, "seats", "at least one lug"),
        (PIN, {"seats": PIN.seats + PIN.seats[:1]}, "seats", "'lug' is there twice"),
        (
            PIN,
            {"seats": (Seat("a", at=5, width=6), Seat("b", width=8))},
            "seats",
            "overlap by 2 mm",
        ),
    ],
)
def test_a_part_that_cannot_be_built_names_the_parameter(shape, change, field, says):
    with pytest.raises(ParameterError, match=says) as caught:
        replace(shape, **change)
    assert caught.value.field == field
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


@pytest.mark.parametrize(("at", "width", "field"), [(-1, 6, "at"), (30, 0, "width"), (2, 6, "at")])
def test_a_seat_that_cannot_be_is_refused(at, width, field):
    with pytest.raises(ParameterError) as caught:
        Seat("lug", at=at, width=width)
    assert caught.value.field == field


def test_lugs_that_touch_are_allowed():
    """Cheek against cheek: 0 + 8/2 is exactly 7 - 6/2."""
    pin = Pin(seats=(Seat("outer", at=7, width=6), Seat("inner", width=8)), diameter=20, overhang=2)
    assert [seat.name for seat, _, _ in pin.seated()] == ["outer", "inner", "outer"]
    assert pin.length == 2 * (7 + 3 + 2)


def test_the_sections_of_a_bar_are_its_tube_and_its_free_cheeks():
    """The cheeks are free from the pin to the end of the cut-out: 56 - 40 mm."""
    tube, cheeks = BAR.sections
    assert (tube.name, cheeks.name, cheeks.length) == ("tube", "cheeks", 16)
    assert (cheeks.stretch, tube.stretch) == ((0.0, 16.0), (16.0, BAR.length))
    (whole,) = replace(BAR, cutout_length=40).sections
    assert (whole.name, whole.stretch) == ("tube", None)
    assert PIN.sections == ()
