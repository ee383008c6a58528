"""The live view as a reader uses it: parts, positions, fields, colours, turning."""

import re
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from checks.result.live_fields import von_mises
from reports.live.section import live_payload
from reports.plain_still import colour_maps, use_colours

from . import sections
from .conftest import pixels, role, settle

PEAK = "ballesta.live.peak.value"


def test_it_is_ready_from_a_file_without_a_network_or_a_word_on_the_console(viewed):
    found = viewed()
    assert role(found.page, "canvas").is_visible()
    assert role(found.page, "note").is_hidden()
    found.assert_quiet()


def test_the_picture_is_coloured_by_stress(viewed):
    shown = pixels(viewed().page)
    spread = shown.max(axis=2) - shown.min(axis=2)
    assert (spread > 60).mean() > 0.05


@pytest.mark.parametrize(("index", "part"), [(0, "ring"), (1, "shaft")])
def test_the_peak_is_the_solvers_at_every_third_position(viewed, index, part):
    """0.2 % of the cycle's peak: 0.1 % that the encoder may be off, and room for float32."""
    page = viewed().page
    page.locator(f"#live-tab-{index}").click()
    settle(page)
    live = next(p for p in sections.design().parts if p.name == part).live
    for number, cycle in enumerate(sections.CYCLES):
        columns = live.coefficients[cycle].shape[1]
        asked = list(range(0, columns, 3 if columns > 30 else 1))
        assert len(asked) >= 24
        shown = page.evaluate(
            "([cycle, asked]) => asked.map((index) => {"
            "  ballesta.setPosition(cycle, index);"
            "  return [ballesta.live.peak.part, ballesta.live.peak.value];"
            "})",
            [number, asked],
        )
        true = [von_mises(live.at(cycle, k)).max() for k in asked]
        assert {owner for owner, _ in shown} == {index}
        np.testing.assert_allclose(
            [value for _, value in shown], true, rtol=0, atol=2e-3 * live.peaks[cycle].max()
        )


def test_on_request_all_parts_share_a_scale(viewed):
    page = viewed().page
    ends = []
    for index in (0, 1):
        page.locator(f"#live-tab-{index}").click()
        settle(page)
        ends.append(page.evaluate("ballesta.live.range.to"))
    assert ends[0] != ends[1]
    role(page, "shared").check()
    for index in (0, 1):
        page.locator(f"#live-tab-{index}").click()
        settle(page)
        assert page.evaluate("ballesta.live.range.to") == max(ends)
    role(page, "shared").uncheck()
    settle(page)
    assert page.evaluate("ballesta.live.range.to") == ends[1]


def test_keys_on_the_slider_change_picture_number_and_position(viewed):
    page = viewed().page
    page.evaluate("() => { ballesta.onPosition((state) => { window.last = state; }); }")
    slider = role(page, "slider")
    page.evaluate("ballesta.setPosition(0, 10)")
    before, told = pixels(page), role(page, "peak").inner_text()
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("[last.cycle, last.index, last.cycleName, last.part]") == [
        0, 11, "turn", "ring",
    ]  # fmt: skip
    page.keyboard.press("Shift+ArrowRight")
    assert page.evaluate("last.index") == 21
    assert role(page, "peak").inner_text() != told
    assert (np.abs(pixels(page) - before).max(axis=2) > 8).mean() > 0.01
    assert slider.get_attribute("aria-valuetext").startswith("crank = 105")
    assert "105 deg" in role(page, "reading").inner_text()
    page.keyboard.press("End")
    assert page.evaluate("last.index") == sections.POSITIONS - 1


