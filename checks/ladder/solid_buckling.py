"""Buckling of a part as a solid: its lowest factor, and the surface as it buckles."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from checks.columns.stability import eigenvalue_check
from checks.derivations.buckling import solid_share
from checks.design.data import Part
from checks.ladder.levels import assumed_pressure
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check, Status, Surface
from checks.store.solutions import remembered
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Level, Models
from checks.stress.symmetry import mode_surface
from fem.buckling import BucklingMode
from fem.unit_solutions import UnitSolutions
from fem.vibration import link_vibration
from geometry.mesh import FloatArray
from geometry.sizing import SizeField

_EXAGGERATED = 0.1  # of the part's size: the largest displacement of a mode as it is drawn


@dataclass(frozen=True, eq=False)
class Buckled:
    """Buckling of a solid.

    checks  by its lowest factor, none without one
    untold  why there is none, in words; "" where nothing is to be said
    mode    the surface as it buckles
    """

    checks: Sequence[Check] = ()
    untold: str = ""
    mode: Surface | None = None


def judge_buckling(
    loaded: LoadedPart, models: Models, levels: Sequence[Level], sizes: SizeField | None
) -> Buckled:
    """Ask the whole solid for its lowest factor; of finer halves a whole one where it decides.

    Where pins press in their bores does not matter to it: pressures are the assumed ones.

    sizes  of the elements of the last mesh
    """
    finest = levels[-1]
    whole = [assumed_pressure(level) for level in levels if not level.half]
    found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found and found[0].status is Status.UNDECIDED and finest.half:
        whole.append(_whole_again(loaded, models, finest, sizes))
        found = eigenvalue_check(loaded, whole, finest.peak.position)
    if found:
        check, mode = found
        unknowns = whole[-1 if "two" in check.method else 0][0].loads.shape[0]
        derivation = solid_share(loaded, check, mode, unknowns)
        return Buckled([replace(check, derivation=derivation)], "", _mode_of(whole, mode))
    if levels[0].solutions.ties is not None:
        said = "buckling of a stack of bodies that slide on each other is not computed"
        return Buckled(untold=said)
    if loaded.part.body is None:
        return Buckled()
    return Buckled(
        untold="the solid does not buckle at the positions asked: no factor is positive before its "
        "stress is a tenth of Young's modulus"
    )


def _mode_of(
    whole: Sequence[tuple[UnitSolutions, FloatArray]], mode: BucklingMode
) -> Surface | None:
    """The surface of the mesh that a mode was found on, displaced by a part of its size."""
    for solutions, _ in whole:
        mesh = solutions.mesh
        if len(mesh.nodes) == len(mode.shape):
            moved = _EXAGGERATED * float(np.ptp(mesh.nodes, axis=0).max()) * mode.shape
            size = np.linalg.norm(mode.shape, axis=1)
            return mode_surface(mesh, solutions.recovery.points, moved, size / size.max())
    return None


def _whole_again(
    loaded: LoadedPart, models: Models, finest: Level, sizes: SizeField | None
) -> tuple[UnitSolutions, FloatArray]:
    """Solutions and coefficients of the whole part with the element sizes of a half."""
    part, loads = loaded.part, loaded.loads
    solutions = models.solutions(part.geometry, finest.fineness, elastic_of(part), sizes)
    coefficients, _ = solutions.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    return solutions, coefficients


# Natural frequencies of a part by itself, its pins standing still.

_COUNT = 2


def frequency_facts(part: Part, solutions: UnitSolutions) -> dict[str, float | str]:
    """The lowest natural frequencies of a part of one body between its pins, by name.

    On the mesh given, ends free to tilt, which is the lower bound of what forks make of them.
    Nothing for pins, for stacks and for parts with fewer than two interfaces.
    """
    if part.body is None or solutions.ties is not None or len(solutions.interfaces) < 2:
        return {}
    found = remembered(
        solutions,
        "vibration",
        (False, _COUNT),
        lambda: link_vibration(solutions, tilt_held=False, count=_COUNT),
    )
    said = [
        f"{hertz:.4g} {_plane(shape)}"
        for hertz, shape in zip(found.hertz, found.shapes, strict=True)
    ]
    name = "natural frequencies between still pins, forks that let it tilt [Hz]"
    return {name: ", ".join(said) + "; counted: none is lower"}


def _plane(shape: np.typing.NDArray[np.float64]) -> str:
    """In which plane a mode (n_nodes, 3) moves most."""
    sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, :2]).max()
    return "out of plane" if sideways else "in plane"
