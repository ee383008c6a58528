"""Charts of a result: what they draw, what stands behind them, and what they leave out."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reports.charts import cycle_charts, part_charts
from reports.charts.over_cycle import Bar, Curve, Limit, Panel, over_cycle
from reports.svg import COLOURS, colour_variables

from .. import chart_results as made
from .. import results
from .read import column, cursor, texts

KEYS = {"haigh", "sn", "buckling", "ladder", "convergence"}


def test_a_whole_result_has_every_chart(charts):
    assert set(charts) == KEYS | {"loads", "drive", "peaks"}
    for chart in charts.values():
        assert chart.title
        assert chart.caption
        assert chart.rows


def test_two_calls_draw_the_same_bytes(charts):
    result = made.design()
    again = part_charts(result.parts[0], result).charts
    assert [chart.svg for chart in again] == [charts[chart.key].svg for chart in again]
    ((_, cycle),) = cycle_charts(result)
    assert list(cycle.charts) == [charts[chart.key] for chart in cycle.charts]


def test_every_colour_follows_the_page_and_nothing_comes_from_outside(charts):
    for chart in charts.values():
        outside = re.sub(r"var\(--[^)]*\)", "", chart.svg)
        assert re.findall(r"#[0-9a-f]{6}\b", outside) == []
        used = set(re.findall(r"--chart-(\w+)", chart.svg))
        assert used <= set(COLOURS)
        assert all(f"--chart-{name}:" in colour_variables(dark=True) for name in used)
        assert "metadata" not in chart.svg
        assert set(re.findall(r"(?:href=|url\()[\"']?(.)", chart.svg)) <= {"#"}
        assert "DejaVu" not in chart.svg


def test_pictures_have_a_name_and_ids_of_their_own(charts):
    seen = []
    for chart in charts.values():
        root = ET.fromstring(chart.svg)
        assert root.get("role") == "img"
        assert root.get("aria-label")
        seen += re.findall(r"\bid=\"([^\"]+)\"", chart.svg)
    assert len(seen) == len(set(seen))


def test_axes_have_units_and_lines_their_names(charts):
    expected = {
        "loads": {"x [mm]", "resultant force [kN]"},
        "drive": {"force [kN]", "power [W]", "cylinder", "process"},
        "peaks": {"von Mises [MPa]", "bar_upper: 355 MPa / 1.5"},
        "haigh": {"mean stress [MPa]", "stress amplitude [MPa]", "Goodman", "Goodman / 1.3",
                  "first yield"},
        "sn": {"cycles in the life [–]", "S-N line", "endurance limit", "loads × 1.3"},
        "buckling": {"axial stress [MPa]", "yield", "Johnson", "Euler", "λ = 108"},
        "ladder": {"time [s]", "limit", "static", "fatigue", "formula 0.020 s", "solid 12 s"},
        "convergence": {"peak von Mises stress [MPa]", "30\u2009123"},
    }  # fmt: skip
    for key, wanted in expected.items():
        assert wanted <= set(texts(charts[key].svg)), key


def test_a_panel_has_0_and_its_bars_in_sight_and_limits_that_are_not_far_away():
    pushed = Curve("pushed", np.array([-30.0, -10.0, np.nan]))
    low, high = Panel("force", "N", [pushed]).span
    assert low < -30
    assert high >= 0
    bar = Bar(0, 0, below=20.0, above=45.0)
    low, high = Panel("force", "N", [pushed], bars=[bar]).span
    assert low < -50
    assert high > 15
    pulled = Curve("pulled", np.array([10.0, 30.0]))
    low, high = Panel("force", "N", [pulled], [Limit(80.0, "near"), Limit(100.0, "far")]).span
    assert low == 0
    assert 80 < high < 100


def test_phases_are_named_and_the_short_one_is_as_wide_as_its_positions(charts):
    assert {"approach", "press", "return"} <= set(texts(charts["loads"].svg))
    line = cursor(charts["loads"])["line"]
    ends = [line["x"][line["at"].index(k)] for k in (61, 121)]
    wide = line["x"][-1] - line["x"][0]
    assert ends[1] - ends[0] > 0.3 * wide  # 5 mm of 391 mm
    assert line["x"] == sorted(line["x"])


@pytest.mark.parametrize("n", [4, 61, 1200])
def test_what_the_cursor_reads_off_a_thinned_curve_is_the_curve(n):
    """Within a thousandth of the panel's height, and the extremes exactly; 12 to 3600 positions."""
    result = made.design(n)
    ((_, found),) = cycle_charts(result)
    drive = next(chart for chart in found.charts if chart.key == "drive")
    data, whole = cursor(drive), result.cycles["press"]
    rows = dict(zip(["cylinder", "process"], data["rows"][:2], strict=True))
    for name, row in rows.items():
        values = np.array(whole["efforts"][name]) * 1e-3
        read = np.interp(np.arange(3 * n), row["at"], row["value"])
        low, _, high, _ = row["scale"]
        assert np.abs(read - values).max() <= 1.2e-3 * (high - low)
        assert_allclose([max(row["value"]), min(row["value"])], [values.max(), values.min()],
                        atol=1e-3)  # fmt: skip
    assert sum(len(chart.svg) for chart in found.charts) < 45_000


