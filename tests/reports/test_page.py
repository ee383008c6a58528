import re
import subprocess
import sys
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from importlib.resources import files
from itertools import pairwise

import pytest

from checks.result.derivation import HandComparison
from checks.result.verdict import Gate
from reports.page import report_html, write_report
from reports.page_parts import alike_parts, ratio
from reports.pictures import Pictures
from reports.templating import SCRIPTS, script_text, value_text

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


def parsed(result, pictures=None):
    return Page(report_html(result, pictures))


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_the_page_is_well_formed_and_stands_alone(make):
    text = report_html(make(), PICTURES)
    page = Page(text)
    kinds = {tag for tag, _ in page.tags}
    assert not kinds & {"link", "iframe", "object", "embed", "form", "base"}
    for tag, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on")]
        assert tag != "script" or "src" not in attributes
        for name in ("href", "src", "xlink:href", "srcset"):
            assert re.match(r"#|data:image/png;base64,", attributes.get(name, "#"))
        assert "url(" not in re.sub(r"url\(#[\w-]+\)", "", attributes.get("style", ""))
    assert "@import" not in text


def test_the_policy_lets_only_the_page_s_one_script_run():
    text = report_html(results.mixed())
    policies = [a["content"] for tag, a in Page(text).tags if a.get("http-equiv")]
    (script,) = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert policies == [
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    ]
    data = [a.get("type") for tag, a in Page(text).tags if tag == "script"]
    assert data.count(None) == 1
    assert set(data) <= {None, "application/json", "text/plain"}


def test_the_script_is_its_files_one_after_the_other_and_runs_nothing_that_it_is_given():
    script = script_text()
    places = [script.index(files("reports").joinpath(name).read_text().strip()) for name in SCRIPTS]
    assert places == sorted(places)
    assert not re.search(
        r"innerHTML|outerHTML|insertAdjacent|document\.write|\beval\b|Function\(", script
    )
    assert not re.search(r"https?://(?!www\.w3\.org/)", script)


def test_hostile_names_are_shown_as_text():
    shown = re.sub(r"<script.*?</script>", "", report_html(results.hostile()), flags=re.DOTALL)
    page = Page(shown)
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
    text = parsed(results.mixed()).text
    order = [
        "FAIL", "of 5 checks 1 fails, 2 open, 2 pass", "0.833 safety factor, 1.3 required",
        "Decided by fatigue of bar_upper", "Where", "When press", "Why the limit is exceeded",
        "To pass its value must be", "ballesta improve toggle_press.toml", "Validity all 3",
        "Assumed 2 assumptions", "Live view", "Know this",
        "Warning", "All 3 validity checks hold", "Not checked", "Assumed by ballesta",
        "All checks, worst first", "Checks of bar_upper", "By hand", "Checks of pin_B",
        "Cycles", "Stated by the design file", "Set on the command line", "Not stated",
        "The design file", "This command makes it again", "Versions",
    ]  # fmt: skip
    place = 0
    for words in order:
        assert words in text[place:], words
        place = text.index(words, place)


def test_headings_go_down_one_step_at_a_time_from_a_single_one():
    levels = [
        int(tag[1]) for tag, _ in parsed(results.mixed(), PICTURES).tags if re.match("h[1-6]", tag)
    ]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(b <= a + 1 for a, b in pairwise(levels))


def test_links_lead_to_places_of_the_page():
    for result in (results.mixed(), results.hostile()):
        page = parsed(result)
        ids = {attributes.get("id") for _, attributes in page.tags}
        links = {a["href"] for tag, a in page.tags if tag == "a"}
        assert {link[1:] for link in links} <= ids
        assert len(links) > 10


def test_checks_stand_worst_first_with_the_governing_one_marked():
    page = report_html(results.mixed())
    table = page[page.index('<section id="checks">') : page.index('<section id="part-1"')]
    names = re.findall(r'<th role="rowheader".*?<a href="#check-(\d)">(.*?)</a>', table, re.DOTALL)
    assert [name for _, name in names] == [
        "bar_upper fatigue", "bar_upper static (von Mises stress)", "pin_B edge",
        "bar_upper static (von Mises stress)", "pin_B static",
    ]  # fmt: skip
    assert [number for number, _ in names] == ["3", "2", "5", "1", "4"]
    assert Page(table).text.count("decides") == 1


def test_everything_of_a_part_is_shown():
    text = parsed(results.mixed(), PICTURES).text
    for words in (
        "±∞ (singular) numerical", "sharp inner corner", "yield strength, 95 % survive", "F / A",
        "1.05", "81 234", "138.2", "tube 80 x 80 x 6.3", "reaction residual", "◀ decides",
        "abababab", "ballesta check toggle_press.toml", 'accuracy = "5 %"', "solve",
    ):  # fmt: skip
        assert words in text.replace("\N{NO-BREAK SPACE}", " "), words
    page = parsed(results.mixed(), PICTURES)
    assert [a["alt"] for tag, a in page.tags if tag == "img" and "src" in a] == [
        "The whole part of bar_upper, coloured by stress",
        "Surroundings of the peak of bar_upper, coloured by stress",
    ]


