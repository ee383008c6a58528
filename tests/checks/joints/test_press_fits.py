"""Bushes that are pressed into lugs: by Lame's rings, by formula and solid, in design files."""

import json
import re
from dataclasses import replace
from functools import partial
from io import StringIO
from math import inf
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.commands.export import export_part
from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.by_formula import not_checked
from checks.derivations.stresses import static
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.handbook.fits import (
    LARGEST,
    LEAST,
    MIDDLE,
    PressFit,
    interferences_of,
    ring_flexibility,
)
from checks.ladder.climb import start_climb
from checks.ladder.levels import first_level, level_on
from checks.models import shapes
from checks.models.checked import rung_level
from checks.models.formula_points import PRESSED_IN
from checks.models.in_bores import Arcs, in_bores
from checks.part.loaded_part import LoadedPart
from checks.stress.clearances import values_at
from checks.stress.judged import RaisedInBores, StaticPeak, direct_under
from checks.stress.solid_mesh_level import Models
from fatigue import goodman
from reports.what_if import what_if

from ...small_machine import MACHINE, PLATE, machine, solved

FORMULA = Effort("formula")
DESIGNS = Path(__file__).parents[3] / "designs"
BUSH = 'length = "8 mm", allowable = "40 MPa"'
STEEL = f'{BUSH}, material = "S355"'
FIT = f'{STEEL}, fit = "0.02 .. 0.04 mm"'
PIN = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "S275"
diameter = "10 mm"
stack = [
  { body = "crank", at = "12 mm", width = "8 mm" },
  { body = "rod", at = "0 mm", width = "8 mm", bush = { BUSH } },
]
"""
LINK = PLATE.replace('hole = "12 mm"', 'hole = "15 mm"\nsecond_hole = "12 mm"').replace(
    "fineness = 0.5", "fineness = 0.9"
)


def link(folder, bush=FIT, more="", pin="12.5 mm"):
    """A flat link whose first bore takes half of its width, with a bush of 15 x 12.5 mm in it."""
    text = LINK.replace("[parts.rod]\n", f"[parts.rod]\n{more}\n")
    return machine(folder, text + PIN.replace("BUSH", bush).replace("10 mm", pin, 1))


def loaded_link(folder, *args, **changes):
    design = link(folder, *args, **changes)
    return LoadedPart.of(design, design.parts["rod"], solved(design))


def refused(folder, *args, **changes):
    with pytest.raises(DesignError) as error:
        link(folder, *args, **changes)
    return str(error.value)


def two_rings(outer, fit, inside=0.0):
    """Pressure, and closing on diameter, of two of Lame's rings: s = A - B/r^2 across, A + B/r^2.

    All four constants and the pressure in one system: tractions at three radii, and what closes.

    inside  MPa, pressure in the bush
    """
    (a, b, c), (young, nu) = (fit.radius / fit.ratio, fit.radius, outer * fit.radius), (210e3, 0.3)

    def moved(r, e, v):  # u = r (s_t - nu s_r)/E by A and B
        return np.array([r * (1 - v), (1 + v) / r]) / e

    own = fit.youngs_modulus, fit.poisson_ratio
    rows = np.zeros((5, 5))  # A and B of the bush, of the lug, p
    rows[0, :2] = 1, -1 / a**2
    rows[1, :2], rows[1, 4] = (1, -1 / b**2), 1
    rows[2, 2:4], rows[2, 4] = (1, -1 / b**2), 1
    rows[3, 2:4] = 1, -1 / c**2
    rows[4, :2], rows[4, 2:4] = -moved(b, *own), moved(b, young, nu)
    found = np.linalg.solve(rows, [-inside, 0, 0, 0, fit.interference / 2])
    return found[4], -2 * moved(a, *own) @ found[:2]


@pytest.mark.parametrize("outer", [1.3, 2.0, 1e9])
@pytest.mark.parametrize("ratio", [1.05, 1.2, 3.0])
@pytest.mark.parametrize("share", [LEAST, LARGEST])
def test_two_rings_hold_each_other_as_lame_says(outer, ratio, share):
    fit = PressFit(0.02, 0.04, 7.5, ratio, 90e3, 0.34, share)
    pressure, closing = two_rings(outer, fit)
    lug = ring_flexibility(inf if outer == 1e9 else outer, 210e3, 0.3)
    assert_allclose(fit.pressure(lug), pressure, rtol=1e-12)
    assert_allclose(fit.closing(lug), closing, rtol=1e-11)


@pytest.mark.parametrize("outer", [1.3, 2.0])
@pytest.mark.parametrize("ratio", [1.05, 1.2, 3.0])
@pytest.mark.parametrize("even", [1.0, -7.0])
def test_pressure_in_a_bush_reaches_the_lug_as_lame_says(outer, ratio, even):
    """Pressure in the bush, even on the bore by its radius, and the bush's own are the rings'."""
    fit = PressFit(0.02, 0.04, 7.5, ratio, 90e3, 0.34)
    lug = ring_flexibility(outer, 210e3, 0.3)
    both, _ = two_rings(outer, fit, even * ratio)
    (pressure,) = fit.pressures(lug, np.zeros(1), np.array([even]))
    if pressure > fit.pressure(lug):
        assert_allclose(even + pressure, both, rtol=1e-12)
    else:  # an opening is left out
        assert even + fit.pressure(lug) > both


@pytest.mark.parametrize(
    ("code", "diameter", "least", "largest"),
    [
        ("H7/p6", 44, 1, 42),
        ("H7/r6", 50, 9, 50),
        ("H7/r6", 50.001, 11, 60),  # finer steps: 50 to 65
        ("H7/s6", 65.001, 29, 78),
        ("H6/s5", 400, 172, 233),
    ],
)
def test_interference_is_that_of_the_tables(code, diameter, least, largest):
    assert interferences_of(code, diameter) == (least / 1000, largest / 1000)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("H8/p7", "may leave no interference: -13 um at 44 mm"),
        ("H7/n6", "bores H and what is pressed in p, r and s, not H/n"),
        ("F7/s6", "bores H and what is pressed in p, r and s, not F/s"),
        ("H4/s6", "from 5 to 11, not 4"),
        ("p6", "reads bore/pin"),
    ],
)
def test_a_press_fit_that_may_be_none_is_refused(code, words):
    with pytest.raises(ValueError, match=words):
        interferences_of(code, 44.0)


def test_limits_that_no_opened_table_has_are_refused():
    with pytest.raises(ValueError, match="limits of r are not known at 3 mm"):
        interferences_of("H6/r5", 3.0)


def press_columns(model):
    return [k for k, (name, _) in enumerate(model.units) if name.endswith(PRESSED_IN)]


def test_formula_and_solid_agree_on_pressure_and_stress_and_the_ring_does_not(tmp_path):
    """d/W = 0.5. Ring of that ratio: pressure 1.1 % less, its hoop stress 8 % less than beside it.

    The formula's band is 4 % either way (45 solids under pins' pressure alone).
    """
    loaded = loaded_link(tmp_path)
    model = shapes.model_of(loaded.part, loaded.loads)
    level = first_level(loaded, Models())
    (column,) = press_columns(model)
    force = model.history.coefficients[column]
    assert np.ptp(force) == 0.0  # its pin opens the bore
    assert_allclose(force, level.lasting["first"], rtol=2e-3)
    fit, material = loaded.part.press_fits["first"], loaded.part.material
    ring = ring_flexibility(2.0, material.youngs_modulus, material.poisson_ratio)
    assert 0.98 < fit.pressure(ring) * fit.per_pressure(8.0) / force[0] < 1.0
    formula, solid = model.history.peaks_by_point(), level.history.peaks_by_point()
    rim = np.array(model.places) == "first"
    bore = np.linalg.norm(level.history.points[:, :2], axis=1) < 7.51
    assert_allclose(formula[rim].max(), solid[bore].max(), rtol=0.03)
    hoop = fit.pressure(ring) * 5 / 3
    assert np.sqrt(hoop**2 + fit.pressure(ring) ** 2 + hoop * fit.pressure(ring)) < (
        0.95 * solid[bore].max()
    )


@pytest.mark.slow
def test_compression_past_a_bore_makes_its_bush_press_more():
    """Uniform compression closes a hole by s/E of its radius in the mean.

    300 MPa in the gross section of the pumpjack's beam, an interference of a thousandth.
    """
    design = read_design(DESIGNS / "gallery" / "pumpjack.toml", [])
    part = design.parts["beam"]
    loaded = LoadedPart.of(design, part, solved(design))
    level = first_level(loaded, Models())
    bore = level.solutions.mesh.interfaces["S"]
    wrenches = {name: np.zeros((3, 6)) for name in loaded.loads.wrenches}
    wrenches["H"][:, 0] = 300 * 398 * 40 * np.array([0, 1, 0.5])
    wrenches["T"][:, 0] = -wrenches["H"][:, 0]
    fit = PressFit(0.12, 0.12, 60.0, 2.0, 206e3, 0.3)
    pressures, strains = [], []
    for sign in (1, -1):  # pulled past the bore, the bush presses as with no load
        loads = replace(
            loaded.loads,
            wrenches={name: sign * rows for name, rows in wrenches.items()},
            accelerations=np.zeros((3, 4)),
            cycles={"press": slice(0, 3)},
            doubts=(),
            press_fits={"S": fit},
        )
        model = shapes.model_of(part, loads)
        (column,) = press_columns(model)
        solid = level_on(loaded.under(loads), level.solutions, 0.7, 100.0).lasting["S"]
        found = np.array([model.history.coefficients[column], solid])
        pressures.append(found / (np.pi * bore.radius * bore.length))
        rim = np.array(model.places) == "S"
        place = model.history.points[rim][:, :2] - bore.centre[:2]
        across, along = (place / bore.radius).T
        others = np.delete(np.arange(len(model.units)), column)
        stress = model.history.basis[rim][:, :, others] @ model.history.coefficients[others]
        hoop = np.einsum("ki,kin->kn", np.column_stack(
            [along**2, across**2, -2 * across * along]), stress[:, [0, 1, 3]])  # fmt: skip
        strains.append(-hoop.mean(axis=0) / part.material.youngs_modulus)
    closed, still = pressures
    assert_allclose(closed[0], closed[1], rtol=0.06)
    assert closed[:, 1].min() > 1.5 * still.max()
    assert_allclose(still[0], still[1], rtol=0.01)
    assert np.ptp(still, axis=1).max() == 0.0
    lug = fit.interference / 120 / still - fit.flexibility
    own = strains[0] / (fit.flexibility + lug[0])  # by the stress that the formula tells on the rim
    assert_allclose(closed[0], still[0] + own, rtol=1e-6)
    strain = 300 / 206e3 * np.array([0, 1, 0.5])
    assert_allclose(closed, (fit.interference / 120 + strain) / (fit.flexibility + lug), rtol=0.1)


def test_what_is_pressed_in_lasts_as_a_mean_stress(tmp_path):
    """The path of each point is moved by one stress: no amplitude more, and another mean."""
    silent, pressed = (loaded_link(tmp_path, bush) for bush in (STEEL, FIT))
    models = [shapes.model_of(one.part, one.loads) for one in (silent, pressed)]
    (column,) = press_columns(models[1])
    stresses = [m.history.basis @ m.history.coefficients for m in models]
    added = stresses[1] - stresses[0]
    lasting = models[1].history.basis[:, :, column] * models[1].history.coefficients[column, 0]
    assert_allclose(added, np.repeat(lasting[:, :, None], added.shape[2], axis=2), atol=1e-9)
    rim = np.array(models[0].places) == "first"
    limits = np.full(rim.sum(), 120.0)
    before, after = (
        goodman(m.history.basis[rim], m.history.coefficients, limits, 430.0) for m in models
    )
    assert_allclose(after.amplitude, before.amplitude, rtol=1e-9)
    assert after.mean.max() > 10 * before.mean.max()


def test_both_ends_of_the_interference_are_in_the_band(tmp_path):
    def estimate(bush):
        climb = start_climb(loaded_link(tmp_path, bush))
        climb.by_formula()
        return {kind: one.check for kind, one in climb.best.items()}

    found = estimate(FIT)
    ends = [estimate(FIT.replace("0.02 .. 0.04", end)) for end in ("0.02", "0.04")]
    for kind in ("static", "fatigue"):
        check = found[kind]
        low, high = (end[kind].value for end in ends)
        assert low < check.value < high
        assert_allclose([check.loads, check.loads_below], [high - check.value, check.value - low],
                        rtol=0.02)  # fmt: skip
        assert "interference of the bush in first, 0.02 to 0.04 mm" in check.note


SECOND = (
    PIN.replace("pin_A", "pin_B")
    .replace('joint = "A"', 'joint = "B"')
    .replace('"crank"', '"slider"')
)


def test_bushes_in_two_bores_are_at_the_same_end_together(tmp_path):
    """With one at its least alone the other one, at its middle, would hold the peak."""

    def static_check(end):
        bush = f'{STEEL}, fit = "{end}"'
        text = LINK + (PIN + SECOND).replace("BUSH", bush).replace('"10 mm"', '"10.5 mm"')
        design = machine(
            tmp_path, text.replace("[parts.rod]\n", '[parts.rod]\ntilt_held_at = "first"\n')
        )
        climb = start_climb(LoadedPart.of(design, design.parts["rod"], solved(design)))
        climb.by_formula()
        return climb.best["static"].check

    whole, least, most = map(static_check, ("0.005 .. 0.03 mm", "0.005 mm", "0.03 mm"))
    assert least.value < 0.5 * whole.value
    assert_allclose(whole.value - whole.loads_below, least.value, rtol=0.02)
    assert_allclose(whole.value + whole.loads, most.value, rtol=0.02)
    assert "interference of the bush in first" in whole.note
    assert "and of the bush in second" in whole.note


@pytest.mark.slow
def test_a_load_factor_leaves_the_bush_and_the_page_follows_neither(tmp_path):
    """Half of the loads is less than half as safe again; the page's slider would have doubled."""
    design = link(tmp_path)
    result = check_design(design, effort=FORMULA)
    data = json.loads(str(what_if(result)))
    (load,) = [lever for lever in data["levers"] if "load_factor" in lever["sets"][0]]
    for name, check in zip((c["name"] for c in data["checks"]), data["checks"], strict=True):
        if name.startswith(("rod static", "rod fatigue")):
            assert check["load"] == 0
            (rows,) = [p["rows"] for p in check["pins"] if data["levers"][p["lever"]] == load]
            assert [k for k, row in enumerate(rows) if row] == [load["now"]]
    text = LINK + PIN.replace("BUSH", FIT).replace("10 mm", "12.5 mm", 1)
    half = check_design(machine(tmp_path, text, "load_factor=0.5"), effort=FORMULA)
    one, other = (next(c for c in r.checks if c.kind == "static") for r in (result, half))
    assert other.safety < 1.5 * one.safety


