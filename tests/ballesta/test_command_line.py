"""The command as a user runs it: output, files, exit codes."""

import errno
import io
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path

import meshio
import numpy as np
import pytest

from ballesta.cli import main

ROOT = Path(__file__).parents[2]
PRESS = "designs/toggle_press.toml"
AS_SIZED = "designs/toggle_press_as_sized.toml"


def test_the_press_is_judged_by_its_exit_code(press):
    status = press.result["status"]
    assert press.code == (0 if status == "pass" else 1)
    assert status in press.stdout or status.upper() in press.stdout


def test_the_answer_names_part_check_bars_limit_and_place(press):
    lines = press.stdout.splitlines()
    assert lines[0] == "Toggle press (designs/toggle_press.toml): PASS"
    row = r"  bar_upper,( bar_lower)? +fatigue +[\d.]+ \+[\d.]+ −[\d.]+ MPa +154 "
    assert re.search(row, press.stdout)
    assert re.search(r"> pin_B +bush \(bush of upper\) ", press.stdout)
    assert re.search(r"decided by +bush \(bush of upper\) of pin_B: mean pressure", press.stdout)
    assert re.search(r"when +press: x = 2 mm", press.stdout)
    assert re.search(r"widest: a pair shares the load evenly", press.stdout)
    assert re.search(r"assumed +\d+ assumptions", press.stdout)
    assert re.search(r"not checked +impact", press.stdout)
    assert re.search(r"warning .*stop at x = 2 mm is ASSUMED", press.stdout)
    assert re.search(r"warning .*2\.\d % reserve", press.stdout)
    assert len(lines) <= 35
    assert "…" not in press.stdout


def test_the_verbose_answer_has_every_check(tmp_path, command):
    run = command(
        "check", PRESS, "-v", "--fidelity", "formula", "--out", str(tmp_path), out=tmp_path
    )
    checks = [check for part in run.result["parts"] for check in part["checks"]]
    rows = re.findall(r"^[> ] (?:bar_upper|bar_lower|pin_B) ", run.stdout, re.MULTILINE)
    assert len(rows) == len(checks) > 20
    assert {"LADDER", "NOT CHECKED", "ASSUMED"} <= set(
        re.findall(r"^[A-Z]+(?: [A-Z]+)*(?=  )", run.stdout, re.M)
    )


def test_reading_a_design_loads_no_library_that_it_has_no_use_for():
    """Each takes a tenth of a second or more; pint is loaded for a unit beside the usual ones."""
    heavy = ["pint", "skfem", "scipy.optimize", "matplotlib.figure", "pyvista", "gmsh"]
    code = (
        "import sys; from ballesta.pipeline import read_design; "
        f"read_design({str(ROOT / PRESS)!r}); print([m for m in {heavy} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_check_by_formula_loads_no_subpackage_of_scipy():
    """Together they take a tenth of its time."""
    heavy = [f"scipy.{name}" for name in ("linalg", "sparse", "optimize", "interpolate", "special")]
    code = (
        "import sys; from ballesta.pipeline import check_design, read_design; "
        "from ballesta.sweeps.improve import with_changes; "
        "from checks.design.effort import Effort; "
        f"design = read_design({str(ROOT / PRESS)!r}); "
        "result = with_changes(design, check_design(design, effort=Effort('formula'), live=True)); "
        f"print(len(result.changes), [m for m in {heavy} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "3 []"


def test_progress_is_one_line_per_step_when_piped(press):
    lines = press.stderr.splitlines()
    assert any("loads" in line for line in lines)
    assert any("pin_B" in line for line in lines)
    assert "\x1b" not in press.stderr
    assert "\x1b" not in press.stdout


def test_the_folder_holds_report_result_and_a_file_per_part(press):
    folder = press.out / "toggle_press"
    names = {path.name for path in folder.iterdir()}
    parts = {"bar_upper.vtu", "bar_lower.vtu", "pin_B.vtu"}
    assert names == {"report.html", "result.json"} | parts
    mesh = meshio.read(folder / "bar_upper.vtu")
    stress = mesh.point_data["von Mises [MPa]"]
    peak = press.result["parts"][0]["checks"][0]["value"]
    assert np.max(stress) == pytest.approx(peak, rel=1e-5)  # written in single precision or better


def test_the_report_is_whole_html_that_shows_the_verdict(press):
    class Titles(HTMLParser):
        def __init__(self):
            super().__init__()
            self.seen = []

        def handle_starttag(self, tag, attrs):
            self.seen.append(tag)

    text = (press.out / "toggle_press" / "report.html").read_text()
    parser = Titles()
    parser.feed(text)
    assert {"table", "svg", "img", "h1"} <= set(parser.seen)
    for word in ("bar_upper", "NOT CHECKED".lower(), "84", "Goodman"):
        assert word.lower() in text.lower()


def test_every_binding_gate_of_the_press_holds(press):
    gates = press.result["gates"] + [g for p in press.result["parts"] for g in p["gates"]]
    assert len(gates) >= 20
    assert all(gate["holds"] for gate in gates if gate["binding"])
    assert [gate["name"] for gate in gates if not gate["holds"]] == ["press: time of a cycle"]


def test_json_is_a_list_of_results_and_nothing_else(command, tmp_path):
    run = command(
        "check",
        AS_SIZED,
        "nope.toml",
        "--json",
        "--out",
        str(tmp_path),
        "--fidelity",
        "formula",
        out=tmp_path,
    )
    (result,) = json.loads(run.stdout)
    assert result["status"] == "FAIL"
    assert Path(result["report"]).exists()
    assert run.code == 2, "the highest exit code of several designs counts"
    assert "nope.toml: cannot be read" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("parts.bar_upper.wall=0.9", "without a unit"),
        ("parts.bar_upper.wall=5kg", "length"),
        ("parts.bar_uper.wall=5mm", "bar_upper"),
        ("parts.bar_upper.material=S335", "S355"),
        ("cycles.press.phases[1].to=501mm", "B|A"),
    ],
)
def test_a_wrong_override_is_a_line_and_exit_code_2(command, tmp_path, override, words):
    run = command("check", PRESS, "--set", override, "--out", str(tmp_path), out=tmp_path)
    assert run.code == 2
    assert run.stdout == ""
    assert re.search(words, run.stderr)
    assert "toggle_press.toml" in run.stderr
    assert "Traceback" not in run.stderr


