"""Masses, joints and coordinates of a design, in the linkage that is solved."""

import numpy as np
import pytest

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of, part_masses, solve_cycles
from ballesta.machine.warnings_of import design_warnings
from checks.part.part_loads import loads_on
from checks.stress.kept_models import Models
from fem.unit_loads import inertia_of
from geometry.mesh import MassProperties

from ...small_machine import MACHINE, PLATE, machine

HEAVY = """
[parts.pin]
joint = "B"
shape = "pin"
fixed_to = "rod"
material = "C45"
diameter = "12 mm"
stack = [
  { body = "rod", at = "0 mm", width = "8 mm" },
  { body = "slider", at = "10 mm", width = "4 mm" },
  { force = "push", at = "976 mm", width = "4 mm" },
]
"""


def test_a_stated_mass_goes_before_that_of_the_part_whose_centre_and_inertia_stay(tmp_path):
    models = Models()
    plain = machine(tmp_path)
    (body, (mass, centre, inertia)), *_ = part_masses(plain, models).items()
    stated = read_design(plain.file, [f"bodies.{body}.mass=7 kg"])
    masses = part_masses(stated, models)
    assert mass != pytest.approx(7e-3)
    assert masses[body] == (7e-3, centre, inertia)
    solved = linkage_of(stated, masses).body(body)
    assert (solved.mass, solved.centre, solved.inertia) == masses[body]


def test_the_length_of_a_force_is_called_by_the_name_that_the_design_has_for_it():
    """Two forces between the same points are one coordinate under two names."""
    assert loads.Distance("ground", "D", "lower", "B").label == "distance D-B"
    cylinder = loads.Distance("ground", "D", "lower", "B", "cylinder")
    assert cylinder.label == "cylinder.length"
    assert cylinder == loads.Distance("ground", "D", "lower", "B", "spring")


def test_a_pin_is_in_the_body_that_it_turns_with_and_hands_its_bore_what_moves_it(tmp_path):
    """12 mm by 1966 mm, 5 beyond its lugs, are 1.75 kg: rod and pin by the parallel axis theorem.

    Bores with the pin's weight and inertia leave the rod's own mass in balance at 50 rad/s.
    """
    path = tmp_path / "own.toml"
    whole = MACHINE.replace('mass = "0.2 kg"\ninertia = "5e-4 kg m2"\ncentre = "80, 0 mm"\n', "")
    path.write_text(whole + PLATE, encoding="utf-8")
    mass, (x, y), inertia = part_masses(read_design(path), Models())["rod"]

    path.write_text(whole + PLATE + HEAVY, encoding="utf-8")
    design = read_design(path, ["cycles.turn.pace.speed=50 rad/s"])
    masses = part_masses(design, Models())
    pin = 7.85e-9 * np.pi * 6**2 * 1966
    length = np.hypot(144, 72)
    centre = (mass * x + pin * length) / (mass + pin)
    about = inertia + pin * (6**2 / 2) + mass * (centre - x) ** 2 + pin * (length - centre) ** 2
    got, at, turns = masses["rod"]
    assert (got, *at, turns) == pytest.approx((mass + pin, centre, y, about), rel=1e-9)

    rod = design.parts["rod"]
    loads = loads_on(design, rod, solve_cycles(design, masses))
    own = inertia_of(MassProperties(mass, np.array([x, y, 0.0]), inertia))
    left = loads.accelerations @ own.T
    for place, wrench in zip((0.0, length), loads.wrenches.values(), strict=True):
        left += wrench[:, [0, 1, 5]] + np.outer(wrench[:, 1] * place, [0.0, 0.0, 1.0])
    assert np.abs(left).max() < 1e-7 * loads.largest_force
    (doubt,) = loads_on(design, design.parts["pin"], solve_cycles(design, masses)).doubts
    assert "weight and inertia of the pin itself" in doubt.words


TURNING = """
name = "Arm with a head"
ground = ["A"]
gravity = "0, 0 m/s2"
points = { A = "0, 0 mm", B = "400, 0 mm" }
bodies.arm = { pins = ["A", "B"], mass = "10 kg", inertia = "0.05 kg m2", centre = "300, 0 mm" }
forces.motor = { turns = "arm", at = "A" }
forces.nothing = { body = "arm", at = "B", direction = "1, 0" }
[cycles.turn]
coordinate = "arm.angle"
start = "0 deg"
pace = { coordinate = "arm.angle", speed = "20 rad/s" }
positions = 13
phases = [{ name = "turn", to = "360 deg", forces = { nothing = "0 N" }, solve = "motor" }]
[parts.arm]
body = "arm"
interfaces = { first = "A", second = "B" }
material = "S355"
shape = "plate_link"
width = "50 mm"
thickness = "10 mm"
hole = "12 mm"
"""


@pytest.mark.parametrize("stated", [True, False])
def test_inertia_of_what_a_part_does_not_have_is_warned_of(tmp_path, stated):
    """The arm pulls with 10 kg at 300 mm and 20 rad/s: 1200 N, 137 N of them by its own 1.71 kg."""
    path = tmp_path / "arm.toml"
    own = 'mass = "10 kg", inertia = "0.05 kg m2", centre = "300, 0 mm" '
    path.write_text(TURNING if stated else TURNING.replace(f", {own}", " "), encoding="utf-8")
    design = read_design(path)
    masses = part_masses(design, Models())
    told = [
        text
        for text in design_warnings(design, masses, solve_cycles(design, masses))
        if "arm is stated with" in text
    ]
    part = 7.85e-9 * 10 * (400 * 50 + np.pi * 25**2 - 2 * np.pi * 6**2)
    force = (10e-3 * 300 - part * 200) * 20**2
    assert len(told) == stated
    assert all(f"{force:.3g} N, {force / 12:.2g} % of its largest force" in text for text in told)


def test_a_mass_without_inertia_is_spread_as_the_part_is(tmp_path):
    """10 kg in place of the part's own mass turn with as many times the part's inertia."""
    path = tmp_path / "arm.toml"
    own = 'mass = "10 kg", inertia = "0.05 kg m2", centre = "300, 0 mm"'
    path.write_text(TURNING.replace(f", {own}", ""), encoding="utf-8")
    mass, centre, inertia = part_masses(read_design(path), Models())["arm"]
    path.write_text(TURNING.replace(own, 'mass = "10 kg"'), encoding="utf-8")
    heavy, same, more = part_masses(read_design(path), Models())["arm"]
    assert heavy == pytest.approx(10e-3)
    assert same == centre
    assert more == pytest.approx(inertia * 10e-3 / mass)
