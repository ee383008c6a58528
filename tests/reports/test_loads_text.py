import re
from dataclasses import replace

import pytest
from rich.cells import cell_len

from checks.result.verdict import Gate
from reports.loads_text import loads_text, table
from reports.loads_words import broken_by_kind

from ..loads.machines import press_cycle, toggle
from . import loads_results


@pytest.fixture(scope="module")
def text():
    result = loads_results.result(loads_results.press(), gates=loads_results.GATES)
    return loads_text(result, 100, ["out/toggle_press/loads.html"])


def test_the_largest_process_force_stands_with_its_position(text):
    """The thesis gives 61.18 kN at x = 2 mm under 11 kN, bars of 4.14 kg and a mould of 10 kg."""
    assert re.search(r"process +solved in press +kN +0 +200 approach +61\.18 +2 press", text)


def test_reactions_stand_with_body_unit_and_position(text):
    assert "on the body" not in text
    assert text.count("what a joint does to the body under “on”") == 1
    (row,) = [line for line in text.splitlines() if re.match(r"  C +pin +lower +ground +Fx", line)]
    assert re.search(r"kN .* 5\.500 +2 press$", row)


def test_moments_and_friction_appear_where_there_are_any():
    linkage = replace(toggle(), friction={})
    bare = loads_text(loads_results.result(loads_results.shown(linkage, press_cycle(linkage))), 100)
    assert "friction" not in bare
    assert len(re.findall(r" M +N m ", bare)) == 1  # of the guide
    rough = loads_text(loads_results.result(loads_results.press(mu_pin=0.1, mu_guide=0.1)), 100)
    assert rough.count("friction M  N m") == 3
    assert rough.count("friction F  N ") == 1


def test_the_drive_stands_against_what_is_available(text):
    joined = " ".join(text.split())
    assert "cylinder: pull up to 11.00 kN at x = 7 mm of 11.31 kN available (97.3%)" in joined
    assert "peak 1100 W" in joined  # 11 kN at 0.1 m/s
    assert "push" not in joined


def test_a_drive_that_is_not_binding_is_not_called_broken(text):
    assert re.search(r"^  DOES NOT HOLD  press: time of a cycle +1\.24 +1\.00$", text, re.M)
    assert re.search(r"^  BROKEN +press: speed irregularity +5\.00 +0\.100$", text, re.M)
    assert re.search(r"^  holds +press: joints closed", text, re.M)
    assert "a flywheel of 3 kg m2" in text


def test_lines_keep_to_the_width(text):
    assert max(map(cell_len, text.splitlines())) <= 100
    narrow = loads_text(loads_results.hostile(), 80)
    assert max(map(cell_len, narrow.splitlines())) <= 80
    assert "\x1b" not in narrow
    assert "\u202e" not in narrow


def test_a_table_wraps_its_widest_column():
    lines = table(["a", "b"], [["one two three four five six", "1"]], {1}, 24)
    assert [line.rstrip() for line in lines] == [
        "  a                    b",
        "  one two three four   1",
        "  five six",
    ]


def test_gates_of_one_kind_are_told_together_with_their_cycles():
    gates = [Gate(f"at_{k}: speed irregularity", 0.1 * k, 0.1, f"flywheel {k}") for k in (1, 3, 2)]
    gates.append(Gate("at_1: joints closed", 1.0, 1e-6, "gap"))
    alike, gap = broken_by_kind(gates)
    assert alike.sentence == "speed irregularity: at_3 0.300, at_2 0.200, limit 0.100"
    assert alike.meaning == alike.told == "The worst, at_3: flywheel 3"
    assert gap.sentence == "at_1: joints closed: 1.00 > 1e-06"
    assert gap.meaning == "gap"


def test_gates_with_different_cures_tell_that_of_the_worst():
    gates = [Gate(f"at_{k}: uneven", k, 0.1, "speed", cure=f"flywheel {k}") for k in (1, 3, 2)]
    (alike,) = broken_by_kind(gates)
    assert alike.told == "The worst, at_3: speed. flywheel 3"
    (same,) = broken_by_kind([replace(gate, cure="one") for gate in gates])
    assert (same.meaning, same.cure) == ("speed", "one")
