"""Bars that several tests share."""

from geometry.parts import IBeam, PinHole, RhsBeam, ToggleBar

PRESS_BAR = ToggleBar(
    length=250.0,
    width=80.0,
    wall=6.3,
    hole=44.0,
    overhang=40.0,
    inner_radius=3.0,
    cutout_length=56.0,
    cutout_corner=5.0,
)  # of designs/toggle_press.toml

HOLES = (
    PinHole("foot", at=0.0, diameter=30.0, boss=50.0),
    PinHole("head", at=330.0, diameter=30.0, boss=50.0),
    PinHole("middle", at=150.0, diameter=40.0, boss=65.0),
)
RHS_120 = RhsBeam(
    holes=HOLES,
    overhang=60.0,
    fillet=4.0,
    height=120.0,
    width=60.0,
    wall=5.0,
    corner=10.0,
)
IPE_160 = IBeam(
    holes=HOLES,
    overhang=60.0,
    fillet=4.0,
    height=160.0,
    width=82.0,
    web=5.0,
    flange=7.4,
    root=9.0,
    boss_width=60.0,
)

_ENDS = (
    PinHole("foot", at=0.0, diameter=14.0, boss=26.0),
    PinHole("head", at=70.0, diameter=14.0, boss=26.0),
)
SHORT_RHS = RhsBeam(
    holes=_ENDS,
    overhang=20.0,
    fillet=5.0,
    height=60.0,
    width=40.0,
    wall=6.0,
    corner=9.0,
)
SHORT_I = IBeam(
    holes=_ENDS,
    overhang=20.0,
    fillet=5.0,
    height=66.0,
    width=40.0,
    web=6.0,
    flange=7.0,
    root=6.0,
    boss_width=26.0,
)
