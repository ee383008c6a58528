"""The live view as a reader uses it: parts, positions, fields, probe, peak."""

import re
from dataclasses import replace

import numpy as np
import pytest

from reports.live.fields import von_mises
from reports.live.payload import live_payload

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
    )
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


def test_the_pointer_reads_the_value_and_a_click_holds_the_components(viewed):
    """The held value is that of full precision at a node near by, to 0.2 % of the peak."""
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 20)")
    canvas = role(page, "canvas")
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 5, box["y"] + box["height"] / 2)
    settle(page)
    assert "beside" in role(page, "probe").inner_text()
    page.locator("[data-view=front]").click()
    row = page.evaluate("[...ballesta.live.camera.pixels()]")
    x, y = row[3] + 21 * row[0], row[7] + 12 * row[5]  # 21 and 12 mm from the axis, on the ring
    page.mouse.move(box["x"] + x, box["y"] + y)
    settle(page)
    probe = page.evaluate("ballesta.live.probe")
    live = sections.design().parts[0].live
    near = np.linalg.norm(live.nodes - probe["place"], axis=1).argsort()[:4]
    mises = von_mises(live.at("turn", 20))
    assert mises[near].min() * 0.9 < probe["value"] < mises[near].max() * 1.1
    page.mouse.click(box["x"] + x, box["y"] + y)
    held = role(page, "pinned")
    assert held.locator("td").count() == 10
    value = float(held.locator("b").inner_text().split()[0])
    assert np.abs(mises[near] - value).min() < 2e-3 * live.peaks["turn"].max()
    sigma = [float(cell.replace("−", "-")) for cell in held.locator("td").all_inner_texts()]
    assert sigma[-1] == pytest.approx(value, abs=0.01)  # rounding of the printed digits
    page.evaluate("ballesta.setPosition(0, 40)")
    assert held.locator("b").inner_text() != f"{value} MPa"
    role(page, "unpin").click()
    assert role(page, "pinned-box").is_hidden()


def test_displacements_are_drawn_as_a_twentieth_of_the_part_rounded_up(viewed):
    page = viewed().page
    role(page, "deformed").check()
    factor = float(role(page, "factor-told").inner_text().removeprefix("× "))
    head = live_payload(sections.design()).header["parts"][0]
    size = np.linalg.norm(np.subtract(*head["bounds"]))
    share = factor * head["scale"]["displacement"]["to"] / size
    assert 0.0499 <= share <= 0.1251


def test_no_digit_is_told_that_the_error_hides(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 20)")
    box = role(page, "canvas").bounding_box()
    page.locator("[data-view=front]").click()
    row = page.evaluate("[...ballesta.live.camera.pixels()]")
    page.mouse.click(box["x"] + row[3] + 21 * row[0], box["y"] + row[7] + 12 * row[5])
    shown = role(page, "pinned").locator("td").all_inner_texts()
    off = live_payload(sections.design()).header["parts"][0]["accuracy"]["principal"][0]
    assert len(shown) == 10
    for text in shown:
        decimals = len(text.partition(".")[2])
        assert text == "0" or 10.0**-decimals > off / 10, (text, off)
    assert any("." in text for text in shown)


def test_no_digit_of_a_field_over_the_duty_or_a_displacement_is_told_that_its_steps_hide(viewed):
    """`text` with the value of the node that has the least of each field, but more than nothing."""
    page = viewed().page
    head = live_payload(sections.design()).header["parts"][0]
    for field, off in (
        ("utilisation", head["coding"]["fatigue"]["utilisation"] / 2),
        ("displacement", head["accuracy"]["moved"][0]),
    ):
        role(page, "field").select_option(field)
        box = role(page, "canvas").bounding_box()
        least = ""
        for across in range(6, 95, 4):
            x, y = box["x"] + across / 100 * box["width"], box["y"] + box["height"] / 2
            page.mouse.click(x, y)
            if role(page, "pinned-box").is_visible():
                text = role(page, "pinned").locator("b").inner_text().split()[0]
                value = float(text.replace("−", "-"))
                if value and (not least or value < float(least)):
                    least = text
        assert least
        decimals = len(least.partition(".")[2])
        assert 10.0**-decimals > off / 10, (field, least, off)


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
        assert page.evaluate("ballesta.live.range.to") == pytest.approx(used)
        assert ("limit" in written_on(page)) is judged


def test_the_linkage_says_that_grey_parts_are_not_in_its_peak(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 5)")
    page.locator("#live-tab-0").click()
    settle(page)
    assert "grey" not in role(page, "peak").inner_text()
    page.locator("#live-tab-linkage").click()
    role(page, "peak").get_by_text("grey parts are not counted").wait_for()


@pytest.mark.parametrize(("decides", "named"), [(True, "by the solver"), (False, "what decides")])
def test_a_mesh_to_look_at_is_not_told_as_what_decides(viewed, tmp_path, decides, named):
    made = sections.design()
    ring, *others = made.parts
    live = replace(ring.live, decides=decides, notes=("drawn to be looked at", "another note."))
    file = tmp_path / "looked_at.html"
    parts = [replace(ring, live=live), *others]
    file.write_text(sections.page(replace(made, parts=parts)), encoding="utf-8")
    page = viewed(file).page
    page.locator("#live-tab-0").click()
    settle(page)
    assert role(page, "worst-name").inner_text().endswith(named)
    assert "Drawn to be looked at. Another note." in role(page, "told").inner_text()


