"""The charts' cursors in a browser: they follow the position, and a click sets it."""

import json
from functools import cache
from importlib.resources import files

import numpy as np
import pytest
from markupsafe import Markup

from reports.charts import cycle_charts, part_charts
from reports.svg import colour_variables
from reports.templating import environment

from . import chart_results as made

PAGE = """{% from "charts.html.j2" import charts with context %}<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline';
 script-src 'unsafe-inline'"><title>Charts</title><style>:root { --ground: #fff; --ink: #000;
 --soft: #555; --line: #ccc; {{ light }} } {% include "charts.css" %}</style></head><body>
<script type="application/json" id="live-cycles">{{ cycles }}</script>
{{ charts(part) }}{% for _, found in cycle %}{{ charts(found) }}{% endfor %}
<script>(() => { "use strict"; {{ script }} })();</script></body></html>"""
IDLE = {"position": [0.0, 1.0, 2.0], "phase": ["idle"] * 3, "shown_name": "x", "unit": "mm"}


@cache
def page_text():
    """A page of all charts with the position's script and theirs."""
    result = made.design()
    cycles = {"idle": IDLE, **result.cycles}
    result = type(result)(**{**vars(result), "cycles": cycles})
    plain = [
        {
            "name": name, "shown_name": cycle["shown_name"], "unit": cycle["unit"],
            "position": list(map(float, cycle["position"])), "time": [], "phase": ["all"],
            "phase_of": [0] * len(cycle["position"]),
        }
        for name, cycle in cycles.items()
    ]  # fmt: skip
    sources = [
        files("reports").joinpath(path).read_text(encoding="utf-8")
        for path in (
            "live/data.js",
            "live/numbers.js",
            "live/positions.js",
            "scripts/cursors.js",
            "scripts/hover.js",
        )
    ]
    return (
        environment()
        .from_string(PAGE)
        .render(
            part=part_charts(result.parts[0], result),
            cycle=cycle_charts(result),
            cycles=Markup(json.dumps(plain).replace("<", "\\u003c")),
            script=Markup("\n".join(sources)),
            light=Markup(colour_variables(dark=False)),
        )
    )


@pytest.fixture
def charts(tmp_path, opened):
    path = tmp_path / "charts.html"
    path.write_text(page_text(), encoding="utf-8")
    found = opened(path, height=6000)
    yield found.page
    found.assert_quiet()


def go(page, cycle, index):
    page.evaluate(f"ballesta.setPosition({cycle}, {index})")


def now(page, key):
    """What a chart's readout says."""
    rows = page.locator(f"figure.{key}:has(svg[data-cursor])").last.locator(".readout output")
    return [text for text in rows.all_text_contents() if text]


def test_the_readout_says_the_value_at_the_position(charts):
    go(charts, 1, 121)  # the end of the press phase, where all peaks are
    cycle = made.cycle()
    assert now(charts, "drive")[1] == f"now {cycle['efforts']['process'][121] * 1e-3:.1f} kN"
    assert now(charts, "peaks")[0] == f"now {cycle['peaks']['bar_upper'][121]:.0f} MPa"
    go(charts, 1, 0)
    assert now(charts, "drive")[1] == "now 0.0 kN"


def test_between_two_positions_the_value_is_on_the_straight_line(charts):
    """To half a unit of the last printed digit, 0.1 kN."""
    effort = np.asarray(made.cycle()["efforts"]["process"]) * 1e-3
    assert abs(effort[101] - effort[100]) > 0.2  # else either end would do
    go(charts, 1, 100.5)
    told = float(now(charts, "drive")[1].split()[1])
    assert abs(told - np.interp(100.5, np.arange(len(effort)), effort)) <= 0.05


def test_the_line_stands_at_the_position_and_dots_on_the_curves(charts):
    line = charts.locator("figure.loads .cursor line")
    xs = []
    for index in (0, 60, 91, 121, 182):
        go(charts, 1, index)
        xs.append(float(line.last.get_attribute("x1")))
    assert xs == sorted(xs)
    assert xs[-1] - xs[0] > 380
    assert charts.locator("figure.loads").last.locator(".cursor circle").count() == 2


def test_the_dot_of_a_curve_is_higher_where_its_value_is_larger(charts):
    heights = []
    for index in (0, 121):  # the end of the press phase, where all peaks are
        go(charts, 1, index)
        circle = charts.locator("figure.peaks").last.locator(".cursor circle").first
        heights.append(float(circle.get_attribute("cy")))
    assert heights[1] < heights[0] - 20  # y goes down


