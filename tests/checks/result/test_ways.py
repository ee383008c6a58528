"""Ways out of an open verdict: each settles what it names, the cheapest comes first."""

from dataclasses import replace
from math import inf

import pytest

from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.models import bands
from checks.result.derivation import Derivation, Given, Section
from checks.result.verdict import Gate, RungTried, Status
from checks.result.ways import (
    arc_fact,
    clearance_fact,
    edges_fact,
    run_in_edges,
    run_in_fact,
    ways_out,
)
from checks.result.words import LESS_IN, WOULD_HIT, open_reason

from ...reports.results import check, design, part
from ...small_machine import PLATE, machine
from ..models.wide_bands import bands_of

SOLID = RungTried("solid", 12.0, 40_000, [], "stopped")
# allowed: 355 / 1.5 = 236.7 MPa
BY_MESH = check(value=225.0, numerical=15.0, model=2.0, method="solid (two meshes)")
BY_MODEL = check(value=225.0, numerical=1.0, model=20.0, method="solid (two meshes)")


def only(result):
    (way,) = ways_out(result)
    return way


def test_a_verdict_that_is_settled_needs_no_way_out():
    assert ways_out(design()) == []


def test_checks_that_fail_are_told_how_much_lower_they_must_be_and_who_finds_the_change():
    """Upper end 300 + 15 + 20 = 335 MPa, allowed 236.7: 29.4 % lower, 370 MPa: 36.0 %."""
    failed = replace(BY_MODEL, value=300.0, numerical=15.0)
    other = replace(failed, kind="fatigue", value=335.0)
    way = only(design(part(checks=[failed, other])))
    assert failed.status is Status.FAIL
    assert way.settles == "static of bar_upper (29 % lower), fatigue of bar_upper (36 % lower)"
    assert way.text == "least single changes, error bars included"
    assert way.command == "ballesta improve toggle_press.toml"


def test_a_mesh_is_asked_for_the_bar_that_settles_the_check():
    """Left are 236.7 - 225 - 2 = 9.67 MPa, 4.29 %; (15 / 9.67)^1.5 = 1.93 times the unknowns."""
    way = only(design(part(checks=[BY_MESH], rungs=[SOLID])))
    assert way.settles == "static of bar_upper"
    assert way.command == "ballesta check toggle_press.toml --set 'accuracy=\"4.2 %\"'"
    assert way.seconds == pytest.approx(12.0 * (15.0 / 9.667) ** 1.5, rel=1e-3)
    assert replace(BY_MESH, numerical=0.042 * 225.0).status is Status.PASS


def test_a_mesh_that_would_have_to_be_too_fine_is_no_way():
    near = replace(BY_MESH, value=234.6)
    assert near.settled_by_mesh
    assert "nothing here settles it" in only(design(part(checks=[near]))).text


def test_a_check_that_nothing_settles_says_so_with_its_reason():
    way = only(design(part(checks=[BY_MODEL], rungs=[SOLID])))
    assert (way.command, way.seconds) == ("", None)
    assert way.text.startswith(
        "nothing here settles it: the limit lies within the model's own error bar"
    )
    singular = only(design(part(checks=[replace(BY_MODEL, numerical=inf)])))
    assert "nothing here settles it: its numerical error bar is infinite" in singular.text


def test_clearances_up_to_which_it_passes_are_fits_of_the_part():
    """A file that states the arc has to give it up, which no override can do."""
    facts = {clearance_fact("static", "knee"): 0.08, clearance_fact("static", "end"): 0.06}
    result = design(part(checks=[BY_MODEL], facts={"mass [kg]": 4.1, **facts}))
    assumed = replace(result, defaults=[("parts.bar_upper.bearing_arc", "90 deg")])
    way = only(assumed)
    assert way.text.endswith("it passes with clearances up to 0.08 mm")
    assert "'parts.bar_upper.fits.knee=\"0 .. 0.08 mm\"'" in way.command
    assert "'parts.bar_upper.fits.end=\"0 .. 0.06 mm\"'" in way.command
    way = only(result)
    assert way.command == ""
    assert way.text.endswith('passes with fits.knee = "0 .. 0.08 mm", fits.end = "0 .. 0.06 mm"')
    for none in ({clearance_fact("fatigue", "knee"): 0.08}, dict.fromkeys(facts, 0.0)):
        other = replace(assumed, parts=[part(checks=[BY_MODEL], facts=none)])
        assert "nothing here settles it" in only(other).text


