"""Solids on carried meshes against solids with meshes of their own, over variations of a part.

python -m bench.swept NAME RECORD        all variations; goes on where RECORD (JSON lines) ends
python -m bench.swept NAME RECORD 0 2    every second one, from the first on: for two processes
python -m bench.swept NAME RECORD told   what RECORD holds

NAME is one of `CAMPAIGNS`. The variations are drawn beforehand (`drawn`): seven of ten by a Sobol
sequence, some dimensions by up to 30 % and all else by up to 9 %, and three of ten at the corners
between neighbours, where every dimension is 9 to 9.5 % off. A verdict turns round at some limit if
the two ranges, each value with all of its bars, have nothing in common; that is asked of all, so
that every limit is covered.
"""

import json
import statistics
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import log
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.machine.runs import doubts_of, run_machine
from ballesta.sweeps.sweep import STEP, Neighbours
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
from geometry.parts import PlateLink
from tests.geometry.step_files import write_step
from tests.small_machine import MACHINE

HERE, SEED = Path(__file__).parent / "rungs", 20261126
DESIGNS = Path(__file__).parents[1] / "designs"
_END = 0.995  # of the way to the corner
STEP_ROD = """
[materials.steel]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
density = "7850 kg/m3"
yield_stress = "355 MPa"
ultimate_stress = "490 MPa"
source = "assumed, a structural steel"
[parts.rod]
body = "rod"
shape = { step = "rod.step" }
interfaces = { first = "A", second = "B" }
material = "steel"
[parts.rod.holes]
first = { diameter = "12 mm", at = "0, 0, 0 mm" }
second = { diameter = "12 mm", at = "161, 0, 0 mm" }
"""


@dataclass(frozen=True)
class Campaign:
    """Variations of a part.

    sizes     key of the design -> its value in the file and its unit
    wide      keys that vary by up to 30 %
    count     of variations
    """

    file: Path
    part: str
    sizes: Mapping[str, tuple[float, str]]
    wide: Sequence[str]
    count: int

    @property
    def told(self) -> str:
        """The part and what varies, in words."""
        wide = [_word(key) for key in self.wide]
        rest = [_word(key) for key in self.sizes if key not in self.wide]
        return (
            f"{self.part} of {self.file.stem}: {', '.join(wide)} by up to 30 %, "
            f"{', '.join(rest)} by up to 9.5 %"
        )


def _word(key: str) -> str:
    return key.rpartition(".")[2].replace("_", " ")


def _of_part(
    file: str, part: str, wide: Sequence[str], count: int, **sizes: float
) -> tuple[str, Campaign]:
    key = f"parts.{part}."
    given = {key + name: (value, "mm") for name, value in sizes.items()}
    return part, Campaign(DESIGNS / file, part, given, [key + name for name in wide], count)


CAMPAIGNS = dict([
    _of_part("toggle_press.toml", "bar_upper", ("wall", "hole"), 200, width=80.0, wall=6.3,
             hole=44.0, overhang=40.0, inner_radius=3.0, cutout_length=56.0, cutout_corner=5.0),
    _of_part("gallery/gas_engine.toml", "rod", ("tube_diameter",), 30, tube_diameter=14.0,
             eye_diameter=34.0, hole=20.0, fillet=6.0),
    _of_part("gallery/push_pull_clamp.toml", "link", ("width", "thickness"), 30, width=20.0,
             thickness=6.0, hole=8.0),
    _of_part("gallery/yoke_actuator.toml", "yoke", ("thickness",), 30, width=64.0,
             thickness=36.0, hole=30.0),
    ("step_rod", Campaign(
        Path("step_rod.toml"), "rod",
        {"parts.rod.thickness": (12.0, "mm"),
         "cycles.turn.phases[0].forces.push": (16.0, "kN"),
         "materials.steel.yield_stress": (355.0, "MPa"),
         "materials.steel.youngs_modulus": (210.0, "GPa")},
        ("parts.rod.thickness", "cycles.turn.phases[0].forces.push"), 60)),
])  # fmt: skip


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


