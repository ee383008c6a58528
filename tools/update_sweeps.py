"""Put what the Python blocks of docs/sweeps.md print behind them.

A text block that ends with a line `...` keeps as many lines as it had before it.
"""

import contextlib
import io
import os
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "sweeps.md"
BLOCK = re.compile(r"(```python\n(.*?)```\n\n```text\n)(.*?)(```)", re.DOTALL)


def printed(found: re.Match[str]) -> str:
    """A block and what it prints now."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        exec(compile(found[2], PAGE.name, "exec"), {"__name__": "example"})
    lines = told.getvalue().splitlines(keepends=True)
    if found[3].endswith("\n...\n"):
        lines = [*lines[: found[3].count("\n") - 1], "...\n"]
    return found[1] + "".join(lines) + found[4]


def main() -> None:
    """Rewrite docs/sweeps.md."""
    os.chdir(ROOT)
    PAGE.write_text(BLOCK.sub(printed, PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
