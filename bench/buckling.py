"""Four buckling modes of a lug bar, with the proof that none was skipped, beside CalculiX.

`python -m bench.buckling` prints everything as a line of JSON; prepare and ours are its children.
CalculiX solves *BUCKLE on the same mesh and load, held at the six displacements of the stress
analysis. For the comparison of the factors ballesta solves that problem too; what is timed is its
own: the ends of a link, on the factor of the stress analysis, which CalculiX has no part in. Both
have one thread: with several, the many short products between the solves wait for each other when
anything else runs, and ratios would say more about that than about the method.
"""

import json
import pickle
import re
import shutil
import statistics
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

from bench import solid
from bench.solid import calculix, child, elastic, python

FINENESS = 1.04  # 150 000 unknowns
THREADS = "1"
RUNS = 3
MODES = 4


def loaded(folder: Path, solutions: Any) -> Any:
    """Coefficients (n_basis,) of the unit loads where the bar is compressed most."""
    import numpy as np

    wrenches, accelerations = pickle.loads((folder / "loads.pickle").read_bytes())
    coefficients, _ = solutions.coefficients(wrenches, accelerations)
    first = next(iter(wrenches.values()))
    return coefficients[:, int(np.argmax(first[:, 0]))]


def deck(folder: Path) -> dict[str, Any]:
    """Write CalculiX's deck, and the factors of its problem by ballesta."""
    from bench.fixed_solid import fixed_solid
    from fem.buckling import solid_buckling
    from fem.deck import write_deck
    from fem.unit_solutions import solve_unit_loads

    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    solutions = solve_unit_loads(mesh, elastic())
    chosen = loaded(folder, solutions)
    plain = folder / "static.inp"
    write_deck(plain, mesh, solutions.material, solutions.held, solutions.loads @ chosen, "bar")
    text = plain.read_text(encoding="ascii")
    text = text.replace("*STEP\n*STATIC\n", f"*STEP\n*BUCKLE\n{MODES}, 1e-4\n")
    text = re.sub(r"\*NODE FILE\n.*?(?=\*END STEP)", "", text, flags=re.DOTALL)
    (folder / "buckle.inp").write_text(text, encoding="ascii")
    displacement = (solutions.displacement @ chosen)[:, None]
    stress = solutions.recovery.quadrature_stress(displacement, slice(None))[..., 0]
    found = solid_buckling(
        fixed_solid(mesh, elastic(), solutions.held), stress, count=MODES, prove=True
    )
    return {"factors": [mode.factor for mode in found.modes]}


def ours(folder: Path) -> dict[str, Any]:
    """Factorisation and unit loads, then the modes without and with the proof, seconds."""
    from fem.buckling import part_buckling
    from fem.threads import keep_freed_memory
    from fem.unit_solutions import solve_unit_loads

    keep_freed_memory()  # as `ballesta check` does
    mesh = pickle.loads((folder / "mesh.pickle").read_bytes())
    start = perf_counter()
    solutions = solve_unit_loads(mesh, elastic())
    seconds = {"unit": perf_counter() - start}
    chosen = loaded(folder, solutions)
    factors = []
    for name, prove in (("modes", False), ("proven", True)):
        start = perf_counter()
        found = part_buckling(solutions, chosen, tilt_held=False, count=MODES, prove=prove)
        seconds[name] = perf_counter() - start
        factors = [mode.factor for mode in found.modes]
    return {**seconds, "unknowns": 3 * len(mesh.nodes), "factors": factors, "proof": found.proven}


def their_factors(folder: Path) -> list[float]:
    """Buckling factors that CalculiX wrote, by size."""
    text = (folder / "buckle.dat").read_text(encoding="ascii")
    table = text.split("B U C K L I N G", 1)[1]
    return sorted(float(m[1]) for m in re.finditer(r"^\s+\d+\s+([-+.\dE]+)\s*$", table, re.M))


def measure() -> dict[str, Any]:
    """Medians of runs in turns; without ccx what concerns ballesta alone."""
    solid.THREADS = THREADS  # of the children
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        python("prepare", str(folder), str(FINENESS))
        peer = shutil.which("ccx") is not None
        held = own("deck", folder)["factors"] if peer else []
        runs = []
        for _ in range(RUNS):
            run = own("ours", folder)
            run["modes over unit"] = run["modes"] / run["unit"]
            run["proven over unit"] = run["proven"] / run["unit"]
            if peer:
                run["calculix"], run["calculix memory"] = calculix(folder / "buckle.inp")
                run["over calculix"] = (run["unit"] + run["proven"]) / run["calculix"]
            runs.append(run)
        result = {
            key: statistics.median(run[key] for run in runs)
            for key, value in runs[0].items()
            if isinstance(value, float)
        }
        result |= {key: runs[0][key] for key in ("unknowns", "factors")}
        if peer:
            theirs = their_factors(folder)
            positive = [factor for factor in theirs if factor > 0]
            result["apart"] = max(
                abs(a / b - 1) for a, b in zip(held, positive[:MODES], strict=False)
            )
            result["compared"] = min(len(held), len(positive))
            result["calculix factors"], result["held factors"] = theirs, held
        return result


def own(command: str, folder: Path) -> dict[str, Any]:
    """The last line's JSON of one of this module's commands."""
    _, _, text = child(sys.executable, "-m", "bench.buckling", command, str(folder))
    return dict(json.loads(text.splitlines()[-1]))


def main(arguments: list[str]) -> None:
    """Run a command of this module; without one, everything."""
    if not arguments:
        answer = measure()
    elif arguments[0] == "deck":
        answer = deck(Path(arguments[1]))
    else:
        answer = ours(Path(arguments[1]))
    print(json.dumps(answer))


if __name__ == "__main__":
    main(sys.argv[1:])
