"""Check a design: its cycles, its parts, its verdict."""

import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import loads
from ballesta.bushes import bush_checks
from ballesta.design import read_design
from ballesta.design_data import Cycle, Design, Part
from ballesta.errors import DesignError, NumericsError
from ballesta.levels import Models
from ballesta.machine import cycle_of, interface_distance, linkage_of, part_placing
from ballesta.part_loads import loads_on, shown_name, shown_position
from ballesta.solid import LEVELS, check_solid
from ballesta.warnings_of import claim_warnings, design_warnings
from fem.solvers import SolverError
from geometry.mesh import MeshError, TooManyElementsError
from reports.verdict import DesignResult, Gate, PartResult

Say = Callable[[str], None]

NOT_CHECKED = (
    "impact and any speed change within a cycle",
    "contact fatigue, wear and lubrication of pins and bushes",
    "welds, screws, circlips and other fasteners",
    "frame, guides, cylinder and mould",
    "lateral loads, clearances, crookedness and eccentricity of bars",
    "vibration, resonance and elastic deflection of the linkage",
    "corrosion, temperature, residual stress and manufacturing defects",
)

_LOADS_LIMIT = 1e-9


def check_file(
    path: str | Path, overrides: Sequence[str] = (), *, say: Say = lambda _: None
) -> DesignResult:
    """Read and check one design file.

    Raises DesignError for a file that cannot be checked as written, NumericsError where a solver
    gave up.
    """
    start = perf_counter()
    design = read_design(path, overrides)
    return check_design(design, say=say, reading=perf_counter() - start)


def check_design(
    design: Design, *, say: Say = lambda _: None, reading: float = 0.0
) -> DesignResult:
    """Check all parts of a design over all its cycles; raises DesignError and NumericsError."""
    models = Models()
    timings = {"read": reading}
    try:
        solve_cycles(design, {})  # what cannot move is told before anything is meshed
        masses = part_masses(design, models, say)
        start = perf_counter()
        say("loads: solving the cycles")
        solved = solve_cycles(design, masses)
        timings["loads"] = perf_counter() - start
    except loads.LinkageError as error:
        raise DesignError(design.file, "linkage", str(error)) from error
    except MeshError as error:
        raise NumericsError(
            str(error), str(design.file), "check the part's dimensions, or change mesh.fineness"
        ) from error

    start = perf_counter()
    before = sum(models.seconds.values())
    results = []
    for part in design.parts.values():
        say(f"{part.name}: solving")
        results.append(_check_part(design, part, solved, models, say))
        later = list(design.parts.values())[len(results) :]
        models.keep_only({other.geometry for other in later})
    spent = sum(models.seconds.values()) - before
    timings |= models.seconds
    timings["cycle, fatigue, buckling"] = perf_counter() - start - spent
    return DesignResult(
        name=design.name,
        file=str(design.file),
        sha256=design.sha256,
        overrides=design.overrides,
        parts=results,
        cycles=_cycle_data(design, solved, results),
        gates=_load_gates(solved),
        warnings=[*claim_warnings(design, results), *design_warnings(design, masses, solved)],
        not_checked=(*NOT_CHECKED, *_not_checked_here(design)),
        assumed=(*design.assumed, *_assumed_here(design)),
        defaults=design.defaults_used,
        inputs=_inputs(design),
        source=design.source,
        versions=versions(),
        command=" ".join(
            ["ballesta check", str(design.file), *(f"--set {o!r}" for o in design.overrides)]
        ),
        timings=timings,
    )


def _not_checked_here(design: Design) -> list[str]:
    if not design.duty.cycles:
        return ["fatigue: no cycle stands in the duty"]
    if len(design.duty.cycles) > 1:
        return ["stress ranges between one cycle of the duty and another"]
    return []


def _assumed_here(design: Design) -> list[tuple[str, str]]:
    if design.friction:
        return []
    return [
        (
            "friction",
            "none is stated: pins and guides are taken without friction; it changes the forces and "
            "bends the parts by its couples",
        )
    ]


def part_masses(
    design: Design, models: Models, say: Say = lambda _: None
) -> dict[str, tuple[float, tuple[float, float], float]]:
    """Mass, centre and inertia of every body that has a part, in the body's frame."""
    masses = {}
    for part in design.parts.values():
        if part.body is None:
            continue
        say(f"{part.name}: meshing")
        try:
            mesh = models.mesh(part.geometry, LEVELS[1] * part.fineness)
        except TooManyElementsError as error:
            raise DesignError(design.file, f"parts.{part.name}", str(error)) from error
        first, second = (mesh.interfaces[name].centre for name in part.geometry.interfaces[:2])
        built = float(np.linalg.norm(second - first))
        if abs(built - interface_distance(design, part)) > 1e-9 * built:
            raise AssertionError(f"{part.name} was built {built} mm long")
        properties = mesh.mass_properties(part.material.density)
        masses[part.body] = part_placing(design, part).to_body(properties)
    return masses