@pytest.mark.parametrize(
    ("position", "phase", "told"),
    [
        ([0.0, 1.0, 2.0, 200.0], ["a", "a", "b", "b"], True),
        ([0.0, 1.0, 2.0, 3.0], ["a", "a", "b", "b"], False),
        ([0.0, 1.0, 2.0, 200.0], ["a"] * 4, False),
        ([0.0, 1.0, 5.0], ["a", "a", "dwell"], True),
    ],
)
def test_phases_of_different_scales_are_told(position, phase, told):
    cycle = {"position": position, "phase": phase, "links": {"eye": [1.0] * len(position)}}
    ((_, found),) = cycle_charts(results.design(cycles={"run": cycle}))
    assert ("each phase has its own scale" in found.charts[0].caption) is told


def test_loads_that_are_alike_are_one_curve_and_all_stand_in_the_table():
    result = made.design()
    links = result.cycles["press"]["links"]
    same = np.array(links["bar_upper knee"]) * 1.004
    loads = {"bar_upper knee": links["bar_upper knee"], "pin_B upper": same}
    cycles = {"press": result.cycles["press"] | {"links": loads}}
    ((_, found),) = cycle_charts(replace(result, cycles=cycles))
    chart = next(c for c in found.charts if c.key == "loads")
    assert len(chart.series) == 1
    assert {"bar_upper knee", "pin_B upper"} == set(chart.series[0].name.split(", "))
    assert {"bar_upper knee [kN]", "pin_B upper [kN]"} <= set(chart.columns)


def test_works_stand_beside_the_areas_under_the_powers(charts):
    caption = charts["drive"].caption
    assert "agree with these works within 0.001 %" in caption
    assert "Power above 0 drives the linkage" in caption
    wrong = made.cycle()
    wrong["works"] = {name: 2.0 * work for name, work in wrong["works"].items()}
    result = replace(made.design(), cycles={"press": wrong})
    ((_, found),) = cycle_charts(result)
    told = next(c for c in found.charts if c.key == "drive").caption
    share = float(re.search(r"within ([\d.e+]+) %", told)[1])
    assert share > 10


def test_the_table_of_a_cycle_has_the_extremes(charts):
    chart = charts["peaks"]
    assert sum(cell.endswith("▲") for cell in column(chart, "bar_upper [MPa]")) == 1
    top = next(c for c in column(chart, "bar_upper [MPa]") if c.endswith("▲"))
    assert_allclose(float(top.split()[0]), max(made.cycle()["peaks"]["bar_upper"]), rtol=1e-3)
    assert 13 <= len(chart.rows) <= 30


def test_the_bar_of_the_static_check_is_drawn_only_on_its_own_curve():
    result = made.design()
    peak = float(np.max(result.cycles["press"]["peaks"]["bar_upper"]))
    own = made.part()
    same = replace(own, checks=[replace(own.checks[0], value=peak)])
    for part, told in ((same, "Bars: error of the static check's value"), (own, "another model")):
        ((_, found),) = cycle_charts(replace(result, parts=[part]))
        assert told in next(c for c in found.charts if c.key == "peaks").caption


