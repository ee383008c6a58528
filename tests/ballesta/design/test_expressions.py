"""Formulas of forces in a design file: units, names, what is refused, and the page's examples."""

# ruff: noqa: E501 - one refusal a line: the formula, then the wording

import math
import re
import time
from pathlib import Path

import numpy as np
import pytest

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of
from ballesta.machine.warnings_of import load_warnings
from checks.design.errors import DesignError

ROOT = Path(__file__).parents[3]
CRANK = (ROOT / "designs" / "slider_crank.toml").read_text()
BETWEEN = """[forces.gas]
between = ["O", "B"]
[forces.stop]
between = ["O", "B"]
[forces.spring]
turns = "rod"
against = "crank"
[forces.push]"""


def read(tmp_path, gas="0 N", stop="0 N", spring="0 N m", overrides=()):
    """The slider-crank with three more forces."""
    laws = f"gas = {gas}, stop = {stop}, spring = {spring}"
    laws = re.sub(r"= (0 N m|0 N)\b", r'= "\1"', laws)
    text = CRANK.replace("[forces.push]", BETWEEN)
    text = re.sub(r'push = "([^"]*)"', rf'push = "\1", {laws}', text)
    file = tmp_path / "machine.toml"
    file.write_text(text)
    return read_design(file, overrides)


def solved(design):
    name = next(iter(design.cycles))
    return loads.run_cycle(linkage_of(design, {}), design.cycles[name].run)


def formula(expression, **where):
    stated = ", ".join(
        f'{k} = "{v}"' if isinstance(v, str) else f"{k} = {v}" for k, v in where.items()
    )
    return f'{{ expression = "{expression}"' + (f", where = {{ {stated} }} }}" if where else " }")


def test_the_examples_of_the_page_are_read_and_do_what_it_says(tmp_path):
    page = (ROOT / "docs" / "design_files.md").read_text()
    found = dict(re.findall(r"`(\w+) = (\{ expression = [^`]*\})`", page))
    assert sorted(found) == ["gas", "spring", "stop"]
    run = solved(read(tmp_path, **{k: v.replace("rocker", "rod") for k, v in found.items()}))
    length = np.hypot(*run.point("slider", "B").T)
    assert run.efforts["gas"] == pytest.approx(-400 * (260 / length) ** 1.2)
    bodies = run.linkage.body_names
    turn = run.poses[:, bodies.index("rod"), 2] - run.poses[:, bodies.index("crank"), 2]
    assert run.efforts["spring"] == pytest.approx(-20e3 * turn)
    damped = 0.2 * run.rate("stop") - 1000 * np.maximum(0, 220 - length)
    assert run.efforts["stop"] == pytest.approx(damped, abs=1e-6)


def test_units_of_constants_are_converted_once(tmp_path):
    """The same spring in other units, to rounding; a plain number has none."""
    same = [
        formula("k * (gas.length - L) / n", k="5 N/mm", L="100 mm", n=2),
        formula("k * (gas.length - L) / n", k="5 kN/m", L="10 cm", n=2.0),
        formula("W / L**2 * (gas.length - L) * 0.5", W="50000 N mm", L="0.1 m"),
        formula("m * w**2 * (gas.length - L)", m="2.5 t", w="1 1/s", L="100 mm"),
        formula("k * (gas.length - L)", k="2.5 N/mm", L="100 mm"),
    ]
    runs = [solved(read(tmp_path, gas=one)).efforts["gas"] for one in same]
    for other in runs:
        assert len(other) == len(runs[-1])
        assert other == pytest.approx(runs[-1], rel=1e-12)


def test_degrees_are_angles(tmp_path):
    design = read(tmp_path, spring=formula("M * sin(crank.angle - a)", M="2 N m", a="30 deg"))
    run = solved(design)
    angle = run.poses[:, run.linkage.body_names.index("crank"), 2]
    assert run.efforts["spring"] == pytest.approx(2000 * np.sin(angle - math.radians(30)))


def test_constants_may_be_set(tmp_path):
    gas = formula("-F * (L / gas.length)**(6/5)", F="400 N", L="260 mm")
    name = re.search(r"\[cycles\.(\w+)\]", CRANK)[1]
    key = f"cycles.{name}.phases[0].forces.gas.where.F"
    one, other = read(tmp_path, gas=gas), read(tmp_path, gas=gas, overrides=(f"{key}=800 N",))
    start = [solved(design).efforts["gas"][0] for design in (one, other)]
    assert start[1] == pytest.approx(2 * start[0])