def test_fits_of_pins_that_would_hit_come_with_their_cushions():
    """Once its fit is stated, a pin whose force reverses has the bound of its hits in the bars."""
    facts = {clearance_fact("static", "knee"): 0.08, clearance_fact("static", "end"): 0.06}
    reason = f"that of D {WOULD_HIT} 9 N on top of 1 N ({LESS_IN} A, C): in no bar"
    result = replace(
        design(part(checks=[BY_MODEL], facts={"mass [kg]": 4.1, **facts})),
        defaults=[("parts.bar_upper.bearing_arc", "90 deg")],
        assumed=[("parts.fits", reason)],
        inputs=[("parts.bar_upper.like", "bar"), ("parts.bar.interfaces.knee", "B"),
                ("parts.bar.interfaces.end", "A")],
    )  # fmt: skip
    way = only(result)
    assert "slows those of A as they cross their play (dynamics.cushioned)" in way.text
    assert way.command.endswith("--set 'dynamics.cushioned=[\"A\"]'")
    stated = [*result.assumed, ("dynamics.cushioned", "stated of E")]
    assert only(replace(result, assumed=stated)).command == ""


def test_bushes_whose_material_is_not_stated_are_a_way_only_where_steel_passes():
    """Of steel 225 + 1 + 10 = 236 of 236.7 MPa; 2 MPa more in the band that is left do not."""

    def of(steel, others=0.0):
        items = (Given("b_s", "of steel", steel, "MPa"), Given("b_up", "band", 60.0, "MPa"))
        told = Derivation((), (Section("bars", items),), "b_up", "b_up")
        open_one = replace(BY_MODEL, model=60.0 + others, derivation=told)
        return only(design(part(checks=[open_one], rungs=[SOLID]))).text

    assert "bush.material in their stacks): as stiff as steel it passes" in of(10.0)
    assert "nothing here settles it" in of(10.0, 2.0)
    assert "nothing here settles it" in of(60.0)


def test_an_arc_from_which_it_passes_is_a_key_of_the_part():
    facts = {"mass [kg]": 4.1, arc_fact("static"): 135.0}
    way = only(design(part(checks=[BY_MODEL], facts=facts)))
    assert "it passes from 135 deg" in way.text
    assert way.command.endswith("--set 'parts.bar_upper.bearing_arc=\"135 deg\"'")
    assert way.seconds == 25.25  # as this check took


def test_a_drive_counts_where_its_load_bar_alone_holds_the_limit():
    """A doubt of another kind stays: only the drive's own goes where the drive is stated."""
    speed = ("speed up to 5 % slower or faster than its mean", 9.0, 9.0)
    surge = ("changes of speed between its slowest and fastest", 6.0, 6.0)
    loads = replace(BY_MODEL, loads=15.0, loads_below=15.0, model_below=20.0, doubts=(speed, surge))
    silent = design(part(checks=[loads]), assumed=[("drive", "none is stated")])
    way = only(silent)
    assert way.text.endswith("without its bar it is a pass")
    assert way.command.endswith("--set 'drive.control=\"constant\"'")
    other = replace(loads, doubts=(speed, ("press: stop from x = 1 to 3 mm", 6.0, 6.0)))
    little = design(part(checks=[other]), assumed=silent.assumed)
    assert not only(little).command
    assert not only(design(part(checks=[loads]))).command  # the drive is stated


