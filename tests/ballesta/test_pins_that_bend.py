"""Pins that bend in a fork: what they press more at edges is in the band of solved contact."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.runs import solved_runs
from ballesta.sweeps.screen import Screening
from checks.by_formula import pin_bending
from checks.derivations.stresses import rung_bars, solid_bars
from checks.design.errors import DesignError
from checks.ladder.climb import start_climb
from checks.ladder.levels import Asked, first_level
from checks.ladder.part_facts import assumed_of, edges_words
from checks.ladder.passing_fits import edges_that_pass
from checks.ladder.pin_settings import pins_data
from checks.ladder.result import cheap_result
from checks.ladder.solid import check_solid
from checks.models import shapes
from checks.models.checked import rung_estimates, rung_level
from checks.models.in_bores import Arcs, InBores, in_bores
from checks.part import pressed_along
from checks.part.loaded_part import LoadedPart
from checks.part.pressed_along import that_count
from checks.result.verdict import Status
from checks.result.ways import edges_fact, run_in_fact
from checks.strength.part_strength import fatigue_use
from checks.stress.beyond_even import beyond_even
from checks.stress.error_bars import banded, bars_of
from checks.stress.judged import StaticPeak
from checks.stress.kept_models import Models
from checks.stress.pins_in_bores import fits_of
from fem.contact.beds import Lug, RoundBar
from fem.contact.bore import bore_harmonics
from fem.contact.line_load import line_load
from fem.contact.uneven import BoreAlong, shares_along, turn_in_bore
from fem.unit_loads import resultants
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts.toggle_bar import ToggleBar

from ..small_machine import PLATE, machine

ARC = 'bearing_arc = "90 deg"\n'
FITS = 'fits = { first = "0 .. 0.02 mm", second = "0 .. 0.02 mm" }\n'
STACK = """
[parts.pin]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "42CrMo4"
diameter = "12 mm"
stack = [
  { body = "crank", at = "AT mm", width = "6 mm" },
  { body = "rod", at = "0 mm", width = "8 mm"BUSH },
]
"""


def rod(folder, at=12.0, bush="", stack=STACK, fits=FITS, overrides=()):
    """The rod of the small machine between the cheeks of a crank; its level on a first mesh."""
    text = PLATE + fits + stack.replace("AT", f"{at:g}").replace("BUSH", bush)
    design = machine(folder, text, *overrides)
    design, runs = solved_runs(design, Models(), lambda _: None)
    return LoadedPart.of(design, design.parts["rod"], runs)


def again(loaded):
    return partial(shapes.model_of, loaded.part)


def bores_of(loaded, level, use=None) -> InBores:
    value = level.peak.value if use is None else use.value(level)
    return in_bores(Arcs(loaded, level, again(loaded)), use, value)


@pytest.fixture(scope="module")
def bent(tmp_path_factory):
    loaded = rod(tmp_path_factory.mktemp("bent"))
    return loaded, first_level(loaded, Models())


def brittle(loaded, *names):
    """The same part, with parts of its design made of what breaks before it yields."""
    parts = {
        name: replace(part, material=replace(part.material, ductile=False, endurance_ratio=0.3))
        if name in names
        else part
        for name, part in loaded.design.parts.items()
    }
    design = replace(loaded.design, parts=parts)
    return replace(loaded, design=design, part=parts[loaded.name])


def test_a_bent_pin_presses_the_edges_of_an_eye_more_which_the_band_holds(bent):
    """Equal at both edges; stress there is not raised by more than the pressure is.

    Static has it where the pin is brittle; fatigue always.
    """
    loaded = brittle(bent[0], "pin")
    level = first_level(loaded, Models())
    for what in (StaticPeak(loaded.loads), fatigue_use(loaded)):
        found = beyond_even(what, level, loaded.part)
        assert found.bent == found.uneven
        assert_allclose(found.even, what.value(level), rtol=1e-6)
        assert "times the mean at the edges of first" in found.words
        most = float(found.words.split("up to ")[1].split(" times")[0])
        assert 1.02 < found.uneven / found.even < most < 2.0
        bars = bars_of(what, loaded.part, [level, level], 0.2)
        assert not bars.evened
        assert bars.above >= found.above > 0
        told, items = solid_bars(bars, "v")
        assert {"q_1", "q_2"} < {getattr(item, "symbol", "") for item in items}
        assert "bent pins" in told.words
        assert found.above > 0.02 * found.even
    said = " ".join(assumed_of(loaded, level))
    assert f"the pin bends ({pressed_along.SOFT_LUGS}), which presses up to" in said
    assert "which the band holds as well" in said


@pytest.mark.slow
@pytest.mark.parametrize("bush", ["", ', bush = { length = "8 mm", allowable = "100 MPa" }'])
def test_what_is_kept_for_other_loads_and_clearances_is_what_a_fresh_solve_finds(tmp_path, bush):
    """Under a factor on the loads pins press as on clearances over it: value and band to 2 %."""
    fits = 'fits = { first = "0.01 .. 0.03 mm", second = "0.01 .. 0.03 mm" }\n'
    stack = STACK.replace('diameter = "12 mm"', 'diameter = "10 mm"') if bush else STACK

    def solved(*overrides):
        loaded = brittle(rod(tmp_path, 12.0, bush, stack, fits, overrides), "pin")
        level = first_level(loaded, Models())
        static = StaticPeak(loaded.loads)
        bars = bars_of(static, loaded.part, [level, level], 0.2)
        now = [static.value(level), bars.above, bars.below]
        return loaded.part, level, static, bars, now

    part, level, what, bars, now = solved()
    assert bars.along.above > 0.02 * bars.along.even
    assert (bars.clearances.soft is not None) is bool(bush)
    kept = pins_data(part, level, {what: bars}, {})["pins"]["kinds"]["static"]
    assert kept["band"] == [bars.above, bars.below]
    loads, by_share = (np.array(kept[key]) for key in ("loads", "clearances"))
    assert_allclose(loads[loads[:, 0] == 1.0][0, 1:], now)
    linear = loads[loads[:, 0] == 1.0][0, 1]
    for factor in (0.75, 1.3):
        fresh = solved(f"load_factor={factor}")[-1]
        found = [factor * np.interp(factor, *loads[:, [0, k]].T) for k in (1, 2, 3)]
        assert_allclose(found, fresh, atol=0.02 * fresh[0])
        assert abs(fresh[0] / (factor * linear) - 1) > 0.01 or bush
    one = [f'parts.rod.fits.{name}="0.014 mm"' for name in ("first", "second")]
    fresh = solved(*one)[-1]
    found = [np.interp(0.2, *by_share[:, [0, k]].T) for k in (1, 2, 3)]
    assert_allclose(found, fresh, atol=0.02 * fresh[0])


def test_a_static_band_jumps_at_the_load_that_the_pin_no_longer_holds_evenly(tmp_path):
    """The theorem holds up to 1.25 of the loads: below it no bent pin, above it all that it has."""
    holds = rod(tmp_path).stack("first").pin_safety / 1.25

    def solved(factor):
        loaded = rod(tmp_path, overrides=(f"load_factor={factor}", f"require.static={holds}"))
        level, static = first_level(loaded, Models()), StaticPeak(loaded.loads)
        return loaded.part, level, static, bars_of(static, loaded.part, [level, level], 0.2)

    part, level, what, bars = solved(1.0)
    rows = pins_data(part, level, {what: bars}, {})["pins"]["kinds"]["static"]["loads"]
    found = {
        factor: factor * np.interp(factor, *np.array(rows)[:, [0, 2]].T) for factor in (1.2, 1.3)
    }
    fresh = {factor: solved(factor)[-1] for factor in found}
    assert fresh[1.2].along.above == 0 < 0.02 * fresh[1.2].along.even < fresh[1.3].along.above
    for factor, above in found.items():
        assert_allclose(above, fresh[factor].above, atol=0.02 * fresh[factor].along.even)


def test_a_part_with_reserve_is_judged_again_where_a_variation_bends_its_pin_more(tmp_path):
    """Of aluminium 2.9 times as much. The other change leaves the rod's pin and loads alone."""
    known = Screening(rod(tmp_path, fits=ARC).design)

    def judged(change, **reserves):
        checks = known.of([change], ["rod"], reserves=reserves).checks
        return {check.kind: check.upper for check in checks}

    soft = 'parts.pin.material="6082-T6"'
    assert judged(soft, rod=4.0)["fatigue"] == judged(soft)["fatigue"]
    assert judged(soft)["fatigue"] > 1.05 * judged("name='as it is'")["fatigue"]
    assert not judged("name='as it is'", rod=4.0)


