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
    PinHole("head", at=700.0, diameter=30.0, boss=50.0),
    PinHole("middle", at=300.0, diameter=40.0, boss=65.0),
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
