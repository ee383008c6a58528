"""Converged solids of the variations that the rungs are calibrated on.

    python -m bench.rung_truth [--scene design/part]...   resumes; writes bench/rungs/truth.jsonl
    python -m bench.rung_truth --buckling [--scene ...]   resumes; writes bench/rungs/buckled.jsonl

One line of JSON for each variation: the checks that a mesh decides, with their bars. Toggle bars
and levers have their buckling in a file of its own, from meshes that are made for it.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from bench.beams import LONG
from bench.rung_variations import SCENES, Machines, Variation
from checks.columns.stability import ELASTIC_SHARE
from checks.ladder.levels import Asked
from checks.ladder.solid import check_solid
from checks.models import shapes
from checks.part.loaded_part import LoadedPart
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Models
from fem.buckling import mesh_bar, part_buckling, shares_of
from fem.solvers import SolverError
from geometry.mesh import MeshError
from geometry.parts import Beam, Pin

ACCURACY, LESS_ACCURATE = 0.02, 0.05
MOST_UNKNOWNS = 150_000
BEAM_FINENESS, LONG_FINENESS = 0.6, 0.45
BUCKLED = 2
# Whole meshes for buckling, by shape: of two the share is extrapolated with the fourth power of the
# elements' size, of one its own bar is known.
FINENESSES = {"slotted_lever": (0.5,), "lever": (0.6,), "toggle_bar": (0.45, 0.7)}
STOUT = ("gallery/punching_press/pitman",)  # too stout to buckle as bars do: stress alone
_SEARCHES = 3  # of the worst position
_SAME = 1.0005  # times the share: no other position is worse
FILE = Path(__file__).parent / "rungs" / "truth.jsonl"
BUCKLED_FILE = FILE.with_name("buckled.jsonl")


def known(file: Path = FILE) -> dict[str, dict[str, Any]]:
    """The lines of the file, by variation."""
    if not file.exists():
        return {}
    lines = (json.loads(line) for line in file.read_text().splitlines() if line)
    return {line["variation"]: line for line in lines}


def with_buckling() -> dict[str, dict[str, Any]]:
    """The lines of both files, by variation: buckling from its own file, where it is there."""
    lines = known()
    for name, line in known(BUCKLED_FILE).items():
        checks = {
            key: check
            for key, check in lines.get(name, {}).get("checks", {}).items()
            if check["kind"] != "buckling"
        }
        found = {line["check"]["quantity"]: line["check"]} if "check" in line else {}
        lines[name] = lines.get(name, line) | {"checks": checks | found}
    return lines


def truth_of(variation: Variation) -> dict[str, Any]:
    """Check a variation as a solid to the accuracy asked for here."""
    # pressed edges of pins: no mesh gives 2 % there; beams: many elements, scatter of a tenth
    less = isinstance(variation.part.geometry, Pin | Beam)
    design = replace(variation.design, accuracy=LESS_ACCURATE if less else ACCURACY)
    # on assumed arcs alone: what contacts exceed these by, rungs add to their bands
    part = replace(variation.part, most_unknowns=MOST_UNKNOWNS, arc_stated=True)
    if isinstance(part.geometry, Beam):
        long = variation.scene.design.startswith(LONG)
        part = replace(part, fineness=LONG_FINENESS if long else BEAM_FINENESS)
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


def buckled(variation: Variation) -> dict[str, Any]:
    """Solve a variation's buckling on the whole meshes of its shape.

    From the position that the formula names, modes under its load and under that turned round name
    the worst of all positions, until one is found again.
    """
    part, loads = variation.part, variation.loads
    finenesses = FINENESSES[part.shape]
    model = shapes.model_of(part, loads)
    position = 0 if model is None or model.buckling is None else model.buckling.position
    shares: list[float] = []
    for fineness in finenesses:
        solutions = Models().solutions(part.geometry, fineness, elastic_of(part))
        states, _ = solutions.coefficients(
            loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
        )
        for _ in range(_SEARCHES):
            found, turned = (
                part_buckling(
                    solutions,
                    sign * states[:, position],
                    tilt_held=False,
                    twist_held_at=loads.tilt_held_at,
                    count=3,
                    prove=False,
                )
                for sign in (1.0, -1.0)
            )
            fields = [mode.shape.ravel() for mode in (*found.modes, *turned.modes)]
            at_all = shares_of(solutions, states, np.stack(fields, axis=1))
            worst = int(at_all.argmax())
            if at_all[worst] <= at_all[position] * _SAME:
                break
            position = worst
        shares.append(1 / found.modes[0].factor)
    value, told = shares[-1], f"one whole mesh of fineness {finenesses[-1]}"
    if len(shares) == 1:
        held = loads.tilt_held_at
        bar = mesh_bar(solutions, states[:, position], found.modes, twist_held_at=held) * value
    else:
        ratio = (finenesses[0] / finenesses[1]) ** 4
        more = (shares[1] - shares[0]) * ratio / (1 - ratio)
        value, bar = value + more, abs(more)
        told = (
            f"two whole meshes of fineness {finenesses[0]} and {finenesses[1]}, extrapolated with "
            "the fourth power of the elements' size"
        )
    return {
        "kind": "buckling",
        "quantity": ELASTIC_SHARE,
        "value": value,
        "numerical": bar,
        "above": 0.0,
        "below": 0.0,
        "limit": 1.0,
        "place": f"{found.modes[0].plane} mode",
        "position": loads.labels[position],
        "note": told,
    }


def _add_buckling(scenes: list[str], most: int) -> None:
    """Add the buckling that is missing."""
    done = known(BUCKLED_FILE)
    for variation in _wanted(Machines(), scenes, most):
        if variation.part.shape not in FINENESSES or variation.name in done:
            continue
        line: dict[str, Any] = {"variation": variation.name, "factors": variation.factors}
        try:
            line["check"] = buckled(variation)
        except (MeshError, SolverError) as error:
            line["gave up"] = str(error)
        with BUCKLED_FILE.open("a") as file:
            file.write(json.dumps(line) + "\n")
        print(variation.name, flush=True)


def _asked(variation: Variation) -> Asked:
    """Stress of every variation, buckling of every other: its modes cost more than the stress."""
    kinds = {"static", "fatigue"}
    if variation.number % BUCKLED == 0 and variation.scene.name not in STOUT:
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
    parser.add_argument("--buckling", action="store_true", help="of toggle bars and levers")
    options = parser.parse_args()
    if options.buckling:
        _add_buckling(options.scene, options.most)
        return
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
