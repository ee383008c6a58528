"""Drive a machine to its extremes from file to verdict; write docs/extremes_chain.md and plots.

    python tools/study_chain_extremes.py            # some four minutes, and 3 GiB

The machine stands in tests/validation/extremes/chain.py, where tests hold the conclusions.
"""

import argparse
import resource
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tools.study_extremes import PICTURES, ROOT, draw, size, study, table

PAGE = ROOT / "docs" / "extremes_chain.md"
FINE = 2000  # positions that count as all
LARGE = (1000, 10_000, 100_000)
FILES = {"slider_crank": ("bench", "at_300"), "toggle_press": ("press", "capacity")}

HEAD = """# Extremes of the whole chain

Written by `python tools/study_chain_extremes.py`; the machine, a crank that pushes a slider by a
plate link, stands in `tests/validation/extremes/chain.py`, and `test_whole_chain.py` there holds
what is concluded. Checked by the rung `formula` where nothing else is said: from the file to the
verdict, all checks of the part and of the linkage. Degenerate verdicts:
`tests/checks/ladder/test_degenerate_verdicts.py`. Elements, solvers and shapes by themselves:
[extremes.md](extremes.md).

| What | Range | What holds | Where it warns or refuses |
| --- | --- | --- | --- |
| [Positions](#positions) | 8 to 100 000 | every number to what the validity check tells, falling \
with the square of the count | more than 1 % of a load between the positions: the validity check \
breaks, the verdict stays UNDECIDED, and a count that is enough is named |
| [Units, place, start](#the-same-machine) | inch and lbf, turned, mirrored, part reversed | every \
number to round-off, start to what positions leave | |
| [Loads](#sizes) | 12 decades | stress proportional to 1e-8 | 1e30 N and more: refused |
| [Speeds](#sizes) | 0.01 to 1000 rad/s | numbers, inertia as the square | |
| [Shapes](#sizes) | sheets, wires, holes nearly as wide as the plate | numbers; beyond what \
solids were compared with the bar is unknown, and `auto` climbs | `formula` alone: \
UNDECIDED, with what is beyond |
"""


def positions() -> Iterator[str]:
    """Errors, time and memory by the count of positions."""
    chain = study("chain")
    yield from (
        "## Positions",
        "",
        f"Largest error of any number of the verdict against {FINE} positions, of the static peak, "
        "and what the validity check `loads between the positions` tells: how far loads at other "
        "positions, "
        "which placing them has solved anyway, lie beyond those at its own. A phase has at least "
        "20 positions.",
        "",
    )
    curves = {}
    for speed in (10.0, 300.0):
        guise = replace(chain.PLAIN, speed=speed)
        exact = chain.values(chain.checked(replace(guise, positions=FINE)))
        static = next(key for key in exact if key[1] == "static")
        rows, found = [], {}
        for count in chain.COUNTS:
            counted = replace(guise, positions=count)
            result = chain.checked(counted)
            errors = {key: abs(v / exact[key] - 1) for key, v in chain.values(result).items()}
            missed = chain.unresolved(counted)
            worst = max(errors, key=lambda key: errors[key])
            found[max(count, 20)] = (errors[worst], missed)
            gate = "holds" if missed <= 0.01 else "BROKEN"
            told = [size(v) for v in (errors[worst], errors[static], missed)]
            rows.append([f"{count}", told[0], f"{worst[1]}, {worst[2]}", *told[1:], gate])
        curves[f"{speed:g} rad/s"] = found
        yield f"At {speed:g} rad/s:"
        yield ""
        yield from table(["positions", "worst", "of", "static", "told", "validity check"], rows)
    draw_positions(curves, PICTURES / "positions.svg")
    yield "![errors by the count of positions](extremes/positions.svg)"
    yield ""
    yield from machines()
    rows = []
    for count in LARGE:
        start = perf_counter()
        chain.checked(chain.with_count(count))
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        rows.append([f"{count}", f"{perf_counter() - start:.0f}", f"{used:.1f}"])
    yield "Time and memory of a check of this machine, most of it for vibration and for the frame:"
    yield ""
    yield from table(["positions", "s", "GiB"], rows)


def machines() -> Iterator[str]:
    """Peaks that two machines' cycles miss, by their number of positions."""
    import loads
    from ballesta.design.read import read_design
    from ballesta.machine.solved_cycles import part_masses, solve_cycles
    from checks.stress.solid_mesh_level import Models

    chain = study("chain")
    rows = []
    for name, cycles in FILES.items():
        for count in (8, 32, 128, 361):
            overrides = [f"cycles.{cycle}.positions={count}" for cycle in cycles]
            design = read_design(chain.DESIGNS / f"{name}.toml", overrides)
            solved = solve_cycles(design, part_masses(design, Models()))
            for cycle, run in solved.items():
                assert isinstance(run, loads.CycleLoads)
                missed = run.unresolved
                told = [size(missed.share) if missed.share else "nothing", missed.what]
                rows.append([f"{name}, {cycle}", f"{count}", f"{len(run.positions)}", *told])
    yield "Machines of this repository; the press is loaded most where its phases end:"
    yield ""
    yield from table(["cycle", "asked", "positions", "told", "most"], rows)


