"""The error bars of the rungs, from converged solids of the machines' parts.

python -m bench.rung_bands [--scene design/part]...   runs every rung on the variations in
bench/rungs/truth.jsonl and buckled.jsonl, writes bench/rungs/compared.jsonl and
checks/models/bands.json; of other scenes than those named what was compared stands
"""

import argparse
import json
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees, exp, sqrt
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from bench.rung_truth import with_buckling
from bench.rung_variations import SCENES, Machines, Variation
from checks.design.effort import FORMULA
from checks.models import shapes
from checks.models.bands import of_buckling, proportions_of
from checks.models.checked import (
    BUCKLING,
    BY_STRESS,
    FATIGUE,
    STATIC,
    STOUT,
    rung_level,
    stress_share,
)
from checks.models.in_bores import Arcs, arcs_of, in_bores
from checks.models.shapes import family_of
from checks.models.shapes.beams import LONG
from checks.part.loaded_part import LoadedPart
from checks.strength.part_strength import fatigue_use
from fem.solvers import SolverError
from geometry.mesh import MeshError

FILE = Path(__file__).parent / "rungs" / "compared.jsonl"
BANDS = Path(__file__).parents[1] / "checks" / "models" / "bands.json"
SHARE = 0.95  # of solids that a band is to hold
_OUTSIDE = (1 - SHARE) / 2  # on either side
_KINDS = (STATIC, FATIGUE, BUCKLING)
FLOOR = 0.02  # of the value: half of the narrowest band; the loads compared are few
# Of a buckling load: none of the flat links compared buckles in its plane, and one beyond, thicker
# than it is wide, has 4 % more.
BUCKLED_FLOOR = 0.04
_FEWEST = 5  # solids that a band needs
_CONVERGED = 0.15  # of its value: a larger numerical bar is no truth to compare with


@dataclass(frozen=True)
class Compared:
    """A check of a rung beside the solid's.

    truth        the solid's value; bar its numerical bar, above and below its model band
    value        the rung's
    by_stress    of a share of the buckling load: what a stout body may have more, else 0
    on_arcs      solid over rung, the largest and the least of all arcs of contact that both know;
                 empty where the rung knows but the half circle
    """

    family: str
    scene: str
    variation: str
    rung: str
    kind: str
    truth: float
    bar: float
    above: float
    below: float
    value: float
    seconds: float
    scales: Mapping[str, float]
    by_stress: float = 0.0
    on_arcs: Sequence[float] = ()

    @property
    def ratio(self) -> float:
        """Solid over rung."""
        return self.truth / self.value

    @property
    def left(self) -> float:
        """Solid over rung, less of an excess what stress alone explains: the bars' other term."""
        return min(self.ratio, max(1.0, (self.truth - self.by_stress) / self.value))

    @property
    def error(self) -> float:
        """Rung over solid less 1, on the arc where it is largest."""
        return max(abs(1 / ratio - 1) for ratio in (self.ratio, *self.on_arcs))

    def inside(self, low: float, high: float) -> bool:
        """True if a band holds the solid on the half circle and on the arcs of both ends."""
        most, least = self.on_arcs or (self.left, self.left)
        return low <= min(self.left, least) and max(self.left, most) <= high


def of_solid(line: Mapping[str, Any], kind: str) -> Mapping[str, Any] | None:
    """The solid's check of a kind in a line of truth.jsonl; None without one that converged."""
    found = [check for check in line.get("checks", {}).values() if check["kind"] == kind]
    if not found:
        return None
    # buckling is known from one mesh; of tubes, whose walls buckle, from two
    by_meshes = kind != BUCKLING
    if by_meshes and not (found[0]["numerical"] or 0.0) <= _CONVERGED * found[0]["value"]:
        return None
    return found[0]


