"""Job functions for workers that need no design, and what a test needs around them."""

import json
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Self

from ballesta.batches import run as batch_run
from ballesta.batches.job import Job
from ballesta.batches.plan import Plan
from ballesta.batches.pool import Finished, Limits, Pool
from ballesta.batches.processes import MIB, Admission, answer

# Written beside the tests' own files, because a worker imports it by name.
MODULE = '''
import ctypes, os, signal, time
from pathlib import Path

def double(job):
    return {"answer": 2 * job["x"]}

def noisy(job):
    print("a library prints to standard output")
    os.write(1, b"and another one to the file itself\\n")
    return double(job)

def act(job):
    """What the job asks for: "ok", "sleep", "die once", "die", "grow", "burst", "raise"."""
    what, marks = job["what"], Path(job["marks"])
    if what == "sleep":
        time.sleep(60)
    if what == "die" or (what == "die once" and not (marks / str(job["x"])).exists()):
        (marks / str(job["x"])).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "segfault":
        ctypes.string_at(0)
    if what == "grow":
        kept = []
        for _ in range(120):
            kept.append(bytearray(b"x") * (4 << 20))
        time.sleep(60)
    if what == "burst":
        bytearray(4 << 30)
    if what == "raise":
        raise KeyError("our own bug")
    return {"answer": 2 * job["x"]}

def calculate(job):
    """Linear algebra of all libraries; tells how much of it was done by other threads."""
    import sys
    sys.path.insert(0, job["tests"])
    from threads_at_work import factorise, multiply, share_of_other_threads
    return {"share": share_of_other_threads(lambda: (multiply(), factorise()))}

def forever(job):
    """Tells its process id and never ends; with the lock of Python's threads held, if asked."""
    Path(job["marks"], "pid").write_text(str(os.getpid()))
    if job["how"] == "sleep":
        time.sleep(120)
    ctypes.PyDLL(None).sleep(120)

def outcome(job):
    """A whole outcome, as a check of a design would give it; slow where the file says so."""
    from hashlib import sha256
    from ballesta.batches.job import Job
    from ballesta.batches.job import ended, WRONG_INPUT
    file = Path(job["file"])
    text = file.read_text()
    with (file.parent / "log.txt").open("a") as log:
        log.write(job["name"] + "\\n")
    time.sleep(float(text.partition("wait ")[2] or 0))
    if text == "full":
        from ballesta.batches.job import FolderError
        raise FolderError("out/c: --out: cannot be written: No space left on device")
    job = Job(**{**job, "overrides": tuple(job["overrides"])})
    done = ended(job, WRONG_INPUT, text.split()[0], "")
    sources = {str(file.resolve()): sha256(text.encode()).hexdigest()}
    return done | {"sources": sources, "seconds": 0.0}
'''


class InThisProcess:
    """An executor that runs jobs one by one in this process, where processes are no subject."""

    at_a_time = 1
    running: Sequence[Any] = ()

    def __init__(self, function: str) -> None:
        module, _, name = function.partition(":")
        self._function = getattr(import_module(module), name)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def start(self, jobs: int) -> None:
        pass

    def results(self, jobs: Sequence[tuple[int, Mapping[str, Any]]]) -> Iterator[list[Finished]]:
        for index, job in jobs:
            reply = json.loads(json.dumps(answer(self._function, json.loads(json.dumps(job)))))
            outcome, status, error = (reply.get(k) for k in ("outcome", "failed", "error"))
            yield [Finished(index, outcome, 0.0, MIB, 1, status or "", error or "",
                            kind=reply.get("kind", ""))]  # fmt: skip


def run_in_this_process(monkeypatch) -> None:
    """Let batches run their jobs in this process."""
    monkeypatch.setattr(
        batch_run, "executor_of", lambda jobs, settings, function, *_: InThisProcess(function)
    )


def write_module(folder: Path, monkeypatch) -> None:
    """Put the functions where workers find them, as module `batch_job_functions`."""
    (folder / "batch_job_functions.py").write_text(MODULE)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=":")


def pool(function, folder, most=2, seconds=None, memory=4096 * MIB, alone=None):
    limits = Limits(seconds, memory, memory if alone is None else alone)
    return Pool(
        f"batch_job_functions:{function}", most, limits, Admission(most * memory, memory), folder
    )


def run(pool, jobs):
    """Finished jobs by their place."""
    with pool:
        ended = [each for some in pool.results(list(enumerate(jobs))) for each in some]
    assert sorted(each.index for each in ended) == list(range(len(jobs)))
    return sorted(ended, key=lambda each: each.index)


def plan_of(folder: Path, texts: dict[str, str], out: Path) -> Plan:
    """A plan of one job per file, of files that hold the texts."""
    jobs = []
    for name, text in texts.items():
        file = folder / f"{name}.txt"
        file.write_text(text)
        jobs.append(Job(name, str(file), (), "formula", None, None, str(out / name)))
    out.mkdir(exist_ok=True)
    return Plan(tuple(jobs), {})


class Silent:
    """Told of everything, keeps it."""

    def __init__(self):
        self.names, self.texts, self.done_before, self.damaged = [], [], 0, 0

    def say(self, text):
        self.texts.append(text)

    def kept(self, count, total, damaged):
        self.done_before, self.damaged = count, damaged

    def workers(self, count):
        self.count = count

    def finished(self, outcome, timings):
        self.names.append(outcome["name"])

    def running(self, steps):
        steps()
