import gzip
import json
import math
import re
from base64 import b64decode, b64encode
from hashlib import sha256
from importlib.resources import files

import numpy as np
import pytest
from markupsafe import Markup
from numpy.testing import assert_allclose

from reports.mechanism_panel import mechanism_panel
from reports.svg import colour_variables
from reports.templating import environment

from . import motion_results, results
from .test_page import Page

SCRIPTS = (
    "live/data.js", "live/numbers.js", "live/positions.js", "scripts/arrows.js",
    "scripts/mechanism.js",
)  # fmt: skip


@pytest.fixture(scope="module")
def press():
    return motion_results.press()


@pytest.fixture(scope="module")
def panel(press):
    return mechanism_panel(press)


def unpacked(panel):
    (block,) = re.findall(r'id="mechanism-data">([^<]*)</script>', panel)
    return json.loads(gzip.decompress(b64decode(block)))


def values(series):
    return series["from"] + series["step"] * np.cumsum(series["d"])


def page(result):
    """A page of the panel alone, under the report's policy, with the positions of the page."""
    cycles = [
        {
            "name": name, "shown": name, "shown_name": cycle["shown_name"], "unit": cycle["unit"],
            "position": np.asarray(cycle["position"]).tolist(),
            "time": np.asarray(cycle["time"]).tolist(),
            "phase": [""], "phase_of": [0] * len(cycle["position"]),
        }
        for name, cycle in result.cycles.items()
    ]  # fmt: skip
    text = "\n".join(files("reports").joinpath(name).read_text("utf-8") for name in SCRIPTS)
    script = f'(() => {{ "use strict";\n{text}\nglobalThis.openPart = positions.setPart;\n}})();'
    colours = {"light": Markup(colour_variables(False)), "dark": Markup(colour_variables(True))}
    found = environment()
    style = found.get_template("report.css").render(**colours)
    style += found.get_template("mechanism.css").render()
    digest = b64encode(sha256(script.encode()).digest()).decode()
    data = json.dumps(cycles).replace("<", "\\u003c")
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        f"script-src 'sha256-{digest}'; style-src 'unsafe-inline'\">"
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Mechanism</title><style>{style}</style></head><body><main>"
        f"{mechanism_panel(result)}</main>"
        f'<script type="application/json" id="live-cycles">{data}</script>'
        f"<script>{script}</script></body></html>"
    )


def test_a_result_without_any_motion_has_no_panel():
    assert mechanism_panel(results.mixed()) is None


def test_the_panel_is_the_same_every_time(press, panel):
    assert mechanism_panel(press) == panel


def test_without_a_script_it_stands_where_the_verdict_is_decided_with_its_forces(press, panel):
    """The peak of bar_upper is half way through the cycle; the nearest kept position is shown."""
    motion = press.motion["press"]
    middle = len(press.cycles["press"]["position"]) // 2
    row = round(motion.row_of(middle))
    x, y = motion.point("upper", "A")[row]
    places = {
        a["id"]: a["transform"] for _, a in Page(panel).tags if "mechanism-point" in a.get("id", "")
    }
    found = [[float(v) for v in re.findall(r"-?[\d.]+", place)] for place in places.values()]
    assert any(math.dist(place, (x, -y)) < 1e-2 for place in found)
    arrows = [a.get("d", "") for _, a in Page(panel).tags if "arrow" in a.get("class", "")]
    assert sum(bool(d) for d in arrows) >= 3
    assert (
        f"x = {press.cycles['press']['position'][int(motion.index[row])]:.5g} mm"
        in Page(panel).text
    )


