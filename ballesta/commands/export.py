"""A part under the loads of one position, for another finite-element program: `ballesta export`."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import loads
from ballesta.design.read import read_design
from ballesta.machine.runs import solved_runs
from ballesta.run import Say, guarded, told_of_folder
from checks.design.data import Design, Part
from checks.design.errors import DesignError, no_such
from checks.part.part_loads import PartLoads, Runs, loads_on, shown_of
from checks.strength.part_strength import elastic_of
from checks.stress.kept_models import told_of_part
from checks.stress.solid_mesh_level import Level, Models, solve_level
from fem.deck import write_deck
from fem.recovery import von_mises
from geometry.mesh import FloatArray, IntArray
from geometry.progress import step
from reports.files import replacing, write_pvd, write_volume

FINENESS = 1.0  # of the exported mesh, times the part's own
WORST = "worst"
_POSITION = re.compile(
    r"(?:(?P<name>[^=]*[^=\s])\s*=\s*)?"
    r"(?P<value>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?P<words>.*)"
)


@dataclass(frozen=True)
class Exported:
    """A written deck, and ballesta's own results for it.

    file        the deck
    position    in words
    peak        MPa, largest von Mises stress that ballesta recovers at the surface
    place       where that is
    resultants  interface -> F_x, F_y in N and M_z in N mm about its centre
    unknowns    of the mesh
    """

    file: Path
    part: str
    position: str
    peak: float
    place: str
    resultants: dict[str, tuple[float, float, float]]
    unknowns: int

    def text(self) -> str:
        """The deck in words: file, position, resultants and the peak to compare with."""
        lines = [
            f"{self.part} at {self.position}: {self.file}",
            f"  {self.unknowns} unknowns; mm, N, MPa, t; stress stays free of the supports",
            f"  ballesta finds at most {self.peak:.4g} MPa (von Mises) at {self.place}",
        ]
        for name, (along, across, turn) in self.resultants.items():
            lines.append(f"  {name}: {along:.6g} N, {across:.6g} N, {turn:.6g} N mm")
        return "\n".join(lines)


def export_part(
    path: Path,
    name: str,
    at: str = WORST,
    *,
    cycle: str | None = None,
    out: Path | None = None,
    overrides: Sequence[str] = (),
    say: Say = lambda _: None,
) -> Exported:
    """Write a part with the nodal forces of one position as an input deck of CalculiX.

    at     "worst", the position of the largest von Mises stress, or a position as reports show it:
           "x = 2 mm return", "x = 2 mm", "2 mm" or "2" (the nearest one is taken, of the phase if
           one is named)
    cycle  the only cycle or run that is looked at; needed where several have such a position
    out    file; without it out/DESIGN/PART.inp

    Raises DesignError for an input that is wrong, NumericsError where the numerics gave up.
    """
    design, solved, part_loads, level = _prepared(path, name, overrides, say)
    candidates = _candidates(design, part_loads, solved, at, cycle)
    position = int(candidates[level.peaks_by_position[candidates].argmax()])
    stress = von_mises(level.history.at(position))
    point = int(stress.argmax())
    file = out or Path("out") / design.file.stem / f"{name}.inp"
    exported = Exported(
        file=file,
        part=name,
        position=f"{part_loads.labels[position]} (cycle {part_loads.cycle_names[position]})",
        peak=float(stress[point]),
        place=level.place(point),
        resultants={
            interface: (float(w[position, 0]), float(w[position, 1]), float(w[position, 5]))
            for interface, w in part_loads.wrenches.items()
        },
        unknowns=level.unknowns,
    )
    _write(exported, design, level, position)
    return exported


def export_cycle(
    path: Path,
    name: str,
    *,
    cycle: str | None = None,
    out: Path | None = None,
    overrides: Sequence[str] = (),
    say: Say = lambda _: None,
) -> list[Path]:
    """Write a part's volume mesh at every position for ParaView: a .pvd for each cycle.

    Beside each a folder of .vtu files with displacement [mm] as a vector and stress [MPa] as a
    tensor at all nodes; of a halved part its half at z >= 0. Pins press with a half cosine.

    cycle  the only one that is written; None for all
    out    folder; without it out/DESIGN

    Raises DesignError for an input that is wrong, NumericsError where the numerics gave up.
    """
    design, solved, part_loads, level = _prepared(path, name, overrides, say)
    slices = part_loads.cycles
    if cycle is not None:
        _among_cycles(design, part_loads, cycle)
        slices = {cycle: slices[cycle]}
    solutions, mesh = level.solutions, level.solutions.mesh
    stress = solutions.recovery.node_stress(solutions.displacement)
    folder = out or Path("out") / design.file.stem
    written = []
    for run, places in slices.items():
        times = solved[run].times
        say(f"{name}: writing {places.stop - places.start} positions of {run}")
        steps = []
        for k, position in enumerate(range(places.start, places.stop)):
            weights = level.coefficients[:, position]
            file = f"{name}_{run}/{k:04d}.vtu"
            fields = {
                "displacement [mm]": (solutions.displacement @ weights).reshape(-1, 3),
                "stress [MPa]": stress @ weights,  # xx, yy, zz, xy, yz, zx as ParaView has it
            }
            steps.append((float(k) if times is None else float(times[k]), file))
            with told_of_folder(folder):
                (folder / f"{name}_{run}").mkdir(parents=True, exist_ok=True)
                write_volume(folder / file, mesh.nodes, mesh.elements, fields)
        with told_of_folder(folder):
            write_pvd(folder / f"{name}_{run}.pvd", steps)
        written.append(folder / f"{name}_{run}.pvd")
    return written


def run_export(
    path: Path,
    name: str,
    at: str | None = WORST,
    *,
    cycle: str | None = None,
    out: Path | None = None,
    overrides: Sequence[str] = (),
) -> int:
    """Write a deck, or for `at` None the cycles for ParaView, and print what was written.

    Returns the exit code. 0: written; 2: an input is wrong; 3: the numerics gave up.
    """

    def say(text: str) -> None:
        step(f"{path.stem}: {text}")

    def work() -> None:
        if at is None:
            files = export_cycle(path, name, cycle=cycle, out=out, overrides=overrides, say=say)
            print(*files, sep="\n")
        else:
            deck = export_part(path, name, at, cycle=cycle, out=out, overrides=overrides, say=say)
            print(deck.text())

    return guarded(work)


def _prepared(
    path: Path, name: str, overrides: Sequence[str], say: Say
) -> tuple[Design, Runs, PartLoads, Level]:
    """A design, its runs, the loads of a part and its solution as a solid."""
    design = read_design(path, overrides)
    if name not in design.parts:
        raise DesignError(design.file, "--part", no_such("part", name, design.parts))
    part = design.parts[name]
    models = Models()
    with told_of_part(design, part):
        design, solved = solved_runs(design, models, say)
        part_loads = loads_on(design, part, solved)
        return design, solved, part_loads, _solve(part, part_loads, models, say)


def _among_cycles(design: Design, part_loads: PartLoads, cycle: str) -> None:
    if cycle not in part_loads.cycles:
        raise DesignError(
            design.file, "--cycle", no_such("cycle that loads the part", cycle, part_loads.cycles)
        )


def _solve(part: Part, part_loads: PartLoads, models: Models, say: Say) -> Level:
    say(f"{part.name}: meshing and solving")
    fineness = FINENESS * part.fineness
    solutions = models.solutions(part.geometry, fineness, elastic_of(part))
    # no fatigue is asked for: the endurance limit has no use
    return solve_level(solutions, fineness, part_loads, 1.0, part.material.ultimate_stress, {})


def _candidates(
    design: Design, part_loads: PartLoads, solved: Runs, at: str, cycle: str | None
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the positions (indices over all cycles) that `at` leaves to choose from."""
    if cycle is not None:
        _among_cycles(design, part_loads, cycle)
    names = list(part_loads.cycles) if cycle is None else [cycle]
    if at == WORST:
        slices = [part_loads.cycles[name] for name in names]
        return np.concatenate([np.arange(part.start, part.stop) for part in slices])
    ways = {name: _Shown(solved[name], *shown_of(design, name, solved[name])) for name in names}
    read = {name: found for name, way in ways.items() if (found := way.read(at)) is not None}
    if not read:
        known = " or ".join(
            way.example() + (f" (cycle {name})" if len(ways) > 1 else "")
            for name, way in ways.items()
        )
        raise DesignError(
            design.file,
            "--at",
            f"must be {WORST!r} or a position as reports show it, {known}; got {at!r}",
        )
    if len(read) > 1:
        raise DesignError(
            design.file,
            "--at",
            f"say with --cycle of which cycle {at} is a position: {', '.join(read)}",
        )
    ((name, (wanted, phase)),) = read.items()
    way = ways[name]
    among = way.of_phase(phase)
    values = way.values[among]
    low, high = float(values.min()), float(values.max())
    step = float(np.abs(np.diff(values)).max(initial=0.0))
    if not low - step <= wanted <= high + step:
        where = f"cycle {name!r}" if phase is None else f"phase {phase!r} of cycle {name!r}"
        raise DesignError(
            design.file,
            "--at",
            f"{way.shown} runs from {low:.6g} to {high:.6g} {way.unit} in {where}, got {at}",
        )
    away = np.abs(values - wanted)
    nearest = among[away <= away.min() + 1e-9 * max(abs(low), abs(high), 1.0)]
    return np.asarray(nearest + part_loads.cycles[name].start)