def test_the_dot_climbs_haighs_path_to_the_critical_point(charts):
    ys = []
    for index in (0, 45, 91):
        go(charts, 1, index)
        ys.append(float(charts.locator("figure.haigh .cursor circle").get_attribute("cy")))
    assert ys == sorted(ys, reverse=True)
    assert now(charts, "haigh") == ["now 35.0 MPa", "now 40.0 MPa", "now 0.318"]
    assert now(charts, "sn") == ["now 38.3 MPa"]


def test_charts_of_another_cycle_show_no_cursor(charts):
    go(charts, 1, 91)
    go(charts, 0, 1)
    assert now(charts, "haigh") == []
    assert charts.locator("figure.haigh .readout li:visible").count() == 0
    assert not charts.locator("figure.haigh .cursor circle").is_visible()
    assert charts.locator("figure.drive .cursor line:visible").count() == 0
    peaks = charts.locator("figure.peaks .readout .peak")
    assert peaks.first.is_visible()  # what is known without a position stays


@pytest.mark.parametrize("share", [0.02, 0.5, 0.97])
def test_a_click_sets_the_position_under_the_pointer(charts, share):
    go(charts, 1, 5)
    chart = charts.locator("figure.drive svg[data-cursor]").last
    box = chart.bounding_box()
    left, right = 44 / 460.8, 1 - 12 / 460.8
    x = box["width"] * (left + share * (right - left))
    chart.click(position={"x": x, "y": box["height"] * 0.3})
    at = charts.evaluate("ballesta.current.index")
    assert at == round(at)
    line = float(chart.locator(".cursor line").get_attribute("x1"))
    assert abs(line / 460.8 * box["width"] - x) < 6


def test_a_click_near_haighs_path_sets_its_nearest_position(charts):
    go(charts, 1, 91)
    chart = charts.locator("figure.haigh svg[data-cursor]")
    dot = chart.locator(".cursor circle")
    box = chart.bounding_box()
    scale = box["width"] / 460.8
    x, y = (float(dot.get_attribute(name)) * scale for name in ("cx", "cy"))
    go(charts, 1, 0)
    chart.click(position={"x": x + 3, "y": y - 3})
    assert abs(charts.evaluate("ballesta.current.index") - 91) <= 3


def test_without_scripts_pictures_peaks_and_tables_are_there(tmp_path, opened):
    path = tmp_path / "charts.html"
    path.write_text(page_text(), encoding="utf-8")
    page = opened(path, java_script_enabled=False).page
    assert page.locator("figure.chart svg[role=img]").count() == 5 + 3
    assert page.locator("figure.drive .peak").first.is_visible()
    assert page.locator("figure.haigh .readout li").first.is_hidden()
    page.locator("figure.haigh summary").click()
    assert page.locator("figure.haigh tbody tr").first.is_visible()


def test_a_phone_shows_whole_charts(tmp_path, opened):
    path = tmp_path / "charts.html"
    path.write_text(page_text(), encoding="utf-8")
    page = opened(path, width=360).page
    widths = page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert widths[0] <= widths[1]
    box = page.locator("figure.haigh .picture > svg").bounding_box()
    assert box["width"] <= 344


def test_values_under_the_pointer_are_told_in_every_chart(charts):
    """In the middle of a frame they are the middle of its axes, as the picture states them."""
    svgs = charts.locator("figure.chart svg[data-frames]")
    assert svgs.count() == charts.locator("figure.chart .picture > svg").count() > 3
    told = svgs.evaluate_all(
        """(all) => all.map((svg) => {
          const [left, top, width, height, x0, x1, y0, y1] =
            svg.dataset.frames.split(";")[0].split(" ").map(Number);
          const log = svg.dataset.frames.split(";")[0].split(" ")[8];
          const at = new DOMPoint(left + width / 2, top + height / 2)
            .matrixTransform(svg.getScreenCTM());
          svg.dispatchEvent(new PointerEvent("pointermove", { clientX: at.x, clientY: at.y }));
          const text = svg.querySelector(".under-pointer")?.textContent ?? "";
          svg.dispatchEvent(new PointerEvent("pointerleave"));
          return [text, x0, x1, y0, y1, log, svg.querySelector(".under-pointer") === null];
        })"""
    )
    for text, x0, x1, y0, y1, log, gone in told:
        x, y = (float(part) for part in text.replace("−", "-").split(";"))
        middle = [(x0 * x1) ** 0.5 if "x" in log else (x0 + x1) / 2]
        middle += [(y0 * y1) ** 0.5 if "y" in log else (y0 + y1) / 2]
        spans = [x if "x" in log else x1 - x0, y if "y" in log else y1 - y0]
        assert abs(x - middle[0]) <= 5e-3 * abs(spans[0])
        assert abs(y - middle[1]) <= 5e-3 * abs(spans[1])
        assert gone
