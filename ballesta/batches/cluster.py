"""A batch on the workers of a dask scheduler: the same jobs, used as `pool.Pool` is."""

import logging
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from secrets import token_hex
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from ballesta.batches.cluster_worker import (
    Site,
    from_text,
    leave,
    nothing_unpickled,
    run_there,
    versions,
)
from ballesta.batches.job import CRASHED, text_digest
from ballesta.batches.pool import Finished, PoolError
from checks.design.errors import DesignError
from checks.result.words import brief

if TYPE_CHECKING:
    from distributed import Client, Security

LOCAL = "local"
_CONNECT = 5.0  # s, until a scheduler counts as out of reach
_CLOSE = 5.0  # s, that leaving it may take
_LOOK_EVERY = 0.02  # s, for jobs that have ended
_COUNT_EVERY = 30.0  # s, for whether there are workers at all
_MARK = ".cluster-"  # how the name of the file begins that workers know the batch's folder by
_FORGED = "a worker's reply has not the form that it must have"
_GOES_ON = "; what is finished is kept, the same command goes on from there"

_Placed = tuple[int, Mapping[str, Any]]  # a job by its place


def scheduler_of(executor: str) -> str | None:
    """Address of the scheduler that `--executor` names, as dask writes it; None for this machine.

    Raises DesignError for anything else, and where dask.distributed is not installed.

    >>> scheduler_of("dask://10.0.0.5:8786")
    'tcp://10.0.0.5:8786'
    """
    if executor == LOCAL:
        return None
    found = re.fullmatch(r"(dask|tls)://(\[[0-9A-Fa-f:.]+\]|[\w.-]+):([0-9]{1,5})", executor)
    if found is None or not 0 < int(found[3]) < 65536:
        raise _error(
            "must be local or dask://HOST:PORT such as dask://10.0.0.5:8786, where the scheduler "
            f'listens, or tls://HOST:PORT with certificates, got "{brief(executor)}"'
        )
    if find_spec("distributed") is None:
        raise _error("needs dask.distributed: pip install 'ballesta[cluster]'")
    return f"{found[1].replace('dask', 'tcp')}://{found[2]}:{found[3]}"


def security_of(folder: Path) -> "Security":
    """Certificates for TLS both ways from the files ca.pem, cert.pem and key.pem of a folder.

    Raises DesignError of --tls where one is missing.
    """
    from distributed import Security

    files = {name: folder / f"{name}.pem" for name in ("ca", "cert", "key")}
    for file in files.values():
        if not file.is_file():
            told = f"needs ca.pem, cert.pem and key.pem: {file} is missing"
            raise DesignError(Path("command line"), "--tls", told)
    return Security(
        require_encryption=True,
        tls_ca_file=str(files["ca"]),
        tls_client_cert=str(files["cert"]),
        tls_client_key=str(files["key"]),
    )


