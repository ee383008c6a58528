import errno
import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pandas
import pytest

from ballesta.batches import run as batch_run
from ballesta.batches.run import Journal, Settings, locked, run_batch
from checks.design.errors import DesignError, NumericsError

from . import jobs

FUNCTION = "batch_job_functions:outcome"
TABLES = ("results.csv", "results.parquet", "index.html")
ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def module(tmp_path, monkeypatch):
    jobs.write_module(tmp_path, monkeypatch)


@pytest.fixture
def in_this_process(tmp_path, monkeypatch):
    """Jobs run in this process: the subject is the journal, the tables or the command."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "batch_job_functions", raising=False)
    jobs.run_in_this_process(monkeypatch)
    yield
    sys.modules.pop("batch_job_functions", None)


def batch(tmp_path, texts, out="out", settings=None, **options):
    told = jobs.Silent()
    plan = jobs.plan_of(tmp_path, texts, tmp_path / out)
    outcomes = run_batch(
        plan, tmp_path / out, settings or Settings(2), told, function=FUNCTION, **options
    )
    return outcomes, told


def tables(folder):
    return {name: (folder / name).read_bytes() for name in TABLES}


def log(tmp_path):
    file = tmp_path / "log.txt"
    return file.read_text().split() if file.exists() else []


TEXTS = {"a": "first wait 0.4", "b": "second", "c": "third wait 0.1", "d": "fourth"}


def test_rows_are_in_the_order_of_the_jobs_not_of_finishing(tmp_path):
    outcomes, told = batch(tmp_path, TEXTS)
    assert [outcome["error"] for outcome in outcomes] == ["first", "second", "third", "fourth"]
    assert told.names[0] == "b"
    lines = (tmp_path / "out" / "results.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines[1:]] == ["a", "b", "c", "d"]


@pytest.mark.usefixtures("in_this_process")
def test_tables_are_written_while_a_batch_runs(tmp_path, monkeypatch):
    """With a row for each design that is still to come, and those that are finished whole."""
    monkeypatch.setattr(batch_run, "_TABLES_EVERY", 0.0)
    monkeypatch.setattr(batch_run, "_TABLES_SHARE", 0.0)
    seen, out = [], tmp_path / "out"

    class Watching(jobs.Silent):
        def finished(self, outcome, timings):
            super().finished(outcome, timings)
            if (out / "results.parquet").exists():
                seen.append(pandas.read_parquet(out / "results.parquet"))

    plan = jobs.plan_of(tmp_path, TEXTS, out)
    run_batch(plan, out, Settings(1), Watching(), function=FUNCTION)
    assert [list(table["error"]).count("the batch has not come to it yet") for table in seen] == [
        3,
        2,
        1,
    ]
    assert list(seen[1]["error"][:2]) == ["first", "second"]
    assert "not run" not in (out / "results.csv").read_text()


@pytest.mark.usefixtures("in_this_process")
def test_a_second_run_does_nothing_and_writes_the_same_tables(tmp_path):
    batch(tmp_path, TEXTS)
    before = tables(tmp_path / "out")
    _, told = batch(tmp_path, TEXTS)
    assert told.done_before == 4
    assert len(log(tmp_path)) == 4
    assert tables(tmp_path / "out") == before


@pytest.mark.usefixtures("in_this_process")
def test_only_what_has_changed_is_done_again(tmp_path):
    batch(tmp_path, TEXTS)
    outcomes, told = batch(tmp_path, {**TEXTS, "c": "new"})
    assert told.names == ["c"]
    assert [outcome["error"] for outcome in outcomes] == ["first", "second", "new", "fourth"]


@pytest.mark.usefixtures("in_this_process")
def test_a_changed_result_json_is_not_taken_for_the_one_that_was_written(tmp_path):
    plan = jobs.plan_of(tmp_path, {"a": "one"}, tmp_path / "out")
    run_batch(plan, tmp_path / "out", Settings(1), jobs.Silent(), function=FUNCTION)
    folder = tmp_path / "out" / "a"
    folder.mkdir()
    (folder / "result.json").write_text("{}")
    with Journal(tmp_path / "out" / "journal.jsonl") as journal:
        (entry,) = journal.entries.values()
        journal.add([replace(entry, result=sha256(b"{}").hexdigest())])
    assert batch(tmp_path, {"a": "one"})[1].done_before == 1
    (folder / "result.json").write_text("{ }")
    assert batch(tmp_path, {"a": "one"})[1].done_before == 0


@pytest.mark.usefixtures("in_this_process")
def test_other_code_or_libraries_make_everything_anew(tmp_path, monkeypatch):
    batch(tmp_path, TEXTS)
    monkeypatch.setattr("checks.store.fingerprints.libraries", lambda: {"numpy": "another"})
    assert batch(tmp_path, TEXTS)[1].done_before == 0


def test_what_was_stopped_by_circumstances_is_tried_again(tmp_path):
    outcomes, _ = batch(tmp_path, {"a": "slow wait 30"}, settings=Settings(1, seconds=0.7))
    assert outcomes[0]["status"] == "out of time"
    (tmp_path / "a.txt").write_text("slow")
    outcomes, told = batch(tmp_path, {"a": "slow"}, settings=Settings(1))
    assert told.done_before == 0
    assert outcomes[0]["error"] == "slow"


@pytest.mark.usefixtures("in_this_process")
def test_a_full_disk_stops_the_batch_and_a_second_run_ends_like_an_undisturbed_one(tmp_path):
    written = []

    def fills(file, data):
        written.append(data)
        if len(written) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return os.write(file, data)

    with pytest.raises(DesignError, match=r"No space left.*same command again"):
        batch(tmp_path, TEXTS, settings=Settings(1), write=fills)
    _, told = batch(tmp_path, TEXTS)
    assert told.done_before == 2
    batch(tmp_path, TEXTS, out="other")
    resumed, undisturbed = tables(tmp_path / "out"), tables(tmp_path / "other")
    assert resumed["results.csv"] == undisturbed["results.csv"]
    assert resumed["results.parquet"] == undisturbed["results.parquet"]


def test_a_disk_that_a_worker_finds_full_stops_the_batch_and_is_nobody_s_verdict(tmp_path):
    with pytest.raises(DesignError, match="cannot be written: No space left on device"):
        batch(tmp_path, {**TEXTS, "c": "full"}, settings=Settings(1))
    outcomes, told = batch(tmp_path, {**TEXTS, "c": "third wait 0.1"})
    assert told.done_before == 2
    assert [outcome["error"] for outcome in outcomes] == ["first", "second", "third", "fourth"]


def test_code_that_changes_while_a_batch_runs_stops_it(tmp_path):
    (tmp_path / "batch_job_functions.py").write_text(
        jobs.MODULE.replace('"seconds": 0.0', '"seconds": 0.0, "code": "other"')
    )
    with pytest.raises(NumericsError, match="code was changed while the batch ran"):
        batch(tmp_path, TEXTS)


PARENT = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from ballesta.batches.run import Journal
from ballesta.batches.run import Settings, run_batch
import jobs
folder = Path(sys.argv[1])
texts = {f"j{k:02d}": f"text-{k} wait 0.15" for k in range(16)}
plan = jobs.plan_of(folder, texts, folder / sys.argv[3])
run_batch(plan, folder / sys.argv[3], Settings(2), jobs.Silent(), function=sys.argv[4])
"""


