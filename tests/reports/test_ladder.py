import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from math import inf

import pytest
from rich.cells import cell_len

from reports import report_html, verdict_text
from reports.files import plain
from reports.ladder_page import ladder_chart, ladder_html, ladder_text
from reports.ladder_summary import tried_sentence, value_and_bar, whole_bar

from . import ladder_results, results
from .test_page import Page


def words(text):
    return " ".join(text.split())


def test_every_rung_shows_its_value_and_whole_bar_against_its_time():
    """The beam's numerical bar is infinite; plane: 4 numerical and 20 of the model are 24."""
    lines = ladder_text(ladder_results.ladder(), 120).splitlines()
    formula, beam, solid, auto = (words(line) for line in lines[4:8])
    assert formula == "static formula 0.012 s 0 200 MPa +30 −10 237 pass"
    assert beam == "beam 0.25 s 312 210 MPa ±∞ (no bar) 237 UNDECIDED"
    assert solid == "solid 1 14 s 48201 207 MPa ±24 237 pass"
    assert auto == "auto 0.012 s 200 MPa +30 −10 237 pass"


def test_a_rung_without_a_model_is_told_apart_from_one_without_an_answer():
    unbuckled = replace(ladder_results.BEAM, checks=ladder_results.BEAM.checks[:1])
    parts = (
        ladder_results.part(rungs=[ladder_results.FORMULA, unbuckled]),
        ladder_results.part("pin_B", rungs=[ladder_results.FORMULA, ladder_results.NONE]),
    )
    text = words(ladder_text(ladder_results.ladder(*parts), 120))
    assert "beam no answer to it" in text
    assert "beam not available: there is no beam of this shape" in text


def test_each_part_ends_with_what_auto_takes_and_why_it_stopped():
    text = words(ladder_text(ladder_results.ladder(ladder_results.part()), 200, ["out/x.html"]))
    assert (
        "AUTO after 0.012 s: static 200 +30 −10 MPa by formula, pass; "
        "buckling 0.0200 ±0.010 by formula, pass "
        "formula 0.012 s, stopped: static pass, 1.5 times its bars included"
    ) in text
    assert text.endswith("written: out/x.html")


def test_a_rung_that_auto_left_for_lack_of_time_is_named():
    left = ladder_results.part(tried=[ladder_results.FORMULA, ladder_results.LEFT])
    text = words(ladder_text(ladder_results.ladder(left), 200))
    assert "solid passed over, no time: about 30 s, 2 s are left" in text


def test_a_part_that_no_rung_answers_is_told_and_has_no_chart():
    none = ladder_results.part(rungs=[ladder_results.NONE], tried=[], chosen=[])
    assert "AUTO     after 0 s: no answer" in ladder_text(ladder_results.ladder(none), 120)
    assert ladder_chart(none) == ""
    assert "No rung has a value" in Page(ladder_html(ladder_results.ladder(none))).text


@pytest.mark.parametrize("width", [100, 120])
@pytest.mark.parametrize("make", [ladder_results.ladder, ladder_results.hostile])
def test_no_line_is_wider_than_the_terminal(make, width):
    lines = ladder_text(make(), width).splitlines()
    assert max(cell_len(line) for line in lines) <= width


def test_hostile_names_steer_neither_terminal_nor_page():
    assert not {"\x1b", "\u202e"} & set(ladder_text(ladder_results.hostile(), 100))
    page = Page(ladder_html(ladder_results.hostile()))
    assert "<script>alert('x')</script>" in page.text
    assert "script" not in {tag for tag, _ in page.tags}
    assert not {"\x1b", "\u202e"} & set(page.text)


def test_the_page_stands_alone_with_a_chart_and_tables_of_every_part():
    page = Page(ladder_html(ladder_results.ladder()))
    kinds = [tag for tag, _ in page.tags]
    assert not set(kinds) & {"script", "link", "iframe", "img", "form"}
    charts = [a["aria-label"] for tag, a in page.tags if tag == "svg"]
    assert charts == ["Ladder of bar_upper", "Ladder of pin_B"]
    assert kinds.count("table") == kinds.count("caption") == 4
    assert all(a.get("scope") in ("row", "col") for tag, a in page.tags if tag == "th")
    scrolling = [a for _, a in page.tags if "scroll" in a.get("class", "").split()]
    assert all(a["tabindex"] == "0" for a in scrolling)
    ids = [a["id"] for _, a in page.tags if "id" in a]
    assert sorted(ids) == sorted(set(ids))
    assert "ballesta ladder designs/toggle_press.toml" in page.text


