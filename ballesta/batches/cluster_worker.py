"""A dask worker's part of a batch: each job runs in a process of its own, as local ones do.

Each thread of a dask worker keeps one such process, for as long as jobs of the same batch come.

Replies are plain text of a known form, which names no code to run. A pickle can name any function
and have it called when it is read; so whoever can speak as a dask worker could run commands where
the batch was started. Replies are JSON here, of which every field is checked. Dask itself pickles
what it tells of its own (texts, lost workers, exceptions): while a batch is connected, such
messages are read by an unpickler that knows a few classes, and puts `Unread` for whatever else is
named.
"""

import builtins
import io
import os
import pickle
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ballesta.batches.job import text_digest
from ballesta.batches.pool import Finished, Limits, Pool, PoolError
from ballesta.batches.processes import Admission, planned_budget
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


CODE = "ballesta's code"
_LOOK_EVERY = 1.0  # s, whether the batch is still there


@dataclass(frozen=True)
class Site:
    """Origin of the jobs of a batch: key, folder, versions and limits.

    key       of the batch, another one each time that it is started
    mark      file that holds the key as long as the batch runs
    folder    that paths of the batch start from
    versions  of our code and of what else numbers depend on, by name
    function, seconds, memory  what runs a job, and what it may take, as in `executor.Settings`
    """

    key: str
    mark: str
    folder: str
    versions: Mapping[str, str]
    function: str
    seconds: float | None
    memory: int | None


class _Kept:
    """The pool of one thread, for one batch; whoever uses or ends it holds `busy`."""

    def __init__(self, thread: int, site: Site) -> None:
        self.thread, self.site = thread, site
        self.pool = _pool(site)
        self.busy = threading.Lock()
        self.ended = False

    def end(self) -> None:
        """End its process."""
        if not self.ended:
            self.ended = True
            _kept.pop(self.thread, None)
            self.pool.close()


_kept: dict[int, _Kept] = {}  # by thread


def run_there(index: int, job: Mapping[str, Any], site: Site) -> str:
    """Run a job of a batch in this dask worker; it is given up when the batch has ended.

    Returns a `Reply` as JSON.

    Raises PoolError where no process starts.
    """
    from distributed import get_worker

    worker = get_worker().address
    refused = refusal(site)
    if refused:
        return to_text(Reply(worker, refused))
    kept = _kept_for(site)
    with kept.busy:
        try:
            finished = None if kept.ended else _finished(index, job, kept)
        except PoolError as error:
            kept.end()
            raise PoolError(f"on worker {worker}: {error}") from error
        except BaseException:
            kept.end()
            raise
        if finished is None:
            kept.end()
            refused = "found the batch ended, or its folder gone"
            return to_text(Reply(worker, refused))
    file = os.path.realpath(Path(site.folder, job["file"]))
    sources: Mapping[str, str] = (finished.outcome or {}).get("sources", {})
    return to_text(Reply(worker, "", finished, {file: text_digest(Path(file)), **sources}))


def leave(key: str) -> None:
    """End the idle processes of a batch; those of running jobs end with them."""
    for kept in list(_kept.values()):
        if kept.site.key == key and kept.busy.acquire(blocking=False):
            try:
                kept.end()
            finally:
                kept.busy.release()


def refusal(site: Site) -> str:
    """Reason not to run jobs of a batch here; "" if there is none."""
    here = versions()
    for name, wanted in site.versions.items():
        if here.get(name) != wanted:
            told = "" if name == CODE else f" ({here.get(name)} there, {wanted} here)"
            return f"has another version of {name}{told}"
    if not Path(site.folder).is_dir():
        return f"does not see the folder {site.folder}, where the batch was started"
    mark = Path(site.folder, site.mark)
    try:
        found = mark.read_text(encoding="utf-8")
    except OSError:
        found = ""
    if found != site.key:
        return f"does not see the batch's folder {mark.parent}: both need a shared file system"
    if not os.access(mark.parent, os.W_OK | os.X_OK):
        return f"may not write to the batch's folder {mark.parent}"
    return ""


def versions() -> dict[str, str]:
    """Versions of all that a result depends on but its inputs; every process has one thread."""
    from checks.store.fingerprints import code_digest, libraries

    found = {name: version for name, version in libraries().items() if name != "threads"}
    return {CODE: code_digest(), **found}


def _finished(index: int, job: Mapping[str, Any], kept: _Kept) -> Finished | None:
    """A job that has ended; None if the batch did so before."""
    mark, look_at = Path(kept.site.folder, kept.site.mark), monotonic() + _LOOK_EVERY
    for ended in kept.pool.results([(index, job)]):
        if ended:
            return ended[0]
        if monotonic() >= look_at:
            if _is_gone(mark):
                return None
            look_at = monotonic() + _LOOK_EVERY
    return None


def _is_gone(file: Path) -> bool:
    try:
        file.stat()
    except FileNotFoundError:
        return True
    except OSError:  # a file server may be away for a moment
        return False
    return False


def _kept_for(site: Site) -> _Kept:
    """The pool of this thread for a batch; one for another batch is ended first."""
    thread = threading.get_ident()
    kept = _kept.get(thread)
    if kept is not None and kept.site != site:
        with kept.busy:
            kept.end()
        kept = None
    if kept is None:
        kept = _kept[thread] = _Kept(thread, site)
    return kept


def _pool(site: Site) -> Pool:
    """One process, with this thread's share of the dask worker's memory limit."""
    from distributed import get_worker

    worker = get_worker()
    limit = worker.memory_manager.memory_limit or planned_budget()
    share = site.memory or max(limit // worker.state.nthreads, 1)
    folder = Path(worker.local_directory) / f"ballesta-{threading.get_ident()}"
    return Pool(
        site.function, 1, Limits(site.seconds, share, share), Admission(share, share), folder,
        Path(site.folder),
    )  # fmt: skip
