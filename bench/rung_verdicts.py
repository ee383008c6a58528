"""Verdicts of `auto` against the finest solid's, on the variations of truth.jsonl.

    python -m bench.rung_verdicts [--scene design/part]...   resumes; writes
                                                             bench/rungs/verdicts.jsonl

Every variation is judged for required safeties multiplied so that the solid's worst utilisation of
yield and fatigue is drawn between 0.2 and 3 (log-uniform, Sobol), and once more near its limit,
between 0.85 and 1.15. `auto` climbs as in a check: where it comes to the solid, it is really run.
"""

import argparse
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import exp, inf, log
from pathlib import Path
from time import perf_counter
from typing import Any

from scipy.stats import qmc

from bench.rung_truth import known
from bench.rung_variations import SCENES, SEED, Machines, Variation
from checks.design.effort import AUTO
from checks.design.model import Requirements
from checks.ladder.climb import climb_cheap, start_climb
from checks.ladder.result import cheap_result, solid_result
from checks.models.checked import BUCKLING
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check, PartResult, Status
from checks.stress.solid_mesh_level import Models

FILE = Path(__file__).parent / "rungs" / "verdicts.jsonl"
_WIDE, _NEAR = (0.2, 3.0), (0.85, 1.15)
_DRAWN = 64  # more than any scene has variations


def demanded(required: Requirements, factor: float) -> Requirements:
    """Required safeties times a factor, which judges as loads times it would without friction."""
    return Requirements(
        static=factor * required.static,
        fatigue=factor * required.fatigue,
        buckling=factor * required.buckling,
        bush=required.bush,
    )


def truth_checks(
    line: Mapping[str, Any], variation: Variation, require: Requirements
) -> dict[str, Check]:
    """The solid's checks for some required safeties, by kind."""
    needed = {"static": require.static, "fatigue": require.fatigue, BUCKLING: require.buckling}
    return {
        check["kind"]: Check(
            part=variation.part.name,
            kind=check["kind"],
            quantity=check["kind"],
            value=check["value"],
            unit="",
            numerical=inf if check["numerical"] is None else check["numerical"],
            model=check["above"] or 0.0,
            model_below=check["below"] or 0.0,
            limit=check["limit"],
            required=needed[check["kind"]],
            cycle="",
            position="",
            place="",
            method="solid",
            basis="",
        )
        for check in line["checks"].values()
    }


def auto_of(
    variation: Variation, require: Requirements, models: Models
) -> tuple[PartResult, float]:
    """Verdict of `auto` for some required safeties, and the seconds it took."""
    start = perf_counter()
    design = replace(variation.design, require=require)
    climb = start_climb(LoadedPart(design, variation.part, variation.loads, variation.runs))
    if climb_cheap(climb, AUTO):
        result = solid_result(climb, models, lambda _: None, everything=False)
    else:
        result = cheap_result(climb, models)
    return result, perf_counter() - start


def compared(
    variation: Variation, line: Mapping[str, Any], target: float, drawn: str, models: Models
) -> Iterator[dict[str, Any]]:
    """A row for each check of a variation: the status by the solid and by `auto`."""
    require = variation.design.require
    at_one = truth_checks(line, variation, require)
    worst = max(check.utilisation for kind, check in at_one.items() if kind != BUCKLING)
    require = demanded(require, target / worst)
    truth = truth_checks(line, variation, require)
    result, seconds = auto_of(variation, require, models)
    tried = [rung.rung for rung in result.rungs if rung.checks]
    for check in result.checks:
        if check.quantity.startswith(("column", "crooked")) or check.kind not in truth:
            continue
        finest = truth[check.kind]
        yield {
            "variation": variation.name,
            "drawn": drawn,
            "kind": check.kind,
            "utilisation": finest.utilisation,
            "solid": str(_by_value(finest)),
            "solid with bars": str(finest.status),
            "auto": str(check.status),
            "method": check.method,
            "rungs": tried,
            "seconds": seconds,
        }


def _by_value(check: Check) -> Status:
    """Status of the value itself: what the finest solid says without its bars."""
    return Status.PASS if check.utilisation <= 1 else Status.FAIL


def targets(scene: int) -> list[tuple[float, float]]:
    """A wide and a near target of the utilisation for each variation of a scene, by its number."""

    def between(share: float, bounds: tuple[float, float]) -> float:
        low, high = map(log, bounds)
        return exp(low + share * (high - low))

    drawn = qmc.Sobol(2, seed=SEED + scene).random(_DRAWN)
    return [(between(wide, _WIDE), between(near, _NEAR)) for wide, near in drawn]


def main() -> None:
    """Judge what has not been judged."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", default=[])
    parser.add_argument("--near", type=int, default=3, help="every n-th variation near its limit")
    options = parser.parse_args()
    truths = {name: line for name, line in known().items() if line.get("checks")}
    done = set()
    if FILE.exists():
        rows = map(json.loads, FILE.read_text().splitlines())
        done = {(row["variation"], row["drawn"]) for row in rows}
    machines = Machines()
    for place, scene in enumerate(SCENES):
        drawn = targets(place)
        if options.scene and scene.name not in options.scene:
            continue
        wanted = {name for name in truths if name.rsplit("/", 1)[0] == scene.name}
        for variation in machines.variations(scene) if wanted else ():
            if variation.name not in wanted:
                continue
            models = Models()
            wide, near = drawn[variation.number]
            asked = {"wide": wide, "near": near} if variation.number % options.near == 0 else {
                "wide": wide
            }  # fmt: skip
            for kind, target in asked.items():
                if (variation.name, kind) in done:
                    continue
                rows = compared(variation, truths[variation.name], target, kind, models)
                with FILE.open("a") as file:
                    for row in rows:
                        file.write(json.dumps(row) + "\n")
                        print(row["variation"], kind, row["kind"], row["solid"], row["auto"])


if __name__ == "__main__":
    main()
