import csv
from io import StringIO

import numpy as np
import pytest

from reports.loads_summary import loads_csv

from . import loads_results


@pytest.fixture(scope="module")
def cycle():
    return loads_results.press(mu_pin=0.1, mu_guide=0.1)


@pytest.fixture(scope="module")
def rows(cycle):
    return list(csv.DictReader(StringIO(loads_csv([cycle]))))


def test_every_column_has_its_unit(rows):
    columns = list(rows[0])
    assert columns[:5] == ["cycle", "phase", "time [s]", "coordinate", "position [mm]"]
    assert all(name.endswith("]") for name in columns[4:])
    assert len(columns) == len(set(columns))
    for name in (
        "lower.angle [rad]", "lower.omega [rad/s]", "mould.ay [mm/s2]", "upper.centre.ax [mm/s2]",
        "A.Fx [N]", "A.friction_couple [N mm]", "guide.M [N mm]", "guide.friction_force [N]",
        "lower@B.Fx [N]", "cylinder.effort [N]",
    ):  # fmt: skip
        assert name in columns


def test_a_row_holds_every_digit_of_the_solution(cycle, rows):
    """Round trip: what is read back is the very number."""
    loads = cycle.loads
    assert len(rows) == len(loads.times)
    for index in (0, 150, 361):
        row = rows[index]
        lower = loads.body_index("lower")
        assert float(row["time [s]"]) == loads.times[index]
        assert float(row["position [mm]"]) == cycle.shown[index]
        assert row["phase"] == cycle.phase_at(index)
        assert float(row["lower.angle [rad]"]) == loads.poses[index, lower, 2]
        assert float(row["lower.alpha [rad/s2]"]) == loads.accelerations[index, lower, 2]
        assert float(row["B.Fy [N]"]) == loads.reactions["B"].force[index, 1]
        assert float(row["guide.M [N mm]"]) == loads.reactions["guide"].moment[index]
        assert float(row["process.effort [N]"]) == loads.efforts["process"][index]


def test_the_columns_of_a_body_are_in_equilibrium(cycle, rows):
    """Newton: what acts at the points of a bar and its weight accelerate its centre."""
    body = cycle.loads.linkage.body("lower")
    column = {name: np.array([float(row[name]) for row in rows]) for name in list(rows[0])[4:]}
    for axis, weight in (("x", 0.0), ("y", -9810.0 * body.mass)):
        acting = column[f"lower@C.F{axis} [N]"] + column[f"lower@B.F{axis} [N]"]
        inertia = body.mass * column[f"lower.centre.a{axis} [mm/s2]"]
        scale = np.abs(column[f"lower@B.F{axis} [N]"]).max()
        np.testing.assert_allclose(acting + weight, inertia, rtol=0, atol=1e-9 * scale)


def test_cycles_with_other_friction_share_one_table(cycle):
    rows = list(csv.DictReader(StringIO(loads_csv([loads_results.press(), cycle]))))
    friction = [row["A.friction_couple [N mm]"] for row in rows]
    assert any(friction)
    assert len(rows) > len(cycle.shown)


def test_a_torque_that_enters_at_no_point_is_the_body_s_own():
    cycle = loads_results.crank(point=None)
    rows = list(csv.DictReader(StringIO(loads_csv([cycle]))))
    torque = [float(row["crank.M [N mm]"]) for row in rows]
    np.testing.assert_array_equal(torque, cycle.loads.efforts["drive"])
    assert not any("nowhere" in name for name in rows[0])