def test_a_bush_in_a_part_without_load_has_its_stress(tmp_path):
    loaded = loaded_link(tmp_path)
    nothing = replace(
        loaded.loads,
        wrenches={k: 0 * w for k, w in loaded.loads.wrenches.items()},
        accelerations=0 * loaded.loads.accelerations,
    )
    assert not nothing.is_nothing
    assert replace(nothing, press_fits={}).is_nothing
    climb = start_climb(loaded.under(nothing))
    climb.by_formula()
    assert climb.best["static"].check.value > 50.0


def test_a_bent_pin_and_loose_arcs_raise_no_bush(tmp_path):
    loaded = loaded_link(tmp_path)
    loads = loaded.loads
    alone = replace(loads, wrenches={k: 1e-9 * w for k, w in loads.wrenches.items()},
                    accelerations=1e-9 * loads.accelerations)  # fmt: skip
    still = loaded.under(alone)
    level = rung_level(still, shapes.model_of(loaded.part, alone))
    value, again = level.peak.value, partial(shapes.model_of, loaded.part)
    found = in_bores(Arcs(still, level, again), None, value)
    assert_allclose([found.half, found.most, found.evened], value, rtol=1e-9)
    solid = level_on(still, first_level(loaded, Models()).solutions, 0.7, 100.0)
    raised = RaisedInBores(0.5, {})(alone, solid, 0, [np.pi])[:, :, 0]
    assert_allclose(raised, solid.history.at(0)[solid.in_bores], atol=1e-6 * solid.peak.value)


