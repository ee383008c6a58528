import re
from html.parser import HTMLParser

import pytest

from reports import Pictures, report_html, write_report
from reports.page import ratio, value_text
from reports.verdict import Gate, HandCheck

from . import results

VOID = {"meta", "img", "br", "link", "input", "hr"}
PICTURES = Pictures({"bar_upper": {"whole": b"\x89PNG one", "peak": b"\x89PNG two"}})


class Page(HTMLParser):
    """Tags with their attributes, the text of some, and whether each tag is closed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.open, self.words = [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


MAKERS = {"mixed": results.mixed, "hostile": results.hostile, "plain": results.design}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_the_page_is_well_formed_and_stands_alone(make):
    text = report_html(make(), PICTURES)
    page = Page(text)
    kinds = {tag for tag, _ in page.tags}
    assert not kinds & {"script", "link", "iframe", "object", "embed", "form", "base"}
    for _, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("href", "src", "xlink:href", "srcset"):
            assert re.match(r"#|data:image/png;base64,", attributes.get(name, "#"))
        assert "url(" not in re.sub(r"url\(#[\w-]+\)", "", attributes.get("style", ""))
    assert "@import" not in text


def test_the_policy_forbids_everything_but_inline_styles_and_data_images():
    page = Page(report_html(results.design()))
    policies = [a["content"] for tag, a in page.tags if a.get("http-equiv")]
    assert policies == [
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    ]


def test_hostile_names_are_shown_as_text():
    page = Page(report_html(results.hostile()))
    assert "<script>alert('x')</script>" in page.text
    assert "\x1b" not in page.text
    assert "\u202e" not in page.text
    # Only inputs, which must be complete to some length, hold long runs, and none is endless.
    assert max(map(len, page.text.split())) <= 2000


def test_the_page_is_the_same_each_time():
    assert report_html(results.mixed(), PICTURES) == report_html(results.mixed(), PICTURES)


def test_ids_occur_once():
    page = Page(report_html(results.mixed()))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert sorted(ids) == sorted(set(ids))


def test_tables_have_captions_and_scopes():
    page = Page(report_html(results.mixed()))
    kinds = [tag for tag, _ in page.tags]
    assert kinds.count("table") == kinds.count("caption") > 10
    assert all(a.get("scope") in ("row", "col") for tag, a in page.tags if tag == "th")


def test_the_verdict_comes_first_with_what_decides_it_and_why():
    text = Page(report_html(results.mixed())).text
    assert "FAIL (under 2 assumptions); decided by bar_upper fatigue, safety 0.833" in text
    order = ["decided by", "Warning", "Validity", "Not checked", "Assumed", "All checks",
             "Checks of bar_upper", "Cycles", "Given by the design file", "Not stated",
             "The design file", "This command makes it again", "Versions"]  # fmt: skip
    place = 0
    for words in order:
        assert words in text[place:], words
        place = text.index(words, place)


def test_everything_of_a_part_is_shown():
    text = Page(report_html(results.mixed(), PICTURES)).text
    for words in (
        "±∞ (singular)", "sharp inner corner", "yield strength, 95 % survive", "F / A", "1.05",
        "81 234", "138.2", "tube 80 x 80 x 6.3", "reaction residual", "◀\N{NO-BREAK SPACE}decides",
        "abababab", "ballesta check toggle_press.toml", 'accuracy = "5 %"', "solve",
    ):  # fmt: skip
        assert words.replace("\N{NO-BREAK SPACE}", " ") in text, words
    page = Page(report_html(results.mixed(), PICTURES))
    assert [a["alt"] for tag, a in page.tags if tag == "img"] == [
        "The whole part of bar_upper, coloured by stress",
        "Surroundings of the peak of bar_upper, coloured by stress",
    ]


def test_missing_pictures_are_explained_in_words():
    text = Page(
        report_html(results.design(), Pictures(reason="no GL: apt-get install libgl1"))
    ).text
    assert "no GL: apt-get install libgl1" in text


def test_broken_gates_come_before_the_checks_with_their_owner():
    broken = Gate("reaction residual", 0.5, 1e-6, "unbalanced share")
    text = Page(report_html(results.design(results.part(gates=[broken])))).text
    assert text.index("Gate broken bar_upper: reaction residual: 0.500 > 1e-06") < text.index(
        "All checks"
    )
    assert "Broken gates, 1 of 2" in text
    assert "All 2 gates hold" in Page(report_html(results.design())).text


def test_an_empty_design_has_a_page():
    empty = results.design(
        results.part(checks=[], gates=[], hand_checks=[], meshes=[], facts={}, charts={}),
        cycles={}, gates=[], warnings=[], not_checked=[], assumed=[], defaults=[], inputs=[],
        timings={}, versions={},
    )  # fmt: skip
    assert "UNDECIDED: nothing was checked" in Page(report_html(empty)).text


def test_the_file_holds_the_page_and_nothing_is_left_beside_it(tmp_path):
    path = tmp_path / "out" / "report.html"
    write_report(results.mixed(), PICTURES, path)
    assert path.read_text(encoding="utf-8") == report_html(results.mixed(), PICTURES)
    assert list(path.parent.iterdir()) == [path]


def test_facts_are_written_by_their_kind():
    assert value_text(81234) == "81 234"
    assert value_text(4.14134) == "4.141"
    assert value_text("12") == "12"
    assert value_text(True) == "yes"
    assert value_text(None) == "–"
    assert value_text({"knee": [1.5, 2.5]}) == "knee: 1.500, 2.500"


def test_a_hand_check_of_zero_has_no_ratio():
    assert ratio(HandCheck("moment", 0.0, 1.0, "N mm", "0")) == "–"
