"""Converged solids of the variations that the rungs are calibrated on.

    python -m bench.rung_truth [--scene design/part]...   resumes; writes bench/rungs/truth.jsonl

One line of JSON for each variation: the checks that a mesh decides, with their bars.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from time import perf_counter
from typing import Any

from bench.rung_variations import SCENES, Machines, Variation
from checks.ladder.levels import Asked
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError
from geometry.mesh import MeshError
from geometry.parts import Pin

ACCURACY, PIN_ACCURACY = 0.02, 0.05
MOST_UNKNOWNS = 150_000
BUCKLED = 2
FILE = Path(__file__).parent / "rungs" / "truth.jsonl"


def known(file: Path = FILE) -> dict[str, dict[str, Any]]:
    """The lines of the file, by variation."""
    if not file.exists():
        return {}
    lines = (json.loads(line) for line in file.read_text().splitlines() if line)
    return {line["variation"]: line for line in lines}


def truth_of(variation: Variation) -> dict[str, Any]:
    """Check a variation as a solid to the accuracy asked for here."""
    is_pin = isinstance(variation.part.geometry, Pin)  # pressed edges: no mesh gives 2 % there
    design = replace(variation.design, accuracy=PIN_ACCURACY if is_pin else ACCURACY)
    # on assumed arcs alone: what contacts exceed these by, rungs add to their bands
    part = replace(variation.part, most_unknowns=MOST_UNKNOWNS, arc_stated=True)
    start = perf_counter()
    line: dict[str, Any] = {"variation": variation.name, "factors": variation.factors}
    try:
        result = check_solid(
            LoadedPart(design, part, variation.loads), Models(), asked=_asked(variation)
        )
    except (MeshError, SolverError) as error:
        return line | {"gave up": str(error), "seconds": perf_counter() - start}
    checks = [check for check in result.checks if check.method.startswith("solid")]
    return line | {
        "seconds": perf_counter() - start,
        "shape": variation.part.shape,
        "unknowns": [mesh["unknowns"] for mesh in result.meshes],
        "checks": {
            f"{check.kind}: {check.quantity}": {
                "kind": check.kind,
                "value": check.value,
                "numerical": check.numerical,
                "above": check.model,
                "below": check.below,
                "limit": check.limit,
                "place": check.place,
                "position": check.position,
                "note": check.note,
            }
            for check in checks
        },
    }


def _asked(variation: Variation) -> Asked:
    """Stress of every variation, buckling of every other: its modes cost more than the stress."""
    kinds = {"static", "fatigue"}
    if variation.number % BUCKLED == 0:
        kinds.add("buckling")
    return Asked(frozenset(kinds), modes=False)


def _wanted(machines: Machines, scenes: list[str], most: int) -> Iterator[Variation]:
    by_name = {scene.name: scene for scene in SCENES}
    for scene in map(by_name.__getitem__, scenes or by_name):
        yield from islice(machines.variations(scene), most + 1)


def main() -> None:
    """Add what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", default=[])
    parser.add_argument("--most", type=int, default=1000, help="variations of each scene")
    parser.add_argument("--out", type=Path, default=FILE)
    options = parser.parse_args()
    done = known(options.out)
    options.out.parent.mkdir(exist_ok=True)
    for variation in _wanted(Machines(), options.scene, options.most):
        if variation.name in done:
            continue
        line = truth_of(variation)
        with options.out.open("a") as file:
            file.write(json.dumps(line) + "\n")
        print(f"{variation.name}: {line['seconds']:.1f} s", flush=True)


if __name__ == "__main__":
    main()