def test_arcs_and_solved_contact_keep_what_is_pressed_in(tmp_path):
    silent, pressed = (loaded_link(tmp_path, bush) for bush in (STEEL, FIT))
    models = Models()
    levels = [first_level(one, models) for one in (silent, pressed)]
    lasting = levels[1].history.basis @ levels[1].lasting_states[:, 3]
    assert lasting.max() > 50.0
    plain, lasted = (
        direct_under(one.loads, level, 3, [2.0])[:, :, 0]
        for one, level in zip((silent, pressed), levels, strict=True)
    )
    assert_allclose(lasted - plain, lasting, atol=1e-6)
    found = []
    for one in (silent, pressed):
        part = replace(one.part, clearances={"first": (0.02, 0.05), "second": (0.02, 0.05)})
        fitted = replace(one, part=part)
        level = level_on(fitted, levels[0].solutions, 0.7, 100.0)
        at_least = values_at(StaticPeak(one.loads), level, [LEAST])[LEAST]
        found.append((level, level.history.at(3), at_least))
    (_, plain, before), (level, lasted, after) = found
    assert_allclose(lasted - plain, level.history.basis @ level.lasting_states[:, 3], atol=1e-6)
    assert after > before + 50.0


def test_a_solid_tells_that_its_even_pressure_has_the_bush_in_it(tmp_path):
    loaded = loaded_link(tmp_path)
    told = static(loaded.part, loaded.loads, first_level(loaded, Models())).notes
    assert "cos 0 of a bore that a bush is pressed into" in told[0]


