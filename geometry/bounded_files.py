"""Reading files that somebody names: whole ones of a bounded size, never a device or a pipe."""

import errno
import stat
from pathlib import Path

MEBIBYTE = 2**20
MOST_TEXT = 16 * MEBIBYTE  # of a design, a table, or a result
MOST_CAD = 128 * MEBIBYTE


def read_bounded(path: Path, most: int = MOST_TEXT) -> bytes:
    """Content of a file of at most so many bytes.

    Raises OSError with the reason in words for a larger one, and for what is no file: a device may
    have no end, and a pipe may never begin.
    """
    with_type = path.stat().st_mode
    if stat.S_ISDIR(with_type):
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if not stat.S_ISREG(with_type):
        raise OSError(errno.EINVAL, "is a device or a pipe, not a file", str(path))
    with path.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        told = f"has more than {most // MEBIBYTE} MiB, the most that is read"
        raise OSError(errno.EFBIG, told, str(path))
    return content