@dataclass(frozen=True, eq=False)
class _Shown:
    """Axis of a cycle: name, unit, and the values (n,) of its positions."""

    history: loads.CycleLoads | loads.MeasuredLoads
    shown: str
    unit: str
    values: FloatArray

    def read(self, at: str) -> tuple[float, str | None] | None:
        """Value and phase of a position such as "x = 2 mm return"; None: it is not one of these."""
        found = _POSITION.fullmatch(at.strip())
        if found is None or found["name"] not in (None, self.shown):
            return None
        value, words = float(found["value"]), found["words"].split()
        if words[:1] == [self.unit]:
            words = words[1:]
        if len(words) > 1 or not set(words) <= set(self.history.phases) or not np.isfinite(value):
            return None
        return value, words[0] if words else None

    def of_phase(self, phase: str | None) -> IntArray:
        """Indices of the positions in a phase, or of all."""
        if phase is None:
            return np.arange(len(self.values))
        return np.flatnonzero(self.history.phase_of == self.history.phases.index(phase))

    def example(self) -> str:
        """An example of a position that can be asked for, with their range and phases."""
        low, high = float(self.values.min()), float(self.values.max())
        return (
            f"such as {self.values[len(self.values) // 2] + 0.0:.4g}, in {self.unit}, from "
            f"{low + 0.0:.6g} to {high + 0.0:.6g}; phases: {', '.join(self.history.phases)}"
        )


def _write(exported: Exported, design: Design, level: Level, position: int) -> None:
    solutions = level.solutions
    title = "\n".join(
        [
            f"{design.name}: {exported.part} at {exported.position}",
            f"Design file {design.file.name}, sha256 {design.sha256}",
            f"ballesta recovers at most {exported.peak:.6g} MPa (von Mises) at {exported.place}",
            *(
                f"{name}: F_x {along:.9g} N, F_y {across:.9g} N, M_z {turn:.9g} N mm"
                for name, (along, across, turn) in exported.resultants.items()
            ),
            *(
                ["Pins press with a half cosine here, not where the contact of their fit says"]
                if design.parts[exported.part].clearances
                else ()
            ),
            *(
                f"{bore}: even pressure of the bush pressed in with {fit.interference:.4g} mm"
                for bore, fit in design.parts[exported.part].press_fits.items()
            ),
            "Nodal forces hold these, inertia and weight; they balance, the supports carry nothing",
        ]
    )
    with told_of_folder(exported.file), replacing(exported.file) as temporary:
        write_deck(
            temporary,
            solutions.mesh,
            solutions.material,
            solutions.held,
            solutions.loads @ level.coefficients[:, position],
            title,
        )
