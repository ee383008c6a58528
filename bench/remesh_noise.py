"""Re-mesh noise: how far numbers move when a part is meshed again with slightly other sizes.

    python -m bench.remesh_noise [DESIGN ...] [--part NAME] [--accuracy 5%]

Without names: every design. Meshes each part 20 times with element sizes between 3 % smaller and
3 % larger, refines each to the design's accuracy as a test with a baseline does, and writes the
scatter to ballesta/regression/noise.json, from which the bands of baselines come. Resumes: what
stands there is not measured again, unless --again is given.
"""

import argparse
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ballesta.design.read import read_design
from ballesta.machine.elastic_parts import compliances_of
from ballesta.machine.measured_balance import measured_loads
from ballesta.machine.quasi_static import vibration_of, with_dynamics
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from ballesta.regression.file import LARGEST, NOISE, band_width, is_bounded, percent, rungs_of
from checks.design.data import Design, Part
from checks.design.errors import DesignError, NumericsError
from checks.ladder.climb import start_climb
from checks.ladder.part_ladder import climb_pinned
from checks.ladder.result import solid_result
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError
from geometry.mesh import MeshError, TooManyElementsError

COUNT, LARGEST_CHANGE = 20, 0.03
_DESIGNS = Path(__file__).parents[1] / "designs"
_RUNG = "solid"
_GAVE_UP = (DesignError, NumericsError, MeshError, SolverError, TooManyElementsError)

Entry = dict[str, Any]


def main() -> None:
    """Measure what is asked for and not known yet."""
    parser = argparse.ArgumentParser(prog="python -m bench.remesh_noise")
    parser.add_argument("designs", nargs="*", help="names in designs/, or files; else all")
    parser.add_argument("--part", action="append", help="only this part; may be given again")
    parser.add_argument("--accuracy", help="instead of the designs' own, such as 2%%")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--again", action="store_true")
    asked = parser.parse_args()
    overrides = [] if asked.accuracy is None else [f"accuracy={asked.accuracy}"]
    for file in _files(asked.designs):
        design = read_design(file, overrides)
        runs = None
        for name in asked.part or design.parts:
            known = [
                entry
                for entry in read_measured()
                if _is(entry, design, name) and _is_complete(entry, asked.count)
            ]
            if known and not asked.again:
                continue
            runs = _runs(design) if runs is None else runs
            start = perf_counter()
            entries = list(measured(design, design.parts[name], runs, asked.count))
            write_measured(entries)
            for entry in entries:
                told = "" if entry["scatter"] is None else percent(entry["scatter"])
                print(f"{design.file.stem} {name} {entry['kind']}: {told}", flush=True)
            print(f"{perf_counter() - start:.0f} s", flush=True)


def _files(names: Iterable[str]) -> list[Path]:
    files = [path if (path := Path(n)).is_file() else _DESIGNS / f"{n}.toml" for n in names]
    return files or sorted(_DESIGNS.glob("*.toml"))


def _runs(design: Design) -> Any:
    """All cycles and measured runs of a design, solved as a check solves them."""
    models = Models()
    masses = part_masses(design, models)
    solved = solve_cycles(design, masses, compliances_of(design, models))
    solved = with_dynamics(design, solved, vibration_of(design, solved))
    return {**solved, **measured_loads(design, masses)}


def measured(design: Design, part: Part, runs: Any, count: int) -> Iterator[Entry]:
    """Scatter of each kind of check of a part by a solid: the largest less the least, as a share.

    A kind without an entry is none of the solid's. A scatter of None: fewer than two meshes.
    """
    shares = [0.0, *np.linspace(-LARGEST_CHANGE, LARGEST_CHANGE, count)]
    found: dict[str, list[float]] = {}
    numerical: dict[str, list[float | None]] = {}
    gave_up = 0
    for share in shares:
        try:
            checks = _checks(design, part, runs, 1 + float(share))
        except _GAVE_UP as error:
            gave_up += 1
            print(f"{part.name}: {str(error)[:100]}", flush=True)
            if not found:
                break  # the first mesh, at the part's own size
            continue
        for check in checks:
            kind = check["kind"]
            found.setdefault(kind, []).append(check["value"])
            numerical.setdefault(kind, []).append(_bar(check))
    base: Entry = {"design": design.file.stem, "part": part.name, "rung": _RUNG}
    base |= {"accuracy": design.accuracy}
    if not found:
        yield base | {"kind": "none", "remeshes": 0, "scatter": None}
    for kind, values in found.items():
        yield base | {
            "kind": kind,
            "remeshes": len(values) - 1,
            "gave up": gave_up,
            "scatter": round((max(values) - min(values)) / values[0], 9) if values[0] else 0.0,
            "numerical": _largest(numerical[kind]),
        }


