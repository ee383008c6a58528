"""A page that a tool writes: written anew, or compared with what is there."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path


def write_or_check(
    file: Path, text: str, cure: str, description: str | None, arguments: Sequence[str] | None
) -> int:
    """Write a page, or with --check say whether it is up to date: then 1 if it is not.

    cure  the command that writes it
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--check", action="store_true", help="exit 1 if the page would change")
    if not parser.parse_args(arguments).check:
        file.write_text(text, encoding="utf-8")
        return 0
    current = file.read_text(encoding="utf-8") if file.exists() else ""
    if text != current:
        print(f"{file.name} is out of date: run {cure}", file=sys.stderr)
    return int(text != current)
