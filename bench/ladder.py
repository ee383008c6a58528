"""500 variations of the toggle press by formula, and one check of it as solids, in one run.

The variations are drawn from a Sobol sequence with a stated seed, between the bounds below; those
that the design's door refuses count as screened. Prints a line of JSON.
"""

import json
import os
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from time import perf_counter, process_time

from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from ballesta.sweeps.screen import Screened
from bench.screening import screen
from checks.design.data import Design
from checks.ladder.part_ladder import Effort

PRESS = "designs/toggle_press.toml"
SEED = 20261121
COUNT = 500

# key -> smallest value, largest value, unit
BOUNDS: Mapping[str, tuple[float, float, str]] = {
    "parts.bar_upper.width": (76.0, 110.0, "mm"),
    "parts.bar_upper.wall": (5.0, 10.0, "mm"),
    "parts.bar_upper.overhang": (34.0, 55.0, "mm"),
    "parts.bar_upper.cutout_corner": (3.0, 9.0, "mm"),
    "parts.pin_B.diameter": (38.0, 44.0, "mm"),
    "parts.pin_B.step_fillet": (0.4, 1.45, "mm"),
    "bodies.mould.mass": (5.0, 40.0, "kg"),
    "cycles.press.phases[1].forces.cylinder": (6.0, 11.0, "kN"),
}


def variations(count: int) -> Iterator[Mapping[str, str]]:
    """The first `count` variations of the press."""
    draws = qmc.Sobol(len(BOUNDS), seed=SEED).random_base2((count - 1).bit_length())
    for drawn in draws[:count]:
        yield {
            key: f"{low + share * (high - low):.6g} {unit}"
            for share, (key, (low, high, unit)) in zip(drawn, BOUNDS.items(), strict=True)
        }


def _statuses(found: list[Screened]) -> Mapping[str, int]:
    return Counter("refused" if one.status is None else str(one.status) for one in found)


def _timed(
    design: Design, wanted: list[Mapping[str, str]], cores: int
) -> tuple[list[Screened], float, float, float]:
    """The result; s by the clock and of the processor in one process; s by the clock in all."""
    start, busy = perf_counter(), process_time()
    found = screen(design, wanted)
    alone, alone_busy = perf_counter() - start, process_time() - busy
    start = perf_counter()
    screen(design, wanted, processes=cores)
    return found, alone, alone_busy, perf_counter() - start


def main(count: int = COUNT) -> None:
    """Measure the screening in one process and in one for each core, and the solid check."""
    design = read_design(PRESS)
    wanted = list(variations(count))
    screen(design, wanted[:2])  # what is imported once is not of the 500
    half, cores = count // 2, os.cpu_count() or 1
    # one half before the solid and one behind it: what else the machine does then weighs on both
    found, screened, screened_busy, shared = _timed(design, wanted[:half], cores)
    start, busy = perf_counter(), process_time()
    solid = check_design(design, effort=Effort("solid"))
    checked, checked_busy = perf_counter() - start, process_time() - busy
    later = _timed(design, wanted[half:], cores)
    found, screened = found + later[0], screened + later[1]
    screened_busy, shared = screened_busy + later[2], shared + later[3]
    print(
        json.dumps(
            {
                "variations": count,
                "screen": screened,
                "processes": cores,
                "screen, all processes": shared,
                "screen, processor": screened_busy,
                "solid": checked,
                "solid, processor": checked_busy,
                "screen over solid": screened / checked,
                "screen, all processes, over solid": shared / checked,
                "per variation": screened / count,
                "statuses": _statuses(found),
                "afresh": sum(one.afresh for one in found),
                "solid status": str(solid.status),
                "load average": os.getloadavg()[0],
            }
        )
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