def test_keys_in_another_order_and_in_other_units_are_the_same_bush(tmp_path):
    fits = [
        link(tmp_path, bush).parts["rod"].press_fits
        for bush in (
            FIT,
            'fit = "20 .. 40 um", material = "S355", allowable = "40 MPa", length = "0.8 cm"',
            f'{STEEL}, fit = "0.02 mm .. 40 um"',
        )
    ]
    assert fits[0].keys() == {"first"}
    for other in fits[1:]:
        for field in ("least", "largest", "ratio", "radius"):
            assert_allclose(
                getattr(other["first"], field), getattr(fits[0]["first"], field), rtol=1e-12
            )
    assert fits[0]["first"].share == MIDDLE
    iso = link(tmp_path, f'{STEEL}, fit = "H7/s6"').parts["rod"].press_fits["first"]
    assert (iso.least, iso.largest) == (0.010, 0.039)


def test_the_bush_closes_on_its_pin(tmp_path):
    """In an endless plate."""
    part = link(tmp_path, more='fits = { first = "0.08 .. 0.12 mm" }').parts["rod"]
    fit = part.press_fits["first"]
    lug = ring_flexibility(inf, part.material.youngs_modulus, part.material.poisson_ratio)
    less, more = (two_rings(1e9, fit.at(share))[1] for share in (LEAST, LARGEST))
    assert_allclose(part.clearances["first"], (0.08 - more, 0.12 - less), rtol=1e-9)
    assert_allclose(more, fit.at(LARGEST).closing(lug), rtol=1e-9)
    assert 0.03 < more < 0.04