def test_the_bar_of_the_peak_reaches_as_far_down_as_the_check_says_and_the_limit_is_allowed(
    monkeypatch,
):
    panels, draw = [], over_cycle

    def noted(label, axis, given):
        panels.extend(given)
        return draw(label, axis, given)

    monkeypatch.setattr("reports.charts.cycles.over_cycle", noted)
    peaks = np.asarray(made.cycle()["peaks"]["bar_upper"])
    static = replace(results.PASSING, kind="static", part="bar_upper", cycle="press", unit="MPa",
                     value=float(peaks.max()), numerical=2.0, model=30.0, model_below=5.0,
                     limit=300.0, required=1.5)  # fmt: skip
    part = results.part(name="bar_upper", checks=[static])
    cycle_charts(results.design(part, cycles={"press": made.cycle()}))
    (panel,) = (one for one in panels if one.quantity == "von Mises")
    (bar,) = panel.bars
    assert (bar.below, bar.above) == (7.0, 32.0)
    assert bar.index == peaks.argmax()
    assert [limit.value for limit in panel.limits] == [200.0]


def test_a_mean_power_is_the_work_over_the_time_of_the_cycle():
    """8400 N mm in 4.2 s."""
    cycle = made.cycle() | {"works": {"cylinder": -8400.0, "process": 8400.0}}
    assert cycle["time"][-1] == 4.2
    charts = cycle_charts(replace(made.design(), cycles={"press": cycle}))[0][1].charts
    told = next(chart for chart in charts if chart.key == "drive").caption
    assert "process: work 8.40 J, mean power 2.00 W." in told


def test_what_is_missing_is_told_in_words():
    bare = results.part(charts={}, meshes=[])
    found = part_charts(bare, results.design(bare))
    assert not found
    assert {item.key for item in found.missing} == KEYS
    reasons = " ".join(why for why, _ in found.reasons)
    for words in ("no cycle of the duty", "no mesh was solved", "no model was tried"):
        assert words in reasons
    ((_, cycle),) = cycle_charts(results.design(cycles={"idle": {"position": [], "phase": []}}))
    assert not cycle
    assert cycle.reasons[0][0] == "the cycle has no positions"
    measured = {"position": [0.0, 1.0], "links": {"a": [1.0, 2.0]}}
    ((_, run),) = cycle_charts(results.design(cycles={"run": measured}))
    assert [chart.key for chart in run.charts] == ["loads"]


def test_gaps_and_odd_values_are_drawn():
    gaps = made.cycle()
    values = np.array(gaps["peaks"]["bar_upper"])
    values[70:80] = np.nan
    gaps["peaks"] = {"bar_upper": values, "pin_B": [None] * 183}
    ((_, found),) = cycle_charts(replace(made.design(), cycles={"press": gaps}))
    chart = next(c for c in found.charts if c.key == "peaks")
    row = cursor(chart)["rows"][0]
    assert row["value"][row["at"].index(70)] is None
    assert row["value"][row["at"].index(79)] is None
    assert row["value"][row["at"].index(80)] is not None
    single = {"position": [1.0], "phase": ["all"], "peaks": {"bar_upper": [5.0]}}
    ((_, one),) = cycle_charts(replace(made.design(), cycles={"press": single}))
    assert one.charts


def test_a_place_that_is_passed_twice_in_a_phase_is_shown_over_time():
    there_and_back = {"position": [0.0, 1.0, 0.0], "time": [0.0, 1.0, 2.0],
                      "links": {"a": [1.0, 2.0, 1.0]}}  # fmt: skip
    ((_, found),) = cycle_charts(results.design(cycles={"swing": there_and_back}))
    assert "time [s]" in texts(found.charts[0].svg)
    ((_, untimed),) = cycle_charts(results.design(cycles={"swing": there_and_back | {"time": []}}))
    assert "number of the position [–]" in texts(untimed.charts[0].svg)


def test_hostile_names_stay_text():
    hostile = results.hostile()
    for _, found in cycle_charts(hostile):
        for chart in found.charts:
            assert "<script" not in chart.svg
            ET.fromstring(chart.svg)
    bad = replace(made.part(), name=results.HOSTILE)
    for chart in part_charts(bad, hostile).charts:
        assert "<script" not in chart.svg
        ET.fromstring(chart.svg)
