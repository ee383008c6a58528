"""The rung `beam`: buckling of a part as a Timoshenko frame of its profile.

Its stress is the rung `formula`'s: over all kinds of checks that lies nearer to solids than a
frame's, which settled 19 of 512 recorded verdicts on stress, all as the solid does.
"""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import scipy

from checks.design.data import Part
from checks.models import formula
from checks.models.beam_solution import BeamSolution, solve_frame
from checks.models.shapes import shape_model
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Given, Item, Step
from checks.stress.part_model import ElasticLoad, RungModel
from fem.frame_lateral import geometric_forms
from geometry.mesh import FloatArray


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula, its buckling by its frame; None where there is none of both."""
    solved = solve_frame(part)
    base = None if solved is None else formula.model_of(part, loads)
    if solved is None or base is None:
        return None
    coefficients = solved.coefficients(loads)
    return replace(
        base,
        rung="beam",
        residual=max(base.residual, solved.residual(loads, coefficients)),
        buckling=buckling_of(part, loads, solved, coefficients),
        unknowns=6 * len(solved.frame.nodes),
    )


# At which position a part's frame buckles first, its pins as hinges that let it tilt.
#
# As fem/worst_position.py finds it for solids: modes of a few states judge all positions
# (Rayleigh and Ritz, never above the truth), the position that looks worst is solved, its modes
# join.

_MOST = 6  # positions that are solved
_PATTERNS = 4  # load states whose modes are taken to begin with
_SMALL = 0.1  # of the largest: what is left of all states counts as known
_CLOSE = 0.999  # of the lowest factor: an estimate above that asks for no further position
_TIE = 1e-6  # factors that are closer are equal: the first position is named
_COUNT = 3  # modes of each state
_SOFTEST = 40  # motions of the frame that modes are made of
_NONE = 1e-9  # of the largest factor's inverse: below it, round-off
_BLOCK = 4096  # positions at a time


def buckling_of(
    part: Part, loads: PartLoads, solved: BeamSolution, coefficients: FloatArray
) -> ElasticLoad:
    """Largest share of the elastic buckling load over all positions."""
    search = _Search(solved, coefficients)
    found = search.worst()
    told = (
        f"the frame's factor is the eigenvalue of a frame of {6 * len(solved.frame.nodes)} "
        "unknowns, which no formula gives"
    )
    plane, share, position = "nothing presses or bends it", 0.0, 0
    if found is not None:
        position, factor, shape = found
        share = 1 / factor
        plane = f"{search.plane(shape)}: eigenvalue of the frame, its pins let it tilt"
    model = shape_model(part.geometry)
    walls = np.zeros(1) if model is None else model.walls(part, part.geometry, loads)
    if walls.max() > share:
        (position,) = first_largest(walls)
        wall = float(walls[position])
        said = "walls, at the end that is pressed"
        return ElasticLoad(wall, position, said, partial(_items, 0.0, wall), told)
    return ElasticLoad(share, position, plane, partial(_items, share, 0.0), told)


def _items(share: float, walls: float) -> list[Item]:
    """How the share comes about: frame or walls."""
    if walls:
        said = "share that the stress in the walls is of that under which plates buckle"
        source = "Timoshenko and Gere, 2nd ed., 9.2"
        first: Item = Given("f", said, walls, "", source, main=True)
    elif share:
        first = Given("lam", "lowest factor on all loads at which the frame buckles", 1 / share, "",
                      "eigenvalue: docs/theory/rungs_beam.md", main=True)  # fmt: skip
    else:
        return [Step("share", "share of the elastic buckling load", "0", main=True)]
    formula = "f" if walls else "1/lam"
    return [first, Step("share", "share of the elastic buckling load", formula, main=True)]


@dataclass(frozen=True, eq=False)
class _Search:
    solved: BeamSolution
    coefficients: FloatArray

    @cached_property
    def fields(self) -> FloatArray:
        """Motions (6 n, k) that the pins allow: the softest of the frame, of unit strain energy.

        Held are the displacements at each pin, along the part at the first only, and the turn about
        the part's axis there (fem.end_conditions.link_solid).
        """
        frame = self.solved.frame
        scale = np.tile(np.r_[np.ones(3), np.full(3, 1 / self.solved.size)], len(frame.nodes))
        rows = self._held() * scale
        free = np.linalg.qr(rows.T, mode="complete")[0][:, len(rows) :] * scale[:, None]
        values, vectors = scipy.linalg.eigh(
            free.T @ (frame.stiffness @ free), subset_by_index=(0, min(_SOFTEST, free.shape[1]) - 1)
        )
        return np.asarray(free @ (vectors / np.sqrt(values)))

    def _held(self) -> FloatArray:
        first, second = (6 * entry.node for entry in self.solved.entries[:2])
        held = [first, first + 1, first + 2, first + 3, second + 1, second + 2]
        return np.eye(6 * len(self.solved.frame.nodes))[held]

    @cached_property
    def forms(self) -> FloatArray:
        """Second-order work (n_basis, k, k) of each unit case between the fields."""
        return geometric_forms(self.solved.frame, self.solved.at_points, self.fields)

    def modes(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest factors above 0 of a state (n_basis,) of the loads, and shapes by the fields."""
        values, vectors = np.linalg.eigh(-np.tensordot(state, self.forms, axes=1))
        order = np.flatnonzero(values > _NONE * np.abs(values).max(initial=0.0))[::-1][:_COUNT]
        return 1 / values[order], vectors[:, order]

    def worst(self) -> tuple[int, float, FloatArray] | None:
        """The position with the lowest factor found, the factor and its shape (6 n,)."""
        fields = [self.modes(sign * state)[1] for state in self._patterns() for sign in (1.0, -1.0)]
        if not fields:
            return None
        solved: dict[int, tuple[FloatArray, FloatArray]] = {}
        while len(solved) < _MOST:
            shares = self._shares(np.hstack(fields))
            shares[list(solved)] = 0.0
            position = int(np.argmax(shares))
            known = max((1 / m[0][0] for m in solved.values() if len(m[0])), default=0.0)
            if not shares[position] * _CLOSE > known:
                break
            solved[position] = self.modes(self.coefficients[:, position])
            fields.append(solved[position][1])
        buckling = {k: modes for k, modes in solved.items() if len(modes[0])}
        if not buckling:
            return None
        lowest = min(factors[0] for factors, _ in buckling.values())
        worst = min(k for k, m in buckling.items() if m[0][0] <= (1.0 + _TIE) * lowest)
        factors, shapes = buckling[worst]
        return worst, float(factors[0]), self.fields @ shapes[:, 0]

    def plane(self, shape: FloatArray) -> str:
        """In which plane a mode moves more."""
        moved = np.abs(shape.reshape(-1, 6)[:, :3]).max(axis=0)
        return "out of plane" if moved[2] > moved[:2].max() else "in plane"

    def _patterns(self) -> list[FloatArray]:
        """Load states that those of all positions are made of, to a tenth of the largest.

        Measured by the section forces, moments over the part's size.
        """
        scale = np.r_[np.ones(3), np.full(3, 1 / self.solved.size)]
        forces = self.solved.at_points * scale[:, None]
        left = np.linalg.qr(forces.reshape(-1, len(self.coefficients)), mode="r")
        left = left @ self.coefficients
        states = self.coefficients.copy()
        largest = float(np.linalg.norm(left, axis=0).max(initial=0.0))
        found: list[FloatArray] = []
        while largest > 0.0 and len(found) < _PATTERNS:
            sizes = np.linalg.norm(left, axis=0)
            most = int(sizes.argmax())
            if sizes[most] < _SMALL * largest:
                break
            found.append(states[:, most].copy())
            along = (left[:, most] @ left) / sizes[most] ** 2
            states -= np.outer(found[-1], along)
            left -= np.outer(left[:, most].copy(), along)
        return found

    def _shares(self, fields: FloatArray) -> FloatArray:
        """Share (n,) of its lowest factor that each position's load is at least; 0 without any."""
        own = np.linalg.qr(fields)[0]
        forms = own.T @ self.forms @ own
        count = self.coefficients.shape[1]
        result = np.zeros(count)
        for start in range(0, count, _BLOCK):
            part = self.coefficients[:, start : start + _BLOCK]
            states = -np.tensordot(part.T, forms, axes=1)
            result[start : start + _BLOCK] = np.linalg.eigvalsh(states)[:, -1]
        return np.maximum(result, 0.0)
