"""Charts of a result: what they draw, what stands behind them, and what they leave out."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.column_curves import eurocode_stress, perry_robertson
from reports.charts import cycle_charts, part_charts
from reports.charts.buckling import column_curves
from reports.charts.haigh import utilisation
from reports.charts.over_cycle import Bar, Curve, Limit, Panel, over_cycle
from reports.charts.plane import Plane
from reports.charts.sn import reversed_amplitude
from reports.svg import COLOURS, colour_variables

from . import chart_results as made
from . import results

KEYS = {"haigh", "sn", "buckling", "ladder", "convergence"}


@pytest.fixture(scope="module")
def charts():
    """Every chart of the made-up press, by its key."""
    result = made.design()
    found = [*part_charts(result.parts[0], result).charts]
    found += [chart for _, own in cycle_charts(result) for chart in own.charts]
    return {chart.key: chart for chart in found}


def texts(svg):
    return [
        "".join(node.itertext()) for node in ET.fromstring(svg).iter() if node.tag.endswith("text")
    ]


def cursor(chart):
    return json.loads(ET.fromstring(chart.svg).get("data-cursor"))


def column(chart, name):
    return [row[chart.columns.index(name)] for row in chart.rows]


@pytest.fixture
def drawn(monkeypatch):
    """Return what draws a chart of a made-up part, and gives the lines (k, 2) on it."""
    lines, line = [], Plane.line

    def noted(self, points, **style):
        lines.append(np.asarray(points, dtype=float).reshape(-1, 2))
        return line(self, points, **style)

    monkeypatch.setattr(Plane, "line", noted)

    def draw(key, **data):
        result = made.design(**data)
        lines.clear()
        wanted = next(c for c in part_charts(result.parts[0], result).charts if c.key == key)
        assert wanted.svg
        return list(lines)

    return draw


def has_line(lines, points):
    wanted = np.array(points, dtype=float)
    return any(one.shape == wanted.shape and np.allclose(one, wanted) for one in lines)


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
        "buckling": {"axial stress [MPa]", "yield", "Johnson", "Euler", "Perry-Robertson",
                     "a0", "a", "b", "c", "d", "λ = 108"},
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


def test_the_haigh_path_ends_in_the_critical_point_with_its_utilisation(charts):
    data = cursor(charts["haigh"])
    use = data["rows"][2]
    assert_allclose(max(use["value"]), 35 / 150 + 40 / 470, atol=1e-4)
    assert min(use["value"]) == 0
    (path,) = data["dots"]
    k = int(np.argmax(use["value"]))
    assert path["at"][k] == 91
    assert path["x"][k] == max(path["x"])
    assert path["y"][k] == min(path["y"])  # up is less
    assert "safety 3.14" in " ".join(texts(charts["haigh"].svg))


def test_the_haigh_diagram_has_the_required_safety_below_its_limit_and_the_ray_up_to_it(drawn):
    """Required is 1.3 on all loads; Goodman: 35/150 + 40/470 of what the point may have."""
    lines = drawn("haigh")
    assert has_line(lines, [[0, 150], [470, 0]])
    assert has_line(lines, [[0, 150 / 1.3], [470 / 1.3, 0]])
    used = 35 / 150 + 40 / 470
    assert has_line(lines, [[40, 35], [40 / used, 35 / used]])


def test_the_haigh_table_ends_the_ray_on_the_line(charts):
    (end,) = (row for row in charts["haigh"].rows if row[0] == "end of the ray")
    mean, amplitude, used = map(float, end[1:])
    assert used == 1.0
    assert amplitude / 150 + mean / 470 == pytest.approx(1.0, abs=0.005)
    assert mean / amplitude == pytest.approx(40 / 35, rel=0.01)


def test_the_haigh_diagram_says_which_rule_decides_where_it_is_not_goodman():
    result = made.design(haigh=made.haigh(183) | {"criterion": "Findley"})
    found = part_charts(result.parts[0], result).charts
    shown = " ".join(texts(next(c for c in found if c.key == "haigh").svg))
    assert "safety 3.14 by Goodman (Findley decides: 3.94)" in shown  # 150 / 38, rounded down


def test_a_limit_that_a_notch_lowers_is_told_with_its_factor(charts):
    lowered = {"away": 195.0}
    result = made.design(haigh=made.haigh(183) | lowered, sn=made.sn(**lowered))
    found = {chart.key: chart for chart in part_charts(result.parts[0], result).charts}
    for key in ("haigh", "sn"):
        told = "by the notch or fretting factor at this place: 195 MPa / 1.3 = 150 MPa"
        assert told in found[key].caption
        assert "factor" not in charts[key].caption


def test_a_metal_without_an_endurance_limit_has_a_strength_at_its_knee():
    """The line's knee in the data is at 10⁶ cycles."""
    result = made.design(sn=made.sn(endless=False))
    found = part_charts(result.parts[0], result).charts
    chart = next(each for each in found if each.key == "sn")
    assert "strength at 10⁶ cycles decides, not the line" in chart.caption
    assert chart.rows[0][0] == "strength at 10⁶ cycles"
    assert "strength at 10⁶ cycles" in texts(chart.svg)
    told = " ".join([chart.caption, *texts(chart.svg), *map(" ".join, chart.rows)])
    assert "endurance limit" not in told