def test_models_without_contact_have_what_bent_pins_press_in_their_band_as_well(bent, tmp_path):
    """Without a fit a formula and a solid on arcs have as much more in the bore, for its check."""
    fitted, solved = bent
    bound, edge, _ = fitted.uneven["first"]
    assert edge == "edges"
    beyond = [beyond_even(what, solved, fitted.part)
              for what in (StaticPeak(fitted.loads), fatigue_use(fitted))]  # fmt: skip
    contact = max(one.bent / one.even for one in beyond)
    assert contact < bound < 2.0  # solved contact has the mesh's own tilt and clearance
    loaded = brittle(rod(tmp_path, fits=""), "pin")  # so that static has it, too
    uneven = loaded.uneven
    level = first_level(loaded, Models())
    for what in (StaticPeak(loaded.loads), fatigue_use(loaded)):
        even, raised = (bars_of(what, loaded.part, [level, level], 0.2, u) for u in ({}, uneven))
        assert_allclose(raised.in_bores, uneven["first"][0] * even.in_bores, rtol=0.02)
        assert raised.above > even.above
        assert "times as much at the edges of first, as the pin bends" in raised.note
    by_formula = rung_level(loaded, shapes.model_of(loaded.part, loaded.loads))
    found = [bores_of(one, by_formula).half for one in (replace(loaded, runs={}), loaded)]
    assert_allclose(found[1] / found[0], uneven["first"][0], rtol=0.02)
    estimate = rung_estimates(loaded, by_formula, None, again(loaded))["static"].check
    assert "at the edges of first, as the pin bends" in estimate.note
    stated = replace(loaded, part=replace(loaded.part, arc_stated=True))
    assert (
        stated.uneven["first"][:2] == uneven["first"][:2]
    )  # it says how the pin presses around, not along
    even, raised = (bars_of(what, stated.part, [level, level], 0.2, u) for u in ({}, uneven))
    assert even.in_bores == 0.0
    assert raised.above > even.above
    assert "model band: 1." in raised.note


