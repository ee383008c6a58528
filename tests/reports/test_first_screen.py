"""The ten questions of a designer, answered without scrolling and in the first 25 lines."""

import re
from dataclasses import replace
from math import isfinite
from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from ballesta.sweeps.improve import with_changes
from checks.design.effort import Effort
from checks.result.verdict import Status
from checks.result.words import clean, moment, need_text, number, safety_text
from reports.answer_facts import answer_text
from reports.page import write_report

from .test_numbers_agree import assert_same_everywhere, schema_of_results

ROOT = Path(__file__).parents[2]
schema = schema_of_results
DESIGNS = ROOT / "designs"
ALIKE = ("toggle_press", "toggle_press_as_sized", "toggle_press_friction")  # two others of five
ALL = sorted(
    path
    for path in (*DESIGNS.glob("*.toml"), *DESIGNS.glob("gallery/*.toml"))
    if path.stem not in ALIKE
)
FAST = "toggle_press_30x30"
MOST_LINES = 25
MOST_SHEETS = 8  # without the annex

# Text that is seen without scrolling, each piece of it whole.
SEEN = """() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = [], range = document.createRange();
  while (walker.nextNode()) {
    const node = walker.currentNode;
    if (!node.data.trim() || !node.parentElement.checkVisibility()) continue;
    if (node.parentElement.closest("script, style, noscript, option")) continue;
    range.selectNodeContents(node);
    const box = range.getBoundingClientRect();
    if (box.width && box.top >= 0 && box.bottom <= innerHeight) seen.push(node.data);
  }
  return seen.join(" ");
}"""


def words(text):
    return " ".join(text.split()).lower()


def questions(result):
    """What stands in an answer to each of them, every piece as it must be read."""
    check, keys = result.deciding, "mass [kg]"
    masses = [float(part.facts[keys]) for part in result.parts if keys in part.facts]
    passes = all(one.status is Status.PASS for one in result.checks)
    broken = [gate for gate in result.all_gates if not gate.holds]
    binds = any(gate.binding for gate in broken)
    held = "not valid" if binds else "not met" if broken else "validity checks hold"
    known = passes or isfinite(check.upper)
    changes = "ballesta improve" if result.changes else clean(result.unchanged)
    if not (known or result.changes):  # a better model comes first where nothing else is told
        changes = "a model that knows its error bar"
    return {
        "does it survive?": [str(result.status)],
        "which part?": [f"{check.kind}", f"of {check.part}"],
        "where?": [clean(check.place) or "whole part"],
        "when?": [clean(moment(check))],
        "by how much?": [safety_text(check.safety, check.required), need_text(check.required)],
        "of what mass?": [f"{number(sum(masses))} kg"],
        "why is it open?": [] if check.status is Status.PASS else [
            "why open" if check.status is Status.UNDECIDED else "even at the lower end"],
        "what to change?": ["to save" if passes else "to pass", changes],
        "what is assumed?": ["assumed", "assumption"],
        "what was not checked?": ["not checked", "impact"],
        "is it valid?": [held],
    }  # fmt: skip


def unanswered(result, text):
    return [
        (question, piece)
        for question, pieces in questions(result).items()
        for piece in pieces
        if words(piece) not in words(text)
    ]


@pytest.mark.parametrize(
    "design",
    [
        pytest.param(path, id=path.stem, marks=() if path.stem == FAST else pytest.mark.slow)
        for path in ALL
    ],
)
def test_page_and_terminal_answer_ten_questions_at_once_with_the_same_numbers(
    design, tmp_path, opened, monkeypatch, schema
):
    """By formula, so that no design costs a solid: page and terminal are written the same way.

    Designs are named as their users do: a long path takes lines of the commands that are told.
    """
    monkeypatch.chdir(ROOT)
    stated = read_design(design.relative_to(ROOT), ())
    if design.stem == "spring_hammer":  # of twelve cycles those that decide
        few = {name: stated.cycles[name] for name in ("at_5_work_10", "at_10")}
        stated = replace(stated, cycles=few)
    result = with_changes(stated, check_design(stated, effort=Effort("formula"), live=True))
    text = answer_text(result, 100, "out/report.html")
    assert len(text.splitlines()) <= MOST_LINES
    assert unanswered(result, text) == []
    page = tmp_path / "report.html"
    write_report(result, None, page)
    found = opened(page, width=1440, height=900)
    found.page.locator("html[data-live=ready]").wait_for(state="attached")
    assert unanswered(result, found.page.evaluate(SEEN)) == []
    frame = found.page.locator(".live-frame").bounding_box()
    assert frame["y"] + frame["height"] <= 900
    assert found.page.evaluate("ballesta.live.field") is not None  # never a grey part
    found.page.add_style_tag(content=".annex-title, .annex-title ~ * { display: none !important; }")
    printed = found.page.pdf(format="A4", print_background=True)
    assert len(re.findall(rb"/Type /Page\b", printed)) <= MOST_SHEETS
    found.assert_quiet()
    assert_same_everywhere(result, tmp_path, schema)
