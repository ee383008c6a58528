"""Sizes that lie so far apart that no mesh can have them are refused at once, with their key."""

import pytest

from ballesta.check import check_file
from checks.design.effort import Effort
from checks.design.errors import DesignError

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
        ("parts.pin.overhang=1e10 mm", r"parts\.pin\.overhang: 1e\+10 mm beside stack\[0\]\.width"),
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


def test_more_positions_than_a_check_can_hold_are_refused(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PLATE, encoding="utf-8")
    with pytest.raises(DesignError, match=r"positions: must be at most 20000, got 100000"):
        check_file(file, ["cycles.turn.positions=100000"], effort=Effort("formula"))
