"""Blows of a design's contacts: by hand, the hammer's ram, drives, words, refusals."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from ballesta.commands.loads_command import loads_of_file
from ballesta.design.read import read_design
from ballesta.machine.blows import (
    blow_gates,
    blow_subject,
    blows_of,
    swing_gates,
    transients_of,
)
from ballesta.machine.drive_speed import motor_figures
from ballesta.machine.quasi_static import quasi_static_gates
from ballesta.machine.runs import MachineRuns, play_pairs, run_machine
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.validity_checks import load_gates
from ballesta.pipeline import NOT_CHECKED, _not_checked
from checks.design.errors import DesignError
from checks.models.shapes.leaf_pack import leaf_bar
from checks.part.part_loads import loads_on, stretches_of
from checks.stress.kept_models import Models
from loads import moments_of_blows
from reports.loads_page import loads_html
from reports.loads_text import loads_text

ROOT = Path(__file__).parents[3]
FORGING = "at_5_work_10"
DESIGNS = ROOT / "designs"
# a crank of 60 mm and a rod of 200 mm; the slider, 2 kg, meets a stop of 1 kN/mm at 150 mm
PAGE = ROOT / "docs" / "theory" / "blows.md"


def stop_design(tmp_path, *changes):
    """The page's own design file."""
    text = re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    file = tmp_path / "striker.toml"
    file.write_text(text)
    return file


def struck(file, overrides=()):
    design = read_design(file, overrides)
    solved = solve_cycles(design, {})
    return [blow for cycle in solved.values() for blow in blows_of(design, cycle)]


def test_the_page_tells_what_its_design_gives(tmp_path):
    told = loads_text(loads_of_file(stop_design(tmp_path)), 120)
    (line,) = re.findall(r"^blow .*(?:\n {9}.*)*", told, re.MULTILINE)
    assert line in PAGE.read_text()
    page = loads_html(loads_of_file(stop_design(tmp_path)))
    assert "<li>Blow of stop at crank.angle = 140.55 deg: 5.80 kg strike at 366 mm/s" in page


def test_a_stop_of_a_slider_crank_takes_all_its_energy_by_hand(tmp_path):
    """Of the crank (by its inertia about O), the rod (two point masses) and the slider.

    The rod's 1 kg are 1/2 kg at each end with the inertia of that about the middle: the energy of
    two points whose speeds are known. So m v^2 = I_O w^2 + (r w)^2 / 2 + 2.5 v^2.
    """
    (blow,) = struck(stop_design(tmp_path))
    spin, crank, rod = 120 * 2 * np.pi / 60, 60.0, 200.0
    at = np.arccos((crank**2 + 150.0**2 - rod**2) / (2 * crank * 150.0))
    lean = np.arcsin(crank * np.sin(at) / rod)
    speed = crank * spin * np.sin(at + lean) / np.cos(lean)
    assert blow.at == pytest.approx(np.degrees(at), rel=1e-6)
    assert blow.speed == pytest.approx(speed, rel=1e-6)
    energy = 0.5 * (1.0 * spin**2 + 0.5e-3 * (crank * spin) ** 2 + 2.5e-3 * speed**2)
    assert blow.energy[0] == pytest.approx((1 - 0.3**2) * energy, rel=1e-6)
    assert blow.impulse[0] == pytest.approx(1.3 * 2 * energy / speed, rel=1e-6)
    assert blow.per_minute == pytest.approx(120.0)


