"""The live view where something is different: paper, dark, narrow, no WebGL, strange names."""

import re
from base64 import b64encode
from dataclasses import replace
from gzip import compress
from io import BytesIO

import numpy as np
import pytest
from markupsafe import Markup
from PIL import Image

from reports.templating import packed_json

from .. import results
from ..conftest import NO_GL, until
from . import sections
from .conftest import pixels, role, settle

LONG = "a" * 10_000


def written_as(tmp_path, result, **section):
    path = tmp_path / "live.html"
    path.write_text(sections.page(result, **section), encoding="utf-8")
    return path


def test_without_webgl_words_stay_and_the_position_still_moves(viewed):
    found = viewed(state="failed", flags=NO_GL)
    page = found.page
    note = role(page, "note").inner_text()
    assert "3-D picture is missing" in note
    assert "WebGL2" in note
    assert "slider and charts work" in note  # this page has no mechanism
    assert page.locator(".live-lead").is_hidden()
    assert role(page, "canvas").is_hidden()
    slider = role(page, "slider")
    slider.focus()
    before = page.evaluate("ballesta.current.index")
    page.keyboard.press("ArrowLeft" if before else "ArrowRight")
    assert page.evaluate("ballesta.current.index") != before
    assert found.asked == [page.url, *(url for url in found.asked if url.startswith("data:"))]


def test_without_scripts_the_numbers_are_there(opened, written):
    page = opened(written, java_script_enabled=False).page
    assert page.locator(".live-transport").is_hidden()
    assert page.locator("noscript p").is_visible()
    assert page.locator(".live-lead").is_hidden()
    page.locator(".live-tables summary").click()
    rows = page.locator(".live-tables table").first.locator("tbody tr")
    assert rows.count() >= 8


def test_a_lost_context_is_told_and_comes_back(viewed):
    page = viewed().page
    before = pixels(page)
    page.evaluate("window.loss = ballesta.live.context().getExtension('WEBGL_lose_context')")
    page.evaluate("loss.loseContext()")
    page.locator("html[data-live=lost]").wait_for(state="attached")
    assert "graphics" in role(page, "note").inner_text()
    page.evaluate("ballesta.setPosition(0, 7); ballesta.setPosition(0, 0)")
    page.locator("#live-tab-1").click()  # a part that is opened meanwhile
    page.locator("#live-tab-0").click()
    settle(page)
    page.evaluate("loss.restoreContext()")
    page.locator("html[data-live=ready]").wait_for(state="attached")
    assert role(page, "note").is_hidden()
    assert (np.abs(pixels(page) - before).max(axis=2) > 30).mean() < 0.05
    page.locator("#live-tab-1").click()
    settle(page)
    assert (np.ptp(pixels(page), axis=2) > 60).mean() > 0.03


def test_dark_mode_changes_the_ground_and_keeps_the_colours(viewed):
    page = viewed().page
    light = pixels(page)
    page.emulate_media(color_scheme="dark")
    dark = pixels(page)
    assert light[200, 30].min() > 200
    assert dark[200, 30].max() < 60
    assert (np.ptp(dark, axis=2) > 60).mean() > 0.05


def test_paper_gets_the_picture_of_the_moment_in_the_colours_of_paper(viewed):
    found = viewed(color_scheme="dark")
    page = found.page
    page.evaluate("ballesta.setPosition(0, 15)")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    source = role(page, "printed").get_attribute("src")
    assert source.startswith("data:image/png;base64,")
    assert "peak" in role(page, "printed").get_attribute("alt")
    page.emulate_media(media="print")
    assert role(page, "printed").is_visible()
    assert role(page, "canvas").is_hidden()
    assert page.locator(".live-transport").is_hidden()
    shot = page.locator(".live-frame").screenshot()
    paper = np.asarray(Image.open(BytesIO(shot)).convert("RGB")).astype(int)
    assert paper[150, 30].min() > 240
    assert (np.ptp(paper, axis=2) > 60).mean() > 0.05
    page.emulate_media(media="screen")
    assert len(page.pdf()) > 20_000
    found.assert_quiet()


