"""A lug bar solved by ballesta and by CalculiX on one mesh, each run a process of its own.

`python -m bench.solid` prints everything as a line of JSON; the other commands are its children:
prepare, ours, stock, solver; `million` is one run on a million
unknowns. CalculiX is `ccx`, with as many threads as ballesta.
"""

import json
import os
import pickle
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

THREADS = "2"
PAIRS = 5
FINENESS = 1.1  # 170 000 unknowns
SIZES = (0.34, 0.6, FINENESS, 1.45, 1.87)  # 20 000 to 500 000 unknowns
MILLION = 2.45  # 1.05 million unknowns
SMALL = 0.6  # what SuperLU can do in reasonable time
POSITIONS = 720
YOUNG, POISSON, DENSITY = 210e3, 0.3, 7.85e-9
DESIGN = Path(__file__).parent.parent / "designs" / "toggle_press.toml"


def child(*command: str, folder: Path | None = None) -> tuple[float, float, str]:
    """Wall time, peak memory in GiB and output of a process."""
    environment = {**os.environ, "OMP_NUM_THREADS": THREADS, "OPENBLAS_NUM_THREADS": THREADS}
    environment["MKL_NUM_THREADS"] = THREADS
    start = perf_counter()
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command, cwd=folder, env=environment, stdout=output)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = perf_counter() - start
        output.seek(0)
        text = output.read()
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}:\n{text[-2000:]}")
    return seconds, usage.ru_maxrss / 2**20, text


def python(*arguments: str) -> tuple[float, float, dict[str, Any]]:
    """Wall time, peak memory and the last line's JSON of one of this module's commands."""
    seconds, memory, text = child(sys.executable, "-m", "bench.solid", *arguments)
    return seconds, memory, json.loads(text.splitlines()[-1])


def calculix(deck: Path) -> tuple[float, float]:
    """Wall time and peak memory, GiB, of CalculiX on a deck."""
    seconds, memory, text = child("ccx", deck.stem, folder=deck.parent)
    if "Job finished" not in text:
        raise RuntimeError(f"ccx did not finish {deck}:\n{text[-2000:]}")
    return seconds, memory


def bar() -> Any:
    """The toggle bar of designs/toggle_press.toml."""
    from geometry.parts import ToggleBar

    return ToggleBar(
        length=250,
        width=80,
        wall=6.3,
        hole=44,
        overhang=40,
        inner_radius=3,
        cutout_length=56,
        cutout_corner=5,
    )


def press_loads() -> tuple[dict[str, Any], Any]:
    """Wrenches (720, 6) on the bar's interfaces over the press' cycle, and accelerations."""
    from ballesta.design.read import read_design
    from ballesta.machine.solved_cycles import part_masses, solve_cycles
    from checks.part.part_loads import loads_on
    from checks.stress.solid_mesh_level import Models

    design = read_design(DESIGN, [f"cycles.press.positions={POSITIONS}"])
    solved = solve_cycles(design, part_masses(design, Models()))
    loads = loads_on(design, design.parts["bar_upper"], {"press": solved["press"]})
    wrenches = {name: wrench[:POSITIONS] for name, wrench in loads.wrenches.items()}
    return wrenches, loads.accelerations[:POSITIONS]


def prepare(folder: Path, fineness: float, with_decks: bool) -> dict[str, Any]:
    """Mesh, loads, and decks of CalculiX: the worst position, and all unit loads."""
    from geometry.meshing import mesh_shape

    mesh = mesh_shape(bar(), fineness=fineness)
    (folder / "mesh.pickle").write_bytes(pickle.dumps(mesh))
    (folder / "loads.pickle").write_bytes(pickle.dumps(press_loads()))
    if with_decks:
        from fem.deck import write_deck
        from fem.unit_solutions import solve_unit_loads

        solutions = solve_unit_loads(replace(mesh), elastic())
        coefficients, _ = solutions.coefficients(*press_loads())
        load = solutions.loads @ coefficients[:, -1]
        for name, columns in (("one", load), ("units", solutions.loads)):
            deck = folder / f"{name}.inp"
            write_deck(deck, mesh, solutions.material, solutions.held, columns, "toggle bar")
    return {"unknowns": 3 * len(mesh.nodes), "elements": len(mesh.elements)}


def elastic() -> Any:
    from fem.unit_solutions import Elastic

    return Elastic(YOUNG, POISSON, DENSITY)