def test_the_blow_of_the_hammer_is_its_rams_and_the_leaves_pass_nothing_on():
    """The ram's own kinetic energy, which its contact loses; 100 w / (2 pi) blows a minute."""
    design = read_design(DESIGNS / "spring_hammer.toml")
    solved = solve_cycles(design, {})
    energies = {}
    for name, cycle in solved.items():
        for blow in blows_of(design, cycle):
            ram = cycle.linkage.body("ram").mass
            assert blow.mass == pytest.approx((ram, ram), rel=1e-9)
            assert blow.energy == pytest.approx((float(cycle.contacts["workpiece"].impacts[0]), 0))
            assert blow.rigid_mass > 1.5 * ram
            assert not blow.drive_struck
            assert {"C", "R", "slot"} == set(blow.open)
            energies[name] = blow.energy[0]
            spin = design.cycles[name].run.pace.speed
            assert blow.per_minute == pytest.approx(60 * spin / (2 * np.pi))
            _, spin, _, height = name.split("_")
            low, high = blow.impulse
            row = (
                f"| {spin} | {blow.per_minute:.1f} | {height} | {blow.speed:.0f} | {low:.1f} ... "
                f"{high:.1f} | {blow.energy[0] * 1e-3:.2f} |"
            )
            assert row in PAGE.read_text()
    assert len(energies) == 8
    assert energies["at_10_work_10"] > 3 * energies["at_5_work_10"]
    subject = blow_subject(design, solved)
    assert re.fullmatch(
        r"impact of up to \d\d\.\d N s and \d+\.?\d* J a blow on workpiece, in at_10_work_20; its "
        "force is unknown",
        subject,
    )


def test_what_is_not_checked_has_the_heaviest_blow_and_its_force_is_not_known(tmp_path):
    design = read_design(stop_design(tmp_path))
    solved = solve_cycles(design, {})
    machine = MachineRuns(design, {}, solved, {}, {}, solved, {}, [])
    first, second, *rest = _not_checked(design, machine)
    assert first.startswith("impact of up to 2.76 N s and 0.354 J a blow on stop, in run; ")
    assert second == "any speed change within a cycle"
    assert tuple(rest) == NOT_CHECKED
    still = MachineRuns(design, {}, {}, {}, {}, {}, {}, [])
    assert _not_checked(design, still)[0] == "impact and any speed change within a cycle"


def test_a_stiff_linkage_on_a_stiff_contact_strikes_with_anything_up_to_all_of_itself():
    """The press' bars and its stack give way alike: between the mould and the whole linkage."""
    result = loads_of_file(DESIGNS / "toggle_press_pull_through.toml")
    blows = [blow for cycle in result.cycles for blow in cycle.blows]
    assert len(blows) == 2
    for blow in blows:
        assert blow.mass == (pytest.approx(0.01), blow.rigid_mass)
        assert blow.rigid_mass > 5 * blow.mass[0]
        assert blow.impulse == pytest.approx(
            (blow.mass[0] * blow.speed, 2 * blow.mass[1] * blow.speed)
        )
        assert blow.energy == pytest.approx((0.5 * blow.mass[1] * blow.speed**2, 0.0))
        assert blow.joints == ()
    told = " ".join(loads_text(result, 200).split())
    assert "so that anything up to the rigid linkage (at least 129 kg) may strike" in told
    assert "no joint takes any" not in told


FLYWHEEL = ("[duty]", '[drive]\nflywheel = "0.5 kg m2"\n[duty]')
CONSTANT = ("[duty]", '[drive]\ncontrol = "constant"\n[duty]')


def test_a_flywheel_strikes_too_and_a_drive_that_holds_its_speed_has_no_bound(tmp_path):
    (plain,) = struck(stop_design(tmp_path))
    (heavy,) = struck(stop_design(tmp_path, FLYWHEEL))
    spin = 120 * 2 * np.pi / 60
    assert heavy.energy[0] - plain.energy[0] == pytest.approx((1 - 0.3**2) * 0.5 * 500.0 * spin**2)
    assert (plain.drive_struck, plain.drive_stated) == (True, False)
    assert (heavy.drive_struck, heavy.drive_stated) == (True, True)
    (held,) = struck(stop_design(tmp_path, CONSTANT))
    assert held.impulse[0] == np.inf
    told = " ".join(loads_text(loads_of_file(stop_design(tmp_path, CONSTANT)), 200).split())
    assert "no bound of the impulse, as the drive holds its speed" in told
    plain_data = loads_of_file(stop_design(tmp_path, CONSTANT)).to_dict()
    (cycle,) = plain_data["cycles"]
    assert cycle["blows"][0]["mass"] == [None, None]
    json.dumps(plain_data, allow_nan=False)


