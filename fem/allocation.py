"""Memory allocation of the C library, for arrays and factors."""

import ctypes
import sys

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
