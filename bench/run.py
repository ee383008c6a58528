"""Run the benchmarks and write bench/results.json (name, value, unit, target, holds, machine).

Each measurement runs in a process of its own. Times are medians of the stated number of runs and
belong to the machine named beside them; nothing here is asserted in a test. docs/speed.md is
written from the results. `python bench/run.py solid` runs that one and keeps the other rows; those
that want a quiet machine are `short peer batch million installed`, in 3, 3, 5, 3 and 15 minutes.
"""

import json
import os
import platform
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

HERE = Path(__file__).parent
PRESS = HERE.parent / "designs" / "toggle_press.toml"


def machine() -> str:
    """The machine that the numbers were measured on."""
    model = ""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            line.split(":", 1)[1].strip()
            for line in cpuinfo.read_text().splitlines()
            if line.startswith("model name")
        ]
        model = names[0] if names else ""
    python = platform.python_version()
    return f"{model or platform.machine()}, {os.cpu_count()} cores, Python {python}"


def entry(name: str, value: float, unit: str, target: float | None = None) -> dict[str, Any]:
    """One benchmark; a target is the most that `value` should be."""
    return {
        "name": name,
        "value": round(value, 3),
        "unit": unit,
        "target": target,
        "holds": None if target is None else value <= target,
        "machine": machine(),
    }


def help_time() -> list[dict[str, Any]]:
    """`ballesta --help`, which must not import anything heavy."""
    times = []
    for _ in range(5):
        start = perf_counter()
        subprocess.run(
            [sys.executable, "-m", "ballesta", "--help"], check=True, capture_output=True
        )
        times.append(perf_counter() - start)
    return [entry("ballesta --help", statistics.median(times), "s", 0.5)]


def measured_by(module: str, *arguments: str) -> dict[str, Any]:
    """Last line, JSON, that a benchmark of its own process prints."""
    done = subprocess.run(
        [sys.executable, "-m", module, *arguments],
        check=True,
        capture_output=True,
        text=True,
        cwd=HERE.parent,
    )
    return dict(json.loads(done.stdout.splitlines()[-1]))


def press_check() -> list[dict[str, Any]]:
    """The check of the toggle press, stage by stage, with report and files."""
    measured = measured_by("bench.press", str(PRESS))
    rows = [
        entry("toggle press: whole check", measured["seconds"], "s", 60.0),
        entry("toggle press: peak memory", measured["memory"], "GiB"),
    ]
    rows += [entry(f"toggle press: {k}", v, "s") for k, v in measured["stages"].items()]
    rows += [
        entry(f"toggle press: memory after {k}", v, "GiB") for k, v in measured["memories"].items()
    ]
    return rows


def loads_of_machines() -> list[dict[str, Any]]:
    """720 positions of four machines: seconds, and the part of the one-by-one way's time.

    ``arrays``: same functions as ours; ``jacobian``: these with analytic slopes; ``floats``: the
    constraints written out in floats, the quickest script. A target of 0.1 is ten times as fast.
    """
    measured = measured_by("bench.loads")
    rows = []
    for name, row in measured["machines"].items():
        rows.append(entry(f"loads, {name}: 720 positions", row["together"], "s"))
        rows.append(entry(f"loads, {name}: run_cycle of 720", row["cycle"], "s"))
        for way in ("arrays", "jacobian", "floats"):
            target = 0.1 if way == "arrays" else None
            rows.append(
                entry(f"loads, {name}: over {way}", row["together"] / row[way], "1", target)
            )
    cost = measured["costs"]
    rows += [
        entry(f"loads: time per position of {n}", value, "us")
        for n, value in cost["microseconds"].items()
    ]
    rows.append(entry("loads: exponent of time over positions, 1e4 to 1e5", cost["exponent"], "1"))
    rows.append(entry("loads: peak memory of 1e5 positions", cost["mebibytes"] / 1024, "GiB"))
    return rows