def rungs_of(variation: Variation, line: Mapping[str, Any]) -> Iterable[Compared]:
    """The formula's checks of a variation beside the solid's."""
    part, loads, design = variation.part, variation.loads, variation.design
    use = fatigue_use(LoadedPart(design, part, loads))
    start = process_time()
    try:
        model = shapes.model_of(part, loads)
    except (MeshError, SolverError) as error:
        print(f"{variation.name}: {FORMULA} gave up: {error}")
        return
    if model is None:
        return
    level = rung_level(LoadedPart(design, part, loads), model)
    values = {STATIC: level.peak.value}
    if use is not None:
        values[FATIGUE] = use.value(level)
    load = model.buckling
    if load is not None and not load.pulled and load.weakest is None:  # others: a bound, no band
        values[BUCKLING] = load.share
    seconds = process_time() - start
    for kind, value in values.items():
        truth = of_solid(line, kind)
        if truth is None or not value > 0:
            continue
        on_arcs: Sequence[float] = ()
        arcs = arcs_of(part) if kind != BUCKLING else []
        # bands of their own: fixity of forks, arcs where the rung knows them
        told_apart = kind == BUCKLING or bool(arcs)
        if arcs:
            loaded = LoadedPart(design, part, loads)
            judged = use if kind == FATIGUE else None
            models = Arcs(loaded, level, partial(shapes.model_of, part))
            rung = in_bores(models, judged, value).by_arc
            on_arcs = _on_arcs(truth, rung) if rung else ()
        yield Compared(
            family_of(part, loads, kind),
            variation.scene.name,
            variation.name,
            FORMULA,
            kind,
            truth["value"],
            truth["numerical"] or 0.0,
            0.0 if told_apart else truth["above"] or 0.0,
            0.0 if told_apart else truth["below"] or 0.0,
            value,
            seconds,
            proportions_of(part, loads),
            STOUT / BY_STRESS * stress_share(part, model) if kind == BUCKLING else 0.0,
            on_arcs,
        )


def _on_arcs(truth: Mapping[str, Any], rung: Mapping[float, float]) -> Sequence[float]:
    """Solid over rung, of the largest and of the least on the arcs; the solid's are in its note."""
    told = dict(re.findall(r"(\d+) deg ([\d.e+-]+)", truth["note"].partition("by arc of")[2]))
    own = {round(degrees(arc)): value for arc, value in rung.items()}
    pairs = [(float(value), own[int(arc)]) for arc, value in told.items() if int(arc) in own]
    if not pairs:
        return ()
    solid, formula = np.array(pairs).T
    return float(solid.max() / formula.max()), float(solid.min() / formula.min())


def compare(truths: Mapping[str, Mapping[str, Any]]) -> list[Compared]:
    """Run the rungs on all variations that have a solid."""
    machines, rows = Machines(), []
    for scene in SCENES:
        wanted = {name for name in truths if name.rsplit("/", 1)[0] == scene.name}
        if not wanted:
            continue
        last = max(int(name.rsplit("/", 1)[1]) for name in wanted)
        for variation in machines.variations(scene):
            if variation.name in wanted:
                rows += rungs_of(variation, truths[variation.name])
            if variation.number == last:
                break
    return rows


def predicted(ratios: Sequence[float], count: int) -> tuple[float, float]:
    """Between which values the next ratio lies in 95 % of all cases, if its logarithm is normal.

    Mean and deviation are those of n solids, and not known: mean +- t s sqrt(1 + 1/n) with
    Student's t of n - 1 degrees of freedom (prediction interval; Hahn and Meeker, Statistical
    Intervals, 1991, section 4.7).

    count  n: a solid may have more ratios than one, which are no more solids
    """
    from scipy.stats import t as student  # takes a second to load: whoever collects tests waits

    logs, n = np.log(ratios), count
    reach = float(student.ppf((1 + SHARE) / 2, n - 1)) * float(logs.std(ddof=1)) * sqrt(1 + 1 / n)
    middle = float(logs.mean())
    return exp(middle - reach), exp(middle + reach)


