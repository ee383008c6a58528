"""`ballesta loads` as a user runs it: output, files, gates, exit codes."""

import csv
import json
import re
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest

from ballesta.commands.loads_command import loads_of_file
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles, stored_loads
from ballesta.machine.validity_checks import load_gates
from checks.design.errors import DesignError

ROOT = Path(__file__).parents[3]
PRESS = "designs/toggle_press.toml"
CRANK = "designs/slider_crank.toml"
# no meshing: every mass is stated
MASSES = [
    f"bodies.{body}.{key}={value}"
    for body in ("lower", "upper")
    for key, value in (
        ("mass", "4.14134 kg"),
        ("inertia", "0.0215695 kg m2"),
        ("centre", "125, 0 mm"),
    )
]


def gates(*overrides, file=PRESS, cycles=()):
    own = MASSES if file == PRESS else []
    result = loads_of_file(ROOT / file, [*own, *overrides], cycles)
    return {gate.name: gate for gate in result.gates}


@pytest.fixture(scope="module")
def run(command, tmp_path_factory):
    out = tmp_path_factory.mktemp("loads")
    return command(
        "loads", PRESS, "--plot", "--csv", str(out / "t.csv"), "--out", str(out), out=out
    )


def test_the_press_gives_its_force_with_its_position(run):
    """61.18 kN at x = 2 mm: the thesis' force of the press."""
    assert run.code == 0
    assert re.search(r"process +solved in press +kN .* 61\.18 +2 press", run.stdout)
    assert re.search(r"pull up to 11\.00 kN at x = 7 mm of 11\.31 kN available", run.stdout)
    assert "the stop at x = 2 mm is ASSUMED" in " ".join(run.stdout.split())


def test_what_is_written_is_named(run):
    assert f"written: {run.out / 't.csv'}" in run.stdout
    assert f"written: {run.out / 'toggle_press' / 'loads.html'}" in run.stdout
    assert (run.out / "toggle_press" / "loads.html").read_text().startswith("<!DOCTYPE html>")
    assert len((run.out / "t.csv").read_text().splitlines()) > 700


def test_meshing_for_a_mass_is_told_and_only_done_where_needed(command, run, tmp_path):
    assert "the mass of lower, upper comes from its part" in run.stderr
    stated = [part for mass in MASSES for part in ("--set", mass)]
    quick = command("loads", PRESS, *stated, out=tmp_path)
    assert quick.code == 0
    assert quick.stderr == ""


def test_the_table_goes_to_standard_output_alone(command, tmp_path):
    light = "drive.flywheel=0.01 kg m2"
    done = command("loads", CRANK, "--csv", "-", "--cycle", "at_300", "--set", light, out=tmp_path)
    rows = list(csv.DictReader(StringIO(done.stdout)))
    assert {row["cycle"] for row in rows} == {"at_300"}
    assert float(rows[-1]["position [deg]"]) == pytest.approx(360.0)
    assert "speed irregularity of drive" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_json_holds_extremes_and_gates(command, tmp_path):
    done = command("loads", CRANK, "--json", "--cycle", "at_300", out=tmp_path)
    (cycle,) = json.loads(done.stdout)["cycles"]
    assert cycle["name"] == "at_300"
    assert {effort["quantity"] for effort in cycle["efforts"]} == {"drive", "push"}
    assert cycle["drives"][0]["irregularity"] > 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nope.toml"], "cannot be read"),
        ([PRESS, "--cycle", "pres"], "did you mean press"),
        ([PRESS, "--set", "cycles.press.phases[1].to=501mm"], "toggle_press.toml"),
        ([CRANK, "--csv", "/dev/null/x.csv"], "cannot be written"),
        ([CRANK, "--csv", "-", "--json"], "standard output"),
    ],
)
def test_a_wrong_input_is_a_line_and_exit_code_2(command, tmp_path, arguments, words):
    done = command("loads", *arguments, out=tmp_path)
    assert done.code == 2
    assert done.stdout == ""
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_a_part_that_cannot_be_meshed_is_exit_code_3(monkeypatch, capsys):
    from ballesta.commands.loads_command import Wanted, run_loads
    from geometry.mesh import MeshError

    def gives_up(*_):
        raise MeshError("the mesher gave up")

    monkeypatch.setattr("ballesta.commands.loads_command.part_masses", gives_up)
    assert run_loads(ROOT / PRESS, Wanted()) == 3
    assert "the mesher gave up" in capsys.readouterr().err


def test_every_gate_of_the_press_holds_but_the_cycle_s_time():
    """178.3 mm of cylinder there and back at 0.1 m/s take 3.7 s; 20 1/min allow 3 s."""
    found = gates()
    broken = {name: gate for name, gate in found.items() if not gate.holds}
    assert list(broken) == ["press: time of a cycle"]
    assert broken["press: time of a cycle"].value == pytest.approx(3.734 / 3.0, rel=1e-3)
    assert not broken["press: time of a cycle"].binding
    assert found["press: cylinder, pull"].value == pytest.approx(11.0 / 11.3097, rel=1e-5)
    # the share of the motion that the process sees falls with x: most so at the end, x = 2 mm
    assert "x = 2 mm" in found["press: nearness to a dead centre"].meaning


