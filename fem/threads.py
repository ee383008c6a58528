"""Threads of linear algebra: one, but two in a factorisation that is large enough to gain by them.

Measured on 4 cores (python -m bench.threads): below 100 000 unknowns two threads save less than a
tenth of a second, beside other work any number above one loses. Two threads take 0.66 of the time
on 570 000 unknowns and lose nothing beside other work; four take 0.46 of it on an idle machine and
2.5 times as long on a busy one.

OpenBLAS and MKL have pools of their own, whose sizes can be set at run time (threadpoolctl).
Debian's CHOLMOD asks for an OpenMP team of four whatever OMP_NUM_THREADS says
(CHOLMOD_OMP_NUM_THREADS in cholmod_core.h of SuiteSparse 5). Its threads spin at barriers where
others wait for a core, so parallel regions are inactive while it factorises:
omp_set_max_active_levels(0), OpenMP 5.2, 18.3.10, which holds for the calling thread.
"""

import ctypes
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

LARGE = 100_000  # unknowns
_SEVERAL = 2
OWN = "BALLESTA_THREADS"
_POOLS = ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")

# What makes a process run one thread, whatever it loads: of workers that run side by side.
ONE_THREAD: Mapping[str, str] = {
    name: "1"
    for name in (OWN, *_POOLS, "OMP_THREAD_LIMIT", "LP_NUM_THREADS", "VTK_SMP_MAX_THREADS")
}  # the last two of software that draws


def policy() -> str:
    """Threads of linear algebra in words, as results state them and digests compare them.

    Raises ValueError for a wrong BALLESTA_THREADS.
    """
    kept = _of_environment()
    if kept:
        return "as the environment says: " + ", ".join(f"{k}={v}" for k, v in kept.items())
    return "1" if _several() == 1 else f"1; {_several()} from {LARGE} unknowns"


@contextmanager
def one_thread() -> Iterator[None]:
    """Let linear algebra take one thread, also in libraries that are loaded meanwhile.

    Pools that the environment sizes on purpose (OPENBLAS_NUM_THREADS, MKL_NUM_THREADS,
    OMP_NUM_THREADS) are left as they are. Raises ValueError for a wrong BALLESTA_THREADS.
    """
    if _of_environment():
        yield
        return
    from threadpoolctl import threadpool_limits

    _several()
    ours = {name: "1" for name in _POOLS} | {OWN: os.environ.get(OWN) or "auto"}
    before = {name: os.environ.get(name) for name in ours}
    os.environ.update(ours)
    try:
        with threadpool_limits(1, user_api="blas"):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def threads_for(unknowns: int, *, team: bool = True) -> Iterator[None]:
    """Let linear algebra take the threads that a factor of so many unknowns is worth.

    team    False holds teams of OpenMP to one thread, for CHOLMOD's cannot be sized, and spins. Not
            around PARDISO: MKL crashes where it is refused the team that it has been promised.
    """
    kept = _of_environment()
    if kept and team:
        yield
        return
    libraries = _controller.__wrapped__(0) if team else _controller(len(sys.modules))
    with ExitStack() as stack:
        for library in [] if team else libraries.select(prefix="libgomp").lib_controllers:
            levels = library.dynlib.omp_get_max_active_levels()
            library.dynlib.omp_set_max_active_levels(0)
            stack.callback(library.dynlib.omp_set_max_active_levels, levels)
        if not kept:
            most = _several() if unknowns >= LARGE else 1
            stack.enter_context(libraries.limit(limits=most, user_api="blas"))
        yield


@lru_cache(maxsize=1)
def _controller(_modules: int) -> "ThreadpoolController":
    """Pools of the libraries that are loaded: read out of the whole map of the memory, 1 to 5 ms.

    Kept until modules are loaded, which may bring libraries. MKL's comes with none.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def _of_environment() -> dict[str, str]:
    """Sizes of thread pools that the environment states, unless ballesta itself wrote them."""
    if os.environ.get(OWN):
        return {}
    return {name: os.environ[name] for name in _POOLS if os.environ.get(name)}


def _several() -> int:
    """Threads of a large factorisation."""
    stated = os.environ.get(OWN) or "auto"
    if stated != "auto":
        if not stated.isdecimal() or int(stated) < 1:
            raise ValueError(f'{OWN} must be a whole number above 0 or "auto", got "{stated}"')
        return int(stated)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    limit = os.environ.get("OMP_THREAD_LIMIT", "")  # PARDISO fails (error -2) if it asks for more
    return max(1, min(_SEVERAL, cores or 1, int(limit) if limit.isdecimal() else _SEVERAL))


# Memory allocation of the C library, for arrays and factors.

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of mallopt(3)
_LARGE = 2**30  # bytes; mallopt takes an int


def keep_freed_memory() -> bool:
    """Let this process keep freed memory for its next arrays; return True if the C library does so.

    By default glibc maps arrays above some size anew and gives them back when they are freed, and
    the first touch of each page costs more than the work on it: a tenth of the time from mesh to
    stress basis (bench/solid.py), for 3 to 7 % more memory at the peak. mallopt(3); elsewhere than
    on glibc nothing changes.
    """
    if not sys.platform.startswith("linux"):
        return False
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is None:
        return False
    return bool(mallopt(_MMAP_THRESHOLD, _LARGE)) and bool(mallopt(_TRIM_THRESHOLD, _LARGE))
