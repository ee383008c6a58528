"""Write docs/speed.md and its plot from bench/results.json: `python -m bench.speed_page`."""

import json
import re
import textwrap
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "bench" / "results.json"
PAGE = ROOT / "docs" / "speed.md"
PLOT = PAGE.parent / "speed" / "cost.svg"
# The ratios that are promised, in the order of the page: name in results.json, what it says.
RATIOS = {
    "solid: unit loads over CalculiX's step": (
        "assembly, factorisation, all unit loads and the stress basis of the surface, over one "
        "static step of CalculiX"
    ),
    "solid: whole cycle over CalculiX's step": (
        "the same and 720 positions with von Mises and Goodman at every surface node, over one "
        "static step of CalculiX"
    ),
    "solid: process over CalculiX's step": "the whole process, imports and reading of the mesh too",
    "solid: unit loads over CalculiX's unit steps": (
        "unit loads and stress basis, over one CalculiX run with all unit loads as steps, which "
        "factorises once: the fair rival"
    ),
    "solid: memory over CalculiX's": "peak memory of both processes",
    "solid: assembly over scikit-fem's": (
        "assembly, over scikit-fem's `linear_elasticity` on the same basis, three runs each"
    ),
}
BUCKLING = {
    "buckling: modes over factorisation and unit loads": (
        "four modes, over factorisation and unit loads of the same part"
    ),
    "buckling: modes and proof over factorisation and unit loads": "the same with the proof",
    "buckling: all over CalculiX": (
        "factorisation, unit loads, modes and proof, over CalculiX's *BUCKLE with four modes"
    ),
}
FATIGUE = {
    "fatigue: verdict over factorisation and solves": (
        "the verdict as `ballesta check` asks for it, both passes, over factorisation and "
        "unit-load solves of the same part"
    ),
    "fatigue: every point over factorisation and solves": (
        "the same with Goodman's longest chord at every point, not only where it can govern"
    ),
    "fatigue: first pass over product by point": (
        "the first pass, over rebuilding all stress histories with one product per point, stacked "
        "as numpy's `@` does it"
    ),
    "fatigue: first pass over product by block": (
        "the first pass, over the same blocks as one matrix product each"
    ),
    "fatigue: memory of the verdict": "memory of the verdict beyond its arrays, GiB",
    "fatigue: out of phase over factorisation and solves": (
        "the verdict on a cycle out of phase, over factorisation and solves"
    ),
    "fatigue: out of phase, memory": "its memory, GiB",
    "fatigue: FKM line and Miner over pyLife's": (
        "FKM's line of mean stress and Miner's sum of 30 000 points and 8 cycles, over pyLife's"
    ),
}
STAGES = (
    "assembly",
    "unit load vectors",
    "factorisation",
    "solves",
    "stress basis",
    "von Mises",
    "Goodman",
)


def read() -> dict[str, dict[str, Any]]:
    """The rows of bench/results.json by their names."""
    return {row["name"]: row for row in json.loads(RESULTS.read_text(encoding="utf-8"))}


