"""Loads from a file: read right, refused in words where they are wrong, and parts checked.

The slider-crank is solved, its loads are written to a file as another program would write them, and
the file is read again: the parts must not notice.
"""

# ruff: noqa: E501 - one refusal a line: what is wrong, then the wording

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.measured_balance import balance_gates, measured_loads, not_measured
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from ballesta.pipeline import check_file
from checks.design.errors import DesignError
from checks.ladder.part_ladder import Effort
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import Models
from loads import LinkageError
from loads.kinematics import rotated, turned_left

ROOT = Path(__file__).parent.parent.parent
SOLID = Effort("solid")
MACHINE = """
name = "Slider-crank"
ground = ["O"]

[points]
O = "0, 0 mm"
A = "60, 0 mm"
B = "280, 0 mm"

[bodies.crank]
pins = ["O", "A"]
mass = "1.5 kg"
inertia = "0.003 kg m2"
centre = "20, 0 mm"
[bodies.rod]
pins = ["A", "B"]
mass = "0.8 kg"
inertia = "0.006 kg m2"
centre = "90, 4 mm"
"""
SOLVED = """
[bodies.slider]
pins = ["B"]
mass = "0.6 kg"
guide = { along = "1, 0" }
[forces.drive]
turns = "crank"
at = "O"
[forces.push]
body = "slider"
at = "B"
direction = "1, 0"
[cycles.turn]
coordinate = "crank.angle"
start = "0 deg"
pace = { coordinate = "crank.angle", speed = "60 rad/s" }
positions = 181
phases = [{ name = "turn", to = "360 deg", forces = { push = "-900 N" }, solve = "drive" }]
"""
MEASURED = """
[measured.run]
loads = "motion.csv"
position = { column = "phi", unit = "deg", name = "crank angle" }
time = { column = "t", unit = "ms" }
[measured.run.bodies.rod]
angle = { column = "theta", unit = "deg" }
acceleration = { columns = ["ax", "ay"], unit = "m/s2" }
angular_velocity = { column = "w", unit = "rad/s" }
angular_acceleration = { column = "dw", unit = "rad/s2" }
[measured.run.bodies.rod.at.A]
force = { columns = ["Ax", "Ay"], unit = "N" }
[measured.run.bodies.rod.at.B]
force = { columns = ["Bx", "By"], unit = "kN", sign = -1 }
"""
TUBE = """
[duty]
cycles = { CYCLE = 1e6 }
[parts.rod_tube]
body = "rod"
shape = "prismatic_tube"
interfaces = { start = "A", end = "B" }
material = "S355"
width = "30 mm"
wall = "3 mm"
mesh = { fineness = 0.5 }
"""
COARSE = ["accuracy=30 %"]


def written(folder, machine=MACHINE + MEASURED, file="crank.toml"):
    path = folder / file
    path.write_text(machine)
    return path


def columns_of(cycle):
    """The motion and loads of the rod in a solved cycle, in the units that MEASURED states."""
    body, row = cycle.linkage.body("rod"), cycle.body_index("rod")
    angle, spin, turn = (
        cycle.poses[:, row, 2],
        cycle.velocities[:, row, 2],
        cycle.accelerations[:, row, 2],
    )
    arm = rotated(np.array(body.centre), angle)
    centre = cycle.accelerations[:, row, :2] + turn[:, None] * turned_left(arm)
    centre -= (spin**2)[:, None] * arm
    on = {load.point: load.force for load in cycle.body_loads("rod")}
    return {
        "phi": np.degrees(cycle.positions),
        "t": cycle.times * 1e3,
        "theta": np.degrees(angle),
        "w": spin,
        "dw": turn,
        "ax": centre[:, 0] / 1e3,
        "ay": centre[:, 1] / 1e3,
        "Ax": on["A"][:, 0],
        "Ay": on["A"][:, 1],
        "Bx": -on["B"][:, 0] / 1e3,
        "By": -on["B"][:, 1] / 1e3,
    }


