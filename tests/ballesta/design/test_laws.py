"""Paces, force laws, contacts and elasticity in a design file: what is read, what is refused."""

# ruff: noqa: E501 - one refusal a line: the change of the file, then the wording

import math
import random
import re
from pathlib import Path

import numpy as np
import pytest

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of, solve_cycles
from ballesta.machine.warnings_of import stop_warnings
from ballesta.pipeline import _not_checked_here
from checks.design.errors import DesignError
from reports.mechanism_layout import Layout

DESIGNS = Path(__file__).parents[3] / "designs"
HAMMER = (DESIGNS / "spring_hammer.toml").read_text()
CRANK = (DESIGNS / "slider_crank.toml").read_text()
PRESS = (DESIGNS / "toggle_press.toml").read_text()
ALL = sorted(DESIGNS.glob("*.toml"))


def read(tmp_path, *changes, text=CRANK, overrides=()):
    """Read a design with pieces of its text exchanged."""
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    file = tmp_path / "machine.toml"
    file.write_text(text)
    return read_design(file, overrides)


def given(design, cycle, force):
    return design.cycles[cycle].run.phases[0].given[force]


STEADY = 'pace = { coordinate = "crank.angle", speed = "1 rad/s" }'
PUSH = 'push = "0 N"'


def test_a_pace_may_speed_up_or_follow_a_law(tmp_path):
    crank = loads.Angle("crank")
    up = read(tmp_path, ('speed = "1 rad/s"', 'speed = "60 rpm", acceleration = "-30 deg/s2"'))
    pace = up.cycles["bench"].run.pace
    assert isinstance(pace, loads.SteadyPace)
    assert pace.coordinate == crank
    assert (pace.speed, pace.acceleration) == pytest.approx((2 * math.pi, -math.pi / 6))
    law = read(tmp_path, ('speed = "1 rad/s"', 'law = "cycloidal", time = "1500 ms"'))
    assert law.cycles["bench"].run.pace == loads.StrokePace(crank, "cycloidal", 1.5)


def test_a_cylinder_fills_as_fast_as_its_flow(tmp_path):
    """108 l/min are 95.5 mm/s on the rod's side, 30 mm2 pi/4 (160^2 - 40^2), as it pulls."""
    flow = ('speed = "0.1 m/s"', 'flow = "108 l/min"')
    design = read(tmp_path, flow, text=PRESS)
    cycle = design.cycles["press"].run
    pulls = 1.8e6 / (math.pi / 4 * (160**2 - 40**2))
    assert cycle.pace.falling == pytest.approx(pulls)
    solved = loads.run_cycle(linkage_of(design, {}), cycle)
    way = np.ptp(np.hypot(*(solved.point("ground", "D") - solved.point("lower", "B")).T))
    assert solved.times[-1] == pytest.approx(way / pulls + way / (1.8e6 / (math.pi / 4 * 160**2)))
    with pytest.raises(DesignError, match=r"pace: has speed, flow; a stroke runs by one"):
        read(tmp_path, (flow[0], f"{flow[0]}, {flow[1]}"), text=PRESS)


def test_a_cushion_brakes_a_cylinder_evenly_to_rest(tmp_path):
    """30 mm at half the speed in the mean take as long again; the last of it at v^2 / (2 c)."""
    flow = ('speed = "0.1 m/s"', 'flow = "108 l/min", cushion = "30 mm"')
    design = read(tmp_path, flow, text=PRESS)
    cycle = design.cycles["press"]
    linkage = linkage_of(design, {})
    solved = loads.run_cycle(linkage, cycle.run)
    length = np.hypot(*(solved.point("ground", "D") - solved.point("lower", "B")).T)
    pulls = 1.8e6 / (math.pi / 4 * (160**2 - 40**2))
    pushes = 1.8e6 / (math.pi / 4 * 160**2)
    assert solved.times[-1] == pytest.approx((np.ptp(length) + 30) * (1 / pulls + 1 / pushes))
    rate = np.abs(solved.rate("cylinder"))
    back = int(np.argmin(length))
    left = np.where(np.arange(len(length)) <= back, length - length.min(), length.max() - length)
    speed = np.where(np.arange(len(length)) <= back, pulls, pushes)
    braked = speed * np.sqrt(np.minimum(left / 30, 1))
    inside = (np.arange(len(length)) != back + 1) & (left > 1e-6)
    assert rate[inside] == pytest.approx(braked[inside], rel=1e-6)
    assert cycle.entries == (0, 0, 1, 2, 2)  # it begins before the knee presses
    long = read(tmp_path, (flow[0], flow[1].replace("30 mm", "400 mm")), text=PRESS)
    with pytest.raises(DesignError, match=r"cushion of 400 mm is longer than a stroke of"):
        solve_cycles(long, {})