def buckling_lines(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The section on buckling modes."""

    def value(name: str, digits: int = 2) -> str:
        return f"{rows[f'buckling: {name}']['value']:.{digits}f}"

    peer = ""
    if "buckling: CalculiX" in rows:
        peer = (
            f"CalculiX's *BUCKLE, held at six displacements, {value('CalculiX')}. On that problem "
            f"{value('factors compared', 0)} positive factors of both differ by at "
            f"most {value('factors apart', 1)} millionths."
        )
    return [
        "## Buckling modes",
        "",
        paragraph(
            f"The bar with {value('unknowns', 0)} unknowns at its largest compression, on hinges: "
            "the first four modes, and a count that proves that none was skipped. Medians of three "
            "runs in turns, with one thread."
        ),
        "",
        *ratio_lines(rows, BUCKLING),
        "",
        paragraph(
            f"Seconds: factorisation and unit loads {value('factorisation and unit loads')}, modes "
            f"{value('four modes')}, with the proof {value('four modes and the proof')}. {peer}"
        ),
        "",
    ]


def costs(rows: dict[str, dict[str, Any]]) -> dict[str, dict[int, float]]:
    """Seconds of every stage, and GiB, against the number of unknowns."""
    found: dict[str, dict[int, float]] = {}
    for name, row in rows.items():
        match = re.fullmatch(r"solid: (\d+) unknowns, (.+)", name)
        if match:
            found.setdefault(match[2], {})[int(match[1])] = row["value"]
    return found


def paragraph(text: str) -> str:
    """The text in lines of the page's width."""
    return textwrap.fill(" ".join(text.split()), 100, break_long_words=False)


def ratio_lines(rows: dict[str, dict[str, Any]], names: dict[str, str]) -> list[str]:
    """A table of what is promised, and whether it holds."""
    lines = ["| Ratio | Value | Target | |", "| --- | --- | --- | --- |"]
    for name, meaning in names.items():
        if name not in rows:  # measured where the peer is installed
            lines.append(f"| {meaning} | not run | | |")
            continue
        row = rows[name]
        target = "" if row["target"] is None else f"{row['target']:.3g}"
        verdict = {None: "", True: "holds", False: "**missed**"}[row["holds"]]
        lines.append(f"| {meaning} | {row['value']:.3g} | {target} | {verdict} |")
    return lines


def fatigue_lines(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The section on the fatigue verdict."""

    def value(name: str, digits: int = 2) -> str:
        return f"{rows[f'fatigue: {name}']['value']:.{digits}f}"

    return [
        "## Fatigue verdict",
        "",
        paragraph(
            f"The same bar, {value('surface points', 0)} points of its surface over 720 positions, "
            "in one process and two threads: solution and verdict in turns, medians of five. The "
            "first pass and the products take turns in another, of one thread each. "
            "*Out of phase* is the same cycle with each unit load a quarter of the cycle after "
            "the one before it: hardly any path is straight, and Findley decides."
        ),
        "",
        *ratio_lines(rows, FATIGUE),
        "",
        paragraph(
            f"Seconds: factorisation and unit-load solves "
            f"{value('factorisation and unit-load solves')}, verdict "
            f"{value('verdict, both passes')}, first pass {value('first pass')} "
            f"({value('first pass, points', 0)} points a second), of one thread "
            f"{value('first pass, one thread')}, histories "
            f"{value('histories, one product by point')} with one product per point and "
            f"{value('histories, one product by block')} with one per block; out of phase "
            f"{value('out of phase, verdict')}. The second pass searched the planes of "
            f"{value('planes searched at', 0)} points, out of phase of "
            f"{value('out of phase, planes searched at', 0)}, "
            f"{value('out of phase, second pass, points', 0)} points a second."
        ),
        "",
    ]


def page(rows: dict[str, dict[str, Any]]) -> str:
    """The text of docs/speed.md."""

    def value(name: str, digits: int = 2) -> str:
        return f"{rows[name]['value']:.{digits}f}"

    table = costs(rows)
    unknowns = sorted(table["factorisation"])
    lines = [
        "# Speed and memory",
        "",
        paragraph(
            "Written by `python bench/run.py` (`make bench`), which measures everything; "
            "`python -m bench.speed_page` writes this page again from bench/results.json. "
            f"Machine: {rows['solid: unit loads and stress basis']['machine']}."
        ),
        "",
        "## Beside CalculiX",
        "",
        paragraph(
            "The bar of the toggle press as a mesh of "
            f"{rows['solid: unknowns']['value']:.0f} unknowns, handed to both. CalculiX is "
            "`ccx` of Debian's calculix-ccx with its solver SPOOLES, two threads as ballesta "
            "has. Ratios are medians of five pairs run in turns; a target is the most that a "
            "ratio may be."
        ),
        "",
        *ratio_lines(rows, RATIOS),
    ]
    steps = next(name for name in rows if re.fullmatch(r"solid: CalculiX, \d+ unit steps", name))
    lines += [
        "",
        paragraph(
            f"Seconds: unit loads and stress basis {value('solid: unit loads and stress basis')}, "
            f"whole cycle {value('solid: whole cycle')}, CalculiX's one step "
            f"{value('solid: CalculiX, one step')}, CalculiX's "
            f"{steps.removeprefix('solid: CalculiX, ')} {value(steps)}. Peak memory "
            f"{value('solid: peak memory')} GiB."
        ),
        "",
        "## The solvers",
        "",
        paragraph(
            "Factorisation and solves of all unit loads, in seconds. The first that can be loaded "
            "is taken, and the result names it: CHOLMOD (the extra `cholmod`, what `make` "
            "installs), PARDISO (the extra `pardiso`), SciPy's SuperLU, of which the result warns. "
            "All give the same numbers: to 1e-9, eigenvalues to 1e-6 "
            "(tests/ballesta/test_solver_choice.py)."
        ),
        "",
        "| Solver | Small mesh | Large mesh |",
        "| --- | --- | --- |",
    ]
    for solver in ("CHOLMOD", "PARDISO", "SuperLU"):
        cells = [
            value(name) if (name := f"solid: {solver}, {size} mesh") in rows else "not run"
            for size in ("small", "large")
        ]
        lines.append(f"| {solver} | {cells[0]} | {cells[1]} |")
    lines += [
        "",
        "## Cost against size",
        "",
        "![Seconds and GiB against the number of unknowns](speed/cost.svg)",
        "",
        "Seconds per stage, and the exponent of the unknowns that fits them best.",
        "",
        "| Unknowns | " + " | ".join(f"{n}" for n in unknowns) + " | Exponent |",
        "| --- |" + " --- |" * (len(unknowns) + 1),
    ]
    for stage in STAGES:
        exponent = value(f"solid: exponent over unknowns, {stage}")
        cells = " | ".join(f"{table[stage][n]:.2f}" for n in unknowns)
        lines.append(f"| {stage} | {cells} | {exponent} |")
    exponent = value("solid: exponent over unknowns, memory")
    cells = " | ".join(f"{table['peak memory'][n]:.2f}" for n in unknowns)
    lines.append(f"| peak memory, GiB | {cells} | {exponent} |")
    press = value("toggle press: whole check", 0)
    lines += [
        "",
        *(buckling_lines(rows) if "buckling: unknowns" in rows else []),
        *(fatigue_lines(rows) if "fatigue: surface points" in rows else []),
        *short_lines(rows),
        *main_job_lines(rows),
        "## A whole check",
        "",
        paragraph(
            f"`ballesta check designs/toggle_press.toml` takes {press} s, with meshing, "
            "refinement, buckling, report and pictures."
        ),
        "",
    ]
    return "\n".join(lines)


def short_lines(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The section on commands that must answer at once."""
    found = [name for name, row in rows.items() if name.startswith("short: ") and row["target"]]
    if not found:
        return []
    lines = [
        "## Short commands",
        "",
        paragraph(
            "Whole processes on the toggle press, as installed, files and charts included, in "
            "turns with an import of some libraries, which tells how fast the machine is "
            "(scipy.interpolate, scipy.optimize, gmsh, jinja2, meshio, matplotlib.figure). Seconds "
            "are the least of seven runs, by the clock and of processors, all processes together: "
            "other work on the machine lengthens both. The ratio is the median of "
            f"processor times of pairs. Machine: {rows[found[0]]['machine']}."
        ),
        "",
        "| Command | s | Target | | s of processors | over the libraries |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for name in found:
        row, spent = rows[name], f"{name}, of processors"
        lines.append(
            f"| `{name.partition(': ')[2]}` | {row['value']:.2f} | {row['target']:g} | "
            f"{'holds' if row['holds'] else '**missed**'} | {rows[spent]['value']:.2f} | "
            f"{rows[f'{spent} over libraries']['value']:.2f} |"
        )
    return [*lines, ""]


def main_job_lines(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The section on whole checks as a user has them, and on threads."""
    words = ("peer: ", "installed: ", "batch: ")
    names = {name: name.partition(": ")[2] for name in rows if name.startswith(words)}
    if not names:
        return []
    spent = {name.partition(": ")[2]: row for name, row in rows.items() if name[:7] == "peer, s"}
    seconds = ", ".join(f"{name} {row['value']:.1f}" for name, row in spent.items())
    large = {name: rows[f"million: {name}"]["value"] for name in ("unknowns", "peak memory")
             if f"million: {name}" in rows}  # fmt: skip
    machine = rows[next(iter(names))]["machine"]
    return [
        "## The main job",
        "",
        paragraph(
            "Whole processes of `ballesta check designs/toggle_press.toml` in turns, as installed "
            "over `OMP_THREAD_LIMIT=1 OPENBLAS_NUM_THREADS=1`, and over one static step of "
            "CalculiX on 170 000 unknowns with one thread each. "
            f"Machine: {machine}."
        ),
        "",
        *ratio_lines(rows, names),
        "",
        *([paragraph(f"Seconds: {seconds}."), ""] if seconds else []),
        *(
            [
                f"{large['unknowns']:.0f} unknowns, all unit loads and the whole cycle take "
                f"{large['peak memory']:.1f} GiB.",
                "",
            ]
            if large
            else []
        ),
        *thread_lines(rows),
    ]


def thread_lines(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The table of threads by size."""
    sizes: dict[str, dict[str, float]] = {}
    for name, row in rows.items():
        match = re.fullmatch(r"threads: (\d+) unknowns, (\d+) threads", name)
        if match:
            sizes.setdefault(match[1], {})[match[2]] = row["value"]
    counts = sorted({n for row in sizes.values() for n in row}, key=int)
    if not counts:
        return []
    return [
        "Factorisation and 24 solves, seconds, by threads of OpenBLAS:",
        "",
        "| Unknowns | " + " | ".join(counts) + " |",
        "| --- |" + " --- |" * len(counts),
        *(
            f"| {size} | " + " | ".join(f"{row[n]:.2f}" for n in counts) + " |"
            for size, row in sizes.items()
        ),
        "",
    ]


def plot(rows: dict[str, dict[str, Any]], path: Path) -> None:
    """Seconds of the stages, and GiB, against the number of unknowns, both logarithmic."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    table = costs(rows)
    with mpl.rc_context({"svg.hashsalt": "ballesta", "svg.fonttype": "none", "font.size": 9}):
        figure, axes = plt.subplots(figsize=(7, 4.2), layout="constrained")
        for stage in (*STAGES, "peak memory"):
            unknowns = sorted(table[stage])
            style = "k--" if stage == "peak memory" else "o-"
            label = "peak memory, GiB" if stage == "peak memory" else stage
            axes.loglog(unknowns, [table[stage][n] for n in unknowns], style, ms=3, label=label)
        axes.set_xlabel("unknowns")
        axes.set_ylabel("s, GiB")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper left", fontsize=8, frameon=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)


def main() -> None:
    """Write page and plot."""
    rows = read()
    PAGE.write_text(page(rows), encoding="utf-8")
    plot(rows, PLOT)


if __name__ == "__main__":
    main()
