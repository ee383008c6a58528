"""Charts of a part: Haigh, S-N, column curves, ladder, convergence."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.handbook.column_curves import eurocode_stress
from reports.charts import part_charts
from reports.charts.buckling import column_curves
from reports.charts.haigh import utilisation
from reports.charts.sn import reversed_amplitude

from .. import chart_results as made
from .read import column, cursor, has_line, texts


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
        (
            {
                "damage": None,
                "state": "beyond the curve",
                "cycles": [[1e7, None, None, None], [1e5, 200.0, 0.4, 270.0]],
            },
            "beyond the curve",
        ),
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
    transition = np.pi * np.sqrt(2 * 210e3 / 355)
    assert_allclose([curves["Johnson"](transition), curves["Euler"](transition)], 355 / 2)
    assert np.isnan(curves["Johnson"](transition + 1))
    assert set(curves) == {"yield", "Johnson", "Euler"}
    stated = column_curves(made.column(curve="c"))
    assert_allclose(stated["Eurocode 3 c"](80), eurocode_stress(euler, 355.0, "c"))


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
    assert "Passed over: formula, there is no formula of this shape." in chart.caption
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


def test_convergence_of_a_part_without_load_is_drawn():
    meshes = [entry | {"value": 0.0, "bar": 0.0} for entry in made.CONVERGENCE["static"]]
    result = made.design(convergence={"static": meshes})
    found = part_charts(result.parts[0], result).charts
    assert {"convergence"} <= {chart.key for chart in found}