def test_the_mouse_on_the_slider_changes_the_position(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    box = role(page, "slider").bounding_box()
    before = page.evaluate(PEAK)
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert abs(page.evaluate("ballesta.current.index") - 36) <= 1
    assert page.evaluate(PEAK) != before


def test_tabs_open_by_click_and_by_arrow_keys(viewed):
    found = viewed()
    page = found.page
    tabs = page.get_by_role("tab")
    assert tabs.all_inner_texts() == ["Whole linkage", "ring", "shaft", "plate"]
    page.locator("#live-tab-1").click()
    settle(page)
    assert page.evaluate("[ballesta.live.tab, ballesta.current.part]") == [1, "shaft"]
    page.keyboard.press("ArrowRight")
    settle(page)
    assert page.locator("#live-tab-2").get_attribute("aria-selected") == "true"
    assert page.locator("#live-tab-1").get_attribute("tabindex") == "-1"
    assert page.evaluate("ballesta.live.peak") is None  # the plate has no stress, and says why
    assert "decided by a formula" in role(page, "told").inner_text()
    page.keyboard.press("Home")
    settle(page)
    assert page.evaluate("[ballesta.live.tab, ballesta.current.part]") == [-1, None]
    assert page.locator("#live-panel").get_attribute("aria-labelledby") == "live-tab-linkage"
    found.assert_quiet()


def test_the_whole_linkage_moves_and_shows_the_worst_part(viewed):
    page = viewed().page
    page.locator("#live-tab-linkage").click()
    settle(page)
    page.evaluate("ballesta.setPosition(0, 0)")
    first = pixels(page)
    assert page.evaluate("ballesta.live.marker.words").startswith("ring: peak ")
    assert "Layers are spread" in role(page, "told").inner_text()
    page.evaluate("ballesta.setPosition(0, 18)")
    settle(page)
    made = sections.design()
    parts = {each.name: each.live for each in made.parts[:2]}
    peaks = {name: von_mises(live.at("turn", 18)) for name, live in parts.items()}
    owner = max(peaks, key=lambda name: peaks[name].max())
    motion = made.motion["turn"]
    x, y, angle = motion.parts[owner][9]  # the tenth of the kept positions, every second one
    px, py, pz = parts[owner].nodes[peaks[owner].argmax()]
    c, s = np.cos(angle), np.sin(angle)
    point = [x + c * px - s * py, y + s * px + c * py, pz + motion.layer[owner], 1.0]
    rows = np.reshape(page.evaluate("[...ballesta.live.camera.pixels()]"), (3, 4))
    marker = page.evaluate("ballesta.live.marker")
    assert marker["words"].startswith(owner)
    np.testing.assert_allclose([marker["x"], marker["y"]], (rows @ point)[:2], atol=0.1)  # px
    assert (np.abs(pixels(page) - first).max(axis=2) > 30).mean() > 0.02
    page.evaluate("ballesta.setPosition(1, 3)")
    assert "no motion is shown" in role(page, "told").inner_text()


def test_fields_have_their_own_scale_and_missing_ones_say_why(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 5)")
    field, seen = role(page, "field"), []
    for name in ("mises", "principal", "utilisation", "amplitude", "mean", "displacement"):
        field.select_option(name)
        seen.append((page.evaluate("ballesta.live.field"), *page.evaluate(
            "[ballesta.live.range.from, ballesta.live.range.to]")))  # fmt: skip
    assert [name for name, _, _ in seen] == [
        "mises", "principal", "utilisation", "amplitude", "mean", "displacement",
    ]  # fmt: skip
    assert all(low == -high for name, low, high in seen if name in ("principal", "mean"))
    assert dict((name, high) for name, _, high in seen)["utilisation"] == pytest.approx(
        0.9, abs=0.05
    )  # not judged: 1 is no limit, and need not be in sight
    page.locator("#live-tab-1").click()
    settle(page)
    assert page.evaluate("ballesta.live.field") == "mises"
    assert field.locator("option[value=displacement]").is_disabled()
    assert "rigid motion is unknown" in role(page, "missing").inner_text()
    page.locator("#live-tab-0").click()  # what was chosen comes back where it is known
    settle(page)
    assert page.evaluate("ballesta.live.field") == "displacement"


def test_maps_bands_own_scale_and_deformation_change_the_picture(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 30)")
    last = pixels(page)

    def differs(least):
        nonlocal last
        now = pixels(page)
        changed = (np.abs(now - last).max(axis=2) > 8).mean()
        last = now
        assert changed > least

    role(page, "map").select_option("turbo")
    differs(0.05)
    role(page, "bands").check()
    differs(0.02)
    role(page, "own").check()
    differs(0.05)
    assert page.evaluate("ballesta.live.range.to") == pytest.approx(page.evaluate(PEAK))
    role(page, "deformed").check()
    differs(0.003)
    assert role(page, "factor-told").inner_text().startswith("× ")
    role(page, "factor").fill("60")
    differs(0.003)


def test_displacements_are_drawn_as_a_twentieth_of_the_part_rounded_up(viewed):
    page = viewed().page
    role(page, "deformed").check()
    factor = float(role(page, "factor-told").inner_text().removeprefix("× "))
    head = live_payload(sections.design()).header["parts"][0]
    size = np.linalg.norm(np.subtract(*head["bounds"]))
    share = factor * head["scale"]["displacement"]["to"] / size
    assert 0.0499 <= share <= 0.1251


def written_on(page):
    """The words that are written on the picture when it is drawn."""
    return page.evaluate(
        """() => {
          const kept = CanvasRenderingContext2D.prototype.fillText, words = [];
          CanvasRenderingContext2D.prototype.fillText = function (text, ...more) {
            words.push(text);
            kept.call(this, text, ...more);
          };
          ballesta.live.draw();
          CanvasRenderingContext2D.prototype.fillText = kept;
          return words;
        }"""
    )


def test_the_colour_bar_marks_what_is_allowed_and_a_limit_where_utilisation_has_one(
    viewed, tmp_path
):
    made = sections.design()
    ring, *others = made.parts
    peak = ring.live.peak.value
    static = replace(ring.checks[0], limit=0.9 * peak)
    fatigue = replace(static, kind="fatigue", value=90.0, limit=100.0, required=1.25)
    for judged in (True, False):
        part = replace(ring, checks=[static, fatigue], live=replace(ring.live, judged=judged))
        file = tmp_path / f"{judged}.html"
        file.write_text(sections.page(replace(made, parts=[part, *others])), encoding="utf-8")
        page = viewed(file).page
        page.locator("#live-tab-0").click()
        settle(page)
        words = written_on(page)
        assert {"allowed", "yield"} <= {*words}
        role(page, "field").select_option("utilisation")
        used = 1.25 * ring.live.fatigue["utilisation"].max()
        assert used > 1
        to = page.evaluate("ballesta.live.range.to")
        assert used < to < 1.3 * used if judged else to == pytest.approx(used)
        assert ("limit" in written_on(page)) is judged
        assert role(page, "map").input_value() == ("use" if judged else "viridis")


def test_the_map_in_use_is_the_one_that_is_named(viewed):
    page = viewed().page
    field, shown = role(page, "field"), role(page, "map")

    def open_options():
        return shown.locator("option:not(:disabled)").evaluate_all("all => all.map((o) => o.value)")

    shown.select_option("cividis")
    assert open_options() == ["viridis", "cividis", "turbo"]
    field.select_option("principal")
    assert shown.input_value() == "signed"
    assert open_options() == ["turbo", "signed"]
    field.select_option("mises")
    assert shown.input_value() == "cividis"  # what was chosen comes back
    field.select_option("principal")
    before = pixels(page)
    shown.select_option("turbo")
    assert (np.abs(pixels(page) - before).max(axis=2) > 8).mean() > 0.05
    shown.select_option("signed")
    assert shown.input_value() == "signed"
    assert (np.abs(pixels(page) - before).max(axis=2) > 8).mean() < 0.01


def test_drag_keys_and_buttons_turn_and_zoom(viewed):
    page = viewed().page
    canvas = role(page, "canvas")
    page.locator("[data-view=iso]").click()
    turn, scale = page.evaluate("[ballesta.live.camera.turn, ballesta.live.camera.scale]")
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 500, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 560, box["y"] + 240, steps=4)
    page.mouse.up()
    turned = page.evaluate("ballesta.live.camera.turn")
    assert turned != turn
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("ballesta.live.camera.turn") != turned
    page.keyboard.press("+")
    assert page.evaluate("ballesta.live.camera.scale") == pytest.approx(1.25 * scale)
    page.mouse.wheel(0, -200)  # the picture has the focus, so the wheel is its own
    settle(page)
    assert page.evaluate("ballesta.live.camera.scale") > 1.3 * scale
    assert page.evaluate("scrollY") == 0
    page.locator("[data-view=iso]").click()
    assert page.evaluate("ballesta.live.camera.turn") == turn
    assert page.evaluate("ballesta.live.camera.scale") == pytest.approx(scale)


