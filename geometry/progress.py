"""Progress of long work, and what of it is finished: told and handed over to a supervisor.

Where nobody supervises (a library's user, a worker of a batch), telling falls back to lines on
standard error, and nothing is handed over.
"""

import pickle
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from geometry.child import Parent


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
