from dataclasses import replace

from rich.cells import cell_len

from reports.page import report_html
from reports.terminal import tried_sentence, verdict_text

from . import ladder_results, results
from .test_page import Page


def words(text):
    return " ".join(text.split())


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
    rungs = ladder_results.HOSTILE_RUNGS
    result = results.design(results.part(rungs=rungs))
    assert not {"\x1b", "\u202e"} & set(verdict_text(result, 100))
    assert max(map(cell_len, verdict_text(result, 100).splitlines())) <= 100
    scripts = [a.get("type") for tag, a in Page(report_html(result)).tags if tag == "script"]
    assert scripts.count(None) == 1  # the page's own
