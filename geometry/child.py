"""A Python process of our own that can be ended wherever it stands, and the pipe to it.

Signals of Python wait until a library returns: gmsh may mesh for minutes, CHOLMOD factorise. A
process that does nothing but wait can always answer, and end the one that works.
"""

import os
import subprocess
import sys
import threading
from contextlib import suppress
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from queue import SimpleQueue
from typing import Any, cast


class Child:
    """A started interpreter that calls a function "module:name" with one value: its `Parent`.

    Standard input, output and error are those of this process. It is in no group that a terminal
    interrupts, and ends with this process. To be used by one thread.
    """

    def __init__(self, function: str) -> None:
        self._pipe, theirs = Pipe()
        handle = theirs.fileno()
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; from geometry.child import serve; "
            f"serve({function!r}, {handle})"
        )
        self._process = _started([sys.executable, "-P", "-c", code], handle)
        theirs.close()

    def send(self, message: Any) -> None:
        """Send it anything that can be pickled; nothing happens if it has ended."""
        with suppress(OSError):
            self._pipe.send(message)

    def messages(self, seconds: float) -> list[Any] | None:
        """Wait so long for what it has sent; None when it has ended."""
        found: list[Any] = []
        try:
            while self._pipe.poll(0.0 if found else seconds):
                found.append(self._pipe.recv())
        except (EOFError, OSError):
            return found or None
        return found

    def ended(self) -> int:
        """Wait for its end; its exit code, below 0 the number of the signal that killed it."""
        return self._process.wait()

    def processor_seconds(self) -> float:
        """Processor time that it has taken, s; 0 when it is gone."""
        import psutil

        try:
            times = psutil.Process(self._process.pid).cpu_times()
        except psutil.Error:
            return 0.0
        return float(times.user + times.system)

    def kill(self) -> None:
        """End it and all that it has started, at once; nothing happens if it has ended."""
        if self._process.poll() is not None:
            return
        import psutil

        with suppress(psutil.NoSuchProcess):
            own = psutil.Process(self._process.pid)
            for process in [*own.children(recursive=True), own]:
                with suppress(psutil.NoSuchProcess):
                    process.kill()
        self._process.wait()


class Parent:
    """The other end, in the child, which ends with its parent."""

    def __init__(self, pipe: "Connection") -> None:
        self._pipe = pipe
        self._messages: SimpleQueue[Any] = SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def send(self, message: Any) -> None:
        """Send anything that can be pickled."""
        with suppress(OSError):  # it is gone, and so are we in a moment
            self._pipe.send(message)

    def receive(self) -> Any:
        """Wait for the next message."""
        return self._messages.get()

    def _read(self) -> None:
        with suppress(EOFError, OSError):
            while True:
                self._messages.put(self._pipe.recv())
        os._exit(1)  # the parent is gone


def serve(function: str, handle: int) -> None:
    """Call the function that the parent has named; the main program of a child."""
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection

        pipe = cast("Connection", PipeConnection(handle))  # equal but for the kind of handle
    else:
        os.set_inheritable(handle, False)
        pipe = Connection(handle)
    module, _, name = function.partition(":")
    getattr(import_module(module), name)(Parent(pipe))


def _started(command: list[str], handle: int) -> "subprocess.Popen[bytes]":
    """Start a process that inherits a handle, in a process group of its own."""
    if sys.platform == "win32":  # as documented; tried on no Windows machine yet
        os.set_handle_inheritable(handle, True)
        return subprocess.Popen(
            command,
            stdin=0,
            stdout=1,
            stderr=2,
            startupinfo=subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]}),
            creationflags=subprocess.CREATE_NEW_PROCESS_GROUP,
        )
    return subprocess.Popen(command, pass_fds=(handle,), process_group=0)
