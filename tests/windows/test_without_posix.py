"""ballesta where the platform claims to be Windows and nothing of POSIX can be had.

What this cannot show: Windows' own libraries, paths, drives and locks of open files. That no name
is used anywhere that Windows lacks is told by `mypy --platform win32` (make lint).
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from ballesta.pipeline import check_file
from checks.design.effort import Effort

from ..ballesta.batches.jobs import MODULE
from ..small_machine import MACHINE, PLATE

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ROD = ["accuracy=30 %", "parts.rod.mesh.fineness=0.4"]


def run(*command, paths=()):
    """A process on a Windows of ours, whose pipes know a code page of 256 characters."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(map(str, (HERE, ROOT, *paths))),
        "PYTHONIOENCODING": "cp1252",
        "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow",  # its library is that of this system
    }
    return subprocess.run(
        [sys.executable, "-P", *command], env=environment, capture_output=True, check=False
    )


@pytest.fixture(scope="module")
def design(tmp_path_factory):
    path = tmp_path_factory.mktemp("windows") / "rod.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    return path


@pytest.mark.parametrize("fidelity", ["formula", pytest.param("solid", marks=pytest.mark.slow)])
def test_a_check_has_the_numbers_that_it_has_here(design, tmp_path, fidelity):
    options = [word for override in ROD for word in ("--set", override)]
    done = run(
        "-m", "ballesta", "check", str(design), "--fidelity", fidelity, *options,
        "--out", str(tmp_path),
    )  # fmt: skip
    here = check_file(design, ROD, effort=Effort(fidelity)).to_dict()
    assert done.returncode == here["exit_code"], done.stderr.decode()
    there = json.loads((tmp_path / "rod" / "result.json").read_text(encoding="utf-8"))
    assert there["versions"]["platform"].startswith("win32 ")
    assert there["parts"][0]["checks"] == json.loads(json.dumps(here["parts"][0]["checks"]))
    assert "report.html" in done.stdout.decode("utf-8")
    assert (tmp_path / "rod" / "report.html").stat().st_size > 100_000


def test_the_claim_blocks_what_only_posix_has():
    modules = ["fcntl", "resource", "pwd", "grp", "termios"]
    code = f"""
for module in {modules}:
    try:
        __import__(module)
    except ImportError as error:
        print(module, "halted" in str(error))
"""
    told = run("-c", code).stdout.decode().split()
    assert told == [word for module in modules for word in (module, "True")]


def test_the_claim_holds_for_our_modules_and_for_no_others():
    """In a module of ours and in one of somebody else."""
    statements = ["os.killpg", "os.waitid", "os.fork", "signal.SIGKILL", "ctypes.CDLL(None)",
                  "selectors.DefaultSelector()", "os.sched_getaffinity"]  # fmt: skip
    code = f"""
begin = "import ctypes, os, selectors, signal, sys\\nfound = sys.platform, os.name\\n"
for statement in {statements}:
    text = begin + statement
    theirs = {{"__name__": "somebody.module"}}
    exec(text, theirs)
    ours = {{"__name__": "fem.module"}}
    try:
        exec(text, ours)
    except (AttributeError, TypeError, OSError) as error:
        print(statement, *theirs["found"], *ours["found"], "Windows" in str(error))
"""
    told = run("-c", code).stdout.decode().splitlines()
    found = f"{sys.platform} {os.name} win32 nt True"
    assert told == [f"{statement} {found}" for statement in statements]


BATCH = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import jobs
folder = Path(sys.argv[1])
acts = [{"what": what, "x": x, "marks": str(folder)}
        for x, what in enumerate(["ok", "die once", "segfault", "sleep", "grow", "raise", "ok"])]
pool = jobs.pool("act", folder / "work", seconds=3.0, memory=300 * jobs.MIB)
print([each.status or each.outcome["answer"] for each in jobs.run(pool, acts)])
"""


def test_a_batch_survives_what_its_jobs_do(tmp_path):
    """Crashes, hangs and what takes too much memory cost themselves alone, without POSIX too."""
    (tmp_path / "batch_job_functions.py").write_text(MODULE, encoding="utf-8")
    jobs = str(ROOT / "tests" / "ballesta" / "batches")
    done = run("-c", BATCH, str(tmp_path), jobs, paths=[tmp_path])
    assert done.stdout.decode().strip() == (
        "[0, 2, 'crashed', 'out of time', 'out of memory', 'crashed', 12]"
    ), done.stderr.decode()


@pytest.mark.slow
def test_a_batch_of_designs_is_resumed(design, tmp_path):
    command = (
        "-m", "ballesta", "batch", str(design), "--fidelity", "formula", "--jobs", "2",
        "--no-reports", "--sweep", "parts.rod.width = 30, 32 mm", "--out", str(tmp_path / "out"),
    )  # fmt: skip
    first, second = run(*command), run(*command)
    assert first.returncode == second.returncode < 2, first.stderr.decode()
    assert "2 designs to check" in first.stderr.decode()
    assert "2 of 2 designs are done already" in second.stderr.decode()


def test_a_worker_ends_with_its_parent_by_the_end_of_its_input(tmp_path):
    """Without the death signal of Linux; and with what it has started itself."""
    code = """
import os, subprocess, sys
from ballesta.batches.processes import _Lines
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
print(child.pid, flush=True)
for line in _Lines():
    pass
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), str(ROOT)])},
    )  # fmt: skip
    child = psutil.Process(int(process.stdout.readline()))
    process.stdin.close()
    assert process.wait(20) == 1
    gone, alive = psutil.wait_procs([child], timeout=5)
    assert [child.pid for child in gone] == [child.pid]
    assert not alive
    process.stdout.close()


@pytest.mark.slow
def test_a_batch_from_a_script_without_a_main_guard(design, tmp_path):
    """Windows starts every process anew; workers that imported the script would start batches."""
    script = tmp_path / "sweep.py"
    script.write_text(f"""
import ballesta
print("once")
result = ballesta.batch({str(design)!r}, {str(tmp_path / "out")!r}, fidelity="formula", jobs=1)
print(result.outcomes[0]["status"] in ("pass", "UNDECIDED", "FAIL"))
""")
    done = run(str(script))
    said = done.stdout.decode()
    assert done.returncode == 0, done.stderr.decode()
    assert (said.count("once"), said.split()[-1]) == (1, "True")
