"""Strength of parts from their design."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks.part.loaded_part import LoadedPart, bent_area
from checks.strength.part_strength import (
    beyond_size_data,
    endurance_of,
    equivalent_diameter,
    life_task,
)
from checks.stress.solid_mesh_level import Models

from ...small_machine import PLATE, machine

DESIGNS = Path(__file__).parents[3] / "designs"


def part(*section, **other):
    geometry = SimpleNamespace(stressed_evenly=other.pop("evenly", False), stressed_section=section)
    area = other.pop("area", 0.0)
    return SimpleNamespace(geometry=geometry, fkm=other.pop("fkm", None), bent_area=area)


def test_the_diameter_that_is_bent_grows_as_the_load_goes_round_a_pin():
    """Shigley's 95 % of the largest stress: 0.0766 d^2 of a bar that rotates, 0.01046 d^2 else."""
    assert equivalent_diameter(part(20.0, area=0.0766)) == 20.0
    assert equivalent_diameter(part(20.0, area=0.01046)) == pytest.approx(7.4)
    assert equivalent_diameter(part(20.0)) == pytest.approx(7.4)


@pytest.mark.parametrize("swing", [0, 20, 60, 90, 120, 180, 360])
def test_the_area_that_is_bent_is_that_of_a_force_that_swings_about_a_pin(swing):
    """A force of one size swings by phi and back through nothing: (0.01046 + phi/41.0) d^2.

    Fibres within the swing have all of its amplitude, 0.0766/pi of d^2 a radian.
    """
    angles = np.radians(np.linspace(0.0, swing, 721))
    force = np.column_stack([np.cos(angles), np.sin(angles)])
    both = np.concatenate([force, -force, 0.0 * force])  # to both sides: amplitude 1
    wanted = min(0.01046 + np.radians(swing) * 0.0766 / np.pi, 0.0766)
    assert bent_area(loads_of(both), ["turn"]) == pytest.approx(wanted, rel=0.01)
    assert bent_area(loads_of(0.0 * both), ["turn"]) == 0.0


def test_a_crank_pin_is_bent_in_more_directions_than_a_pin_of_a_ram():
    """The slider-crank's force goes round its pin on an ellipse, the punch's stays in one plane."""
    shares = []
    for design, pin in (("slider_crank", "pin_A"), ("gallery/punching_press", "pin_B")):
        stated = read_design(DESIGNS / f"{design}.toml")
        runs = solve_cycles(stated, part_masses(stated, Models()))
        loaded = LoadedPart.of(stated, stated.parts[pin], runs)
        shares.append(equivalent_diameter(loaded.part) / loaded.part.geometry.diameter)
    assert shares[0] > 0.45
    assert 0.37 <= shares[1] < 0.4


def loads_of(force):
    wrench = np.zeros((len(force), 6))
    wrench[:, :2] = force
    return SimpleNamespace(cycles={"turn": slice(0, len(force))}, wrenches={"rod": wrench})


def test_a_size_factor_beyond_the_end_of_its_data_is_told_with_the_last_that_has_data():
    """0.808 sqrt(400 mm 300 mm) = 279.9 mm: 1.51 d^-0.157 is 0.623, at 254 mm 0.633."""
    told = beyond_size_data(part(400.0, 300.0))
    assert "end at an equivalent diameter of 254 mm" in told
    assert "to 279.9 mm: 0.623 in place of 0.633" in told


@pytest.mark.parametrize(
    "within",
    [part(400.0, 240.0), part(400.0, 300.0, evenly=True), part(400.0, 300.0, fkm=object())],
    ids=["250 mm", "axial force has no size factor", "FKM has another"],
)
def test_nothing_is_told_where_the_factor_has_data_or_is_not_used(within):
    assert beyond_size_data(within) is None


ROD = PLATE.replace("plate_link", "tube_rod").replace(
    'width = "30 mm"\nthickness = "8 mm"\n',
    'tube_diameter = "8 mm"\neye_diameter = "EYE"\neye_width = "10 mm"\nfillet = "10 mm"\n',
)


@pytest.mark.parametrize(
    ("eye", "axial"),
    [
        ("20 mm", False),  # 8 mm beside the hole: its peak is above the shank's stress
        ("30 mm", True),  # 160 mm2 of it beside a shank of 50 mm2, which is pulled evenly
    ],
)
def test_a_shank_that_is_pulled_evenly_has_the_load_factor_of_axial_force(eye, axial, tmp_path):
    """Shigley, 9th ed., 6-20 and 6-26: 0.85 and no size factor; it had 1 and that of bending."""
    limit = endurance_of(machine(tmp_path, ROD.replace("EYE", eye)).parts["rod"])
    assert (limit.load, limit.size == 1.0) == ((0.85, True) if axial else (1.0, False))


def test_a_shank_between_large_eyes_has_the_curve_of_axial_force(tmp_path):
    """Eyes of 80 x 40 mm: the size factor 0.83 is the lower one; the curve starts axially."""
    text = ROD.replace("EYE", "80 mm").replace('eye_width = "10 mm"', 'eye_width = "40 mm"')
    design = machine(tmp_path, text)
    limit = endurance_of(design.parts["rod"])
    assert limit.load == 1.0
    assert 0.82 < limit.size < 0.84
    assert life_task(design.parts["rod"], design.duty).axial
