"""Friction that is known to a third: the loads at both ends, in place of a validity check."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.machine.drive_speed import friction_gate, friction_pairs
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.validity_checks import load_gates
from ballesta.machine.warnings_of import design_warnings, load_warnings
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.part.part_loads import PartDoubt, _rubbing, loads_on
from checks.strength.load_doubts import load_bars
from loads import MeasuredLoads

from ...small_machine import PLATE, machine, solved

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
BAR = (4.14134e-3, (125.0, 0.0), 21.56947917)
FEW = "cycles.press.positions=61"
LOCKS = 3.0  # solvable, and four thirds of it are not: no force moves the knee at A.y = 300 mm


def press(*friction):
    design = read_design(PRESS, (*(f"friction.{one}" for one in friction), FEW))
    solved = solve_cycles(design, dict.fromkeys(("lower", "upper"), BAR))
    return design, {"press": solved["press"]}


def pins(coefficient, diameter="40 mm"):
    return f'pins={{ coefficient = {coefficient}, diameter = "{diameter}" }}'


@pytest.fixture(scope="module")
def rubbing():
    return press(pins(0.09))


def test_friction_is_a_pair_of_the_loads_with_a_third_less_and_a_third_more(rubbing):
    """Designs written with 0.06 and 0.12 have the efforts of the ends."""
    design, solved = rubbing
    (pair,), gates = friction_pairs(design, solved)
    assert not gates
    assert pair.words == "press: coefficients of friction a third lower or higher"
    for end, written in zip(pair.ends, (0.06, 0.12), strict=True):
        efforts = press(pins(written))[1]["press"].efforts
        for name, effort in efforts.items():
            largest = np.abs(effort).max()
            np.testing.assert_allclose(end["press"].efforts[name], effort, atol=1e-9 * largest)


def test_the_press_force_falls_with_friction_in_the_sense_of_its_work(rubbing):
    """Less friction leaves more force; both thirds change it alike to the first order.

    The rest is of second order, as large as the share of friction in the force.
    """
    design, solved = rubbing
    (pair,), _ = friction_pairs(design, solved)
    low, mid, high = (
        np.abs(one["press"].efforts["process"]).max()
        for one in (pair.ends[0], solved, pair.ends[1])
    )
    assert low > mid > high
    share = (low - mid) / mid
    assert (mid - high) / (low - mid) == pytest.approx(1.0, abs=3 * share)


def test_the_share_of_friction_does_not_bind_where_the_pair_is_in_the_bars():
    design, solved = press(pins(0.3, "80 mm"))
    pairs, _ = friction_pairs(design, solved)
    covered = {gate for pair in pairs for gate in pair.gates}
    name = friction_gate("press")
    alone, beside = (
        next(gate for gate in load_gates(design, solved, names) if gate.name == name)
        for names in ((), covered)
    )
    assert alone.value == beside.value > alone.limit
    assert alone.binding
    assert not beside.binding
    assert "a third lower and higher are in the error bars" in beside.told


def test_cycles_of_one_machine_have_their_friction_together(tmp_path):
    """The same cycle written twice has the bars of one; apart, one doubt more was added each."""
    text = PLATE + '[friction.pins]\ncoefficient = 0.1\ndiameter = "10 mm"\n'
    again = '[cycles.again]\nlike = "turn"\n'
    counts = "duty.cycles = { turn = 5e5, again = 5e5 }"
    found = []
    for more, overrides in (("", ()), (again, (counts,))):
        design = machine(tmp_path, text + more, *overrides)
        (pair,), gates = friction_pairs(design, solved(design))
        assert not gates
        assert len(pair.gates) == len(design.cycles)
        found.append([c.upper for c in check_design(design, effort=Effort("formula")).checks])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)


def test_without_friction_there_is_no_pair():
    assert friction_pairs(*press()) == ([], [])
    assert friction_pairs(*press(pins(0.0))) == ([], [])


def test_friction_that_locks_a_third_higher_breaks_a_validity_check():
    """A pin of the knee that rubs at four thirds of the arm at which no effort moves it."""
    design, solved = press(pins(LOCKS))
    pairs, (gate,) = friction_pairs(design, solved)
    assert not pairs
    assert gate.binding
    assert not gate.holds
    assert "press: friction a third" in gate.name


@pytest.mark.slow
def test_bars_of_a_check_reach_to_the_loads_with_other_friction():
    """By formula: value and bars of 0.09 hold the values of 0.06 and 0.12."""
    effort = Effort(fidelity="formula")

    def fatigue(coefficient):
        over = ("friction." + pins(coefficient), FEW, "parts.bar_lower.mesh.fineness=0.4")
        result = check_design(read_design(PRESS, over), effort=effort)
        part = next(part for part in result.parts if part.name == "bar_upper")
        return next(check for check in part.checks if check.kind == "fatigue")

    own, low, high = (fatigue(value) for value in (0.09, 0.06, 0.12))
    values = sorted((low.value, high.value))
    assert own.value - own.loads_below <= values[0] * (1 + 1e-6)
    assert own.value + own.loads >= values[1] * (1 - 1e-6)
    assert own.loads + own.loads_below >= 0.999 * (values[1] - values[0]) > 0.0


@pytest.mark.parametrize(("diameter", "told"), [("35 mm", 0), ("10 mm", 1)])
def test_friction_on_less_than_the_pins_own_diameter_is_told(diameter, told):
    """The couple is mu F d/2; the pin has 35 mm in the eye, where it is thinnest."""
    design, solved = press(pins(0.1, diameter))
    told_of = design_warnings(replace(design, cycles={"press": design.cycles["press"]}), {}, solved)
    warnings = [text for text in told_of if "friction" in text]
    assert len(warnings) == told
    assert all("pin_B has 35 mm, whose couple is 3.5 times" in text for text in warnings)


def test_pins_that_rub_are_a_doubt_of_the_stress_beside_them(tmp_path):
    """Friction of 0.1 on 10 mm in bores of 12: m = M/(r F) = 0.1 x 5/6, and 0.85 m of a peak.

    The rod turns to and fro under its force: the couple changes its sign, and half its range is m.
    """
    text = PLATE + '[friction.pins]\ncoefficient = 0.1\ndiameter = "10 mm"\n'
    design = machine(tmp_path, text)
    rod = design.parts["rod"]
    loads = loads_on(design, rod, solved(design))
    share = 0.1 * 5 / 6
    assert loads.rubs[0] == pytest.approx(share, rel=1e-9)
    assert 0.5 * share < loads.rubs[1] <= share

    bars = load_bars(loads, lambda _: {"static": 200.0, "fatigue": 80.0, "amplitude": 50.0})
    ends = {kind: own["pins that rub where they press"] for kind, own in bars.shares.items()}
    assert ends["static"] == pytest.approx([1 + 0.85 * share, 1 - 0.85 * share])
    assert ends["fatigue"][0] == pytest.approx(1 + 1.3 * loads.rubs[1] * 200 / 50)
    for arc, times in ((np.pi / 4, 1.3 * 2**1.2), (0.01, 0.6 / loads.rubs[1])):
        values = {"static": 200.0, "fatigue": 50.0, "amplitude": 50.0}
        narrow = load_bars(loads, lambda _, own=values: own, arc).shares
        assert narrow["static"]["pins that rub where they press"][0] == pytest.approx(
            1 + 1.1 * share
        )
        swing = narrow["fatigue"]["pins that rub where they press"][0]
        assert swing == pytest.approx(1 + times * loads.rubs[1] * 200 / 50)

    doubted = replace(loads, doubts=(PartDoubt("more", (replace(loads, rubs=(0.3, 0.0)),)),))
    own = load_bars(doubted, lambda _: {"static": 200.0}).shares["static"]
    assert own["pins that rub where they press"][0] == pytest.approx(1 + 0.85 * 0.3)
    steady = np.tile([6.0, 6.0, 0.0, 0.0, 0.0, 1.0], (3, 1))
    most, swing = _rubbing(rod, solved(design), dict.fromkeys(loads.wrenches, steady))
    assert swing == pytest.approx(most / 2)  # the force may turn in its bore

    smooth = machine(tmp_path, PLATE)
    assert not loads_on(smooth, rod, solved(smooth)).rubs[0]


def test_couples_of_a_file_are_friction_of_the_pins_up_to_a_coefficient_of_0_3(tmp_path):
    """M/(r F) in bores of 12 mm under 10 N: 0.6 N mm are 0.01; 30 N mm are more than friction.

    Half of the range counts towards a swing, 0 in it.
    """
    rod = machine(tmp_path, PLATE).parts["rod"]
    body = SimpleNamespace(angle=np.zeros(3), body=SimpleNamespace(name="rod"))
    run = MeasuredLoads("run", np.arange(3.0), None, {"rod": body})
    for couple, share in ((0.6, 0.01), (-6.0, 0.1), (30.0, 0.3)):
        wrench = np.tile([6.0, 8.0, 0.0, 0.0, 0.0, couple], (3, 1))
        steady, swing = _rubbing(rod, {"run": run}, dict.fromkeys(rod.interfaces, wrench))
        assert steady == pytest.approx(share, rel=1e-12)
        assert swing == pytest.approx(min(abs(couple) / 120, 0.3), rel=1e-12)


def test_a_life_has_as_large_a_share_of_pins_that_rub_as_the_amplitude_that_it_multiplies(tmp_path):
    text = PLATE + '[friction.pins]\ncoefficient = 0.1\ndiameter = "10 mm"\n'
    found = []
    for life in ((), ("duty.life=finite", "duty.cycles.turn=1e8", "duty.damage_so_far=0.2")):
        result = check_design(machine(tmp_path, text, *life), effort=Effort(fidelity="formula"))
        (fatigue,) = (one for one in result.parts[0].checks if one.kind == "fatigue")
        more = {words: above for words, above, _ in fatigue.doubts}
        found.append((fatigue.value, more["pins that rub where they press"] / fatigue.value))
    assert found[1][0] > 1.2 * found[0][0]
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-6)


GUIDE = """
name = "Slider with an arm"
ground = ["G"]
gravity = "0, 0 m/s2"
points = { G = "0, 0 mm", S = "500, 0 mm", E = "500, ARM mm" }
[bodies.slider]
pins = ["S", "E"]
mass = "0 kg"
inertia = "0 kg m2"
centre = "0, 0 mm"
guide = { along = "1, 0" }
[forces]
cylinder = { between = ["G", "S"] }
work = { body = "slider", at = "E", direction = "-1, 0" }
[friction]
guides = { coefficient = 0.2 }
[cycles.stroke]
coordinate = "S.x"
start = "500 mm"
pace = { coordinate = "S.x", speed = "0.1 m/s" }
positions = 3
phases = [{ name = "out", to = "700 mm", forces = { work = "1 kN" }, solve = "cylinder" }]
"""


@pytest.mark.parametrize(("arm", "told"), [("300", 1), ("1e-4", 0)])
def test_a_couple_of_a_guide_that_rubs_is_warned_of(tmp_path, arm, told):
    """1 kN on an arm of 300 mm: two bearings 100 mm apart press with 3 kN each, and none rubs."""
    path = tmp_path / "slider.toml"
    path.write_text(GUIDE.replace("ARM", arm), encoding="utf-8")
    design = read_design(path)
    cycles = solve_cycles(design, {})
    assert cycles["stroke"].efforts["cylinder"] == pytest.approx(-1000.0)
    warnings = [text for text in load_warnings(design, {}, cycles) if "guide:slider" in text]
    assert len(warnings) == told
    assert all("300 N m is left out" in text and "6e+03 N at 100 mm" in text for text in warnings)


@pytest.mark.parametrize("arm", [300.0, 20.0])
def test_two_bearings_of_a_guide_rub_with_its_couple(tmp_path, arm):
    """M = F e presses each of two bearings with M/L, and 0.02 of both rubs: F + 0.02 x 2 F e/L.

    With a weight of 10 N as well it is 5 N +- M/L on each, as much in all.
    """
    text = GUIDE.replace("ARM", f"{arm:g}").replace('"0, 0 m/s2"', '"0, -10 m/s2"')
    text = text.replace('mass = "0 kg"', 'mass = "1 kg"').replace(
        "coefficient = 0.2 }", 'coefficient = 0.02, length = "100 mm" }'
    )
    path = tmp_path / "slider.toml"
    path.write_text(text, encoding="utf-8")
    design = read_design(path)
    cycle = solve_cycles(design, {})["stroke"]
    assert cycle.efforts["cylinder"] == pytest.approx(-1000.0 * (1 + 0.02 * 2 * arm / 100))
    rubs = cycle.reactions["guide:slider"].friction_force
    assert np.abs(rubs) == pytest.approx(0.02 * 2 * 1000.0 * arm / 100)
    assert not [text for text in load_warnings(design, {}, {"stroke": cycle}) if "guide:" in text]


def test_a_guide_that_its_couple_jams_locks_the_linkage(tmp_path):
    """Pushed on an arm of 300 mm, bearings 100 mm apart, 0.2: 2 x 0.2 x 300/100 is more than 1."""
    text = GUIDE.replace("ARM", "300").replace("0.2 }", '0.2, length = "100 mm" }')
    text = text.replace("cylinder = {", "old = {").replace("work = {", "cylinder = {")
    text = text.replace("old = {", "work = {").replace('direction = "-1, 0"', 'direction = "1, 0"')
    path = tmp_path / "slider.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError, match="friction locks the linkage"):
        solve_cycles(read_design(path), {})


def test_a_length_is_of_a_guide(tmp_path):
    path = tmp_path / "slider.toml"
    text = GUIDE.replace("ARM", "300").replace("guides = { coefficient = 0.2 }", "joints = JOINTS")
    for joints, found in (
        ('{ "guide:slider" = { coefficient = 0.1, length = "50 mm" } }', 50.0),
        ('{ "guide:slider" = { coefficient = 0.1 } }', 0.0),
    ):
        path.write_text(text.replace("JOINTS", joints), encoding="utf-8")
        assert read_design(path).friction["guide:slider"].length == found
    wrong = '[friction.pins]\ncoefficient = 0.1\ndiameter = "10 mm"\n'
    wrong += '[friction.joints.B]\ncoefficient = 0.1\ndiameter = "9 mm"\nlength = "5 mm"\n'
    with pytest.raises(DesignError, match=r"joints\.B\.length: is not used, B is a pin"):
        machine(tmp_path, PLATE + wrong)
