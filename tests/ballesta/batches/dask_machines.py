"""A dask scheduler and its workers, real processes that talk over the loopback."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[3]

# Written to a folder that workers import from.
MODULE = '''
import os, signal, time
from hashlib import sha256
from pathlib import Path
from ballesta.batches.job import run_plain
from ballesta.batches.job import Job
from ballesta.batches.job import WRONG_INPUT, ended

def slowly(job):
    """A check that tells when it begins, and in which dask worker, and leaves time to kill that."""
    note(job)
    time.sleep(0.4)
    return run_plain(job)

def fate(job):
    """What the text of the job's file asks for: "hang", "die", "edit", or an outcome at once."""
    note(job)
    file = Path(job["file"])
    text = file.read_text()
    if text == "hang":
        time.sleep(60)
    if text == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if text == "die with the worker":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    if text == "edit":
        file.write_text("edited")
    time.sleep(float(text.partition("wait ")[2] or 0))
    job = Job(**{**job, "overrides": tuple(job["overrides"])})
    sources = {str(file.resolve()): sha256(text.encode()).hexdigest()}
    return ended(job, WRONG_INPUT, text, "") | {"sources": sources, "seconds": 0.0}

def note(job):
    with (Path(job["folder"]).parent / "begun").open("a") as begun:
        begun.write(f"{job['name']} {os.getppid()} {os.getpid()}\\n")
'''


class DaskMachines:
    """Starts a scheduler; `workers` are processes with one thread each.

    folder  of what they keep; holds the module `cluster_job_functions` for them
    allowed_failures  how many workers a job may take along before it is given up
    tls     folder of certificates for TLS; None for none
    """

    def __init__(self, folder: Path, allowed_failures: int = 3, tls: Path | None = None) -> None:
        self.folder = folder
        self._tls = [] if tls is None else [
            "--tls-ca-file", str(tls / "ca.pem"), "--tls-cert", str(tls / "cert.pem"),
            "--tls-key", str(tls / "key.pem"),
        ]  # fmt: skip
        self._environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT), str(folder)]),
            "DASK_CONFIG": str(folder),
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(allowed_failures),
        }
        (folder / "cluster_job_functions.py").write_text(MODULE)
        self.workers: list[subprocess.Popen] = []
        self.scheduler = self._start(
            "scheduler", *(["--protocol", "tls"] if tls else []), "--host", "127.0.0.1",
            "--port", "0", "--no-dashboard", "--dashboard-address", "127.0.0.1:0",
            "--scheduler-file", "scheduler.json",
        )  # fmt: skip
        self.address = _waited_for(lambda: self._address(), self.scheduler)

    def add_worker(self) -> None:
        """Start a worker; returns when the scheduler knows it."""
        name = f"worker_{len(self.workers)}"
        self.workers.append(
            self._start(
                "worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
                "--dashboard-address", "127.0.0.1:0", "--local-directory", name, log=name,
            )
        )  # fmt: skip
        log = self.folder / f"{name}.log"
        _waited_for(lambda: "Registered to" in log.read_text(), self.workers[-1])

    def kill(self) -> None:
        """End all of them."""
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()

    def _start(self, what: str, *options: str, log: str = "scheduler") -> subprocess.Popen:
        with (self.folder / f"{log}.log").open("wb") as output:
            return subprocess.Popen(
                [sys.executable, "-P", "-m", f"distributed.cli.dask_{what}", *options, *self._tls],
                cwd=self.folder, stdout=output, stderr=output, env=self._environment,
            )  # fmt: skip

    def _address(self) -> str:
        try:
            return json.loads((self.folder / "scheduler.json").read_text())["address"]
        except (OSError, ValueError):
            return ""


def _waited_for(found, process: subprocess.Popen):
    deadline = time.monotonic() + 30
    while not (answer := found()):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return answer


def begun(out: Path) -> list[tuple[str, int, int]]:
    """Name of every job that was begun, its dask worker's process and its own."""
    file = out / "begun"
    lines = file.read_text().splitlines() if file.exists() else []
    return [(name, int(worker), int(own)) for name, worker, own in map(str.split, lines)]


def ends(pid: int, within: float) -> bool:
    """Whether a process ends within some seconds."""
    deadline = time.monotonic() + within
    while time.monotonic() < deadline:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def kill(pid: int) -> None:
    """End a process at once."""
    os.kill(pid, signal.SIGKILL)