def test_the_utilisation_by_fkms_line_is_that_of_its_ray():
    data = made.fkm(9)
    points = np.array([[0.0, 75.0], [67.5, 67.5], [300.0, 30.0]])
    assert_allclose(utilisation(data, points), [0.5, 0.5, 30 / (0.8 * 150)])


def test_a_part_of_fkms_chain_has_fkms_line_and_no_goodman():
    result = made.design(haigh=None, fkm=made.fkm(183), sn=made.sn(chain="FKM", damage=None))
    found = {chart.key: chart for chart in part_charts(result.parts[0], result).charts}
    shown = texts(found["haigh"].svg)
    assert "FKM" in shown
    assert not any("Goodman" in text for text in shown)
    assert "guideline's line" in found["sn"].caption


def test_the_duty_stands_on_the_s_n_line_as_often_as_it_runs(charts):
    chart = charts["sn"]
    assert "1.1·10⁷ × 38.3 MPa" in texts(chart.svg)
    assert "endurance limit decides, not the line" in chart.caption
    assert "1 kind of cycle is too small" in chart.caption
    use = cursor(chart)["rows"][0]
    assert_allclose(max(use["value"]), 35 / (1 - 40 / 470), atol=0.01)


def test_the_required_safety_lifts_a_cycle_from_its_own_amplitude(drawn):
    equivalent = 35 / (1 - 40 / 470)
    lines = drawn("sn")
    assert has_line(lines, [[1.1e7, equivalent], [1.1e7, 1.35 * equivalent]])
    assert has_line(lines, [[1.1e7, 1.35 * equivalent]])


def test_by_fkm_a_position_s_reversed_amplitude_is_its_use_of_the_limit():
    points = np.array([[0.0, 75.0], [67.5, 67.5], [300.0, 30.0]])
    found = reversed_amplitude(made.fkm(9), made.sn(limit=150.0), points)
    assert_allclose(found, [75.0, 75.0, 37.5])


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"why": "no S-N line: too high", "line": [], "below": []}, "No S-N line: too high"),
        ({"damage": 0.4, "cycles": [[1e5, 200.0, 0.4, 270.0]]}, "Miner's sum of the life is 0.4"),
        ({"endless": False}, "infinite life"),
        ({"cycles": [[1e7, 1.0, 0.0, 1.3]]}, "too small for the chart"),
        ({"cycles": [[1e7, 300.0, 0.0, None]]}, "infinite life"),
    ],
)
def test_other_duties_are_drawn_and_told(changes, told):
    result = made.design(sn=made.sn(**changes))
    chart = next(c for c in part_charts(result.parts[0], result).charts if c.key == "sn")
    assert told in chart.caption
    ET.fromstring(chart.svg)