def test_no_static_band_has_what_yields_at_edges_of_ductile_parts(bent, tmp_path):
    """By contact, by a solid on arcs and by formula: even pressure, and the elastic value told."""
    loaded, level = bent
    what = StaticPeak(loaded.loads)
    found = beyond_even(what, level, loaded.part)
    kept_in = brittle(loaded, "pin")
    elastic = beyond_even(what, first_level(kept_in, Models()), kept_in.part)
    assert found.above == found.below == 0.0
    assert_allclose(found.bent, elastic.uneven, rtol=1e-9)
    bars = bars_of(what, loaded.part, [level, level], 0.2)
    assert_allclose(bars.above, bars.clearances.above, rtol=1e-12)
    assert bars.evened == found.bent > 1.02 * found.even
    assert "lower bound theorem" in bars.note
    assert f"{found.bent:.4g} MPa" in bars.note
    told, items = solid_bars(bars, "v")
    assert "q_2" not in {getattr(item, "symbol", "") for item in items}
    assert f"in no band: bent pins, with which it is up to {found.bent:.4g} MPa" in told.words
    assert "of static not: edges yield, no more" in " ".join(assumed_of(loaded, level))
    loaded = rod(tmp_path, fits="")
    level, kept_in = first_level(loaded, Models()), brittle(loaded, "pin")
    bars = bars_of(what, loaded.part, [level, level], 0.2, loaded.uneven)
    even = bars_of(what, loaded.part, [level, level], 0.2, {})
    elastic = bars_of(what, kept_in.part, [level, level], 0.2, kept_in.uneven)
    assert (bars.above, bars.in_bores) == (even.above, even.in_bores)
    assert bars.evened == elastic.in_bores > bars.in_bores
    assert f"elastic, with it, up to {bars.evened:.4g} MPa" in bars.note
    by_formula = rung_level(loaded, shapes.model_of(loaded.part, loaded.loads))
    straight = replace(loaded, runs={})
    checks = [rung_estimates(one, by_formula, None, again(loaded))["static"].check
              for one in (loaded, straight, kept_in)]  # fmt: skip
    assert checks[0].model == checks[1].model < checks[2].model
    elastic = bores_of(kept_in, by_formula).most
    assert f"elastic, with it, up to {elastic:.4g} MPa" in checks[0].note
    told, _ = rung_bars(
        loaded.part, loaded.loads, by_formula.model, checks[0], "v", bores_of(loaded, by_formula)
    )  # fmt: skip
    assert f"in no band: bent pins, with which it is up to {elastic:.4g} MPa" in told.words
    told, _ = rung_bars(
        kept_in.part, kept_in.loads, by_formula.model, checks[2], "v", bores_of(kept_in, by_formula)
    )  # fmt: skip
    assert f"above about {elastic:.4g} MPa (bent pins, arcs)" in told.words
    use = fatigue_use(loaded)  # not covered by the theorem
    assert bores_of(loaded, by_formula, use).most > bores_of(straight, by_formula, use).most


def test_what_is_brittle_or_a_pin_that_does_not_hold_keeps_the_elastic_band(tmp_path):
    """The pin's safety is that of its own checks: 0.1 % off and the verdict would move."""
    loaded = rod(tmp_path, fits="")
    uneven, part = loaded.uneven, loaded.part
    assert not that_count(part, uneven, static=True)
    assert set(that_count(part, uneven, static=False)) == {"first"}
    for name in ("rod", "pin"):
        one = brittle(loaded, name)
        assert set(that_count(one.part, one.uneven, static=True)) == {"first"}
    assert not that_count(part, brittle(loaded, "crank").uneven, static=True)
    pin = LoadedPart.of(loaded.design, loaded.design.parts["pin"], loaded.runs)
    own = min(check.safety for check in pin_bending.checks(pin))
    assert_allclose(loaded.stack("first").pin_safety, own, rtol=1e-9)
    for share, counts in ((0.999, set()), (1.001, {"first"})):
        require = loaded.design.require.model_copy(update={"static": share * own})
        one = replace(loaded, design=replace(loaded.design, require=require))
        assert set(that_count(part, one.uneven, static=True)) == counts


def test_a_pin_must_hold_the_mean_pressure_of_its_seats(tmp_path):
    """F/(d w), more than its bending, F/2 (4 - 2/4)/(pi d^3/32), in a lug of 2 mm."""
    stack = STACK.replace('width = "8 mm"', 'width = "2 mm"')
    loaded = rod(tmp_path, at=4.0, stack=stack, fits="")
    force = np.hypot(*loaded.loads.wrenches["first"][:, :2].T).max()
    found = loaded.stack("first")
    assert_allclose(found.pin_safety, found.pin.material.yield_stress * 12 * 2 / force, rtol=1e-9)


