"""Solids of parts beyond the proportions that the rungs are calibrated on, beside the formula.

    python -m bench.rung_beyond [--scene design/part]... [--most N] [--buckling] [--way pulled]
                                 adds to rungs/beyond.jsonl; stresses, or buckling by one mesh;
                                 the parts all loaded in one way, or each in a way by chance
    python -m bench.rung_beyond --fit   writes how the bars grow to checks/models/beyond.json

Dimensions, length and the way a part is loaded are drawn so that at least one of its proportions
lies outside the range compared, half of the parts by up to a quarter, half by up to three times.
Each end of a band is moved by exp(g d), d the distance of the proportions from their ranges; g is
the least that holds 97 % of a family's solids, and of the half that is nearest, with a floor.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, exp, inf, log
from pathlib import Path
from time import perf_counter
from typing import Any
from zlib import crc32

import numpy as np

from bench.rung_variations import SCENES, SEED, Machines, Scene, varied
from checks.design.data import Design, Part
from checks.design.errors import DesignError
from checks.ladder.levels import Asked
from checks.ladder.solid import check_solid
from checks.models import shapes
from checks.models.bands import distance_from, known_band, of_buckling, proportions_of
from checks.models.checked import BUCKLING, FATIGUE, STATIC, rung_level, stress_share
from checks.models.shapes import family_of
from checks.part.loaded_part import LoadedPart, check_reach
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import fatigue_use
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError
from geometry.cad_body import cad_body
from geometry.mesh import MeshError
from geometry.parameters import ParameterError
from geometry.parts import Pin, ToggleBar, TubeRod

FILE = Path(__file__).parent / "rungs" / "beyond.jsonl"
GROWTH = Path(__file__).parents[1] / "checks" / "models" / "beyond.json"
HOLDS = 0.97
FLOOR = 0.25  # of a growth: what few solids may not have shown
PULLED = "buckling when pulled"  # a bound, and no estimate that a band stands around
_FEWEST = 6  # solids that a growth needs
_CONVERGED = 0.15
_BUCKLING_KNOWN = 0.5  # of a solid's buckling: its own bar, from one mesh, may be so wide
_NEAR, _FAR = 1.25, 3.0
_SETTINGS = {"accuracy": 0.06, "most_unknowns": 90_000, "fineness": 0.7}
_BUCKLED_UNKNOWNS = 250_000  # at most of the one mesh that buckling takes
_WAYS = ("as it is", "reversed", "pulled", "pushed")
_DRAWS = 4000
_SOLID = 0.3  # of the tube rods are made without a bore


Drawn = tuple[str, dict[str, Any], Design, Part, PartLoads]


def loaded(loads: PartLoads, design: Design, part: Part, way: str) -> PartLoads | None:
    """The loads of one cycle of the duty, or some of its positions; None without any."""
    name = next(name for name in design.duty.cycles if name in loads.cycles)
    rows = np.arange(len(loads.labels))[loads.cycles[name]]
    rows = rows[:: max(1, len(rows) // 40)]
    sign = -1.0 if way == "reversed" else 1.0
    if way in ("pulled", "pushed"):
        along = loads.wrenches[part.geometry.interfaces[1]][rows, 0]
        rows = rows[along > 0 if way == "pulled" else along < 0]
    if len(rows) < 4:
        return None
    return PartLoads(
        {face: sign * wrench[rows] for face, wrench in loads.wrenches.items()},
        sign * loads.accelerations[rows],
        {name: slice(0, len(rows))},
        tuple(loads.labels[k] for k in rows),
        (name,) * len(rows),
        {face: reach[rows] for face, reach in loads.reaches.items()},
        loads.tilt_held_at,
    )


def drawn(machines: Machines, scene: Scene, only: str = "") -> Iterator[Drawn]:
    """Parts beyond the ranges: name, how it was drawn, design, part and loads.

    only  the way in which all are loaded, which alone may lie beyond what was compared; or ""
    """
    first = next(machines.variations(scene))
    design, part = first.design, first.part
    random = np.random.default_rng([SEED, crc32(f"{scene.name}{only}".encode())])
    bounds = dict(scene.bounds)
    # a toggle bar's columns are as long as its joints stand apart in the design
    if not isinstance(part.geometry, Pin | ToggleBar) and hasattr(part.geometry, "length"):
        bounds["length"] = (0.15, 1.0) if isinstance(part.geometry, TubeRod) else (0.7, 1.4)
    made = 0
    for _ in range(_DRAWS):
        reach = _NEAR if made % 2 == 0 and not only else _FAR
        factors = {
            name: float(exp(random.uniform(log(low / reach**0.5), log(high * reach**0.5))))
            for name, (low, high) in bounds.items()
            if name == "seat width" or getattr(part.geometry, name, None)
        }
        way = "as it is" if isinstance(part.geometry, Pin) else only or str(random.choice(_WAYS))
        some = loaded(first.loads, design, part, way)
        try:
            shape = varied(part.geometry, factors)
            if isinstance(shape, TubeRod) and random.uniform() < _SOLID:
                shape = replace(shape, wall=None)
            changed = replace(part, geometry=shape)
            if some is None:
                continue
            interfaces = cad_body(changed.geometry).interfaces
            check_reach(LoadedPart(design, changed, some), interfaces)
        except (ParameterError, MeshError, DesignError):
            continue
        far = distance_from(
            family_of(changed, some, STATIC), "formula", STATIC, proportions_of(changed, some)
        )
        if far is None or not 0.0 < far <= 2 * log(reach):
            continue
        made += 1
        name = f"{scene.name}/beyond {only} {made}".replace("  ", " ")
        yield name, {"factors": factors, "way": way}, design, changed, some


def line_of(
    name: str,
    how: Mapping[str, Any],
    design: Design,
    part: Part,
    loads: PartLoads,
    *,
    buckling: bool = False,
) -> dict[str, Any]:
    """The solid and the rungs of one part: its stresses, or its buckling."""
    start = perf_counter()
    line: dict[str, Any] = {"variation": name, **how, "rungs": {}, "solid": {}}
    if part.clearances and not buckling:
        return line | {"gave up": "fits are stated: bands compare solids on assumed arcs"}
    try:
        model = shapes.model_of(part, loads)
    except SolverError as error:
        return line | {"gave up": f"formula: {error}"}
    if model is None:
        return line | {"gave up": "no formula"}
    if buckling:
        load = model.buckling
        if load is None:
            return line | {"gave up": "no formula of its buckling"}
        line["rungs"] = {PULLED if load.pulled else BUCKLING: load.share}
        line["by stress"] = stress_share(part, model)
    else:
        loaded_part = LoadedPart(design, part, loads)
        use = fatigue_use(loaded_part)
        level = rung_level(loaded_part, model)
        line["rungs"] = {STATIC: level.peak.value}
        if use is not None:
            line["rungs"][FATIGUE] = use.value(level)
    line["families"] = {
        kind: family_of(part, loads, kind) for kind in line["rungs"] if kind != PULLED
    }
    line["scales"] = proportions_of(part, loads)
    try:
        found = check_solid(
            LoadedPart(
                replace(design, accuracy=_SETTINGS["accuracy"]),
                replace(
                    part,
                    most_unknowns=_BUCKLED_UNKNOWNS if buckling else _SETTINGS["most_unknowns"],
                    fineness=_SETTINGS["fineness"],
                ),
                loads,
            ),
            Models(),
            asked=Asked(frozenset({BUCKLING} if buckling else {STATIC, FATIGUE}), modes=False),
        )
    except (MeshError, SolverError) as error:
        return line | {"gave up": str(error)}
    line["solid"] = {
        check.kind: [check.value, min(check.numerical, 1e9), check.model, check.below]
        for check in found.checks
        if check.method.startswith("solid")
    }
    return line | {"seconds": perf_counter() - start}


def known() -> dict[str, dict[str, Any]]:
    """The lines of the file, by variation."""
    if not FILE.exists():
        return {}
    lines = (json.loads(line) for line in FILE.read_text().splitlines() if line)
    return {line["variation"]: line for line in lines}


@dataclass(frozen=True)
class Beyond:
    """A solid beside the formula, outside the range.

    far           distance of its proportions
    lower, higher  what the ends of the band must grow by, over the distance, to hold the solid
    above, below  reach of the solid's own model band (arcs of contact), over the rung's value
    scales        its proportions
    """

    far: float
    lower: float
    higher: float
    above: float
    below: float
    scales: Mapping[str, float]


def outside(lines: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, list[Beyond]]]:
    """Every converged solid outside the range, by family and kind."""
    found: dict[str, dict[str, list[Beyond]]] = defaultdict(lambda: defaultdict(list))
    for line in lines.values():
        for kind, (value, numerical, above, below) in line["solid"].items():
            rung = line["rungs"].get(kind)
            known_to = _BUCKLING_KNOWN if kind == BUCKLING else _CONVERGED
            if not rung or not numerical <= known_to * value:
                continue
            family = line["families"][kind]
            band = known_band(family, "formula", kind)
            far = distance_from(family, "formula", kind, line["scales"])
            if band is None or not far:
                continue
            scales = of_buckling(line["scales"]) if kind == BUCKLING else line["scales"]
            ratio = value / rung
            most = max(ratio - line.get("by stress", 0.0) / rung, band.high)
            lower = max(0.0, log(band.low / ratio)) / far
            higher = log(most / band.high) / far
            found[family][kind].append(
                Beyond(far, lower, higher, above / rung, below / rung, scales)
            )
    return found


def fitted(solids: Sequence[Beyond], side: str) -> float:
    """The growth that holds the share asked for of all solids and of the nearer half."""
    ordered = sorted(solids, key=lambda solid: solid.far)
    halves = (ordered, ordered[: ceil(len(ordered) / 2)])
    return max(FLOOR, *(_held([getattr(solid, side) for solid in half]) for half in halves))


def _held(growths: Sequence[float]) -> float:
    return sorted(growths)[min(len(growths) - 1, ceil(HOLDS * len(growths)) - 1)]


def main() -> None:
    """Add what is missing, or fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", default=[])
    parser.add_argument("--most", type=int, default=12, help="parts of each scene")
    parser.add_argument("--buckling", action="store_true", help="by one mesh, not the stresses")
    parser.add_argument("--way", default="", choices=["", *_WAYS], help="all are loaded like this")
    parser.add_argument("--fit", action="store_true", help="write the growth of the bars")
    options = parser.parse_args()
    if options.fit:
        fit()
        return
    machines = Machines()
    by_name = {scene.name: scene for scene in SCENES if scene.bounds}  # of random ones none
    for scene in map(by_name.__getitem__, options.scene or by_name):
        for number, (name, *rest) in enumerate(drawn(machines, scene, options.way), 1):
            if number > options.most:
                break
            name += " buckled" if options.buckling else ""
            if name in known():
                continue
            line = line_of(name, *rest, buckling=options.buckling)
            with FILE.open("a") as file:
                file.write(json.dumps(line) + "\n")
            print(f"{name}: {line.get('seconds', inf):.1f} s {line.get('gave up', '')}", flush=True)