def solve_cycles(
    design: Design, masses: Mapping[str, tuple[float, tuple[float, float], float]]
) -> dict[str, loads.CycleLoads]:
    """Solve every cycle of a design; raises DesignError, LinkageError for the linkage itself."""
    linkage = linkage_of(design, masses)
    solved = {}
    for name, cycle in design.cycles.items():
        try:
            solved[name] = loads.run_cycle(linkage, cycle_of(design, cycle))
        except loads.LinkageError as error:
            raise DesignError(design.file, f"cycles.{name}", str(error)) from error
    return solved


def _check_part(
    design: Design,
    part: Part,
    solved: Mapping[str, loads.CycleLoads],
    models: Models,
    say: Say,
) -> PartResult:
    try:
        part_loads = loads_on(design, part, solved)
        result = check_solid(design, part, part_loads, models, say)
    except loads.LinkageError as error:
        raise DesignError(design.file, f"parts.{part.name}", str(error)) from error
    except TooManyElementsError as error:
        raise DesignError(design.file, f"parts.{part.name}", str(error)) from error
    except (MeshError, SolverError) as error:
        raise NumericsError(
            str(error),
            f"{design.file}: parts.{part.name}",
            "check the part's dimensions, or change mesh.fineness",
        ) from error
    bushes = bush_checks(design, part, part_loads)
    if not bushes:
        return result
    return replace(result, checks=[*result.checks, *bushes])


def _load_gates(solved: Mapping[str, loads.CycleLoads]) -> list[Gate]:
    gates = []
    for name, cycle in solved.items():
        frictionless = not cycle.linkage.friction
        gates += [
            Gate(
                f"{name}: joints closed",
                cycle.constraint_residual,
                1e-6,
                "widest gap of a joint at any position, mm",
            ),
            Gate(
                f"{name}: equilibrium of the bodies",
                max(cycle.equilibrium_residual.values()),
                _LOADS_LIMIT,
                "force and moment left on a body over the largest force",
            ),
            Gate(
                f"{name}: power balance",
                cycle.power_balance_error,
                _LOADS_LIMIT if frictionless else 1e-6,
                "power that is not accounted for, over the power turned over",
            ),
        ]
    return gates


def _cycle_data(
    design: Design, solved: Mapping[str, loads.CycleLoads], results: Sequence[PartResult]
) -> dict[str, dict[str, Any]]:
    data = {}
    for name, cycle in solved.items():
        stated: Cycle = design.cycles[name]
        shown, unit = shown_name(stated)
        links = {}
        for part in design.parts.values():
            part_loads = loads_on(design, part, {name: cycle})
            for interface in part_loads.wrenches:
                links[f"{part.name} {interface}"] = part_loads.resultant(interface).tolist()
        data[name] = {
            "shown_name": shown,
            "unit": unit,
            "position": shown_position(stated, cycle.positions).tolist(),
            "time": cycle.times.tolist(),
            "phase": [cycle.phases[k] for k in cycle.phase_of],
            "efforts": {force: values.tolist() for force, values in cycle.efforts.items()},
            "links": links,
            "peaks": {r.name: r.charts["peaks"][name] for r in results},
            "duty": design.duty.cycles.get(name, 0.0),
        }
    return data


def _inputs(design: Design) -> list[tuple[str, str]]:
    import tomllib

    from ballesta.overrides import apply_override, parse_override

    data = tomllib.loads(design.source)
    for text in design.overrides:
        apply_override(data, parse_override(text), design.file)

    def walk(value: Any, key: str) -> list[tuple[str, str]]:
        if isinstance(value, dict):
            return [pair for k, v in value.items() for pair in walk(v, f"{key}.{k}" if key else k)]
        if isinstance(value, list) and any(isinstance(v, dict) for v in value):
            return [pair for k, v in enumerate(value) for pair in walk(v, f"{key}[{k}]")]
        return [(key, str(value))]

    return [pair for pair in walk(data, "") if not pair[0].startswith("assumed")]


def versions() -> dict[str, str]:
    """Return what a result was made with."""
    names = ("ballesta", "gmsh", "scikit-fem", "scikit-sparse", "numpy", "scipy", "meshio")
    return {
        **{name: version(name) for name in names},
        "python": platform.python_version(),
        "platform": f"{sys.platform} {platform.machine()}",
    }
