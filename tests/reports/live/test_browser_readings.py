"""Readings of the live view: values at points, the peak and its marker, digits, notes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from checks.result.live_fields import von_mises
from reports.live.section import live_payload

from . import sections
from .conftest import role, settle

PEAK = "ballesta.live.peak.value"


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
    below = page.locator(".live-top > .live-viewer")
    words = below.locator("[data-role=told], [data-role=missing]").all_inner_texts()
    assert " ".join(words).count("decided by a formula") == 1
