"""Data of the charts, against the checks and the loads."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fatigue
from ballesta import run
from ballesta.pipeline import check_design, check_file
from checks.design.effort import Effort
from checks.ladder import chart_data
from checks.result.formulas import evaluate
from reports.charts.haigh import utilisation

from ...small_machine import MACHINE, PLATE, machine

HEAVY = 'cycles.turn.phases[0].forces.push="36000 N"'
FORMULA = Effort("formula")


def result_of(folder, *overrides, effort=FORMULA, text=PLATE):
    path = folder / "machine.toml"
    path.write_text(MACHINE + text, encoding="utf-8")
    return check_file(path, ['accuracy="50 %"', *overrides], effort=effort)


@pytest.fixture(scope="module")
def light(tmp_path_factory):
    return result_of(tmp_path_factory.mktemp("light"))


@pytest.fixture(scope="module")
def meshed(tmp_path_factory):
    """As a solid by FKM's chain, on coarse meshes."""
    folder = tmp_path_factory.mktemp("meshed")
    return result_of(folder, 'parts.rod.strength="fkm"', effort=Effort("solid"))


def check_of(result, kind, quantity=""):
    return next(c for c in result.checks if c.kind == kind and quantity in c.quantity)


def test_the_curve_of_the_peaks_has_the_value_of_the_static_check(light):
    charts = light.parts[0].charts
    check = check_of(light, "static")
    assert charts["by"] == check.method == "formula"
    assert_allclose(max(charts["peaks"]["turn"]), check.value, rtol=1e-12)


def test_the_path_in_haighs_diagram_ends_in_the_critical_point_and_nowhere_beyond(light):
    haigh = light.parts[0].charts["haigh"]
    path = np.array([haigh["paths"]["turn"][key] for key in ("mean", "amplitude")]).T
    point = [haigh["mean"], haigh["amplitude"]]
    far = np.abs(path - point).max(axis=1)
    assert far.min() < 1e-9 * haigh["amplitude"]
    assert path[:, 1].max() <= haigh["amplitude"] * (1 + 1e-9)
    check = check_of(light, "fatigue")
    assert check.quantity.startswith("Goodman")
    used = haigh["amplitude"] / haigh["endurance"] + haigh["mean"] / haigh["ultimate"]
    assert_allclose(used, 1 / check.safety, rtol=1e-9)


def test_the_path_in_haighs_diagram_begins_where_the_deciding_pair_is_stressed_less(light):
    derivation = check_of(light, "fatigue").derivation
    stress = {s: evaluate(f"von_mises({s})", derivation.values) for s in ("s_1", "s_2")}
    assert abs(stress["s_1"] - stress["s_2"]) > 0.01 * max(stress.values())
    index = {case.symbol: case.index for case in derivation.cases}
    haigh = light.parts[0].charts["haigh"]
    amplitude = np.array(haigh["paths"]["turn"]["amplitude"])
    first, last = sorted(stress, key=lambda symbol: stress[symbol])
    assert amplitude[index[first]] == pytest.approx(0.0, abs=1e-9 * haigh["amplitude"])
    assert amplitude[index[last]] == pytest.approx(haigh["amplitude"])


def test_a_swing_in_compression_has_no_mean():
    """From nothing to 60 MPa of push, and of pull: half of it is the amplitude."""
    pushed = np.zeros((6, 2))
    pushed[:3, 0], pushed[0, 1] = (-60.0, -80.0, -90.0), 60.0
    swings = chart_data._swings(pushed, np.zeros(6))
    assert swings["mean"] == pytest.approx([0.0, 30.0])
    assert swings["amplitude"][1] == pytest.approx(30.0)


