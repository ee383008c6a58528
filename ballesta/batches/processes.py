"""Processes with all that they start: how to end them, and how they end with who started them.

POSIX has process groups, Linux a death signal of the parent. Windows has neither: there the
children of a process are found by psutil, and the end of its standard input tells a worker that
nobody waits for it any more.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress


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
    try:
        return f"was killed by signal {signal.Signals(-code).name}"
    except ValueError:
        return f"was killed by signal {-code}"


def _kill_children(pid: int) -> None:
    """Kill the descendants of a process that are still running."""
    import psutil

    with suppress(psutil.Error):
        for child in psutil.Process(pid).children(recursive=True):
            with suppress(psutil.Error):
                child.kill()
