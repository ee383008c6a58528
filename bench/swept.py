"""Solids on carried meshes against solids with meshes of their own, over variations of a bar.

python -m bench.swept RECORD            all variations; goes on where RECORD (JSON lines) ends
python -m bench.swept RECORD 0 2        every second one, from the first on: for two processes
python -m bench.swept RECORD told       what RECORD holds

The variations are drawn beforehand (`drawn`): 140 by a Sobol sequence, wall and hole by up to 30 %
and all else by up to 9 %, and 60 at the corners between neighbours, where every dimension is 9 to
9.5 % off. A verdict turns round at some limit if the two ranges, each value with all of its bars,
have nothing in common; that is asked of all, so that every limit is covered.
"""

import json
import statistics
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from math import log
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.machine.runs import doubts_of, run_machine
from ballesta.sweeps.neighbours import STEP, Neighbours
from checks.design.errors import DesignError
from checks.ladder.carried import carried_result, judged_of
from checks.ladder.climb import start_climb
from checks.ladder.levels import Asked
from checks.ladder.solid import solve_stress
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check
from checks.store.store import Store
from checks.stress.kept_models import Models
from fem.threads import one_thread

PRESS = Path(__file__).parents[1] / "designs" / "toggle_press.toml"
PART = "bar_upper"
BAR = {"width": 80.0, "wall": 6.3, "hole": 44.0, "overhang": 40.0, "inner_radius": 3.0,
       "cutout_length": 56.0, "cutout_corner": 5.0}  # fmt: skip
WIDE = ("wall", "hole")
DRAWN, CORNERS, SEED = 140, 60, 20261126
_END = 0.995  # of the way to the corner


@dataclass(frozen=True)
class Compared:
    """A kind of check by both: value, numerical bar, model band above and below, MPa."""

    swept: tuple[float, float, float, float]
    full: tuple[float, float, float, float]

    @property
    def missed(self) -> float:
        """Distance of the values over the numerical bar of the carried mesh."""
        return abs(self.swept[0] - self.full[0]) / self.swept[1]

    @property
    def turned(self) -> bool:
        """True if the ranges have nothing in common: some limit lies between them."""
        (low, high), (lowest, highest) = _range(self.swept), _range(self.full)
        return high < lowest or highest < low


def _range(check: Sequence[float]) -> tuple[float, float]:
    value, error, above, below = check
    return value - error - below, value + error + above


def drawn() -> list[tuple[str, ...]]:
    """Overrides of every variation, those at corners between the others."""
    return list(_drawn())


def _drawn() -> Iterator[tuple[str, ...]]:
    sobol = qmc.Sobol(len(BAR), seed=SEED)
    reach = np.array([log(1.3) if name in WIDE else log(1.09) for name in BAR])
    random = np.random.default_rng(SEED)
    count = {"drawn": 0, "corners": 0}
    while sum(count.values()) < DRAWN + CORNERS:
        corner = is_corner(count["drawn"] + count["corners"])
        if corner:
            steps = [random.integers(-1, 2) if name in WIDE else 0 for name in BAR]
            ends = random.choice([-1.0, 1.0], len(BAR)) * _END / 2
            moves = (np.array(steps) + ends) * log(STEP)
        else:
            moves = reach * (2 * sobol.random(1)[0] - 1)
        values = np.array(list(BAR.values())) * np.exp(moves)
        names = zip(BAR, values.tolist(), strict=True)
        overrides = tuple(f"parts.{PART}.{name}={value:.5g} mm" for name, value in names)
        try:
            read_design(PRESS, overrides)
        except DesignError:
            continue  # a shape that cannot be
        count["corners" if corner else "drawn"] += 1
        yield overrides


def is_corner(number: int) -> bool:
    """True if a variation is one of those at corners: three of ten."""
    return number % 10 >= 7


def loaded_of(overrides: Sequence[str]) -> tuple[LoadedPart, Models]:
    """The bar of a variation under its loads."""
    design, models = read_design(PRESS, overrides), Models()
    machine = run_machine(design, models)
    design, doubts = machine.design, doubts_of(machine.design, machine).all
    return LoadedPart.of(design, design.parts[PART], machine.all, models, doubts), models


def compare(overrides: Sequence[str], store: Store) -> dict[str, Any]:
    """One variation by both, with the processor time of each, s."""
    loaded, models = loaded_of(overrides)
    neighbour = Neighbours(PRESS, overrides, store).of(PART)
    if isinstance(neighbour, str):
        return {"anew": neighbour.splitlines()[0].replace(f"{PRESS}: ", "")}
    start = process_time()
    swept = carried_result(start_climb(loaded), neighbour, models, lambda _: None)
    spent = process_time() - start
    if isinstance(swept, str):
        return {"anew": swept, "seconds": spent}
    start = process_time()
    judged = judged_of(loaded)
    both = list(judged.values())
    asked = Asked(frozenset(judged), modes=False)
    full = solve_stress(loaded, models, both, both, lambda _: None, asked)
    found = {
        one.kind: asdict(Compared(_numbers(one), _numbers(other)))
        for one, other in zip(swept.checks, full.checks, strict=True)
    }
    return {"seconds": spent, "full": process_time() - start, "checks": found}


def _numbers(check: Check) -> tuple[float, float, float, float]:
    return check.value, check.numerical, check.model, check.below


def told(record: Path) -> str:
    """Summary of a record, in lines."""
    rows = [json.loads(line) for line in record.read_text().splitlines()]
    solved = [row for row in rows if "checks" in row]
    pairs = [
        (kind, Compared(**numbers)) for row in solved for kind, numbers in row["checks"].items()
    ]
    corners = sum(map(is_corner, (row["number"] for row in solved)))
    lines = [
        f"{len(rows)} of {DRAWN + CORNERS} variations compared or made anew; carried over "
        f"{len(solved)}, {corners} of them at corners"
    ]
    lines += [
        f"made anew {count}: {why}"
        for why, count in Counter(row["anew"] for row in rows if "anew" in row).most_common()
    ]
    for kind in sorted({kind for kind, _ in pairs}):
        own = [pair for name, pair in pairs if name == kind]
        missed = [pair.missed for pair in own]
        bars = statistics.median(pair.swept[1] / pair.swept[0] for pair in own)
        off = statistics.median(abs(p.swept[0] / p.full[0] - 1) for p in own)
        lines.append(
            f"{kind}: {sum(m > 1 for m in missed)} of {len(own)} outside, the farthest by "
            f"{max(missed):.2f} bars; {sum(p.turned for p in own)} verdicts turned; median bar "
            f"{100 * bars:.2f} %, median difference {100 * off:.2f} %"
        )
    for name, key in (("carried over", "seconds"), ("on meshes of its own", "full")):
        times = [row[key] for row in solved]
        lines.append(
            f"processor time {name}: {statistics.median(times):.2f} s, the least {min(times):.2f} s"
        )
    return "\n".join(lines)


@one_thread()
def main() -> None:
    """Go on with a record, or tell of it."""
    record = Path(sys.argv[1])
    if sys.argv[2:] == ["told"]:
        print(told(record))
        return
    first, step = map(int, sys.argv[2:4] or ("0", "1"))
    lines = record.read_text().splitlines() if record.exists() else []
    done = {json.loads(line)["number"] for line in lines}
    store = Store(record.with_name("neighbours.store"))
    for number, overrides in enumerate(drawn()):
        if number % step == first and number not in done:
            row = {"number": number, "overrides": overrides, **compare(overrides, store)}
            with record.open("a") as stream:
                stream.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