def test_without_restitution_both_ends_are_told(tmp_path):
    file = stop_design(tmp_path, (", restitution = 0.3", ""))
    (blow,) = struck(file)
    told = " ".join(loads_text(loads_of_file(file), 200).split())
    assert blow.restitution == (0.0, 1.0)
    assert blow.impulse[1] == pytest.approx(2 * blow.impulse[0])
    assert (blow.energy[1], blow.rebound) == (0.0, (0.0, pytest.approx(blow.speed)))
    (stated,) = struck(stop_design(tmp_path))
    for own, other in zip(blow.joints, stated.joints, strict=True):
        assert (own.x, own.y) == pytest.approx((2.0 / 1.3 * other.x, 2.0 / 1.3 * other.y))
    assert "(restitution 0 ... 1, none is stated)" in told
    assert "the drive's own inertia is not stated and adds to it" in told


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("1.5", r"forces\.stop\.restitution: must be at most 1|restitution: .*1\.5"),
        ("-0.1", r"forces\.stop\.restitution: "),
        ('"0.3"', r"forces\.stop\.restitution: must be a number"),
        ("true", r"forces\.stop\.restitution: must be a number"),
    ],
)
def test_a_restitution_that_cannot_be_is_refused(value, message, tmp_path):
    file = stop_design(tmp_path, ("restitution = 0.3", f"restitution = {value}"))
    with pytest.raises(DesignError, match=message):
        read_design(file)
    file = stop_design(tmp_path, ("restitution = 0.3", "restitutoin = 0.3"))
    with pytest.raises(DesignError, match="unknown key, did you mean restitution"):
        read_design(file)


@pytest.fixture(scope="module")
def forging(tmp_path_factory):
    """The hammer on a workpiece of 10 mm: what it answers with -> design and solved cycle."""

    def solved(answers):
        text = (DESIGNS / "spring_hammer.toml").read_text()
        old = 'at = "1123.5 mm" }'
        assert text.count(old) == 1
        file = tmp_path_factory.mktemp("forging") / "hammer.toml"
        file.write_text(text.replace(old, f'at = "1123.5 mm", blow = {answers} }}'))
        design = read_design(file)
        return design, {"at_5_work_10": solve_cycles(design, {})["at_5_work_10"]}

    return solved


def largest(cycle, joint, rows=slice(None)):
    return np.hypot(*cycle.reactions[joint].force[rows].T).max()


def test_the_hammer_forges_with_the_energy_of_its_ram(forging):
    """A plastic workpiece keeps the ram's energy at its touch; all validity checks hold.

    By hand: the ram stands until the leaves lift it, at its weight. The pin of the leaves has the
    speed v then, so the ram, with 2.4 kg of the leaves, lags by v sqrt(K m) = 0.58 kN.
    """
    design, solved = forging('{ yields = "30 kN" }')
    found = transients_of(design, solved)
    struck, whole = found.blows[FORGING], found.cycles[FORGING]
    blow = max(struck.blows, key=lambda one: one.speed)
    assert blow.blow.force.max() == pytest.approx(30e3)
    assert blow.blow.energy == pytest.approx(0.5 * 0.03985 * blow.speed**2, rel=0.03)
    assert blow.blow.energy == pytest.approx(30e3 * blow.blow.depth, rel=1e-3)
    assert struck.swung.swing.turns <= 3
    assert max(whole.equilibrium_residual.values()) < 1e-9
    assert whole.power_balance_error < 1e-9
    free, swung = found.smooth[FORGING], struck.swung.loads
    last = np.flatnonzero(swung.efforts["workpiece"] > 0.0)[-1]
    later = np.flatnonzero(free.times > free.times[last])
    peak = later[np.hypot(*swung.reactions["slot"].force[later].T).argmax()]
    lags = free.rate("workpiece")[last] * np.sqrt(51.66 * (0.03985 + 0.0024))
    expected = largest(free, "slot", [peak]) + lags * np.exp(-0.02 * np.pi / 2)
    assert largest(swung, "slot", later) == pytest.approx(expected, rel=0.03)
    for joint in ("R", "slot"):
        assert largest(whole, joint) > 1.8 * largest(solved[FORGING], joint)
    gates = [*blow_gates(found.blows), *quasi_static_gates(design, found.vibration)]
    assert not [gate.name for gate in gates if not gate.holds]
    subject = "ring-down of fast modes and stress waves in a blow, leaves that part in it"
    assert blow_subject(design, solved, found.blows) == subject


