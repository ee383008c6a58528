"""A worker process of a batch: jobs come in as lines of JSON, outcomes go out as lines of JSON.

python -P -m ballesta.batches.worker MODULE:FUNCTION   the function that a job's data is given to

It dies with the process that started it, so that nobody else's batch finds it still writing.
"""

import faulthandler
import json
import os
import sys
import threading
import traceback
from collections.abc import Callable
from importlib import import_module
from typing import Any, BinaryIO

from ballesta.batches.outcome import CRASHED, OUT_OF_MEMORY
from ballesta.batches.processes import (
    die_with_parent,
    end_ourselves,
    limit_memory,
    peak_bytes,
    reset_peak,
    resident_bytes,
)


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