def test_powers_integrate_to_the_works_and_a_closed_cycle_without_friction_gives_all_back(light):
    """25 positions: trapezoids of power over time against effort over way; 3 % of the turnover."""
    cycle = light.cycles["turn"]
    time = np.array(cycle["time"])
    works = cycle["works"]
    turnover = 0.0
    for name, power in cycle["powers"].items():
        power = np.array(power)
        area = float(np.trapezoid(power, time))
        turnover = max(turnover, float(np.trapezoid(np.abs(power), time)))
        assert_allclose(area, works[name], atol=0.03 * turnover)
    assert turnover > 0
    assert abs(sum(works.values())) < 0.03 * turnover


def test_the_power_is_effort_times_rate_with_the_sign_of_what_drives(light):
    """The crank turns at 10 rad/s, so the drive's power is ten times its torque."""
    cycle = light.cycles["turn"]
    assert_allclose(cycle["powers"]["drive"], 10 * np.array(cycle["torques"]["drive"]), rtol=1e-9)


def test_where_no_cycle_exceeds_the_endurance_limit_no_cycle_does_damage(light):
    sn = light.parts[0].charts["sn"]
    assert sn["damage"] == 0
    assert {harm for _, _, harm, _ in sn["cycles"]} == {0.0}
    assert sn["limit"] == light.parts[0].charts["haigh"]["endurance"]


def test_both_diagrams_tell_the_limit_away_from_notches_that_the_check_states(light):
    away = check_of(light, "fatigue").limit
    for key in ("haigh", "sn"):
        assert light.parts[0].charts[key]["away"] == away


def test_damages_of_the_listed_cycles_add_up_to_miners_sum(tmp_path):
    result = result_of(tmp_path, HEAVY, 'duty.life="finite"', "duty.cycles.turn=1e4")
    sn = result.parts[0].charts["sn"]
    assert sn["damage"] > 0
    total = sum(harm for _, _, harm, _ in sn["cycles"]) + sn["left_damage"]
    assert_allclose(total, sn["damage"], rtol=1e-12)
    (first, start), (knee, limit) = sn["line"]
    assert (first, knee, limit) == (1e3, 1e6, sn["limit"])
    count, amplitude, harm, _ = sn["cycles"][0]
    slope = np.log(knee / first) / np.log(start / limit)
    assert limit < amplitude < start
    assert_allclose(harm, count / (knee * (amplitude / limit) ** -slope), rtol=1e-9)


def test_below_its_knee_the_line_falls_as_haibach_has_it(tmp_path):
    """With the slope 2 k - 1, a thousand times as many cycles on."""
    sn = result_of(tmp_path, HEAVY).parts[0].charts["sn"]
    (first, start), (knee, limit) = sn["line"]
    slope = np.log(knee / first) / np.log(start / limit)
    (at, same), (far, low) = sn["below"]
    assert (at, same, far) == (knee, limit, 1e3 * knee)
    assert_allclose(low, limit * 1e3 ** (-1 / (2 * slope - 1)), rtol=1e-9)


@pytest.mark.parametrize("listed", [0, 1])
def test_what_is_not_listed_of_a_duty_is_told_with_its_damage(tmp_path, monkeypatch, listed):
    monkeypatch.setattr(chart_data, "_MOST_CYCLES", listed)
    changes = (HEAVY, 'duty.life="finite"', "duty.cycles.turn=1e4")
    sn = result_of(tmp_path, *changes).parts[0].charts["sn"]
    assert len(sn["cycles"]) == listed
    own = sum(harm for _, _, harm, _ in sn["cycles"])
    assert_allclose(own + sn["left_damage"], sn["damage"], rtol=1e-12)
    if not listed:
        assert sn["left_damage"] > 0
        assert sn["left_out"] >= 1e4


def test_the_required_safety_lifts_a_cycle_by_more_than_itself_where_it_has_a_mean(light):
    """Goodman: n a/(1 - n m/S_u); the safety that just reaches the limit is the check's."""
    sn, haigh = (light.parts[0].charts[key] for key in ("sn", "haigh"))
    _, amplitude, _, raised = sn["cycles"][0]
    assert_allclose(amplitude, haigh["amplitude"] / (1 - haigh["mean"] / haigh["ultimate"]))
    n = sn["required"]
    expected = n * haigh["amplitude"] / (1 - n * haigh["mean"] / haigh["ultimate"])
    assert_allclose(raised, expected)
    assert raised > n * amplitude