def test_the_leaves_bending_at_their_clamp_goes_on_through_the_touch(forging):
    """No moment at R jumps as the ram is stopped: inertia of the leaves carries the slot's force.

    With the inertia of a rigid pack alone it would, to less than half and to 1.4 times.
    """
    design, solved = forging('{ yields = "30 kN" }')
    cycle = transients_of(design, solved).cycles[FORGING]
    part = design.parts["leaves"]
    loaded = loads_on(design, part, {FORGING: cycle})
    moments = np.flatnonzero(moments_of_blows(cycle))
    assert np.hypot(*cycle.reactions["slot"].force[moments[:20]].T).max() > 1500.0

    def at_pivot(some):
        bar = leaf_bar(part, part.geometry, some)
        return bar.at(np.zeros(1)).moment_z[0, moments[0] - 1 : moments[20]]

    with_it, without = (at_pivot(some) for some in (loaded, replace(loaded, own_swing={})))
    assert with_it / with_it[0] == pytest.approx(1.0, abs=0.05)
    assert (without / without[0]).min() < 0.6
    own = np.array(list(loaded.own_swing.values()))
    places = np.array(list(loaded.own_swing))
    assert np.abs(own.sum(axis=0)).max() < 1e-9 * np.abs(own).max()
    assert np.abs(places @ own).max() < 1e-9 * np.abs(own).max() * np.ptp(places)


def test_a_machine_too_fast_for_its_own_forces_stays_not_valid(forging):
    """At 10 rad/s 1.66 without any blow: not valid, until what vibration adds is on the loads."""
    design, _ = forging('{ yields = "30 kN" }')
    name = "at_10_work_10"
    values = {}
    for apply in ("false", "true"):
        asked = read_design(design.file, (f"dynamics={{ apply = {apply} }}",))
        asked = replace(asked, cycles={name: asked.cycles[name]})
        found = transients_of(asked, solve_cycles(asked, {}))
        gate, *followed = quasi_static_gates(asked, found.vibration)
        assert [one.holds for one in followed] == [True] * (apply == "true")
        assert gate.value == pytest.approx(1.66, abs=0.01)
        assert gate.binding == (apply == "false")
        assert "Without the contact, by whose blows the linkage swings" in gate.meaning
        assert all(one.holds for one in blow_gates(found.blows))
        values[apply] = largest(found.cycles[name], "R")
    assert values["true"] > 1.02 * values["false"]


def test_a_blow_that_is_not_solved_leaves_its_cycle_not_valid():
    """Its impulse alone is known: the contact counts as a load, which jumps."""
    design = read_design(DESIGNS / "spring_hammer.toml")
    design = replace(design, cycles={FORGING: design.cycles[FORGING]})
    found = transients_of(design, solve_cycles(design, {}))
    (gate,) = quasi_static_gates(design, found.vibration)
    assert gate.value > 3.0
    assert gate.binding
    assert not gate.holds
    assert found.blows == {}


def test_at_other_positions_the_swing_has_modes_of_its_own(forging):
    """As at the ends of a doubt that are solved anew."""
    design, solved = forging('{ yields = "30 kN" }')
    known = transients_of(design, solved)
    coarse = read_design(design.file, ("cycles.at_5_work_10.positions=361",))
    coarse = replace(coarse, cycles={FORGING: coarse.cycles[FORGING]})
    again = transients_of(coarse, solve_cycles(coarse, {}), known.vibration)
    assert len(again.cycles[FORGING].times) != len(known.cycles[FORGING].times)
    pair = (largest(found.cycles[FORGING], "R") for found in (again, known))
    assert next(pair) == pytest.approx(next(pair), rel=0.01)


def test_a_swing_that_does_not_repeat_is_not_valid(forging):
    """Of the cycle itself, and once for both ends of a doubt."""
    design, solved = forging('{ yields = "30 kN" }')
    blows = transients_of(design, solved).blows
    assert swing_gates([blows]) == []
    struck = blows[FORGING]
    bouncing = replace(struck.swung, swing=replace(struck.swung.swing, changed=0.3))
    again = {FORGING: replace(struck, swung=bouncing)}
    (gate,) = [gate for gate in blow_gates(again) if not gate.holds]
    assert gate.name == f"{FORGING}: swing that repeats"
    assert "A workpiece that yields" in gate.cure
    (told,) = swing_gates([again, again])
    assert (told.value, told.holds) == (0.3, False)
    stiff = {FORGING: replace(struck, swung=replace(struck.swung, still=0.5))}
    broken = [gate.name for gate in blow_gates(stiff) if not gate.holds]
    assert broken == [f"{FORGING}: modes in the swing"]