def test_an_output_folder_that_cannot_be_made_is_a_line_and_exit_code_2(command, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    run = command("check", PRESS, "--out", str(blocked), out=tmp_path)
    assert run.code == 2
    assert "cannot be written" in run.stderr


def test_a_plan_names_the_part_that_is_too_fine(command, tmp_path):
    found = command("plan", "designs/toggle_press.toml", "--set", "parts.bar_upper.wall=0.01mm",
                    out=tmp_path)  # fmt: skip
    assert found.code == 2
    assert "designs/toggle_press.toml: parts.bar_upper: mesh.most_unknowns is" in found.stderr


def test_the_template_is_a_design_that_can_be_planned(command, tmp_path):
    run = command("new", "toggle-press", "--file", str(tmp_path / "mine.toml"), out=tmp_path)
    assert run.code == 0
    again = command("new", "toggle-press", "--file", str(tmp_path / "mine.toml"), out=tmp_path)
    assert again.code == 2, "an existing file is not overwritten"
    plan = command("plan", str(tmp_path / "mine.toml"), out=tmp_path)
    assert plan.code == 0
    for words in ("bar_upper: toggle_bar", "knee at B: up to 61.5", "unknowns", "GiB", "guide of"):
        assert words in plan.stdout


def test_an_unknown_template_names_the_nearest(command, tmp_path):
    run = command("new", "toggle-pres", out=tmp_path)
    assert run.code == 2
    assert "did you mean toggle-press" in run.stderr


def test_the_schema_is_json(command, tmp_path):
    run = command("schema", out=tmp_path)
    assert run.code == 0
    assert json.loads(run.stdout)["type"] == "object"


@pytest.mark.skipif(sys.platform == "win32", reason="a closed pipe is another error there")
def test_a_reader_that_has_seen_enough_is_no_error():
    """As in `ballesta schema | head -1`, where the last lines wait when nobody reads any more."""
    code = (
        "import os; from ballesta.supervisor import finish_standard_output as finish; "
        "reading, writing = os.pipe(); os.close(reading); os.dup2(writing, 1); "
        "print('left over'); {}"
    )
    complains, silent = (
        subprocess.run(
            [sys.executable, "-c", code.format(last)],
            capture_output=True,
            timeout=60,
            env=os.environ | {"PYTHONUNBUFFERED": ""},
        )
        for last in ("", "finish()")
    )
    assert b"BrokenPipeError" in complains.stderr
    assert (silent.returncode, silent.stderr) == (0, b"")


def test_a_reader_that_has_seen_enough_of_a_long_answer_is_no_verdict(monkeypatch):
    """1 would be FAIL; where nobody reads, shells report 128 + SIGPIPE = 141."""

    class Unread(io.StringIO):
        def write(self, _):
            raise BrokenPipeError(errno.EPIPE, "Broken pipe")

    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setattr(sys, "stdout", Unread())
    assert main(["schema"]) == 141


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from ballesta.cli import main; main(['--help']); "
        "heavy = {'numpy', 'gmsh', 'scipy', 'pint', 'pydantic', 'pyvista', 'matplotlib', 'skfem'}; "
        "sys.exit(f'imported {heavy & set(sys.modules)}' if heavy & set(sys.modules) else 0)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)


def test_designs_of_one_name_get_folders_of_their_own():
    from ballesta.run import output_folders

    folders = output_folders([Path("a/x.toml"), Path("b/x.toml"), Path("c/y.toml")], Path("out"))
    assert folders == [Path("out/a_x"), Path("out/b_x"), Path("out/c_y").with_name("y")]


def test_a_pin_whose_stack_forgets_a_force_is_refused_with_its_part(tmp_path):
    text = (ROOT / PRESS).read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if '{ force = "cylinder"' not in line]
    assert len(kept) == len(text.splitlines()) - 1
    file = tmp_path / "press.toml"
    file.write_text("\n".join(kept), encoding="utf-8")
    code = [sys.executable, "-m", "ballesta", "check", str(file), "--fidelity", "formula"]
    done = subprocess.run([*code, "--out", str(tmp_path)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2
    assert "parts.pin_B: pin 'B': every one of cylinder, lower, upper needs one seat" in done.stderr


def test_the_version_names_ballesta_and_its_solver(capsys):
    assert main(["--version"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"ballesta {version('ballesta')}"
    assert any(line.startswith("solver ") for line in lines)