class Cluster:
    """Runs jobs by a function that is named "module:function" on the workers of a scheduler.

    address  of the scheduler, as `scheduler_of` returns it
    seconds, memory  that a job may take, as in `executor.Settings`
    out      folder of the batch, which the workers see, too
    say      takes a text when there are no workers
    tls      folder of certificates, as `security_of` reads it; None for dask's own configuration

    Whatever keeps the batch from being run as asked is a DesignError of --executor.
    """

    def __init__(
        self,
        address: str,
        function: str,
        seconds: float | None,
        memory: int | None,
        out: Path,
        say: Callable[[str], None],
        tls: Path | None = None,
    ) -> None:
        self._address, self._out, self._say = address, out, say
        self._security = None if tls is None else security_of(tls)
        key = token_hex(16)
        self._mark = out / f"{_MARK}{key[:8]}"
        self._site = Site(key, str(self._mark), os.getcwd(), versions(), function, seconds, memory)
        self._client: Client | None = None
        self._guard = ExitStack()
        self._count_at = 0.0

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def at_a_time(self) -> int:
        """Number of jobs that run beside each other: the threads of the dask workers."""
        with self._asked() as client:
            return sum(client.nthreads().values())

    @property
    def running(self) -> list[tuple[int, float, Sequence[str]]]:
        """Always empty: dask does not report the step of a running job."""
        return []

    def start(self, jobs: int) -> None:
        """Connect to the scheduler, and let workers know the batch's folder by a file in it."""
        from distributed import Client

        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # told in our own words
        self._guard.enter_context(nothing_unpickled())
        try:
            self._client = Client(
                self._address,
                timeout=_CONNECT,
                set_as_default=False,
                direct_to_workers=False,
                security=self._security,
                deserializers=["pickle", "msgpack", "error"],
            )
        except (OSError, ImportError) as error:
            cause = str(error).partition("\n")[0]
            raise _error(
                f"no dask scheduler answers at {_shown(self._address)} ({cause}): start "
                "`dask scheduler` there, or correct the address"
            ) from error
        for stale in self._out.glob(f"{_MARK}*"):  # of a batch that was killed: its jobs end now
            stale.unlink(missing_ok=True)
        self._mark.write_text(self._site.key, encoding="utf-8")

    def results(self, jobs: Sequence[_Placed]) -> Iterator[list[Finished]]:
        """Run jobs, (place, plain data); yields those that ended since the last time.

        Also yields an empty list many times a second. Raises PoolError where processes do not
        start on a worker.
        """
        suspects: list[_Placed] = []
        yield from self._results(jobs, suspects)
        for job in suspects:  # by itself: most only waited for the worker that another took along
            yield from self._results([job], None)

    def _results(
        self, jobs: Sequence[_Placed], suspects: list[_Placed] | None
    ) -> Iterator[list[Finished]]:
        """Run jobs; those whose dask workers keep dying become suspects, or have crashed."""
        from distributed import as_completed

        job_of = dict(jobs)
        places, data = [place for place, _ in jobs], [job for _, job in jobs]
        with self._asked() as client:
            futures = client.map(run_there, places, data, site=self._site, pure=False)
            ended = as_completed(futures, loop=client.loop, with_results=True, raise_errors=False)
        place_of = {future.key: place for future, place in zip(futures, places, strict=True)}
        del futures  # what has ended is forgotten, here and on the cluster
        self._count_at = monotonic() + _COUNT_EVERY
        while place_of:
            finished: list[Finished] = []
            trouble: Exception | None = None
            for future, reply in ended.next_batch(block=False):
                place = place_of.pop(future.key)
                try:
                    if suspects is not None and _dask_gave_up(reply):
                        suspects.append((place, job_of[place]))
                    else:
                        finished.append(self._taken(place, reply))
                except (DesignError, PoolError) as error:
                    trouble = error
            yield finished
            if trouble is not None:
                raise trouble
            if client.status != "running":
                raise self._lost()
            if not finished:
                self._tell_if_nobody_works()
                sleep(_LOOK_EVERY)

    def close(self) -> None:
        """Leave the cluster; jobs that are being run there end within seconds."""
        with suppress(OSError):
            self._mark.unlink(missing_ok=True)
        with self._guard:
            self._leave()

    def _leave(self) -> None:
        from distributed import fire_and_forget

        if self._client is None:
            return
        if self._client.status == "running":
            with suppress(DesignError), self._asked() as client:
                for worker in client.nthreads():
                    options = {"workers": [worker], "allow_other_workers": True, "pure": False}
                    fire_and_forget(client.submit(leave, self._site.key, **options))
        self._client.close(timeout=_CLOSE)

    def _taken(self, place: int, reply: Any) -> Finished:
        """Outcome of a job, from its reply or from dask's own words in place of one."""
        from distributed import CancelledError

        if isinstance(reply, str):
            return self._told(place, reply)
        if isinstance(reply, CancelledError):
            raise self._lost()
        if not (isinstance(reply, tuple) and len(reply) == 3):
            raise _error(f"{_FORGED}: it is {type(reply).__name__}")
        _, error, _ = reply
        if isinstance(error, PoolError):
            raise error
        if _dask_gave_up(reply):
            attempts = 2 * (int(error.allowed_failures) + 1)
            last = brief(getattr(error.last_worker, "address", "one that is not told"))
            text = f"every dask worker that had it died, alone with it, too; the last was {last}"
            return Finished(place, None, 0.0, 0, attempts, CRASHED, text)
        told = brief(" ".join(str(error).split()), 1000)
        raise _error(
            f"a job does not run on the cluster ({type(error).__name__}: {told}): its scheduler "
            "and workers need ballesta and the libraries as they are installed here"
        )

    def _told(self, place: int, text: str) -> Finished:
        """The job that a worker has ended; raises DesignError for anything else."""
        try:
            reply = from_text(text)
        except ValueError as error:
            raise _error(f"{_FORGED}: {error}") from None
        if reply.finished is None:
            raise _error(f"worker {brief(reply.worker)} {brief(reply.refused, 1000)}")
        if reply.finished.index != place:
            raise _error(f"worker {brief(reply.worker)} replied of a job that it was not given")
        for file, digest in (reply.texts or {}).items():
            if text_digest(Path(file)) != digest:
                raise _error(
                    f"{file} differs between worker {brief(reply.worker)} and here: it must be on "
                    f"a shared file system, or it was edited just now{_GOES_ON}"
                )
        return reply.finished

    def _tell_if_nobody_works(self) -> None:
        if monotonic() > self._count_at:
            self._count_at = monotonic() + _COUNT_EVERY
            if not self.at_a_time:
                self._say(f"no dask worker is at {_shown(self._address)}: waiting for some")

    @contextmanager
    def _asked(self) -> "Iterator[Client]":
        """Yield who asks the scheduler; raises DesignError when it does not answer."""
        assert self._client is not None
        try:
            yield self._client
        except (OSError, RuntimeError) as error:  # dask's own errors are of these kinds
            raise self._lost() from error

    def _lost(self) -> DesignError:
        return _error(f"the dask scheduler at {_shown(self._address)} was lost{_GOES_ON}")


def _dask_gave_up(reply: Any) -> bool:
    """True if dask gave a job up since the workers that had it died, one after the other."""
    from distributed import KilledWorker

    return isinstance(reply, tuple) and isinstance(reply[1], KilledWorker)


def _shown(address: str) -> str:
    return address.replace("tcp://", "dask://", 1)


def _error(problem: str) -> DesignError:
    return DesignError(Path("command line"), "--executor", problem)
