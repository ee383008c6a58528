"""Value and error bar against seconds for every rung of every part: `ballesta ladder`."""

import json
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from time import perf_counter
from typing import TypeVar

from ballesta.design.read import read_design
from ballesta.machine.runs import solved_runs
from ballesta.run import Say, guarded, told_of_folder
from checks.design.data import Design, Part
from checks.design.effort import AUTO, FORMULA, SOLID
from checks.design.errors import DesignError, no_such
from checks.ladder.climb import Climb, answered, climb_cheap, start_climb
from checks.ladder.leaf_checks import Solved
from checks.ladder.part_ladder import told_of_part
from checks.ladder.result import solid_result
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check, RungTried
from checks.stress.solid_mesh_level import Models
from fem.solvers import SolverError
from fem.threads import keep_freed_memory
from fem.unit_solutions import Elastic, UnitSolutions
from geometry.body import Buildable
from geometry.mesh import Mesh, MeshError
from geometry.progress import step
from geometry.sizing import SizeField
from reports.files import plain, write_whole
from reports.ladder_page import ladder_html, ladder_text
from reports.ladder_summary import LadderPart, LadderResult

# Of the part's mesh.fineness. Quadratic elements: stresses converge with the square of their size,
# so a mesh of half the fineness is asked for four times the numerical error.
SOLIDS = (0.5, 0.7, 1.0)