@pytest.mark.parametrize("answers", ['{ stiffness = "20 kN/mm" }', '{ yields = "30 kN" }'])
def test_the_hammer_forges_by_motor_and_flywheel(forging, answers):
    """The ram strikes as where the drive is held, at the motor's speed; the motor turns on."""
    held, _ = forging(answers)
    motor = 'power="1.5 kW", speed="1430 rpm", free_speed="1500 rpm", breakdown=2.6, ratio=30'
    design = read_design(held.file, (f'drive={{ motor={{ {motor} }}, flywheel="20 kg m2" }}',))
    design = replace(design, cycles={FORGING: design.cycles[FORGING]})
    solved = solve_cycles(design, {})
    found = transients_of(design, solved)
    struck, whole = found.blows[FORGING], found.cycles
    gates = [*load_gates(design, whole), *blow_gates(found.blows)]
    assert not [gate.name for gate in gates if not gate.holds]
    assert 0.0 < struck.swung.surge < 0.1
    assert whole[FORGING].times[-1] == solved[FORGING].times[-1]
    blow = max(struck.blows, key=lambda one: one.speed)
    if "yields" in answers:
        assert blow.blow.energy == pytest.approx(0.5 * 0.03985 * blow.speed**2, rel=0.03)
    else:
        expected = blow.speed * np.sqrt(20e3 * 0.03985)
        assert 1.0 < blow.blow.force.max() / expected < 1.06
    for figure in ("work", "mean_power", "speed"):
        with_it, without = (one[FORGING].drive("drive") for one in (whole, solved))
        assert getattr(with_it, figure) == getattr(without, figure)
    with_it, without = (motor_figures(design, one[FORGING]) for one in (whole, solved))
    assert (with_it.effective, with_it.missing) == (without.effective, without.missing)
    assert len(with_it.speed) == len(whole[FORGING].times)


@pytest.mark.slow
def test_an_elastic_workpiece_is_struck_as_by_the_ram_alone_and_the_anvil_yields(forging):
    """v sqrt(k m) for half a period, at every touch; the leaves press with up to 1.1 kN besides."""
    design, solved = forging('{ stiffness = "20 kN/mm" }')
    hits = transients_of(design, solved).blows[FORGING]
    assert len(hits.blows) == len(hits.swung.swing.strikes) > 1
    for one in hits.blows:
        assert 1.0 < one.blow.force.max() / (one.speed * np.sqrt(20e3 * 0.03985)) < 1.06
        assert 1.0 < one.blow.contact / (np.pi * np.sqrt(0.03985 / 20e3)) < 1.06
    (told, *_) = blows_of(design, solved[FORGING], hits)
    assert told.solved.peak == max(one.blow.force.max() for one in hits.blows)
    assert told.solved.count == len(hits.blows)
    anvil = 'anvil = { mass = "0.5 t", stiffness = "50 kN/mm" }'
    design, solved = forging(f'{{ stiffness = "20 kN/mm", {anvil} }}')
    moved = transients_of(design, solved).blows[FORGING].blows[0]
    still = moved.speed * np.sqrt(20e3 * 0.03985)
    assert 0.9 < moved.blow.force.max() / still < 1.0