def test_verdicts_that_differ_without_the_bar_of_the_drive_are_told_apart():
    speed = ("speed up to 5 % slower or faster than its mean", 25.0, 25.0)
    check = replace(BY_MODEL, limit=100.0, required=1.0, numerical=0.0, model=30.0, doubts=(speed,))
    checks = [replace(check, value=80.0), replace(check, kind="fatigue", value=110.0)]
    ways = ways_out(design(part(checks=checks), assumed=[("drive", "none is stated")]))
    assert [(way.settles.split()[0], way.text.split()[-1]) for way in ways] == [
        ("static", "pass"),
        ("fatigue", "FAIL"),
    ]


def test_a_doubt_without_end_is_no_way_out():
    speed = ("changes of speed between its slowest and fastest", inf, 0.0)
    check = replace(BY_MODEL, model=inf, doubts=(speed,))
    ways = ways_out(design(part(checks=[check]), assumed=[("drive", "none is stated")]))
    assert not any("drive" in way.text for way in ways)


def test_a_range_that_is_stated_counts_where_it_alone_holds_the_limit():
    bush = ("interference of the bush in first, 0.02 to 0.04 mm", 15.0, 15.0)
    loads = replace(BY_MODEL, loads=15.0, loads_below=15.0, model_below=20.0, doubts=(bush,))
    assert only(design(part(checks=[loads]))).text == (
        "state a narrower range (bush.fit) of the interference of the bush in first, 0.02 to "
        "0.04 mm: at its middle it is a pass"
    )
    stop = replace(loads, doubts=(("press: end of its travel off by up to 0.3 mm", 15.0, 15.0),))
    assert only(design(part(checks=[stop]))).text == (
        "state a smaller cycles.press.stop.tolerance: at the stop itself it is a pass"
    )
    off = "cut: lengths and position off by general tolerances"
    lengths = replace(loads, doubts=((off, 15.0, 15.0),))
    assert only(design(part(checks=[lengths]))).text == (
        "end cut farther from its dead centre: with exact lengths it is a pass"
    )
    little = replace(loads, doubts=((bush[0], 2.0, 2.0),))
    assert "nothing here settles it" in only(design(part(checks=[little]))).text


def test_hits_in_joints_count_where_they_together_hold_the_limit():
    plays = [(f"play of 0.04 mm in {name} as its force reverses", 9.0, 0.0) for name in "AB"]
    loads = replace(BY_MODEL, loads=18.0, model_below=20.0, doubts=tuple(plays))
    way = only(design(part(checks=[loads])))
    assert way.text.startswith("state that oil, preload or friction slows the pins of A, B as")
    assert way.text.endswith("bounds of rigid bodies on steel, it is a pass")
    assert way.command.endswith('--set \'dynamics.cushioned=["A", "B"]\'')
    assert not only(design(part(checks=[loads]), assumed=[("dynamics.cushioned", "C")])).command
    assert open_reason(loads) == (
        "the limit lies within what is not known of its loads: play of 0.04 mm in A as its force "
        "reverses and play of 0.04 mm in B as its force reverses"
    )
    one = replace(loads, doubts=(plays[0],))
    assert "nothing here settles it: the limit lies within the model's own error bar" in (
        only(design(part(checks=[one]))).text
    )


def test_more_positions_are_asked_for_where_the_bar_between_them_holds_the_limit():
    """225 + 20 + 2 MPa of 236.7; 18 of them are between the positions, and no mesh narrows that."""
    check = replace(BY_MESH, numerical=20.0, sampling=18.0, method="formula")
    way = only(design(part(checks=[check])))
    assert way.text.startswith("state more positions of its cycle (cycles.NAME.positions): ")
    assert way.text.endswith("it is a pass")
    assert open_reason(check).startswith("more positions of its cycle can settle it")
    little = replace(check, sampling=5.0)
    assert not any("positions" in way.text for way in ways_out(design(part(checks=[little]))))
    assert open_reason(little).startswith("a finer mesh")