def ours(folder: Path) -> dict[str, Any]:
    """The whole cycle from the mesh to von Mises and Goodman at every surface node, by stage."""
    import fem.unit_solutions as solving
    from fatigue import goodman
    from fem.stress_history import StressHistory
    from fem.threads import keep_freed_memory

    keep_freed_memory()  # as `ballesta check` does
    stages: dict[str, float] = {}

    def timed(stage: str, work: Any) -> Any:
        def run(*arguments: Any, **named: Any) -> Any:
            start = perf_counter()
            answer = work(*arguments, **named)
            stages[stage] = stages.get(stage, 0.0) + perf_counter() - start
            return answer

        return run

    for name, stage in (
        ("stiffness", "assembly"),
        ("interface_loads", "unit load vectors"),
        ("acceleration_loads", "unit load vectors"),
        ("factorize", "factorisation"),
        ("_solve_held", "solves"),
    ):
        setattr(solving, name, timed(stage, getattr(solving, name)))
    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    wrenches, accelerations = pickle.loads((folder / "loads.pickle").read_bytes())

    start = perf_counter()
    solutions = solving.solve_unit_loads(mesh, elastic())
    basis = timed("stress basis", lambda: solutions.basis)()
    unit = perf_counter() - start
    coefficients, _ = solutions.coefficients(wrenches, accelerations)
    nodes = solutions.recovery.points
    history = StressHistory(nodes, mesh.nodes[nodes], basis, coefficients)
    peaks, _ = timed("von Mises", history.peaks_by_position)()
    verdict = timed("Goodman", goodman)(basis, coefficients, 200.0, 500.0)
    whole = perf_counter() - start
    return {
        "unknowns": 3 * len(mesh.nodes),
        "points": len(nodes),
        "unit loads": len(coefficients),
        "positions": coefficients.shape[1],
        "solver": solutions.factor.solver,
        "unit": unit,
        "whole": whole,
        "stages": stages,
        "peak": float(peaks.max()),
        "utilisation": float(verdict.utilisation.max()),
    }


