"""Report of a part besides its checks: assumptions, and facts of its shape and loads."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.ladder.part_facts import assumed_of, facts_of
from checks.part.loaded_part import LoadedPart
from checks.strength.part_strength import elastic_of, endurance_of
from checks.stress.solid_mesh_level import Models, solve_level
from geometry.shape import Half

from ...small_machine import PLATE, loads_of, machine

TUBE = """
[parts.rod]
body = "rod"
shape = "toggle_bar"
interfaces = { knee = "A", end = "B" }
material = "S275"
width = "40 mm"
wall = "4 mm"
hole = "16 mm"
overhang = "20 mm"
inner_radius = "2 mm"
cutout_length = "30 mm"
cutout_corner = "3 mm"
mesh = { fineness = 0.4 }
"""
PIN = """
[parts.rod]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "10 mm"
stack = [
  { body = "crank", at = "12 mm", width = "8 mm", single = SINGLE },
  { body = "rod", at = "0 mm", width = "8 mm", single = SINGLE },
]
"""
CHEEKS = "both cheeks carry the same share"
COUPLES = (
    "a couple about a bore's axis enters as an even tangential traction; keys, splines and press "
    "fits that bring it in are not modelled"
)


def told(folder, text=PLATE, couple=0.0, *, half=False, tilt=0.0, swing=()):
    """Assumptions and facts of a part pulled with 1000 N, and couples, N mm, about z and y."""
    design = machine(folder, text)
    part = design.parts["rod"]
    names = list(part.interfaces)
    wrenches = {name: [(0, 0, 0)] for name in names}
    wrenches[names[0]], wrenches[names[1]] = [(-1000, 0, couple)], [(1000, 0, -couple)]
    loads = replace(loads_of(wrenches), own_swing=dict(swing))
    loads.wrenches[names[0]][:, 4] = tilt
    shape = Half(part.geometry) if half else part.geometry
    solutions = Models().solutions(shape, part.fineness * 0.7, elastic_of(part))
    level = solve_level(solutions, 0.5, loads, 1.0, part.material.ultimate_stress, {})
    return assumed_of(LoadedPart(design, part, loads), level), facts_of(
        part,
        loads,
        solutions.mesh.mass_properties(part.material.density),
        float(np.ptp(solutions.mesh.nodes, axis=0).max()),
        endurance_of(part),
    )


def pressing(assumed):
    (found,) = [text for text in assumed if text.startswith("pins press with a cosine pressure")]
    return found


@pytest.mark.parametrize("half", [False, True])
def test_cheeks_are_told_of_where_a_part_has_two(tmp_path, half):
    """The toggle bar's tube; also of the half with one of them."""
    assumed, _ = told(tmp_path, TUBE, half=half)
    assert pressing(assumed).endswith("to 180 deg; " + CHEEKS)


@pytest.mark.parametrize("half", [False, True])
def test_a_plate_has_no_cheeks(tmp_path, half):
    assumed, _ = told(tmp_path, half=half)
    assert pressing(assumed).endswith("to 180 deg")


@pytest.mark.parametrize(("single", "cheeks"), [("true", False), ("false", True)])
def test_a_pin_has_cheeks_on_it_where_lugs_are_in_a_pair(tmp_path, single, cheeks):
    tilt = 0.0 if cheeks else 12e3  # N mm, of 1000 N on the single lug at z = 12 mm
    assumed, _ = told(tmp_path, PIN.replace("SINGLE", single), tilt=tilt)
    assert (CHEEKS in pressing(assumed)) is cheeks


def test_a_couple_about_a_bore_is_told_with_how_it_enters(tmp_path):
    """20 N m at both holes; without it neither the sentence nor the facts."""
    assumed, facts = told(tmp_path, couple=-20e3)
    assert COUPLES in assumed
    for name in ("first", "second"):
        assert_allclose(facts[f"largest couple at {name} [N m]"], 20.0)
        assert_allclose(facts[f"largest force at {name} [N]"], 1000.0)
    assumed, facts = told(tmp_path)
    assert COUPLES not in assumed
    assert not [name for name in facts if "couple" in name]


def test_a_couple_that_is_next_to_nothing_is_not_told(tmp_path):
    """1e-6 of 1000 N times a plate of some 190 mm is 0.2 N mm."""
    size = 161 + 30
    for share, expected in ((0.5e-6, False), (2e-6, True)):
        assumed, facts = told(tmp_path, couple=share * 1000 * size)
        assert (COUPLES in assumed) is expected
        assert any("couple" in name for name in facts) is expected
    assert np.isfinite(facts["largest couple at first [N m]"])


def test_a_solid_says_that_it_does_not_bend_by_its_own_inertia(tmp_path):
    words = "its bending by its own inertia is left out"
    for swing, expected in (((), False), ([(10.0, np.zeros(1))], True)):
        assumed, _ = told(tmp_path, swing=swing)
        assert any(words in text for text in assumed) is expected