T = TypeVar("T")


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta ladder`; no part stands for all of them."""

    part: str | None = None
    out: Path = Path("out")
    as_json: bool = False


class PricedModels(Models):
    """Models that remember what each mesh and solution took.

    spared  s, what answers from memory would have taken: equal parts and rungs that share a mesh
            are still told apart by what each takes by itself
    """

    def __init__(self) -> None:
        super().__init__()
        self.spared = 0.0
        self._prices: dict[Hashable, float] = {}

    def mesh(
        self,
        shape: Buildable,
        fineness: float,
        sizes: SizeField | None = None,
        most_unknowns: float = inf,
    ) -> Mesh:
        """Return the mesh of a shape, as any models do."""
        key = (shape, fineness, sizes)
        return self._priced(
            key,
            key in self._meshes,
            lambda: Models.mesh(self, shape, fineness, sizes, most_unknowns),
        )

    def solutions(
        self, shape: Buildable, fineness: float, material: Elastic, sizes: SizeField | None = None
    ) -> UnitSolutions:
        """Return the solved unit loads of a shape, as any models do."""
        key = (shape, fineness, sizes, material)
        return self._priced(
            key,
            key in self._solutions,
            lambda: Models.solutions(self, shape, fineness, material, sizes),
        )

    def _priced(self, key: Hashable, known: bool, work: Callable[[], T]) -> T:
        start, before = perf_counter(), self.spared
        found = work()
        if known:
            self.spared += self._prices[key]
        else:
            self._prices[key] = perf_counter() - start + self.spared - before
        return found


def ladder_of_file(
    path: Path, overrides: Sequence[str] = (), part: str | None = None, *, say: Say = lambda _: None
) -> LadderResult:
    """Read a design and try every rung on every part, or on the one that is named.

    Raises DesignError for a file that cannot be checked as written, NumericsError where a solver
    gave up.
    """
    design = read_design(path, overrides)
    parts = _parts(design, part)
    keep_freed_memory()
    models = PricedModels()
    design, solved = solved_runs(design, models, say)
    found = []
    for done, each in enumerate(parts):
        with told_of_part(design, each):
            found.append(_ladder(design, each, solved, models, say))
        models.keep_only({other.geometry for other in parts[done + 1 :]})
    return LadderResult(
        name=design.name,
        file=str(design.file),
        sha256=design.sha256,
        overrides=design.overrides,
        parts=found,
        solids=_solids_in_words(design),
        command=" ".join(
            [
                "ballesta ladder",
                str(design.file),
                *([] if part is None else [f"--part {part}"]),
                *(f"--set {override!r}" for override in design.overrides),
            ]
        ),
    )


def run_ladder(path: Path, wanted: Wanted, overrides: Sequence[str] = ()) -> int:
    """Print the ladder of a design and write its page; returns the exit code.

    0: told, whatever the checks say; 2: an input is wrong; 3: the numerics gave up.
    """

    def say(text: str) -> None:
        step(f"{path.stem}: {text}")

    def work() -> None:
        result = ladder_of_file(path, overrides, wanted.part, say=say)
        page = wanted.out / Path(result.file).stem / "ladder.html"
        with told_of_folder(wanted.out):
            write_whole(page, ladder_html(result).encode())
        if wanted.as_json:
            report = plain(result.to_dict() | {"files": [str(page)]})
            print(json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False))
        else:
            print(ladder_text(result, None, [page]), end="")

    return guarded(work)


def _parts(design: Design, name: str | None) -> list[Part]:
    if not design.parts:
        raise DesignError(design.file, "parts", "there are none to check")
    if name is None:
        return list(design.parts.values())
    if name not in design.parts:
        raise DesignError(design.file, "parts", no_such("part", name, design.parts))
    return [design.parts[name]]


def _ladder(
    design: Design, part: Part, solved: Solved, models: PricedModels, say: Say
) -> LadderPart:
    loaded = LoadedPart.of(design, part, solved, models)
    auto = start_climb(loaded)
    tried, chosen = _auto(auto, models, say)
    alone = start_climb(loaded)
    climb_cheap(alone, FORMULA, say)
    rungs = [alone.tried[-1], *(_solid(loaded, models, say, share) for share in SOLIDS)]
    return LadderPart(part.name, part.shape, part.material.name, auto.asked, rungs, tried, chosen)


def _auto(climb: Climb, models: PricedModels, say: Say) -> tuple[list[RungTried], list[Check]]:
    """The rungs that `auto` tries, and the checks of models that it reports."""
    if not climb_cheap(climb, AUTO, say):
        return climb.tried, answered(climb)
    say(f"{climb.part.name}: {SOLID}, as auto asks for")
    spared = models.spared
    result = solid_result(climb, models, say, everything=False)
    *before, solid = result.rungs
    solid = replace(solid, seconds=solid.seconds + models.spared - spared)
    decided = [check for check in result.checks if _by_a_model(check, climb)]
    return [*before, solid], decided


def _by_a_model(check: Check, climb: Climb) -> bool:
    """True if a rung's own model decides a check, not a formula that stands on every rung."""
    own = [estimate.check for estimate in climb.best.values()]
    return check.method.startswith(SOLID) or any(check is other for other in own)


def _solid(loaded: LoadedPart, models: PricedModels, say: Say, share: float) -> RungTried:
    """The solid of a part with a share of its fineness; one that is coarser may be refused."""
    design, part = loaded.design, loaded.part
    fineness, accuracy = _settings(design, part, share)
    name = f"{SOLID} {fineness:g}"
    say(f"{part.name}: {name}")
    coarser = replace(part, fineness=fineness)
    climb = start_climb(replace(loaded, design=replace(design, accuracy=accuracy), part=coarser))
    spared = models.spared
    try:
        tried = solid_result(climb, models, say, everything=True).rungs[-1]
    except (MeshError, SolverError) as error:
        if share == 1.0:
            raise
        return RungTried(name, 0.0, 0, [], f"too coarse for this part: {error}")
    return replace(tried, rung=name, seconds=tried.seconds + models.spared - spared)


def _settings(design: Design, part: Part, share: float) -> tuple[float, float]:
    """Fineness and accuracy of a solid."""
    return share * part.fineness, design.accuracy / share**2


def _solids_in_words(design: Design) -> str:
    wanted = ", ".join(
        f"{share:g} times the part's mesh.fineness to {100 * design.accuracy / share**2:.3g} %"
        for share in SOLIDS
    )
    return (
        "solid F is `ballesta check --fidelity solid` with mesh.fineness F, on two meshes and on "
        f"more until the numerical error is that asked for: {wanted}"
    )
