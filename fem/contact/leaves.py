"""A pack of leaves that press and rub on each other: beams with unilateral contact and friction.

Every leaf is a Timoshenko beam on the same places along x; leaves are stacked along y. Between the
faces of neighbours, at each place, there is a gap and a slip

    gap  = w_above - w_below + gap_0            pressure >= 0, gap >= 0, pressure * gap = 0
    slip = u_above - u_below + (turn_above + turn_below) t/2,     |shear| <= friction * pressure

with shear against the change of the slip since the position before where it is at its limit, and no
change where it is below (Coulomb, quasi-static: only the order of the positions counts). Loads are
taken one position after the other, turn after turn, until a turn ends as it began
(docs/theory/leaf_packs.md).

Forces are condensed to the interfaces. With springs of a stiffness k at every gap and slip the pack
is held together by linear springs alone, and forces z = c + k d on the interfaces, d the gaps and
slips and c the true forces of contact, make up for them. What touches and what slips is found by
Newton's method, started from the position before.

Loads of the pack must balance but for what a rigid acceleration of its evenly spread mass takes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from fem.contact.condensed import ContactError
from geometry.mesh import BoolArray, FloatArray, IntArray

SHEAR = 5 / 6  # share of a rectangle's section that its mean shear strain acts on
_NEWTON_STEPS = 150
_SHARES = (0.0, 0.3, 0.7, 0.99)  # of the worst broken law: laws that one step mends, at least
_SOFT = 1e-4  # springs of the interfaces over E times the width; results do not depend on it
_HALVINGS = 6  # of the way from one position to the next
_TURNS = 20
_REPEATS = 1e-5  # of the largest slip: how well a turn must end as it began
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
        return _hat(self.places, x)

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
        return np.array([_hat(self.places, x) for x in middle]).T @ lengths

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffness (n_dofs, n_dofs) N/mm, N, N mm of the leaves, each on its own."""
        whole = np.zeros((self.n_dofs, self.n_dofs))
        for rows, element in zip(self._rows, self._elements, strict=True):
            whole[np.ix_(rows, rows)] += element
        return whole

    @cached_property
    def _rows(self) -> IntArray:
        k = len(self.places)
        first = (np.arange(self.count)[:, None] * k + np.arange(k - 1)).ravel()
        return 3 * first[:, None] + np.arange(6)

    @cached_property
    def _elements(self) -> FloatArray:
        """Stiffness (elements, 6, 6) of Timoshenko beams, exact under loads at their ends."""
        area = self.width * self.thickness
        bending = self.youngs_modulus * area * self.thickness**2 / 12
        shear = SHEAR * area * self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        found = []
        for h in np.tile(np.diff(self.places), self.count):
            a = self.youngs_modulus * area / h
            soft = 12 * bending / (shear * h**2)
            b = bending / (h**3 * (1 + soft))
            k = np.zeros((6, 6))
            k[np.ix_([0, 3], [0, 3])] = a * np.array([[1, -1], [-1, 1]])
            k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = b * np.array(
                [
                    [12, 6 * h, -12, 6 * h],
                    [6 * h, (4 + soft) * h**2, -6 * h, (2 - soft) * h**2],
                    [-12, -6 * h, 12, -6 * h],
                    [6 * h, (2 - soft) * h**2, -6 * h, (4 + soft) * h**2],
                ]
            )
            found.append(k)
        return np.array(found)

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

    @cached_property
    def face_stress(self) -> FloatArray:
        """Stress along x (count, 2, 2 (k - 1), n_dofs) MPa/mm: lower, upper face of each leaf.

        N/A - M y/I at both ends of each stretch: shear between faces acts at the places and makes
        steps there, whose higher side counts.
        """
        k, area = len(self.places), self.width * self.thickness
        modulus = area * self.thickness / 6
        result = np.zeros((self.count, 2, 2 * (k - 1), self.n_dofs))
        numbers = np.arange(self.count * (k - 1)).reshape(self.count, k - 1)
        for (leaf, e), number in np.ndenumerate(numbers):
            element = self._elements[number]
            ends = (-element[0], -element[2]), (element[3], element[5])
            for end, (normal, moment) in enumerate(ends):
                for face, side in ((0, 1.0), (1, -1.0)):
                    stress = normal / area + side * moment / modulus
                    result[leaf, face, 2 * e + end, self._rows[number]] = stress
        return result

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