def test_the_chart_says_times_in_numbers_and_names_every_rung():
    """Times from 0.012 s to 14 s: decades in between are ticks, written without an exponent."""
    chart = ladder_chart(ladder_results.part())
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", chart)
    assert {"0.1", "1", "10"} <= set(texts)
    assert {"formula", "beam", "solid 1", "auto", "allowed"} <= set(texts)


def test_a_limit_that_differs_from_rung_to_rung_is_drawn_at_each():
    """Another limit changes one panel from a line across to marks; the same limit changes none."""
    other = replace(ladder_results.FORMULA.checks[0], limit=300.0)
    mixed = replace(ladder_results.FORMULA, checks=[other])
    same = ladder_results.part(kinds=("static",))
    marked = ladder_results.part(kinds=("static",), rungs=[mixed, ladder_results.SOLID])

    def limits(part):
        drawn = [node for node in ET.fromstring(ladder_chart(part)) if node.get("d")]
        red = [node.get("d") for node in drawn if "--chart-fail" in node.get("style")]
        return sum(way.count("M") for way in red)

    assert limits(same) == 2  # the line, and its sample beside the panel
    assert limits(marked) == 4  # of two rungs and what auto took, and the sample


def test_a_whole_bar_adds_the_numerical_bar_to_the_model_band():
    check = results.check(numerical=4.0, model=20.0, model_below=6.0)
    assert whole_bar(check) == (24.0, 10.0)
    assert value_and_bar(check) == ("141", "+24 −10")
    assert value_and_bar(replace(check, model=inf))[1] == "±∞ (no bar)"


def test_the_ladder_is_plain_data():
    data = json.loads(json.dumps(plain(ladder_results.ladder().to_dict()), allow_nan=False))
    part = data["parts"][0]
    assert [rung["rung"] for rung in part["rungs"]] == ["formula", "beam", "solid 1"]
    assert part["rungs"][1]["checks"][0]["numerical"] is None
    assert part["auto"]["seconds"] == pytest.approx(0.0123)


def climbed(**changes):
    rungs = [
        replace(ladder_results.FORMULA, why="goes on: static has its limit within its bars"),
        ladder_results.NONE,
        replace(ladder_results.SOLID, rung="solid", why="stopped: static pass"),
    ]
    return results.part(rungs=rungs, **changes)


def test_the_verdict_tells_what_was_tried_of_a_part_and_why_it_stopped():
    text = words(verdict_text(results.design(climbed()), 200))
    assert (
        "LADDER bar_upper: formula 0.012 s (goes on: static has its limit within its bars), "
        "solid 14 s (stopped: static pass)"
    ) in text
    assert "no beam of this shape" not in text  # only what was tried, or what was left at last


def test_the_verdict_names_a_solid_that_there_was_no_time_for():
    said = tried_sentence([ladder_results.FORMULA, ladder_results.LEFT])
    assert said.endswith(
        "solid passed over (no time: about 30 s, 2 s are left; it may settle static)"
    )


def test_a_result_without_rungs_has_no_ladder():
    assert "LADDER" not in verdict_text(results.design(), 200)
    assert "Models that were tried" not in report_html(results.design())


def test_a_long_reason_is_clipped_in_the_verdict_and_whole_in_the_report():
    """Each reason of a line takes 90 characters at most; that of the page 600."""
    why = "stopped: " + "reason " * 40 + "end"
    result = results.design(results.part(rungs=[replace(ladder_results.SOLID, why=why)]))
    (line,) = [ln for ln in verdict_text(result, 300).splitlines() if ln.startswith("LADDER")]
    assert len(line) < 150
    assert words(why) in Page(report_html(result)).text


def test_the_report_has_every_check_of_every_rung():
    page = Page(report_html(results.design(climbed())))
    text = page.text
    table = text[text.index("Models that were tried") :]
    for part in (
        "formula 0.012 0 static 200 MPa ±0 +30 −10",
        "beam – – passed over there is no beam of this shape",
        "solid 14 48 201 static 207 MPa ±4 ±20",
    ):
        assert part in words(table), part
    assert all(a.get("scope") in ("row", "col") for tag, a in page.tags if tag == "th")


def test_hostile_rungs_are_text_in_the_verdict():
    rungs = ladder_results.hostile().parts[0].rungs
    result = results.design(results.part(rungs=rungs))
    assert not {"\x1b", "\u202e"} & set(verdict_text(result, 100))
    assert max(map(cell_len, verdict_text(result, 100).splitlines())) <= 100
    scripts = [a.get("type") for tag, a in Page(report_html(result)).tags if tag == "script"]
    assert scripts.count(None) == 1  # the page's own