def test_a_bush_must_hold_its_mean_pressure(tmp_path):
    """F/(d w) of a bush of 8 mm on a pin of 10 mm."""
    bush = ', bush = { length = "8 mm", allowable = "100 MPa", material = "CuSn11P" }'
    stack = STACK.replace('diameter = "12 mm"', 'diameter = "10 mm"')
    loaded = rod(tmp_path, 12.0, bush, stack, "")
    force = np.hypot(*loaded.loads.wrenches["first"][:, :2].T).max()
    found = loaded.stack("first")
    own = found.pin.bushes["rod"].yield_stress * 10 * 8 / force
    assert_allclose(found.bush_safety, own, rtol=1e-9)
    weaker = min(own, found.pin_safety)
    assert_allclose(found.even_up_to, weaker / loaded.design.require.static, rtol=1e-9)


def test_a_bush_that_breaks_keeps_the_elastic_band(tmp_path):
    for name, counts in (("CuSn11P", set()), ("plastic", {"first"})):
        (folder := tmp_path / name).mkdir()
        bush = f', bush = {{ length = "8 mm", allowable = "100 MPa", material = "{name}" }}'
        stack = STACK.replace('diameter = "12 mm"', 'diameter = "10 mm"') + PLASTIC
        loaded = rod(folder, bush=bush, stack=stack, fits="")
        assert set(that_count(loaded.part, loaded.uneven, static=True)) == counts


def run_in(loaded, **edges):
    """The same part with edges of its bores as stated."""
    return replace(loaded, part=replace(loaded.part, bore_edges=edges))


def test_edges_that_are_stated_to_have_run_in_take_the_bent_pin_out_of_both_bands(bent, tmp_path):
    """By contact, on arcs and by formula, of a brittle pin as well; what it takes away is told."""
    loaded = brittle(bent[0], "pin")
    level = first_level(loaded, Models())
    even = run_in(loaded, first="run_in")
    told = {}
    for kind, what in (("static", StaticPeak(loaded.loads)), ("fatigue", fatigue_use(loaded))):
        was, now = (bars_of(what, one.part, [level, level], 0.2) for one in (loaded, even))
        assert_allclose(now.above, now.clearances.above, rtol=1e-12)
        assert was.above > now.above
        assert now.evened == was.along.uneven > what.value(level)
        again = banded(was, what, even.part, level, even.uneven)
        assert (again.above, again.below, again.above_steel) == (now.above, now.below, now.above)
        assert "its edges are stated as run in" in now.note
        told[kind] = now.evened
    (said,) = edges_words(even, told)
    assert said.startswith("bore_edges.first = run_in, as stated: pressed evenly along the pin")
    assert said.endswith(f"static would be up to {told['static']:.4g} MPa, "
                         f"fatigue would be up to {told['fatigue']:.4g} MPa")  # fmt: skip
    (said,) = edges_words(run_in(bent[0], first="run_in"), told)
    assert "static" not in said  # ductile: statics had left it out before
    (said,) = edges_words(run_in(loaded, second="run_in"), told)
    assert "it takes nothing away: no bent pin is known to press there" in said
    assert "in no band: its edges are stated as run in" in " ".join(assumed_of(even, level))
    loaded = rod(tmp_path, fits="")
    level, use = first_level(loaded, Models()), fatigue_use(loaded)
    even = run_in(loaded, first="run_in")
    straight, stated = (bars_of(use, even.part, [level, level], 0.2, u) for u in ({}, even.uneven))
    assert (stated.above, stated.in_bores) == (straight.above, straight.in_bores)
    level = rung_level(loaded, shapes.model_of(loaded.part, loaded.loads))
    same = [bores_of(one, level, use).most for one in (even, replace(loaded, runs={}))]
    assert same[0] == same[1] < bores_of(loaded, level, use).most
    elsewhere = run_in(loaded, second="run_in")
    assert bores_of(elsewhere, level, use) == bores_of(loaded, level, use)


def test_a_check_that_bent_pins_leave_open_names_the_edges_that_settle_it(tmp_path):
    """By formula; stated so, it passes with the safety that was named, and on no less."""
    loaded = rod(tmp_path, fits="")
    first = start_climb(loaded)
    assert first.by_formula()
    checks = [first.best["fatigue"].check, start_climb(run_in(loaded, first="run_in"))]
    assert checks[1].by_formula()
    even = checks[1].best["fatigue"].check
    assert even.upper < checks[0].upper
    fact = edges_fact("fatigue", ["first"])
    for need, named in ((even.limit / even.upper, True), (1.001 * even.limit / even.upper, False)):
        require = loaded.design.require.model_copy(update={"fatigue": need * (1 - 1e-9)})
        climb = start_climb(replace(loaded, design=replace(loaded.design, require=require)))
        assert climb.by_formula()
        assert climb.best["fatigue"].check.status is Status.UNDECIDED
        facts = cheap_result(climb, Models()).facts
        assert (fact in facts) is named
        if named:
            assert_allclose(facts[fact], even.limit / even.upper, rtol=1e-9)


