import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ballesta.batches.pool import Limits, Pool, PoolError, fatal_words
from ballesta.batches.processes import MIB, Admission
from fem.threads import ONE_THREAD

from . import jobs


@pytest.fixture(autouse=True)
def module(tmp_path, monkeypatch):
    jobs.write_module(tmp_path, monkeypatch)


def acts(tmp_path, *whats):
    return [{"what": what, "x": x, "marks": str(tmp_path)} for x, what in enumerate(whats)]


def test_every_job_is_answered_by_its_own_place(tmp_path):
    done = jobs.run(jobs.pool("double", tmp_path / "work"), [{"x": x} for x in range(20)])
    assert [each.outcome["answer"] for each in done] == [2 * x for x in range(20)]
    assert all(each.attempts == 1 and each.status == "" for each in done)


def test_what_a_library_prints_is_no_answer(tmp_path):
    (done,) = jobs.run(jobs.pool("noisy", tmp_path / "work"), [{"x": 3}])
    assert done.outcome == {"answer": 6}


def test_workers_have_one_thread_each(tmp_path, monkeypatch):
    """The processor time of a worker's other threads: 2 to 3 times its own where they are free."""
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "8")
    tests = str(Path(__file__).parents[2])
    (done,) = jobs.run(jobs.pool("calculate", tmp_path / "work"), [{"tests": tests}])
    assert done.outcome["share"] < 0.05


def test_a_worker_is_ready_before_it_has_loaded_what_only_a_check_needs():
    code = "import sys, ballesta.batches.processes; print({'scipy', 'numpy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_a_worker_that_was_killed_costs_nothing_but_time(tmp_path):
    done = jobs.run(
        jobs.pool("act", tmp_path / "work"), acts(tmp_path, "ok", "die once", "ok", "ok")
    )
    assert [each.outcome["answer"] for each in done] == [0, 2, 4, 6]
    assert [each.attempts for each in done] == [1, 2, 1, 1]


def test_a_worker_killed_from_outside_is_replaced(tmp_path):
    (tmp_path / "1").touch()
    killed = []
    with jobs.pool("act", tmp_path / "work", most=1) as pool:
        ended = []
        for some in pool.results(list(enumerate(acts(tmp_path, "sleep", "ok")))):
            ended += some
            if pool.running and pool.running[0][0] == 0:
                pid = pool._workers[0].pid
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
    by_place = {each.index: each for each in ended}
    assert len(set(killed)) == 2
    assert by_place[1].outcome["answer"] == 2
    assert by_place[0].status == "crashed"


def test_a_job_that_always_crashes_costs_itself_alone_and_tells_its_signal(tmp_path):
    done = jobs.run(
        jobs.pool("act", tmp_path / "work"), acts(tmp_path, "ok", "segfault", "die", "ok")
    )
    assert [each.status for each in done] == ["", "crashed", "crashed", ""]
    assert "SIGSEGV, 2 times" in done[1].error
    assert "SIGKILL" in done[2].error
    assert "want of memory" in done[2].error
    assert fatal_words(done[1].said) == "Fatal Python error: Segmentation fault"


def test_a_hang_is_ended_at_the_time_limit_and_costs_itself_alone(tmp_path):
    start = time.monotonic()
    done = jobs.run(
        jobs.pool("act", tmp_path / "work", seconds=1.0), acts(tmp_path, "sleep", "ok", "ok")
    )
    assert [each.status for each in done] == ["out of time", "", ""]
    assert done[0].error == "took longer than 1 s (--time-limit)"
    assert time.monotonic() - start < 20


@pytest.mark.parametrize(
    ("how", "words"), [("grow", "it may take 300 MiB"), ("burst", "there was not enough memory")]
)
def test_a_memory_blow_up_costs_itself_alone(tmp_path, how, words):
    """By 480 MiB slowly, which is watched, or 4 GiB at once, which is refused; 300 MiB are free."""
    done = jobs.run(
        jobs.pool("act", tmp_path / "work", memory=300 * MIB), acts(tmp_path, how, "ok", "ok")
    )
    assert [each.status for each in done] == ["out of memory", "", ""]
    assert words in done[0].error


def test_what_is_too_large_beside_others_runs_alone(tmp_path):
    pool = jobs.pool("act", tmp_path / "work", seconds=2.0, memory=200 * MIB, alone=4096 * MIB)
    done = jobs.run(pool, acts(tmp_path, "grow", "ok", "ok"))
    assert [each.status for each in done] == ["out of time", "", ""]  # it sleeps once it is large


def test_a_bug_of_ours_is_told_with_its_place(tmp_path):
    done = jobs.run(jobs.pool("act", tmp_path / "work"), acts(tmp_path, "raise", "ok"))
    assert done[0].status == "crashed"
    assert "KeyError: 'our own bug' (batch_job_functions.py:" in done[0].error
    assert done[1].outcome["answer"] == 2


def test_workers_that_cannot_start_end_the_batch_with_the_reason(tmp_path):
    limits = Limits(None, 300 * MIB, 300 * MIB)
    with (
        Pool("no_such_module:run", 1, limits, Admission(MIB, MIB), tmp_path / "work") as pool,
        pytest.raises(PoolError, match="no_such_module"),
    ):
        list(pool.results([(0, {})]))


def test_closing_ends_workers_and_removes_what_they_kept(tmp_path):
    pool = jobs.pool("act", tmp_path / "work", most=2)
    ticks = pool.results(list(enumerate(acts(tmp_path, "sleep", "sleep"))))
    while len(pool.running) < 2:
        next(ticks)
    pids, folder = [worker.pid for worker in pool._workers], tmp_path / "work"
    assert folder.is_dir()
    pool.close()
    assert not folder.exists()
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_fewer_run_beside_each_other_as_they_turn_out_larger():
    admission = Admission(budget=8000, estimate=1000)
    assert [admission.fitting(most) for most in (4, 100)] == [4, 8]
    admission.saw(2000)
    assert admission.fitting(100) == 3  # 8000 / (1.2 * 2000)
    admission.saw(100_000)
    assert admission.fitting(100) == 1