def test_forks_count_where_the_linkage_passes_with_stiff_ones():
    """A share of 0.5 against 1/3; stiff forks leave 0.5 - 0.4 = 0.1, a safety of 10."""
    share = check(kind="buckling", value=0.5, limit=1.0, required=3.0, unit="", numerical=0.0,
                  model=0.0, model_below=0.4, method="frame")  # fmt: skip
    way = only(replace(design(), linkage=[share]))
    assert share.status is Status.UNDECIDED
    assert way.settles == "buckling of the linkage"
    assert way.text.endswith("its safety is then 10.0")
    assert way.command.endswith("--set 'forks=\"stiff\"'")
    loose = replace(
        share, value=0.1, model=inf, model_below=0.0
    )  # of stiff forks; soft hold nothing
    assert only(replace(design(), linkage=[loose])).text.endswith("its safety is then 10.0")
    little = replace(share, model_below=0.2, value=0.45)  # 0.25 of 0.333
    assert only(replace(design(), linkage=[little])).command
    hard = replace(share, model_below=0.2, numerical=0.1)  # 0.3 + 0.06 of 0.333
    assert "nothing here settles it" in only(replace(design(), linkage=[hard])).text
    coarse = replace(share, numerical=0.45, model=0.5)  # bars of a share are shares of it: 0.29
    assert only(replace(design(), linkage=[coarse])).command
    tube = replace(share, kind="static", method="formula")  # of a cylinder, which has no forks
    assert "nothing here settles it" in only(replace(design(), linkage=[tube])).text
    rounded = replace(share, value=1e19, model_below=1.000001e19)  # no more is left than nothing
    assert only(replace(design(), linkage=[rounded])).text


def test_a_better_model_is_a_way_only_for_what_it_may_settle():
    by_formula = replace(BY_MODEL, method="formula")
    told = RungTried("formula", 0.1, 0, [], "goes on", ["static"])
    command = "ballesta check toggle_press.toml --fidelity formula --set 'a=1'"
    way = only(design(part(checks=[by_formula], rungs=[told]), command=command))
    assert way.command == "ballesta check toggle_press.toml --set 'a=1'"
    assert "ballesta plan toggle_press.toml tells its time" in way.text
    late = [told, RungTried("solid", 0.0, 0, [], "no time", ["static"], 40.0)]
    hurried = "ballesta check toggle_press.toml --within 5s"
    way = only(design(part(checks=[by_formula], rungs=late), command=hurried))
    assert (way.command, way.seconds) == ("ballesta check toggle_press.toml", 65.25)
    for_good = replace(told, left=[])
    assert not only(design(part(checks=[by_formula], rungs=[for_good]))).command


def test_edges_that_would_settle_it_are_keys_of_their_bores_with_the_safety_they_give():
    """One command for both checks; with bushes there is none, as their material is not known."""
    both = [BY_MODEL, replace(BY_MODEL, kind="fatigue")]
    bores = ("knee", "end")
    facts = {edges_fact("static", bores): 1.61, edges_fact("fatigue", bores): 1.7}
    way = only(design(part(checks=both, facts={"mass [kg]": 4.1, **facts})))
    assert way.settles == "static of bar_upper, fatigue of bar_upper"
    assert "state edges of knee and end that have run in (bore_edges)" in way.text
    assert "static passes, safety ≥ 1.61" in way.text
    stated = [f"'parts.bar_upper.bore_edges.{bore}=\"run_in\"'" for bore in bores]
    assert way.command.endswith(f"--set {stated[0]} --set {stated[1]}")
    facts = {edges_fact("static", ("knee",), steel=True): 1.5}
    way = only(design(part(checks=[BY_MODEL], facts={"mass [kg]": 4.1, **facts})))
    assert "as stiff as steel" in way.text
    assert (way.command, way.seconds) == ("", None)
    assert only(design(part(checks=[both[1]], facts=facts))).text.startswith("nothing here")
    hit = replace(BY_MODEL, doubts=(("play of 0.1 mm in B:rod as its force reverses", 1.0, 0.0),))
    facts = {edges_fact("static", ("knee",), cushioned=True): 1.5}
    way = only(design(part(checks=[hit], facts={"mass [kg]": 4.1, **facts})))
    assert "slows the pins of B:rod as they cross their play (dynamics.cushioned)" in way.text
    assert way.command.endswith(f"--set {stated[0]} --set 'dynamics.cushioned=[\"B\"]'")


