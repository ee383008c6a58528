"""Derivations of what the four machines have not: solids, FKM, lives, curves, contacts."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import numpy as np
import pytest

from ballesta.pipeline import check_design
from checks.derivations import buckling, stresses
from checks.derivations.stresses import solid_bars
from checks.design.effort import Effort
from checks.handbook.column_curves import column_force
from checks.ladder import part_ladder
from checks.ladder.leaf_checks import Friction, LeafBand
from checks.ladder.part_ladder import UNKNOWN, explained
from checks.models.formula_bars import LATERAL, column_items, stretch_items
from checks.result.derivation import BarSymbols, Derivation, Given, Section, Step
from checks.stress.error_bars import Bars
from fem.convergence import ErrorBar, discretisation_error
from geometry.parts import Pin, Seat
from reports.charts.buckling import column_curves

from ...misses import misses
from ...small_machine import PLATE, machine
from ..joints.test_bush_checks import PIN
from ..joints.test_slot_checks import LEVER

SLOT = ('points.P="144, -120 mm"', 'points.T="144, 100 mm"', 'ground=["O", "P"]')
ROLLER = '"10 mm"\ncontacts = { slot = { radius = "6 mm" } }\n'
BUSH = PIN.replace("BEARS", 'allowable = "40 MPa", pv = "1 MPa m/s"')
COLUMN = PLATE + "column = { COLUMN }\n"


@cache
def result_of(text, *overrides, rung="formula"):
    with TemporaryDirectory() as folder:
        return check_design(machine(Path(folder), text, *overrides), effort=Effort(rung))


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
        (
            COLUMN.replace("COLUMN", 'crookedness = "1 mm", eccentricity = "0.3 mm"'),
            ('cycles.turn.pace.speed="200 rad/s"',),  # inertia: it yields beside its middle
        ),
        (COLUMN.replace("COLUMN", 'out_of_plane = "400 mm", fork_stiffness = "1 N m/rad"'), ()),
        (BUSH, ()),
        (LEVER, SLOT),
        (LEVER.replace('"10 mm"\n', ROLLER), SLOT),
    ],
)
def test_every_number_follows_from_its_formulas(text, overrides):
    for check in result_of(text, *overrides).checks:
        assert misses(check.derivation, check) == "", check.quantity
        assert check.derivation.unproved in ("", LATERAL) or check.method == "frame"


@pytest.fixture(scope="module")
def solids():
    """The rod as a solid, by Marin's chain, by FKM's, and for a finite life."""
    return {
        "marin": result_of(PLATE, rung="solid"),
        "fkm": result_of(PLATE + 'strength = "fkm"\n', rung="solid"),
        "finite": result_of(PLATE, "duty.life=finite", "duty.damage_so_far=0.2", rung="solid"),
    }


@pytest.mark.parametrize("chain", ["marin", "fkm", "finite"])
def test_a_solid_s_stresses_follow_from_its_unit_loads(solids, chain):
    for kind in ("static", "fatigue"):
        check = found(solids[chain], kind)
        assert check.method == "solid"
        assert misses(check.derivation, check) == ""
        bars = check.derivation.bars
        own = sum(check.derivation.number(symbol) for symbol in bars.numerical.split())
        assert own == pytest.approx(check.numerical, rel=1e-9)
        slack = 1e-9 * check.value
        for size, symbol in ((check.model, bars.above), (check.below, bars.below)):
            parts = sum(check.derivation.number(part) for part in symbol.split())
            assert parts == pytest.approx(size, rel=1e-9, abs=slack)


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


def test_a_column_shows_its_limits():
    derivation = found(result_of(PLATE), "buckling", "column in plane").derivation
    steps = {item.symbol for item in derivation.items if isinstance(item, Step)}
    assert {"sigma_E", "S"} <= steps
    assert min(derivation.number(symbol) for symbol in ("sigma_E", "S")) > 0


def test_a_stated_curve_s_limit_is_that_of_the_chart():
    result = result_of(COLUMN.replace("COLUMN", 'curve = "c"'))
    data = result.parts[0].charts["column"]
    curve = column_curves(data)["Eurocode 3 c"]
    for plane in data["planes"]:
        own = found(result, "buckling", f"column {plane['plane']}").derivation
        assert own.number("S") == pytest.approx(curve(plane["slenderness"]), rel=1e-9)


def test_a_bar_of_the_linkage_stands_beside_euler_s_force_of_its_own_length():
    """The plate of 30 x 8 mm, bent over its 8 mm."""
    (check,) = result_of(PLATE).linkage
    (one,) = check.derivation.compared
    euler = np.pi**2 * 210e3 * (30 * 8**3 / 12) / (144**2 + 72**2)
    assert one.hand == pytest.approx(check.derivation.number("N") / euler, rel=1e-6)
    assert one.model == check.value


def test_the_stress_of_a_pin_in_two_directions_is_findley_s():
    check = found(result_of(BUSH), "fatigue")
    assert check.quantity.startswith("Findley")
    normal = next(item for item in check.derivation.items if item.symbol == "n")
    assert isinstance(normal, Given)
    assert sum(one**2 for one in normal.value) == pytest.approx(1.0)


def test_a_solid_s_eigenvalue_has_its_own_bars_beside_those_of_its_loads(solids):
    """Else `why` would find another bar in the result than what its parts add up to."""
    check = found(solids["marin"], "buckling", "elastic load share")
    assert "no formula gives it or its own error bars" in check.derivation.unproved
    assert check.derivation.bars.numerical == "e_num e_pos"
    assert misses(check.derivation, check) == ""


def test_a_roller_without_a_material_is_said_to_be_assumed():
    rolling = LEVER.replace('"10 mm"\n', ROLLER)
    derivation = found(result_of(rolling, *SLOT), "contact").derivation
    sources = {item.symbol: item.source for item in derivation.items}
    assert sources["E_2"] == sources["nu_2"] == "assumed: steel"
    stated = rolling.replace('radius = "6 mm"', 'radius = "6 mm", material = "S355"')
    derivation = found(result_of(stated, *SLOT), "contact").derivation
    assert next(item for item in derivation.items if item.symbol == "E_2").source.startswith("S355")


@pytest.fixture(scope="module")
def climbed():
    """Arguments of `explained` for every part: the rod."""
    caught = {}

    def keep(climb, checks):
        caught.setdefault(climb.part.name, (climb, checks))
        return explained(climb, checks)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(part_ladder, "explained", keep)
        result_of.__wrapped__(PLATE)  # not one that another test has asked for
    return caught


def test_a_check_of_a_new_kind_gets_a_derivation_that_says_it_has_none(climbed):
    climb, checks = climbed["rod"]
    check = replace(checks[0], kind="creep", derivation=None, model=float("inf"), model_below=None)
    (other,) = explained(climb, [check])
    assert other.derivation.unproved == UNKNOWN


def test_a_singular_place_and_a_single_mesh_are_told_apart():
    plain = Bars(ErrorBar(1.0, 1.0, 0.0, 100.0), 0.0, 0.0, "", (99.0, 100.0), (2.0, 1.0))
    singular = replace(plain, numerical=replace(plain.numerical, singular=0.4))
    assert "singular" in solid_bars(singular, "sigma")[0].words
    assert "two meshes" in solid_bars(replace(plain, values=(1.0,)), "sigma")[0].words
    assert solid_bars(plain, "sigma")[0].numerical == "e_num"


def test_the_constants_of_a_solid_s_bar_are_those_of_its_computation(monkeypatch):
    bar = ErrorBar(1.0, 1.0, 0.0, 100.0, order=3.0)
    plain = Bars(bar, 0.0, 0.0, "", (99.0, 100.0), (2.0, 1.0))
    for name, value in (("FINER", 1.7), ("SAFETY", 2.5), ("LEAST", 0.3), ("SCATTER", 0.7),
                        ("REPEATS", 0.004)):  # fmt: skip
        monkeypatch.setattr(stresses, name, value)
    items = {item.symbol: item for item in solid_bars(plain, "sigma")[1]}
    assert items["r_m"].formula == "max(h_1/h_2, 1.7)"
    assert items["e_h"].formula == "max(2.5/(r_m^3 - 1), 0.29999999999999999)*abs(sigma - v_1)"
    assert items["e_num"].formula == "max(e_h, 0.7*e_s, e_n) + 0.004*sigma + e_t"


@pytest.mark.parametrize("order", [1.0, 2.0])
@pytest.mark.parametrize(("scatter", "notch"), [(1.0, 0.0), (30.0, 0.0), (1.0, 40.0)])
def test_the_formulas_of_a_solid_s_bar_give_it(order, scatter, notch):
    """Also where a pressure ends: stress converges with order 1 there, and all scatter counts."""
    values, sizes = (85.0, 100.0), (2.0, 1.2)
    left = discretisation_error(values, sizes, order)
    bar = ErrorBar(left, scatter, 0.7, 100.0, notch=notch, order=order)
    told, items = solid_bars(Bars(bar, 0.0, 0.0, "", values, sizes), "sigma")
    items = (Given("sigma", "", 100.0), *items)
    own = Derivation((), (Section("all", items),), "sigma", "sigma")
    assert own.number(told.numerical) == pytest.approx(bar.value, rel=1e-12)


def test_a_bar_of_another_shape_is_compared_with_euler_in_words():
    """Every bar of a linkage is compared; for a shape that is none a note stands in its place."""
    result = result_of(PLATE)
    (check,) = result.linkage
    assert check.derivation.compared
    pin = Pin(seats=(Seat("lug", width=10.0),), diameter=10.0)
    shape = SimpleNamespace(body="rod", geometry=pin)
    mode = SimpleNamespace(body="rod", effective_length=2.0, compression=3.0)
    compared, notes = buckling._alone(SimpleNamespace(parts={"rod": shape}), mode, 0.5)
    assert compared == ()
    assert "no comparison with Euler's force: rod" in notes[0]


BENDING, SHEAR = np.linspace(1e6, 2e6, 9), np.linspace(3e4, 5e4, 9)


@pytest.mark.parametrize(
    ("items", "share"),
    [
        (column_items(500.0, BENDING, np.inf, 90.0), 500 / column_force(BENDING, np.inf, 90.0)),
        (column_items(500.0, BENDING, SHEAR, 90.0), 500 / column_force(BENDING, SHEAR, 90.0)),
        (column_items(0.0, BENDING, 4e4, 90.0, sideways=0.3), 0.3),
        (stretch_items(500.0, local=1e-3), 0.5),
        (stretch_items(-500.0, local=1e-3), 0.0),
    ],
)
def test_the_share_of_a_bar_follows_from_its_numbers(items, share):
    own = Derivation((), (Section("all", tuple(items)),), "share", "share")
    assert own.number("share") == pytest.approx(share, rel=1e-12)


@pytest.mark.parametrize(
    ("most", "least", "above", "below"),
    [(2.0, 0.5, "b w_up", "w_lo"), (0.5, 0.5, "b", "w_lo"), (float("inf"), 1.0, "", "")],
)
def test_friction_hands_over_its_own_terms(climbed, most, least, above, below):
    check = replace(climbed["rod"][1][0], value=100.0, numerical=0.0, model=1.0, model_below=0.0)
    items = (Given("sigma", "", 100.0), Given("L", "", check.limit), Given("b", "", 1.0))
    own = Derivation((), (Section("all", items),), "sigma", "L", BarSymbols(above="b", words="own"))
    band = LeafBand(Friction((most, most), (least, least), "solved again"))
    check = band(replace(check, kind="static"))
    assert check.model == 1.0 + max(0.0, most - 1) * 100.0
    assert check.below == max(0.0, 1 - least) * 100.0
    found = band.explained(check, own)
    assert (found.bars.above, found.bars.below) == (above, below)
    assert misses(found, check) == ""
