"""Replies of a cluster's workers: plain text of a known form, which names no code to run.

A pickle can name any function and have it called when it is read; so whoever can speak as a dask
worker could run commands where the batch was started. Replies are JSON here, of which every field
is checked. Dask itself pickles what it tells of its own (texts, lost workers, exceptions): while a
batch is connected, such messages are read by an unpickler that knows a few classes, and puts
`Unread` for whatever else is named.
"""

import builtins
import io
import pickle
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ballesta.batches.pool import Finished, PoolError
from checks.result.words import brief

_PLAIN = ("bool", "bytearray", "bytes", "complex", "dict", "float", "frozenset", "int", "list",
          "set", "str", "tuple")  # fmt: skip
_DASK = {"distributed.scheduler": ("KilledWorker", "WorkerState")}
_STRICT = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Reply:
    """Outcome of a job on a dask worker.

    worker    its address
    refused   why the job was not run or not ended; "" if it was
    finished  what came of the job
    texts     files that the job was read from -> sha256 of their texts; None if unreadable
    """

    __pydantic_config__ = _STRICT

    worker: str
    refused: str = ""
    finished: Finished | None = None
    texts: Mapping[str, str | None] | None = None


_REPLY = TypeAdapter(Reply)


def to_text(reply: Reply) -> str:
    """A reply as JSON."""
    return _REPLY.dump_json(reply).decode()


def from_text(text: str) -> Reply:
    """Parse a reply; raises ValueError with the first field that is wrong."""
    try:
        return _REPLY.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "it"
        raise ValueError(brief(f"{place}: {first['msg']}", 200)) from None


class Unread(Exception):
    """Stands for a thing in a pickle that is not made: it takes what that would, and does nothing.

    It is an exception, as dask wants one for the failure of a job whatever was pickled.
    """

    def __init__(self, *_: object, **__: object) -> None:
        super().__init__("of a kind that is not read here")

    def _taken(self, *_: object, **__: object) -> None:
        return None

    __setitem__ = append = extend = add = update = __setstate__ = _taken


class _Harmless(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        if module == "builtins" and name in _PLAIN:
            return getattr(builtins, name)
        if module == "builtins":
            found = getattr(builtins, name, None)
            error = isinstance(found, type) and issubclass(found, Exception)
            return found if error else Unread
        if name in _DASK.get(module, ()):
            from distributed import scheduler

            return getattr(scheduler, name)
        if (module, name) == (PoolError.__module__, PoolError.__qualname__):
            return PoolError
        if module.startswith("tblib."):
            return _TBLIB.get(name, Unread)
        return Unread


def _no_traceback(*_: object) -> None:
    return None


def _exception(kind: type[Exception], args: Sequence[object], *_: object) -> Exception:
    """An exception as tblib pickles it, without its traceback and cause."""
    return kind(*args)


def _exception_with(
    kind: type[Exception], attributes: Mapping[str, object], *rest: object
) -> Exception:
    args = rest[5] if len(rest) > 5 else ()
    made = kind.__new__(kind, *args) if isinstance(args, tuple) else kind()
    for name, value in attributes.items():
        setattr(made, name, value)
    return made


_TBLIB = {
    "unpickle_traceback": _no_traceback,
    "unpickle_exception": _exception,
    "unpickle_exception_with_attrs": _exception_with,
}


class _Pickle:
    """The module pickle with a `loads` restricted to known classes."""

    def __getattr__(self, name: str) -> Any:
        return getattr(pickle, name)

    @staticmethod
    def loads(data: bytes, *, buffers: Sequence[Any] = ()) -> Any:
        """Read a pickle; whatever it names beyond a few classes is `Unread`."""
        return _Harmless(io.BytesIO(data), buffers=buffers).load()


@contextmanager
def nothing_unpickled() -> Iterator[None]:
    """Restrict unpickling by dask.distributed in this process to known classes.

    A failure has no traceback then: dask stumbles over one that is none, and waits for ever.
    """
    from distributed import client, core
    from distributed.protocol import pickle as protocol

    plain = core.clean_exception

    def failure(exception: Any, *_: object, **__: object) -> Any:
        try:
            return plain(exception)
        except AssertionError:
            return plain("a worker reports a failure that is no exception")

    kept = client.pickle, protocol.pickle, client.clean_exception
    client.pickle = protocol.pickle = _Pickle()
    core.clean_exception = client.clean_exception = failure
    try:
        yield
    finally:
        client.pickle, protocol.pickle, client.clean_exception = kept
        core.clean_exception = plain