def test_a_check_that_passes_by_run_in_edges_alone_says_what_it_rests_on(tmp_path):
    """Up to where it came with edges as cut; nothing where these pass, too, or neither does."""
    loaded = rod(tmp_path, fits="")
    cut, even = start_climb(loaded), start_climb(run_in(loaded, first="run_in"))
    assert cut.by_formula()
    assert even.by_formula()
    cut, even = (climb.best["fatigue"].check for climb in (cut, even))
    fact = run_in_fact("fatigue", ["first"])
    for need, rests in ((even.limit / even.upper, True), (cut.limit / cut.upper, False),
                        (1.001 * even.limit / even.upper, False)):  # fmt: skip
        require = loaded.design.require.model_copy(update={"fatigue": need * (1 - 1e-9)})
        one = replace(loaded, design=replace(loaded.design, require=require))
        climb = start_climb(run_in(one, first="run_in"))
        assert climb.by_formula()
        facts = cheap_result(climb, Models()).facts
        assert (fact in facts) is rests
        if rests:
            assert_allclose(facts[fact], cut.upper, rtol=1e-9)
            assert facts[fact] > even.limit / need


@pytest.mark.slow
def test_a_solid_names_the_edges_with_which_it_passes_and_then_does(bent):
    """Fatigue by contact, asked for what the band of even pressure just holds."""
    loaded, _ = bent
    models, asked = Models(), Asked(frozenset({"fatigue"}), modes=False)

    def checked(need, **edges):
        require = loaded.design.require.model_copy(update={"fatigue": need})
        one = replace(loaded, design=replace(loaded.design, require=require))
        result = check_solid(run_in(one, **edges), models, asked=asked)
        return result, next(check for check in result.checks if check.kind == "fatigue")

    _, even = checked(1.0, first="run_in")
    need = even.limit / even.upper * (1 - 1e-9)
    result, check = checked(need)
    assert check.status is Status.UNDECIDED
    assert_allclose(result.facts[edges_fact("fatigue", ["first"])], need, rtol=1e-6)
    assert checked(need, first="run_in")[1].status is Status.PASS
    result, _ = checked(1.001 * need)
    assert edges_fact("fatigue", ["first"]) not in result.facts


def test_a_pin_that_is_no_part_claims_no_theorem(tmp_path):
    """Where no part is the pin nothing is known of it: no band of it, and no word of one."""
    loaded = rod(tmp_path, stack="", fits="")
    assert loaded.uneven == {}
    level = rung_level(loaded, shapes.model_of(loaded.part, loaded.loads))
    check = rung_estimates(loaded, level, None, again(loaded))["static"].check
    assert "theorem" not in check.note


def test_a_pin_that_does_not_bend_presses_as_evenly_as_it_was_taken(tmp_path):
    """A pin a thousand times as stiff leaves a thousandth, and some for its harder surface."""
    stack = rod(tmp_path).stack("first")
    lugs, own = stack.lugs(0, 0.0)
    lugs = pressed_along.under_one(lugs)
    found = {}
    for stiffer in (1.0, 1e3):
        bar = replace(stack.bar, youngs_modulus=stiffer * stack.bar.youngs_modulus)
        bent, straight = (line_load(bar, lugs, bends=bends) for bends in (True, False))
        found[stiffer] = shares_along(bent, own) - shares_along(straight, own)
    assert_allclose(found[1.0], stack.shares(0, 0.0), rtol=1e-9)
    assert found[1.0][1] > 0.1
    assert 0 < found[1e3][1] < 3e-3 * found[1.0][1]


@pytest.mark.parametrize("clearance", [0.0, 0.02])
def test_the_line_load_over_its_mean_stays_under_other_forces_and_is_known(tmp_path, clearance):
    """Degree 1 in forces and clearances together: to round-off, lift-off and skew forces included.

    So what a stack solves once is known under forces that are alike to four digits.
    """
    bar = RoundBar((-60.0, 60.0), (20.0,), 210e3, 0.3)
    lugs = [Lug(low, low + width, force, 210e3, 0.3, tilt, clearance)
            for low, width, force, tilt in (
                (-40.0, 8.0, (1000.0, 900.0), 1e-9), (-25.0, 50.0, (-2000.0, -1800.0), 0.0),
                (32.0, 8.0, (1000.0, 900.0), 1e-9))]  # fmt: skip
    heavy = [replace(lug, force=(7 * lug.force[0], 7 * lug.force[1]), clearance=7 * clearance)
             for lug in lugs]  # fmt: skip
    own, other = (line_load(bar, some) for some in (lugs, heavy))
    assert min(own.intensity(1)) == 0.0  # it lifts off
    for k in range(3):
        assert_allclose(other.intensity(k), 7 * own.intensity(k), rtol=1e-9, atol=1e-9)
    loose = [replace(lug, clearance=clearance) for lug in heavy]
    beside = shares_along(line_load(bar, loose), 1) - shares_along(own, 1)
    assert np.abs(beside).max() < 1e-9 if not clearance else np.abs(beside).max() > 1e-3
    assert_allclose([lug.size for lug in pressed_along.under_one(heavy)],
                    [lug.size for lug in pressed_along.under_one(lugs)], rtol=1e-12)  # fmt: skip
    alike = line_load(bar, pressed_along.under_one(lugs))
    assert_allclose(shares_along(alike, 1), shares_along(own, 1), atol=1e-3)
    stack = rod(tmp_path).stack("first")
    before = stack.shares(0, 0.0)
    solved = pressed_along._pressed.cache_info().misses
    grown = {name: 1.7 * wrench for name, wrench in stack.loads.wrenches.items()}
    again = replace(stack, loads=replace(stack.loads, wrenches=grown))
    assert_allclose(again.shares(0, 0.0), before, rtol=1e-12)
    assert pressed_along._pressed.cache_info().misses == solved