def test_the_column_stands_where_its_checks_say(light):
    column = light.parts[0].charts["column"]
    for plane in column["planes"]:
        check = check_of(light, "buckling", f"column {plane['plane']}")
        assert_allclose([plane["stress"], plane["limit"]], [check.value, check.limit])
        assert f"slenderness {plane['slenderness']:.1f}" in check.basis
        below = 1 - (plane["stiffest"] < plane["slenderness"]) * check.below / check.value
        assert below <= 1
        force = np.array(column["force"]["turn"])
        assert_allclose(force.max() / plane["area"], plane["stress"])
    assert column["required"] == check.required


def test_the_stiffest_ends_of_a_column_clamp_the_part_itself(tmp_path):
    """A plate of 8 mm between forks: half of its 161 mm over t/sqrt(12), not the 400 mm stated."""
    result = result_of(tmp_path, text=PLATE + 'column = { out_of_plane = "400 mm" }\n')
    planes = {one["plane"]: one for one in result.parts[0].charts["column"]["planes"]}
    held = planes["out of plane"]
    assert check_of(result, "buckling", "column out of plane").below > 0
    assert_allclose(held["slenderness"], 400 / (8 / 12**0.5))
    assert_allclose(held["stiffest"], 0.5 * np.hypot(144, 72) / (8 / 12**0.5))


def test_a_part_without_a_duty_has_no_diagram_of_fatigue(tmp_path):
    charts = result_of(tmp_path, "duty.cycles={}").parts[0].charts
    assert {"haigh", "fkm", "sn"}.isdisjoint(charts)
    assert "peaks" in charts


def test_fkms_line_passes_where_its_safety_says_and_carries_no_goodman(meshed):
    charts = meshed.parts[0].charts
    assert "haigh" not in charts
    fkm, check = charts["fkm"], check_of(meshed, "fatigue")
    point = np.array([fkm["mean"], fkm["amplitude"]])
    line = np.array(fkm["line"])
    factor = fatigue.fkm_factor(point[1], point[0], fkm["sensitivity"])
    assert_allclose(factor * fkm["endurance"] / point[1], check.safety, rtol=1e-9)
    assert_allclose(line[0], [0.0, fkm["endurance"]])
    assert (np.diff(line[:, 0] / line[:, 1]) > 0).all()
    (cycle,) = charts["sn"]["cycles"]
    assert_allclose(charts["sn"]["limit"] / cycle[1], check.safety, rtol=1e-9)


def test_fkms_s_n_line_has_its_cycle_with_count_and_required_safety(meshed):
    sn = meshed.parts[0].charts["sn"]
    (cycle,) = sn["cycles"]
    count, amplitude, _, raised = cycle
    assert count == 1e6
    assert_allclose(raised, sn["required"] * amplitude)
    assert sn["required"] > 1.1
    assert_allclose(sn["line"][-1], [1e6, sn["limit"]])


def test_aluminium_endures_less_for_ever_than_at_the_knee_of_fkms_line(tmp_path):
    overrides = ('parts.rod.strength="fkm"', 'parts.rod.material="6082-T6"')
    sn = result_of(tmp_path, *overrides, effort=Effort("solid")).parts[0].charts["sn"]
    (_, _), (knee, at_knee) = sn["line"]
    (_, start), (far, low) = sn["below"]
    assert (start, far) == (at_knee, 1e3 * knee)
    assert sn["limit"] < 0.9 * at_knee
    assert low <= sn["limit"] * (1 + 1e-9)