def test_inputs_of_the_file_those_of_the_command_line_and_defaults_are_kept_apart():
    result = results.design(overrides=["parts.bar_upper.wall=6.3 mm", "pace=x"])
    text = report_html(result)
    tables = {}
    for name in ("Stated by the design file", "Set on the command line", "Not stated, taken"):
        part = text[text.index(f"<summary>{name}") :]
        tables[name] = Page(part[: part.index("</details>") + 10].replace("</details>", "")).text
    assert "Toggle press" in tables["Stated by the design file"]
    assert "bar_upper" not in tables["Stated by the design file"]
    assert "parts.bar_upper.wall 6.3 mm" in tables["Set on the command line"]
    assert "pace=x" in tables["Set on the command line"]
    assert "gravity" in tables["Not stated, taken"]


def test_assumptions_of_the_design_and_of_the_tool_are_kept_apart():
    result = results.design(assumed_by_design=["cycles.press.stop"])
    text = parsed(result).text
    design, tool = text.index("Assumed by the design file"), text.index("Assumed by ballesta")
    assert design < text.index("nothing mechanical ends the stroke") < tool
    assert tool < text.index("bearing arc 120 deg", tool) < text.index("All checks")


def test_gates_of_a_kind_are_told_as_one_with_the_worst():
    gates = [Gate(f"{name}: uneven", value, 0.1, f"of {name}")
             for name, value in (("slow", 0.5), ("fast", 7.0), ("even", 0.05))]  # fmt: skip
    text = parsed(results.design(gates=gates)).text
    assert "NOT VALID uneven: slow 0.500, fast 7.00, limit 0.100 The worst, fast: of fast" in text


def test_gates_that_the_verdict_depends_on_come_before_those_that_it_does_not():
    gates = [Gate("slow", 2.0, 1.0, "late", binding=False), Gate("gap", 2.0, 1.0, "open")]
    text = parsed(results.design(gates=gates)).text.partition("Know this NOT VALID")[2]
    first = text.index("gap")
    assert first < text.index("Does not hold slow") < text.index("Warning", first)


def test_missing_pictures_are_explained_in_words():
    text = Page(
        report_html(results.design(), Pictures(reason="no GL: apt-get install libgl1"))
    ).text
    assert "no GL: apt-get install libgl1" in text


def test_broken_gates_come_before_the_checks_with_their_owner():
    broken = Gate("reaction residual", 0.5, 1e-6, "unbalanced share")
    text = Page(report_html(results.design(results.part(gates=[broken])))).text
    assert text.index("NOT VALID bar_upper: reaction residual: 0.500 > 1e-06") < text.index(
        "All checks"
    )
    assert "NOT VALID" in text
    assert "All 2 validity checks hold" in parsed(results.design()).text


def test_an_empty_design_has_a_page():
    empty = results.design(
        results.part(checks=[], gates=[], hand_checks=[], meshes=[], facts={}, charts={}),
        cycles={}, gates=[], warnings=[], not_checked=[], assumed=[], defaults=[], inputs=[],
        timings={}, versions={},
    )  # fmt: skip
    assert "UNDECIDED nothing was checked" in Page(report_html(empty)).text


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
    assert ratio(HandComparison("moment", 0.0, 1.0, "N mm", "0")) == "–"


OUTCOMES = {
    "all 2 checks pass": [results.PASSING] * 2,
    "the one check passes": [results.PASSING],
    "of 2 checks 1 open, 1 passes": [results.PASSING, results.UNDECIDED],
    "of 2 checks 2 fail": [results.FAILING] * 2,
    "of 3 checks 1 fails, 1 open, 1 passes": [
        results.PASSING, results.UNDECIDED, results.FAILING],
}  # fmt: skip


@pytest.mark.parametrize(("words", "checks"), OUTCOMES.items(), ids=range(len(OUTCOMES)))
def test_the_card_says_how_many_checks_stand_how(words, checks):
    result = results.design(results.part(checks=[replace(check) for check in checks]))
    assert words in parsed(result).text


def test_a_page_can_be_written_without_any_solver():
    """What an unchanged design needs is imported late, and no solver or mesher ever."""
    code = (
        "import sys; import reports.page; found = set(sys.modules) & "
        "{'scipy', 'gmsh', 'skfem', 'pyvista', 'matplotlib'}; sys.exit(', '.join(found) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def twins(value=180.0, **changes):
    """Two bars of one shape, the second with other numbers, and what changes on it."""
    own = {"facts": {"mass [kg]": 4.1, "inertia about the centre [kg m2]": 0.035}}
    upper, lower = (
        results.part(name, [replace(c, part=name) for c in (results.PASSING, fatigue)], **more)
        for name, fatigue, more in (
            ("bar_upper", results.FAILING, own),
            ("bar_lower", replace(results.FAILING, value=value), own | changes),
        )
    )
    return upper, lower


def test_a_part_that_a_worse_one_tells_as_well_names_it_and_how_far_its_numbers_differ():
    upper, lower = twins(value=179.1)
    told = {"bar_lower": "As bar_upper: the same shape, material and limits, values within 0.50 %"}
    assert alike_parts([lower, upper]) == told
    assert alike_parts(twins()) == {"bar_lower": told["bar_lower"].split("within")[0] + "equal"}
    page = report_html(results.design(lower, upper))
    assert page.count('class="part alike"') == 1
    assert told["bar_lower"] in page


@pytest.mark.parametrize(
    "pair",
    [
        twins(value=178.0),
        twins(material="S275"),
        twins(facts={"mass [kg]": 4.2, "inertia about the centre [kg m2]": 0.035}),
        twins(facts={}),
    ],
)
def test_parts_that_differ_by_more_than_a_percent_or_in_their_form_are_told_one_by_one(pair):
    assert alike_parts(pair) == {}
