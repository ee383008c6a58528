"""Bars that several tests share."""

from geometry.parts import ToggleBar

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
