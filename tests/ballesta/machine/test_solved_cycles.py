"""Masses, joints and coordinates of a design, in the linkage that is solved."""

import pytest

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of, part_masses
from checks.stress.kept_models import Models

from ...small_machine import machine


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