@pytest.mark.parametrize(
    ("bush", "more", "words"),
    [
        (f'{BUSH}, fit = "H7/s6"', "", "parts.pin_A.stack[1].bush.material: must be stated"),
        (f'{STEEL}, fit = "H7/p6"', "", "may leave no interference: 0 um at 15 mm"),
        (f'{STEEL}, fit = "0 .. 0.02 mm"', "", "an interference above 0 mm"),
        (f'{STEEL}, fit = "0.05 .. 0.02 mm"', "", "smaller end first"),
        (f'{STEEL}, fit = "0.2 mm"', "", "more than a hundredth of the bore's diameter"),
        (f'{STEEL}, fit = "tight"', "", '"H7/p6", or an interference on diameter'),
        (FIT, 'fits = { first = "0.02 .. 0.06 mm" }', "parts.rod.fits.first: leaves the pin"),
    ],
)
def test_a_bush_that_cannot_be_pressed_in_is_refused_with_its_key(tmp_path, bush, more, words):
    assert words in refused(tmp_path, bush, more)


def test_a_fit_in_a_lug_that_no_part_describes_is_refused(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PIN.replace("BUSH", FIT), encoding="utf-8")
    with pytest.raises(DesignError, match=r"no part of the design has the bore of rod at A"):
        read_design(path, [])


