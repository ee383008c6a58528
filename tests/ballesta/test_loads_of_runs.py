"""`ballesta loads` of measured runs: what acts on each body, and whether that balances."""

import csv
import json
import re
from io import StringIO

import numpy as np
import pytest

from ballesta.commands.loads_command import loads_of_file
from ballesta.design.read import read_design
from ballesta.machine.measured_balance import measured_loads
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.pipeline import check_file
from checks.design.errors import DesignError
from reports.loads_page import loads_html
from reports.loads_summary import loads_csv
from reports.loads_text import loads_text

from .test_measured_loads import MACHINE, MEASURED, SOLVED, TUBE, columns_of, csv_text, written

WITHOUT_TIME = MEASURED.replace('time = { column = "t", unit = "ms" }\n', "")


@pytest.fixture(scope="module")
def columns(tmp_path_factory):
    design = read_design(written(tmp_path_factory.mktemp("solved"), MACHINE + SOLVED))
    return columns_of(solve_cycles(design, {})["turn"])


@pytest.fixture
def folder(tmp_path, columns):
    (tmp_path / "motion.csv").write_text(csv_text(columns))
    return tmp_path


def test_the_extremes_are_those_of_the_file_as_they_act_on_the_body(folder, columns):
    """The file has the force at B by the rod, in kN: on it, it is the opposite."""
    result = loads_of_file(written(folder))
    (run,) = result.runs
    assert not result.cycles
    point = {(entry.body, entry.point): entry for entry in run.points}["rod", "B"]
    extremes = {entry.quantity: entry for entry in point.extremes}
    assert set(extremes) == {"Fx", "Fy", "|F|"}
    on_rod = -1e3 * columns["Bx"]
    assert extremes["Fx"].low == pytest.approx(on_rod.min())
    assert extremes["Fx"].high_at == pytest.approx(columns["phi"][on_rod.argmax()])
    mean = np.trapezoid(on_rod, columns["t"]) / columns["t"][-1]
    assert extremes["Fx"].mean == pytest.approx(mean)
    assert run.duration == pytest.approx(2 * np.pi / 60)
    assert result.gates[0].name == "run: balance of the loads on rod"


def test_the_run_is_shown_as_text_json_and_page(folder, command):
    file = written(folder)
    done = command("loads", str(file), "--plot", "--out", str(folder / "out"), out=folder)
    assert done.code == 0
    assert re.search(
        r"RUN run: measured in motion\.csv; 0\.1047 s, \d+ positions of crank angle \[deg\] "
        "from 0 to 360, in no duty",
        " ".join(done.stdout.split()),
    )
    assert re.search(r"^  rod +B +Fx +N ", done.stdout, re.M)
    assert "holds" in done.stdout
    page = (folder / "out" / "crank" / "loads.html").read_text()
    assert '<section id="run-1">' in page
    assert 'class="mechanism"' not in page
    assert "forces on the bodies" in page
    (run,) = json.loads(command("loads", str(file), "--json", out=folder).stdout)["runs"]
    assert run["name"] == "run"
    assert run["points"][0]["extremes"][0]["mean"] is not None


def test_loads_that_do_not_balance_are_refused_as_in_a_check(folder, command):
    file = written(folder, MACHINE + MEASURED.replace("sign = -1", "sign = 1"))
    done = command("loads", str(file), out=folder)
    assert done.code == 2
    assert done.stdout == ""
    with pytest.raises(DesignError) as refused:
        measured_loads(read_design(file), {})
    assert "reversing the force at B closes it" in str(refused.value)
    assert done.stderr.strip() == f"ballesta: {refused.value}"


