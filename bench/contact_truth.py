"""Formula, solid on assumed arcs and solved contact beside finer contact, of the machines' parts.

    python -m bench.contact_truth [DESIGN/PART]...   resumes; writes bench/rungs/contact.jsonl

Parts in whose bores pins press and whose design states neither arc nor fit. One line of JSON each:
static stress and fatigue by every model to the design's accuracy, by contact to `ACCURACY`, and
seconds of the processor. Loads have no doubts here: these are the same for all models.
"""

import json
import sys
from collections.abc import Iterable
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path
from time import process_time
from typing import Any

from ballesta.design.read import read_design
from ballesta.machine.runs import run_machine
from ballesta.pipeline import versions_of_libraries
from bench.auto_cost import DESIGNS, MACHINES
from bench.run import machine
from checks.ladder.carried import judged_of
from checks.ladder.climb import start_climb
from checks.ladder.levels import Asked, first_of
from checks.ladder.passing_fits import with_assumed_fits
from checks.ladder.solid import SolvedStress, solve_stress
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check
from checks.stress.solid_mesh_level import Models
from fem.contact.condensed import ContactError
from fem.solvers import SolverError
from fem.threads import one_thread
from geometry.mesh import MeshError

FILE = Path(__file__).parent / "rungs" / "contact.jsonl"
ACCURACY, MOST_UNKNOWNS = 0.02, 150_000


def pinned(name: str) -> list[str]:
    """Parts of a machine in whose bores pins press, without a stated arc or fit."""
    return [
        part.name
        for part in read_design(DESIGNS / f"{name}.toml").parts.values()
        if part.body is not None
        and not part.arc_stated
        and not part.clearances
        and any(face.kind == "bore" for face in part.geometry.placed_interfaces)
    ]


def measured(loaded: LoadedPart, models: Models) -> dict[str, Any]:
    """The checks of a part by every model, and the seconds of each from the start of the part."""
    judged = judged_of(loaded)
    both = list(judged.values())
    row: dict[str, Any] = {"seconds": {}, "unknowns": {}, "checks": {}}
    start = process_time()

    def note(model: str, checks: Iterable[Check], solved: SolvedStress | None = None) -> None:
        row["seconds"][model] = process_time() - start
        if solved is not None:
            row["unknowns"][model] = [level.unknowns for level in solved.levels]
        row["checks"][model] = {check.kind: _told(check) for check in checks}

    climb = start_climb(loaded)
    if climb.by_formula(list(judged)):
        note("formula", (climb.best[kind].check for kind in judged))

    def solve(some: LoadedPart, before: SolvedStress | None = None) -> SolvedStress:
        kinds = frozenset(judged)
        asked = Asked(kinds, modes=False, first=first_of(loaded.accuracy, kinds))
        return solve_stress(some, models, both, both, lambda _: None, asked, before)

    start = process_time()
    arcs = solve(loaded)
    note("arcs", arcs.checks, arcs)
    every = [replace(check, model=inf, model_below=inf) for check in arcs.checks]
    fitted = with_assumed_fits(loaded, arcs.finest, every)
    if fitted is None:
        return row | {"left out": "contact is not solved: its edges are sharp, or it has a journal"}
    contact = solve(fitted, arcs)
    note("contact", contact.checks, contact)
    finer = replace(
        fitted,
        design=replace(fitted.design, accuracy=ACCURACY),
        part=replace(fitted.part, most_unknowns=MOST_UNKNOWNS),
    )
    truth = solve(finer, contact)
    note("truth", truth.checks, truth)
    return row


def _told(check: Check) -> dict[str, Any]:
    """Value and ends of its bars, MPa, None where infinite, and the verdict."""
    ends = {name: getattr(check, name) for name in ("value", "lower", "upper", "numerical")}
    told = {name: end if isfinite(end) else None for name, end in ends.items()}
    return told | {"utilisation": check.utilisation, "status": str(check.status)}


@one_thread()
def main() -> None:
    """Measure what is missing."""
    lines = FILE.read_text().splitlines() if FILE.exists() else []
    done = {json.loads(line)["part"] for line in lines}
    versions = versions_of_libraries()
    for name in MACHINES:
        wanted = [f"{name}/{part}" for part in pinned(name)]
        wanted = [one for one in wanted if one in (sys.argv[1:] or wanted) and one not in done]
        if not wanted:
            continue
        models = Models()
        run = run_machine(read_design(DESIGNS / f"{name}.toml"), models)
        for part in wanted:
            own = run.design.parts[part.rpartition("/")[2]]
            loaded = LoadedPart.of(run.design, own, run.all, models)
            row: dict[str, Any] = {"part": part, "machine": machine(), "versions": versions}
            try:
                row |= measured(loaded, models)
            except (ContactError, MeshError, SolverError) as error:
                row["left out"] = str(error)
            with FILE.open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(part, row["seconds"] if "seconds" in row else row["left out"], flush=True)


if __name__ == "__main__":
    main()
