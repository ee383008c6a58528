"""A pack of leaves that press and rub on each other: beams with unilateral contact and friction.

Every leaf is a Timoshenko beam on the same places along x; leaves are stacked along y. Between the
faces of neighbours, at each place, there is a gap and a slip

    gap  = w_above - w_below + gap_0            pressure >= 0, gap >= 0, pressure * gap = 0
    slip = u_above - u_below + (turn_above + turn_below) t/2,     |shear| <= friction * pressure

with shear against the change of the slip since the position before where it is at its limit, and no
change where it is below (Coulomb, quasi-static: only the order of the positions counts). Loads are
taken one position after the other, turn after turn, until a turn comes to a position as the turn
before (docs/theory/leaf_packs.md).

The pack is condensed to its interfaces: forces there are c = S d - g, with d what gaps and slips
have changed by, S the stiffness of loose leaves against that, and -g the forces of a pack that is
glued together. What touches and what slips is found by Newton's method, started from the position
before; in each step only the d of open gaps and of what slips are unknown.

Loads of the pack must balance but for what a rigid acceleration of its evenly spread mass takes.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from fem.contact.condensed import ContactError
from geometry.mesh import BoolArray, FloatArray, IntArray

SHEAR = 5 / 6  # share of a rectangle's section that its mean shear strain acts on
_NEWTON_STEPS = 150
_SHARES = (0.0, 0.3, 0.7, 0.99)  # of the worst broken law: laws that one step mends, at least
_SOFT = 1e-4  # of E times the width: springs that hold loose leaves; results do not depend on it
_HALVINGS = 6  # of the way from one position to the next
_TURNS = 20
_REPEATS = 1e-5  # of the largest slip: how well a turn must come to a position as the one before
_ROUND_OFF = 1e-9  # of the largest force of contact
_FAINT = 1e-3  # of the largest load: forces of contact that may be taken for nothing


@dataclass(frozen=True, eq=False)
class LeafStack:
    """Equal leaves on top of each other.

    places     (k,) mm, rising, where neighbours can touch
    count      number of leaves, at least 2
    width, thickness                  mm, of one leaf
    youngs_modulus, poisson_ratio     MPa, 1
    bolted     index of the place where nothing slips, whatever presses; None for none
    openings   (count - 1, k) mm, gaps of the leaves as made, unstressed; 0 for flat ones

    Raises ValueError for a stack that cannot be.
    """

    places: FloatArray
    count: int
    width: float
    thickness: float
    youngs_modulus: float
    poisson_ratio: float
    bolted: int | None = None
    openings: FloatArray | float = 0.0

    def __post_init__(self) -> None:
        if self.count < 2 or len(self.places) < 2 or not (np.diff(self.places) > 0).all():
            raise ValueError(
                f"a stack needs two leaves and two rising places, got {self.count} leaves on "
                f"{len(self.places)} places"
            )

    @property
    def n_dofs(self) -> int:
        """Displacements along x and y and turns of all leaves at all places."""
        return 3 * self.count * len(self.places)

    def dof(self, leaf: int, which: int) -> IntArray:
        """Numbers (k,) of a leaf's displacements along x (0), along y (1) or turns (2)."""
        return 3 * (leaf * len(self.places) + np.arange(len(self.places))) + which

    def at(self, x: float) -> FloatArray:
        """Shares (k,) of the two places next to x, which keep force and moment."""
        shares = np.zeros(len(self.places))
        at = int(np.clip(np.searchsorted(self.places, x) - 1, 0, len(self.places) - 2))
        way = (x - self.places[at]) / (self.places[at + 1] - self.places[at])
        shares[at], shares[at + 1] = 1 - way, way
        return shares

    def spread(self, span: tuple[float, float], force: float, couple: float) -> FloatArray:
        """Forces along y (k,) of a clamp, N: even over its span, those of its couple grow along it.

        couple  N mm, about the middle of the span
        """
        weights = self.spans(span)
        share = weights / weights.sum()
        arms = self.places - share @ self.places
        couple = couple - force * (float(share @ self.places) - (span[0] + span[1]) / 2)
        return np.asarray(force * share + couple * share * arms / (share @ arms**2))

    def on_faces(self, forces: FloatArray, like: FloatArray | None = None) -> FloatArray:
        """Loads (n_dofs,) of forces along y (k,) that push on the outer faces.

        Upwards on the lowest leaf, downwards on the highest; with `like`, on the faces that the
        forces (k,) of another load push on.
        """
        up = (forces if like is None else like) >= 0
        loads = np.zeros(self.n_dofs)
        loads[self.dof(0, 1)] = np.where(up, forces, 0.0)
        loads[self.dof(self.count - 1, 1)] = np.where(up, 0.0, forces)
        return loads

    def squeezed(self, span: tuple[float, float], force: float) -> FloatArray:
        """Loads (n_dofs,) of a force, N, that presses the leaves together evenly over a span."""
        weights = self.spans(span)
        loads = np.zeros(self.n_dofs)
        loads[self.dof(0, 1)] = force * weights / weights.sum()
        loads[self.dof(self.count - 1, 1)] = -force * weights / weights.sum()
        return loads

    def spans(self, span: tuple[float, float]) -> FloatArray:
        """Length (k,) mm of a span that belongs to each place, by hats."""
        edges = np.unique(np.clip(np.r_[self.places, span], *span))
        middle, lengths = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
        return np.array([self.at(x) for x in middle]).T @ lengths

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffness (n_dofs, n_dofs) N/mm, N, N mm of the leaves, each on its own."""
        n = 3 * len(self.places)
        leaf = np.zeros((n, n))
        for first, element in zip(range(0, n, 3), self._elements, strict=False):
            leaf[first : first + 6, first : first + 6] += element
        return np.kron(np.eye(self.count), leaf)

    @cached_property
    def _elements(self) -> FloatArray:
        """Stiffness (k - 1, 6, 6) of a leaf's beams between places, exact under loads at their ends."""
        area, h = self.width * self.thickness, np.diff(self.places)
        bending = self.youngs_modulus * area * self.thickness**2 / 12
        shear = SHEAR * area * self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        a, one = self.youngs_modulus * area / h, np.ones_like(h)
        soft = 12 * bending / (shear * h**2)
        near, far = (4 + soft) * h**2, (2 - soft) * h**2
        bent = np.array(
            [
                [12 * one, 6 * h, -12 * one, 6 * h],
                [6 * h, near, -6 * h, far],
                [-12 * one, -6 * h, 12 * one, -6 * h],
                [6 * h, far, -6 * h, near],
            ]
        )
        found = np.zeros((6, 6, len(h)))
        found[np.ix_([0, 3], [0, 3])] = a * np.array([[1, -1], [-1, 1]])[:, :, None]
        found[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bending / (h**3 * (1 + soft)) * bent
        return np.moveaxis(found, 2, 0)

    @cached_property
    def relative(self) -> FloatArray:
        """Gaps, then slips, (2 m, n_dofs) of displacements; m = (count - 1) k."""
        k, m = len(self.places), (self.count - 1) * len(self.places)
        rows = np.zeros((2 * m, self.n_dofs))
        for i in range(self.count - 1):
            gap, slip = i * k + np.arange(k), m + i * k + np.arange(k)
            rows[gap, self.dof(i, 1)] = -1
            rows[gap, self.dof(i + 1, 1)] = 1
            rows[slip, self.dof(i, 0)] = -1
            rows[slip, self.dof(i + 1, 0)] = 1
            rows[slip, self.dof(i, 2)] = self.thickness / 2
            rows[slip, self.dof(i + 1, 2)] = self.thickness / 2
        return rows

    @cached_property
    def stress_places(self) -> FloatArray:
        """Places (2 (k - 1),) mm of stresses: both ends of every stretch between two places."""
        return np.repeat(self.places, 2)[1:-1]

    def stress(self, displacements: FloatArray) -> FloatArray:
        """Stress along x (n, count, 2, 2 (k - 1)) MPa: lower, upper face of each leaf.

        N/A - M y/I at both ends of each stretch: shear between faces acts at the places and makes
        steps there, whose higher side counts.
        """
        area, n = self.width * self.thickness, len(displacements)
        modulus = area * self.thickness / 6
        ends = displacements.reshape(n, self.count, len(self.places), 3)
        ends = np.concatenate([ends[:, :, :-1], ends[:, :, 1:]], axis=3)
        forces = np.einsum("eij,nlej->nlei", self._elements, ends)
        normal = np.stack([-forces[..., 0], forces[..., 3]], axis=-1).reshape(n, self.count, -1)
        moment = np.stack([-forces[..., 2], forces[..., 5]], axis=-1).reshape(n, self.count, -1)
        bent = moment / modulus
        return np.stack([normal / area + bent, normal / area - bent], axis=2)

    def balanced(self, loads: FloatArray) -> FloatArray:
        """Loads (..., n_dofs) with the inertia of a rigid acceleration that balances them."""
        weights = self.spans((self.places[0], self.places[-1]))
        rigid, inertia = np.zeros((3, self.n_dofs)), np.zeros((3, self.n_dofs))
        for leaf in range(self.count):
            y = (leaf - (self.count - 1) / 2) * self.thickness
            rigid[0, self.dof(leaf, 0)] = 1
            rigid[1, self.dof(leaf, 1)] = 1
            rigid[2, self.dof(leaf, 0)] = -y
            rigid[2, self.dof(leaf, 1)] = self.places
            rigid[2, self.dof(leaf, 2)] = 1
            inertia[0, self.dof(leaf, 0)] = weights
            inertia[1, self.dof(leaf, 1)] = weights
            inertia[2, self.dof(leaf, 0)] = -weights * y
            inertia[2, self.dof(leaf, 1)] = weights * self.places
        left = loads @ rigid.T
        return np.asarray(loads - left @ np.linalg.solve(inertia @ rigid.T, inertia))


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

    def towards(self, other: "_Loads", way: float) -> "_Loads":
        """The loads on the way to those of another position, at its end for way 1."""
        imposed = self.imposed + way * (other.imposed - self.imposed)
        return _Loads(
            self.glued + way * (other.glued - self.glued),
            self.unit + way * (other.unit - self.unit),
            self.soft + way * (other.soft - self.soft),
            imposed if np.isfinite(imposed) else other.imposed,
        )


@dataclass(frozen=True, eq=False)
class _State:
    """Forces c and changes d at one position; which gaps are closed, which slips stick.

    missed  N, of the laws of contact and friction on the way there
    """

    c: FloatArray
    d: FloatArray
    force: float
    closed: BoolArray
    stuck: BoolArray
    sense: FloatArray
    missed: float = 0.0


class LeafContact:
    """Leaves with everything that depends neither on loads nor on friction."""

    def __init__(self, stack: LeafStack) -> None:
        self.stack = stack
        b = stack.relative
        self.size = len(b) // 2
        # springs at the interfaces hold the leaves while their flexibility is found, then go again
        self._spring = stack.youngs_modulus * stack.width * _SOFT
        held = stack.stiffness + self._spring * b.T @ b
        middle = 3 * (len(stack.places) // 2)
        for which in range(3):  # loads balance, so what holds the pack carries nothing
            held[middle + which, middle + which] *= 2
        inverse = scipy.linalg.cho_solve(scipy.linalg.cho_factor(held), np.eye(stack.n_dofs))
        self._inverse = np.ascontiguousarray(inverse + inverse.T) / 2
        self._moved = b @ self._inverse
        tied = np.linalg.inv(self._moved @ b.T)
        tied = (tied + tied.T) / 2
        self._glued = tied @ self._moved
        self._stiff = tied - self._spring * np.eye(2 * self.size)
        shape = stack.count - 1, len(stack.places)
        openings = np.asarray(stack.openings, dtype=float)
        self._openings = np.broadcast_to(openings, shape).ravel()
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
        state, m = self._start(), self.size
        states: list[_State] = []
        there = given[0].towards(given[0], 0.0)
        there = replace(there, glued=0.0 * there.glued, imposed=0.0 * there.imposed)
        for turn in range(1, 2 if once else _TURNS + 1):
            scale = max((float(np.abs(s.d[m:]).max()) for s in states), default=0.0)
            for k, here in enumerate(given):
                state, there = self._reached(state, there, here, friction, k, least), here
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

    def _start(self) -> _State:
        nothing, none = np.zeros(2 * self.size), np.zeros(self.size)
        return _State(nothing, nothing, 0.0, self._openings <= 0, none == 0, none)

    def _reached(
        self, state: _State, there: _Loads, here: _Loads, friction: float, k: int, least: float
    ) -> _State:
        """The state at position k from the one before, by smaller steps where one is too long."""
        for halvings in range(_HALVINGS + 1):
            following, missed = state, 0.0
            for way in np.arange(1, 2**halvings + 1) / 2**halvings:
                step = there.towards(here, way) if halvings else here
                tries = (self._newton(following, step, friction, least, s) for s in _SHARES)
                found = next((state for state in tries if state is not None), None)
                if found is None:
                    break
                following, missed = found, max(missed, found.missed)
            else:
                return replace(following, missed=missed)
        raise ContactError(f"contact and friction of the leaves do not settle at position {k}")

    def _newton(
        self, last: _State, given: _Loads, friction: float, least: float, share: float
    ) -> _State | None:
        """Newton's method on the laws of contact and friction; None where it does not settle.

        least  N, a force of contact that counts
        share  of the worst broken law: laws broken less stay as they are for a step
        """
        m, k, bolted, before = self.size, self._spring, self._bolted, last.d[self.size :]
        aim = np.r_[-self._openings, before]
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
            d[free] = np.linalg.solve(matrix, right)
            c = stiff @ d - glued
            c[free] = 0.0
            c[m + rubbing] = rate * c[rubbing]
            force = float(given.imposed - given.unit @ d) / given.soft if driving else 0.0
            scale = _ROUND_OFF * max(float(np.abs(c).max()), least)
            bound = friction * c[:m].clip(min=0)
            gap, trial = k * (d[:m] + self._openings), c[m:] - k * (d[m:] - before)
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
            gaps=(d[:, :m] + self._openings).reshape(shape),
            slips=d[:, m:].reshape(shape),
            force=force,
            unbalanced=float(np.abs(left).max()) / largest,
            not_complementary=max(s.missed for s in states) / largest,
            turns=turns,
        )