def fit() -> None:
    """Write how the bars of the families grow, and print what they hold."""
    growths: dict[str, dict[str, Any]] = {}
    for family, kinds in sorted(outside(known()).items()):
        for kind, solids in sorted(kinds.items()):
            if len(solids) < _FEWEST:
                continue
            band = known_band(family, "formula", kind)
            assert band is not None
            # where the solids compared have no reach, their arcs are the formula's own
            reach = 1.0 if band.above[1] or band.below[1] else 0.0
            lower, higher = fitted(solids, "lower"), fitted(solids, "higher")
            furthest = max(solid.far for solid in solids)
            growths.setdefault(family, {})[kind] = {
                "lower": lower,
                "higher": higher,
                "furthest": furthest,
                "count": len(solids),
                "above": reach * max(solid.above for solid in solids),
                "below": reach * max(solid.below for solid in solids),
                "scales": {
                    name: [
                        min(solid.scales[name] for solid in solids),
                        max(solid.scales[name] for solid in solids),
                    ]
                    for name in solids[0].scales
                },
            }
            below = np.array([1 - band.low / exp(lower * solid.far) for solid in solids])
            above = np.array([band.high * exp(higher * solid.far) - 1 for solid in solids])
            inside = np.mean([s.lower <= lower and s.higher <= higher for s in solids])
            print(
                f"{family:26s} {kind:8s} {len(solids):3d} solids as far as {furthest:.2f}, growth "
                f"{lower:.2f} down {higher:.2f} up: {inside:.0%} inside, the rung's own bar "
                f"-{np.median(below):.0%} +{np.median(above):.0%} in the median, "
                f"-{below.max():.0%} +{above.max():.0%} at most"
            )
    data = {"command": "python -m bench.rung_beyond --fit", "families": growths}
    GROWTH.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
