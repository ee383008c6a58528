"""Puts the cycles and the duty of a design together."""

from ballesta.design_data import Coordinate, Cycle, Duty, Phase, Shown, Stop
from ballesta.design_model import CycleEntry, DesignFile
from ballesta.errors import Problems
from ballesta.names import listed, no_such
from ballesta.units import DIMENSIONS, Measured


def cycles_of(file: DesignFile, problems: Problems) -> dict[str, Cycle]:
    """Return the cycles whose entries are in order."""
    cycles = {}
    for name, entry in file.cycles.items():
        cycle = _cycle(name, entry, file, problems)
        if cycle is not None:
            cycles[name] = cycle
    return cycles


def duty_of(file: DesignFile, problems: Problems) -> Duty:
    """Return the duty; a cycle that does not exist is a problem."""
    for name in file.duty.cycles:
        if name not in file.cycles:
            problems.add(f"duty.cycles.{name}", no_such("cycle", name, file.cycles))
    return Duty(dict(file.duty.cycles), file.duty.rate)


def _cycle(name: str, entry: CycleEntry, file: DesignFile, problems: Problems) -> Cycle | None:
    key = f"cycles.{name}"
    swept = _coordinate(f"{key}.coordinate", entry.coordinate, file, problems)
    pace = _coordinate(f"{key}.pace.coordinate", entry.pace.coordinate, file, problems)
    if swept is None or pace is None:
        return None

    def along(where: str, measured: Measured, dimension: str = swept.dimension) -> float:
        if measured.dimension != dimension:
            kinds = DIMENSIONS[dimension], DIMENSIONS[measured.dimension]
            problems.add(
                f"{key}.{where}",
                f'must be {kinds[0].title} such as "{kinds[0].example}", got {kinds[1].title}',
            )
        return measured.value

    speed_dimension = "angular speed" if pace.dimension == "angle" else "speed"
    start = along("start", entry.start)
    return Cycle(
        name=name,
        coordinate=swept,
        start=start,
        pace=pace,
        pace_speed=along("pace.speed", entry.pace.speed, speed_dimension),
        positions=entry.positions,
        shown=None
        if entry.shown is None
        else Shown(entry.shown.name, along("shown.zero", entry.shown.zero), entry.shown.sign),
        stop=None
        if entry.stop is None
        else Stop(entry.stop.basis, along("stop.tolerance", entry.stop.tolerance)),
        phases=_phases(
            key,
            entry,
            [along(f"phases[{i}].to", phase.to) for i, phase in enumerate(entry.phases)],
            start,
            file,
            problems,
        ),
    )


def _phases(
    key: str,
    entry: CycleEntry,
    ends: list[float],
    start: float,
    file: DesignFile,
    problems: Problems,
) -> tuple[Phase, ...]:
    phases: list[Phase] = []
    for index, (phase, end) in enumerate(zip(entry.phases, ends, strict=True)):
        here = f"{key}.phases[{index}]"
        if end == (ends[index - 1] if index else start):
            problems.add(f"{here}.to", f"phase {phase.name!r} ends where it starts")
        if phase.name in [earlier.name for earlier in phases]:
            problems.add(f"{here}.name", f"{phase.name!r} is there twice")
        for force in phase.forces:
            if force not in file.forces:
                problems.add(f"{here}.forces.{force}", no_such("force", force, file.forces))
        if phase.solve not in file.forces:
            problems.add(f"{here}.solve", no_such("force", phase.solve, file.forces))
        elif phase.solve in phase.forces:
            problems.add(
                f"{here}.solve",
                f"phase {phase.name!r} both gives and solves {phase.solve}; it can only do one",
            )
        for force in file.forces:
            if force not in phase.forces and force != phase.solve:
                problems.add(
                    f"{here}.forces",
                    f"phase {phase.name!r} leaves {force} neither given nor solved; "
                    f'state it, {force} = "0 N" when it rests',
                )
        phases.append(Phase(phase.name, end, dict(phase.forces), phase.solve))
    return tuple(phases)


def _coordinate(key: str, text: str, file: DesignFile, problems: Problems) -> Coordinate | None:
    name, _, what = text.rpartition(".")
    pins = dict.fromkeys(pin for body in file.bodies.values() for pin in body.pins)
    pulling = [force for force, entry in file.forces.items() if entry.between is not None]
    kinds = {
        "x": ("point on a body", list(pins)),
        "y": ("point on a body", list(pins)),
        "angle": ("body", list(file.bodies)),
        "length": ("force between two points", pulling),
    }
    if what not in kinds or not name:
        problems.add(
            key,
            "must be <point>.x, <point>.y, <body>.angle or <force>.length, "
            f'got "{text}"; points {listed(pins)}; bodies {listed(file.bodies)}; '
            f"forces {listed(pulling)}",
        )
        return None
    kind, known = kinds[what]
    if name not in known:
        problems.add(key, no_such(kind, name, known))
        return None
    return Coordinate(name, what)