def _checks(design: Design, part: Part, runs: Any, factor: float) -> list[Entry]:
    """The checks that a solid decides, its elements made smaller by a factor."""
    part = replace(part, fineness=part.fineness * factor)
    climb = start_climb(LoadedPart(design, part, loads_on(design, part, runs), runs))
    solids = climb_pinned(climb, dict.fromkeys(climb.asked, _RUNG), lambda _: None)
    result = solid_result(climb, Models(), lambda _: None, everything=False, pinned=solids)
    plain = result.to_dict()
    by_solid = {kind for kind, found in rungs_of(plain).items() if found == _RUNG}
    return [check for check in plain["checks"]
            if check["kind"] in by_solid and check["method"].startswith(_RUNG)]  # fmt: skip


def _bar(check: Mapping[str, Any]) -> float | None:
    """Numerical error bar over the value; None where it is not known."""
    if check["numerical"] is None:
        return None
    return float(check["numerical"] / check["value"]) if check["value"] else 0.0


def _largest(bars: list[float | None]) -> float | None:
    known = [bar for bar in bars if bar is not None]
    return round(max(known), 6) if len(known) == len(bars) else None


def read_measured() -> list[Entry]:
    """The noise measured so far."""
    entries: list[Entry] = json.loads(NOISE.read_text(encoding="utf-8"))["measured"]
    return entries


def write_measured(entries: list[Entry]) -> None:
    """Add entries to the file, or put them in the place of those they measure again."""
    new = {(e["design"], e["part"], e["rung"], e["accuracy"]) for e in entries}
    kept = [
        e for e in read_measured() if (e["design"], e["part"], e["rung"], e["accuracy"]) not in new
    ]
    everything = sorted([*kept, *entries], key=lambda e: [str(e[key]) for key in _ORDER])
    data = {"made by": "python -m bench.remesh_noise", "worst": [], "measured": everything}
    data["worst"] = worst_of(everything)
    lists = ",\n".join(
        f" {json.dumps(key)}: {_lines(value) if isinstance(value, list) else json.dumps(value)}"
        for key, value in data.items()
    )
    temporary = NOISE.with_suffix(".tmp")
    temporary.write_text("{\n" + lists + "\n}\n", encoding="utf-8")
    os.replace(temporary, NOISE)


_ORDER = ("rung", "kind", "accuracy", "design", "part")


def _lines(entries: list[Entry]) -> str:
    return "[\n" + ",\n".join(f"  {json.dumps(entry)}" for entry in entries) + "\n ]"


def worst_of(entries: Iterable[Mapping[str, Any]]) -> list[Entry]:
    """The worst scatter by rung, kind and accuracy, of parts whose bars are within the accuracy.

    Others are not bounded: a baseline refuses them (`bands.band_of`).
    """
    worst: dict[tuple[str, str, float], Entry] = {}
    for entry in entries:
        key = (entry["rung"], entry["kind"], entry["accuracy"])
        if not entry["scatter"] or not is_bounded(*key[:2], entry["numerical"], key[2]):
            continue
        so_far = worst.setdefault(
            key, dict(zip(_ORDER[:3], key, strict=True)) | {"remeshes": 0, "worst": 0.0}
        )
        so_far["remeshes"] += entry["remeshes"]
        so_far["worst"] = max(so_far["worst"], entry["scatter"])
    for entry in worst.values():
        if band_width(entry["worst"]) > LARGEST:
            entry["refused"] = f"a band of {percent(band_width(entry['worst']))} would miss 5 %"
    return list(worst.values())


def _is_complete(entry: Mapping[str, Any], count: int) -> bool:
    """True if a part was meshed again often enough, or the solid gave up."""
    return entry["scatter"] is None or bool(entry["remeshes"] + entry["gave up"] >= count)


def _is(entry: Mapping[str, Any], design: Design, part: str) -> bool:
    return (entry["design"], entry["part"], entry["rung"], entry["accuracy"]) == (
        design.file.stem,
        part,
        _RUNG,
        design.accuracy,
    )


if __name__ == "__main__":
    main()