def test_a_force_may_follow_a_table(tmp_path):
    table = 'push = { over = "crank.angle", at = ["0 deg", "360 deg"], force = ["0 N", "-1 kN"] }'
    design = read(tmp_path, (PUSH, table))
    law = given(design, "bench", "push")
    assert law == loads.Table(loads.Angle("crank"), (0.0, 2 * math.pi), (0.0, -1000.0))
    solved = loads.run_cycle(linkage_of(design, {}), design.cycles["bench"].run)
    assert solved.efforts["push"] == pytest.approx(-1000 * solved.positions / (2 * math.pi))


@pytest.mark.parametrize(
    "text",
    ["0,0\n1,50\n400,-50\n", "x mm;F\n0;0\n1;50\n400;-50\n", "\n 0\t0\n1\t5e1\n\n400\t-50\n"],
    ids=["comma", "semicolon and a line of words", "tab and empty lines"],
)
def test_a_table_may_stand_in_a_csv_file_which_counts_as_a_source(text, tmp_path):
    (tmp_path / "work.csv").write_text(text)
    change = (PUSH, 'push = { over = "B.x", table = "work.csv", units = ["mm", "N"] }')
    design = read(tmp_path, change)
    assert given(design, "bench", "push").values == (0.0, 1.0, 400.0)
    assert given(design, "bench", "push").forces == (0.0, 50.0, -50.0)
    assert [Path(path).name for path, _ in design.sources] == ["machine.toml", "work.csv"]
    (tmp_path / "work.csv").write_text(text.replace("-50", "-51"))
    assert read(tmp_path, change).sha256 != design.sha256


def test_a_piston_pushes_with_its_area_or_the_ring_around_its_rod(tmp_path):
    """60 bar on 40 mm are 7.540 kN, around a rod of 22 mm 5.259 kN."""
    whole = 'push = { pressure = "60 bar", bore = "40 mm" }'
    ring = 'push = { pressure = "6 MPa", bore = "40 mm", rod = "22 mm" }'
    assert given(read(tmp_path, (PUSH, whole)), "bench", "push") == pytest.approx(7539.82, rel=1e-6)
    assert given(read(tmp_path, (PUSH, ring)), "bench", "push") == pytest.approx(5259.03, rel=1e-6)


@pytest.mark.parametrize(("rod", "force"), [("", -7539.82), (', rod = "22 mm"', 5259.03)])
def test_a_piston_between_two_points_pushes_them_apart_or_pulls_around_its_rod(
    tmp_path, rod, force
):
    """As a cylinder whose `available` has 7.540 kN to push and 5.259 kN to pull."""
    between = ('body = "slider"\nat = "B"\ndirection = "1, 0"', 'between = ["O", "B"]')
    for pressure, shares in (
        ('pressure = "60 bar"', 1.0),
        ('pressure = ["0 bar", "60 bar"], over = "B.x", at = ["0 mm", "900 mm"]', (0.0, 1.0)),
    ):
        piston = f'push = {{ {pressure}, bore = "40 mm"{rod} }}'
        law = given(read(tmp_path, between, (PUSH, piston)), "bench", "push")
        law = law.forces if isinstance(law, loads.Table) else law
        assert law == pytest.approx(np.multiply(shares, force), rel=1e-6)