def test_edges_that_a_pass_rests_on_are_told_once_for_parts_alike():
    """With the check that came the farthest above what is allowed; nothing without such edges."""
    passing = replace(BY_MODEL, kind="fatigue", limit=154.0, required=1.3)
    far = {"mass [kg]": 4.1, run_in_fact("fatigue", ["knee"]): 124.2}
    near = {**far, run_in_fact("fatigue", ["knee"]): 122.0}
    both = [
        part(checks=[passing], facts=near),
        replace(part(checks=[passing], facts=far), name="bar_lower"),
    ]
    (said,) = run_in_edges(design(*both))
    assert said == (
        "edges of knee that have run in (bar_upper, bar_lower): as cut, fatigue would not pass, "
        "up to 124 of 118 MPa allowed"
    )
    assert run_in_edges(design(part(checks=[passing]))) == []


def test_a_broken_gate_has_its_key_or_says_what_to_do():
    key = Gate("turn: loads between the positions", 0.1, 0.01, "rise", cure="State more",
               key="cycles.turn.positions=720")  # fmt: skip
    way = only(design(gates=[key]))
    assert way.command.endswith("--set cycles.turn.positions=720")
    assert only(design(gates=[replace(key, key="", cure="")])).text.startswith(
        "nothing here settles it: turn: loads between the positions: 0.1"
    )
    assert ways_out(design(gates=[replace(key, binding=False)])) == []


def test_the_cheapest_way_comes_first_and_one_command_stands_once():
    facts = {"mass [kg]": 4.1, arc_fact("static"): 135.0}
    arc = part(checks=[BY_MODEL], facts=facts)
    mesh = part("pin", checks=[replace(BY_MESH, part="pin")], rungs=[replace(SOLID, seconds=1.0)])
    nothing = part("rod", checks=[BY_MODEL], rungs=[SOLID])
    found = ways_out(design(nothing, arc, mesh))
    assert [way.settles.split()[-1] for way in found] == ["pin", "bar_upper", "rod"]
    two = [replace(BY_MESH, quantity="a"), replace(BY_MESH, quantity="b")]
    way = only(design(part(checks=two, rungs=[SOLID])))
    assert way.settles == "static (a) of bar_upper, static (b) of bar_upper"
    open_ = design(nothing, part("arm", checks=[BY_MODEL], rungs=[SOLID]))
    assert only(open_).settles == "static of rod, static of arm"
    assert way.text.endswith("ask for a numerical error bar of 4.2 %")
    assert way.seconds == pytest.approx(23, abs=0.5)


def test_the_arc_that_is_named_passes_and_the_next_narrower_one_does_not(tmp_path, monkeypatch):
    """A plate whose bearing band of 90 to 180 deg holds the limit, by solids.

    Another check fails, so that contact is not asked.
    """
    monkeypatch.setattr(bands, "_data", lambda: bands_of(formula=0.1))
    arc = 'parts.rod.bearing_arc="90 deg"'
    given = ("duty.cycles.turn=1", 'drive.control="constant"', "require.fatigue=1000", arc)
    solid = Effort("solid")

    def static(*more):
        result = check_design(machine(tmp_path, PLATE, *given, *more), effort=solid)
        (one,) = result.parts
        return result, next(check for check in one.checks if check.kind == "static")

    _, first = static()
    middle = first.value + first.numerical + 0.5 * first.model
    need = f"require.static={first.limit / middle}"
    result, open_ = static(need)
    assert open_.status is Status.UNDECIDED
    way = next(way for way in result.ways if "arc" in way.text)
    arc = float(way.text.rpartition("from ")[2].removesuffix(" deg"))
    assert 90 < arc < 180
    _, wide = static(need, f'parts.rod.bearing_arc="{arc:g} deg"')
    _, narrow = static(need, f'parts.rod.bearing_arc="{arc - 15:g} deg"')
    assert wide.status is Status.PASS
    assert narrow.status is Status.UNDECIDED
    assert result.to_dict()["ways_out"][0]["command"] == result.ways[0].command
