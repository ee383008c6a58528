"""A pack of leaves that press and rub on each other: beams with unilateral contact and friction.

Every leaf is a Timoshenko beam on the same places along x; leaves are stacked along y. Between the
faces of neighbours, at each place, there is a gap and a slip

    gap  = w_above - w_below                    pressure >= 0, gap >= 0, pressure * gap = 0
    slip = u_above - u_below + (turn_above + turn_below) t/2,     |shear| <= friction * pressure

with shear against the change of the slip since the position before where it is at its limit, and no
change where it is below (Coulomb, quasi-static: only the order of the positions counts). Loads are
taken one position after the other, turn after turn, until a turn comes to a position as the turn
before (docs/theory/leaf_packs.md).

The pack is condensed to its interfaces: forces there are c = S d - g, with d the gaps and slips, S
the stiffness of loose leaves against them, and -g the forces in a pack that is glued together.
Where a gap is closed or a slip sticks d is known, elsewhere c. What touches and what slips is found
by Newton's method, started from the position before.

Loads of the pack must balance but for what a rigid acceleration of its evenly spread mass takes.
"""

from dataclasses import dataclass

import numpy as np

from fem.contact.condensed import ContactError
from fem.leaf_stack import LeafStack
from geometry.mesh import BoolArray, FloatArray

_NEWTON_STEPS = 150
_SHARES = (0.1, 0.3, 0.7, 0.99)  # of the worst broken law: laws that one step mends, at least
_SOFT = 1e-4  # of E times the width: springs that hold loose leaves; results do not depend on it
_TURNS = 20
_REPEATS = 1e-5  # of the largest slip: how well a turn must come to a position as the one before
_ROUND_OFF = 1e-9  # of the largest force of contact
_MOST_DOFS = 4500  # displacements and turns, 14 s and 1.2 GB of full matrices
_FAINT = 1e-3  # of the largest load: forces of contact that may be taken for nothing


@dataclass(frozen=True, eq=False)
class Driven:
    """A force that is as large as it takes to impose a deflection.

    direction  (n, n_dofs) loads of a unit force, balanced; its work is the deflection
    deflection (n,) mm along the force, with `soft` times the force, that is imposed; NaN where
               the force is nothing
    soft       (n,) mm/N, of what else gives way
    """

    direction: FloatArray
    deflection: FloatArray
    soft: FloatArray


@dataclass(frozen=True, eq=False)
class LeafHistory:
    """A pack over the positions of a turn that repeats.

    displacements     (n, n_dofs) mm and rad
    stress            (n, count, 2, 2 (k - 1)) MPa, lower and upper faces at `stress_places`
    pressures, shears (n, count - 1, k) N, forces between faces at the places
    gaps, slips       (n, count - 1, k) mm
    force             (n,) N, of what is driven
    unbalanced        largest force that is left, over the largest load
    not_complementary largest of pressure with a gap and of a broken law of friction, scaled
    turns             until the turn repeated itself
    """

    displacements: FloatArray
    stress: FloatArray
    pressures: FloatArray
    shears: FloatArray
    gaps: FloatArray
    slips: FloatArray
    force: FloatArray
    unbalanced: float
    not_complementary: float
    turns: int


@dataclass(frozen=True, eq=False)
class _Loads:
    """Loads of the interfaces at one position.

    glued   (2 m,) N, g of all loads but the driven force
    unit    (2 m,) g of a unit of the driven force
    soft    mm/N, its compliance on a pack that is glued together, with what else gives way
    imposed mm, its deflection less what the other loads make of it there; NaN: it is nothing
    """

    glued: FloatArray
    unit: FloatArray
    soft: float
    imposed: float


@dataclass(frozen=True, eq=False)
class _State:
    """Forces c, gaps and slips d at one position; which gaps are closed, which slips stick.

    missed  N, of the laws of contact and friction
    """

    c: FloatArray
    d: FloatArray
    force: float
    closed: BoolArray
    stuck: BoolArray
    sense: FloatArray
    missed: float