def solid_and_its_peer() -> list[dict[str, Any]]:
    """A lug bar of 170 000 unknowns over 720 positions, and CalculiX's single static step.

    Ratios are medians over five pairs run in turns, both with two threads. ``process`` counts from
    the start of the interpreter, as CalculiX's time does; the rest from the mesh in memory.
    """
    measured = measured_by("bench.solid")
    stock = measured["stock"]
    rows = [
        entry("solid: assembly, scikit-fem's form", stock["theirs"], "s"),
        entry("solid: assembly, ours", stock["ours"], "s"),
        entry("solid: assembly over scikit-fem's", stock["ours"] / stock["theirs"], "1", 1 / 15),
    ]
    if "pairs" in measured:
        pair = measured["pairs"]
        units = measured["unit steps of calculix"]
        rows += [
            entry("solid: unknowns", pair["unknowns"], "1"),
            entry("solid: unit loads and stress basis", pair["unit"], "s"),
            entry("solid: whole cycle", pair["whole"], "s"),
            entry("solid: whole cycle, process", pair["process"], "s"),
            entry("solid: CalculiX, one step", pair["calculix"], "s"),
            entry(f"solid: CalculiX, {pair['unit loads']} unit steps", units, "s"),
            entry("solid: unit loads over CalculiX's step", pair["unit over calculix"], "1", 0.6),
            entry(
                "solid: whole cycle over CalculiX's step", pair["whole over calculix"], "1", 0.75
            ),
            entry("solid: process over CalculiX's step", pair["process over calculix"], "1", 0.75),
            entry("solid: unit loads over CalculiX's unit steps", pair["unit"] / units, "1"),
            entry("solid: peak memory", pair["memory"], "GiB"),
            entry("solid: memory over CalculiX's", pair["memory over calculix"], "1", 1.3),
        ]
        rows += [entry(f"solid: {stage}", value, "s") for stage, value in pair["stages"].items()]
    for size, solvers in measured["solvers"].items():
        for name, row in solvers.items():
            spent = row["factorisation"] + row["solves"]
            rows.append(entry(f"solid: {name}, {size} mesh", spent, "s"))
    for row in measured["costs"]["rows"]:
        label = f"solid: {row['unknowns']} unknowns"
        limit = 16.0 if row["unknowns"] > 400_000 else None
        rows.append(entry(f"{label}, peak memory", row["memory"], "GiB", limit))
        rows += [entry(f"{label}, {stage}", value, "s") for stage, value in row["stages"].items()]
    for stage, value in measured["costs"]["exponents"].items():
        rows.append(entry(f"solid: exponent over unknowns, {stage}", value, "1"))
    return rows


def fatigue_verdict() -> list[dict[str, Any]]:
    """The fatigue verdict of the lug bar over 720 positions, and FKM and Miner beside pyLife's.

    Ratios are medians over five turns in one process, with two threads; those of the first pass
    over products of one thread each. ``out of phase``: each unit load a quarter of the cycle after
    the one before, so that hardly any path is straight.
    """
    measured = measured_by("bench.fatigue")
    points = measured["points"]
    ratio = "over factorisation and solves"
    search = measured["apart searched"] / measured["apart search"]
    rows = [
        entry("fatigue: surface points", points, "1"),
        entry("fatigue: factorisation and unit-load solves", measured["solution"], "s"),
        entry("fatigue: verdict, both passes", measured["verdict"], "s"),
        entry(f"fatigue: verdict {ratio}", measured["verdict over solution"], "1", 0.25),
        entry("fatigue: Goodman at every point too", measured["every point"], "s"),
        entry(f"fatigue: every point {ratio}", measured["every point over solution"], "1"),
        entry("fatigue: planes searched at", measured["searched"], "points"),
        entry("fatigue: memory of the verdict", measured["cycle memory"], "GiB", 2.0),
        entry("fatigue: first pass", measured["first pass"], "s"),
        entry("fatigue: first pass, points", points / measured["first pass"], "1/s"),
        entry("fatigue: first pass, one thread", measured["bounds"], "s"),
    ]
    for way in ("by point", "by block"):
        over = measured[f"first pass over {way}"]
        rows += [
            entry(f"fatigue: histories, one product {way}", measured[way], "s"),
            entry(f"fatigue: first pass over product {way}", over, "1", 3.0),
        ]
    rows += [
        entry("fatigue: out of phase, verdict", measured["apart"], "s"),
        entry(f"fatigue: out of phase {ratio}", measured["apart over solution"], "1"),
        entry("fatigue: out of phase, planes searched at", measured["apart searched"], "points"),
        entry("fatigue: out of phase, second pass, points", search, "1/s"),
        entry("fatigue: out of phase, memory", measured["apart memory"], "GiB", 2.0),
    ]
    peer = measured["pylife"]
    if peer:
        rows += [
            entry("fatigue: FKM line and Miner, ours", 1e3 * peer["ours"], "ms"),
            entry("fatigue: FKM line and Miner, pyLife", 1e3 * peer["theirs"], "ms"),
            entry("fatigue: FKM line and Miner over pyLife's", peer["ours over theirs"], "1", 1.0),
        ]
    return rows


