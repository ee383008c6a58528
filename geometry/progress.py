"""A process that can be ended wherever it stands, and its progress, handed over to a supervisor.

Signals of Python wait until a library returns: gmsh may mesh for minutes, CHOLMOD factorise. A
process that does nothing but wait can always answer, and end the one that works.

Where nobody supervises (a library's user, a worker of a batch), telling falls back to lines on
standard error, and nothing is handed over.
"""

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from queue import SimpleQueue
from signal import Signals
from time import monotonic
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
            f"import sys; sys.path[:] = {sys.path!r}; from geometry.progress import serve; "
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


def signal_name(number: int) -> str:
    """Name of a signal of the system; the number where it has none for it.

    >>> signal_name(11), signal_name(0)
    ('SIGSEGV', '0')
    """
    return next((one.name for one in Signals if one == number), str(number))


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


@dataclass(frozen=True)
class Order:
    """The work that a child process is started for.

    argv   of the command line
    began  when the user gave it, on the clock of `monotonic`
    kept   what an ended predecessor had handed over, pickled, by name
    ended  why that one was ended, in words; "" where there was none
    stop   true if it reports what was kept, then ends
    """

    argv: Sequence[str]
    began: float
    kept: dict[str, bytes] = field(default_factory=dict)
    ended: str = ""
    stop: bool = False


# Progress of long work, and what of it is finished.
_parent: Parent | None = None
_order = Order((), 0.0)
_shown = False  # whether the supervisor's line of progress may stand on the terminal


def begin(parent: Parent, order: Order) -> None:
    """Tell this parent from now on, of the work that it ordered."""
    global _parent, _order
    _parent, _order = parent, order
    for stream in (sys.stdout, sys.stderr):
        if stream.isatty():
            _clear_before(stream)


def _clear_before(stream: Any) -> None:
    """Have the supervisor take its line from the terminal before anything is written there."""
    write = stream.write

    def cleared(text: str) -> int:
        global _shown
        if _shown and _parent is not None:
            _shown = False
            _parent.send(("clear",))
            _parent.receive()
        return int(write(text))

    stream.write = cleared


def step(text: str, name: str = "") -> None:
    """Tell what is done now, of the design of that name."""
    global _shown
    if _parent is not None:
        _shown = True
        _parent.send(("step", name, text))
    else:
        print(f"{name}: {text}" if name else text, file=sys.stderr, flush=True)


def expect(text: str, seconds: float) -> None:
    """Tell a supervisor what begins now and how long it may take, s."""
    if _parent is not None:
        _parent.send(("expect", text, seconds))


def is_supervised() -> bool:
    """True if a supervisor takes what is kept."""
    return _parent is not None


def keep(name: str, value: Any) -> None:
    """Hand something over, for a successor to go on with if this process is ended."""
    if _parent is not None:
        _parent.send(("keep", name, pickle.dumps(value, pickle.HIGHEST_PROTOCOL)))


def forget(prefix: str) -> None:
    """Take back what was handed over under names that begin so."""
    if _parent is not None:
        _parent.send(("forget", prefix))


def recovered(name: str) -> Any:
    """The value that an ended predecessor has handed over under a name; None for none."""
    return pickle.loads(_order.kept[name]) if name in _order.kept else None


def ended() -> str:
    """Why a predecessor was ended, in words; "" where there was none."""
    return _order.ended


def stops() -> bool:
    """True if this process reports what was recovered, then ends."""
    return _order.stop


def limit(seconds: float | None, before: float = 0.0) -> None:
    """Have the supervisor end this process when a time, s, is up; None for never.

    before  how much of it has passed
    """
    if _parent is not None:
        _parent.send(("limit", seconds, monotonic() - before))


def since_begun() -> float:
    """How long ago the user gave the command, s; 0 where nobody supervises."""
    return monotonic() - _order.began if _parent is not None else 0.0