def test_a_pressure_may_follow_a_table_or_an_indicator_diagram(tmp_path):
    (tmp_path / "work.csv").write_text("angle,p\n0,1\n180,30\n360,1\n")
    rest = 'bore = "40 mm", over = "crank.angle"'
    at = 'at = ["0 deg", "180 deg", "360 deg"], pressure = ["1 bar", "30 bar", "0.1 MPa"]'
    for columns in (at, 'table = "work.csv", units = ["deg", "bar"]'):
        law = given(read(tmp_path, (PUSH, f"push = {{ {columns}, {rest} }}")), "bench", "push")
        assert law.coordinate == loads.Angle("crank")
        assert law.values == pytest.approx((0.0, math.pi, 2 * math.pi))
        area = math.pi * 20.0**2
        assert law.forces == pytest.approx((0.1 * area, 3.0 * area, 0.1 * area))


def test_a_force_may_act_against_the_motion(tmp_path):
    """The phase ends where the slider reverses; what is told of phases keeps the file's numbers."""
    design = read(tmp_path, (PUSH, 'push = { dry = "40 N", viscous = "20 N s/m" }'))
    cycle = design.cycles["bench"]
    names = [phase.name for phase in cycle.run.phases]
    assert names == [f"turn-{k + 1}" for k in range(len(names))]
    assert len(names) > 1
    assert {cycle.entry(k) for k in range(len(names))} == {0}
    for phase in cycle.run.phases:
        assert phase.given["push"] == loads.Opposing(dry=40.0, viscous=0.02)
    solved = loads.run_cycle(linkage_of(design, {}), cycle.run)
    place = solved.linkage.body_names.index("slider")
    speed = solved.velocities[:, place, 0]
    assert abs(solved.efforts["push"]) == pytest.approx(40.0 + 0.02 * abs(speed), rel=1e-6)
    tabled = 'push = { at_speed = ["0 m/s", "2 m/s"], resistance = ["40 N", "10 N"] }'
    law = given(read(tmp_path, (PUSH, tabled)), "bench", "push")
    assert law == loads.Opposing(speeds=(0.0, 2000.0), forces=(40.0, 10.0))


FOLLOWS = ('direction = "1, 0"', 'direction = "0, 1"\nfollows = "rod"')


def test_a_force_may_turn_with_a_body(tmp_path):
    """The page's own words: across the rod at its end, wherever the rod turns."""
    design = read(tmp_path, FOLLOWS, (PUSH, 'push = "100 N"'))
    assert design.forces["push"].coordinate == loads.PointCoordinate("slider", "B", (0, 1), "rod")
    run = loads.run_cycle(linkage_of(design, {}), design.cycles["bench"].run)
    rod = run.poses[:, run.linkage.body_names.index("rod"), 2]
    (load,) = [load for load in run.body_loads("slider") if load.source == "force 'push'"]
    across = np.stack([-np.sin(rod), np.cos(rod)], axis=1)
    assert load.force == pytest.approx(100.0 * across)
    assert np.ptp(rod) > 0.1


def test_the_picture_draws_a_force_that_turns_where_it_points_and_the_answer_says_what_is_left(
    tmp_path,
):
    design = read(tmp_path, FOLLOWS, (PUSH, 'push = "100 N"'))
    run = loads.run_cycle(linkage_of(design, {}), design.cycles["bench"].run)
    layout = Layout(run)
    places, drawn = layout.pushes[[force.name for force in layout.efforts].index("push")]
    (load,) = [load for load in run.body_loads("slider") if load.source == "force 'push'"]
    assert drawn == pytest.approx(load.force)
    assert places == pytest.approx(run.point("slider", "B"))
    (left,) = _not_checked_here(design)
    assert left.startswith("the turning of push with its body as the linkage buckles")
    assert _not_checked_here(read(tmp_path)) == []


