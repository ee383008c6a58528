"""The number of every check of the four machines follows from its derivation's written formulas."""

import json
from dataclasses import replace
from math import isfinite
from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.ladder.leaf_checks import WIDER
from checks.ladder.part_ladder import UNKNOWN
from checks.models.formula_bars import LATERAL
from checks.result.derivation import Given, Step, Superposition
from checks.result.formulas import evaluate
from checks.result.verdict import Check
from checks.store.store import from_record, to_record
from reports.derivation_text import bar_texts, derivation_text, shares_of, status_texts
from reports.files import plain

from ...misses import misses

DESIGNS = Path(__file__).parents[3] / "designs"
FEWER = {  # positions: what is derived does not depend on how many there are
    "toggle_press": "cycles.press.positions=61",
    "slider_crank": "cycles.bench.positions=61",
    "quick_return": "cycles.at_4.positions=61",
    "spring_hammer": "cycles.at_5.positions=46",
}
OF_THE_HAMMER = ("at_5", "at_10", "at_5_work_10")  # free, fast and the duty's, of twelve cycles


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.slow if name == "spring_hammer" else ())
        for name in FEWER
    ],
)
def machine(request):
    """A machine checked by formula."""
    design = read_design(DESIGNS / f"{request.param}.toml", [FEWER[request.param]])
    if request.param == "spring_hammer":
        design = replace(design, cycles={name: design.cycles[name] for name in OF_THE_HAMMER})
    return check_design(design, effort=Effort("formula"))


def sum_of(derivation, symbols):
    return sum(derivation.number(symbol) for symbol in symbols.split())


def test_every_number_and_limit_follows_from_its_formulas(machine):
    """To round-off, 1e-9 of the number (`tests.misses.ROUND_OFF`)."""
    assert machine.checks
    for check in machine.checks:
        assert check.derivation is not None, (check.part, check.quantity)
        assert misses(check.derivation, check) == "", (check.part, check.quantity)


def test_only_friction_between_leaves_widens_a_band_and_shows_its_terms(machine):
    """By how much leaf_checks has widened it; no rest is booked for anything else."""
    packs = {part.name for part in machine.parts if part.shape == "leaf_pack"}
    widened = set()
    for check in machine.checks:
        for section in check.derivation.sections:
            assert "Wider" not in section.title or section.title == WIDER
            if section.title == WIDER:
                widened.add((check.part, check.kind))
                words = " ".join(item.meaning for item in section.items)
                assert "that of leaves that slide" in words
                told = " ".join(bar_texts(check, formulas=False))
                assert "friction adds " in told
                assert "friction between the leaves" in told
    assert widened == {(name, kind) for name in packs for kind in ("static", "fatigue")}


def test_no_check_is_without_a_derivation_of_its_own(machine):
    assert not [c.quantity for c in machine.checks if UNKNOWN in c.derivation.unproved]


@pytest.mark.slow
def test_every_check_of_the_press_by_the_cheapest_models_that_settle_it_has_its_own():
    path = DESIGNS / "toggle_press.toml"
    result = check_design(read_design(path, [FEWER["toggle_press"]]), effort=Effort("auto"))
    assert {"formula", "solid", "frame"} <= {check.method for check in result.checks}
    for check in result.checks:
        assert UNKNOWN not in check.derivation.unproved, check.quantity
        assert misses(check.derivation, check) == "", (check.part, check.quantity)


def test_only_what_an_eigenvalue_gives_has_no_formula(machine):
    without = [check for check in machine.checks if check.derivation.unproved]
    sideways = [check for check in without if check.derivation.unproved == LATERAL]
    assert {check.method for check in without if check not in sideways} == {"frame"}
    assert {check.part for check in sideways} <= {"lever"}
    assert all("eigenvalue" in c.derivation.unproved for c in machine.linkage)


def test_every_finite_bar_follows_from_its_formula(machine):
    for check in machine.checks:
        bars = check.derivation.bars
        for size, symbols in (
            (check.numerical, bars.numerical),
            (check.model, bars.above),
            (check.below, bars.below),
        ):
            if size and isfinite(size):
                slack = 1e-9 * max(check.value, size)
                assert sum_of(check.derivation, symbols) == pytest.approx(size, abs=slack, rel=0)


def test_the_stresses_of_unit_loads_add_up_to_the_stress_that_is_told(machine):
    for check in machine.checks:
        for item in check.derivation.items:
            if isinstance(item, Superposition):
                whole = evaluate(f"von_mises({item.symbol})", check.derivation.values)
                assert sum(shares_of(item)) == pytest.approx(whole, rel=1e-9, abs=1e-12)


def test_the_forces_of_the_load_case_are_those_of_the_position_in_the_result(machine):
    parts = {part.name for part in machine.parts}
    for check in machine.checks:
        for case in check.derivation.cases:
            links = machine.cycles[case.cycle]["links"]
            for acts in case.acting if check.part in parts else ():
                there = links[f"{check.part} {acts.interface}"][case.index]
                assert acts.force == pytest.approx(there, rel=1e-12, abs=1e-9)


def test_a_derivation_comes_back_from_result_json_as_it_was(machine):
    for check in machine.checks:
        text = json.dumps(plain(check.to_dict()), allow_nan=False)
        again = Check.from_dict(json.loads(text))
        assert again == replace(check, model_below=again.model_below)
        assert again.derivation == check.derivation


def test_a_derivation_comes_back_from_the_store_as_it_was(machine):
    for check in machine.checks[:3]:
        again = from_record(*to_record(check))
        assert again.derivation == check.derivation


def test_what_is_told_names_the_status_and_stays_within_its_width(machine):
    for check in machine.checks:
        assert str(check.status) in status_texts(check)[-1]
        for everything in (False, True):
            text = derivation_text(check, check.kind, everything=everything, width=100)
            assert max(map(len, text.splitlines())) <= 100
    short = derivation_text(machine.deciding, machine.deciding.kind, width=100)
    assert len(short.splitlines()) <= 24


def test_a_formula_that_is_altered_is_found_out(machine):
    """Every step of the deciding check matters, or is of its bars or beside it."""
    check = machine.deciding
    altered = 0
    for number, section in enumerate(check.derivation.sections):
        for place, item in enumerate(section.items):
            if isinstance(item, Step) and item.main:
                items = list(section.items)
                items[place] = replace(item, formula=f"1.001*({item.formula})")
                sections = list(check.derivation.sections)
                sections[number] = replace(section, items=tuple(items))
                other = replace(check.derivation, sections=tuple(sections))
                assert misses(other, check)
                altered += 1
    assert altered >= 1


def test_what_was_put_in_says_where_it_comes_from(machine):
    for check in machine.checks:
        for item in check.derivation.items:
            if isinstance(item, Given):
                assert item.meaning