def test_a_shape_whose_formula_knows_no_bush_has_none_with_one(tmp_path, monkeypatch):
    silent, pressed = (loaded_link(tmp_path, bush) for bush in (STEEL, FIT))
    known = shapes.shape_model(pressed.part.geometry)
    monkeypatch.setattr(shapes, "shape_model", lambda _: replace(known, press_fits=False))
    assert shapes.model_of(silent.part, silent.loads) is not None
    assert shapes.model_of(pressed.part, pressed.loads) is None


def radial_force(deck):
    """Outward nodal forces in the first bore, N."""
    blocks = re.findall(r"^\*(NODE|NSET|CLOAD)\b(.*)\n((?:[^*].*\n)+)", deck, re.MULTILINE)
    rows = {(kind, names.strip(" ,")): text for kind, names, text in blocks}
    nodes = np.loadtxt(StringIO(rows["NODE", "NSET=ALL"]), delimiter=",")
    forces = np.loadtxt(StringIO(rows["CLOAD", ""]), delimiter=",")
    bore = [int(n) for n in rows["NSET", "NSET=S_FIRST"].replace(",", " ").split()]
    acting = forces[np.isin(forces[:, 0], bore) & (forces[:, 1] < 3)]
    where = dict(zip(nodes[:, 0], nodes[:, 1:3] / 7.5, strict=True))
    return sum(force * where[node][int(axis) - 1] for node, axis, force in acting)


def test_a_deck_for_another_program_has_the_bush_and_says_so(tmp_path):
    """58.9 MPa on 2 pi 7.5 mm x 8 mm, more than the pin's own pressure, at the same position."""
    decks = []
    for bush in (STEEL, FIT):
        link(tmp_path, bush)
        export_part(tmp_path / "machine.toml", "rod", "450 deg", out=tmp_path / "rod.inp")
        decks.append((tmp_path / "rod.inp").read_text(encoding="utf-8"))
    silent, pressed = map(radial_force, decks)
    assert_allclose(pressed - silent, 58.9 * 2 * np.pi * 7.5 * 8, rtol=0.01)
    assert "first: even pressure of the bush pressed in with 0.03 mm" in decks[1]


def test_assumptions_name_the_bush_and_one_that_yields(tmp_path):
    stated, yields = not_checked(loaded_link(tmp_path))
    assert "bush of pin_A in first is pressed in with 0.02 to 0.04 mm" in stated
    assert "the bush of pin_A in first yields as it is pressed in" in yields
    assert "of 355 MPa at its inside" in yields
    (stated,) = not_checked(loaded_link(tmp_path, FIT.replace("0.02 .. 0.04", "0.01 .. 0.02")))
    assert "with 0.01 to 0.02 mm" in stated
    (silent,) = not_checked(loaded_link(tmp_path, STEEL))
    assert "left out, as parts.pin_A.stack[1].bush.fit is not stated" in silent
