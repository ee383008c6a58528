"""Put the design file and the commands' real output into README.md.

The first toml block becomes the toggle press; a console block keeps its `$` line and gets what that
command prints.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
TOML = re.compile(r"(```toml\n)(.*?)(```\n)", re.DOTALL)
CONSOLE = re.compile(r"(```console\n\$ ballesta ([^\n]*)\n)(.*?)(```\n)", re.DOTALL)


def design_text() -> str:
    """The design file that the README explains."""
    return (ROOT / "designs" / "toggle_press.toml").read_text(encoding="utf-8")


def main() -> None:
    """Rewrite README.md."""
    text = README.read_text(encoding="utf-8")
    text = TOML.sub(lambda found: found[1] + design_text() + found[3], text, count=1)
    for found in CONSOLE.findall(text):
        done = subprocess.run(
            [sys.executable, "-m", "ballesta.cli", *found[1].split()],
            cwd=ROOT,
            capture_output=True,
            text=True,
            env=os.environ | {"COLUMNS": "120"},
            check=False,
        )
        head, _, before, tail = found
        text = text.replace(head + before + tail, f"{head}{done.stdout.strip()}\n{tail}")
    README.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