def test_the_packed_numbers_are_the_motion_s(press, panel):
    data = unpacked(panel)
    motion = press.motion["press"]
    cycle = data["cycles"][0]
    assert data["cycles"][1] is None  # measured
    assert cycle["index"] == motion.index.tolist()
    size = np.ptp(motion.poses[..., :2])
    for k, series in enumerate(cycle["poses"]):
        assert_allclose(values(series), motion.poses[:, 1 + k // 3, k % 3], atol=2e-5 * size)
    for k, pin in enumerate(motion.pins.values()):
        largest = np.abs(pin.force).max()
        for axis in (0, 1):
            assert_allclose(
                values(cycle["pins"][2 * k + axis]), pin.force[:, axis], atol=2e-5 * largest
            )
    assert [pin["part"] for pin in data["pins"]] == [0, 0, 1, 2]
    assert data["parts"][2]["mark"] is not None  # the pin is a pin of the picture
    assert data["parts"][0]["mark"] is None


def test_a_force_that_slides_has_its_places_packed():
    result = motion_results.crank()
    data = unpacked(mechanism_panel(result))
    assert data["pins"][0]["at"] is None
    assert data["pins"][1]["at"] == [0, 0]
    x, y = data["cycles"][0]["places"]
    assert_allclose(values(x), np.linspace(0, 40, 60), atol=1e-3)
    assert_allclose(values(y), 0)


def test_every_pin_force_stands_in_a_table_with_where_it_is_largest(press, panel):
    text = Page(panel).text
    sizes = np.hypot(*press.motion["press"].pins["bar_upper knee"].force.T)
    assert f"{sizes.max() / 1000:.4g}" in text
    assert "in kN, in the machine's axes" in text
    for words in ("bar_upper", "bar_lower", "pin_B", "knee", "largest"):
        assert words in text
    assert "rig: no motion is shown" in text


def test_the_table_has_the_components_of_each_largest_force(press, panel):
    (table,) = re.findall(r'<table data-cycle="0">.*?</table>', panel, re.DOTALL)
    rows = re.findall(r"<tr><th scope=\"row\".*?</tr>", table, re.DOTALL)
    pins = list(press.motion["press"].pins.values())
    assert len(rows) == len(pins)
    turned = 0
    for row, pin in zip(rows, pins, strict=True):
        cells = re.findall(r'<td class="n">([^<]*)</td>', row)
        size, x, y = (float(cell.replace("−", "-")) for cell in cells[:3])
        force = pin.force[np.hypot(*pin.force.T).argmax()] / 1000
        assert [size, x, y] == pytest.approx([np.hypot(*force), *force], rel=1e-3, abs=1e-6)
        turned += abs(x - y) > 0.1 * size
    assert turned


def test_hostile_names_are_text():
    panel = mechanism_panel(motion_results.hostile())
    assert "<script>alert" not in panel
    assert "<script>alert('x')</script>" in Page(panel).text
    ids = [a["id"] for _, a in Page(panel).tags if "id" in a]
    assert len(ids) == len(set(ids))


@pytest.fixture
def shown(opened, tmp_path):
    """A page of a result in the browser, ready."""

    def show(result, **keywords):
        path = tmp_path / "panel.html"
        path.write_text(page(result), encoding="utf-8")
        found = opened(path, **keywords)
        if keywords.get("java_script_enabled", True):
            found.page.locator("#mechanism[data-state=ready]").wait_for(state="attached")
        return found

    return show


PLACE = "document.getElementById('mechanism-body-1').getAttribute('transform')"
ARROWS = (
    "[...document.querySelectorAll('.on-part')].map((a) => (a.getAttribute('d') ?? '').length > 0)"
)


def numbers(text):
    return [float(value) for value in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]


def test_the_picture_follows_the_page_s_position_also_between_two(shown, press):
    found = shown(press)
    motion = press.motion["press"]
    body = motion.linkage.body_names.index("upper")
    for index in (0, 40, 41.5, 100.25):
        found.page.evaluate(f"ballesta.setPosition(0, {index})")
        row = motion.row_of(index)
        low = int(row)
        pose = motion.poses[low, body] + (row - low) * (
            motion.poses[min(low + 1, len(motion.poses) - 1), body] - motion.poses[low, body]
        )
        x, y, angle = numbers(found.page.evaluate(PLACE.replace("body-1", f"body-{body - 1}")))
        assert [x, y, angle] == pytest.approx([pose[0], -pose[1], -math.degrees(pose[2])], abs=0.02)
    assert "cylinder" in found.page.locator(".mechanism-reading").inner_text()
    found.assert_quiet()


def test_the_open_part_is_marked_and_carries_its_own_forces(shown):
    found = shown(motion_results.press())
    page = found.page
    page.evaluate("ballesta.setPosition(0, 180)")
    reactions = "document.querySelectorAll('.arrow:not(.on-part)[d*=M]').length"
    assert page.evaluate(ARROWS) == [False] * 4
    assert page.evaluate(reactions) >= 3
    page.evaluate("openPart(0)")
    assert page.evaluate(ARROWS) == [True, True, False, False]
    assert page.evaluate(reactions) == 0
    assert page.locator(".body.open").count() == 1
    told = page.locator("[data-role=on]").inner_text()
    assert "forces on bar_upper" in told
    assert "knee" in told
    assert "end" in told
    page.evaluate("openPart(2)")  # a pin: its circle is marked instead of a body
    assert page.locator(".body.open").count() == 0
    assert page.locator(".pin.open").count() == 1
    page.evaluate("openPart(-1)")
    assert page.locator(".open").count() == 0
    assert page.locator("[data-role=on]").is_hidden()
    found.assert_quiet()


def test_an_arrow_is_as_long_as_its_force_over_the_largest(shown, press):
    """The longest arrow of a cycle is a fifth of the linkage's size."""
    found = shown(press)
    motion = press.motion["press"]
    force = motion.pins["bar_upper end"].force
    row = int(np.hypot(*force.T).argmax())
    found.page.evaluate(f"openPart(0); ballesta.setPosition(0, {int(motion.index[row])})")
    path = found.page.evaluate("document.querySelectorAll('.on-part')[0].getAttribute('d')")
    x0, y0, x1, y1 = numbers(path)[:4]
    assert [x0, y0] == pytest.approx(motion.point("upper", "A")[row] * [1, -1], abs=0.02)
    data = unpacked(mechanism_panel(press))
    scale = data["cycles"][0]["scale"]
    assert [x1 - x0, y0 - y1] == pytest.approx((scale * force[row]).tolist(), rel=1e-3, abs=0.02)


def test_a_reaction_is_drawn_the_way_it_acts_and_an_effort_is_told_in_its_unit(shown, press):
    found = shown(press)
    data = unpacked(mechanism_panel(press))
    cycle = data["cycles"][0]
    reactions = [values(one) for one in cycle["reactions"]]
    row = int(np.hypot(*reactions[:2]).argmax())
    index = int(press.motion["press"].index[row])
    found.page.evaluate(f"openPart(-1); ballesta.setPosition(0, {index})")
    compared = 0
    for k in range(data["joints"]):
        force = np.array([reactions[2 * k][row], reactions[2 * k + 1][row]])
        path = found.page.evaluate(
            f"document.getElementById('mechanism-arrow-{k}').getAttribute('d')"
        )
        if path:
            x0, y0, x1, y1 = numbers(path)[:4]
            wanted = (cycle["scale"] * force).tolist()
            assert [x1 - x0, y0 - y1] == pytest.approx(wanted, rel=1e-3, abs=0.02)
            compared += abs(wanted[0]) > 1
    assert compared
    reading = found.page.locator(".mechanism-reading").inner_text()
    for effort, series in zip(data["efforts"], cycle["efforts"], strict=True):
        told = re.search(rf"{effort['name']} (\S+) {effort['unit']}", reading)[1]
        size = effort["factor"] * values(series)[row]
        assert float(told.replace("−", "-")) == pytest.approx(size, rel=6e-3, abs=6e-3)
    found.assert_quiet()


def test_every_arrow_stays_in_the_picture(press, panel):
    """Also those on the bodies that the reactions are not drawn on."""
    box = [float(v) for v in re.search(r'viewBox="([^"]*)"', panel)[1].split()]
    scale = unpacked(panel)["cycles"][0]["scale"]
    motion = press.motion["press"]
    for pin in motion.pins.values():
        tips = (pin.place + scale * pin.force) * [1, -1]
        assert (tips >= box[:2]).all()
        assert (tips <= np.add(box[:2], box[2:])).all()


def test_the_table_tells_the_forces_at_the_position_shown(shown, press):
    found = shown(press)
    motion = press.motion["press"]
    found.page.evaluate("ballesta.setPosition(0, 180)")
    found.page.locator("summary").click()
    told = found.page.locator("table td[data-now]").all_inner_texts()
    sizes = [np.hypot(*pin.force[90]) for pin in motion.pins.values()]
    assert [float(text) for text in told] == pytest.approx([f / 1000 for f in sizes], rel=6e-3)


def test_a_measured_run_stands_still_and_says_so(shown, press):
    found = shown(press)
    before = found.page.evaluate(PLACE)
    found.page.evaluate("ballesta.setPosition(1, 5)")
    assert found.page.evaluate(PLACE) == before
    assert "no motion is known of this run" in found.page.locator(".mechanism-reading").inner_text()
    assert found.page.locator("svg.still").count() == 1
    found.page.evaluate("ballesta.setPosition(0, 5)")
    assert found.page.locator("svg.still").count() == 0
    found.assert_quiet()


@pytest.mark.parametrize("kind", ["crank", "hostile"])
def test_torques_sliding_forces_and_hostile_names_move_quietly(shown, kind):
    found = shown(getattr(motion_results, kind)(), width=360, color_scheme="dark")
    for index in (0, 10.5, 29):
        found.page.evaluate(f"openPart(0); ballesta.setPosition(0, {index})")
    wide = found.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 360
    found.assert_quiet()


def test_without_scripts_the_picture_and_the_tables_are_there(shown, press):
    found = shown(press, java_script_enabled=False)
    assert found.page.locator("svg .link").count() >= 2
    assert "cycle press, x = " in found.page.locator(".mechanism-reading").inner_text()
    assert found.page.locator("th[data-now]").first.is_hidden()
    found.page.locator("summary").click()
    assert found.page.locator("table").first.is_visible()


def test_data_that_cannot_be_unpacked_leave_the_picture_as_it_is(opened, tmp_path, press):
    path = tmp_path / "broken.html"
    broken = re.sub(r'(id="mechanism-data">)[^<]*', r"\1AAAA", page(press))
    path.write_text(broken, encoding="utf-8")
    found = opened(path)
    found.page.locator("#mechanism[data-state=failed]").wait_for(state="attached")
    told = found.page.locator(".mechanism-reading").inner_text()
    assert "it cannot move here: the motion in this page is damaged" in told
    found.assert_quiet()


@pytest.mark.parametrize(("most", "printed"), [(0, False), (1000, True)])
def test_paper_gets_the_table_of_forces_only_if_it_is_short(monkeypatch, press, most, printed):
    monkeypatch.setattr("reports.mechanism_panel._PRINTED", most)
    assert ('<details class="printed">' in mechanism_panel(press)) is printed