def test_a_stop_is_told_where_the_force_that_meets_it_turns_with_a_body(tmp_path):
    """The mould does not turn, so that its loads are those of a direction in the ground frame."""
    follows = ('direction = "0, -1"', 'direction = "0, -1"\nfollows = "mould"')
    told = []
    for changes in ((), (follows,)):
        design = read(tmp_path, *changes, text=PRESS)
        run = loads.run_cycle(linkage_of(design, {}), design.cycles["press"].run)
        told.append(next(iter(stop_warnings(design, {"press": run}))))
    assert "Nothing else stops it" in told[0]
    assert told[0].startswith(told[1])  # without a position there is no stiffness to tell


def test_a_contact_along_a_direction_that_turns_is_refused(tmp_path):
    contact = 'push = { touches = "B.x", at = "1 mm", stiffness = "1 N/mm" }'
    with pytest.raises(DesignError, match=r"forces\.push: a contact .*; push turns with rod"):
        read(tmp_path, FOLLOWS, (PUSH, contact))


def test_a_spring_with_preload_and_end_stop_is_a_table_over_its_own_length(tmp_path):
    """By hand: 40 N of preload at the corner, soft beyond and hard below; a turn takes no work."""
    spring = '[forces.spring]\nbetween = ["O", "B"]\n[forces.push]'
    table = 'spring = { over = "spring.length", at = ["AT0", "AT1", "AT2"], force = ["-2 kN", "40 N", "580 N"] }'
    free = read(tmp_path)
    path = loads.run_cycle(linkage_of(free, {}), free.cycles["bench"].run)
    ends = np.hypot(*path.point("slider", "B").T)
    low, high = ends.min(), ends.max()
    corner = low + (high - low) / 10
    for name, value in (("AT0", corner - 2 * (corner - low)), ("AT1", corner), ("AT2", high + 1)):
        table = table.replace(name, f"{value:.6f} mm")
    added = (PUSH, f'push = "0 N", {table}')
    other = ('push = "-200 N"', 'push = "-200 N", spring = "0 N"')
    design = read(tmp_path, ("[forces.push]", spring), added, other)
    run = loads.run_cycle(linkage_of(design, {}), design.cycles["bench"].run)
    length = np.hypot(*run.point("slider", "B").T)
    soft, hard = 540.0 / (high + 1 - corner), 2040.0 / (2 * (corner - low))
    stretch = length - corner
    by_hand = 40.0 + np.where(stretch > 0, soft, hard) * stretch
    assert run.efforts["spring"] == pytest.approx(by_hand, abs=0.01)
    assert np.abs(stretch).min() < 1e-4  # the preload's corner has positions of its own
    assert abs(run.drive("spring").work) < 1e-6 * np.abs(by_hand).max() * (high - low)


def test_a_contact_is_told_along_the_axis_and_handed_on_along_the_force(tmp_path):
    """A force that points down has the coordinate -y: touching at y is touching at -y there."""
    design = read(tmp_path, text=HAMMER)
    key = "cycles.at_5_work_10.phases[0].forces.workpiece"
    assert {(f"{key}.stops", "true"), (f"{key}.stiffness", "rigid")} <= set(design.defaults_used)
    handed = design.cycles["at_5_work_10"].run.phases[0].given["workpiece"]
    assert handed == loads.Contact(1123.5, None, 1, True)
    press = read(
        tmp_path,
        ('forces = { process = "0 N" }', 'forces = { process = { touches = "A.y", at = "490 mm", stiffness = "80 kN/mm", stops = false } }'),
        text=PRESS,
    )  # fmt: skip
    handed = press.cycles["press"].run.phases[0].given["process"]
    assert handed == loads.Contact(-490.0, 80e3, 1, False)


def test_a_buffer_between_two_points_pushes_them_apart(tmp_path):
    """The cylinder is 0.5675 m long when open and gets shorter; brief 4.2, equation (5.3)."""
    text = PRESS.replace('process = "0 N" }', 'process = "0 N", buffer = "0 N" }')
    design = read(
        tmp_path,
        ("[forces.process]", '[forces.buffer]\nbetween = ["D", "B"]\n[forces.process]'),
        ('buffer = "0 N"', 'buffer = { touches = "buffer.length", at = "400 mm", stiffness = "1 N/mm" }'),
        text=text.replace('cylinder = "11 kN" }', 'cylinder = "11 kN", buffer = "0 N" }'),
    )  # fmt: skip
    mass = {"upper": (4e-3, (125.0, 0.0), 20.0), "lower": (4e-3, (125.0, 0.0), 20.0)}
    solved = loads.run_cycle(linkage_of(design, mass), design.cycles["press"].run)
    force = solved.efforts["buffer"][solved.phase_of == 0]
    assert force[0] == 0.0
    assert -60.0 < force[-1] < 0.0, "a push is a negative pull"