def test_cheeks_farther_away_bend_the_pin_more(tmp_path):
    shares = [rod(tmp_path, at).stack("first").shares(0, 0.0)[1] for at in (8.0, 12.0, 20.0)]
    assert 0 < shares[0] < shares[1] < shares[2]


def test_lugs_of_other_parts_are_as_soft_as_slender_forks(tmp_path, monkeypatch):
    """Nearly as bent as between lugs that tilt as they like; lugs that are held bend it less."""
    found = []
    free = pressed_along._FREE
    for soft in (0.0, pressed_along._SOFT, free, 10 * free):
        monkeypatch.setattr(pressed_along, "_SOFT", soft)
        found.append(rod(tmp_path).stack("first").shares(0, 0.0)[1])
    held, own, loose, looser = found
    assert held < 0.9 * own
    assert 0.85 * loose < own < loose
    assert_allclose(looser, loose, rtol=1e-3)


def test_lugs_on_one_side_and_pins_without_a_part_are_left_out(bent, tmp_path):
    loaded, _ = bent
    assert loaded.stack("second") is None
    one_sided = STACK.replace('width = "6 mm"', 'width = "6 mm", single = true')
    assert rod(tmp_path, stack=one_sided).stack("first") is None


def bushed(folder, material="", **changed):
    """The rod with a bush of 1 mm on a brittle pin of 10 mm; its level and static bars."""
    bush = f', bush = {{ length = "8 mm", allowable = "100 MPa"{material} }}'
    text = STACK.replace('diameter = "12 mm"', 'diameter = "10 mm"') + changed.get("more", "")
    loaded = brittle(rod(folder, bush=bush, stack=text), "pin")
    level = first_level(loaded, Models())
    return loaded, level, bars_of(StaticPeak(loaded.loads), loaded.part, [level, level], 0.2)


PLASTIC = """
[materials.plastic]
youngs_modulus = "3 GPa"
poisson_ratio = 0.4
density = "1400 kg/m3"
yield_stress = "60 MPa"
ultimate_stress = "60 MPa"
ductile = false
"""


def test_the_softer_a_bush_the_less_a_bent_pin_presses_at_edges_and_the_wider_its_arc(tmp_path):
    """Where the material is left out, the band reaches above those of steel and of plastic."""
    found = {}
    for name, said in (
        ("unstated", ""),
        ("steel", ', material = "C45"'),
        ("bronze", ', material = "CuSn7Zn2Pb3"'),
        ("plastic", ', material = "plastic"'),
    ):
        (folder := tmp_path / name).mkdir()
        loaded, level, bars = bushed(folder, said, more=PLASTIC)
        cycle = level.contact.over(np.array([level.peak.position]), 0.5)
        value = StaticPeak(loaded.loads).value(level)
        found[name] = value, bars, float(cycle.bores["first"].arcs[0]), loaded, level
    steel, bronze, plastic = (found[name] for name in ("steel", "bronze", "plastic"))
    assert steel[1].along.above > bronze[1].along.above > 10 * plastic[1].along.above > 0
    assert steel[2] < bronze[2] < plastic[2]
    value, bars, arc, loaded, level = found["unstated"]
    assert_allclose([value, arc], [steel[0], steel[2]], rtol=1e-6)
    assert_allclose(bars.along.above, steel[1].along.above, rtol=1e-6)
    for own, other, *_ in (steel, bronze, plastic):
        assert value + bars.above >= (own + other.above) * (1 - 1e-9)
        assert other.clearances.soft is None
    assert bars.above >= bars.clearances.soft - value
    said = " ".join(assumed_of(loaded, level))
    assert "through a bush 1 mm thick, of a material ASSUMED between steel and so soft" in said
    assert "parts.pin.stack[1].bush.material" in said
    assert "which the band holds as well" in said
    said = " ".join(assumed_of(*bronze[3:]))
    assert "through a bush of CuSn7Zn2Pb3, 1 mm thick" in said
    told, items = solid_bars(bars, "v")
    assert "s_b" in {getattr(item, "symbol", "") for item in items}
    assert "bushes, whose material is not stated" in told.words


