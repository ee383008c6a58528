from dataclasses import replace
from html import unescape
from math import inf

import pytest

from checks.result.derivation import Derivation, LoadCase
from checks.result.verdict import Gate, RungTried
from reports.gauge import gauge
from reports.live.section import live_section
from reports.page import report_html
from reports.page_words import (
    deciding_place,
    mirrored,
    page_bars,
    place_of,
    reach_words,
    rungs_beside,
)

from . import motion_results, results
from .test_page import Page

LOADS = Gate("press: quasi-static loads", 4.83, 1.2, "not valid")
NBSP = "\N{NO-BREAK SPACE}"


def bars(**changes):
    return page_bars(results.check(**changes)).replace(NBSP, " ")


def test_a_formula_without_bars_is_not_written_as_exact():
    assert bars(numerical=0.0, model=0.0) == "no error bar stated"
    text = Page(report_html(results.design(results.part(
        checks=[results.check(numerical=0.0, model=0.0)])))).text  # fmt: skip
    assert "no error bar stated" in text
    assert "±0" not in text


def test_bars_below_a_thousandth_of_the_value_count_as_nothing():
    assert bars(numerical=0.0, model=1e-9, model_below=20.0) == "+0 −20 model"
    assert bars(numerical=1e-9, model=20.0) == "±20 model"
    assert bars(numerical=1e-9, model=0.0) == "±0 (below 0.1 % of the value)"
    assert bars(numerical=0.2, model=0.0) == "±0.2 numerical"


def test_the_utilisation_at_the_upper_end_of_the_bars_stands_beside_the_value():
    assert reach_words(results.check()) == "up to 0.70"  # (141 + 24) 1.5 / 355 = 0.697
    assert reach_words(results.check(numerical=0.0, model=0.0, model_below=30.0)) == ""
    assert reach_words(results.check(model=inf)) == "no upper end"
    text = Page(report_html(results.mixed())).text
    # fatigue: (180 + 24) 1.3 / 150
    assert "1.56 up to 1.77" in text
    assert "All checks, worst first, error bars included." in text


def test_bars_that_leave_the_gauge_end_in_an_arrow():
    inside, outside = results.check(value=220.0), results.check(value=220.0, model=200.0)
    assert "beyond" not in gauge(inside)
    assert "beyond" in gauge(outside)
    assert "beyond" not in gauge(results.check(model=inf))  # dotted instead


def test_an_uneven_band_that_is_wider_than_the_value_is_told_in_one_wording():
    wide = results.check(value=187.0, numerical=0.0, model=222.0, model_below=60.0, limit=275.0)
    text = Page(report_html(results.design(results.part(checks=[wide])))).text.replace(NBSP, " ")
    assert "its model bar is wider than the value: +222 −60 on 187 MPa" in text
    assert text.count("+222 −60 model") >= 2
    assert "±220" not in text


def test_a_pass_under_invalid_loads_is_marked_in_words_and_not_proven():
    result = results.design(gates=[LOADS])
    page = Page(report_html(result))
    assert "no pass is proven" in page.text
    assert "NOT VALID press: quasi-static loads: 4.83 > 1.20; not valid" in page.text
    # the part's card, both tables, the part's head
    assert page.text.count("PASS, loads not valid") == 4
    assert any("doubted" in (a.get("class") or "") for tag, a in page.tags if tag == "a")
    for gates in ([], [replace(LOADS, binding=False)], [replace(LOADS, value=1.0)]):
        text = Page(report_html(results.design(gates=gates))).text
        assert "loads not valid" not in text
        assert "not proven" not in text


def test_a_broken_gate_of_a_part_marks_the_passes_of_that_part_alone():
    broken = results.part("bar", [results.check("bar")], gates=[LOADS])
    sound = results.part("pin", [results.check("pin")])
    text = Page(report_html(results.design(broken, sound))).text
    assert text.count("PASS, a validity check of the part does not hold") == 4
    assert "loads not valid" not in text


def test_what_to_do_about_a_gate_comes_first():
    cure = "A flywheel of 2 kg m2 brings it to 0.1"
    gate = Gate("press: uneven", 2.0, 0.1, "speed varies", cure=cure)
    text = Page(report_html(results.design(gates=[gate]))).text
    first = text.index("Know this NOT VALID")
    assert text.index(f"{cure}.", first) < text.index("speed varies", first)
    assert f"speed varies. {cure}" in text  # in the table of the gates
    assert gate.to_dict()["cure"] == cure
    assert replace(gate, cure="").told == "speed varies"


def rung(name, *checks):
    return RungTried(name, 0.1, 0, checks, "goes on")