def test_bodies_and_joints_may_give_way(tmp_path):
    design = read(
        tmp_path,
        ("[joints.slot]", '[elastic]\njoints.R = "200 kN/mm"\njoints.slot = "1 MN/m"\n[joints.slot]'),
        ('elastic = { bending = "2786.9184 N m2" }', 'elastic = { bending = "2786.9184 N m2", axial = "390 MN" }'),
        text=HAMMER,
    )  # fmt: skip
    beam, *joints = linkage_of(design, {}).compliance
    assert (beam.body, beam.axial) == ("rocker", 390e6)
    assert beam.bending == pytest.approx(3 * 210e3 * 60 * 9.6**3 / 12, rel=1e-12)
    assert joints == [loads.JointCompliance("R", 200e3), loads.JointCompliance("slot", 1e3)]


def refused(file):
    """Return the error of a design, or None; any other exception is a bug."""
    try:
        read_design(file)
    except DesignError as error:
        return error
    return None


TABLE = 'push = { over = "crank.angle", at = ["0 deg", "360 deg"], force = ["0 N", "50 N"] }'
REFUSED = {
    "speed and law": ((STEADY, STEADY.replace(" }", ', law = "harmonic", time = "1 s" }')), r"cycles\.bench\.pace: has speed, law; a stroke runs by one of them"),
    "no pace": ((STEADY, 'pace = { coordinate = "crank.angle" }'), r"cycles\.bench\.pace: needs speed such as \"60 rpm\", or law and time"),
    "flow of a crank": ((STEADY, 'pace = { coordinate = "crank.angle", flow = "1 l/min" }'), r"cycles\.bench\.pace\.flow: is for the length of a force between two points whose `available` has bore and rod, not for crank\.angle"),
    "cushion without flow": ((STEADY, STEADY.replace(" }", ', cushion = "1 mm" }')), r"pace\.cushion: is only used with flow; leave it out"),
    "flow with acceleration": ((STEADY, 'pace = { coordinate = "crank.angle", flow = "1 l/min", acceleration = "1 rad/s2" }'), r"pace\.acceleration: follows from the flow; leave it out"),
    "law without time": ((STEADY, 'pace = { coordinate = "crank.angle", law = "harmonic" }'), r"cycles\.bench\.pace\.time: must be stated such as \"1\.5 s\": of each stroke"),
    "law with acceleration": ((STEADY, 'pace = { coordinate = "crank.angle", law = "harmonic", time = "1 s", acceleration = "1 rad/s2" }'), r"pace\.acceleration: follows from the law; leave it out"),
    "speed with time": ((STEADY, STEADY.replace(" }", ', time = "1 s" }')), r"pace\.time: is only used with law; leave it out"),
    "unknown law": ((STEADY, 'pace = { coordinate = "crank.angle", law = "cycloid", time = "1 s" }'), r"pace\.law: must be 'harmonic', 'cycloidal' or 'polynomial', got \"cycloid\", did you mean cycloidal\?"),
    "no time": ((STEADY, 'pace = { coordinate = "crank.angle", law = "harmonic", time = "0 s" }'), r"pace\.time: must be above 0 s, got \"0 s\""),
    "time in metres": ((STEADY, 'pace = { coordinate = "crank.angle", law = "harmonic", time = "1 m" }'), r"pace\.time: must be a time such as \"1\.5 s\", got \"1 m\", which is a length"),
    "acceleration of a length": ((STEADY, STEADY.replace(" }", ', acceleration = "1 m/s2" }')), r"pace\.acceleration: must be an angular acceleration .*, got an acceleration"),
    "torque for a force": ((PUSH, 'push = "5 N m"'), r"phases\[0\]\.forces\.push: must be a force such as \"11 kN\", push is a force; got a moment"),
    "bare number": ((PUSH, "push = 5"), r"phases\[0\]\.forces\.push: must be a force such as \"11 kN\" or a moment such as \"12 N m\", got 5 without a unit"),
    "falling table": ((PUSH, TABLE.replace('"360 deg"', '"-1 deg"')), r"forces\.push\.at: must rise, got 0 deg and then -1 deg"),
    "uneven table": ((PUSH, TABLE.replace('"0 deg", ', '"0 deg", "5 deg", ')), r"forces\.push: needs as many forces as values and at least two, got 3 values and 2 forces"),
    "lengths of an angle": ((PUSH, TABLE.replace('"360 deg"', '"360 mm"')), r"forces\.push\.at: must be an angle .*crank\.angle is an angle; got a length"),
    "torques in a table": ((PUSH, TABLE.replace('"50 N"', '"50 N m"')), r"forces\.push\.force: must be a force .*push is a force; got a moment"),
    "over nothing": ((PUSH, TABLE.replace("crank.angle", "crnk.angle")), r"forces\.push\.over: no body is named 'crnk', did you mean crank\?"),
    "table without forces": ((PUSH, TABLE.replace(', force = ["0 N", "50 N"]', "")), r"forces\.push\.force: must be stated, such as over ="),
    "misspelt in a table": ((PUSH, TABLE.replace("over", "ovr")), r"forces\.push\.ovr: unknown key, did you mean over\?"),
    "table without units": ((PUSH, 'push = { over = "B.x", table = "work.csv" }'), r"forces\.push\.units: must be stated beside table"),
    "no file": ((PUSH, 'push = { over = "B.x", table = "wrk.csv", units = ["mm", "N"] }'), r"forces\.push\.table: 'wrk\.csv' cannot be read: there is no such file, did you mean work\.csv\?$"),
    "words in a file": ((PUSH, 'push = { over = "B.x", table = "work.csv", units = ["mm", "N"] }'), r"forces\.push\.table: work\.csv, line 3: must be a number, got \"many\""),
    "units of a file": ((PUSH, 'push = { over = "B.x", table = "work.csv", units = ["kg", "N"] }'), r"forces\.push\.units\[0\]: work\.csv, line 2: must be a length .* which is a mass"),
    "touches elsewhere": ((PUSH, 'push = { touches = "A.x", at = "1 mm", stiffness = "1 N/mm" }'), r"forces\.push\.touches: must be \"B\.x\", the coordinate along which push pushes, got \"A\.x\""),
    "touches at an angle": ((PUSH, 'push = { touches = "B.x", at = "1 deg", stiffness = "1 N/mm" }'), r"forces\.push\.at: must be a length .*, got an angle"),
    "touches nowhere": ((PUSH, 'push = { touches = "B.x", stiffness = "1 N/mm" }'), r"forces\.push\.at: must be stated: the coordinate at first touch"),
    "all is rigid": ((PUSH, 'push = { touches = "B.x", at = "1 mm" }'), r"forces\.push\.stiffness: must be stated such as \"80 kN/mm\": where nothing gives way"),
    "piston without bore": ((PUSH, 'push = { pressure = "60 bar" }'), r"forces\.push\.bore: must be stated"),
    "piston in newton": ((PUSH, 'push = { pressure = "60 N", bore = "40 mm" }'), r"forces\.push\.pressure: must be a stress .* which is a force"),
    "rod thicker than its bore": ((PUSH, 'push = { pressure = "60 bar", bore = "40 mm", rod = "40 mm" }'), r"forces\.push\.rod: must be thinner than the bore of 40 mm, got 40 mm"),
    "piston that turns": (('forces = { push = "0 N" }, solve = "drive"', 'forces = { drive = { pressure = "60 bar", bore = "40 mm" } }, solve = "push"'), r"forces\.drive: drive is a torque, and a piston pushes"),
    "one pressure in a table": ((PUSH, 'push = { pressure = "60 bar", bore = "40 mm", over = "crank.angle" }'), r"forces\.push\.over: is of a table; one pressure"),
    "pressures over nothing": ((PUSH, 'push = { pressure = ["1 bar", "2 bar"], bore = "40 mm", at = ["0 deg", "1 deg"] }'), r"forces\.push\.over: must be stated"),
    "pressures without values": ((PUSH, 'push = { pressure = ["1 bar", "2 bar"], bore = "40 mm", over = "crank.angle" }'), r"forces\.push\.at: must be stated"),
    "fewer pressures than values": ((PUSH, 'push = { pressure = ["1 bar", "2 bar"], bore = "40 mm", over = "crank.angle", at = ["0 deg", "90 deg", "360 deg"] }'), r"forces\.push: needs as many pressures as values and at least two, got 3 values and 2 pressures"),
    "no pressure at all": ((PUSH, 'push = { bore = "40 mm" }'), r"forces\.push\.(at|pressure): must be stated"),
    "pressure of a file in newton": ((PUSH, 'push = { bore = "40 mm", over = "B.x", table = "work.csv", units = ["mm", "N"] }'), r"forces\.push\.units\[1\]: work\.csv, line 2: must be a stress"),
    "soft as butter": ((PUSH, 'push = { touches = "B.x", at = "1 mm", stiffness = "0 N/mm" }'), r"forces\.push\.stiffness: must be above 0 kN/mm, got \"0 N/mm\""),
    "misspelt contact": ((PUSH, 'push = { toches = "B.x", at = "1 mm" }'), r"forces\.push\.toches: unknown key, did you mean touches\?"),
    "misspelt friction": ((PUSH, 'push = { dri = "1 N" }'), r"forces\.push\.dri: unknown key, did you mean dry\?"),
    "friction that helps": ((PUSH, 'push = { dry = "-1 N" }'), r"forces\.push\.dry: must be above 0 kN, got \"-1 N\""),
    "friction of a torque": ((PUSH, 'push = { dry = "1 N m" }'), r"forces\.push\.dry: must be a force .*, push is a force; got a moment"),
    "damping against turning": ((PUSH, 'push = { viscous = "1 N m s/rad" }'), r"forces\.push\.viscous: must be a damping such as \"0\.2 N s/mm\", push is a force; got a damping against turning"),
    "friction twice": ((PUSH, 'push = { dry = "1 N", at_speed = ["0 m/s", "1 m/s"], resistance = ["1 N", "1 N"] }'), r"forces\.push: is either dry and viscous, or at_speed with resistance"),
    "half a table of speeds": ((PUSH, 'push = { at_speed = ["0 m/s", "1 m/s"] }'), r"forces\.push\.resistance: must be stated beside the other column"),
    "a table from a speed on": ((PUSH, 'push = { at_speed = ["1 m/s", "2 m/s"], resistance = ["1 N", "1 N"] }'), r"forces\.push\.at_speed: the speeds of a table must begin at 0, got 1000"),
    "stops maybe": ((PUSH, 'push = { touches = "B.x", at = "1 mm", stiffness = "1 N/mm", stops = "no" }'), r"forces\.push\.stops: must be true or false, got \"no\""),
    "contact of a torque": (('forces = { push = "0 N" }, solve = "drive"', 'forces = { drive = { touches = "crank.angle", at = "1 deg", stiffness = "1 N/mm" } }, solve = "push"'), r"forces\.drive: a contact needs a force along x or y, or between two points; drive is a torque"),
    "follows nobody": ((FOLLOWS[0], FOLLOWS[1].replace("rod", "rodd")), r"forces\.push\.follows: no body is named 'rodd', did you mean rod\?"),
    "torque that follows": (('turns = "crank"', 'turns = "crank"\nfollows = "rod"'), r"forces\.drive\.follows: is only used for a force on a body, this is a torque; leave it out"),
    "contact askew": (('direction = "1, 0"', 'direction = "1, 1"'), None),
    "given and solved": (('forces = { push = "0 N" }', 'forces = { push = "0 N", drive = { touches = "B.x", at = "1 mm" } }'), r"phases\[0\]\.solve: phase 'turn' both gives and solves drive; it can only do one"),
    "elastic in nothing": (('centre = "75, 0 mm"', 'centre = "75, 0 mm"\nelastic = {}'), r"bodies\.rod\.elastic: needs bending such as \"2787 N m2\", axial such as \"390 MN\", or both"),
    "elastic in newton": (('centre = "75, 0 mm"', 'centre = "75, 0 mm"\nelastic = { bending = "5 N" }'), r"bodies\.rod\.elastic\.bending: must be a bending stiffness E I such as \"2787 N m2\", got \"5 N\", which is a force"),
    "elastic joint": (("[forces.drive]", '[elastic.joints]\nQ = "1 N/mm"\n[forces.drive]'), r"elastic\.joints\.Q: no joint is named 'Q'"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_pace_or_law_that_cannot_be_meant_is_refused_at_its_key(case, tmp_path):
    change, message = REFUSED[case]
    (tmp_path / "work.csv").write_text("x,F\n1,2\n3,many\n")
    changes = [change]
    if case == "contact askew":
        changes.append((PUSH, 'push = { touches = "B.x", at = "1 mm", stiffness = "1 N/mm" }'))
        message = r"forces\.push: a contact needs a force along x or y.*; push pushes askew"
    with pytest.raises(DesignError) as caught:
        read(tmp_path, *changes)
    lines = str(caught.value).splitlines()
    assert any(re.search(message, line) for line in lines), lines


def test_a_decimal_comma_in_a_file_is_named(tmp_path):
    (tmp_path / "work.csv").write_text("1,5;2\n3;4\n")
    with pytest.raises(DesignError, match=r'line 1: must be a number, got "1,5"; decimals'):
        read(tmp_path, (PUSH, 'push = { over = "B.x", table = "work.csv", units = ["mm", "N"] }'))


def test_two_contacts_in_one_phase_are_refused(tmp_path):
    contact = '{ touches = "B.x", at = "1 mm", stiffness = "1 N/mm" }'
    with pytest.raises(DesignError, match=r"forces\.stop: is a second contact beside push"):
        read(
            tmp_path,
            ("[forces.push]", '[forces.stop]\nbody = "slider"\nat = "B"\ndirection = "-1, 0"\n[forces.push]'),
            (PUSH, f"push = {contact}, stop = {contact}"),
            ('push = "-200 N"', 'push = "-200 N", stop = "0 N"'),
        )  # fmt: skip


@pytest.mark.parametrize("file", ALL, ids=lambda file: file.stem)
def test_a_design_with_any_line_spoilt_is_read_or_refused_in_words(file, tmp_path):
    """200 designs, each with one line left out, doubled or with a part of it exchanged."""
    for other in DESIGNS.glob("*.toml"):
        (tmp_path / other.name).write_text(other.read_text())
    lines, chance = file.read_text().splitlines(), random.Random(1)
    spoilt = tmp_path / "spoilt.toml"
    wrong = ['"5 kg"', '"x"', "-1", "[]", "{}", "true", '"1 mm"', '["a", "b"]', '"5 N m"', "nan"]
    for _ in range(200):
        row = chance.randrange(len(lines))
        key, equals, value = lines[row].partition(" = ")
        way = chance.randrange(5)
        new = {
            0: [],
            1: [lines[row], lines[row]],
            2: [f"{key}{equals}{chance.choice(wrong)}" if equals else "[nothing]"],
            3: [re.sub(r'"[^"]*"', chance.choice(wrong), lines[row], count=1)],
            4: [f"{key}{equals}{value.swapcase()}"],
        }[way]
        spoilt.write_text("\n".join([*lines[:row], *new, *lines[row + 1 :]]))
        refusal = refused(spoilt)
        assert refusal is None or (refusal.problem and "<" not in refusal.key)