def test_a_bush_that_is_shorter_than_its_lug_is_told(tmp_path):
    stack = STACK.replace('diameter = "12 mm"', 'diameter = "10 mm"')
    short = ', bush = { length = "4 mm", allowable = "100 MPa", material = "CuSn11P" }'
    fit = fits_of(rod(tmp_path, bush=short, stack=stack))["first"]
    assert "CuSn11P, 1 mm thick, 4 mm long but taken as long as the lug of 8 mm," in fit.material


def test_a_bush_of_no_known_material_or_without_room_is_refused_with_its_key(tmp_path):
    with pytest.raises(DesignError, match=r"stack\[1\].bush.material: no material .*'CuSn7'"):
        bushed(tmp_path, ', material = "CuSn7"')
    with pytest.raises(DesignError, match=r"no room for a bush .* pin of 12 mm .* hole of 12 mm"):
        rod(tmp_path, bush=', bush = {length="8 mm", allowable="9 MPa", material="CuSn11P"}')


def waves_along_x(bore, force):
    found = np.zeros(2 * bore.last + 1)
    found[[0, 1]] = force
    return found


def test_an_uneven_pressure_has_the_couple_it_claims_and_no_force(bent):
    """a_1 F w/6 about y; a bow has none. To 1e-3 of F w, for facets' integrals of a kink-free
    polynomial.
    """
    _, level = bent
    bore = level.contact.pins.harmonics[0]
    along, elements = BoreAlong(bore), bore.solutions.elements
    low, high = along.faces
    assert not along.paired
    assert_allclose([low, high], [-4.0, 4.0], atol=1e-9)
    waves = waves_along_x(bore, 100.0)
    for shares, couple in (((0.5, 0.0), 0.5 * 100 * 8 / 6), ((0.0, 1.0), 0.0)):
        vector = along.vector(waves, np.array(shares))
        got = resultants(elements, vector[:, None], bore.loads.interface.centre)[:, 0]
        if not bore.solutions.mesh.half:
            assert_allclose(got[4], couple, atol=1e-3 * 100 * 8)
        assert np.abs(got[:2]).max() < 1e-9 * 100
        assert np.abs(vector).max() > 0.01


def tilt_of_cheeks(wall):
    """How a cheek at the knee of a toggle bar tilts, rad/(N mm)."""
    shape = ToggleBar(
        length=200.0, width=50.0, wall=wall, hole=20.0, overhang=25.0, inner_radius=2.0,
        cutout_length=35.0, cutout_corner=4.0,
    )  # fmt: skip
    steel = Elastic(210e3, 0.3, 7.85e-9)
    solutions = solve_unit_loads(mesh_shape(shape, fineness=0.4), steel)
    along = BoreAlong(bore_harmonics(solutions, "knee"))
    low, high = along.faces
    assert along.paired
    assert_allclose([low, high], [25.0 - wall, 25.0], atol=1e-6)
    assert_allclose(along.places(np.array([-high, -low, low, high])), [1, -1, -1, 1], atol=1e-6)
    lug = Lug(low, high, (1.0, 0.0), 210e3, 0.3)
    bar = RoundBar((-40.0, 40.0), (20.0,), 210e3, 0.3)
    return along.tilt(bar, lug, waves_along_x(along.harmonics, 1.0))


def test_thin_cheeks_tilt_as_plates_bend():
    """Plates bend with the third power of their thickness; the tube's corners hold them alike.

    Half as thick is 8 times as soft, times 42/34 for the wider span between the side walls, or its
    square where they hold less: 10 to 12.
    """
    assert 9.0 < tilt_of_cheeks(4.0) / tilt_of_cheeks(8.0) < 13.0


def test_the_fewest_edges_come_first_and_bushes_last(tmp_path):
    """Two bores bend: both together pass, one alone only with bushes of steel as well."""
    loaded = rod(tmp_path, fits=ARC)
    one = loaded.uneven["first"]
    loaded.__dict__["uneven"] = {"first": one, "second": one}  # as two pins had it
    level = rung_level(loaded, shapes.model_of(loaded.part, loaded.loads))
    use = fatigue_use(loaded)
    check = rung_estimates(loaded, level, use, partial(shapes.model_of, loaded.part), ["fatigue"])[
        "fatigue"
    ].check
    fails, half, holds = (
        replace(check, limit=check.required * check.upper * share, numerical=0.0, model=0.0)
        for share in (0.1, 2.0, 4.0)
    )
    half_open = replace(half, model=10 * half.value)
    asked = []

    def again(other, kind):
        edges = other.part.bore_edges
        asked.append(sorted(edges))
        return (holds if len(edges) == 2 else half_open), half

    found = edges_that_pass(loaded, [half_open, fails], again)
    assert asked == [["first"], ["second"], ["first", "second"]]
    assert found == {edges_fact("fatigue", ("first", "second")): holds.limit / holds.upper}
    found = edges_that_pass(loaded, [half_open], lambda other, kind: (half_open, half))
    assert list(found) == [edges_fact("fatigue", ("first",), steel=True)]
    assert edges_that_pass(loaded, [half_open], lambda *_: (half_open, half_open)) == {}
    hits = ("play of 0.1 mm in B as its force reverses", 10 * half.value, 0.0)
    hit = replace(half_open, doubts=(hits,))
    found = edges_that_pass(loaded, [half_open], lambda *_: (hit, hit))
    assert found == {edges_fact("fatigue", ("first",), cushioned=True): half.limit / half.upper}


