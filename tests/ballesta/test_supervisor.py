"""Long commands answer at once, and what a check had finished is written."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic

import pytest

from ballesta.pipeline import check_design, check_with_cycles
from ballesta.supervisor import is_long
from ballesta.unfinished import FRAME, PART, unfinished
from checks.design.effort import Effort
from reports.page import report_html

from ..small_machine import MACHINE, PLATE, machine

ROOT = Path(__file__).parents[2]
# Children whose solid, loads or page never ends, with Python's lock held as CHOLMOD does; a child
# that only tells what another has finished is as it is.
HOGS = """
import ctypes, os, signal, sys
from ballesta import __main__ as program
from geometry import progress

def held(*_, **__):
    progress.step("held for ever")
    ctypes.PyDLL(None).sleep(600)

def solid(parent):
    import checks.ladder.part_ladder
    checks.ladder.part_ladder.solid_result = held
    program.run(parent)

def late(parent):
    import checks.ladder.part_ladder

    def held_late(*_, **__):
        progress.step("held for ever")  # before a limit that a busy machine may be past at once
        progress.limit(3.0)
        ctypes.PyDLL(None).sleep(600)

    checks.ladder.part_ladder.solid_result = held_late
    program.run(parent)

def loads(parent):
    import ballesta.machine.runs
    ballesta.machine.runs.solve_cycles = held
    program.run(parent)

def noise(parent):
    import ballesta.run
    solved = ballesta.run.guarded

    def noisy(*arguments):
        os.write(1, b"PLC Error: as Tetgen has it\\n")
        return solved(*arguments)

    ballesta.run.guarded = noisy
    program.run(parent)

def crash(parent):
    import checks.ladder.part_ladder
    checks.ladder.part_ladder.solid_result = lambda *_, **__: os.kill(os.getpid(), signal.SIGSEGV)
    program.run(parent)
