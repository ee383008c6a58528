import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from reports import cycle_chart, haigh_chart, utilisation_chart
from reports.svg import COLOURS, colour_variables

from . import results

MAKERS = {
    "utilisation": lambda: utilisation_chart(results.mixed()),
    "cycle": lambda: cycle_chart("press", results.cycle()),
    "haigh": lambda: haigh_chart(results.part(), {"press": results.cycle()}),
}


def texts(svg):
    return [
        "".join(node.itertext()) for node in ET.fromstring(svg).iter() if node.tag.endswith("text")
    ]


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_two_calls_draw_the_same_bytes(make):
    assert make() == make()


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_every_colour_follows_the_page(make):
    svg = make()
    outside = re.sub(r"var\(--[^)]*\)", "", svg)
    assert re.findall(r"#[0-9a-f]{6}\b", outside) == []
    assert "--chart-ink" in svg
    used = set(re.findall(r"--chart-(\w+)", svg))
    assert used <= set(COLOURS)
    assert all(f"--chart-{name}:" in colour_variables(dark=True) for name in used)


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_a_chart_carries_no_date_and_asks_nothing_from_outside(make):
    svg = make()
    assert "metadata" not in svg
    assert set(re.findall(r"(?:href=|url\()[\"']?(.)", svg)) <= {"#"}
    assert "DejaVu" not in svg


def test_axes_have_units():
    cycle = texts(MAKERS["cycle"]())
    assert {"x [mm]", "force [kN]", "resultant [kN]", "von Mises [MPa]"} <= set(cycle)
    haigh = texts(MAKERS["haigh"]())
    assert {"mean stress [MPa]", "stress amplitude [MPa]", "time [s]"} <= set(haigh)


def test_the_cycle_chart_names_forces_joints_parts_and_phases():
    shown = texts(MAKERS["cycle"]())
    for name in ("cylinder", "process", "bar_upper knee", "pin_B", "approach", "press", "return"):
        assert name in shown


def test_the_short_phase_with_the_peak_is_enlarged():
    assert "Forces: phase “press”" in texts(MAKERS["cycle"]())
    single = results.cycle() | {"phase": ["all"] * 183}
    assert "Forces" in texts(cycle_chart("press", single))
    assert not any("phase “" in text for text in texts(cycle_chart("press", single)))


def test_every_check_has_its_bar_and_its_number():
    shown = texts(MAKERS["utilisation"]())
    for text in ("bar_upper fatigue", "pin_B static", "1.56", "0.60 ±∞"):
        assert text in shown


def test_a_hundredfold_utilisation_and_an_unloaded_part_are_drawn():
    checks = [
        results.check(value=9000.0),
        results.check(kind="idle", value=0.0, numerical=0.0, model=inf),
    ]
    shown = texts(utilisation_chart(results.design(results.part(checks=checks))))
    assert "38.03" in shown
    assert "0.00 ±∞" in shown


def test_nothing_to_draw_gives_no_chart():
    assert utilisation_chart(results.design(results.part(checks=[]))) == ""
    assert haigh_chart(results.part(charts={}), {}) == ""
    assert cycle_chart("idle", {"position": [], "phase": []}) == ""


def test_gaps_in_the_data_and_unmatched_times_are_drawn():
    gaps = results.cycle()
    gaps["peaks"] = {"bar_upper": [None] * 183, "pin_B": np.full(183, np.nan)}
    assert cycle_chart("press", gaps)
    assert "number of the position [–]" in texts(haigh_chart(results.part(), {}))


def test_the_haigh_diagram_draws_the_line_with_the_needed_safety():
    fatigue = replace(results.FAILING, required=1.3)
    assert "Goodman / 1.3" in texts(haigh_chart(results.part(checks=[fatigue]), {}))
    assert "Goodman / 1.3" not in texts(haigh_chart(results.part(), {}))


def test_hostile_names_stay_text():
    hostile = results.hostile()
    for name, cycle in hostile.cycles.items():
        svg = cycle_chart(name, cycle)
        assert "<script" not in svg
        ET.fromstring(svg)
    ET.fromstring(utilisation_chart(hostile))
    ET.fromstring(haigh_chart(hostile.parts[0], hostile.cycles))


def test_torques_stand_apart_from_forces_in_newton_metres():
    cycle = {"position": [0.0, 1.0], "torques": {"crank": [0.0, 2500.0]}}
    drawn = texts(cycle_chart("turn", cycle))
    assert "torque [N m]" in drawn
    assert "force [kN]" not in drawn
