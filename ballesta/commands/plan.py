"""Models, loads, time and memory of a check, before it is paid for."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import loads
from ballesta.design.read import read_design
from ballesta.machine.runs import solved_runs
from checks.design.data import Design, Part
from checks.ladder.levels import planned_mesh
from checks.part.loaded_part import LoadedPart
from checks.stress.kept_models import (
    SECOND_MESH,
    mesh_seconds,
    report_seconds,
    solid_seconds,
    solve_gibibytes,
    told_of_part,
)
from checks.stress.solid_mesh_level import Models, half_of


@dataclass(frozen=True)
class PlannedPart:
    """One part as it would be modelled; forces in N by interface, time in s, memory in GiB.

    halved  whether the second mesh is of half of it
    """

    part: Part
    unknowns: tuple[int, ...]
    halved: bool
    forces: dict[str, float]
    seconds: float
    gibibytes: float


def plan(design: Design) -> list[PlannedPart]:
    """Mesh the parts and solve the loads of a design, but no stresses.

    A part whose body gives way as it does is solved once, for that.
    Raises DesignError and NumericsError as a check does.
    """
    models = Models()
    design, runs = solved_runs(design, models, lambda _: None)
    planned = []
    for part in design.parts.values():
        with told_of_part(design, part):
            mesh = planned_mesh(part, models)
            part_loads = LoadedPart.of(design, part, runs, models).loads
        first = 3 * len(mesh.nodes)
        halved = half_of(part, part_loads) is not None
        second = int(SECOND_MESH * first / (2 if halved else 1))
        unknowns = (first, min(second, part.most_unknowns))
        forces = {name: float(part_loads.resultant(name).max()) for name in part_loads.wrenches}
        gibibytes = max(map(solve_gibibytes, unknowns))
        seconds = solid_seconds(*unknowns)
        planned.append(PlannedPart(part, unknowns, halved, forces, seconds, gibibytes))
    return planned


def plan_text(path: str | Path, overrides: Sequence[str] = ()) -> str:
    """Return the plan of a design file in words."""
    design = read_design(path, overrides)
    lines = [f"{design.name} ({path})", ""]
    lines += ["joints", *(f"  {line}" for line in _joints_in_words(design))]
    lines += ["cycles"]
    for cycle in (stated.run for stated in design.cycles.values()):
        phases = ", ".join(f"{p.name} (solves {p.solve})" for p in cycle.phases)
        lines.append(
            f"  {cycle.name}: at least {cycle.n_positions} positions of {cycle.coordinate.label}; "
            f"{_counted(design, cycle.name)}"
        )
        lines.append(f"    phases {phases}")
    for name, event in design.events.items():
        lines.append(f"  {name}: {event.kind} of {event.cycle}; {_counted(design, name)}")
    for run in design.measured.values():
        lines.append(
            f"  {run.name}: {len(run.loads.positions)} positions measured in {run.file}; "
            f"{_counted(design, run.name)}"
        )
    start = perf_counter()
    planned = plan(design)
    so_far = perf_counter() - start  # a check takes it, too
    if not planned:
        lines += ["no parts to check; ballesta loads solves the loads alone"]
        return "\n".join(lines)
    lines += ["parts"]
    for entry in planned:
        part = entry.part
        unknowns = " and about ".join(f"{count:,}".replace(",", " ") for count in entry.unknowns)
        cost = f"about {_seconds(entry.seconds)}"
        lines.append(
            f"  {part.name}: {part.shape}, {part.material.name}, solid on two meshes of {unknowns} "
            f"unknowns{' (of half of it)' if entry.halved else ''}, {cost}, "
            f"{entry.gibibytes:.1f} GiB"
        )
        for name, point in part.interfaces.items():
            lines.append(
                f"    {name} at {point}: up to {entry.forces[name] / 1e3:.4g} kN over the cycles"
            )
    left = sum(entry.seconds - mesh_seconds(entry.unknowns[0]) for entry in planned)
    seconds = so_far + left + report_seconds(len(planned))
    peak = max((entry.gibibytes for entry in planned), default=0.0)
    lines += [
        f"in all about {_seconds(seconds)} by --fidelity solid, by this machine's speed now, and "
        f"{peak:.1f} GiB; auto takes solids only of what cheaper models leave open. A third, finer "
        "mesh is taken where two leave the error above the accuracy asked for"
    ]
    return "\n".join(lines)


def _counted(design: Design, run: str) -> str:
    duty = design.duty.cycles.get(run)
    return f"{duty:.3g} times in its life" if duty else "not in the duty: yield, buckling"


def _seconds(seconds: float) -> str:
    """A time that is known to a factor of two."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def _joints_in_words(design: Design) -> list[str]:
    """Each joint as a line."""
    lines = [
        f"{point}: pin of {', '.join(map(_named, bodies))}" for point, bodies in design.pins.items()
    ]
    guides = []
    for name, joints in design.joints.items():
        for joint in joints:
            bodies = _named(joint.body_a), _named(joint.body_b)
            if isinstance(joint, loads.Fixed):
                lines.append(f"{name}: weld of {' and '.join(bodies)} at {joint.point}")
            elif not isinstance(joint, loads.Revolute):
                x, y = (round(one, 9) + 0.0 for one in joint.direction)  # no -0, no round-off
                between = f", from {joint.ends[0]:g} to {joint.ends[1]:g} mm" if joint.ends else ""
                if joint.point_a not in design.points:
                    guides.append(f"guide of {joint.body_b}{between}")
                    continue
                kind = "slot" if isinstance(joint, loads.Slot) else "guide"
                lines.append(
                    f"{name}: {kind} of {joint.body_b} at {joint.point_b} on {bodies[0]}, "
                    f"through {joint.point_a} along {x:.4g}, {y:.4g}{between}"
                )
    return [*lines, *guides]


def _named(body: str) -> str:
    return "the ground" if body == loads.GROUND else body