def test_a_blow_that_is_solved_is_told_by_its_force(tmp_path):
    soft = "[elastic.joints]\nB = '5 kN/mm'\n[duty]"
    answers = 'blow = { stiffness = "2 kN/mm", yields = "1 kN" }'
    file = stop_design(tmp_path, ("restitution = 0.3", answers), ("[duty]", soft))
    result = loads_of_file(file)
    told = " ".join(loads_text(result, 200).split())
    # by hand: 10 mm less the 0.7 mm of 1 kN on 2 and 5 kN/mm; gone as the slider is back by them
    assert re.search(r"struck at \d+ mm/s, 120 times a minute: force up to 1\.00 kN, gone", told)
    assert re.search(r"gone after 69\.\d ms; pressed in by 9\.3\d mm, 9\.3\d J left in it", told)
    assert "it stands in these loads" in told
    assert "the impact is not in these loads" not in told
    (cycle,) = result.to_dict()["cycles"]
    solved = cycle["blows"][0]["solved"]
    assert solved["peak"] == pytest.approx(1000.0)
    assert solved["joints"]["B"] > 100.0
    json.dumps(result.to_dict(), allow_nan=False)
    page = loads_html(result)
    assert "Blow of stop in run" in page
    assert "time since the touch [ms]" in page


@pytest.mark.parametrize(
    ("answers", "message"),
    [
        ("blow = {}", r"forces\.stop\.blow: needs yields such as"),
        ('restitution = 0.3, blow = { yields = "1 kN" }', r"stop\.restitution: follows from the"),
        ('blow = { yields = "0 N" }', r"stop\.blow\.yields: must be above 0"),
        (
            'blow = { yields = "1 kN", anvil = { mass = "1 kg" } }',
            r"blow\.anvil\.stiffness: must be",
        ),
        ('blow = { yeilds = "1 kN" }', r"unknown key, did you mean yields"),
    ],
)
def test_an_answer_that_cannot_be_is_refused(answers, message, tmp_path):
    with pytest.raises(DesignError, match=message):
        read_design(stop_design(tmp_path, ("restitution = 0.3", answers)))


def test_hits_of_a_pin_come_on_top_of_a_blow(tmp_path):
    """Their pair of forces acts along the joint's force, so that it is never less at any moment.

    Kept from the touch on, they would push against the blow for as long as it lasts.
    """
    rod = """
[drive]
flywheel = "0.5 kg m2"
[elastic.joints]
B = "5 kN/mm"
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "A", second = "B" }
material = "S355"
width = "40 mm"
thickness = "10 mm"
hole = "16 mm"
fits = { second = "D10/h9" }
[duty]"""
    answers = "restitution = 0.3", 'blow = { stiffness = "2 kN/mm", yields = "1 kN" }'
    machine = run_machine(read_design(stop_design(tmp_path, answers, ("[duty]", rod))), Models())
    own = np.hypot(*machine.solved["run"].reactions["B"].force.T)
    assert set(machine.blows) == {"run"}
    ((play,), _) = play_pairs(machine.design, machine.rigid, machine.solved)
    assert play.words.startswith("play of 0.163 mm in B")
    without, hit = (np.hypot(*end["run"].reactions["B"].force.T) for end in play.ends)
    assert_allclose(without, own)
    assert (hit >= (1.0 - 1e-9) * own).all()
    assert hit.max() > 1.2 * own.max()


def test_loads_of_a_swing_jump_at_no_touch_of_the_contact_that_it_replaces(tmp_path):
    """The spring of 1 kN/mm is touched as if slowly; a swing meets it at moments of its own."""
    design = read_design(stop_design(tmp_path))
    cycle = solve_cycles(design, {})["run"]
    assert stretches_of(cycle)[-1] == 2
    assert stretches_of(replace(cycle, swings=True))[-1] == 0


@pytest.mark.slow
def test_a_flywheel_strikes_with_all_that_it_turns(tmp_path):
    """The rigid linkage's mass at the stop, v sqrt(k m): 20 and 500 kN/mm one behind the other."""
    stiff = ("[duty]", "[drive]\nflywheel = '0.5 kg m2'\n[elastic.joints]\nB = '500 kN/mm'\n[duty]")
    answers = ("restitution = 0.3", 'blow = { stiffness = "20 kN/mm" }')
    ((rigid,), (blow,)) = (
        loads_of_file(stop_design(tmp_path, *changes)).cycles[0].blows
        for changes in ((FLYWHEEL,), (answers, stiff))
    )
    expected = rigid.speed * np.sqrt(rigid.mass[0] / (1 / 20e3 + 1 / 500e3))
    assert blow.solved.peak == pytest.approx(expected, rel=0.01)
    assert blow.solved.contact < 0.02
    # it cannot press 10 mm in and turn on: of 39 J of the flywheel's that would take 1 kJ
    broken = [
        gate
        for gate in loads_of_file(stop_design(tmp_path, answers, stiff)).gates
        if not gate.holds
    ]
    assert "run: speed of the drive in the swing" in [gate.name for gate in broken]