def csv_text(columns, mark=","):
    lines = [mark.join(columns)]
    lines += [
        mark.join(repr(float(value)) for value in row)
        for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def columns(tmp_path_factory):
    design = read_design(written(tmp_path_factory.mktemp("solved"), MACHINE + SOLVED))
    return columns_of(solve_cycles(design, {})["turn"])


@pytest.fixture
def folder(tmp_path, columns):
    (tmp_path / "motion.csv").write_text(csv_text(columns))
    return tmp_path


def test_a_clean_file_balances_to_round_off_and_is_told_as_a_gate(folder):
    """The file holds all digits, so that only the round-off of its own numbers is left."""
    design = read_design(written(folder))
    run = measured_loads(design, {})["run"]
    assert run.equilibrium_residual["rod"] < 1e-13
    gate, spin = balance_gates(design, {"run": run})
    assert gate.holds
    assert spin.name == "run: angular velocity of rod"
    assert spin.holds
    assert gate.limit == 0.01
    assert gate.name == "run: balance of the loads on rod"
    assert run.times[-1] == pytest.approx(2 * np.pi / 60)


def test_a_pins_own_inertia_counts_in_a_measured_run(folder):
    """At the dead centre the slider has -r w2 (1 + r/l) = -274.9 m/s2, and the pin of the rod."""
    long = PIN.replace('at = "14 mm", width = "8 mm"', 'at = "260 mm", width = "500 mm"')
    design = read_design(written(folder, MACHINE + MEASURED + long, "long.toml"))
    runs = measured_loads(design, {})
    pull = runs["run"].bodies["rod"].pull_at("B", (0.0, 0.0))
    assert_allclose(pull[0], (-60 * 60**2 * (1 + 60 / 220), 0), rtol=1e-9, atol=1e-3)

    loads = loads_on(design, design.parts["pin_B"], runs)
    mass = 7.85e-9 * np.pi * 6**2 * 1030
    share = mass * np.hypot(pull[0][0], 9810) / loads.largest_force
    (doubt,) = loads.doubts
    assert doubt.words.startswith("weight and inertia of the pin itself")
    assert doubt.ends[0].largest_force == pytest.approx((1 + share) * loads.largest_force)


@pytest.mark.parametrize("mark", [";", "\t", ","])
@pytest.mark.parametrize("start", ["", "\ufeff"])
def test_semicolons_tabs_commas_and_byte_order_marks_are_read(folder, columns, mark, start):
    (folder / "motion.csv").write_text(start + csv_text(columns, mark), encoding="utf-8")
    run = read_design(written(folder)).measured["run"].loads
    assert_allclose(run.bodies["rod"].angle, np.radians(columns["theta"]), rtol=1e-15)


def test_what_the_file_does_not_have_is_told_as_an_assumption(folder):
    text = (MACHINE + MEASURED).replace('angular_velocity = { column = "w", unit = "rad/s" }', "")
    assumed = dict(read_design(written(folder, text)).assumed)
    assert (
        "taken as 0, though the angle changes by"
        in assumed["measured.run.bodies.rod.angular_velocity"]
    )


SLIPS = {
    "sign of the load": ("sign = -1", "sign = 1", "reversing the force at B closes it"),
    "swapped": ('["Ax", "Ay"]', '["Ay", "Ax"]', "swapping x and y of the force at A"),
    "unit": ('unit = "kN"', 'unit = "N"', r"multiplying the force at B by 1000 \(kN taken for N\)"),
    "frame": ('sign = -1', 'sign = -1, frame = "body"', "force at B as given in the ground's frame"),
    "angle": ('"theta", unit = "deg"', '"theta", unit = "rad"', r"taking the angle as deg"),
    "acceleration": ('"m/s2"', '"mm/s2"', r"multiplying the acceleration by 1000"),
    "mass": ('mass = "0.8 kg"', 'mass = "800 kg"', "a mass of 0.8 kg instead of 800 kg"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "told"), SLIPS.values(), ids=SLIPS)
def test_a_slip_in_the_design_file_is_named_in_the_refusal(folder, old, new, told):
    text = MACHINE + MEASURED
    assert text.count(old) >= 1
    changed = (
        text.replace(old, new) if old.startswith("mass") else (MACHINE + MEASURED.replace(old, new))
    )
    design = read_design(written(folder, changed))
    where = (
        r"crank\.toml: measured\.run\.bodies\.rod: motion\.csv: .*unbalanced by .* of the largest"
    )
    with pytest.raises(DesignError, match=f"{where}.*at crank angle .* deg; .*{told}"):
        measured_loads(design, {})


def lines(*rows):
    return "\n".join(rows) + "\n"


HEAD = "phi,t,theta,w,dw,ax,ay,Ax,Ay,Bx,By"
ROW = "0,0,0,0,0,0,0,0,0,0,0"
NEXT = "1,1,0,0,0,0,0,0,0,0,0"
BAD_FILES = {
    "empty": ("", "motion.csv: the file is empty; its first line must name the columns"),
    "blank": (" \n\n", "the file is empty"),
    "names only": (lines(HEAD), "has no row of numbers under the names; at least two"),
    "one row": (lines(HEAD, ROW), "has one row of numbers under the names"),
    "no names": (lines(ROW, NEXT), "line 1: must name the columns, got numbers: 0, 0"),
    "missing column": (lines(HEAD.replace("Bx", "B_x"), ROW, NEXT), r"at\.B\.force\.columns\[0\]: motion\.csv: no column is named 'Bx', did you mean B_x\? There are phi, t"),
    "text": (lines(HEAD, ROW, NEXT.replace("1,1,0", "1,1,none")), r"""line 3, column 'theta': must be a number, got "none"$"""),
    "units in line 2": (lines(HEAD, ROW.replace("0,0", "deg,ms", 1), ROW, NEXT), "line 2, column 'phi': must be a number, got \"deg\"; units stand in the design"),
    "empty cell": (lines(HEAD, ROW, "1,1,0,0,0,0,0,,0,0,0"), "line 3, column 'Ax': is empty, a number is needed"),
    "nan": (lines(HEAD, ROW, "1,1,0,0,0,0,0,0,NaN,0,0"), "line 3, column 'Ay': must be a finite number, got \"NaN\""),
    "infinite": (lines(HEAD, ROW, "1,1,0,0,0,0,0,0,0,-inf,0"), "column 'Bx': must be a finite number"),
    "overflow": (lines(HEAD, ROW, "1,1,0,0,0,0,0,0,0,1e999,0"), "column 'Bx': must be a finite number"),
    "short row": (lines(HEAD, ROW, NEXT, "2,2,0"), "line 4: has 3 cells, the first line names 11 columns"),
    "decimal commas between commas": (lines(HEAD, "0,0,0,0,0,0,0,0,0,0,0,5", NEXT), "line 2: has 12 cells, .* are these decimal commas"),
    "decimal commas": (lines(HEAD.replace(",", ";"), ROW.replace(",", ";"), NEXT.replace(",", ";").replace("1;1", "1,5;1")), "line 3, column 'phi': \"1,5\" has a decimal comma"),
    "two delimiters": (lines(HEAD, ROW.replace(",", ";"), NEXT), "line 2: has 1 cells, .* parted by commas; this line is parted by semicolons"),
    "same position": (lines(HEAD, ROW, ROW), r"measured\.run\.position\.column: 'phi' is the same in every row"),
    "time backwards": (lines(HEAD, ROW, NEXT, "2,0.5" + NEXT[3:]), "time.column: motion.csv: line 4: time runs backwards"),
    "column twice": (lines(HEAD.replace("Ay", "Ax"), ROW, NEXT), r"2 columns are named 'Ax': 8, 9; rename them"),
    "no text": ("phi\0,t\n0,0\n1,1\n", "is not text"),
    "underscore": (lines(HEAD, ROW, NEXT.replace("1,1", "1_0,1")), "line 3, column 'phi': must be a number"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "told"), BAD_FILES.values(), ids=BAD_FILES)
def test_a_bad_file_is_refused_with_its_line(folder, text, told):
    (folder / "motion.csv").write_text(text)
    with pytest.raises(DesignError, match=told) as refused:
        read_design(written(folder))
    assert "crank.toml: measured.run." in str(refused.value)


def test_a_missing_file_and_one_that_is_no_text_are_refused(folder):
    with pytest.raises(
        DesignError,
        match=r"measured\.run\.loads: 'moton\.csv' cannot be read: .*did you mean motion",
    ):
        read_design(written(folder, MACHINE + MEASURED.replace("motion.csv", "moton.csv")))
    (folder / "motion.csv").write_bytes(b"phi,t\n\xff\xfe,1\n")
    with pytest.raises(DesignError, match=r"measured\.run\.loads: .*not UTF-8"):
        read_design(written(folder))


ENTRIES = {
    "no body": ("bodies.rod", "bodies.rot", r"measured\.run\.bodies\.rot: no body is named 'rot', did you mean rod"),
    "no point": ("rod.at.B]", "rod.at.O]", r"measured\.run\.bodies\.rod\.at\.O: no point of body rod is named 'O'"),
    "no angle": ('angle = { column = "theta", unit = "deg" }\n', "", r"bodies\.rod\.angle: must be stated, loads are in the ground frame"),
    "unit": ('unit = "kN"', 'unit = "kg"', r"at\.B\.force\.unit: must be a force such as .*which is a mass"),
    "unit with number": ('unit = "kN"', 'unit = "1 kN"', r"at\.B\.force\.unit: must be a unit such as kN"),
    "sign": ("sign = -1", "sign = 2", r"at\.B\.force\.sign: must be 1 or -1, got 2"),
    "frame": ("sign = -1", 'frame = "bdy"', r"at\.B\.force\.frame: must be .*did you mean body"),
    "unknown key": ("sign = -1", "sing = -1", r"at\.B\.force\.sing: unknown key, did you mean sign"),
    "one column": ('["Bx", "By"]', '["Bx"]', r"at\.B\.force\.columns: must be at least 2 long"),
    "column twice": ('["Bx", "By"]', '["Bx", "Bx"]', r"at\.B\.force\.columns: 'Bx' is named twice"),
    "no load": ('force = { columns = ["Bx", "By"], unit = "kN", sign = -1 }', "", r"at\.B: needs a force, a moment or both"),
    "position unit": ('"phi", unit = "deg"', '"phi", unit = "N"', r"position\.unit: must be an angle .*which is a force"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "told"), ENTRIES.values(), ids=ENTRIES)
def test_a_wrong_entry_is_refused_at_its_key(folder, old, new, told):
    assert old in MEASURED
    with pytest.raises(DesignError, match=told):
        read_design(written(folder, MACHINE + MEASURED.replace(old, new)))


def test_a_duty_names_measured_runs_and_they_share_no_name_with_a_cycle(folder):
    design = read_design(written(folder, MACHINE + MEASURED + "[duty]\ncycles = { run = 1e6 }\n"))
    assert design.duty.cycles == {"run": 1e6}
    with pytest.raises(DesignError, match=r"no cycle is named 'rum', did you mean run"):
        read_design(written(folder, MACHINE + MEASURED + "[duty]\ncycles = { rum = 1e6 }\n"))
    both = MACHINE + SOLVED + MEASURED.replace("measured.run", "measured.turn")
    with pytest.raises(DesignError, match=r"measured\.turn: there is a cycle of that name"):
        read_design(written(folder, both))


def test_the_file_counts_for_the_checksum_of_the_design(folder, columns):
    before = read_design(written(folder)).sha256
    changed = {**columns, "Ax": columns["Ax"] * (1 + 1e-9)}
    (folder / "motion.csv").write_text(csv_text(changed))
    assert read_design(written(folder)).sha256 != before


WITHOUT_MASS = MACHINE.replace(
    'mass = "0.8 kg"\ninertia = "0.006 kg m2"\ncentre = "90, 4 mm"\n', ""
)


@pytest.fixture(scope="module")
def with_part(tmp_path_factory):
    """A folder with the rod as a part: solved.toml, and measured.toml with the solved loads."""
    folder = tmp_path_factory.mktemp("part")
    solved = written(folder, WITHOUT_MASS + SOLVED + TUBE.replace("CYCLE", "turn"), "solved.toml")
    design = read_design(solved)
    masses = part_masses(design, Models())
    cycles = solve_cycles(design, masses)
    (folder / "motion.csv").write_text(csv_text(columns_of(cycles["turn"])))
    written(folder, WITHOUT_MASS + MEASURED + TUBE.replace("CYCLE", "run"), "measured.toml")
    return folder, design, masses, cycles


def test_a_part_is_loaded_by_the_file_as_by_the_solved_cycle(with_part):
    """Round-off of the units' conversion, and of closing a balance that is closed."""
    folder, design, masses, cycles = with_part
    measured = read_design(folder / "measured.toml")
    solved = loads_on(design, design.parts["rod_tube"], cycles)
    read = loads_on(measured, measured.parts["rod_tube"], measured_loads(measured, masses))
    for interface, wrench in solved.wrenches.items():
        assert_allclose(read.wrenches[interface], wrench, rtol=0, atol=1e-9 * solved.largest_force)
    limit = 1e-9 * np.abs(solved.accelerations).max(axis=0)
    assert np.all(np.abs(read.accelerations - solved.accelerations) <= limit)
    assert read.labels[0] == "crank angle = 0 deg"


def test_the_design_of_the_docs_is_loaded_by_the_file_as_well(with_part):
    """The rod of docs/measured_loads.md is this one; its loads balance, and load its part."""
    folder, design, masses, cycles = with_part
    page = (ROOT / "docs" / "measured_loads.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```toml\n(.*?)```\n", page, re.DOTALL)
    read = read_design(written(folder, shown, "docs.toml"))
    on_it = loads_on(read, read.parts["rod_tube"], measured_loads(read, masses))
    solved = loads_on(design, design.parts["rod_tube"], cycles)
    assert on_it.largest_force == pytest.approx(solved.largest_force, rel=1e-9)


@pytest.mark.slow
def test_a_part_has_the_stresses_of_the_solved_cycle_under_its_measured_loads(with_part):
    """The loads agree to 1e-9, and stresses are linear in them."""
    folder = with_part[0]
    solved, read = (
        check_file(folder / name, COARSE, effort=SOLID) for name in ("solved.toml", "measured.toml")
    )
    (own,), (other,) = solved.parts, read.parts
    for check, again in zip(own.checks, other.checks, strict=True):
        assert again.quantity == check.quantity
        assert again.value == pytest.approx(check.value, rel=1e-7)
    assert all(gate.holds for gate in (*read.gates, *other.gates))
    assert read.exit_code == solved.exit_code


@pytest.mark.slow
def test_a_part_is_checked_under_readings_that_are_off_by_half_a_percent(with_part):
    """What they leave is taken up by inertia: the part's own balance still closes to 1e-6."""
    folder = with_part[0]
    text = (folder / "motion.csv").read_text().splitlines()
    names = text[0].split(",")
    values = np.array([[float(cell) for cell in line.split(",")] for line in text[1:]])
    random = np.random.default_rng(3)
    for name in ("Ax", "Ay", "Bx", "By"):
        values[:, names.index(name)] *= 1 + 0.005 * random.uniform(-1, 1, len(values))
    (folder / "noisy.csv").write_text(csv_text(dict(zip(names, values.T, strict=True))))
    noisy = (folder / "measured.toml").read_text().replace("motion.csv", "noisy.csv")
    result = check_file(written(folder, noisy, "noisy.toml"), COARSE, effort=SOLID)
    (gate,) = [gate for gate in result.gates if gate.name.startswith("run: balance")]
    assert 1e-3 < gate.value < 0.01
    assert all(gate.holds for gate in result.parts[0].gates)


PIN = """
[bodies.slider]
pins = ["B"]
mass = "0.6 kg"
guide = { along = "1, 0" }
[parts.pin_B]
joint = "B"
shape = "pin"
fixed_to = "rod"
diameter = "12 mm"
material = "42CrMo4"
stack = [
  { body = "rod", at = "0 mm", width = "16 mm" },
  { body = "slider", at = "14 mm", width = "8 mm" },
]
"""


def test_a_pin_gets_the_opposite_of_the_measured_load_and_the_other_lug_what_follows(
    folder, columns
):
    design = read_design(written(folder, MACHINE + MEASURED + PIN))
    pin = loads_on(design, design.parts["pin_B"], measured_loads(design, {}))
    by_rod = rotated(
        1e3 * np.column_stack([columns["Bx"], columns["By"]]), -np.radians(columns["theta"])
    )
    assert_allclose(pin.wrenches["rod"][:, :2], by_rod, atol=1e-9)
    assert_allclose(pin.wrenches["slider"][:, :2], -by_rod, atol=1e-9)


def test_lugs_that_do_not_press_on_a_pin_alike_are_refused(folder, columns):
    """The slider's load is the rod's opposite and the guide's push: the pin alone is too little."""
    slider = """
[measured.run.bodies.slider]
acceleration = { columns = ["sx", "sy"], unit = "mm/s2" }
[measured.run.bodies.slider.at.B]
force = { columns = ["Sx", "Sy"], unit = "N" }
"""
    still = np.zeros_like(columns["phi"])
    more = {"sx": still, "sy": still, "Sx": still, "Sy": still + 0.6 * 9.81}
    (folder / "motion.csv").write_text(csv_text({**columns, **more}))
    design = read_design(written(folder, MACHINE + MEASURED + slider + PIN))
    with pytest.raises(
        DesignError, match=r"parts\.pin_B\.stack: motion\.csv: pin B: .* N too much"
    ):
        measured_loads(design, {})


def test_a_part_of_which_a_run_says_nothing_is_told(folder):
    pin = PIN.replace('joint = "B"', 'joint = "O"').replace("pin_B", "pin_O")
    pin = pin.replace('body = "rod"', 'body = "crank"').replace(
        'body = "slider"', 'body = "ground"'
    )
    pin = pin.replace('fixed_to = "rod"', 'fixed_to = "ground"')
    design = read_design(written(folder, MACHINE + MEASURED + pin))
    linkage, part = not_measured(design)
    assert linkage.startswith("the linkage in run: its buckling, vibration, hits of pins")
    assert part == "pin_O in run: motion.csv has no load on it"
    with pytest.raises(LinkageError, match="no load acts on it: run"):
        loads_on(design, design.parts["pin_O"], measured_loads(design, {}))