def parent(tmp_path, out):
    here = str(Path(__file__).parent)
    paths = [str(ROOT), str(tmp_path)]
    return subprocess.Popen(
        [sys.executable, "-c", PARENT, str(tmp_path), here, out, FUNCTION],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    )


@pytest.mark.slow
def test_a_killed_parent_takes_its_workers_along_and_is_resumed_to_the_same_tables(tmp_path):
    """SIGKILL of the parent in the middle: no job is lost that was told, none is left running."""
    with parent(tmp_path, "out") as process:
        while len(log(tmp_path)) < 6:
            time.sleep(0.01)
        process.kill()
    time.sleep(0.5)
    begun = log(tmp_path)
    time.sleep(0.6)
    assert log(tmp_path) == begun  # nobody goes on
    assert not (tmp_path / "out" / "results.csv").exists()
    with parent(tmp_path, "out") as process:
        assert process.wait(60) == 0
    assert not (tmp_path / "out" / ".work").exists()
    assert len(log(tmp_path)) <= 16 + 2  # two were being run
    with parent(tmp_path, "other") as process:
        assert process.wait(60) == 0
    resumed, undisturbed = tables(tmp_path / "out"), tables(tmp_path / "other")
    assert resumed["results.csv"] == undisturbed["results.csv"]
    assert resumed["results.parquet"] == undisturbed["results.parquet"]