def pressing_torques(stiffness, yields):
    """Largest and smallest torque of the page's crank: force times rigid lever, pose by pose."""
    angle = np.linspace(0.0, 2 * np.pi, 20001)
    rod = np.sqrt(200.0**2 - (60.0 * np.sin(angle)) ** 2)
    depth = np.maximum(150.0 - 60.0 * np.cos(angle) - rod, 0.0)
    lever = 60.0 * np.sin(angle) * (1.0 + 60.0 * np.cos(angle) / rod)
    pressed_in = np.maximum(np.maximum.accumulate(depth) - yields / stiffness, 0.0)
    torque = stiffness * np.maximum(depth - pressed_in, 0.0) * lever
    return torque.max(), torque.min()


@pytest.mark.parametrize(("yields", "peak"), [("", 10.0 / (1 / 2e3 + 1 / 500e3)), ("12 kN", 12e3)])
def test_a_flywheel_presses_a_workpiece_through_the_dead_centre(tmp_path, yields, peak):
    """The crank passes it whatever the force, so 10 mm go into workpiece and pin by stiffness.

    What is pressed in for good are 10 mm less the elastic part of the yield force.
    """
    stiff = "[drive]\nflywheel = '8 kg m2'\n[elastic.joints]\nB = '500 kN/mm'\n[duty]"
    answers = 'stiffness = "2 kN/mm"' + (f', yields = "{yields}"' if yields else "")
    changes = ("restitution = 0.3", f"blow = {{ {answers} }}"), ("[duty]", stiff)
    result = loads_of_file(stop_design(tmp_path, *changes))
    assert all(gate.holds for gate in result.gates)
    (cycle,) = result.cycles
    (told,) = cycle.blows
    assert told.solved.peak == pytest.approx(peak, rel=0.03)
    assert told.solved.joints["B"] == pytest.approx(peak, rel=0.03)
    depth = 10.0 - peak * (1 / 2e3 + 1 / 500e3)
    assert told.solved.depth == pytest.approx(depth, abs=0.1)
    assert told.solved.energy == pytest.approx(peak * depth, abs=0.1 * peak)
    assert told.solved.until == told.solved.contact
    (drive,) = [one for one in cycle.efforts if one.quantity == "drive"]
    presses, pushed_on = pressing_torques(1 / (1 / 2e3 + 1 / 500e3), peak if yields else np.inf)
    assert drive.high == pytest.approx(presses, rel=0.01)
    assert drive.low == pytest.approx(pushed_on, rel=0.01)


def test_a_flywheel_that_slows_by_a_fifth_still_presses_through(tmp_path):
    """100 J of 237 at an even speed: another speed, the same 10 mm, a pose that turns."""
    stiff = "[drive]\nflywheel = '3 kg m2'\n[elastic.joints]\nB = '500 kN/mm'\n[duty]"
    answers = "restitution = 0.3", 'blow = { stiffness = "2 kN/mm" }'
    result = loads_of_file(stop_design(tmp_path, answers, ("[duty]", stiff)))
    (broken,) = [gate for gate in result.gates if not gate.holds]
    assert broken.name == "run: speed of the drive in the swing"
    assert broken.binding
    assert broken.value == pytest.approx(0.5 * 100.0 / 237.0, rel=0.02)
    assert "first blow" not in broken.meaning
    (blow,) = result.cycles[0].blows
    assert blow.solved.peak == pytest.approx(10.0 / (1 / 2e3 + 1 / 500e3), rel=0.03)


