"""A contact problem condensed to the surface that can touch: gaps, forces, rigid motions.

    gaps = openings + flexibility @ forces - directions @ motion
    gaps >= 0,  forces >= 0,  forces * gaps = 0,  directions.T @ forces = force

Frictionless, linear elastic, small rotations: a convex quadratic problem whose multipliers are the
motions of the rigid bodies that press. Each force belongs to one patch of pressure (a hat), each
gap is the mean of the gap over the same patch, weighted with the same hat. So the flexibility is
symmetric, work is counted exactly, and force and gap exclude each other patch by patch
(docs/theory/contact.md).

The patches that touch are sought by Newton's method on min(forces, gaps) = 0, a primal-dual active
set: a few solutions, one or two from a good start. Where it cycles, a primal active set, which
cannot, starts from forces that balance the load.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.mesh import BoolArray, FloatArray

_NEWTON_STEPS = 40
_ROUND_OFF = 1e-10  # of the largest force or opening
ALLOWED = 1e-6  # what a result may miss of equilibrium and of complementarity, scaled


class ContactError(ValueError):
    """A contact problem without a solution, or with more than one."""


@dataclass(frozen=True, eq=False)
class CondensedContact:
    """Patches that can touch, and their flexibility.

    flexibility  (n, n) mm/N, symmetric: mean opening of each patch per force on each patch
    directions   (n, m) 1: mean approach of each patch per motion of the rigid bodies; transposed,
                 the resultants of unit forces on the patches

    Raises ValueError for shapes that do not fit, or a flexibility that is not symmetric to 1e-9.
    """

    flexibility: FloatArray
    directions: FloatArray

    def __post_init__(self) -> None:
        n = len(self.flexibility)
        if self.flexibility.shape != (n, n) or self.directions.shape[:1] != (n,):
            raise ValueError(
                f"directions {self.directions.shape} do not fit a flexibility "
                f"{self.flexibility.shape}"
            )
        uneven = np.abs(self.flexibility - self.flexibility.T).max(initial=0.0)
        if uneven > 1e-9 * np.abs(self.flexibility).max(initial=0.0):
            raise ValueError(f"the flexibility is not symmetric: {uneven:.2e} mm/N apart")

    def solve(
        self, openings: FloatArray, force: FloatArray, touching: BoolArray | None = None
    ) -> "ContactState":
        """Return what touches under a load.

        openings  (n,) mm, mean gap of each patch before anything moves or presses
        force     (m,) N or N mm, what the patches carry together
        touching  (n,) where it touched at a neighbouring position, to start from

        Raises ContactError if no load presses the bodies together, so that they float, or if no
        pressure balances the load.
        """
        if not np.abs(force).max(initial=0.0) > 0 and openings.min() >= 0:
            raise ContactError(
                "the pin floats: it carries no force and has clearance, so it touches nowhere"
            )
        if touching is None or not touching.any():
            touching = self.directions @ force > 0
        if not touching.any():  # pressed in: no force says where
            touching = np.ones(len(openings), dtype=bool)
        found = self._newton(openings, force, touching)
        if found is None:
            found = self._primal(openings, force, touching)
        return found

    def _equilibrium(
        self, openings: FloatArray, force: FloatArray, touching: BoolArray
    ) -> tuple[FloatArray, FloatArray] | None:
        """Forces (n,) and motion (m,) with the gaps closed where it touches; None if singular."""
        at = touching.nonzero()[0]
        count, m = len(at), self.directions.shape[1]
        if count < m:
            return None
        scale, whole = self._whole
        rows = np.concatenate([at, np.arange(len(whole) - m, len(whole))])
        system = whole[rows[:, None], rows]
        right = np.concatenate([openings[at] / -scale, -force])
        try:
            answer = np.linalg.solve(system, right)
        except np.linalg.LinAlgError:
            return None
        if not np.abs(system @ answer - right).max() <= 1e-9 * np.abs(right).max():
            return None
        forces = np.zeros(len(self.flexibility))
        forces[at] = answer[:count]
        return forces, scale * answer[count:]

    @cached_property
    def _whole(self) -> tuple[float, FloatArray]:
        """Scale of the flexibility, and the equations (n + m, n + m) where every gap is closed."""
        n, m = self.directions.shape
        scale = float(np.abs(self.flexibility.diagonal()).max())  # brings both blocks to one size
        whole = np.zeros((n + m, n + m))
        whole[:n, :n] = self.flexibility / scale
        whole[:n, n:] = -self.directions
        whole[n:, :n] = -self.directions.T
        return scale, whole

    def gaps(self, openings: FloatArray, forces: FloatArray, motion: FloatArray) -> FloatArray:
        """Mean gaps (n,) of the patches, mm."""
        at = forces.nonzero()[0]
        pressed = forces[at] @ self.flexibility[at]
        return np.asarray(openings + pressed - self.directions @ motion)

    def _newton(
        self, openings: FloatArray, force: FloatArray, touching: BoolArray
    ) -> "ContactState | None":
        """Primal-dual active set; None where it cycles or meets a singular set."""
        for step in range(1, _NEWTON_STEPS + 1):
            solved = self._equilibrium(openings, force, touching)
            if solved is None:
                return None
            forces, motion = solved
            gaps = self.gaps(openings, forces, motion)
            gaps[touching] = 0.0
            reach = _ROUND_OFF * max(np.abs(openings).max(), np.abs(motion).max())
            following = (touching & (forces >= 0)) | (~touching & (gaps < -reach))
            if (following == touching).all():
                return ContactState(self, openings, force, forces, motion, touching, step)
            touching = following
        return None

    def _primal(
        self, openings: FloatArray, force: FloatArray, touching: BoolArray
    ) -> "ContactState":
        """Primal active set: every step balances the load and lowers the energy.

        touching  (n,) to begin with

        Raises ContactError if no pressure balances the load.
        """
        forces, free = self._balanced(force, touching)
        for step in range(1, 20 * len(forces)):
            solved = self._equilibrium(openings, force, free)
            if solved is None:
                raise ContactError("the patches that touch do not hold the pin: they are too few")
            wanted, motion = solved
            falls = np.flatnonzero(free & (wanted < 0))
            if len(falls):
                shares = forces[falls] / np.maximum(forces[falls] - wanted[falls], 1e-300)
                first = falls[shares.argmin()]
                forces = forces + shares.min() * (wanted - forces)
                forces[first], free[first] = 0.0, False
                continue
            forces = wanted
            gaps = self.gaps(openings, forces, motion)
            gaps[free] = 0.0
            reach = _ROUND_OFF * max(np.abs(openings).max(), np.abs(motion).max())
            if gaps.min() >= -reach:
                return ContactState(self, openings, force, forces, motion, free, step)
            free[gaps.argmin()] = True
        raise ContactError("the patches that touch were not found")

    def _balanced(self, force: FloatArray, touching: BoolArray) -> tuple[FloatArray, BoolArray]:
        """Forces (n,) N that balance the load, and the patches (n,) that are free to press.

        Of patches that touch by a guess where they can; else of any, which may be fewer than hold
        the pin across the load. Raises ContactError if no pressure balances the load.
        """
        from scipy.optimize import nnls

        size = np.abs(force).max() or 1.0
        for among in (np.flatnonzero(touching), np.arange(len(touching))):
            found, missing = nnls(self.directions[among].T, force / size)
            if missing <= 1e-9:
                break
        else:
            raise ContactError(
                f"no pressure balances the load: {missing:.1e} of it is left, as by a couple that "
                "tips the pin out of its bore"
            )
        forces = np.zeros(len(touching))
        forces[among] = found * size
        if len(among) < len(touching):
            return forces, touching.copy()
        free = (forces > 0) | (self.directions @ force > 0)
        if not forces.any():
            free[:] = True
        return forces, free


@dataclass(frozen=True, eq=False)
class ContactState:
    """Contact at one load.

    forces    (n,) N, of the patches
    motion    (m,) mm and rad, of the rigid bodies
    touching  (n,) True where the gap is closed
    steps     equations solved
    """

    problem: CondensedContact
    openings: FloatArray
    force: FloatArray
    forces: FloatArray
    motion: FloatArray
    touching: BoolArray
    steps: int

    @property
    def gaps(self) -> FloatArray:
        """Mean gaps (n,) of the patches, mm, by all terms: closed ones are round-off, not 0."""
        return self.problem.gaps(self.openings, self.forces, self.motion)

    @property
    def unbalanced(self) -> float:
        """The largest part of the load that the forces miss, over the largest load."""
        return largest_misses([self])[1]

    @property
    def not_complementary(self) -> float:
        """How far forces and gaps are from excluding each other, with their signs, scaled.

        Gaps by the largest opening or approach, forces by their mean where it touches: the largest
        of a gap below 0, a force below 0 and the smaller one of each pair.
        """
        return largest_misses([self])[0]


def largest_misses(states: Sequence[ContactState]) -> tuple[float, float]:
    """Largest `not_complementary` and `unbalanced` of states of one contact."""
    problem = states[0].problem
    openings, loads, forces, motions = (
        np.stack([getattr(state, name) for state in states], axis=1)
        for name in ("openings", "force", "forces", "motion")
    )
    approach = problem.directions @ motions
    gaps = openings + problem.flexibility @ forces - approach
    widest = np.maximum(
        np.abs(openings).max(axis=0, initial=0.0), np.abs(approach).max(axis=0, initial=0.0)
    )
    touching = np.stack([state.touching for state in states], axis=1)
    mean = (forces * touching).sum(axis=0) / touching.sum(axis=0)
    complementary = np.abs(np.minimum(gaps / widest, forces / mean)).max(initial=0.0)
    missed = np.abs(problem.directions.T @ forces - loads).max(axis=0, initial=0.0)
    size = np.abs(loads).max(axis=0, initial=0.0)
    most = np.abs(forces).max(axis=0, initial=1.0)
    return float(complementary), float((missed / np.where(size > 0.0, size, most)).max())