def buckling_modes() -> list[dict[str, Any]]:
    """Four modes of a lug bar of 150 000 unknowns, and CalculiX's *BUCKLE on its mesh.

    Medians of three runs in turns, both with one thread. CalculiX's time is its process', ours
    from the mesh in memory through factorisation and unit loads to the proven modes.
    """
    measured = measured_by("bench.buckling")
    before = "over factorisation and unit loads"
    rows = [
        entry("buckling: unknowns", measured["unknowns"], "1"),
        entry("buckling: factorisation and unit loads", measured["unit"], "s"),
        entry("buckling: four modes", measured["modes"], "s"),
        entry("buckling: four modes and the proof", measured["proven"], "s"),
        entry(f"buckling: modes {before}", measured["modes over unit"], "1", 1.0),
        entry(f"buckling: modes and proof {before}", measured["proven over unit"], "1", 2.0),
    ]
    if "calculix" in measured:
        apart = 1e6 * measured["apart"]
        rows += [
            entry("buckling: CalculiX", measured["calculix"], "s"),
            entry("buckling: all over CalculiX", measured["over calculix"], "1", 1.0),
            entry("buckling: factors apart", apart, "1e-6"),
            entry("buckling: factors compared", measured["compared"], "1"),
        ]
    return rows


def as_installed() -> list[dict[str, Any]]:
    """The check of the press as installed over the same with bound threads, ten pairs in turns."""
    rows = []
    for name, row in measured_by("bench.main_job", "installed").items():
        limit = 1.05 if name == "idle" else 1.15
        for what, value in zip(
            ("verdict", "all files"), row["verdict and all files over bound"], strict=True
        ):
            rows.append(
                entry(f"installed: {what} as installed over bound, {name}", value, "1", limit)
            )
    return rows


def beside_peer() -> list[dict[str, Any]]:
    """The check of the press over one step of CalculiX, five pairs of whole processes in turns."""
    measured = measured_by("bench.main_job", "peer")
    verdict, files, theirs = measured["seconds: verdict, all files, CalculiX"]
    ratios = measured["verdict and all files over CalculiX"]
    return [
        entry("peer: verdict over CalculiX's step", ratios[0], "1", 0.6),
        entry("peer: all files over CalculiX's step", ratios[1], "1", 1.0),
        entry("peer, s: verdict", verdict, "s"),
        entry("peer, s: all files", files, "s"),
        entry(f"peer, s: {measured['peer']}", theirs, "s"),
    ]


def batches() -> list[dict[str, Any]]:
    """Batches of N workers over N runs side by side that know nothing of each other."""
    rows = []
    for workers in (2, 4):
        if workers <= (os.cpu_count() or 1):
            found = measured_by("bench.main_job", "batch", str(workers))
            share = found["throughput over independent runs, s, s"][0]
            name = f"batch: {workers} workers over {workers} independent runs, time"
            rows.append(entry(name, 1 / share, "1", 1 / 0.93))
    return rows


def a_million() -> list[dict[str, Any]]:
    """Memory of a million unknowns with all unit loads and the whole cycle."""
    measured = measured_by("bench.solid", "million")
    rows = [
        entry("million: unknowns", measured["unknowns"], "1"),
        entry("million: peak memory", measured["memory"], "GiB", 12.0),
        entry("million: whole process", measured["process"], "s"),
    ]
    return rows