def test_the_formulas_number_stands_beside_the_solids():
    solid = results.check(method="solid", value=207.0)
    cheap = results.check(
        method="formula", value=199.0, numerical=0.0, model=21.0, model_below=27.0
    )
    other = results.check(kind="buckling", method="formula")
    part = results.part(checks=[solid, other], rungs=[rung("formula", cheap, other), rung("solid")])
    (row,) = rungs_beside(part)
    assert row.cheap.replace(NBSP, " ") == "199 +21 −27 model"
    assert (row.decided[:3], row.ratio) == ("207", "1.04")
    text = Page(report_html(results.design(part))).text
    assert "The first 1 set the formulas' peak beside the model's" in text
    assert "the others test the load path, not the peak" in text
    assert rungs_beside(replace(part, rungs=[])) == []
    assert rungs_beside(replace(part, checks=[replace(solid, method="formula")])) == []


@pytest.mark.parametrize(
    ("body", "method", "place", "told"),
    [
        ("half", "solid", "knee (22.0, 0.0, 40.0)", "and its mirror image at z = −40 mm"),
        ("half", "solid", "knee (22.0, 0.0, 0.0)", ""),
        ("half", "solid", "knee", ""),
        ("half", "formula", "knee (22.0, 0.0, 40.0)", ""),
        ("whole", "solid", "knee (22.0, 0.0, 40.0)", ""),
    ],
)
def test_a_place_on_a_half_has_its_mirror_image(body, method, place, told):
    check = results.check(method=method, place=place)
    part = results.part(checks=[check], meshes=[{"body": body}])
    assert mirrored(check, part) == told
    text = Page(report_html(results.design(part))).text
    assert ("mirror image" in text) == bool(told)
    assert ("Places (x, y, z) are in mm, in the part's own axes" in text) == ("(" in place)


def test_two_positions_of_a_fatigue_check_are_explained():
    swing = results.check(kind="fatigue", position="x = 2 mm to x = 2 mm return")
    for check, expected in ((swing, True), (results.PASSING, False)):
        page = Page(report_html(results.design(results.part(checks=[check]))))
        titles = [a.get("title") or "" for _, a in page.tags]
        assert any(title.startswith("The swing between") for title in titles) == expected


def derived(check, *indices):
    cases = tuple(LoadCase("s", "press", "x", index, ()) for index in indices)
    return replace(check, derivation=Derivation(cases=cases, sections=(), value="v", limit="e"))


def test_all_views_begin_where_the_deciding_check_is_decided():
    """Its load case, which for fatigue is not where the part's stress is largest."""
    result = motion_results.press()
    decides = result.deciding
    part = next(part for part in result.parts if part.name == decides.part)
    index = int(result.motion["press"].index[7])
    moved = derived(replace(decides, kind="fatigue", cycle="press"), index)
    result = replace(
        result,
        parts=[replace(each, checks=[moved] if each is part else []) for each in result.parts],
    )
    cycle = list(result.cycles).index("press")
    assert deciding_place(result) == (cycle, index, result.parts.index(
        next(each for each in result.parts if each.name == part.name)))  # fmt: skip
    assert f'"start":[{cycle},{index}]' in live_section(result)
    page = report_html(result)
    position = result.cycles["press"]["position"][index]
    assert f'"position": [{cycle}, {index}]' in unescape(page)
    assert f"cycle press, x = {position:.5g} mm" in page


@pytest.mark.parametrize("ends", [(3, 5), (5, 3)])
def test_of_a_swing_the_end_that_stresses_the_part_more_is_shown(ends):
    peaks = [0.0] * 12
    peaks[3], peaks[5] = 200.0, 0.5
    check = derived(replace(results.FAILING, part="bar_upper", cycle="press"), *ends)
    part = results.part(checks=[check])
    cycle = results.cycle() | {"peaks": {part.name: peaks}}
    result = results.design(part, cycles={"press": cycle})
    assert part.name == check.part
    assert place_of(check, result) == (0, 3, 0)


def test_without_a_load_case_the_part_s_peak_is_shown_where_it_is_known():
    result = results.design()
    assert deciding_place(result) == place_of(result.checks[0], result) is not None
    fatigue = results.design(results.part(checks=[results.FAILING]))
    assert place_of(fatigue.checks[0], fatigue) is None
    assert deciding_place(fatigue) == deciding_place(result)
    nothing = {"press": results.cycle() | {"peaks": None}}
    assert deciding_place(results.design(cycles=nothing)) is None
    assert deciding_place(results.design(results.part(checks=[]))) is None
