"""The report as its readers meet it: in a browser, on a phone, on paper, by keyboard."""

import re
from dataclasses import replace

import pytest

from checks.result.derivation import Derivation, Given, LoadCase, Section, Step
from checks.result.verdict import Gate
from reports.page import write_report
from reports.pictures import Pictures

from . import motion_results, results
from .conftest import NO_GL, until
from .live import sections
from .live.conftest import settle

PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108060000001f15c4890000000d49444154789c6360"
    "60606000000005000101270b5f0000000049454e44ae426082"
)
STILLS = Pictures({name: {"whole": PIXEL, "peak": PIXEL} for name in ("bar_upper", "pin_B")})
A4, HIGH = 702, 1020  # px of its width and height within the margins


def derived():
    """A failing fatigue check with a derivation; its load case is the third position."""
    told = Derivation(
        cases=(LoadCase("s", "press", "x = 2 mm", 2, ()),),
        sections=(
            Section(
                "Demand", (Given("a", "amplitude", 180.0, "MPa"), Step("v", "demand", "a * 1"))
            ),
            Section("Limit", (Given("e", "endurance limit", 150.0, "MPa"),)),
        ),
        value="v",
        limit="e",
    )
    return replace(results.FAILING, derivation=told)


def failing():
    pin = results.part("pin_B", [results.check("pin_B", value=56.0, limit=650.0)], charts={})
    checks = [results.PASSING, results.UNDECIDED, derived()]
    broken = Gate("loads: gap", 2.0, 1.0, "the linkage does not close")
    return results.design(results.part(checks=checks), pin, gates=[broken])


def alike():
    facts = {"mass [kg]": 4.1, "inertia about the centre [kg m2]": 0.035}
    upper, lower = (
        results.part(
            name, [replace(c, part=name) for c in (results.PASSING, derived())], facts=facts
        )
        for name in ("bar_upper", "pin_B")
    )
    return results.design(upper, lower)


