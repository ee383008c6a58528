"""Derivations of what the four machines have not: solids, FKM, lives, curves, contacts."""

from dataclasses import replace

import pytest

from ballesta.check import check_design
from ballesta.effort import Effort
from ballesta.explained.door import with_derivation
from reports.derivation import Given, Step
from reports.verdict import Status

from ..small_machine import PLATE, machine
from ..test_bush_checks import PIN
from ..test_slot_checks import LEVER

SLOT = ('points.P="144, -120 mm"', 'points.T="144, 100 mm"', 'ground=["O", "P"]')
ROLLER = '"10 mm"\ncontacts = { slot = { radius = "6 mm" } }\n'
BUSH = PIN.replace("BEARS", 'allowable = "40 MPa", pv = "1 MPa m/s"')
COLUMN = PLATE + "column = { COLUMN }\n"


def result_of(folder, text, *overrides, rung="formula"):
    return check_design(machine(folder, text, *overrides), effort=Effort(rung))


def found(result, kind, words=""):
    return next(c for c in result.checks if c.kind == kind and words in c.quantity)


@pytest.mark.parametrize(
    ("text", "overrides"),
    [
        (PLATE, ("duty.life=finite",)),
        (PLATE, ("duty.life=finite", "duty.damage_so_far=0.2")),
        (PLATE, ("duty.life=finite", "parts.rod.thickness=0.4 mm")),
        (PLATE, ("parts.rod.thickness=0.05 mm",)),
        (PLATE.replace("S275", "6082-T6"), ()),
        (COLUMN.replace("COLUMN", 'curve = "c"'), ()),
        (COLUMN.replace("COLUMN", 'curve = "a0"'), ("parts.rod.thickness=1 mm",)),
        (COLUMN.replace("COLUMN", 'crookedness = "1 mm", eccentricity = "0.3 mm"'), ()),
        (COLUMN.replace("COLUMN", 'out_of_plane = "400 mm", fork_stiffness = "1 N m/rad"'), ()),
        (BUSH, ()),
        (LEVER, SLOT),
        (LEVER.replace('"10 mm"\n', ROLLER), SLOT),
    ],
)
def test_every_number_follows_from_its_formulas(tmp_path, text, overrides):
    for check in result_of(tmp_path, text, *overrides).checks:
        assert check.derivation.misses(check.value, check.limit) == "", check.quantity
        assert not check.derivation.unproved or check.method == "frame"


@pytest.fixture(scope="module")
def solids(tmp_path_factory):
    """The rod as a solid, by Marin's chain, by FKM's, and for a finite life."""
    folder = tmp_path_factory.mktemp("solids")
    return {
        "marin": result_of(folder, PLATE, rung="solid"),
        "fkm": result_of(folder, PLATE + 'strength = "fkm"\n', rung="solid"),
        "finite": result_of(
            folder, PLATE, "duty.life=finite", "duty.damage_so_far=0.2", rung="solid"
        ),
    }


@pytest.mark.parametrize("chain", ["marin", "fkm", "finite"])
def test_a_solid_s_stresses_follow_from_its_unit_loads(solids, chain):
    for kind in ("static", "fatigue"):
        check = found(solids[chain], kind)
        assert check.method == "solid"
        assert check.derivation.misses(check.value, check.limit) == ""
        bars = check.derivation.bars
        assert check.derivation.number(bars.numerical) == pytest.approx(check.numerical, rel=1e-9)
        slack = 1e-9 * check.value
        for size, symbol in ((check.model, bars.above), (check.below, bars.below)):
            assert check.derivation.number(symbol) == pytest.approx(size, rel=1e-9, abs=slack)


def test_the_life_is_that_of_miner_s_sum(solids):
    derivation = found(solids["finite"], "fatigue").derivation
    assert derivation.number("D") == pytest.approx(derivation.number("D_a"), rel=1e-9)
    assert derivation.number("D_a") == pytest.approx(0.3 - 0.2)


def test_an_eigenvalue_says_that_no_formula_gives_it_and_stands_beside_euler(solids):
    check = found(solids["marin"], "buckling", "elastic load share")
    assert "unknowns" in check.derivation.unproved
    assert check.derivation.number("share") == pytest.approx(check.value, rel=1e-12)
    across = next(one for one in check.derivation.compared if "out of plane" in one.quantity)
    assert 0.5 < across.model / across.hand < 2.0


def test_hand_checks_stand_beside_the_solid_s_numbers(solids):
    part = solids["marin"].parts[0]
    derivation = found(solids["marin"], "static").derivation
    assert [one.hand for one in derivation.compared] == [one.hand for one in part.hand_checks]
    assert part.hand_checks


def test_the_unit_loads_of_a_solid_are_named_by_interface_and_pattern(solids):
    derivation = found(solids["marin"], "static").derivation
    names = {load.name for load in derivation.items[0].loads}
    assert {"first cos 0", "first cos 1", "second cos 2"} <= names
    assert all(load.unit for load in derivation.items[0].loads)


def test_a_column_shows_all_its_limits(tmp_path):
    derivation = found(result_of(tmp_path, PLATE), "buckling", "column in plane").derivation
    steps = {item.symbol for item in derivation.items if isinstance(item, Step)}
    assert {"sigma_E", "S", "S_P", "S_c"} <= steps
    limits = [derivation.number(symbol) for symbol in ("sigma_E", "S", "S_P", "S_c")]
    assert min(limits) > 0


def test_the_stress_of_a_pin_in_two_directions_is_findley_s(tmp_path):
    check = found(result_of(tmp_path, BUSH), "fatigue")
    assert check.quantity.startswith("Findley")
    normal = next(item for item in check.derivation.items if item.symbol == "n")
    assert isinstance(normal, Given)
    assert sum(one**2 for one in normal.value) == pytest.approx(1.0)


def test_a_check_whose_formulas_miss_it_says_so_in_words(tmp_path):
    check = found(result_of(tmp_path, PLATE), "bearing")
    off = with_derivation(replace(check, value=1.001 * check.value), check.derivation)
    assert "do not give the check's number" in off.derivation.unproved
    assert check.status is Status.PASS
