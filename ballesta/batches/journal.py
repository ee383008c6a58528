"""Journal of a batch: a file of JSON lines, one per finished job, to which lines are only added.

Every line carries the sha256 of what it says. A line that was cut short by a kill is cut away, one
that has been damaged is left aside, and their designs are checked again.
"""

import json
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any, Self

_SYNC_EVERY = 1.0  # s; waiting for the disk after each job would keep workers waiting, too
Write = Callable[[int, bytes], int]


@dataclass(frozen=True)
class JournalEntry:
    """A job that has ended.

    key      digest of the job, the code and the libraries
    sources  files that its design was read from, by their paths from the batch's folder -> sha256
             of their texts
    result   sha256 of its result.json; "" without one
    outcome  as `run_job` returns it, without timings
    timings  seconds, peak_memory_bytes, attempts
    """

    key: str
    sources: Mapping[str, str]
    result: str
    outcome: dict[str, Any]
    timings: Mapping[str, float]


class Journal:
    """The journal of a folder. Opening reads it; raises OSError for a file that takes nothing.

    damaged  number of lines that were left aside
    write    how bytes reach the file, as `os.write`
    """

    def __init__(self, path: Path, write: Write = os.write) -> None:
        self._write, self._synced = write, monotonic()
        self.entries: dict[str, JournalEntry] = {}
        self.damaged = 0
        self._stream = path.open("a+b", buffering=0)
        self._file = self._stream.fileno()
        try:
            self._size = self._read(path)
            os.ftruncate(self._file, self._size)
        except BaseException:
            self._stream.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            os.fsync(self._file)
        finally:
            self._stream.close()

    def add(self, entries: Iterable[JournalEntry]) -> None:
        """Add entries: all of them or, with an OSError, none.

        A kill of any process loses none of them, a loss of power those of the last second.
        """
        entries = list(entries)
        if not entries:
            return
        data = b"".join(_line(entry) for entry in entries)
        left = data
        try:
            while left:
                left = left[self._write(self._file, left) :]
            if monotonic() - self._synced > _SYNC_EVERY:
                os.fsync(self._file)
                self._synced = monotonic()
        except OSError:
            os.ftruncate(self._file, self._size)
            raise
        self._size += len(data)
        self.entries.update((entry.key, entry) for entry in entries)

    def _read(self, path: Path) -> int:
        """Take in all lines; returns the size up to the end of the last whole one."""
        size = 0
        with path.open("rb") as lines:
            for line in lines:
                if not line.endswith(b"\n"):
                    break
                size += len(line)
                entry = _entry(line)
                if entry is None:
                    self.damaged += 1
                else:
                    self.entries[entry.key] = entry
        return size


def _line(entry: JournalEntry) -> bytes:
    text = json.dumps(vars(entry), allow_nan=False, separators=(",", ":"))
    return f'{{"sha256":"{sha256(text.encode()).hexdigest()}","entry":{text}}}\n'.encode()


def _entry(line: bytes) -> JournalEntry | None:
    """The entry of a line; None if the line is not as it was written."""
    head, found, text = line.rstrip(b"\n").partition(b'","entry":')
    if not found or head != b'{"sha256":"' + sha256(text[:-1]).hexdigest().encode():
        return None
    return JournalEntry(**json.loads(text[:-1]))