def drawn(campaign: Campaign) -> Iterator[tuple[str, ...]]:
    """Overrides of every variation, those at corners between the others."""
    read_design(campaign.file)  # raises what is wrong with all of them
    sizes, wide = campaign.sizes, campaign.wide
    sobol = qmc.Sobol(len(sizes), seed=SEED)
    reach = np.array([log(1.3) if key in wide else log(1.09) for key in sizes])
    random = np.random.default_rng(SEED)
    count = refused = 0
    while count < campaign.count:
        if is_corner(count):
            steps = [random.integers(-1, 2) if key in wide else 0 for key in sizes]
            ends = random.choice([-1.0, 1.0], len(sizes)) * _END / 2
            moves = (np.array(steps) + ends) * log(STEP)
        else:
            moves = reach * (2 * sobol.random(1)[0] - 1)
        factors = zip(sizes.items(), np.exp(moves).tolist(), strict=True)
        overrides = tuple(f"{key}={factor * value:.5g} {unit}"
                          for (key, (value, unit)), factor in factors)  # fmt: skip
        try:
            read_design(campaign.file, overrides)
        except DesignError:  # a shape that cannot be
            refused += 1
            if refused > 1000:
                raise
            continue
        count += 1
        yield overrides


def is_corner(number: int) -> bool:
    """True if a variation is one of those at corners: three of ten."""
    return number % 10 >= 7


def loaded_of(campaign: Campaign, overrides: Sequence[str]) -> tuple[LoadedPart, Models]:
    """The part of a variation under its loads."""
    design, models = read_design(campaign.file, overrides), Models()
    machine = run_machine(design, models)
    design, doubts = machine.design, doubts_of(machine.design, machine).all
    return LoadedPart.of(design, design.parts[campaign.part], machine.all, models, doubts), models


def step_rod(folder: Path) -> Path:
    """Write a crank and slider whose rod is drawn in CAD into a folder; the file, as it was."""
    folder.mkdir(exist_ok=True)
    file, drawing = folder / "step_rod.toml", folder / "rod.step"
    if not drawing.exists():
        write_step(drawing, PlateLink(length=161, width=30, thickness=12, hole=12).build)
    file.write_text(MACHINE.replace("400 N", "16 kN") + STEP_ROD)
    return file


def compare(campaign: Campaign, overrides: Sequence[str], store: Store) -> dict[str, Any]:
    """One variation by both, with the processor time of each, s."""
    loaded, models = loaded_of(campaign, overrides)
    start = process_time()
    neighbour = Neighbours(campaign.file, overrides, store).of(campaign.part)
    known = {"neighbour": process_time() - start}
    if isinstance(neighbour, str):
        return {**known, "anew": neighbour.splitlines()[0].replace(f"{campaign.file}: ", "")}
    start = process_time()
    swept = carried_result(start_climb(loaded), neighbour, models, lambda _: None)
    known["seconds"] = process_time() - start
    if isinstance(swept, str):
        return {**known, "anew": swept}
    start = process_time()
    judged = judged_of(loaded)
    both = list(judged.values())
    asked = Asked(frozenset(judged), modes=False)
    full = solve_stress(loaded, models, both, both, lambda _: None, asked)
    found = {
        one.kind: asdict(Compared(_numbers(one), _numbers(other)))
        for one, other in zip(swept.checks, full.checks, strict=True)
    }
    return {**known, "full": process_time() - start, "checks": found}


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
        f"{len(rows)} variations compared or made anew; carried over "
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
    campaign, record = CAMPAIGNS[sys.argv[1]], Path(sys.argv[2])
    if sys.argv[3:] == ["told"]:
        print(told(record))
        return
    if sys.argv[1] == "step_rod":
        campaign = replace(campaign, file=step_rod(record.with_name("step_rod")))
    first, step = map(int, sys.argv[3:5] or ("0", "1"))
    lines = record.read_text().splitlines() if record.exists() else []
    done = {json.loads(line)["number"] for line in lines}
    store = Store(record.with_name("neighbours.store"))
    for number, overrides in enumerate(drawn(campaign)):
        if number % step == first and number not in done:
            row = {"number": number, "overrides": overrides, **compare(campaign, overrides, store)}
            with record.open("a") as stream:
                stream.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