def same() -> Iterator[str]:
    """The same machine, stated otherwise."""
    chain = study("chain")
    base = replace(chain.PLAIN, positions=91)
    fine = replace(chain.PLAIN, positions=361)
    guises = {
        "inch, lbf, lb, psi": (base, {"units": chain.IMPERIAL}),
        "turned by 37 deg, gravity with it": (base, {"turned": 37.0}),
        "turned by 90 deg": (base, {"turned": 90.0}),
        "turned by -60 deg": (base, {"turned": -60.0}),
        "mirrored": (base, {"mirrored": True}),
        "mirrored and turned by 123 deg": (base, {"mirrored": True, "turned": 123.0}),
        "the part's first interface at the slider": (base, {"flipped": True}),
        "starts at 0 deg, 361 positions": (fine, {"start": 0.0}),
        "starts at 37 deg": (fine, {"start": 37.0}),
        "starts at 200 deg": (fine, {"start": 200.0}),
    }
    rows = []
    plain = {guise: chain.checked(guise) for guise in (base, fine)}
    for name, (guise, changes) in guises.items():
        result = chain.checked(replace(guise, **changes))
        alike = chain.statuses(result) == chain.statuses(plain[guise])
        apart = size(chain.apart(plain[guise], result))
        rows.append([name, apart, "the same" if alike else "OTHERS"])
    yield "## The same machine"
    yield ""
    yield "Largest difference of any number of the verdict, and whether every status is the same."
    yield ""
    yield from table(["stated", "apart", "statuses"], rows)


def sizes() -> Iterator[str]:
    """Loads, speeds and shapes."""
    from checks.design.errors import DesignError, NumericsError

    chain = study("chain")
    few = replace(chain.PLAIN, positions=91)
    pushed = replace(few, masses=0.0, gravity=0.0, speed=1e-6)
    one = chain.check_of(chain.checked(pushed), "static").value
    rows = []
    for factor in chain.LOADS:
        result = chain.checked(replace(pushed, push=400.0 * factor))
        value = chain.check_of(result, "static").value
        rows.append(
            [f"{400 * factor:g}", f"{value:.4g}", size(abs(value / factor / one - 1)),
             str(result.status)]
        )  # fmt: skip
    yield "## Sizes"
    yield ""
    yield from table(["push, N", "static peak, MPa", "off the proportion", "verdict"], rows)
    rows = []
    for speed in chain.SPEEDS:
        result = chain.checked(replace(few, speed=speed))
        checks = [chain.check_of(result, kind).value for kind in ("static", "fatigue")]
        rows.append([f"{speed:g}", *(f"{v:.4g}" for v in checks), str(result.status)])
    yield from table(["rad/s", "static, MPa", "fatigue, MPa", "verdict"], rows)
    shapes: Mapping[str, Mapping[str, float]] = study("test_whole_chain").SHAPES
    rows = []
    for name, changes in shapes.items():
        row = [name]
        for effort in ("formula", "auto"):
            try:
                check = chain.check_of(chain.checked(replace(few, **changes), effort), "static")
            except (DesignError, NumericsError) as error:
                row.append(f"refused: {str(error).partition('parts.rod: ')[2].partition(';')[0]}")
                continue
            known = isfinite(check.model)
            bar = "±" + (size((check.numerical + check.model) / check.value) if known else "∞")
            row.append(f"{check.value:.4g} {bar}, {check.status} ({check.method})")
        rows.append(row)
    yield "Static peak, MPa, of the plate link in shapes that no solid was compared with:"
    yield ""
    yield from table(["shape", "formula", "auto"], rows)


def draw_positions(curves: Mapping[str, Mapping[int, tuple[float, float]]], path: Path) -> None:
    """Errors and their estimates over the number of positions."""

    def plot(axes: Any) -> None:
        for k, (name, found) in enumerate(curves.items()):
            error, told = zip(*found.values(), strict=True)
            axes.loglog(list(found), error, "o-", color=f"C{k}", label=f"{name}: worst error")
            axes.loglog(list(found), told, ":", color=f"C{k}", label=f"{name}: told")
        axes.axhline(0.01, color="#888888", lw=0.8)
        axes.set_xlabel("positions; the line is where the validity check breaks")
        axes.set_ylabel("relative error")

    draw(plot, path)


def page() -> str:
    """The text of docs/extremes_chain.md."""
    parts = (positions(), same(), sizes())
    return "\n".join([HEAD, *(line for part in parts for line in part)]).rstrip() + "\n"


def main() -> int:
    """Write the page and its plot."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