def test_column_curves_are_those_of_the_handbooks():
    """At slenderness 80 of S355: Euler 323.8 MPa; Johnson meets Euler at half the yield stress."""
    curves = column_curves(made.column())
    euler = np.pi**2 * 210e3 / 80**2
    assert_allclose(curves["Euler"](80), euler)
    assert_allclose(curves["Perry-Robertson"](80), perry_robertson(euler, 355.0, 0.24))
    assert_allclose(curves["Eurocode 3 c"](80), eurocode_stress(euler, 355.0, "c"))
    transition = np.pi * np.sqrt(2 * 210e3 / 355)
    assert_allclose([curves["Johnson"](transition), curves["Euler"](transition)], 355 / 2)
    assert np.isnan(curves["Johnson"](transition + 1))
    names = ["a0", "a", "b", "c", "d"]
    values = [curves[f"Eurocode 3 {name}"](80) for name in names]
    assert values == sorted(values, reverse=True)


def test_a_stated_crookedness_has_a_curve_for_each_plane():
    planes = made.column()["planes"]
    stated = made.column(planes=[planes[0] | {"eta": 0.3}, planes[1]])
    curves = column_curves(stated)
    euler = np.pi**2 * 210e3 / 50**2
    assert_allclose(curves["Perry-Robertson in plane"](50), perry_robertson(euler, 355.0, 0.3))
    out = curves["Perry-Robertson out of plane"](50)
    assert_allclose(out, perry_robertson(euler, 355.0, 0.15))


def test_the_column_moves_with_the_compression(charts):
    first, second = cursor(charts["buckling"])["rows"]
    assert second["as"] == 0  # the same section
    assert_allclose(max(first["value"]), 60.0)
    assert first["x"] < second["x"]
    assert "safety 5.50" in " ".join(texts(charts["buckling"].svg))


def test_the_column_s_mark_is_what_the_required_safety_leaves_of_its_limit(drawn):
    lines = drawn("buckling")
    assert has_line(lines, [[40, 330 / 3]])
    assert has_line(lines, [[40, 60], [40, 330]])


def test_the_table_of_column_curves_has_the_safety_by_each(charts):
    chart = charts["buckling"]
    (row,) = (row for row in chart.rows if row[0].startswith("safety in plane"))
    euler = np.pi**2 * 210e3 / 40**2
    shown = dict(zip(chart.columns, row, strict=True))
    assert float(shown["yield [MPa]"]) == pytest.approx(355 / 60, abs=0.005)
    assert float(shown["Euler [MPa]"]) == pytest.approx(euler / 60, abs=0.005)


def test_the_ladder_tells_what_was_taken_and_what_was_passed_over(charts):
    chart = charts["ladder"]
    taken = {(row[0], row[3]) for row in chart.rows if row[7] == "yes"}
    assert taken == {("solid", "static"), ("solid", "fatigue")}
    assert "Passed over: beam, there is no beam of this shape." in chart.caption
    assert "Dotted: no error bar." in chart.caption
    assert any("±∞" in cell for cell in column(chart, "value ± bar"))


def test_convergence_is_of_the_stress_that_governs(charts):
    assert "peak von Mises stress [MPa]" in texts(charts["convergence"].svg)
    rows = [row for row in charts["convergence"].rows if row[0] == "static"]
    assert [row[4] for row in rows] == ["–", "4.00"]  # the check's, not the mesh's alone
    assert rows[1][5] == "2.17 %"


@pytest.mark.parametrize(
    ("halves", "axis", "points"),
    [
        ((False, False), "unknowns of the mesh [–]", {"138.0", "141.0"}),
        ((True, True), "unknowns of the mesh, of half of the part [–]", {"138.0", "141.0"}),
        ((False, True), "unknowns of the mesh [–]", {"138.0", "141.0, half of the part"}),
    ],
)
def test_convergence_says_which_meshes_are_half_of_the_part(halves, axis, points):
    meshes = [
        entry | {"half": half}
        for entry, half in zip(made.CONVERGENCE["static"], halves, strict=True)
    ]
    result = made.design(convergence={"static": meshes})
    found = part_charts(result.parts[0], result).charts
    chart = next(each for each in found if each.key == "convergence")
    assert {axis, *points} <= set(texts(chart.svg))
    assert column(chart, "unknowns") == ["30123", "81234"]  # as in the tables, not twice
    whole = {False: "the part", True: "half of the part"}
    assert column(chart, "mesh of") == [whole[half] for half in halves]


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
