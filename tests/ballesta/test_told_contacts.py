"""Words on contacts and drives: an eccentric press on a spring, r = 20 mm, l = 200 mm.

At the crank angle t the slider is at y = r sin t - sqrt(l2 - r2 cos2 t): the law of cosines.
"""

import re
from math import asin, cos, degrees, pi, sin, sqrt

import pytest

from ballesta.commands.loads_command import loads_of_file
from checks.design.errors import DesignError
from reports.loads_text import loads_text

PRESS = """
name = "Eccentric press"
ground = ["O"]
[points]
O = "0, 0 mm"
A = "0, 20 mm"
B = "0, -180 mm"
[bodies.ecc]
pins = ["O", "A"]
mass = "40 kg"
inertia = "0.5 kg m2"
centre = "0, 0 mm"
[bodies.rod]
pins = ["A", "B"]
mass = "8 kg"
inertia = "0.05 kg m2"
centre = "60, 0 mm"
[bodies.ram]
pins = ["B"]
mass = "60 kg"
guide = { along = "0, 1" }
[forces.motor]
turns = "ecc"
[forces.die]
body = "ram"
at = "B"
direction = "0, 1"
[cycles.run]
coordinate = "ecc.angle"
start = "90 deg"
pace = { coordinate = "ecc.angle", speed = "120 rpm" }
[[cycles.run.phases]]
name = "turn"
to = "450 deg"
solve = "motor"
forces = { die = { touches = "B.y", at = "-210 mm", stiffness = "500 N/mm" } }
"""
TOUCH = asin((200**2 - 210**2 - 20**2) / (2 * 20 * 210))  # of the crank, where y = -210 mm
SPEED = (
    4
    * pi
    * (20 * cos(TOUCH) - 400 * cos(TOUCH) * sin(TOUCH) / sqrt(200**2 - 400 * cos(TOUCH) ** 2))
)  # mm/s of the slider there, at 120 rpm
DOWN = ('direction = "0, 1"', 'direction = "0, -1"')


@pytest.fixture
def told(tmp_path):
    def of(*changes, cycle=True):
        text = PRESS
        for old, new in changes:
            assert text.count(old) >= 1, old
            text = text.replace(old, new)
        file = tmp_path / "press.toml"
        file.write_text(text)
        result = loads_of_file(file)
        return (result.cycles[0] if cycle else result), " ".join(loads_text(result, 100).split())

    return of


def test_a_contact_is_told_with_its_own_borders_speed_and_energy(told):
    cycle, text = told()
    (contact,) = cycle.contacts
    (span,) = contact.spans
    assert span.start == pytest.approx(180 - degrees(TOUCH), abs=1e-6)
    assert span.stop == pytest.approx(360 + degrees(TOUCH), abs=1e-6)
    assert span.approach_speed == pytest.approx(abs(SPEED), rel=1e-9)
    assert span.energy == 0.0  # a rigid linkage drives the ram into the spring and loses nothing
    assert "die at B.y = -210 mm: touches from ecc.angle = 212.39 to 327.61 deg (met at" in text
    assert "die touches at B.y = -210 mm (500.0 N/mm)" in text
    assert "is this the other side" not in text


def test_a_force_that_points_down_touches_at_the_coordinate_that_was_written(told):
    cycle, text = told(DOWN, ('"-210 mm"', '"-190 mm"'))
    assert "die touches at B.y = -190 mm" in text
    assert "die at B.y = -190 mm: touches 2 times" in text
    assert "already pressed by 10.0 mm at the start: is the contact on the other side?" in text
    first, last = cycle.contacts[0].spans
    assert first.approach_speed is None
    assert last.approach_speed > 0.0


def test_every_touch_of_a_long_cycle_is_counted_and_four_are_told(told):
    cycle, text = told(('"450 deg"', '"2250 deg"'))
    (contact,) = cycle.contacts
    assert [span.start for span in contact.spans] == pytest.approx(
        [180 - degrees(TOUCH) + 360 * k for k in range(6)], abs=1e-6
    )
    assert "touches 6 times from ecc.angle" in text
    assert "and 2 more" in text
    assert contact.approach_speed == pytest.approx(abs(SPEED), rel=1e-9)


def test_a_contact_that_lasts_from_one_phase_to_the_next_is_one_with_both_named(told):
    """Down to the lower dead centre and up again, the mirrored way."""
    phase = PRESS[PRESS.index("[[cycles") :]
    up = phase.replace('"turn"', '"back"').replace('"450 deg"', '"90 deg"')
    down = phase.replace('"450 deg"', '"270 deg"')
    cycle, text = told((phase, down + up))
    (span,) = cycle.contacts[0].spans
    assert (span.start_phase, span.stop_phase) == ("turn", "back")
    assert span.stop == pytest.approx(180 - degrees(TOUCH), abs=1e-6)
    assert "from ecc.angle = 212.39 deg in turn to 212.39 deg in back (met at" in text


def test_a_contact_that_always_or_never_touches_says_so(told):
    _, always = told(('"-210 mm"', '"-100 mm"'))
    assert "die at B.y = -100 mm: touches all the time; already pressed by 80.0 mm" in always
    assert "impact of what is touched" not in always
    _, never = told(('"-210 mm"', '"-250 mm"'))
    assert "does not touch in this cycle, 30.0 mm stay free" in never