TOGGLE = """
name = "Toggle press"
ground = ["O", "G"]
[points]
O = "-300, -200 mm"
A = "-340, -200 mm"
K = "-75, -200 mm"
G = "0, 0 mm"
B = "0, -400 mm"
[bodies.crank]
pins = ["O", "A"]
mass = "2 kg"
centre = "0, 0 mm"
inertia = "0.01 kg m2"
[bodies.rod]
pins = ["A", "K"]
mass = "1 kg"
centre = "130, 0 mm"
inertia = "0.006 kg m2"
[bodies.upper]
pins = ["G", "K"]
mass = "1 kg"
centre = "100, 0 mm"
inertia = "0.003 kg m2"
[bodies.lower]
pins = ["K", "B"]
mass = "1 kg"
centre = "100, 0 mm"
inertia = "0.003 kg m2"
[bodies.ram]
pins = ["B"]
mass = "20 kg"
guide = { along = "0, 1" }
[forces.motor]
turns = "crank"
at = "O"
[forces.work]
body = "ram"
at = "B"
direction = "0, 1"
[elastic.joints]
A = "ROD"
B = "500 kN/mm"
[drive]
flywheel = "30 kg m2"
[cycles.turn]
coordinate = "crank.angle"
start = "180 deg"
pace = { coordinate = "crank.angle", speed = "100 rpm" }
[[cycles.turn.phases]]
name = "turn"
to = "540 deg"
solve = "motor"
[cycles.turn.phases.forces.work]
touches = "B.y"
at = "-422 mm"
stiffness = "20 kN/mm"
stops = false
blow = { stiffness = "20 kN/mm" }
[duty]
cycles = { turn = 1e7 }
"""


def toggle_at(angle, longer=0.0):
    """Place of the toggle's ram, its crank at an angle, its rod longer by so much."""
    bar, rod = np.hypot(75.0, 200.0), 265.0 + longer
    pin = np.array([-300.0 + 40.0 * np.cos(angle), -200.0 + 40.0 * np.sin(angle)])
    far = np.hypot(*pin)
    along = (bar**2 - rod**2 + far**2) / (2.0 * far)
    across = np.array([-pin[1], pin[0]]) / far * np.sqrt(bar**2 - along**2)
    knee = min(along * pin / far + across, along * pin / far - across, key=lambda one: one[1])
    return knee[1] - np.sqrt(bar**2 - knee[0] ** 2)


@pytest.mark.parametrize(("rod", "holds"), [("5 kN/mm", False), ("80 kN/mm", True)])
def test_a_toggle_whose_rod_gives_way_has_another_stiffness_at_its_dead_centre(
    tmp_path, rod, holds
):
    """At the touch the rod has its share of the force, at the dead centre 5.2 mm on none.

    By hand k is 1/(1/20 + 1/500 + b^2/rod) kN/mm at the touch, b the ram's way over the rod's, and
    without the last at the dead centre. The work of 5.2 mm is asked of the drive, though the
    contact as if slowly is as stiff; the links have the workpiece's force and its side alone.
    """
    file = tmp_path / "toggle.toml"
    file.write_text(TOGGLE.replace("ROD", rod))
    result = loads_of_file(file)
    touch = brentq(lambda angle: toggle_at(angle) + 422.0, np.pi, 1.9 * np.pi)
    leads = (toggle_at(touch, 1e-3) - toggle_at(touch, -1e-3)) / 2e-3
    gives = leads**2 / (float(rod.split()[0]) * 1e3)
    stiff = 1 / 20e3 + 1 / 500e3
    depth = 2 * np.hypot(75.0, 200.0) - 422.0
    (blow,), gates = result.cycles[0].blows, {gate.name: gate for gate in result.gates}
    assert blow.solved.peak == pytest.approx(depth / (stiff + gives), rel=0.015)
    assert blow.solved.joints["G"] == pytest.approx(blow.solved.peak, rel=0.01)
    pose = gates["turn: pose in the swing"]
    assert pose.value == pytest.approx(gives / (stiff + gives), rel=0.05)
    assert (pose.holds, pose.binding) == (holds, True)
    asked = 0.5 * blow.solved.peak * depth / (30e3 * (100.0 * np.pi / 30.0) ** 2)
    assert gates["turn: speed of the drive in the swing"].value == pytest.approx(asked, rel=0.02)


def test_a_blow_of_rigid_bodies_alone_is_refused_with_its_place(tmp_path):
    file = stop_design(tmp_path, ("restitution = 0.3", 'blow = { yields = "1 kN" }'))
    with pytest.raises(DesignError, match=r"cycles\.run: the blow of stop: nothing of the linkage"):
        loads_of_file(file)
