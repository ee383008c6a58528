"""Put the design files and the commands' real output into README.md and two pages of docs.

The first toml block of a page becomes the design it explains, if it explains one; a console block
keeps its `$` line and gets what that command prints.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOUR_BAR = ROOT / "ballesta" / "design" / "templates" / "four_bar.toml"
SHOWN = {
    ROOT / "README.md": FOUR_BAR,
    ROOT / "docs" / "design_files.md": ROOT / "designs" / "toggle_press.toml",
    ROOT / "docs" / "linkage_loads.md": None,
}
TOML = re.compile(r"(```toml\n)(.*?)(```\n)", re.DOTALL)
CONSOLE = re.compile(r"(```console\n\$ ballesta ([^\n]*)\n)(.*?)(```\n)", re.DOTALL)


@contextmanager
def folder() -> Iterator[Path]:
    """A folder with the machines and the template under the names that the pages use."""
    with tempfile.TemporaryDirectory() as name:
        there = Path(name)
        (there / "designs").symlink_to(ROOT / "designs")
        (there / FOUR_BAR.name).write_text(FOUR_BAR.read_text(encoding="utf-8"), encoding="utf-8")
        yield there


def printed(arguments: str, where: Path) -> str:
    """Output of a command, 120 columns wide."""
    done = subprocess.run(
        [sys.executable, "-m", "ballesta", *arguments.split()],
        cwd=where,
        capture_output=True,
        text=True,
        env=os.environ | {"COLUMNS": "120", "PYTHONPATH": str(ROOT)},
        check=False,
    )
    return done.stdout.strip()


def main() -> None:
    """Rewrite the pages."""
    with folder() as where:
        for page, design in SHOWN.items():
            text = page.read_text(encoding="utf-8")
            if design is not None:
                shown = design.read_text(encoding="utf-8")
                text = TOML.sub(lambda found, shown=shown: found[1] + shown + found[3], text, 1)
            for head, arguments, before, tail in CONSOLE.findall(text):
                new = f"{head}{printed(arguments, where)}\n{tail}"
                text = text.replace(head + before + tail, new)
            page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
