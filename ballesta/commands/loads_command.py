"""The loads of a design, solved or measured, without any check of its parts: `ballesta loads`."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import loads
from ballesta.design.read import read_design
from ballesta.machine.blows import blow_gates, blows_of, transients_of
from ballesta.machine.drive_speed import (
    evenness_of,
    shown_cycle,
    shown_run,
    speed_assumptions,
    speed_gates,
    speed_warnings,
)
from ballesta.machine.measured_balance import balance_gates, measured_loads, not_measured
from ballesta.machine.solved_cycles import (
    event_assumptions,
    part_masses,
    parts_that_give,
    solve_cycles,
    try_cycles,
    with_events,
    without_unknown_contacts,
)
from ballesta.machine.validity_checks import load_gates
from ballesta.machine.warnings_of import load_warnings
from ballesta.run import Say, guarded, told_of_folder
from checks.design.data import Design
from checks.design.errors import DesignError, no_such
from checks.result.words import gate_sentence, gate_word
from checks.stress.kept_models import Models
from geometry.progress import step
from reports.files import plain, write_whole
from reports.loads_summary import LoadsResult, loads_csv
from reports.loads_text import loads_text

Masses = Mapping[str, tuple[float, tuple[float, float], float]]

DRIVE_SPEED = "changes of speed that the drive itself would suffer"
ABSENT = (
    "impact, where something is touched or a clearance closes",
    "clearances, and what they let the joints do",
    DRIVE_SPEED,
    "vibration; bodies are rigid but for a stated elasticity in front of a contact",
    "forces out of the plane",
)
ABSENT_MEASURED = ("what the measurement did not see", "forces out of the plane")


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta loads`; csv is a file or "-", no cycles (or runs) for all."""

    csv: str | None = None
    plot: bool = False
    cycles: tuple[str, ...] = ()
    out: Path = Path("out")
    as_json: bool = False


def loads_of_file(
    path: Path,
    overrides: Sequence[str] = (),
    cycles: Sequence[str] = (),
    *,
    say: Say = lambda _: None,
) -> LoadsResult:
    """Read a design, solve its cycles and balance its measured runs, or those that are named.

    Raises DesignError for a file that cannot be solved as written or loads that do not balance,
    NumericsError where a mesh, needed for the mass of a part or for how it gives way, cannot be
    made or solved.
    """
    design = _with_cycles(read_design(path, overrides), cycles)
    try:
        # what cannot move or does not balance is told before anything is meshed
        try_cycles(without_unknown_contacts(design))
        measured_loads(design, {})
        models = Models()
        masses = _masses(design, models, say)
        compliances = _compliances(design, models, say)
        design = with_events(design, masses, compliances)
        solved = solve_cycles(design, masses, compliances)
        transients = transients_of(design, solved, every=False)
        struck, blows = transients.cycles, transients.blows
        measured = measured_loads(design, masses)
        evenness = evenness_of(design, solved)
        gates = [
            *load_gates(design, struck),
            *blow_gates(blows),
            *speed_gates(evenness),
            *balance_gates(design, measured),
        ]
        warnings = [*speed_warnings(evenness), *load_warnings(design, masses, solved)]
    except loads.LinkageError as error:
        raise DesignError(design.file, "linkage", str(error)) from error
    return LoadsResult(
        name=design.name,
        file=str(design.file),
        sha256=design.sha256,
        overrides=design.overrides,
        cycles=[
            shown_cycle(design, struck[name], blows_of(design, cycle, blows.get(name)))
            for name, cycle in solved.items()
        ],
        gates=gates,
        warnings=warnings,
        runs=[shown_run(design, run) for run in measured.values()],
        absent=(*_absent(design, solved), *not_measured(design)),
        assumed=[
            *(pair for pair in design.assumed if not pair[0].startswith("parts.")),
            *speed_assumptions(evenness),
            *event_assumptions(design),
        ],
        command=" ".join(
            [
                "ballesta loads",
                str(design.file),
                *(f"--cycle {name}" for name in cycles),
                "--plot",
                *(f"--set {override!r}" for override in design.overrides),
            ]
        ),
    )


def _absent(design: Design, solved: Mapping[str, loads.CycleLoads]) -> tuple[str, ...]:
    """Effects that the loads leave out, in words."""
    if not solved:
        return ABSENT_MEASURED
    return tuple(text for text in ABSENT if design.drive.motor is None or text != DRIVE_SPEED)


def run_loads(path: Path, wanted: Wanted, overrides: Sequence[str] = ()) -> int:
    """Print the loads of a design and write the files that are wanted; returns the exit code.

    0: solved, whatever the gates say; 2: an input is wrong; 3: the numerics gave up.
    """

    def work() -> None:
        if wanted.as_json and wanted.csv == "-":
            raise DesignError(path, "--csv", "both the table and --json want standard output")

        def say(text: str) -> None:
            step(f"{path.stem}: {text}")

        result = loads_of_file(path, overrides, wanted.cycles, say=say)
        written = _write(result, wanted)
        if wanted.as_json:
            report = plain(result.to_dict() | {"files": [str(file) for file in written]})
            print(json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False))
        elif wanted.csv == "-":
            for gate in result.broken:
                say(f"{gate_word(gate)}: {gate_sentence(gate)}")
            print(loads_csv(result.cycles, result.runs), end="")
        else:
            print(loads_text(result, None, written), end="")

    return guarded(work)


def _write(result: LoadsResult, wanted: Wanted) -> list[Path]:
    written = []
    if wanted.csv is not None and wanted.csv != "-":
        table = Path(wanted.csv)
        with told_of_folder(table, "--csv"):
            write_whole(table, loads_csv(result.cycles, result.runs).encode())
        written.append(table)
    if wanted.plot:
        from reports.loads_page import write_loads_page

        page = wanted.out / Path(result.file).stem / "loads.html"
        with told_of_folder(wanted.out):
            write_loads_page(result, page)
        written.append(page)
    return written


def _with_cycles(design: Design, names: Sequence[str]) -> Design:
    """Return the design with the named cycles and measured runs only, or all of them.

    An event brings its cycle with it.
    """
    known = (*design.cycles, *design.events, *design.measured)
    for name in names:
        if name not in known:
            raise DesignError(design.file, "cycles", no_such("cycle", name, known))
    if not known:
        raise DesignError(design.file, "cycles", "the design has no cycle to solve")
    if not names:
        return design
    events = {name: event for name, event in design.events.items() if name in names}
    bases = {event.cycle for event in events.values()}
    return replace(
        design,
        cycles={
            name: cycle for name, cycle in design.cycles.items() if name in names or name in bases
        },
        events=events,
        measured={name: run for name, run in design.measured.items() if name in names},
    )


def _masses(design: Design, models: Models, say: Say) -> Masses:
    """Mass properties of the bodies that take them from their parts."""
    seen = {name for run in design.measured.values() for name in run.loads.bodies}
    needed = [
        body
        for body, stated in design.stated_masses.items()
        if (design.cycles or body in seen) and None in stated
    ]
    if not needed:
        return {}
    say(f"the mass of {', '.join(needed)} comes from its part")
    return part_masses(design, models)


def _compliances(
    design: Design, models: Models, say: Say
) -> Mapping[str, loads.MatrixCompliance] | None:
    """Compliances of the bodies that give way as their parts do, for which these are solved."""
    if not any(parts_that_give(design)):
        return None
    from ballesta.machine.elastic_parts import compliances_of

    return compliances_of(design, models, say)
