"""Memory that solves take, each in a process of its own, against what is predicted."""

import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.unit_solutions import solve_unit_loads
from geometry.memory import compactness_of, solve_bytes

from ...fem.blocks import block
from ..solids.problems import STEEL

# Bricks of six tetrahedra along x, y and z: cubes, plates, rods; the large ones for the study.
SMALL = ((10, 10, 10), (32, 32, 1), (300, 2, 2))
LARGE = ((16, 16, 16), (22, 22, 22), (64, 64, 2), (80, 80, 3), (1000, 3, 3))
_ROOT = Path(__file__).parents[3]
_LOADS = 10  # unit loads: two faces of three, four accelerations


class Taken(NamedTuple):
    """One solve: unknowns, compactness, bytes predicted and measured."""

    unknowns: int
    compactness: float
    predicted: float
    measured: float


def measured(counts):
    """Solve a block of cubic bricks in another process."""
    words = [sys.executable, "-m", __name__, *map(str, counts)]
    done = subprocess.run(words, cwd=_ROOT, capture_output=True, text=True, check=True)
    unknowns, compactness, taken = map(float, done.stdout.split())
    predicted = solve_bytes(int(unknowns), _LOADS, compactness)
    return Taken(int(unknowns), compactness, predicted, taken)


def _status(name):
    """Bytes of an entry of /proc/self/status."""
    text = Path("/proc/self/status").read_text()
    return 1024.0 * float(text.split(f"{name}:")[1].split()[0])


def _solve(counts):
    solve_unit_loads(block((1, 1, 1), (1.0, 1.0, 1.0)), STEEL)  # what is loaded at first use
    mesh = block(counts, np.array(counts, dtype=float))
    before = _status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew: proc(5)
    solved = solve_unit_loads(mesh, STEEL)
    print(len(solved.loads), compactness_of(mesh.nodes, mesh.volume), _status("VmHWM") - before)


if __name__ == "__main__":
    _solve([int(word) for word in sys.argv[1:]])