def test_runs_and_cycles_are_named_alike(folder):
    file = written(folder, MACHINE + SOLVED + MEASURED)
    every = loads_of_file(file)
    assert [shown.name for shown in (*every.cycles, *every.runs)] == ["turn", "run"]
    alone = loads_of_file(file, cycles=["run"])
    assert (len(alone.cycles), len(alone.runs)) == (0, 1)
    assert not loads_of_file(file, cycles=["turn"]).runs
    with pytest.raises(DesignError, match=r"no cycle is named 'rum', did you mean run\?"):
        loads_of_file(file, cycles=["rum"])


def test_a_run_that_is_not_asked_for_may_be_out_of_balance(folder):
    file = written(folder, MACHINE + SOLVED + MEASURED.replace("sign = -1", "sign = 1"))
    assert [cycle.name for cycle in loads_of_file(file, cycles=["turn"]).cycles] == ["turn"]


def test_a_run_and_the_cycle_it_was_taken_from_agree_in_the_table(folder):
    """Written, read and written again; the units' conversions leave round-off."""
    result = loads_of_file(written(folder, MACHINE + SOLVED + MEASURED))
    rows = list(csv.DictReader(StringIO(loads_csv(result.cycles, result.runs))))
    solved = [row for row in rows if row["cycle"] == "turn"]
    measured = [row for row in rows if row["cycle"] == "run"]
    assert {row["phase"] for row in measured} == {"run"}
    both = [name for name in measured[0] if measured[0][name] and name.endswith("]")]
    assert "rod@B.Fx [N]" in both
    assert "rod.centre.ax [mm/s2]" in both
    for name in both:
        one, other = (np.array([float(r[name]) for r in group]) for group in (solved, measured))
        scale = max(np.abs(one).max(), 1e-9)
        if name.endswith(".M [N mm]"):  # the solved rod has rounding there
            scale = 1e3
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * scale)
    assert measured[0]["drive.effort [N mm]"] == ""


def test_without_times_there_is_no_mean_and_no_duration(folder):
    result = loads_of_file(written(folder, MACHINE + WITHOUT_TIME))
    assert "measured in motion.csv; without times" in loads_text(result, 100)
    assert "mean over time" not in loads_html(result)
    (row, *_) = csv.DictReader(StringIO(loads_csv([], result.runs)))
    assert row["time [s]"] == ""
    assert result.to_dict()["runs"][0]["points"][0]["extremes"][0]["mean"] is None


def test_only_parts_of_measured_bodies_are_meshed_for_their_mass(folder):
    said = []
    unmeasured = MACHINE.replace(
        'mass = "1.5 kg"\ninertia = "0.003 kg m2"\ncentre = "20, 0 mm"\n', ""
    )
    tube = TUBE.replace("CYCLE", "run").replace("rod_tube", "crank_tube")
    tube = tube.replace('body = "rod"', 'body = "crank"')
    tube = tube.replace('start = "A", end = "B"', 'start = "O", end = "A"')
    result = loads_of_file(written(folder, unmeasured + MEASURED + tube), say=said.append)
    assert said == []
    assert "crank_tube in run: motion.csv has no load on it" in result.absent


def test_an_acceleration_that_is_not_stated_is_told_in_the_diagnosis(folder):
    text = MEASURED.replace('acceleration = { columns = ["ax", "ay"], unit = "m/s2" }\n', "")
    text = text.replace('angular_acceleration = { column = "dw", unit = "rad/s2" }\n', "")
    with pytest.raises(
        DesignError,
        match="no acceleration is stated: taken as at rest; "
        "no angular_acceleration is stated: taken as 0",
    ):
        loads_of_file(written(folder, MACHINE + text))


@pytest.mark.parametrize("loads", [MEASURED, SOLVED])
def test_a_check_without_parts_says_that_there_is_nothing_to_check(folder, loads):
    with pytest.raises(DesignError, match=r"crank\.toml: parts: there are none to check"):
        check_file(written(folder, MACHINE + loads))


def test_a_design_that_does_nothing_is_refused(folder):
    with pytest.raises(DesignError, match="cycles: must be stated: what the machine does"):
        loads_of_file(written(folder, MACHINE))