PAGES = {
    "alike": alike,
    "fail": failing,
    "undecided": lambda: results.design(results.part(checks=[results.UNDECIDED])),
    "pass": results.design,
    "hostile": results.hostile,
    "live": lambda: sections.design(motion={}),
    "moving": motion_results.press,
    "empty": lambda: results.design(
        results.part(checks=[], charts={}, gates=[]), cycles={}, gates=[]
    ),
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return what writes the page of a name, once."""
    folder = tmp_path_factory.mktemp("pages")

    def write(name):
        path = folder / f"{name}.html"
        if not path.exists():
            write_report(PAGES[name](), STILLS, path)
        return path

    return write


@pytest.fixture
def shown(opened, written):
    """Return what opens the page of a name and waits until it is ready."""

    def show(name, **context):
        result = opened(written(name), **context)
        if context.get("java_script_enabled", True):
            result.page.locator("html[data-live=ready]").wait_for(state="attached")
        return result

    return show


@pytest.mark.parametrize(
    ("name", "scheme"), [*((name, "light") for name in PAGES), ("live", "dark")]
)
def test_a_page_opens_without_a_word_on_the_console_and_asks_for_nothing(shown, name, scheme):
    found = shown(name, color_scheme=scheme)
    found.page.mouse.wheel(0, 4000)
    until(found.page, "scrollY > 0")
    settle(found.page)
    found.assert_quiet()
    kept = found.page.evaluate("[localStorage.length, sessionStorage.length, document.cookie]")
    assert kept == [0, 0, ""]
    ground = found.page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (ground == "rgb(255, 255, 255)") == (scheme == "light")


@pytest.mark.parametrize(
    ("name", "word"), [("fail", "FAIL"), ("undecided", "UNDECIDED"), ("pass", "PASS")]
)
def test_verdict_number_and_what_to_know_are_on_the_first_screen(shown, name, word):
    page = shown(name, width=1280, height=800).page
    assert page.title().startswith(f"{word}: ")
    assert page.locator("#verdict .badge").inner_text() == word
    for choice in (
        "#verdict .figure b", "#verdict .safety-scale", ".live-frame", ".tiles a >> nth=0",
        "#live-transport", *(f"#verdict dt >> nth={k}" for k in range(4)),
    ):  # fmt: skip
        box = page.locator(choice).bounding_box()
        assert box["y"] + box["height"] <= 800, choice


@pytest.mark.parametrize("name", PAGES)
def test_a_phone_never_scrolls_sideways(shown, name):
    found = shown(name, width=360, height=740)
    assert found.page.evaluate("document.documentElement.scrollWidth") == 360
    found.assert_quiet()


def test_on_a_phone_a_check_is_a_card_that_fits(shown):
    page = shown("fail", width=360, height=740).page
    for box in page.locator(".checks").all():
        assert box.evaluate("each => each.scrollWidth <= each.clientWidth")
    cell = page.locator("#check-3 td[data-label=utilisation]")
    assert cell.evaluate("each => getComputedStyle(each, '::before').content") == '"utilisation"'


CONTRAST = """() => {
  const parse = (text) => (text.match(/[\\d.]+/g) ?? []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const [r, g, b, alpha = 1] = parse(getComputedStyle(at).backgroundColor);
      if (alpha === 1) return [r, g, b];
    }
    return [255, 255, 255];
  };
  const weak = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let count = 0;
  while (walker.nextNode()) {
    const text = walker.currentNode, element = text.parentElement;
    if (!text.data.trim() || element.closest("svg, script, noscript, .skip")) continue;
    if (!element.checkVisibility()) continue;
    const style = getComputedStyle(element);
    const [a, b] = [light(parse(style.color)), light(ground(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    count += 1;
    if (ratio < 4.5) weak.add(`${element.tagName}.${element.className} ${ratio.toFixed(2)}`);
  }
  return [count, [...weak]];
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["fail", "live"])
def test_all_text_has_the_contrast_that_wcag_aa_asks_for(shown, name, scheme):
    """WCAG 2.2, 1.4.3: 4.5 to 1 for text of any size."""
    count, weak = shown(name, color_scheme=scheme).page.evaluate(CONTRAST)
    assert count > 150
    assert weak == []


@pytest.mark.parametrize(("name", "scheme"), [("alike", "light"), ("moving", "dark")])
def test_axe_finds_nothing_on_a_page_with_all_its_folds_open(shown, axe, name, scheme):
    page = shown(name, color_scheme=scheme, bypass_csp=True).page
    page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    assert axe(page) == []


def test_paper_has_all_parts_with_the_governing_derivation_and_no_controls(shown):
    page = shown("fail", width=A4).page
    assert not page.locator("#why-3 .derivation").evaluate("each => each.open")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    for choice in (
        "#part-1 h2", "#part-2 h2", "#why-3 .derivation table >> nth=0", "#inputs pre",
        "#inputs table >> nth=1", "#verdict .badge", ".notes li >> nth=0", "#command",
    ):  # fmt: skip
        assert page.locator(choice).is_visible(), choice
    for control in page.locator("nav, button, select, input").all():
        assert not control.is_visible(), control.evaluate("each => each.outerHTML")
    assert page.evaluate("document.documentElement.scrollWidth") <= A4
    wide = page.locator(".scroll").evaluate_all(
        "all => all.filter((each) => each.scrollWidth > each.clientWidth + 1)"
        ".map((each) => each.ariaLabel)"
    )
    assert wide == []
    assert page.locator("thead").first.evaluate("each => getComputedStyle(each).display") == (
        "table-header-group"
    )
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not page.locator("#why-3 .derivation").evaluate("each => each.open")


@pytest.mark.parametrize("name", ["fail", "moving"])
def test_the_first_sheet_alone_is_a_record(shown, name):
    """Picture, verdict, date, version, hash, assumptions and lines to sign, to the last one."""
    page = shown(name, width=A4).page
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    on_it = ["#verdict .badge", ".stands-on", ".record", ".signature"]
    on_it += [] if name == "fail" else [".stage .live-frame img[src]"]
    for choice in on_it:
        place = page.locator(choice).first.bounding_box()
        assert place["height"] > 0, choice
        assert place["y"] + place["height"] <= HIGH, choice
    assert "SHA-256" in page.locator(".record").inner_text()


def test_a_part_that_another_tells_as_well_prints_its_checks_alone(shown):
    page = shown("alike", width=A4).page
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    for part, visible in (("#part-1", True), ("#part-2", False)):
        assert page.locator(f"{part} .checks tr.has").count() == 2
        assert page.locator(f"{part} .checks tr.has >> nth=1").is_visible()
        for choice in (
            ".derivation table >> nth=0",
            ".chart >> nth=0",
            ".pictures",
            "tr.told >> nth=0",
        ):
            assert page.locator(f"{part} {choice}").is_visible() is visible, choice


def test_the_browser_prints_the_page(shown):
    found = shown("fail")
    made = found.page.pdf(format="A4", prefer_css_page_size=True)
    assert 3 <= len(re.findall(rb"/Type\s*/Page\b", made)) <= 40
    found.assert_quiet()


FOCUSABLE = """() => [...document.querySelectorAll(
  "a[href], button, input, select, textarea, summary, [tabindex='0']")]
  .filter((each) => each.checkVisibility() && !each.disabled && each.tabIndex >= 0).length"""
FOCUSED = """() => {
  const at = document.activeElement, style = getComputedStyle(at);
  const first = !at.dataset.seen;
  at.dataset.seen = "yes";
  const outlined = style.outlineStyle !== "none" && style.outlineWidth !== "0px";
  return [at === document.body, first, outlined, `${at.tagName}.${at.className}`];
}"""


@pytest.mark.parametrize("name", ["fail", "live"])
def test_the_keyboard_reaches_everything_and_shows_where_it_is(shown, name):
    page = shown(name).page
    wanted = page.evaluate(FOCUSABLE)
    assert wanted > 30
    seen, dim = 0, set()
    for _ in range(wanted + 5):
        page.keyboard.press("Tab")
        outside, first, outlined, told = page.evaluate(FOCUSED)
        if outside or not first:
            break
        seen += 1
        if not outlined:
            dim.add(told)
    assert seen == wanted
    assert dim == set()


def test_the_first_key_offers_to_skip_to_the_verdict(shown):
    page = shown("pass").page
    page.keyboard.press("Tab")
    box = page.locator(".skip").bounding_box()
    assert box["y"] >= 0
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id") == "main"


def test_without_scripts_everything_is_there_to_be_read(shown):
    found = shown("fail", java_script_enabled=False)
    text = found.page.locator("body").inner_text()
    for words in (
        "Know this", "Scripts are switched off", "Warning", "even at the lower end",
        "All checks", "1.3 required", "By hand", "This command makes it again",
    ):  # fmt: skip
        assert words.lower() in text.lower(), words
    assert found.page.locator("#part-1 img").first.is_visible()
    assert not found.page.locator("#copy").is_visible()
    found.page.locator("#why-3 summary").first.click()
    assert found.page.locator("#why-3 table").first.is_visible()


def test_hostile_names_run_nothing_and_stay_text(shown):
    found = shown("hostile")
    tags = found.page.evaluate(
        "[...document.querySelectorAll('script')].filter(s => !s.type).length"
    )
    assert tags == 1
    assert "<script>alert('x')</script>" in found.page.locator("#verdict").inner_text()
    found.page.locator("summary").evaluate_all(
        "all => all.forEach((each) => each.parentElement.open = true)"
    )
    assert found.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    found.assert_quiet()


def test_a_number_opens_to_how_it_comes_about(shown):
    page = shown("fail").page
    page.locator("#checks a.value").first.click()
    assert page.locator("#why-3 .derivation").evaluate("each => each.open")
    assert page.locator("#why-3 table").first.is_visible()


def test_a_link_shows_the_deciding_position_and_its_part(shown):
    page = shown("fail").page
    page.locator("#verdict a[data-show]").click()
    assert page.evaluate("[ballesta.current.cycle, ballesta.current.index]") == [0, 2]
    page = shown("live").page
    page.locator("#part-2 a[data-show]").first.click()
    page.locator("#live-tab-1[aria-selected=true]").wait_for()
    assert page.evaluate("ballesta.current.part") == "shaft"


def test_the_command_can_be_copied(shown):
    page = shown("pass").page
    page.locator("#copy").click()
    page.locator("#copy", has_text=re.compile("Copied|Selected")).wait_for()
    assert page.evaluate("getSelection().toString().trim()") == "ballesta check toggle_press.toml"


def test_the_bar_tells_which_section_is_read(shown):
    page = shown("fail").page
    current = page.locator(".contents a[aria-current]")
    assert current.get_attribute("href") == "#main"
    page.locator("#part-2").scroll_into_view_if_needed()
    page.evaluate("document.getElementById('part-2').scrollIntoView()")
    page.locator(".contents a[aria-current][href='#part-2']").wait_for()
    assert page.locator(".contents").bounding_box()["y"] == 0


def test_only_tables_that_must_be_scrolled_are_stops_of_the_keyboard(shown):
    stops = "[...document.querySelectorAll('.checks')].map((each) => each.tabIndex)"
    page = shown("fail", width=1300).page
    page.locator(".checks[tabindex='-1']").first.wait_for()
    assert set(page.evaluate(stops)) == {-1}
    page = shown("fail", width=360).page
    hand = page.locator("#part-1 [aria-label='Hand calculations'][tabindex='0']")
    hand.wait_for()
    assert hand.evaluate("each => each.scrollWidth > each.clientWidth")


def test_without_webgl_a_still_stands_with_each_part_and_the_position_moves(opened, written):
    found = opened(written("fail"), flags=NO_GL)
    page = found.page
    page.locator("html[data-live=failed]").wait_for(state="attached")
    assert "WebGL2" in page.locator("[data-role=note]").inner_text()
    for part in ("#part-1", "#part-2"):
        assert page.locator(f"{part} .pictures img").count() == 2
    images = page.locator("img[src^='data:']").evaluate_all("all => all.length")
    assert images == 4  # none of them twice
    page.evaluate("ballesta.setPosition(0, 7)")
    assert page.evaluate("ballesta.current.index") == 7
    found.assert_quiet()
