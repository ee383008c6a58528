"""Derivations: evaluated in order, as plain data and back, on the page and on the terminal."""

import json
from dataclasses import replace
from html.parser import HTMLParser
from math import inf

import pytest

from checks.result.derivation import (
    Acting,
    BarSymbols,
    Column,
    Derivation,
    Given,
    HandComparison,
    LoadCase,
    Section,
    Step,
    Sum,
    Superposition,
    UnitLoad,
    derivation_of_data,
)
from checks.result.formulas import FormulaError
from checks.result.verdict import Status
from reports.derivation_text import bar_texts, derivation_text, paragraphs, shares_of, status_texts
from reports.page import FILTERS, formula_markup, view_of
from reports.templating import environment

from ..misses import misses
from .results import HOSTILE, check

VOID = {"br"}


class Page(HTMLParser):
    """Tags with their attributes; every tag that is opened is closed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.open = [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


LOADS = (
    UnitLoad("bore F", "N", 1000.0, (0.1, 0.02, 0.0, 0.0, 0.0, 0.0)),
    UnitLoad("bore couple", "N mm", -50.0, (0.0, 0.0, 0.0, 0.4, 0.0, 0.0)),
)


STRESS = Superposition("s", "stress there", "press, x = 2 mm", LOADS)
SUM = Sum(
    "q",
    "a sum",
    "a*b",
    ("one", "two"),
    (Column("a", "first", "", (1.0, 2.0)), Column("b", "second", "mm", (3.0, 4.0))),
    "mm",
)
ACTING = Acting("bore", "B", (1e3, 0.0, 0.0, 0.0, 0.0, -50.0))


def derivation(**changes):
    """A stress by two unit loads, a limit, and a bar."""
    demand = Step("sigma", "von Mises", "von_mises(s)", "MPa", "a book", main=True)
    limit = Given("S_y", "yield stress", 355.0, "MPa", "EN 10025-2", main=True)
    values = {
        "cases": (LoadCase("s", "press", "x = 2 mm", 7, (ACTING,)),),
        "sections": (
            Section("Stress at the point", (STRESS,)),
            Section("Demand", (demand,)),
            Section("Limit", (limit, SUM)),
            Section("Error bars", (Step("e_num", "a bar", "0.01*sigma", "MPa"),)),
        ),
        "value": "sigma",
        "limit": "S_y",
        "bars": BarSymbols("e_num", words="as found"),
        "compared": (HandComparison("axial stress", 100.0, 99.0, "MPa", "F/A"),),
        "notes": ("a note",),
    } | changes
    return Derivation(**values)


def explained(**changes):
    own = derivation()
    value = own.number("sigma")
    return check(value=value, numerical=0.01 * value, model=0.0, derivation=own, **changes)


def test_each_item_uses_what_stands_before():
    own = derivation()
    # 100, 20, 0 and a shear of 20: sqrt(100^2 - 100 20 + 20^2 + 3 20^2)
    assert own.number("sigma") == pytest.approx(9600**0.5, rel=1e-14)
    assert own.number("q") == 11.0


def test_a_symbol_that_comes_too_late_is_told():
    sections = derivation().sections[::-1]
    with pytest.raises(FormulaError, match="has no value"):
        _ = replace(derivation(), sections=sections).values


def test_a_symbol_that_is_given_twice_is_told():
    twice = derivation().with_items("again", [Given("sigma", "another", 1.0)])
    with pytest.raises(FormulaError, match="twice"):
        _ = twice.values


def test_what_the_formulas_miss_is_told():
    own, one = derivation(), replace(explained(), limit=355.0)
    assert misses(own, one) == ""
    assert misses(own, replace(one, value=one.value * (1 + 1e-12))) == ""
    assert "a value of 97.97" in misses(own, replace(one, value=1.00001 * one.value))
    assert "a limit of 355" in misses(own, replace(one, limit=354.0))
    assert "q" in misses(replace(own, equal=(("q", "S_y"),)), one)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"numerical": 0.98}, "the formulas give a numerical bar of 0.9797"),
        ({"numerical": 0.0}, "the formulas give a numerical bar of 0.9797"),
        ({"numerical": inf}, "where an infinite one must stand"),
        ({"model": 1.0, "model_below": 0.0}, "no formula gives the model band above of 1"),
        ({"model_below": 2.0}, "no formula gives the model band below of 2"),
        ({"model": 1e-6, "model_below": 0.0}, "no formula gives the model band above of 1e-06"),
    ],
)
def test_a_bar_that_no_formula_gives_is_told(changes, said):
    one = replace(explained(), limit=355.0)
    assert said in misses(derivation(), replace(one, **changes))


def test_an_infinite_limit_is_no_formula_s():
    assert "where inf must stand" in misses(derivation(), replace(explained(), limit=inf))


def test_an_infinite_bar_needs_words_and_no_formula():
    one = replace(explained(), limit=355.0, model=inf, model_below=0.0)
    assert misses(derivation(), one) == ""
    silent = derivation(bars=BarSymbols("e_num"))
    assert "nothing says why the model band above is infinite" in misses(silent, one)


def test_a_sum_or_a_step_that_gives_a_vector_is_refused():
    for item in (replace(SUM, symbol="w", formula="a*s"), Step("w", "", "s/2")):
        with pytest.raises(FormulaError, match="'w' must be a number"):
            _ = derivation().with_items("more", [item]).values


def test_a_sum_that_no_number_can_hold_is_refused():
    far = Sum("w", "", "a", ("1", "2"), (Column("a", "", "", (1.7e308, 1.7e308)),))
    with pytest.raises(FormulaError, match="not finite"):
        _ = derivation().with_items("more", [far]).values
    with pytest.raises(FormulaError, match="no formula"):
        _ = derivation().with_items("more", [Sum("w", "", "((", (), ())]).values


def test_it_comes_back_from_json_as_it_was():
    own = derivation()
    assert derivation_of_data(json.loads(json.dumps(own.to_dict()))) == own


@pytest.mark.parametrize("missing", ["cases", "sections", "value", "bars"])
def test_data_of_another_version_is_refused(missing):
    data = derivation().to_dict()
    del data[missing]
    with pytest.raises(ValueError, match="not a derivation of this version"):
        derivation_of_data(data)


def test_data_with_a_number_that_is_none_is_refused():
    data = derivation().to_dict()
    data["sections"][2]["items"][0]["value"] = "355"
    with pytest.raises(ValueError, match="no number"):
        derivation_of_data(data)


def test_a_sum_needs_as_many_values_as_rows():
    with pytest.raises(ValueError, match="2 rows"):
        Sum("q", "", "a", ("one", "two"), (Column("a", "", "", (1.0,)),))


def test_the_shares_of_unit_loads_are_the_von_mises_stress():
    own = derivation()
    shares = shares_of(own.items[0])
    assert sum(shares) == pytest.approx(own.number("sigma"), rel=1e-14)
    assert shares[0] > shares[1] > 0


def test_the_check_keeps_its_derivation_out_of_comparisons_and_in_its_data():
    one = explained()
    assert one == replace(one, derivation=None)
    assert "derivation" not in replace(one, derivation=None).to_dict()
    assert one.to_dict()["derivation"]["value"] == "sigma"


@pytest.mark.parametrize(
    ("limit", "status", "count"),
    [(355.0, Status.PASS, 2), (148.0, Status.UNDECIDED, 3), (100.0, Status.FAIL, 3)],
)
def test_the_rule_of_the_status_is_told_with_numbers(limit, status, count):
    one = replace(explained(), limit=limit)
    texts = status_texts(one)
    assert one.status is status
    assert len(texts) == count
    assert texts[-1].startswith(str(status))
    assert texts[0].startswith("(97.98 + 0.9798)·1.5 = 148.4 MPa")


def test_bars_are_told_with_their_formulas():
    assert bar_texts(explained()) == ["numerical ±0.9798 MPa = 0.01·97.98", "as found"]


def test_an_infinite_bar_is_told_as_such():
    one = replace(explained(), model=float("inf"))
    assert "model + infinite" in bar_texts(one)[1].replace("+infinite", "+ infinite")
    assert "∞" in status_texts(one)[0]


def test_the_short_telling_has_loads_stress_demand_limit_bars_and_verdict():
    text = derivation_text(explained(), "static", width=90)
    labels = [line.split()[0] for line in text.splitlines()[1:] if not line.startswith(" ")]
    assert labels == ["loads", "stress", "demand", "limit", "bars", "by", "verdict"]
    assert len(text.splitlines()) <= 14
    assert "S_y = 355 MPa [EN 10025-2]" in text


def test_a_check_without_a_derivation_says_so():
    assert "no derivation" in derivation_text(check(), "static")
    assert view_of(check()) is None


def test_a_sum_stands_as_a_table():
    limit = next(p for p in paragraphs(derivation()) if p.title == "Limit")
    (table,) = limit.tables
    assert [row[-1] for row in table.rows] == ["3", "8"]
    assert table.total[-1] == "11"


def page_of(one, governing=False):
    made = environment()
    made.filters |= FILTERS
    template = made.from_string(
        "{% from 'derivation.html.j2' import derivation_of %}"
        "{{ derivation_of(check, title, governing) }}"
    )
    return template.render(check=one, title="static", governing=governing)


def test_the_page_has_a_closed_section_with_tables_that_have_captions_and_heads():
    text = page_of(explained())
    page = Page(text)
    assert text.count("<details") == 1
    assert "open" not in dict(next(attrs for tag, attrs in page.tags if tag == "details"))
    tables = [tag for tag, _ in page.tags if tag == "table"]
    assert len(tables) == len([tag for tag, _ in page.tags if tag == "caption"])
    assert all("scope" in attrs for tag, attrs in page.tags if tag == "th")
    assert "S<sub>y</sub>" in text


def test_hostile_names_stay_text():
    own = derivation(
        cases=(LoadCase("s", HOSTILE, HOSTILE, 0, (Acting(HOSTILE, HOSTILE, (1.0,) * 6),)),),
        notes=(HOSTILE,),
        unproved=HOSTILE,
        compared=(HandComparison(HOSTILE, 1.0, 2.0, HOSTILE, HOSTILE),),
    )
    long = "x" * 10_000
    one = replace(explained(part=long, quantity=HOSTILE), derivation=own)
    text = page_of(one)
    Page(text)
    assert "<script" not in text
    assert "\x1b" not in text
    assert "\u202e" not in text
    told = derivation_text(one, HOSTILE, everything=True, width=80)
    assert "\x1b" not in told
    assert long not in told


def test_subscripts_are_set_and_the_rest_is_escaped():
    assert formula_markup("σ_a < S_e") == "σ<sub>a</sub> &lt; S<sub>e</sub>"
    assert formula_markup("<b>bar_upper</b>") == "&lt;b&gt;bar_upper&lt;/b&gt;"


STYLE = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>t</title><style>
:root {{ --ground: #fff; --panel: #eee; --ink: #000; --soft: #555; --line: #ccc;
  --undecided: #850; }} .scroll {{ overflow-x: auto; }} {css}</style></head>
<body><main>{body}</main></body></html>"""


