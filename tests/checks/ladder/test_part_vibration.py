"""Frequencies that a part's facts tell."""

import numpy as np
import pytest

from checks.ladder.solid import frequency_facts
from checks.part.loaded_part import FIRST
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Models

from ...small_machine import PLATE, machine


def test_a_link_swings_like_a_pinned_beam_sideways_first(tmp_path):
    """30 x 8 mm over 160 mm, S275: pi/2 sqrt(EI/(rho A L^4)) = 731 Hz sideways by hand.

    Its round ends reach 15 mm beyond the pins: they add inertia, the holes take stiffness away.
    """
    part = machine(tmp_path, PLATE).parts["rod"]
    solutions = Models().solutions(part.geometry, FIRST * part.fineness, elastic_of(part))
    ((name, said),) = frequency_facts(part, solutions).items()
    assert "[Hz]" in name
    first, second = (text.split(" ", 1) for text in said.split(";")[0].split(", "))
    length = 160.0
    by_hand = np.pi / 2 * np.sqrt(210e3 * 8**2 / 12 / (7.85e-9 * length**4))
    assert first[1] == "out of plane"
    assert float(first[0]) == pytest.approx(by_hand, rel=0.15)
    assert float(first[0]) < by_hand
    assert float(second[0]) > float(first[0])