@pytest.mark.parametrize(
    ("override", "name", "binding"),
    [
        ("forces.cylinder.available=10 kN", "press: cylinder, pull", False),
        ("duty.rate=10 1/min", None, False),
        (
            "forces.cylinder.available={ push = '20 kN', pull = '10.9 kN' }",
            "press: cylinder, pull",
            False,
        ),
    ],
)
def test_a_gate_breaks_when_it_should(override, name, binding):
    broken = {gate.name for gate in gates(override).values() if not gate.holds}
    others = {gate for gate in broken if gate.startswith("press:")} - {"press: time of a cycle"}
    assert others == ({name} if name else set())
    if name:
        assert gates(override)[name].binding is binding
    else:
        assert "press: time of a cycle" not in broken


@pytest.mark.parametrize("turns", [7, 13, 17, 29])
def test_a_machine_that_runs_just_as_often_as_its_duty_asks_meets_it(turns):
    """Of the time of a turn by the pace and of the rate's, one or the other may be a bit more."""
    asked = [f"cycles.at_300.pace.speed={turns} rpm", f"duty.rate={turns} 1/min"]
    found = gates(*asked, file="designs/slider_crank.toml", cycles=["at_300"])
    assert found["at_300: time of a cycle"].holds


def test_a_dead_centre_that_is_near_breaks_its_gate():
    """A toggle's angle goes with sqrt(x), what lengths do as 1 over it: of 0.0453 at 2 mm."""
    design = read_design(ROOT / PRESS, (*MASSES, 'cycles.capacity.phases[0].to="499.9 mm"'))
    solved = solve_cycles(design, {})
    (gate,) = [g for g in load_gates(design, solved) if g.name.startswith("capacity: nearness")]
    assert gate.value == pytest.approx(0.0453 * (2.0 / 0.1) ** 0.5, rel=0.02)
    assert gate.binding
    assert not gate.holds


def test_friction_that_takes_most_of_the_work_breaks_its_gate():
    """Of the work of lifting against friction: a guide takes little, thick rough pins much."""
    few = "cycles.press.positions=61"
    assert "press: share of friction" not in gates(few)
    assert gates(few, "friction.guides.coefficient=0.1")["press: share of friction"].holds
    rough = "friction.pins={ coefficient = 0.3, diameter = '80 mm' }"
    assert not gates(few, rough)["press: share of friction"].holds


def test_a_flywheel_that_is_too_light_breaks_its_gate():
    """The cure that is told brings the irregularity to a tenth."""
    name = "at_300: speed irregularity of drive"
    gate = gates("drive.flywheel=0.01 kg m2", file=CRANK, cycles=["at_300"])[name]
    assert gate.binding
    assert not gate.holds
    enough = re.search(r"drive\.flywheel = ([\d.]+) kg m2", gate.cure)[1]
    cured = gates(f"drive.flywheel={enough} kg m2", file=CRANK, cycles=["at_300"])
    assert name not in cured
    assert name not in gates(file=CRANK, cycles=["at_300"])


def test_a_slot_end_that_is_near_breaks_its_gate():
    """The pin goes from 40 to 180 mm of its slot."""
    file = "designs/quick_return.toml"
    near = gates('joints.slot.ends=["39.5 mm", "192 mm"]', file=file, cycles=["at_4"])
    assert not near["at_4: travel in slot"].holds
    assert gates(file=file, cycles=["at_4"])["at_4: travel in slot"].value == pytest.approx(
        1 - 2 * 12 / 164, abs=1e-3
    )


def test_an_unknown_cycle_names_the_nearest():
    with pytest.raises(DesignError, match="did you mean capacity"):
        loads_of_file(ROOT / PRESS, cycles=["capcity"])


def test_each_cycle_of_rigid_parts_is_solved_once(monkeypatch):
    """Masses in closed form leave nothing to try before a mesh."""
    solved = []

    def noted(store, linkage, cycle):
        solved.append(cycle.name)
        return stored_loads(store, linkage, cycle)

    monkeypatch.setattr("ballesta.machine.solved_cycles.stored_loads", noted)
    monkeypatch.setattr("loads.try_cycle", lambda *_: solved.append("tried"))
    found = loads_of_file(ROOT / PRESS)
    assert len(solved) == len(found.cycles) == len(set(solved)) > 1
    assert "tried" not in solved


def test_loads_of_rigid_parts_import_nothing_that_meshes_or_solves():
    """The masses are known in closed form; SciPy, gmsh and fem take longer than the linkage."""
    code = (
        "import sys; from pathlib import Path\n"
        "from ballesta.commands.loads_command import loads_of_file\n"
        f"loads_of_file(Path({PRESS!r})); print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True
    )
    loaded = set(done.stdout.split())
    assert not {"scipy", "gmsh", "fem.unit_solutions"} & loaded
