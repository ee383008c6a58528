"""Closed forms of the parametric parts against the CAD kernel's integrals of their solids."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.cad_body import cad_body
from geometry.closed_form import closed_body
from geometry.parts import LeafPack, Pin, PlateLink, PrismaticTube, Seat, SlottedLever, TubeRod

from .bars import IPE_160, PRESS_BAR, RHS_120

PIN = Pin(
    seats=(
        Seat("outer", at=42.0, width=6.0),
        Seat("eye", at=0.0, width=43.0, diameter=35.0),
    ),
    diameter=40.0,
    step_fillet=1.0,
)
ONE_SIDED = Pin(
    seats=(
        Seat("crank", at=0.0, width=10.0, diameter=14.0, single=True),
        Seat("rod", at=18.0, width=12.0, single=True),
    ),
    diameter=20.0,
    step_fillet=2.0,
)
PACK = LeafPack(
    length=460.0,
    leaves=3,
    width=60.0,
    thickness=9.6,
    arm=453.5,
    overhang=26.5,
    clamp_length=80.0,
    rod_length=40.0,
    contact_from=426.0,
    contact_to=448.5,
    contact_length=10.0,
)
ROD = TubeRod(
    length=400.0,
    tube_diameter=30.0,
    wall=4.0,
    eye_diameter=60.0,
    eye_width=30.0,
    hole=20.0,
    fillet=8.0,
)
LEVER = SlottedLever(
    length=300.0,
    width=60.0,
    thickness=12.0,
    hole=20.0,
    slot_width=22.0,
    slot_from=40.0,
    slot_to=240.0,
)
BOSSED = replace(LEVER, overhang=35.0, boss_diameter=40.0, boss_height=10.0, boss_fillet=3.0)
SHAPES = {
    "toggle bar": PRESS_BAR,
    "corner of the cut-out above the inner radius": replace(PRESS_BAR, inner_radius=8.0),
    "cut-out that ends before the knee": replace(PRESS_BAR, cutout_length=15.0, cutout_corner=12.0),
    "cut-out over the second hole": replace(PRESS_BAR, cutout_length=300.0),
    "tube": PrismaticTube(length=250.0, width=30.0, wall=1.6),
    "tube with round corners": PrismaticTube(length=250.0, width=40.0, wall=4.0, inner_radius=6.0),
    "pin": PIN,
    "sharp steps": replace(PIN, step_fillet=0.0),
    "pin with lugs on one side": ONE_SIDED,
    "link": PlateLink(length=100.0, width=20.0, thickness=10.0, hole=10.0),
    "link with two holes": PlateLink(
        length=100.0, width=30.0, thickness=8.0, hole=10.0, second_hole=22.0
    ),
    "leaves": PACK,
    "rod": ROD,
    "rod whose flats cut the fillets": replace(ROD, eye_width=31.0, fillet=40.0),
    "rod without fillets": replace(ROD, fillet=0.0, eye_width=44.0),
    "solid rod as thick as its eyes": replace(ROD, wall=None, tube_diameter=30.0),
    "slotted lever": LEVER,
    "slotted lever with square ends": replace(LEVER, overhang=25.0),
    "slotted lever with a boss": BOSSED,
    "boss without fillet": replace(BOSSED, boss_fillet=0.0, overhang=None),
    "hollow beam": RHS_120,
    "hollow beam without roundings": replace(RHS_120, corner=0.0, fillet=0.0),
    "I beam": IPE_160,
    "I beam without fillets": replace(IPE_160, fillet=0.0),
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_closed_forms_are_the_kernels_integrals(shape):
    """The kernel integrates curved faces to about 1e-6; measured below 3e-7."""
    closed, known = closed_body(shape), cad_body(shape)
    assert closed.volume == pytest.approx(known.volume, rel=1e-5)
    assert closed.second == pytest.approx(known.second, rel=1e-5)
    assert closed.centre == pytest.approx(known.centre, abs=1e-5 * known.size)
    assert closed.size == pytest.approx(known.size, rel=1e-6)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_interfaces_need_no_kernel(shape):
    closed, known = closed_body(shape).interfaces, cad_body(shape).interfaces
    assert list(closed) == list(known)
    for name, interface in closed.items():
        for field in interface.__dataclass_fields__:
            np.testing.assert_array_equal(getattr(interface, field), getattr(known[name], field))


def test_the_centre_of_a_pin_with_lugs_on_one_side_is_away_from_its_fixed_lug():
    """Its thick end is the heavier one: beyond the middle of its length, 9.5 mm from the crank."""
    low, high = ONE_SIDED.ends
    assert closed_body(ONE_SIDED).centre[2] > (low + high) / 2


def test_a_wider_tube_has_the_mass_of_its_walls():
    """Length times the area of the walls: four of 30 x 2 mm less the corners counted twice."""
    tube = closed_body(PrismaticTube(length=100.0, width=30.0, wall=2.0))
    assert tube.volume == pytest.approx(100.0 * (4 * 30.0 * 2.0 - 4 * 2.0**2), rel=1e-12)


def test_a_straight_rod_is_what_a_hand_adds_up():
    """Ball of the eye's diameter cut flat, pi w (R^2 - w^2/12), less holes, on a bar's two ends.

    The fillets are left out (radius 0); of the tube what lies inside of the balls is theirs: a cap
    of the height R - c, c = sqrt(R^2 - r^2), and a bore with two hemispheres.
    """
    rod = replace(ROD, fillet=0.0, eye_width=44.0)
    ball = np.pi * 44.0 * (30.0**2 - 44.0**2 / 12) - np.pi * 10.0**2 * 44.0
    outside = np.sqrt(30.0**2 - 15.0**2)
    cap = np.pi * (30.0 - outside) ** 2 * (3 * 30.0 - (30.0 - outside)) / 3
    bore = np.pi * 11.0**2 * (400.0 - 60.0 - 22.0) + 4 * np.pi * 11.0**3 / 3
    tube = np.pi * 15.0**2 * (400.0 - 2 * outside)
    assert closed_body(rod).volume == pytest.approx(2 * (ball - cap) + tube - bore, rel=1e-12)


def test_a_boss_that_the_slot_cuts_into_is_left_to_the_kernel():
    """Quick return's lever: its slot ends 3 mm inside of the boss, 0.8 % of the volume."""
    assert closed_body(replace(BOSSED, slot_to=300.0 - 20.0 - 3.0)) is not None
    assert closed_body(replace(BOSSED, slot_to=300.0 - 20.0 - 2.9)) is None


def test_a_shape_without_closed_form_is_left_to_the_kernel():
    assert closed_body(object()) is None