def stock(folder: Path) -> dict[str, Any]:
    """Assembly by scikit-fem's own form and by ours, and how far they are apart."""
    import numpy as np
    import skfem
    from skfem.models.elasticity import linear_elasticity

    from bench.scikit_fem import to_scikit_fem
    from fem.assembly import Elements, Pattern, full, stiffness

    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    element = skfem.ElementVector(skfem.ElementTetP2())
    basis = skfem.CellBasis(to_scikit_fem(mesh), element, intorder=2)
    form = linear_elasticity(
        YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
    )
    theirs, own = [], []
    for _ in range(3):
        start = perf_counter()
        matrix = form.assemble(basis)
        theirs.append(perf_counter() - start)
        start = perf_counter()  # with all that scikit-fem's basis holds already
        upper = stiffness(Pattern(Elements(mesh)), YOUNG, POISSON)
        own.append(perf_counter() - start)
    to_ours = np.empty(basis.N, dtype=int)
    for k in range(basis.element_dofs.shape[0]):  # 10 nodes of 3 components
        to_ours[basis.element_dofs[k]] = 3 * mesh.elements[:, k // 3] + k % 3
    order = np.argsort(to_ours)
    apart = abs(full(upper) - matrix.tocsr()[order][:, order]).max() / abs(upper).max()
    return {
        "theirs": statistics.median(theirs),
        "ours": statistics.median(own),
        "apart": float(apart),
    }


def solver(folder: Path, name: str) -> dict[str, Any]:
    """Factorisation and solves of all unit loads with one solver."""
    import fem.unit_solutions as solving

    seconds: dict[str, float] = {}
    factorize, solve = solving.factorize, solving._solve_held

    def timed_factorize(upper: Any, **_: Any) -> Any:  # with its own order of elimination
        start = perf_counter()
        factor = factorize(upper, name)
        seconds["factorisation"] = perf_counter() - start
        return factor

    def timed_solve(*arguments: Any) -> Any:
        start = perf_counter()
        answer = solve(*arguments)
        seconds["solves"] = perf_counter() - start
        return answer

    solving.factorize, solving._solve_held = timed_factorize, timed_solve
    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    solutions = solving.solve_unit_loads(mesh, elastic())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return {**seconds, "backward error": solutions.residual, "memory": peak}


def pairs(folder: Path) -> dict[str, Any]:
    """Medians of ballesta's and CalculiX's times, run in turns; ratios of each pair."""
    runs = []
    for _ in range(PAIRS):
        seconds, memory, measured = python("ours", str(folder))
        theirs, their_memory = calculix(folder / "one.inp")
        runs.append(
            measured
            | {
                "process": seconds,
                "memory": memory,
                "calculix": theirs,
                "calculix memory": their_memory,
                "unit over calculix": measured["unit"] / theirs,
                "whole over calculix": measured["whole"] / theirs,
                "process over calculix": seconds / theirs,
                "memory over calculix": memory / their_memory,
            }
        )
    middle = {
        key: statistics.median(run[key] for run in runs)
        for key, value in runs[0].items()
        if isinstance(value, float)
    }
    middle["stages"] = {
        stage: statistics.median(run["stages"][stage] for run in runs)
        for stage in runs[0]["stages"]
    }
    fixed = {k: runs[0][k] for k in ("unknowns", "points", "unit loads", "positions", "solver")}
    return fixed | middle


def costs(root: Path) -> dict[str, Any]:
    """Stages and memory against the number of unknowns, and the exponents between the ends."""
    import numpy as np

    rows = []
    for fineness in SIZES:
        folder = root / f"size_{fineness}"
        folder.mkdir()
        python("prepare", str(folder), str(fineness))
        process, memory, measured = min(
            (python("ours", str(folder)) for _ in range(3)), key=lambda run: run[0]
        )
        rows.append(measured | {"process": process, "memory": memory})
        shutil.rmtree(folder)
    unknowns = np.log([row["unknowns"] for row in rows])
    exponents = {
        stage: float(np.polyfit(unknowns, np.log([row["stages"][stage] for row in rows]), 1)[0])
        for stage in rows[0]["stages"]
    }
    for key in ("unit", "whole", "memory"):
        exponents[key] = float(np.polyfit(unknowns, np.log([row[key] for row in rows]), 1)[0])
    return {"rows": rows, "exponents": exponents}


def million() -> dict[str, Any]:
    """One run on a million unknowns: seconds and peak memory of the process."""
    with tempfile.TemporaryDirectory() as folder:
        python("prepare", folder, str(MILLION))
        process, memory, measured = python("ours", folder)
        return measured | {"process": process, "memory": memory}


def ladder(folder: Path, root: Path) -> dict[str, Any]:
    """Every solver that is there on a small mesh, and the first two on the large one."""
    small = root / "small"
    small.mkdir()
    python("prepare", str(small), str(SMALL))
    found: dict[str, Any] = {"small": {}, "large": {}}
    for size, place, names in (
        ("small", small, ("CHOLMOD", "PARDISO", "SuperLU")),
        ("large", folder, ("CHOLMOD", "PARDISO")),
    ):
        for name in names:
            try:
                found[size][name] = python("solver", str(place), name)[2]
            except RuntimeError as error:  # pypardiso is an extra
                print(f"{name} was not measured: {error}", file=sys.stderr)
    return found


def measure() -> dict[str, Any]:
    """Everything; without ccx what concerns ballesta alone."""
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)
        folder = root / "large"
        folder.mkdir()
        peer = shutil.which("ccx") is not None
        python("prepare", str(folder), str(FINENESS), *(["decks"] if peer else []))
        result: dict[str, Any] = {"stock": python("stock", str(folder))[2]}
        if peer:
            result["pairs"] = pairs(folder)
            result["unit steps of calculix"] = calculix(folder / "units.inp")[0]
        result["solvers"] = ladder(folder, root)
        result["costs"] = costs(root)
        return result


def main(arguments: list[str]) -> None:
    """Run a command of this module; without one, everything."""
    if not arguments:
        answer = measure()
    elif arguments[0] == "prepare":
        answer = prepare(Path(arguments[1]), float(arguments[2]), "decks" in arguments[3:])
    elif arguments[0] == "ours":
        answer = ours(Path(arguments[1]))
    elif arguments[0] == "million":
        answer = million()
    elif arguments[0] == "stock":
        answer = stock(Path(arguments[1]))
    else:
        answer = solver(Path(arguments[1]), arguments[2])
    print(json.dumps(answer))


if __name__ == "__main__":
    main(sys.argv[1:])
