"""A machine that is drawn otherwise has the same parts under the same loads: the same mesh."""

from math import atan2, cos, degrees, radians, sin

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.motion import part_frame
from ballesta.machine.solved_cycles import solve_cycles
from checks.part.part_loads import loads_on

from ..small_machine import MACHINE, PLATE

PIN = """
[parts.pin]
joint = "O"
shape = "pin"
fixed_to = "ground"
material = "S275"
diameter = "12 mm"
stack = [
  { body = "crank", at = "0 mm", width = "12 mm" },
  { body = "ground", at = "12 mm", width = "10 mm" },
]
"""
POINTS = {"O": (0.0, 0.0), "A": (0.0, 60.0), "B": (144.0, -12.0)}
ANGLE = radians(37.0)


def turned(x, y):
    return cos(ANGLE) * x - sin(ANGLE) * y, sin(ANGLE) * x + cos(ANGLE) * y


def drawn(folder, place=lambda x, y: (x, y), length="mm", per_mm=1.0):
    """The crank and slider with its points and directions placed, in some unit of length."""
    text = MACHINE + PLATE.replace("30 mm", f"{30 * per_mm!r} {length}") + PIN
    for name, point in POINTS.items():
        x, y = (per_mm * value for value in place(*point))
        old = next(line for line in text.splitlines() if line.startswith(f"{name} = "))
        text = text.replace(old, f'{name} = "{x!r}, {y!r} {length}"')
    for key, direction in (("along", (1.0, 0.0)), ("direction", (-1.0, 0.0))):
        x, y = place(*direction)
        old = f'{key} = "{direction[0]:g}, 0"'
        assert old in text
        text = text.replace(old, f'{key} = "{x!r}, {y!r}"')
    x, y = (9.81 * value for value in place(0.0, -1.0))
    text = text.replace("[points]", f'gravity = "{x!r}, {y!r} m/s2"\n[points]')
    turn = degrees(atan2(*place(1.0, 0.0)[::-1]))
    for angle in (90, 450):
        text = text.replace(f'"{angle} deg"', f'"{angle + turn!r} deg"')
    file = folder / "drawn.toml"
    file.write_text(text, encoding="utf-8")
    design = read_design(file)
    return design, solve_cycles(design, {})


@pytest.mark.parametrize(
    "otherwise",
    [{"place": turned}, {"length": "m", "per_mm": 1e-3}, {"length": "in", "per_mm": 1 / 25.4}],
    ids=["turned by 37 degrees", "in metres", "in inches"],
)
def test_parts_and_their_loads_are_the_same_however_the_machine_is_drawn(tmp_path, otherwise):
    """Shapes to the last bit, as meshes are chaotic; forces to round-off."""
    first, solved = drawn(tmp_path)
    second, again = drawn(tmp_path, **otherwise)
    for name in ("rod", "pin"):
        assert first.parts[name].geometry == second.parts[name].geometry
        wanted = loads_on(first, first.parts[name], solved)
        found = loads_on(second, second.parts[name], again)
        for interface, wrench in wanted.wrenches.items():
            slack = 1e-9 * wanted.largest_force
            np.testing.assert_allclose(found.wrenches[interface], wrench, atol=slack)


def test_a_pin_in_the_ground_is_drawn_as_its_forces_see_it(tmp_path):
    """Its x axis points from O to the farthest point, B: 144 mm beside and 12 mm below."""
    design, solved = drawn(tmp_path)
    frame = part_frame(design, design.parts["pin"], solved["turn"])
    np.testing.assert_allclose(frame[:, 2], np.arctan2(-12.0, 144.0), rtol=1e-12)