"""
pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="sleep(3) of the C library"
)


@pytest.fixture(scope="module")
def open_design(tmp_path_factory):
    """A design whose rod asks for a solid: what it needs is what it has by formula."""
    folder = tmp_path_factory.mktemp("open")
    result = check_design(machine(folder, PLATE), effort=Effort("formula"))
    found = next(check for check in result.checks if check.kind == "static")
    file = folder / "open.toml"
    file.write_text(MACHINE + PLATE + f"[require]\nstatic = {found.safety:.4f}\n")
    return file


class Started:
    """A supervised command whose child is a hog; lines of its standard error as they come."""

    def __init__(self, hog, folder, *argv):
        (folder / "hogs.py").write_text(HOGS)
        code = (
            # a shell that starts the tests in the background has interrupts ignored
            "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
            f"import sys; sys.path[:0] = {[str(folder), str(ROOT)]!r}; "
            f"import ballesta.supervisor as s; s._CHILD = 'hogs:{hog}'; "
            f"sys.exit(s.supervise({list(argv)!r}))"
        )
        self.process = subprocess.Popen(
            [sys.executable, "-c", code],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
        )

    def until(self, words):
        assert self.process.stderr is not None
        for line in self.process.stderr:
            if words in line:
                return line
        raise AssertionError(f"never said {words!r}")

    def rest(self):
        out, err = self.process.communicate(timeout=120)
        return self.process.returncode, out, err


def result_of(folder, name="open"):
    return json.loads((folder / "out" / name / "result.json").read_text())


def test_an_interrupt_answers_within_a_second_and_what_is_finished_is_written(
    tmp_path, open_design
):
    (tmp_path / "first.toml").write_text(MACHINE + PLATE)
    run = Started("solid", tmp_path, "check", "first.toml", str(open_design), "--json")
    run.until("held for ever")
    start = monotonic()
    run.process.send_signal(signal.SIGINT)
    run.until("ballesta: stopped; writing what is finished")
    assert monotonic() - start < 1.0
    code, out, _ = run.rest()
    assert code == 130
    found = result_of(tmp_path)
    assert found["status"] == "UNDECIDED"
    (part,) = found["parts"]
    assert [check["method"] for check in part["checks"] if check["kind"] == "static"] != ["solid"]
    assert part["rungs"][-1]["why"].startswith("stopped by the user before it was finished")
    assert any("stopped by the user" in warning for warning in found["warnings"])
    assert "stopped by the user" in (tmp_path / "out" / "open" / "report.html").read_text()
    first, second = ("stopped by the user" in str(result["warnings"]) for result in json.loads(out))
    assert (first, second) == (False, True)


def test_past_its_time_a_check_tells_the_models_that_finished_and_names_the_others(
    tmp_path, open_design
):
    run = Started("late", tmp_path, "check", str(open_design), "--json")
    run.until("held for ever")
    start = monotonic()
    code, out, _ = run.rest()
    assert monotonic() - start < 30.0  # 5 s where the machine has nothing else to do
    assert code == 1
    (found,) = json.loads(out)
    assert found == result_of(tmp_path) | {"report": found["report"]}
    assert any("the time is up (--within 3s)" in text for text in found["warnings"])
    assert "it may settle static" in str(found["warnings"])


def test_a_termination_before_anything_is_known_says_so(tmp_path, open_design):
    run = Started("loads", tmp_path, "check", str(open_design))
    run.until("held for ever")
    run.process.send_signal(signal.SIGTERM)
    code, _, said = run.rest()
    assert code == 130
    assert "ballesta: stopped at: held for ever; nothing of it was finished" in said


def test_a_library_that_crashes_costs_no_finished_model_and_is_told(tmp_path, open_design):
    run = Started("crash", tmp_path, "check", str(open_design))
    code, _, said = run.rest()
    assert code == 3
    assert "killed by signal SIGSEGV" in said
    assert "Traceback" not in said
    assert result_of(tmp_path)["status"] == "UNDECIDED"


def test_a_reader_that_has_enough_of_the_answer_is_no_crash(tmp_path, open_design):
    """`ballesta check ... | head -1`: the report is written by then."""
    command = [sys.executable, "-m", "ballesta", "check", str(open_design), "--fidelity", "formula"]
    with subprocess.Popen(
        [*command, "--out", str(tmp_path / "out")],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as run:
        run.stdout.close()
        said = run.stderr.read().decode()
        assert run.wait() == 141
    assert "killed" not in said
    assert "Traceback" not in said
    assert list(tmp_path.glob("out/*/report.html"))


def test_whatever_was_handed_over_makes_a_result_and_a_page(tmp_path):
    text = PLATE + PLATE.replace("[parts.rod]", "[parts.crank]").replace(
        'body = "rod"', 'body = "crank"'
    ).replace('first = "A", second = "B"', 'first = "O", second = "A"')
    kept, seen, told = {}, [], []

    def keep(name, value):
        kept[name] = value
        told.append(name)
        result = unfinished(kept.get, "stopped")
        if result is None:
            seen.append((name, None))
            return
        assert "stopped" in report_html(result)
        seen.append((name, str(result.status)))

    by_formula = Effort("formula")
    whole = check_with_cycles(
        machine(tmp_path, text), effort=by_formula, keep=keep, say=told.append, live=True
    ).result
    # a part that is decided is drawn beside the model of the next
    assert told.index(f"{PART}rod") < told.index("crank: formula")
    assert seen == [
        (FRAME, None),
        (f"{PART}rod", "UNDECIDED"),
        (f"{PART}crank", str(whole.status)),
    ]
    result = unfinished(kept.get, "stopped")
    assert [c.to_dict() for c in result.checks] == [c.to_dict() for c in whole.checks]
    for kept_part, part in zip(result.parts, whole.parts, strict=True):  # formulas are made once
        assert all(a is b for a, b in zip(kept_part.checks, part.checks, strict=True))
    assert result.cycles == whole.cycles


def test_short_commands_and_help_have_no_child():
    assert is_long(["check", "a.toml"])
    assert is_long(["batch", "a.toml", "--until=pass"])
    assert not is_long(["batch", "a.toml"])
    assert not is_long(["check", "--help"])
    assert not is_long(["schema"])
    assert not is_long([])


def test_what_a_library_prints_stands_in_no_json(tmp_path, open_design):
    """Tetgen inside gmsh prints on standard output; that of the program is a JSON list alone."""
    code, out, err = Started(
        "noise", tmp_path, "check", str(open_design), "--json", "--fidelity", "formula"
    ).rest()
    assert [one["name"] for one in json.loads(out)] == ["Crank and slider"]
    assert code == 1
    assert "PLC Error" in err
    verdict = err.index("open.toml: UNDECIDED, safety ")  # told before what decides nothing
    assert verdict < err.index("seeking single changes")