def test_the_most_stressed_places_stand_in_a_table_that_leads_to_them(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    box = role(page, "hottest")
    box.locator("summary").click()
    rows = box.locator("tbody tr")
    rows.first.wait_for()
    assert rows.count() == 8
    values = [float(text.split()[0]) for text in box.locator("td.n").all_inner_texts()]
    assert values == sorted(values, reverse=True)
    assert values[0] == pytest.approx(page.evaluate(PEAK), abs=0.01)
    rows.nth(2).get_by_role("button").click()
    assert float(role(page, "pinned").locator("b").inner_text().split()[0]) == values[2]


def test_the_most_stressed_places_are_a_little_apart_from_each_other(viewed):
    """By 3 % of the part's diagonal at least, but no farther than it takes."""
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    box = role(page, "hottest")
    box.locator("summary").click()
    box.locator("tbody tr").first.wait_for()
    told = [
        re.findall(r"[xyz] (−?[\d.]+)", row) for row in box.locator("tbody tr").all_inner_texts()
    ]
    places = np.array([[float(one.replace("−", "-")) for one in row] for row in told])
    head = live_payload(sections.design()).header["parts"][0]
    size = np.linalg.norm(np.subtract(*head["bounds"]))
    apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(8, 1)] / size
    assert 0.029 < apart.min() < 0.06


def _covered(live, node, towards):
    """Whether a triangle that does not touch the node stands before it: Moeller and Trumbore."""
    start = live.nodes[node]
    corners = live.nodes[live.triangles[~(live.triangles == node).any(axis=1)]]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(towards, two)
    scale = (one * across).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((start - corners[:, 0]) * across).sum(axis=1) / scale
        round_ = np.cross(start - corners[:, 0], one)
        v = (round_ * towards).sum(axis=1) / scale
        far = (two * round_).sum(axis=1) / scale
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (far > 1e-3)).any())


def test_the_peaks_marker_knows_when_a_rim_hides_it(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    live = sections.design().parts[0].live
    node = int(von_mises(live.at("turn", 0)).argmax())
    normal = np.zeros(3)
    for a, b, c in live.triangles[(live.triangles == node).any(axis=1)]:
        normal += np.cross(live.nodes[b] - live.nodes[a], live.nodes[c] - live.nodes[a])
    seen = set()
    for turn in np.random.default_rng(3).normal(size=(60, 4)):
        marker, rows = page.evaluate(
            "(turn) => { const { camera } = ballesta.live; camera.turn = turn;"
            " camera.orbit(1e-9, 0); ballesta.live.draw();"
            " return [ballesta.live.marker, camera.rows]; }",
            (turn / np.linalg.norm(turn)).tolist(),
        )
        towards = np.array(rows[6:])
        assert marker["hidden"] == _covered(live, node, towards)
        assert marker["words"].endswith("hidden") == marker["hidden"]
        seen.add((bool(normal @ towards > 0), marker["hidden"]))
    assert (True, True) in seen  # its face is turned to the reader, and yet it is hidden
    assert (True, False) in seen
    assert (False, True) in seen


def test_the_peak_view_turns_to_where_the_peak_is_seen(viewed):
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    page.locator("[data-view=front]").click()
    page.locator("[data-view=peak]").click()
    settle(page)
    marker, size = page.evaluate("[ballesta.live.marker, ballesta.live.camera]")
    assert not marker["hidden"]
    assert marker["x"] == pytest.approx(size["width"] / 2, abs=1)
    assert marker["y"] == pytest.approx(size["height"] / 2, abs=1)


def test_the_peak_view_is_as_square_and_as_high_as_what_stands_before_the_peak_allows(viewed):
    """Against 400 other directions: none that sees the peak has a better sum of both."""
    page = viewed().page
    page.evaluate("ballesta.setPosition(0, 0)")
    page.locator("[data-view=iso]").click()
    iso = np.array(page.evaluate("ballesta.live.camera.rows")[6:])
    page.locator("[data-view=peak]").click()
    towards = np.array(page.evaluate("ballesta.live.camera.rows")[6:])
    live = sections.design().parts[0].live
    node = int(von_mises(live.at("turn", 0)).argmax())
    normal = np.zeros(3)
    for a, b, c in live.triangles[(live.triangles == node).any(axis=1)]:
        normal += np.cross(live.nodes[b] - live.nodes[a], live.nodes[c] - live.nodes[a])
    normal /= np.linalg.norm(normal)
    assert normal @ towards > 0.1
    ways = np.random.default_rng(5).normal(size=(400, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    best = max(
        way @ (normal + 0.5 * iso)
        for way in ways
        if way @ normal > 0.1 and not _covered(live, node, way)
    )
    assert towards @ (normal + 0.5 * iso) > best - 0.15  # directions 14 degrees apart


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


def test_nothing_is_told_twice_and_the_bound_of_a_field_only_with_it(viewed):
    page = viewed().page
    page.locator("#live-tab-0").click()
    settle(page)
    for field, told in (("mises", True), ("utilisation", False)):
        role(page, "field").select_option(field)
        assert ("differs from the solver's von Mises" in role(page, "told").inner_text()) is told
    page.locator("#live-tab-2").click()
    settle(page)
    page.get_by_text("decided by a formula").first.wait_for()
    below = page.locator(".live-below > .live-viewer")
    words = below.locator("[data-role=told], [data-role=missing]").all_inner_texts()
    assert " ".join(words).count("decided by a formula") == 1


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