@pytest.fixture
def written(tmp_path):
    """A page with two derivations, the second one governing."""
    css = environment().get_template("derivation.css").render()
    body = page_of(explained()) + page_of(explained(), governing=True)
    path = tmp_path / "page.html"
    path.write_text(STYLE.format(css=css, body=body), encoding="utf-8")
    return path


def test_in_the_browser_it_opens_without_scripts(opened, written):
    found = opened(written, java_script_enabled=False)
    first = found.page.locator("details").first
    assert not first.locator("table").first.is_visible()
    first.locator("summary").click()
    assert first.locator("table").first.is_visible()
    found.assert_quiet()


def test_in_print_only_the_governing_one_is_shown_whole(opened, written):
    found = opened(written)
    found.page.emulate_media(media="print")
    closed, governing = found.page.locator("details").all()
    assert not closed.is_visible()
    assert governing.locator("table").first.is_visible()
    assert governing.locator("h4").last.is_visible()


def test_on_a_phone_nothing_is_wider_than_the_page(opened, written):
    found = opened(written, width=360)
    for summary in found.page.locator("summary").all():
        summary.click()
    wide = found.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 360


def test_the_keyboard_opens_it(opened, written):
    found = opened(written)
    found.page.keyboard.press("Tab")
    found.page.keyboard.press("Enter")
    assert found.page.locator("details").first.locator("table").first.is_visible()


def test_the_rule_of_an_undecided_check_takes_each_bar_on_its_own_side():
    one = replace(explained(), value=100.0, numerical=2.0, model=30.0, model_below=5.0,
                  limit=130.0, required=1.2)  # fmt: skip
    assert one.status is Status.UNDECIDED
    upper, lower, _ = status_texts(one)
    assert upper.startswith("(100 + 2 + 30)·1.2 = 158.4")
    assert "> 130" in upper
    assert lower.startswith("(100 − 2 − 5)·1.2 = 111.6")
    assert "≤ 130" in lower
