"""Sizes that lie so far apart that no mesh can have them are refused at once, with their key."""

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_file
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.result.verdict import Status

from ...small_machine import MACHINE, PLATE

PIN = """
[parts.pin]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "12 mm"
stack = [
  { body = "crank", at = "0 mm", width = "8 mm", single = true },
  { body = "rod", at = "9 mm", width = "8 mm", single = true },
]
"""


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "parts.rod.hole=0.01 mm",
            r"parts\.rod\.hole: 0\.01 mm beside length = 161 mm are too far",
        ),
        ("points.B=144, 1600 m", r"parts\.rod\.interfaces: pins that are 1\.606e\+06 mm apart"),
        ("parts.pin.overhang=5e6 mm", r"parts\.pin\.overhang: 5e\+06 mm beside stack\[0\]\.width"),
    ],
)
def test_sizes_that_no_mesh_can_have_are_refused_with_the_odd_one(tmp_path, change, told):
    """Gmsh would mesh the picture of each for minutes to days."""
    file = tmp_path / "machine.toml"
    text = MACHINE + PLATE if "pin" not in change else MACHINE + PLATE + PIN
    file.write_text(text, encoding="utf-8")
    changes = [change, 'parts.rod.hole="12 mm"'] if "pin" in change else [change]
    with pytest.raises(DesignError, match=told) as found:
        check_file(file, changes, effort=Effort("formula"))
    assert "triangles, more than 1.5e+05" in str(found.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "parts.pin.stack[1].width=6e-12 mm",
            r"parts\.pin\.stack\[1\]\.width: must be between 1e-06 and 1e\+07 mm, as of any part "
            r"of a machine, got 6e-12 mm",
        ),
        ("parts.pin.stack[0].diameter=3.5e-11 mm", r"parts\.pin\.stack\[0\]\.diameter: must be b"),
        ("parts.pin.overhang=1e9 mm", r"parts\.pin\.overhang: must be between .* got 1e\+09 mm"),
        (
            "parts.pin.stack[1].width=7e-6 mm",
            r"parts\.pin\.stack\[1\]\.width: 7e-06 mm is too far from diameter = 12 mm",
        ),
        (
            "points.B=2e8, 0 mm",
            r"parts\.rod\.interfaces: must be between 1e-06 and 1e\+07 mm.* got 2e\+08 mm",
        ),
        (
            "cycles.turn.phases[0].to=3.6e8 deg",
            r"cycles\.turn\.phases\[0\]\.to: must be within 36000 deg of 0, got 3\.6e\+08 deg; a "
            "motion that repeats is stated once",
        ),
        ("cycles.turn.start=-4e4 deg", r"cycles\.turn\.start: must be within 36000 deg of 0"),
    ],
)
def test_sizes_and_turns_that_no_machine_has_are_refused(tmp_path, change, told):
    """Fuzz: a lug of 6e-12 mm had no member of the frame, a million turns no end."""
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PLATE + PIN, encoding="utf-8")
    with pytest.raises(DesignError, match=told):
        read_design(file, [change, 'parts.rod.hole="12 mm"'])


def test_a_lug_a_million_times_thinner_than_its_pin_is_pressed(tmp_path):
    """No bar is known for it, so nothing passes."""
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PIN, encoding="utf-8")
    changes = ["parts.pin.stack[1].width=2e-5 mm"]
    (result,) = check_file(file, changes, effort=Effort("formula")).parts
    static = next(check for check in result.checks if check.kind == "static")
    assert static.status is Status.UNDECIDED
    assert static.value > 1e5  # MPa


def test_where_a_lug_stands_is_no_size(tmp_path):
    """A lug at 1e-14 mm, as a script's sums leave it, is one at 0 mm."""
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PIN, encoding="utf-8")
    seats = read_design(file, ["parts.pin.stack[0].at=1e-14 mm"]).parts["pin"].geometry.seats
    assert seats[0].at == 1e-14


def test_more_positions_than_a_check_can_hold_are_refused(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PLATE, encoding="utf-8")
    with pytest.raises(DesignError, match=r"positions: must be at most 20000, got 100000"):
        check_file(file, ["cycles.turn.positions=100000"], effort=Effort("formula"))
