"""Buckling of a part at its worst position: column formulas in both planes, and eigenvalues."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from checks.columns.column_limits import ColumnCase, Plane, cases_of
from checks.columns.column_moments import axial_compression as axial_compression
from checks.design.data import Part
from checks.part.derived import Kind
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, first_largest
from checks.result.verdict import Check, Status
from checks.store.solutions import remembered
from checks.strength.sampling import beside, with_sampling
from fem.buckling import Buckling, BucklingMode, buckling_at, mesh_bar, shares_of, worst_buckling
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

ELASTIC = Kind(
    name="buckling",
    quantity="elastic load share",
    demand="load over the lowest elastic buckling load of the part, by whatever model",
    limit="1",
    require="buckling",
    source="[buckling](../theory/buckling.md)",
)
ELASTIC_SHARE = ELASTIC.quantity
_SAME = 1e-9  # of a safety
_ROUND_OFF = 1e-12  # of the largest force: no compression
FAR = 3.0  # times the required safety: beyond it forks' fixity is not computed


@dataclass(frozen=True)
class JudgedColumns:
    """A plane's columns under one force.

    found     (case, axial stress, safety), the least safety first
    held      what has the least safety, with the stiffest ends
    stiffest  the least safety of all with the stiffest ends
    """

    found: tuple[tuple[ColumnCase, float, float], ...]
    held: ColumnCase
    stiffest: float

    @property
    def deciding(self) -> tuple[ColumnCase, float, float]:
        """The case with the least safety."""
        return self.found[0]

    @property
    def between(self) -> bool:
        """True if stiffer ends would make a difference."""
        return self.stiffest > self.deciding[2] * (1 + _SAME)

    @property
    def told(self) -> str:
        """Safeties with the stiffest ends, and of the other sections."""
        _, *others = self.found
        told = [f"safety with the stiffest ends {self.stiffest:.3g}"] if self.between else []
        if others:
            told.append(
                "other sections, safety: "
                + "; ".join(
                    f"{c.section.name}{'' if c.whole else ' by itself'}: {value:.2f} "
                    f"({c.law}, slenderness {c.strength.slenderness:.1f})"
                    for c, _, value in others
                )
            )
        return "; ".join(told)


def judged_columns(part: Part, plane: Plane, force: float) -> JudgedColumns:
    """Judge every section of a part as a column in a plane under a compression, N."""
    found = []
    for case in cases_of(part, plane):
        stress = force / case.section.area
        found.append((case, stress, case.limit / stress))
    held = cases_of(part, plane, stiffest=True)
    order = sorted(range(len(found)), key=lambda k: found[k][2])
    stiffest = min(case.limit * case.section.area / force for case in held)
    return JudgedColumns(tuple(found[k] for k in order), held[order[0]], stiffest)


def worst_compression(part: Part, loads: PartLoads) -> int | None:
    """Position of the largest compression; None without sections or compression.

    A column's limits do not depend on the position, so that it is the worst of all of them.
    """
    if not part.geometry.sections:
        return None
    force = axial_compression(part, loads)
    (worst,) = first_largest(force)
    return worst if force[worst] > _ROUND_OFF * loads.largest_force else None


def eigenvalue_check(
    loaded: LoadedPart, levels: Sequence[tuple[UnitSolutions, FloatArray]], peak: int
) -> tuple[Check, BucklingMode] | None:
    """Return the lowest buckling factor of the solid over all positions, ends free to tilt.

    levels  solutions and coefficients (n_basis, n) of the meshes, coarse to fine
    peak    position of the largest stress, asked besides the largest compression's

    Any part of one body between two interfaces is asked, with sections or without: a plate that is
    bent may buckle sideways while it is pulled. Forks that hold the ends against tilting are the
    model band. None for pins and stacks, and where nothing buckles.
    """
    part, loads = loaded.part, loaded.loads
    twist = part.tilt_held_at
    solutions, coefficients = levels[0]
    if part.body is None or solutions.ties is not None or len(solutions.interfaces) < 2:
        return None
    starts = [*first_largest(axial_compression(part, loads)), peak]
    found = remembered(
        solutions,
        "buckling",
        (coefficients, starts, twist),
        lambda: worst_buckling(
            solutions, coefficients, starts, tilt_held=False, twist_held_at=twist
        ),
    )
    if found is None:
        return None
    worst, buckling = found
    modes = buckling.modes
    stiff: float | None = None
    forks = "not asked"
    if modes[0].factor < FAR * loaded.required.buckling:
        held = _buckling_at(solutions, coefficients[:, worst], twist, tilt_held=True).modes
        stiff = held[0].factor if held else np.inf
        forks = f"{stiff:.3g}" if held else "none"
    turned = ""
    if buckling.reversed is not None and buckling.reversed < modes[0].factor:
        turned = f"; with all loads turned round it would buckle at {buckling.reversed:.3g} of them"
    stated = part.column.fork_stiffness is not None
    unused = " (the stated fork_stiffness is the column formulas' only)" if stated else ""
    proof, missed = _proof(buckling)
    by_plane = {mode.plane: mode.factor for mode in reversed(modes)}
    planes = ", ".join(f"{factor:.3g} {plane}" for plane, factor in by_plane.items())

    def checked(mode: BucklingMode, bar: float, meshes: str) -> Check:
        below = 0.0 if stiff is None else max(0.0, 1 - modes[0].factor / stiff) / mode.factor
        below *= max(0.0, 1 - bar)  # the stiffer forks' factor is as uncertain
        check = Check(
            part=part.name,
            kind=ELASTIC.name,
            quantity=ELASTIC.quantity,
            value=1 / mode.factor,
            unit="",
            numerical=max(bar / mode.factor, missed),
            model=0.0,
            model_below=below,
            limit=1.0,
            required=ELASTIC.safety(loaded.required),
            cycle=loads.cycle_names[worst],
            position=loads.labels[worst],
            place=f"{mode.plane} mode",
            method=f"solid ({meshes})",
            basis="linear eigenvalue, both ends held sideways: knows neither yield nor crookedness",
            note=f"lowest factors {planes}, {proof} at this position, the worst of all that was "
            f"found; fixity: with forks that hold the ends against tilting {forks}{unused}{turned}",
        )
        return with_sampling(check, rise * check.value)

    fields = np.stack([mode.shape.ravel() for mode in modes], axis=1)
    places = beside(loads, worst)
    rise = 0.0  # of the share, over it
    if places is not None:
        between = np.column_stack([coefficients[:, worst], places.of(coefficients.T).T])
        share, *others = shares_of(solutions, between, fields)
        rise = max(0.0, max(others) / share - 1)

    check = checked(modes[0], _bar_of(solutions, coefficients[:, worst], twist, modes), "one mesh")
    if check.status is Status.UNDECIDED and len(levels) > 1:
        solutions, coefficients = levels[-1]
        again = _buckling_at(solutions, coefficients[:, worst], twist, tilt_held=False)
        if again.modes:
            proof, missed = _proof(again)
            moved = abs(again.modes[0].factor / modes[0].factor - 1)
            bar = max(moved, _bar_of(solutions, coefficients[:, worst], twist, again.modes))
            return checked(again.modes[0], bar, "two meshes"), again.modes[0]
    return check, modes[0]


def _buckling_at(
    solutions: UnitSolutions, state: FloatArray, twist_held_at: str, *, tilt_held: bool
) -> Buckling:
    """Modes of one position, from the store of the solutions if they have one."""
    return remembered(
        solutions,
        "buckling_at",
        (state, twist_held_at, tilt_held),
        lambda: buckling_at(solutions, state, tilt_held=tilt_held, twist_held_at=twist_held_at),
    )


def _bar_of(
    solutions: UnitSolutions, state: FloatArray, twist_held_at: str, modes: Sequence[BucklingMode]
) -> float:
    """Error of the share by the mesh, over it, from the store of the solutions if they have it."""
    return remembered(
        solutions,
        "buckling_bar",
        (state, twist_held_at),
        lambda: mesh_bar(solutions, state, modes, twist_held_at=twist_held_at),
    )


def _proof(buckling: Buckling) -> tuple[str, float]:
    """Proof of the lowest factor by a count, in words, and the share that it leaves open above it.

    A mode that the count does not exclude may be as low as what it does; without a count, as low as
    any: then the share is infinite.
    """
    lowest = buckling.modes[0].factor
    if buckling.proven >= lowest:
        return "counted: none is lower", 0.0
    if buckling.proven > 0:
        left = 1 / buckling.proven - 1 / lowest
        return f"counted: none is below {buckling.proven:.3g}, another may be between", left
    return "not proved to be the lowest", inf
