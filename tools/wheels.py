"""Wheels of all that ballesta needs, for each system and Python: an install without a compiler.

python tools/wheels.py    (make wheels)

Asks the package index that pip is set up with and downloads no wheel: `pip install --dry-run
--only-binary=:all:` chooses the same files as `pip download` would. Exit code 1 where none are.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ("3.11", "3.13")
# glibc of Debian 12 is 2.36; MKL's wheels ask for 2.28. gmsh has no wheel for macOS 11.
SYSTEMS = {
    "Windows": (["win_amd64"], "pardiso"),
    "Linux": ([f"manylinux_2_{minor}_x86_64" for minor in range(28, 16, -1)], "pardiso"),
    "macOS 12 on Apple silicon": (["macosx_12_0_arm64"], None),
}


def needs(extra: str | None) -> list[str]:
    """Requirements that pip is asked for."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project["dependencies"] + (project["optional-dependencies"][extra] if extra else [])


def resolved(platforms: list[str], extra: str | None, python: str) -> tuple[int, str]:
    """Number of wheels that pip would take, and what it says if there are none."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        done = subprocess.run(
            [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--ignore-installed",
             "--only-binary=:all:", "--python-version", python, "--target", folder,
             "--report", str(report), *(f"--platform={name}" for name in platforms), *needs(extra)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            return 0, done.stderr.strip()
        return len(json.loads(report.read_text(encoding="utf-8"))["install"]), ""


def main() -> int:
    """Print a line for each system and Python."""
    asked = [(name, python) for name in SYSTEMS for python in PYTHONS]
    with ThreadPoolExecutor() as pool:
        found = list(pool.map(lambda one: resolved(*SYSTEMS[one[0]], one[1]), asked))
    for (name, python), (count, said) in zip(asked, found, strict=True):
        extra = SYSTEMS[name][1]
        what = "ballesta" + (f"[{extra}]" if extra else "")
        print(f"{name}, Python {python}: {what} takes {f'{count} wheels' if count else said}")
    return 0 if all(count for count, _ in found) else 1


if __name__ == "__main__":
    sys.exit(main())