class LeafContact:
    """Leaves with everything that depends neither on loads nor on friction.

    Raises ContactError for a stack of so many places that its full matrices would take gigabytes.
    """

    def __init__(self, stack: LeafStack) -> None:
        if stack.n_dofs > _MOST_DOFS:
            raise ContactError(
                f"{stack.count} leaves that can touch at {len(stack.places)} places are more than "
                f"this contact is solved for; together at most {_MOST_DOFS // 3} places"
            )
        self.stack = stack
        b = stack.relative
        self.size = len(b) // 2
        # springs at the interfaces hold the leaves while their flexibility is found, then go again
        self._spring = stack.youngs_modulus * stack.width * _SOFT
        held = stack.stiffness + self._spring * b.T @ b
        middle = 3 * (len(stack.places) // 2)
        for which in range(3):  # loads balance, so what holds the pack carries nothing
            held[middle + which, middle + which] *= 2
        root = np.linalg.inv(np.linalg.cholesky(held))
        self._inverse = root.T @ root
        self._moved = b @ self._inverse
        tied = np.linalg.inv(self._moved @ b.T)
        tied = (tied + tied.T) / 2
        self._glued = tied @ self._moved
        self._stiff = tied - self._spring * np.eye(2 * self.size)
        self._bolted = np.zeros(self.size, dtype=bool)
        if stack.bolted is not None:
            self._bolted[stack.bolted :: len(stack.places)] = True

    def tied(self, loads: FloatArray, *, bonded: bool = False) -> FloatArray:
        """Displacements (n, n_dofs) of leaves that neither part nor rub, or are glued together."""
        glued = loads @ self._glued.T
        c, d = -glued, np.zeros_like(glued)
        if not bonded:
            free = self.size + np.flatnonzero(~self._bolted)
            d[:, free] = np.linalg.solve(self._stiff[free[:, None], free], glued[:, free].T).T
            c += d @ self._stiff
            c[:, free] = 0.0
        return self._displacements(loads, c, d)

    def _displacements(self, loads: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
        return np.asarray(loads @ self._inverse + (c + self._spring * d) @ self._moved)

    def history(
        self,
        loads: FloatArray,
        friction: float,
        driven: Driven | None = None,
        *,
        once: bool = False,
    ) -> LeafHistory:
        """Step through the positions of a turn until it repeats itself.

        loads     (n, n_dofs) N, N mm, balanced, without what is driven
        friction  coefficient between faces, at least 0
        driven    the force by which deflections are imposed
        once      step through the positions once only, from unstressed leaves

        Raises ValueError for bad friction, and ContactError where no contact is found or the turn
        does not repeat itself.
        """
        if not friction >= 0:
            raise ValueError(f"friction must be at least 0, got {friction:g}")
        given = self._loads(loads, driven)
        least = _FAINT * max(
            float(np.abs(sizes).max())
            for sizes in (loads, *(() if driven is None else (driven.direction,)))
        )
        m, nothing, none = self.size, np.zeros(2 * self.size), np.zeros(self.size)
        state = _State(nothing, nothing, 0.0, none == 0, none == 0, none, 0.0)
        states: list[_State] = []
        for turn in range(1, 2 if once else _TURNS + 1):
            scale = max((float(np.abs(s.d[m:]).max()) for s in states), default=0.0)
            for k, here in enumerate(given):
                tries = (self._newton(state, here, friction, least, share) for share in _SHARES)
                found = next((one for one in tries if one is not None), None)
                if found is None:
                    raise ContactError(
                        f"contact and friction of the leaves do not settle at position {k}"
                    )
                state = found
                if turn == 1:
                    states.append(state)
                    continue
                change = float(np.abs(state.d[m:] - states[k].d[m:]).max())
                states[k] = state
                if change <= _REPEATS * scale:
                    return self._told(states, loads, driven, turn)
        if once:
            return self._told(states, loads, driven, 1)
        raise ContactError(
            f"the leaves' slip does not repeat itself after {_TURNS} turns: between the ends of "
            f"the last two, {change:.3g} mm of {scale:.3g} mm differ"
        )

    def _loads(self, loads: FloatArray, driven: Driven | None) -> list[_Loads]:
        glued = loads @ self._glued.T
        if driven is None:
            nothing = np.zeros(2 * self.size)
            return [_Loads(g, nothing, 1.0, np.nan) for g in glued]
        unit = driven.direction @ self._glued.T
        own = driven.direction @ self._inverse - unit @ self._moved
        soft = np.einsum("nd,nd->n", own, driven.direction) + driven.soft
        imposed = driven.deflection - np.einsum("nd,nd->n", own, loads)
        rows = zip(glued, unit, soft.tolist(), imposed.tolist(), strict=True)
        return [_Loads(*row) for row in rows]

    def _newton(
        self, last: _State, given: _Loads, friction: float, least: float, share: float
    ) -> _State | None:
        """Newton's method on the laws of contact and friction; None where it does not settle.

        least  N, a force of contact that counts
        share  of the worst broken law: laws broken less stay as they are for a step
        """
        m, k, bolted, before = self.size, self._spring, self._bolted, last.d[self.size :]
        aim = np.r_[np.zeros(m), before]
        closed, stuck, sense = last.closed, last.stuck | bolted, last.sense
        driving = bool(np.isfinite(given.imposed))
        stiff, glued = self._driven(given) if driving else (self._stiff, given.glued)
        seen: set[bytes] = set()
        for _ in range(_NEWTON_STEPS):
            held = np.r_[closed, closed & stuck | bolted]
            free, rubbing = np.flatnonzero(~held), np.flatnonzero(closed & ~stuck)
            rate = friction * sense[rubbing]
            d = np.where(held, aim, 0.0)
            left = glued - stiff @ d
            right, matrix = left[free], stiff[free[:, None], free]
            rows = np.searchsorted(free, m + rubbing)
            right[rows] -= rate * left[rubbing]
            matrix[rows] -= rate[:, None] * stiff[rubbing[:, None], free]
            try:
                d[free] = np.linalg.solve(matrix, right)
            except np.linalg.LinAlgError:  # a leaf that nothing holds
                return None
            c = stiff @ d - glued
            c[free] = 0.0
            c[m + rubbing] = rate * c[rubbing]
            force = float(given.imposed - given.unit @ d) / given.soft if driving else 0.0
            scale = _ROUND_OFF * max(float(np.abs(c).max()), least)
            bound = friction * c[:m].clip(min=0)
            gap, trial = k * d[:m], c[m:] - k * (d[m:] - before)
            broken = np.abs(np.minimum(c[:m], gap))
            rubbed = np.abs(c[m:] - np.clip(trial, -bound, bound))
            rubbed[bolted] = 0.0
            missed = max(float(broken.max()), float(rubbed.max()))
            if missed <= scale and force < 0:
                driving, stiff, glued = False, self._stiff, given.glued
                continue
            if missed <= scale:
                return _State(c, d, force, closed, stuck, sense, missed)
            closed = np.where(broken >= share * missed, c[:m] - gap > -scale, closed)
            mended = rubbed >= share * missed
            stuck = np.where(mended, np.abs(trial) <= bound + scale, stuck) | bolted
            sense = np.where(mended, np.sign(trial), sense)
            key = closed.tobytes() + stuck.tobytes() + sense.tobytes()
            if key in seen:
                return None
            seen.add(key)
        return None

    def _driven(self, given: _Loads) -> tuple[FloatArray, FloatArray]:
        """S and g of the interfaces with the driven force, (imposed - unit d) / soft, in them."""
        unit = given.unit / given.soft
        return self._stiff + np.outer(given.unit, unit), given.glued + given.imposed * unit

    def _told(
        self, states: list[_State], loads: FloatArray, driven: Driven | None, turns: int
    ) -> LeafHistory:
        m, stack = self.size, self.stack
        force = np.array([s.force for s in states])
        c, d = (np.array([getattr(s, name) for s in states]) for name in "cd")
        whole = loads if driven is None else loads + force[:, None] * driven.direction
        moved = self._displacements(whole, c, d)
        left = moved @ stack.stiffness - whole - c @ stack.relative
        left[:, 2::3] /= stack.thickness  # couples, as forces on the faces
        largest = max(float(np.abs(c).max()), float(np.abs(whole).max()), 1e-30)
        shape = len(states), stack.count - 1, len(stack.places)
        return LeafHistory(
            displacements=moved,
            stress=stack.stress(moved),
            pressures=c[:, :m].reshape(shape),
            shears=c[:, m:].reshape(shape),
            gaps=d[:, :m].reshape(shape),
            slips=d[:, m:].reshape(shape),
            force=force,
            unbalanced=float(np.abs(left).max()) / largest,
            not_complementary=max(s.missed for s in states) / largest,
            turns=turns,
        )
