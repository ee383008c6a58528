"""Processes with all that they start: how to end them, how they end, and the memory they may take.

POSIX has process groups, Linux a death signal of the parent. Windows has neither: there the
children of a process are found by psutil, and the end of its standard input tells a worker that
nobody waits for it any more.

python -P -m ballesta.batches.processes MODULE:FUNCTION is a worker of a batch: jobs come in as
lines of JSON for the function, outcomes go out as lines of JSON. It dies with the process that
started it, so that nobody else's batch finds it still writing.
"""

import faulthandler
import json
import os
import re
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

from ballesta.batches.job import CRASHED, OUT_OF_MEMORY
from geometry.progress import signal_name


def end_with_children(process: "subprocess.Popen[bytes]") -> None:
    """Kill a process that was started in a session of its own, and everything that it started."""
    if sys.platform == "win32":
        _kill_children(process.pid)
        process.kill()
    else:
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def end_ourselves() -> None:
    """End this process, which leads a session of its own, and everything that it started."""
    if sys.platform == "win32":
        _kill_children(os.getpid())
        os._exit(1)
    else:
        os.killpg(0, signal.SIGKILL)


def die_with_parent() -> None:
    """Have Linux kill this process with its parent; elsewhere the end of its input tells it.

    A library that holds Python's lock for minutes keeps the thread that reads from noticing.
    prctl(2), PR_SET_PDEATHSIG.
    """
    if sys.platform.startswith("linux"):
        import ctypes

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def ending(code: int) -> str:
    """End of a process in words: its exit code or its signal.

    >>> ending(-11), ending(1)
    ('was killed by signal SIGSEGV', 'ended with exit code 1')
    """
    if code >= 0:
        return f"ended with exit code {code}"
    return f"was killed by signal {signal_name(-code)}"


def _kill_children(pid: int) -> None:
    """Kill the descendants of a process that are still running."""
    import psutil

    with suppress(psutil.Error):
        for child in psutil.Process(pid).children(recursive=True):
            with suppress(psutil.Error):
                child.kill()


# Memory of the machine and of a job, and the number of jobs that fit beside each other.

MIB = 2**20
# Largest resident size of a worker, measured over the four machines of designs/; solids of
# 140 000 unknowns take 1.3 GiB to solve (checks/stress/kept_models.py) beside meshing and judging.
FIRST_ESTIMATES = {"formula": 600 * MIB}
FIRST_ESTIMATE = 2048 * MIB
_SHARE = 0.9  # of what is available at the start may be planned for
_BESIDE = 1.2  # times the largest job so far is expected of the next
_UNITS = {"MB": 10**6, "GB": 10**9, "MIB": 2**20, "GIB": 2**30}


def parse_memory(text: str) -> int:
    """Bytes of "4 GB", "500 MiB"; raises ValueError with the words.

    >>> parse_memory("1.5 GB")
    1500000000
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([A-Za-z]+)\s*", text)
    unit = _UNITS.get(found[2].upper()) if found else None
    if found is None or unit is None:
        raise ValueError(f'must be a size in MB, GB, MiB or GiB such as "4 GB", got {text!r}')
    size = int(float(found[1]) * unit)
    if size < 256 * MIB:
        raise ValueError(f"must be at least 256 MiB, which reading a design takes, got {text!r}")
    return size


@dataclass
class Admission:
    """Number of jobs that fit beside each other, by the largest job so far.

    budget    bytes that all of them may take together
    estimate  bytes that one takes, before one has been measured
    """

    budget: int
    estimate: int
    _largest: int = field(default=0, init=False)

    def saw(self, peak: int) -> None:
        """Note how much a job took."""
        self._largest = max(self._largest, peak)

    def fitting(self, most: int) -> int:
        """Number of jobs that fit beside each other, at least 1 and at most `most`."""
        expected = int(_BESIDE * self._largest) or self.estimate
        return max(1, min(most, self.budget // expected))


def planned_budget() -> int:
    """Bytes that a batch may plan for."""
    from geometry.memory import available_bytes  # loads SciPy, which a worker need not wait for

    return int(_SHARE * available_bytes())


def limit_memory(cap: int) -> None:
    """Let allocations beyond a cap fail in this process, on Linux; the pool watches what it takes.

    Above the cap by a quarter and what libraries reserve without touching it: it is there for what
    grows faster than anyone looks.
    """
    if not sys.platform.startswith("linux"):
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = cap + cap // 4 + 256 * MIB
    soft = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def reset_peak() -> None:
    """Begin to measure this process's peak anew, where the system can."""
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:
        return


def peak_bytes() -> int:
    """Largest resident size of this process since `reset_peak`.

    Of its whole life on Windows, and what it is now on systems that tell no peak.
    """
    found = _status("VmHWM")
    if found is not None:
        return found
    import psutil

    taken = psutil.Process().memory_info()
    return int(getattr(taken, "peak_wset", taken.rss))


def resident_bytes(pid: int | None = None) -> int:
    """Resident size of a process, this one if none is named; 0 when it is gone."""
    import psutil

    try:
        return int(psutil.Process(os.getpid() if pid is None else pid).memory_info().rss)
    except psutil.Error:
        return 0


def _status(name: str) -> int | None:
    try:
        text = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    found = re.search(rf"^{name}:\s+(\d+) kB$", text, re.MULTILINE)
    return int(found[1]) * 1024 if found else None


def main() -> None:
    """Serve until standard input ends."""
    faulthandler.enable()
    die_with_parent()
    replies = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what a library prints must not be read as a reply
    module, _, name = sys.argv[1].partition(":")
    function = getattr(import_module(module), name)
    lines = _Lines()
    _send(replies, {"ready": True})
    for line in lines:
        request = json.loads(line)
        limit_memory(request["memory"])
        reset_peak()
        reply = answer(function, request["job"])
        _send(replies, reply | {"peak": peak_bytes(), "resident": resident_bytes()})


def answer(function: Callable[[Any], Any], job: Any) -> dict[str, Any]:
    """Return value of a job's function, or its error, as the worker sends it."""
    try:
        outcome = function(job)
        json.dumps(outcome, allow_nan=False)
    except MemoryError:
        return {"failed": OUT_OF_MEMORY, "error": "there was not enough memory"}
    except Exception as error:  # a bug of ours costs this job alone
        traceback.print_exc()
        what = "".join(traceback.format_exception_only(error)).strip()
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{os.path.basename(place.filename)}:{place.lineno}"
        return {"failed": CRASHED, "error": f"internal error, not the design's fault: {what} "
                f"({where})", "kind": type(error).__name__}  # fmt: skip
    return {"outcome": outcome}


def _send(stream: BinaryIO, message: dict[str, Any]) -> None:
    data = json.dumps(message, allow_nan=False).encode() + b"\n"
    while data:
        data = data[stream.write(data) :]


class _Lines:
    """Lines of standard input, read by a thread: when the parent is gone, so are we at once."""

    def __init__(self) -> None:
        from queue import SimpleQueue

        self._queue: SimpleQueue[bytes] = SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in sys.stdin.buffer:
            self._queue.put(line)
        end_ourselves()

    def __iter__(self) -> "_Lines":
        return self

    def __next__(self) -> bytes:
        return self._queue.get()


if __name__ == "__main__":
    main()