REFUSED = {
    "force and length": (formula("F + gas.length", F="1 N"), r"expression: F \+ gas\.length puts a force and a length together"),
    "a moment": (formula("F * gas.length", F="1 N"), r"expression: must come out as a force, as gas is a force; it is a moment"),
    "an arc": (formula("k * L * crank.angle", k="1 N/mm", L="1 mm"), r"it is .*; a factor of an angle is stated for each rad, such as \"60 mm/rad\""),
    "sine of a number": (formula("F * sin(30)", F="1 N"), r"sin takes an angle, 30 is a plain number"),
    "exponential of a length": (formula("F * exp(gas.length)", F="1 N"), r"exp takes a plain number, gas\.length is a length"),
    "exponent with a unit": (formula("F ** gas.length", F="1 N"), r"an exponent must be a plain number, and gas\.length is not"),
    "exponent beyond": (formula("F * 2 ** 11", F="1 N"), r"2 \*\* 11: exponents go to 10"),
    "tower": (formula("F * 9**9**9**9", F="1 N"), r"exponents go to 10"),
    "name": (formula("f * 2", F="1 N"), r"no value in where is named 'f', did you mean F\?"),
    "unused": (formula("F * 2", F="1 N", L="1 mm"), r"where\.L: is not in the expression; leave it out"),
    "no body": (formula("k * crnk.angle", k="1 N/rad"), r"no body is named 'crnk', did you mean crank\?"),
    "no coordinate": (formula("k * gas.lenth", k="1 N/mm"), r"got \"gas\.lenth\", did you mean gas\.length\?"),
    "function": (formula("F * sinn(crank.angle)", F="1 N"), r"no function is named 'sinn', did you mean sin\?"),
    "sign": (formula("F * sign(gas.length)", F="1 N"), r"a force that jumps is \{ dry = \.\.\. \} against the motion"),
    "comparison": (formula("F * (gas.length > L)", F="1 N", L="1 mm"), r"gas\.length > L is not read in a formula; a force that jumps"),
    "condition": (formula("F if gas.length else F", F="1 N"), r"a force that jumps"),
    "caret": (formula("F ^ 2", F="1 N"), r"F \^ 2 is not read in a formula; a power is written \*\*"),
    "unit in the text": (formula("-400 N"), r"numbers with units stand in where"),
    "number without unit": (formula("-400"), r"must come out as a force, as gas is a force; it is a plain number"),
    "import": (formula("__import__('os').system('true')"), r"is not read in a formula"),
    "dunder": (formula("gas.__class__"), r"must be <point>\.x"),
    "two steps": (formula("gas.length.real"), r"must be <point>\.x"),
    "lambda": (formula("(lambda: 1)()"), r"is not read in a formula"),
    "list": (formula("[F for _ in F]", F="1 N"), r"is not read in a formula"),
    "text": (formula("F * 'a'", F="1 N"), r"'a' is not read in a formula"),
    "true": (formula("F * True", F="1 N"), r"True is not read in a formula"),
    "complex": (formula("F * 1j", F="1 N"), r"1j is not read in a formula"),
    "keyword": (formula("max(0, F, key=F)", F="1 N"), r"is not read in a formula"),
    "star": (formula("max(*F, 0)", F="1 N"), r"\*F is not read in a formula"),
    "one of two": (formula("max(F)", F="1 N"), r"max takes 2 to 8 terms, max\(F\) has 1"),
    "rate of a sum": (formula("c * rate(gas.length * 2)", c="1 N s/mm"), r"rate takes a coordinate such as B\.x"),
    "huge": (formula("F * 1e999", F="1 N"), r"1e999 is beyond any machine"),
    "huge whole number": (formula("F * " + "9" * 350, F="1 N"), r"is beyond any machine"),
    "by nothing": (formula("F * (1 / 0)", F="1 N"), r"1 / 0 is no number of a machine"),
    "long": (formula("F" + " + F" * 100, F="1 N"), r"has 401 characters, at most 400 are read"),
    "deep": (formula("+".join(["F"] * 80), F="1 N"), r"has more than 60 terms within each other"),
    "nothing": (formula(""), r"is no formula such as"),
    "unit": (formula("F", F="1 Nn"), r"where\.F: must be a number or a quantity .*unit \"Nn\" is unknown, did you mean N\?"),
    "temperature": (formula("F * T", F="1 N", T="1 K"), r"where\.T: .*which is a temperature"),
    "function's name": (formula("max * 2", max="1 N"), r"where\.max: max is a function; choose another name"),
    "no text": ("{ expression = 5 }", r"gas\.expression: must be text, got 5"),
    "misspelt": ("{ expresion = '1' }", r"gas\.expresion: unknown key, did you mean expression\?"),
    "a table besides": ("{ expression = '0', over = 'B.x' }", r"gas\.over: unknown key"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_formula_that_cannot_be_meant_is_refused_at_its_key(case, tmp_path):
    gas, message = REFUSED[case]
    before = time.process_time()
    with pytest.raises(DesignError) as caught:
        read(tmp_path, gas=gas)
    assert time.process_time() - before < 5.0
    lines = str(caught.value).splitlines()
    assert any(re.search(message, line) for line in lines), lines
    assert all("forces.gas" in line for line in lines), lines


def test_a_plain_zero_has_any_unit_and_parentheses_none(tmp_path):
    deep = formula("(" * 90 + "max(0, F)" + ")" * 90, F="-1 N")
    assert solved(read(tmp_path, gas=deep)).efforts["gas"] == pytest.approx(0.0)
    assert solved(read(tmp_path, gas=formula("0"))).efforts["gas"] == pytest.approx(0.0)


def test_angles_that_are_more_than_half_a_turn_apart_as_assembled_are_warned_of(tmp_path):
    """Crank at -154 deg and rod at 153 deg on the left: 307 deg apart, 53 deg by the eye."""
    winds = formula("k * (crank.angle - rod.angle)", k="1 N m/rad")
    left = ["points.A=-90, -43.58898944 mm", "points.B=-223.3979, 25 mm"]
    for overrides, told in ((left, True), ([], False)):
        design = read(tmp_path, spring=winds, overrides=overrides)
        warnings = [text for text in load_warnings(design, {}, {}) if text.startswith("spring")]
        assert len(warnings) == told
        assert all("crank.angle = -154.2 deg and rod.angle = 152.8 deg" in w for w in warnings)