def test_a_cloud_of_fkms_diagram_is_used_as_its_points_are_on_their_own_strength(tmp_path):
    design = machine(tmp_path, PLATE, 'accuracy="50 %"', 'parts.rod.strength="fkm"')
    (part,) = check_design(design, effort=Effort("solid"), live=True).parts
    fkm = part.charts["fkm"]
    shown = utilisation(fkm, np.array(fkm["cloud"]))
    known = np.unique(part.live.fatigue["utilisation"])
    nearest = known[np.clip(np.searchsorted(known, shown), 1, len(known) - 1)[:, None] - [0, 1]]
    assert (np.abs(nearest / shown[:, None] - 1).min(axis=1) < 1e-5).all()


def test_a_mesh_s_bar_is_of_the_meshes_up_to_it(monkeypatch):
    monkeypatch.setattr(chart_data, "mesh_bar", lambda what, levels: 0.1 * len(levels))
    levels = [SimpleNamespace(unknowns=k, half=False) for k in (10, 20, 30)]
    judged = {"static": SimpleNamespace(value=lambda level: float(level.unknowns))}
    meshes = chart_data.convergence_data(levels, judged)["static"]
    assert [mesh["bar"] for mesh in meshes] == [None, pytest.approx(4.0), pytest.approx(9.0)]


def test_convergence_ends_with_the_values_of_the_checks(meshed):
    part = meshed.parts[0]
    for kind, meshes in part.charts["convergence"].items():
        check = check_of(meshed, kind)
        assert_allclose(meshes[-1]["value"], check.value, rtol=1e-12)
        assert meshes[0]["bar"] is None
        assert 0 < meshes[-1]["bar"] <= check.numerical * (1 + 1e-12)
    own = [(mesh["unknowns"], mesh["body"] == "half") for mesh in part.meshes]
    assert [(m["unknowns"], m["half"]) for m in part.charts["convergence"]["static"]] == own


def test_the_data_of_the_charts_is_json(light, meshed):
    for result in (light, meshed):
        text = json.dumps(result.parts[0].charts, allow_nan=False)
        assert json.loads(text) == json.loads(json.dumps(result.to_dict()["parts"][0]["charts"]))


def test_without_a_line_the_reason_stands_and_the_cycles_are_listed(tmp_path, monkeypatch, light):
    """A limit above the strength at 1000 cycles leaves no line, but the same cycles."""
    why = "no S-N line: the endurance limit is too high"
    monkeypatch.setattr(chart_data, "why_no_curve", lambda *_, **__: why)
    sn = result_of(tmp_path).parts[0].charts["sn"]
    assert (sn["why"], sn["line"], sn["damage"]) == (why, [], None)
    known = light.parts[0].charts["sn"]["cycles"]
    assert_allclose(np.array(sn["cycles"], dtype=float), np.array(known, dtype=float))


def test_a_cycle_that_reaches_the_ultimate_strength_is_beyond_the_curve(tmp_path):
    """No finite number of such cycles does the damage, and no number stands for it."""
    changes = ('cycles.turn.phases[0].forces.push="1e9 N"', 'duty.life="finite"')
    charts = result_of(tmp_path, *changes).parts[0].charts
    sn = json.loads(json.dumps(charts["sn"], allow_nan=False))
    assert (sn["state"], sn["damage"]) == ("beyond the curve", None)
    assert None in [harm for _, _, harm, _ in sn["cycles"]]


def test_the_list_of_results_on_standard_output_is_json_whatever_the_load(
    tmp_path, capsys, monkeypatch
):
    """Infinities of charts and facts are null there, as in result.json."""
    written = []
    monkeypatch.setattr(run, "write_folder", lambda *given: written.append(given) or {})
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE + PLATE, encoding="utf-8")
    push = ['cycles.turn.phases[0].forces.push="-1e12 N"']
    code = run.check_all(
        [file], out=tmp_path / "out", as_json=True, overrides=push, fidelity="formula"
    )
    assert (code, len(written)) == (1, 1)
    (result,) = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert result["parts"][0]["charts"]["sn"]["state"] == "beyond the curve"
