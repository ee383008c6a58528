"""A dask worker's part of a batch: each job runs in a process of its own, as local ones do.

Each thread of a dask worker keeps one such process, for as long as jobs of the same batch come.
"""

import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

from ballesta.batches.cluster_reply import Reply, to_text
from ballesta.batches.job import text_digest
from ballesta.batches.pool import Finished, Limits, Pool, PoolError
from ballesta.batches.processes import Admission, planned_budget

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
