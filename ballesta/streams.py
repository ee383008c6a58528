"""Standard output and standard error of the program."""

import os
import sys
from contextlib import suppress
from io import TextIOWrapper


def claim_standard_output() -> None:
    """Leave standard output to this program: what libraries print there goes to standard error.

    Tetgen inside gmsh tells of intersecting facets by C's printf, in front of what `--json` prints.
    """
    stream = sys.stdout
    if stream is not sys.__stdout__ or not isinstance(stream, TextIOWrapper):
        return
    stream.flush()
    own = os.dup(1)
    with suppress(OSError):  # there is no standard error: all stays as it is
        os.dup2(2, 1)
        sys.stdout = os.fdopen(own, "w", encoding=stream.encoding, errors=stream.errors)
        sys.__stdout__ = sys.stdout  # type: ignore[misc]  # it tells how wide the terminal is


def finish_standard_output() -> None:
    """Hand over what is printed; a reader that has seen enough, such as `head`, is no error."""
    stream = sys.__stdout__  # sys.stdout may be one that typer has put before it
    if stream is None:
        return
    try:
        stream.flush()
    except BrokenPipeError:  # the interpreter would flush once more at its end, and complain
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def speak_utf8() -> None:
    """Write UTF-8 into files and pipes: Windows' code pages have no minus sign and no sigma."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.encoding.lower() != "utf-8":
            stream.reconfigure(encoding="utf-8")