def ends_of(rows: Sequence[Compared]) -> tuple[float, float]:
    """Ends of the band of a rung's check: as predicted, and as wide as its floor at the least.

    Each end is a factor on the half circle's value and on the least, or the largest, of all arcs.
    """
    even = [row.left for row in rows]
    most, least = ([row.on_arcs[k] for row in rows if row.on_arcs] for k in (0, 1))
    low = min(predicted(even + least, len(rows))[0], _share_below(even, least, _OUTSIDE))
    high = max(predicted(even + most, len(rows))[1], _share_below(even, most, 1 - _OUTSIDE))
    middle, floor = _middle(even), BUCKLED_FLOOR if rows[0].kind == BUCKLING else FLOOR
    return min(low, middle * (1 - floor)), max(high, middle * (1 + floor))


def _share_below(even: Sequence[float], arcs: Sequence[float], share: float) -> float:
    """Ratio below which a share of the solids lies: their logarithms may not be normal."""
    found = [float(np.quantile(ratios, share)) for ratios in (even, arcs) if len(ratios)]
    return max(found) if share > 0.5 else min(found)


def _middle(ratios: Sequence[float]) -> float:
    return exp(float(np.log(ratios).mean()))


def band_of(rows: Sequence[Compared]) -> dict[str, Any]:
    """The band of a rung's check from what was compared."""
    low, high = ends_of(rows)
    bands = {
        side: sorted(getattr(row, side) / row.truth for row in rows) for side in ("above", "below")
    }
    arcs = {side: [shares[0], shares[-1]] for side, shares in bands.items()}
    told: dict[str, list[float]] = defaultdict(list)
    for row in rows:
        scales = of_buckling(row.scales) if row.kind == BUCKLING else row.scales
        for name, value in scales.items():
            told[name].append(value)
    return {
        "low": low,
        "high": high,
        "count": len(rows),
        **arcs,
        "scales": {name: [min(values), max(values)] for name, values in told.items()},
    }


def bands(rows: Sequence[Compared]) -> dict[str, Any]:
    """All bands: family -> rung -> kind."""
    groups: dict[tuple[str, str, str], list[Compared]] = defaultdict(list)
    for row in rows:
        groups[row.family, row.rung, row.kind].append(row)
    for (
        family,
        *rest,
    ), some in groups.items():  # few solids: what shorter beams have may be theirs
        if family.endswith(LONG):
            some += groups[family.removesuffix(LONG), *rest]
    found: dict[str, Any] = {}
    for (family, rung, kind), some in sorted(groups.items()):
        if len(some) >= _FEWEST:
            found.setdefault(family, {}).setdefault(rung, {})[kind] = band_of(some)
    return found


def told(rows: Sequence[Compared]) -> str:
    """A line for every family, rung and check: ratios solid over rung."""
    lines = []
    groups: dict[tuple[str, str, str], list[Compared]] = defaultdict(list)
    for row in rows:
        groups[row.family, row.kind, row.rung].append(row)
    for (family, kind, rung), some in sorted(groups.items()):
        ratios = np.array([row.ratio for row in some])
        seconds = float(np.median([row.seconds for row in some]))
        lines.append(
            f"{family:27s} {kind:9s} {rung:8s} {len(some):3d}  "
            f"{np.quantile(ratios, 0.05):6.3f} {np.median(ratios):6.3f} "
            f"{np.quantile(ratios, 0.95):6.3f}  worst {ratios.min():.3f} {ratios.max():.3f}  "
            f"{seconds:.2f} s"
        )
    return "\n".join(lines)


def main() -> None:
    """Compare, and write the bands."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dry", action="store_true", help="write no bands")
    parser.add_argument("--scene", action="append", default=[], help="the others as they stand")
    options = parser.parse_args()
    truths, rows = with_buckling(), list[Compared]()
    if options.scene:
        rows = [Compared(**json.loads(line)) for line in FILE.read_text().splitlines()]
        rows = [row for row in rows if row.scene not in options.scene]
        truths = {
            name: line for name, line in truths.items() if name.rsplit("/", 1)[0] in options.scene
        }
    order = [scene.name for scene in SCENES]
    rows = sorted([*rows, *compare(truths)], key=lambda row: order.index(row.scene))
    FILE.write_text("".join(json.dumps(vars(row)) + "\n" for row in rows))
    print(told(rows))
    if not options.dry:
        data = {"command": "python -m bench.rung_bands", "families": bands(rows)}
        BANDS.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