@pytest.mark.slow
def test_a_contact_that_is_all_blow_is_not_told_to_stay_free(told):
    """A flywheel that cannot press it through has its first blow; one that can, the whole touch.

    By hand 10 mm less those of 3 kN on 20 and 100 kN/mm are pressed in then.
    """
    soft = "[elastic.joints]\nB = '100 kN/mm'\n[drive]\nflywheel = '0.5 kg m2'\n[cycles.run]"
    answers = 'blow = { stiffness = "20 kN/mm", yields = "3 kN" }'
    changes = ("[cycles.run]", soft), ('stiffness = "500 N/mm"', answers)
    _, said = told(*changes)
    assert "die at B.y = -210 mm: touches in its blow alone" in said
    assert "force up to 3.00 kN" in said
    cycle, said = told(*changes, ("0.5 kg m2", "50 kg m2"))
    assert "die at B.y = -210 mm: touches from ecc.angle = 212.37 to 327.63 deg" in said
    assert cycle.blows[0].solved.depth == pytest.approx(10.0 - 3.0 * (1 / 20 + 1 / 100), rel=2e-3)


def test_what_the_contact_does_to_the_ram_is_told(told):
    """Rigid contact and elastic rod stop it; of two springs in series each takes its share."""
    assert "ram keeps its acceleration" in told()[1]
    rod = ('centre = "60, 0 mm"', 'centre = "60, 0 mm"\nelastic = { axial = "1 MN" }')
    rigid = ('stiffness = "500 N/mm"', "stops = true")
    assert "ram is held by it: no acceleration along the force" in told(rod, rigid)[1]
    # near the lower dead centre l / EA = 1/5000 mm/N gives way in series with 1/5000
    soft = ('stiffness = "500 N/mm"', 'stiffness = "5000 N/mm"')
    share = re.search(r"ram follows it: loses up to ([\d.]+) %", told(rod, soft)[1])
    assert float(share[1]) == pytest.approx(50, abs=1)
    free = ('stiffness = "500 N/mm"', 'stiffness = "5000 N/mm", stops = false')
    assert "ram keeps its acceleration" in told(rod, free)[1]


def test_the_mean_power_is_told_to_be_without_the_impact(told):
    """Where a rigid die stops the ram; its own weight shortens the rod by 0.1 mm at the touch."""
    rod = ('centre = "60, 0 mm"', 'centre = "60, 0 mm"\nelastic = { axial = "1 MN" }')
    cycle, text = told(rod, ('stiffness = "500 N/mm"', "stops = true"))
    assert cycle.contacts[0].energy == pytest.approx(0.5 * 0.06 * SPEED**2, rel=0.05)
    said = r"the mean power does not contain the impact of what is touched, 1\.\d+ J a cycle"
    assert re.search(said, text)
    assert "impact of what is touched" not in told()[1]


def test_a_cycle_that_is_not_closed_is_told_and_warned_of_in_the_duty(told):
    half = ('"450 deg"', '"200 deg"')
    result, text = told(half, ("[forces.motor]", "[duty]\ncycles = { run = 1e6 }\n[forces.motor]"),
                        cycle=False)  # fmt: skip
    assert "not closed: ends in another pose than it starts from" in text
    assert [w for w in result.warnings if "stands in the duty but is not closed" in w]
    alone, _ = told(half, cycle=False)
    assert not [w for w in alone.warnings if "not closed" in w]
    assert "not closed" not in told()[1]


def test_evenness_is_asked_of_a_steady_speed_only(told):
    """A drive that changes its speed has an irregularity of its own."""
    rising = ('speed = "120 rpm"', 'speed = "120 rpm", acceleration = "1 rad/s2"')
    law = ('speed = "120 rpm"', 'law = "cycloidal", time = "1 s"')
    assert "to keep within 10 % of its mean speed" in told()[1]
    for pace in (rising, law):
        assert "its speed within" not in told(pace)[1]
        assert "irregular" not in told(pace)[1]


def test_without_masses_no_flywheel_is_told(told):
    masses = [
        (f'mass = "{mass} kg"', 'mass = "0 kg"') for mass in (40, 8, 60)
    ] + [('inertia = "0.5 kg m2"', 'inertia = "0 kg m2"'),
         ('inertia = "0.05 kg m2"', 'inertia = "0 kg m2"')]  # fmt: skip
    result, text = told(*masses, cycle=False)
    assert "nothing that it drives has a mass" in text
    assert "∞" not in text
    assert "flywheel" not in text
    assert not [gate for gate in result.gates if "irregularity" in gate.name]


def test_the_friction_s_convention_is_told_once_and_only_where_there_is_friction(told):
    friction = ("[forces.motor]", "[friction]\nguides = { coefficient = 0.1 }\n[forces.motor]")
    assert told(friction)[1].count("couple M of a guide does not add to it") == 1
    assert "couple M of a guide" not in told()[1]


def test_what_a_phase_cannot_do_is_told_at_its_key_without_its_names(told):
    table = "die = { over = 'ecc.angle', at = ['0 deg', '90 deg'], force = ['0 N', '1 N'] }"
    law = 'die = { touches = "B.y", at = "-210 mm", stiffness = "500 N/mm" }'
    with pytest.raises(DesignError) as refused:
        told((law, table))
    assert refused.value.key == "cycles.run.phases[0]"
    assert "cycle 'run'" not in refused.value.problem