@pytest.mark.parametrize("how", ["sleep", "hold the lock"])
def test_a_worker_in_the_middle_of_a_long_job_dies_with_its_parent(tmp_path, how):
    """Also where a library never lets Python's own threads run: on Linux the system sees to it."""
    code = (
        "import jobs, sys, pathlib\n"
        "pool = jobs.pool('forever', pathlib.Path(sys.argv[1], 'work'), most=1)\n"
        "for _ in pool.results([(0, {'marks': sys.argv[1], 'how': sys.argv[2]})]): pass"
    )
    here = str(Path(__file__).parent)
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path), how],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(tmp_path), here])},
    )
    mark = tmp_path / "pid"
    with process:
        while not mark.exists() or not mark.read_text():
            time.sleep(0.01)
        process.kill()
    pid, deadline = int(mark.read_text()), time.monotonic() + 5
    while _is_alive(pid) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not _is_alive(pid)


def _is_alive(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"  # whoever inherits it may be slow to reap it


@pytest.mark.usefixtures("in_this_process")
def test_an_interrupt_leaves_tables_that_say_what_was_not_run(tmp_path):
    class Impatient(jobs.Silent):
        def finished(self, outcome, timings):
            super().finished(outcome, timings)
            raise KeyboardInterrupt

    plan = jobs.plan_of(tmp_path, TEXTS, tmp_path / "out")
    with pytest.raises(KeyboardInterrupt):
        run_batch(plan, tmp_path / "out", Settings(1), Impatient(), function=FUNCTION)
    lines = (tmp_path / "out" / "results.csv").read_text().splitlines()
    assert [line.split(",")[3] for line in lines[1:]] == ["wrong input", *["not run"] * 3]
    outcomes, told = batch(tmp_path, TEXTS)
    assert told.done_before == 1
    assert "not run" not in [outcome["status"] for outcome in outcomes]


def test_two_batches_do_not_run_in_one_folder(tmp_path):
    (tmp_path / "out").mkdir()
    with (
        locked(tmp_path / "out"),
        pytest.raises(DesignError, match="another batch is running in this folder"),
    ):
        batch(tmp_path, TEXTS)


@pytest.mark.usefixtures("in_this_process")
def test_the_journal_holds_no_timings_among_what_is_compared(tmp_path):
    batch(tmp_path, {"a": "one"})
    (line,) = (tmp_path / "out" / "journal.jsonl").read_text().splitlines()
    entry = json.loads(line)["entry"]
    assert set(entry["timings"]) == {"seconds", "peak_memory_bytes", "attempts"}
    assert not set(entry["timings"]) & set(entry["outcome"])


@pytest.mark.usefixtures("in_this_process")
def test_the_journal_names_files_from_the_batchs_folder(tmp_path):
    """No path of the machine or its user stands in it, and a finished job is found all the same."""
    batch(tmp_path, TEXTS)
    written = (tmp_path / "out" / "journal.jsonl").read_text()
    sources = [json.loads(line)["entry"]["sources"] for line in written.splitlines()]
    assert any(sources)
    assert all(not os.path.isabs(file) for one in sources for file in one)
    assert str(tmp_path) not in "".join(json.dumps(one) for one in sources)
    assert batch(tmp_path, TEXTS)[1].done_before > 0