def short_commands() -> list[dict[str, Any]]:
    """Commands that must answer at once, as processes in turns with an import of the libraries."""
    measured = measured_by("bench.main_job", "short")
    rows = []
    for name, limit in (
        ("check --fidelity formula", 1.5),
        ("loads", 1.0),
        ("import ballesta", 0.2),
    ):
        row = measured[name]
        rows += [
            entry(f"short: {name}", row["least"][0], "s", limit),
            entry(f"short: {name}, of processors", row["least"][1], "s"),
            entry(f"short: {name}, of processors over libraries", row["over libraries"][1], "1"),
        ]
    return rows


def forging() -> list[dict[str, Any]]:
    """A steady run by a motor over the same at a prescribed speed, five in turns, and a blow."""
    measured = measured_by("bench.forging")
    return [
        entry(
            "forging: 720 positions by motor over prescribed speed",
            measured["steady over prescribed"], "1", 5.0,
        ),
        entry("forging: 720 positions by motor, of processors", measured["steady"], "s"),
        entry("forging: one blow, of processors", measured["blow"], "s", 1.0),
    ]  # fmt: skip


def threads_by_size() -> list[dict[str, Any]]:
    """Factorisation and 24 solves by number of threads, from 6 000 to 570 000 unknowns."""
    done = subprocess.run(
        [sys.executable, "-m", "bench.threads"],
        check=True, capture_output=True, text=True, cwd=HERE.parent,
    )  # fmt: skip
    rows = []
    for line in done.stdout.splitlines():
        found = json.loads(line)
        size = found.pop("unknowns")
        for threads, (wall, _, solves, _) in found.items():
            name = f"threads: {size} unknowns, {threads} threads"
            rows.append(entry(name, wall + solves, "s"))
    return rows


def ladder_of_the_press() -> list[dict[str, Any]]:
    """500 variations of the press by formula, loads solved again, and one solid check of it."""
    measured = measured_by("bench.ladder")
    refused = measured["statuses"].get("refused", 0)
    return [
        entry("ladder: variations of the press screened", measured["variations"], "1"),
        entry("ladder: of these refused at the door", refused, "1"),
        entry("ladder: all variations by formula", measured["screen"], "s"),
        entry("ladder: the same, a process per core", measured["screen, all processes"], "s"),
        entry("ladder: one variation", 1e3 * measured["per variation"], "ms"),
        entry("ladder: one check as solids", measured["solid"], "s"),
        entry("ladder: all variations over one solid", measured["screen over solid"], "1", 1.0),
        entry(
            "ladder: all over one solid, a process per core",
            measured["screen, all processes, over solid"],
            "1",
            1.0,
        ),
    ]


# Every benchmark by the first word of its rows.
BENCHMARKS = {
    "ballesta": help_time,
    "buckling": buckling_modes,
    "fatigue": fatigue_verdict,
    "forging": forging,
    "ladder": ladder_of_the_press,
    "loads": loads_of_machines,
    "installed": as_installed,
    "peer": beside_peer,
    "batch": batches,
    "million": a_million,
    "short": short_commands,
    "solid": solid_and_its_peer,
    "threads": threads_by_size,
    "toggle": press_check,
}


def main(wanted: Sequence[str]) -> None:
    """Run the benchmarks named, or all, and keep the rows of the others; saved after each."""
    path = HERE / "results.json"
    results = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    for word in wanted or BENCHMARKS:
        print(f"running {word}", file=sys.stderr)
        rows = BENCHMARKS[word]()
        results = [row for row in results if row["name"].split()[0].strip(":,") != word] + rows
        path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    if any(row["name"] == "solid: unknowns" for row in results):
        subprocess.run([sys.executable, "-m", "bench.speed_page"], check=True, cwd=HERE.parent)
    else:
        print("ccx is missing: docs/speed.md is left as it was", file=sys.stderr)
    for row in results:
        target = "" if row["target"] is None else f"  (at most {row['target']}: {row['holds']})"
        print(f"{row['name']:45s} {row['value']:9.3f} {row['unit']}{target}")


if __name__ == "__main__":
    main(sys.argv[1:])
