"""Plates, rods, levers, packs and single lugs that cannot be built name the parameter."""

from dataclasses import fields, replace

import pytest

from geometry.parameters import ParameterError
from geometry.parts import Pin, Seat

from .test_leaf_pack import PACK
from .test_plate_parts import CRANK, LEVER, QUICK_RETURN
from .test_tube_rod import ROD

REFUSED = [
    (CRANK, {"hole": 20}, "hole", "below 20 mm, the width of the plate, got 20 mm"),
    (CRANK, {"second_hole": 20}, "second_hole", "below 20 mm, the width"),
    (CRANK, {"second_hole": 0}, "second_hole", "above 0 mm"),
    (CRANK, {"length": 10}, "hole", "the holes meet, the pins are 10 mm apart"),
    (ROD, {"wall": 10}, "wall", "below 10 mm, half the tube's diameter, got 10 mm"),
    (ROD, {"wall": 0}, "wall", "above 0 mm"),
    (ROD, {"fillet": -1}, "fillet", "at least 0 mm"),
    (ROD, {"eye_diameter": 20}, "eye_diameter", "above 20 mm, got 20 mm"),
    (ROD, {"hole": 28.5}, "hole", "below 28.5 mm, the diameter of the eye"),
    (ROD, {"eye_width": 24}, "eye_width", "below 23.585 mm, where the eye's flats hold the hole"),
    (ROD, {"eye_width": 19}, "tube_diameter", "at most 19 mm, or it reaches beyond the flats"),
    (ROD, {"length": 24}, "fillet", "eyes and fillets take 24.82 mm, the pins are 24 mm apart"),
    (ROD, {"length": 40}, "wall", "no room for a bore, eyes and hemispheres take 43.5 mm"),
    (LEVER, {"hole": 30}, "hole", "below 30 mm, the width of the plate"),
    (LEVER, {"slot_width": 30}, "slot_width", "below 30 mm, the width of the plate"),
    (LEVER, {"slot_from": 4}, "slot_from", "above 4 mm"),
    (LEVER, {"slot_to": 196}, "slot_to", "below 196 mm, where the hole at the tip begins"),
    (LEVER, {"slot_to": 40}, "slot_to", "above 40 mm"),
    (LEVER, {"overhang": 4}, "overhang", "above 4 mm"),
    (LEVER, {"boss_height": 5}, "boss_height", "there is no boss: state boss_diameter too"),
    (LEVER, {"boss_fillet": 1}, "boss_fillet", "there is no boss"),
    (QUICK_RETURN, {"boss_diameter": 8}, "boss_diameter", "above 8 mm"),
    (QUICK_RETURN, {"boss_height": 0}, "boss_height", "above 0 mm"),
    (QUICK_RETURN, {"boss_fillet": 9.75}, "boss_fillet", "below 9.75 mm, the boss's height"),
    (QUICK_RETURN, {"boss_diameter": 26}, "boss_diameter", "beyond the plate; it must be below 26"),
    (QUICK_RETURN, {"overhang": 13}, "boss_diameter", "beyond the plate; it must be below 22 mm"),
    (QUICK_RETURN, {"slot_to": 194}, "boss_diameter", "straight flanks; it must be at most 20 mm"),
    (LEVER, {"contact_length": 0}, "contact_length", "above 0 mm"),
    (LEVER, {"contact_length": 152}, "contact_length", "no way to slide: from 110 to 110 mm"),
    (LEVER, {"travel_from": 39}, "travel_from", "round end; it must be at least 40 mm"),
    (LEVER, {"travel_to": 181}, "travel_to", "round end; it must be at most 180 mm"),
    (LEVER, {"travel_from": 90, "travel_to": 90}, "travel_to", "from 90 to 90 mm"),
    (PACK, {"leaves": 0}, "leaves", "must be 1, 2, 3 or so, got 0"),
    (PACK, {"leaves": 2.5}, "leaves", "got 2.5"),
    (PACK, {"contact_to": 427}, "contact_to", "above 427 mm"),
    (PACK, {"contact_to": 449}, "contact_to", "end of the leaves, at 453.5 mm; it must be at most"),
    (PACK, {"contact_from": 44}, "contact_from", "onto the clamp; it must be at least 45 mm"),
    (PACK, {"overhang": 19}, "overhang", "at least 20 mm"),
    (PACK, {"rod_length": 841}, "rod_length", "at most 840 mm, where it meets the pivot's clamp"),
    (PACK, {"clamp_length": 920}, "clamp_length", "below 920 mm, where it meets the rod's pin"),
    (PACK, {"clamp_factor": 0.9}, "clamp_factor", "at least 1, got 0.9$"),
]


@pytest.mark.parametrize(("shape", "change", "field", "says"), REFUSED)
def test_a_part_that_cannot_be_built_names_the_parameter(shape, change, field, says):
    with pytest.raises(ParameterError, match=says) as caught:
        replace(shape, **change)
    assert caught.value.field == field


@pytest.mark.parametrize("value", [-1.0, float("nan")])
@pytest.mark.parametrize("shape", [CRANK, ROD, QUICK_RETURN, PACK], ids=lambda s: type(s).__name__)
def test_no_parameter_may_be_negative_or_no_number(shape, value):
    for parameter in fields(shape):
        with pytest.raises(ParameterError):
            replace(shape, **{parameter.name: value})


@pytest.mark.parametrize("at", [float("nan"), float("inf")])
def test_a_single_lug_at_no_finite_place_is_refused(at):
    with pytest.raises(ParameterError, match="must be a finite length") as caught:
        Seat("lug", at=at, width=6, single=True)
    assert caught.value.field == "at"


def test_only_a_single_lug_may_stand_below_the_mid_plane_or_across_it():
    assert Seat("lug", at=-1, width=6, single=True).places == (-1,)
    with pytest.raises(ParameterError, match="at least 0 mm"):
        Seat("lug", at=-1, width=6)
    with pytest.raises(ParameterError, match="overlaps itself"):
        Seat("lug", at=1, width=6)


def test_single_lugs_that_overlap_are_refused():
    seats = (Seat("a", at=5, width=10, single=True), Seat("b", at=-4, width=10, single=True))
    with pytest.raises(ParameterError, match="'b' and 'a' overlap by 1 mm"):
        Pin(seats=seats, diameter=10)


@pytest.mark.parametrize(
    ("at", "overhang", "field", "says"),
    [
        (-3, 5, "step_fillet", "between 'rod' and 'crank' there are 0 mm for 1 mm of fillets"),
        (-4, 0.9, "overhang", "0.9 mm does not hold the fillet of 1 mm"),
    ],
)
def test_a_fillet_needs_room_beside_its_lug(at, overhang, field, says):
    neck = Seat("rod", at=at, width=6, diameter=8, single=True)
    seats = (Seat("crank", at=5, width=10, single=True), neck)
    with pytest.raises(ParameterError, match=says) as caught:
        Pin(seats=seats, diameter=10, step_fillet=1, overhang=overhang)
    assert caught.value.field == field