def test_a_phone_shows_it_without_scrolling_sideways(viewed):
    page = viewed(width=360, height=700, has_touch=True).page
    for tab in page.get_by_role("tab").all():
        tab.click()
        settle(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
    page.locator("#live-tab-0").click()
    role(page, "deformed").check()
    page.locator(".live-tables summary").click()
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    for control in page.locator("#live :is(button, select, input):visible").all():
        box = control.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 360 or control.get_attribute("role") == "tab"


def test_two_fingers_zoom_about_their_middle_and_move(viewed):
    page = viewed(width=360, height=700, has_touch=True).page
    box = role(page, "canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = page.context.new_cdp_session(page)

    def fingers(kind, *places):
        points = [{"x": a, "y": b, "id": k} for k, (a, b) in enumerate(places)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def seen():
        settle(page)
        scale = page.evaluate("ballesta.live.camera.scale")
        return scale, np.reshape(page.evaluate("[...ballesta.live.camera.pixels()]"), (3, 4))

    (scale, rows), turn = seen(), page.evaluate("ballesta.live.camera.turn")
    fingers("touchStart", (x - 30, y), (x + 30, y))
    for spread in (36, 48, 60):
        fingers("touchMove", (x - spread, y), (x + spread, y))
    wider, _ = seen()
    assert wider == pytest.approx(2 * scale, rel=0.02)
    fingers("touchMove", (x - 60, y + 25), (x + 60, y + 25))
    again, moved = seen()
    fingers("touchEnd")
    assert again == pytest.approx(wider, rel=0.02)
    middle = np.array([x - box["x"], y - box["y"]])
    start = middle + 2 * (rows[:2, 3] - middle)  # where the part's origin is after the zoom
    np.testing.assert_allclose(moved[:2, 3] - start, [0, 25], atol=2)
    assert page.evaluate("ballesta.live.camera.turn") == turn
    assert page.evaluate("scrollY") == 0


def test_the_mechanism_stands_beside_the_readings_and_on_a_phone_below_them(tmp_path, viewed):
    figure = Markup('<figure style="margin:0"><svg viewBox="0 0 4 3"></svg></figure>')
    path = written_as(tmp_path, sections.design(), mechanism=figure)
    page = viewed(path, width=1280).page
    places = {
        "picture": ".live-frame", "slider": ".live-transport", "readings": ".live-readings",
        "mechanism": ".live-mechanism svg",
    }  # fmt: skip

    def boxes():
        return {name: page.locator(selector).bounding_box() for name, selector in places.items()}

    wide = boxes()
    assert wide["mechanism"]["x"] > wide["readings"]["x"] + wide["readings"]["width"]
    assert wide["picture"]["y"] < wide["slider"]["y"] < wide["mechanism"]["y"]
    page.set_viewport_size({"width": 360, "height": 700})
    narrow = boxes()
    order = sorted(narrow, key=lambda name: narrow[name]["y"])
    assert order == ["picture", "slider", "readings", "mechanism"]


def test_the_whole_linkage_shows_the_mechanisms_cylinders_where_they_are(tmp_path, viewed):
    """A line of the mechanism's picture, y down, 7 mm below the machine's x axis."""
    line = '<line class="rod" x1="-1000" y1="7" x2="1000" y2="7"/>'
    svg = f'<svg class="mechanism" viewBox="-50 -50 100 100">{line}</svg>'
    figure = Markup(f'<figure id="mechanism">{svg}</figure>')
    page = viewed(written_as(tmp_path, sections.design(), mechanism=figure)).page
    page.locator("#live-tab-linkage").click()
    settle(page)
    rows = np.reshape(page.evaluate("[...ballesta.live.camera.pixels()]"), (3, 4))
    x = np.linspace(-1000.0, 1000.0, 401)
    spots = (rows @ np.stack([x, 0 * x - 7, 0 * x, 0 * x + 1]))[:2].T.tolist()
    covered = """(spots) => {
      ballesta.live.draw();
      const canvas = document.querySelector("[data-role=canvas]");
      const context = canvas.getContext("2d"), ratio = canvas.width / canvas.clientWidth;
      return spots.filter(([x, y]) => x > 0 && y > 0 && x < canvas.clientWidth &&
        y < canvas.clientHeight)
        .map(([x, y]) => context.getImageData(ratio * x, ratio * y, 1, 1).data[3] > 60);
    }"""
    there = page.evaluate(covered, spots)
    assert len(there) > 5
    assert all(there)
    page.evaluate("document.querySelector('#mechanism svg').classList.add('still')")  # no motion
    assert sum(page.evaluate(covered, spots)) < 0.5 * len(there)


def test_the_slider_stays_in_sight_while_the_tables_are_read(viewed):
    for width in (900, 1280):
        page = viewed(width=width, height=700).page
        page.locator(".live-tables summary").click()
        page.locator(".live-tables").evaluate("e => scrollTo(0, e.getBoundingClientRect().top)")
        settle(page)
        box = page.locator(".live-transport").bounding_box()
        assert 0 < box["y"] < 100


def test_names_from_a_stranger_are_only_words(tmp_path, viewed):
    hostile = results.HOSTILE
    made = sections.design()
    names = {"ring": f"</script>{hostile}", "shaft": LONG, "plate": "<img src=x onerror=alert(1)>"}
    cycles = {
        f"{name} {hostile}": {
            **cycle, "shown_name": hostile, "unit": f"<b>{LONG}",
            "phase": [hostile] * len(cycle["phase"]),
            "peaks": {names[part]: values for part, values in cycle["peaks"].items()},
        }
        for name, cycle in made.cycles.items()
    }  # fmt: skip
    parts = []
    for part in made.parts:
        fields = replace(
            part.live,
            notes=(hostile, LONG),
            missing={field: f"{hostile} {why}" for field, why in part.live.missing.items()},
            coefficients={f"{n} {hostile}": c for n, c in part.live.coefficients.items()},
            peaks={f"{n} {hostile}": p for n, p in part.live.peaks.items()},
            peak=part.live.peak and replace(
                part.live.peak, cycle=f"{part.live.peak.cycle} {hostile}", place=hostile
            ),
        )  # fmt: skip
        check = replace(part.checks[0], part=names[part.name])
        parts.append(replace(part, name=names[part.name], live=fields, checks=[check]))
    moved = sections.motion(list(names.values()))
    moved.layers_told = hostile
    result = replace(made, parts=parts, cycles=cycles, motion={f"turn {hostile}": moved})
    found = viewed(written_as(tmp_path, result), width=700)
    page = found.page
    page.on("dialog", lambda dialog: found.told.append(dialog.message))
    for tab in page.get_by_role("tab").all():
        tab.click()
        settle(page)
    role(page, "hottest").locator("summary").click()
    page.locator(".live-tables summary").click()
    assert page.locator("#live :is(b b, img:not([src^=data]):not([data-role]))").count() == 0
    assert page.locator("#live script").count() == page.locator(
        "#live script[type='application/json'], #live script[type='text/plain']"
    ).count()  # fmt: skip
    assert page.evaluate("document.documentElement.scrollWidth") <= 700
    assert page.evaluate("ballesta.current.cycleName").startswith("turn <script>")
    found.assert_quiet()


def test_with_reduced_motion_play_is_a_step_and_nothing_runs(viewed):
    page = viewed(reduced_motion="reduce").page
    page.evaluate("ballesta.setPosition(0, 0)")
    play = role(page, "play")
    assert play.inner_text() == "Step"
    play.click()
    assert page.evaluate("[ballesta.current.index, ballesta.current.playing]") == [3, False]
    page.wait_for_timeout(150)
    assert page.evaluate("ballesta.current.index") == 3
    assert role(page, "pace").is_hidden()


def buckling(tmp_path):
    """The page of the small design whose ring buckles in a bow along its axis."""
    result = sections.design()
    ring = result.parts[0]
    bow = np.cos(np.pi * ring.live.nodes[:, 2] / 40.0)[:, None] * [1.0, 0.0, 0.0]
    parts = [replace(ring, live=replace(ring.live, mode=bow)), *result.parts[1:]]
    path = tmp_path / "buckling.html"
    path.write_text(sections.page(replace(result, parts=parts)), encoding="utf-8")
    return path


def test_a_buckling_mode_swings_for_a_while_and_as_long_as_the_cycle_plays(viewed, tmp_path):
    page = viewed(buckling(tmp_path)).page
    straight = pixels(page)
    box = role(page, "mode")
    assert not page.evaluate("ballesta.live.buckled")
    box.check()
    assert page.evaluate("ballesta.live.buckled")
    assert role(page, "factor-box").is_hidden()
    shapes = [pixels(page) for _ in range(3)]
    assert any((shapes[0] != each).any() for each in shapes[1:])  # it moves
    printed = []
    for _ in range(2):  # on paper at its largest, whenever that is
        page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        printed.append(role(page, "printed").get_attribute("src"))
        page.wait_for_timeout(300)
    assert printed[0] == printed[1]
    page.wait_for_timeout(4200)
    rest = pixels(page)
    assert (pixels(page) == rest).all()  # no longer than five seconds by itself (WCAG 2.2.2)
    assert (np.abs(rest - straight).max(axis=2) > 30).mean() > 0.01
    role(page, "play").click()
    assert any((pixels(page) != rest).any() for _ in range(3))
    role(page, "play").click()
    box.uncheck()
    page.evaluate("ballesta.setPosition(0, 0)")
    page.locator("[data-part='1']").click()
    settle(page)
    assert role(page, "mode-box").is_hidden()  # the shaft has none


def test_with_reduced_motion_a_buckling_mode_stands_still_at_its_largest(viewed, tmp_path):
    page = viewed(buckling(tmp_path), reduced_motion="reduce").page
    straight = pixels(page)
    role(page, "mode").check()
    shapes = [pixels(page) for _ in range(3)]
    assert all((shapes[0] == each).all() for each in shapes[1:])
    assert (np.abs(shapes[0] - straight).max(axis=2) > 30).mean() > 0.01


def test_space_plays_and_pauses_and_the_cycle_comes_round(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 71)")
    role(page, "pace").select_option("4")
    role(page, "canvas").focus()
    page.keyboard.press(" ")
    assert page.evaluate("ballesta.current.playing")
    assert role(page, "play").inner_text() == "Pause"
    until(page, "ballesta.current.index < 60")  # past the end, it began again
    page.keyboard.press(" ")
    index = page.evaluate("ballesta.current.index")
    assert index == int(index)
    assert index < 71
    page.wait_for_timeout(100)
    assert page.evaluate("[ballesta.current.index, ballesta.current.playing]") == [index, False]


def test_another_cycle_keeps_the_share_that_was_gone(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 36)")
    role(page, "cycle").select_option(label="hold")
    assert page.evaluate("[ballesta.current.cycle, ballesta.current.index]") == [1, 12]
    assert role(page, "slider").get_attribute("max") == "24"


def test_a_page_whose_parts_have_no_stress_still_follows_the_position(tmp_path, viewed):
    made = sections.design()
    bare = [replace(p, live=None) for p in made.parts]
    page = viewed(written_as(tmp_path, replace(made, parts=bare, motion={}))).page
    assert page.evaluate("ballesta.live.peak") is None
    assert role(page, "field").is_disabled()
    assert "not kept" in role(page, "told").inner_text()
    page.evaluate("ballesta.setPosition(0, 9)")
    assert "45 deg" in role(page, "reading").inner_text()


BROKEN = {
    "no base64": "no base64!",
    "no gzip": "AAAA",
    "cut off": packed_json(list(range(1000)))[:400],
    "no JSON": b64encode(compress(b"[1, 2")).decode(),
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_damaged_motion_is_told_and_everything_else_works(tmp_path, viewed, how):
    text = sections.page(sections.design())
    text, count = re.subn(r'(id="live-motion">)[^<]*', rf"\g<1>{BROKEN[how]}", text)
    assert count == 1
    path = tmp_path / "broken.html"
    path.write_text(text, encoding="utf-8")
    found = viewed(path)
    page = found.page
    why = "the motion in this page is damaged"
    role(page, "told").get_by_text(f"No motion and no forces are shown: {why}").wait_for()
    assert role(page, "note").is_hidden()
    assert role(page, "forces-box").is_hidden()
    assert (np.ptp(pixels(page), axis=2) > 60).mean() > 0.05
    before = page.evaluate("ballesta.setPosition(0, 3); ballesta.live.peak.value")
    page.evaluate("ballesta.setPosition(0, 30)")
    assert page.evaluate("ballesta.live.peak.value") != before
    role(page, "field").select_option("principal")
    assert page.evaluate("ballesta.live.field") == "principal"
    page.locator("#live-tab-linkage").click()
    settle(page)
    assert why in role(page, "empty").inner_text()
    assert page.evaluate("ballesta.live.peak") is None
    page.locator("#live-tab-1").click()
    settle(page)
    assert role(page, "empty").is_hidden()
    assert page.evaluate("ballesta.live.peak.part") == 1
    found.assert_quiet()


def test_a_sheet_is_seen_from_both_sides(tmp_path, viewed):
    flat = sections.part("sheet", sections.live(*sections.sheet(), hot=[0.0, 0.0, 0.0]))
    made = replace(sections.design(), motion={})
    peaks = {name: {"sheet": flat.live.peaks[name].tolist()} for name in made.cycles}
    cycles = {name: {**cycle, "peaks": peaks[name]} for name, cycle in made.cycles.items()}
    page = viewed(written_as(tmp_path, replace(made, parts=[flat], cycles=cycles))).page
    for turn in ([1, 0, 0, 0], [0, 0, 1, 0]):  # from before and from behind
        page.evaluate("(turn) => { ballesta.live.camera.turn = turn; ballesta.live.draw(); }", turn)
        assert (np.ptp(pixels(page), axis=2) > 60).mean() > 0.1


@pytest.mark.parametrize("empty", ["parts", "cycles"])
def test_a_page_without_parts_or_cycles_says_so_and_breaks_nothing(tmp_path, viewed, empty):
    made = replace(sections.design(), motion={})
    if empty == "parts":
        result = replace(made, parts=[])
    else:
        parts = [
            replace(p, live=replace(p.live, coefficients={}, peaks={}, peak=None))
            for p in made.parts
        ]
        result = replace(made, parts=parts, cycles={})
    found = viewed(written_as(tmp_path, result))
    if empty == "parts":
        assert "Nothing can be drawn" in role(found.page, "note").inner_text()
    else:
        assert found.page.locator(".live-transport").is_hidden()
        role(found.page, "field").select_option("utilisation")
        assert found.page.evaluate("ballesta.live.peak.value") == pytest.approx(0.9, abs=0.05)
    found.assert_quiet()


def test_positions_are_refused_in_words_and_told_at_once(viewed):
    page = viewed().page
    assert page.evaluate(
        "(() => { const seen = []; const stop = ballesta.onPosition((p) => seen.push(p.index));"
        " ballesta.setPosition(0, 5.5); stop(); ballesta.setPosition(0, 1);"
        " ballesta.setPosition(0, 1e9); return [seen.slice(1), ballesta.current.index]; })()"
    ) == [[5.5], 72]
    for wrong in ("7, 0", "0, NaN", "'x', 1"):
        with pytest.raises(Exception, match="RangeError"):
            page.evaluate(f"ballesta.setPosition({wrong})")