def cosine_waves(bore, arc, angle):
    """Waves (2 last + 1,) of 1 N of pressure that is a cosine on an arc about an angle, rad."""
    t = 2 * np.pi * np.arange(4096) / 4096
    away = (t - angle + np.pi) % (2 * np.pi) - np.pi
    pressure = np.where(np.abs(away) < arc / 2, np.cos(np.pi / arc * away), 0.0)
    turned = np.arange(1, bore.last + 1)[:, None] * t
    waves = np.stack([np.cos(turned), np.sin(turned)], axis=1).reshape(-1, len(t)) @ pressure
    force = pressure @ np.cos(away)
    return np.r_[pressure.sum(), waves] / force


def least_turn(shape):
    """The least turn of a toggle bar's cheeks over a strip's, any end, direction and arc."""
    steel = Elastic(210e3, 0.3, 7.85e-9)
    solutions = solve_unit_loads(mesh_shape(shape, fineness=0.5), steel)
    found = []
    for name in ("knee", "end"):
        along = BoreAlong(bore_harmonics(solutions, name))
        low, high = along.faces
        bar = RoundBar((-high - 5, high + 5), (shape.hole,), 210e3, 0.3)
        for angle in (0.0, 0.25 * np.pi, 0.5 * np.pi, np.pi):
            lug = Lug(low, high, (np.cos(angle), np.sin(angle)), 210e3, 0.3)
            for arc in (np.pi, 0.5 * np.pi):
                tilt = along.tilt(bar, lug, cosine_waves(along.harmonics, arc, angle))
                found.append((tilt + turn_in_bore(bar, lug)) / pressed_along._bent(lug))
    return min(found)


PRESS = {"length": 300.0, "width": 80.0, "wall": 6.3, "hole": 44.0, "overhang": 40.0,
         "inner_radius": 3.0, "cutout_length": 56.0, "cutout_corner": 5.0}  # fmt: skip
MORE = [
    {"hole": 60.0, "overhang": 34.0}, {"wall": 4.0, "hole": 62.0, "overhang": 36.0},
    {"wall": 4.0, "hole": 20.0}, {"wall": 10.0, "hole": 20.0}, {"wall": 10.0, "hole": 50.0},
    {"wall": 3.0, "hole": 40.0}, {"overhang": 26.0}, {"cutout_length": 42.0},
    {"cutout_length": 110.0}, {"inner_radius": 8.0}, {"cutout_corner": 15.0},
    {"width": 150.0, "wall": 5.0, "hole": 50.0, "overhang": 60.0},
    {"wall": 12.0, "cutout_length": 80.0},
    {"wall": 4.0, "hole": 61.0, "overhang": 33.6, "inner_radius": 5.0, "cutout_length": 40.0},
]  # fmt: skip


@pytest.mark.parametrize(
    "changed", [{}, *(pytest.param(one, marks=pytest.mark.slow) for one in MORE)]
)
def test_cheeks_of_toggle_bars_turn_at_least_as_much_as_formulas_take(changed):
    """So a formula takes a pin to press no less unevenly than contact with the mesh's own tilt."""
    shape = ToggleBar(**PRESS | changed)
    assert_allclose(shape.cheeks_turn, 0.27 * 12 / shape.wall**3, rtol=1e-12)
    assert least_turn(shape) > 1.1 * 0.27


def test_formulas_press_the_bars_of_the_press_no_less_than_any_tilt_they_may_have():
    """Held 1.55 times, with the mesh's own tilt, 7.7e-8, 1.22."""
    design, runs = solved_runs(read_design("designs/toggle_press.toml"), Models(), lambda _: None)
    loaded = LoadedPart.of(design, design.parts["bar_upper"], runs)
    stack, position = loaded.stack("knee"), int(loaded.loads.resultant("knee").argmax())
    lugs, own = stack.lugs(position, 0.0)
    least, mesh = stack._least_tilt(lugs[own]), 7.7e-8
    assert 0.3 * mesh < least < mesh
    pressed = [pressed_along.most_pressed(stack.shares(position, tilt))[0]
               for tilt in (0.0, *np.geomspace(least, 1e3 * least, 7), mesh)]  # fmt: skip
    assert_allclose([pressed[0], pressed[-1]], [1.55, 1.22], atol=0.006)
    assert loaded.uneven["knee"].most == pressed[1] == max(pressed[1:])
    assert loaded.uneven["knee"].edge == "inner edge"


def test_beyond_the_cheeks_that_were_compared_formulas_hold_them():
    for changed in ({"hole": 66.0, "wall": 3.0}, {"wall": 24.0, "hole": 20.0}, {"overhang": 23.0}):
        assert ToggleBar(**PRESS | changed).cheeks_turn == 0.0