def _hat(places: FloatArray, x: float) -> FloatArray:
    """Shares (k,) of the two places next to x, which keep force and moment."""
    shares = np.zeros(len(places))
    at = int(np.clip(np.searchsorted(places, x) - 1, 0, len(places) - 2))
    way = (x - places[at]) / (places[at + 1] - places[at])
    shares[at], shares[at + 1] = 1 - way, way
    return shares


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
    deflection        (n,) mm along it, without what else gives way
    unbalanced        largest force that is left, over the largest load
    not_complementary largest of pressure with a gap and of a broken law of friction, scaled
    turns             until the turn repeated itself
    work              N mm, that friction takes in a turn
    """

    displacements: FloatArray
    stress: FloatArray
    pressures: FloatArray
    shears: FloatArray
    gaps: FloatArray
    slips: FloatArray
    force: FloatArray
    deflection: FloatArray
    unbalanced: float
    not_complementary: float
    turns: int
    work: float


@dataclass(frozen=True, eq=False)
class _State:
    """Forces of contact and slips at one position; which gaps are closed, which slips stick.

    missed  N, of the laws of contact and friction on the way there
    """

    z: FloatArray
    force: float
    contact: FloatArray
    relative: FloatArray
    closed: BoolArray
    stuck: BoolArray
    sense: FloatArray
    missed: float = 0.0


@dataclass(frozen=True, eq=False)
class _Input:
    """Loads at one position, as in `LeafContact.history` and `Driven`."""

    load: FloatArray
    direction: FloatArray
    deflection: float
    soft: float

    @property
    def nothing(self) -> "_Input":
        """The same without any load."""
        return _Input(0.0 * self.load, self.direction, 0.0 * self.deflection, self.soft)

    def towards(self, other: "_Input", way: float) -> "_Input":
        """The loads on the way to those of another position, at its end for way 1."""
        deflection = self.deflection + way * (other.deflection - self.deflection)
        return _Input(
            self.load + way * (other.load - self.load),
            self.direction + way * (other.direction - self.direction),
            deflection if np.isfinite(deflection) else other.deflection,
            self.soft + way * (other.soft - self.soft),
        )


def _inputs(loads: FloatArray, driven: Driven | None) -> list[_Input]:
    if driven is None:
        return [_Input(load, np.zeros_like(load), np.nan, 0.0) for load in loads]
    return [
        _Input(*rows)
        for rows in zip(loads, driven.direction, driven.deflection, driven.soft, strict=True)
    ]


class LeafContact:
    """Leaves with everything that does not depend on loads; raises ValueError for bad numbers.

    friction  coefficient between faces, at least 0
    """

    def __init__(self, stack: LeafStack, friction: float) -> None:
        if not friction >= 0:
            raise ValueError(f"friction must be at least 0, got {friction:g}")
        self.stack, self.friction = stack, friction
        b = stack.relative
        self.size = len(b) // 2
        self.spring = stack.youngs_modulus * stack.width * _SOFT
        held = stack.stiffness + self.spring * b.T @ b
        middle = 3 * (len(stack.places) // 2)
        for which in range(3):  # loads balance, so what holds the pack carries nothing
            held[middle + which, middle + which] *= 2
        inverse = scipy.linalg.cho_solve(scipy.linalg.cho_factor(held), np.eye(stack.n_dofs))
        self._inverse = np.ascontiguousarray(inverse + inverse.T) / 2
        self._moved = self._given_way(b)
        flexible = self._moved @ b.T
        self._flexible = (flexible + flexible.T) / 2
        self._from_z = np.eye(2 * self.size) - self.spring * self._flexible
        openings = np.broadcast_to(
            np.asarray(stack.openings, dtype=float), (stack.count - 1, len(stack.places))
        )
        self._openings = openings.ravel()
        self._bolted = np.zeros(self.size, dtype=bool)
        if stack.bolted is not None:
            self._bolted[stack.bolted :: len(stack.places)] = True

    def _given_way(self, loads: FloatArray) -> FloatArray:
        """Displacements (..., n_dofs) of the pack held together by springs alone."""
        return np.asarray(loads @ self._inverse)

    def tied(self, loads: FloatArray, *, bonded: bool = False) -> FloatArray:
        """Displacements (n, n_dofs) of leaves that neither part nor rub, or are glued together."""
        rows = np.arange(2 * self.size if bonded else self.size)
        if not bonded and self.stack.bolted is not None:
            rows = np.r_[rows, self.size + np.flatnonzero(self._bolted)]
        gaps = loads @ self._moved.T
        left = np.zeros_like(gaps)
        left[:, rows] = gaps[:, rows]
        # what is free carries nothing: z = k d; what is tied has d = 0
        matrix = self._from_z.copy()
        matrix[rows] = self.spring * self._flexible[rows]
        right = self.spring * gaps
        right[:, rows] *= -1
        z = np.linalg.solve(matrix, right.T).T
        return np.asarray(self._given_way(loads) + z @ self._moved)

    def history(self, loads: FloatArray, driven: Driven | None = None) -> LeafHistory:
        """Step through the positions of a turn until it repeats itself.

        loads   (n, n_dofs) N, N mm, balanced, without what is driven
        driven  the force by which deflections are imposed

        Raises ContactError where no contact is found, or the turn does not repeat itself.
        """
        state = self._start()
        for turn in range(1, _TURNS + 1):
            before = state.relative[self.size :]
            states = self._followed(state, loads, driven, first=turn == 1)
            state = states[-1]
            change = float(np.abs(state.relative[self.size :] - before).max())
            scale = max(float(np.abs(s.relative[self.size :]).max()) for s in states)
            if turn > 1 and change <= _REPEATS * scale:
                return self._told(states, loads, driven, turn)
        raise ContactError(
            f"the leaves' slip does not repeat itself after {_TURNS} turns: between the ends of "
            f"the last two, {change:.3g} mm of {scale:.3g} mm differ"
        )

    def path(self, loads: FloatArray, driven: Driven | None = None) -> LeafHistory:
        """Step through positions (n,) once, from unstressed leaves. As `history`."""
        return self._told(
            self._followed(self._start(), loads, driven, first=True), loads, driven, 1
        )

    def _followed(
        self, state: _State, loads: FloatArray, driven: Driven | None, *, first: bool
    ) -> list[_State]:
        least = _FAINT * float(np.abs(loads).max())
        if driven is not None:
            least = max(least, _FAINT * float(np.abs(driven.direction).max()))
        states: list[_State] = []
        inputs = _inputs(loads, driven)
        for k, here in enumerate(inputs):
            there = here.nothing if first and k == 0 else inputs[k - 1]
            state = self._reached(state, there, here, k, least)
            states.append(state)
        return states

    def _start(self) -> _State:
        nothing = np.zeros(2 * self.size)
        return _State(
            nothing,
            0.0,
            nothing,
            np.r_[self._openings, np.zeros(self.size)],
            self._openings <= 0,
            np.ones(self.size, dtype=bool),
            np.zeros(self.size),
        )

    def _reached(self, state: _State, there: _Input, here: _Input, k: int, least: float) -> _State:
        """The state at position k from the one before, by smaller steps where one is too long."""
        for share in _SHARES:
            found = self._newton(state, here, least, share)
            if found is not None:
                return found
        for halvings in range(1, _HALVINGS + 1):
            following, missed = state, 0.0
            for way in np.arange(1, 2**halvings + 1) / 2**halvings:
                step = there.towards(here, way)
                tries = (self._newton(following, step, least, share) for share in _SHARES)
                found = next((state for state in tries if state is not None), None)
                if found is None:
                    break
                following, missed = found, max(missed, found.missed)
            else:
                return replace(following, missed=missed)
        raise ContactError(f"contact and friction of the leaves do not settle at position {k}")

    def _newton(self, last: _State, given: _Input, least: float, share: float) -> _State | None:
        """Newton's method on the laws of contact and friction; None where it does not settle.

        least  N, a force of contact that counts
        share  of the worst broken law: laws broken less stay as they are for a step
        """
        load, direction = given.load, given.direction
        m, k = self.size, self.spring
        slip_before = last.relative[m:]
        opened = np.r_[self._openings, np.zeros(m)]
        free = self._moved @ load + opened
        unit = self._moved @ direction
        way = self._given_way(direction) if direction.any() else direction
        own, stiff = float(way @ load), float(way @ direction) + given.soft
        touching = bool(np.isfinite(given.deflection))
        closed, stuck, sense = last.closed.copy(), last.stuck.copy(), last.sense.copy()
        stuck |= self._bolted
        seen: set[bytes] = set()
        for _ in range(_NEWTON_STEPS):
            matrix, right = np.zeros((2 * m + 1, 2 * m + 1)), np.zeros(2 * m + 1)
            held = np.r_[closed, closed & stuck | self._bolted]
            matrix[: 2 * m, : 2 * m] = np.where(held[:, None], k * self._flexible, self._from_z)
            matrix[: 2 * m, 2 * m] = np.where(held, k, -k) * unit
            aim = np.r_[np.zeros(m), slip_before]
            right[: 2 * m] = np.where(held, k * (aim - free), k * (free - opened))
            rows = np.flatnonzero(closed & ~stuck)
            rate = self.friction * sense[rows]
            matrix[m + rows] -= rate[:, None] * np.column_stack(
                [self._from_z[rows], -k * unit[rows]]
            )
            right[m + rows] -= rate * k * (free - opened)[rows]
            if touching:
                matrix[2 * m, : 2 * m] = k * unit
                matrix[2 * m, 2 * m] = k * stiff
                right[2 * m] = k * (given.deflection - own)
            else:
                matrix[2 * m, 2 * m] = 1.0
            found = scipy.linalg.solve(matrix, right, check_finite=False, overwrite_a=True)
            z, force = found[: 2 * m], float(found[2 * m])
            d = free + unit * force + self._flexible @ z
            c = z - k * (d - opened)
            scale = _ROUND_OFF * max(float(np.abs(c).max()), least)
            bound = self.friction * c[:m].clip(min=0)
            trial = c[m:] - k * (d[m:] - slip_before)
            next_closed = c[:m] - k * d[:m] > -scale
            next_stuck = (np.abs(trial) <= bound + scale) | self._bolted
            next_sense = np.sign(trial)
            broken = np.abs(np.minimum(c[:m], k * d[:m]))
            rubbed = np.abs(c[m:] - np.clip(trial, -bound, bound))
            rubbed[self._bolted] = 0.0
            missed = max(float(broken.max()), float(rubbed.max()))
            if missed <= scale and touching and force < 0:
                touching = False
                continue
            if missed <= scale:
                return _State(z, force, c, d, closed, stuck, sense, missed)
            closed = np.where(broken >= share * missed, next_closed, closed)
            mended = rubbed >= share * missed
            stuck = np.where(mended, next_stuck, stuck)
            sense = np.where(mended, next_sense, sense)
            key = closed.tobytes() + stuck.tobytes() + sense.tobytes()
            if key in seen:
                return None
            seen.add(key)
        return None

    def _told(
        self, states: Sequence[_State], loads: FloatArray, driven: Driven | None, turns: int
    ) -> LeafHistory:
        m, stack = self.size, self.stack
        z = np.array([s.z for s in states])
        force = np.array([s.force for s in states])
        contact = np.array([s.contact for s in states])
        relative = np.array([s.relative for s in states])
        direction = np.zeros_like(loads) if driven is None else driven.direction
        whole = loads + force[:, None] * direction
        moved = self._given_way(whole) + z @ self._moved
        left = moved @ stack.stiffness - whole - contact @ stack.relative
        left[:, 2::3] /= stack.thickness  # couples, as forces on the faces
        largest = max(float(np.abs(contact).max()), float(np.abs(whole).max()), 1e-30)
        pressures, gaps = contact[:, :m], relative[:, :m]
        shears, slips = contact[:, m:], relative[:, m:]
        steps = slips - np.roll(slips, 1, axis=0)
        shape = (len(states), stack.count - 1, len(stack.places))
        return LeafHistory(
            displacements=moved,
            stress=np.einsum("lfkd,nd->nlfk", stack.face_stress, moved),
            pressures=pressures.reshape(shape),
            shears=shears.reshape(shape),
            gaps=gaps.reshape(shape),
            slips=slips.reshape(shape),
            force=force,
            deflection=np.einsum("nd,nd->n", direction, moved),
            unbalanced=float(np.abs(left).max()) / largest,
            not_complementary=max(s.missed for s in states) / largest,
            turns=turns,
            work=float(-(shears * steps)[:, ~self._bolted].sum()),
        )