def test_a_utilisation_is_grey_below_and_red_over_its_limit(viewed, tmp_path):
    """One hard change of colour at 1: red everywhere over it, nowhere below."""
    made = sections.design()
    ring, *others = made.parts
    static = replace(ring.checks[0], limit=0.5 * ring.live.peak.value)
    file = tmp_path / "used.html"
    result = replace(made, parts=[replace(ring, checks=[static]), *others])
    file.write_text(sections.page(result), encoding="utf-8")
    page = viewed(file, field="static").page
    page.locator("#live-tab-0").click()
    settle(page)
    role(page, "forces").uncheck()
    peak, to = page.evaluate("[ballesta.live.peak.value, ballesta.live.range.to]")
    assert 1 < peak < to

    def red():
        colours = pixels(page)[:, : int(0.8 * pixels(page).shape[1])]  # without the colour bar
        return int((colours[..., 0] > colours[..., 2] + 60).sum())

    assert red() > 50
    quiet = page.evaluate(
        """() => { for (let k = 0; k < 200; k++) {
          ballesta.setPosition(0, k);
          if (ballesta.live.peak.value < 0.95) return ballesta.live.peak.value;
        } }"""
    )
    assert quiet < 0.95
    assert red() == 0


@pytest.mark.parametrize("most", [0.3, 2.0, 5.0])
def test_stills_have_the_colours_of_the_live_view(viewed, most):
    """Each of its 256 colours is that of stills at its utilisation, to the step between two."""
    script = files("reports.live").joinpath("picture.js").read_text(encoding="utf-8")
    made = re.search(r"const useTable = .*?\n};\n", script, re.DOTALL)[0]
    table, to = viewed().page.evaluate(
        f"([most, stops]) => {{ {made} const {{ table, to }} = useTable(most, stops);"
        " return [[...table], to]; }",
        [most, colour_maps()["use"]],
    )
    uses = np.linspace(0.0, to, 256)
    step = np.abs(np.diff(np.reshape(table, (256, 3)), axis=0))
    last = int((uses <= 1).sum())  # one hard change, at 1
    assert step.sum(axis=1).argmax() == last - 1
    assert np.abs(use_colours(uses, to) - np.reshape(table, (256, 3))).max() < 4
