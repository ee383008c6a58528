"""Linear buckling of a solid part with the end conditions of a link, not those of the stress hold.

The pins are hinges about their own axis: at each interface the mean displacement is held, in the
plane of the mechanism the part may turn at both ends, about its own axis it may not turn at
one. Out of plane the ends are as stiff as their forks; both bounds are computed, ends free to
tilt and ends that cannot (docs/theory/buckling.md). A pin's pressure does not turn with its bore:
its push goes through its axis.

The largest mu of -K_s x = mu K x is found, so that the load factor 1/mu is right at any size of the
load and tension gives no positive factor; that no lower one was skipped is proven by a count.

The position of a cycle that buckles first is found without solving all of them. The geometric
stiffness is linear in the unit loads. The modes of a few load states that all positions are made
of, of either sign, are displacement fields that the part could take at any; the largest mu of -K_s
x = mu K x among them, at every position, is never above the true one (Rayleigh and Ritz), and close
to it where the part buckles alike. The position where it is largest is solved next, its modes join,
until the position that looks worst has been solved. The reported factor is a solved one; that no
other position has a lower one is not proved but sought.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from fem.assembly import full, geometric_stiffness
from fem.lowest_modes import lowest_modes
from fem.mode_count import (
    LowRank,
    SupportedSolid,
    elastic_and_geometric_energy,
    geometric_forms,
    link_solid,
    surface_weights,
)
from fem.recovery import energy_error, tensor
from fem.solvers import SolverError
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_CLOSE = 0.98  # of the largest share: an estimate below that over it asks for no further position
_DEPENDENT = 1e-8  # of the largest energy: fields that say nothing new

# Bar of a factor by the estimated energy e of its mode's error, as a share of the mode's: the
# factor is too high by the error's share of the energy, which is up to 3.2 e on ordinary meshes and
# more on those that are too coarse to tell; 1 % for what rounds and holes lose between nodes.
_OF_ENERGY, _LEAST = 3.0, 0.01
_SEEN = 4  # modes whose error is estimated

# A mode that needs a larger elastic stress than this share of Young's modulus somewhere is none of
# a structure; pi^2 / slenderness^2 of a column of slenderness 5 is 0.39.
_STRESS_LIMIT = 1.0
_MOST = 6  # positions that are solved
_TIE = 1e-6  # shares that are closer are equal: the first position is named
_PATTERNS = 4  # load states whose modes are taken to begin with
_SMALL = 0.1  # of the largest state: what is left of all states counts as known


@dataclass(frozen=True, eq=False)
class BucklingMode:
    """One buckling mode.

    factor  load factor at which the part buckles elastically; > 0
    plane   "in plane" or "out of plane" of the mechanism, by where the mode moves
    shape   (n_nodes, 3) largest displacement 1
    """

    factor: float
    plane: str
    shape: FloatArray


@dataclass(frozen=True, eq=False)
class Buckling:
    """The lowest buckling modes of a load state, and what is known about others.

    modes     lowest factor first; none in tension or without load
    proven    every factor below this one is among the modes, or follows the last of them in
              steps below 0.2 %: a count by inertia says so. 0 if no count was asked for, infinite
              without load
    reversed  size of the lowest factor of the same loads turned round, None without one
    limit     the factor at which the largest stress is Young's modulus; modes above it are none
    """

    modes: tuple[BucklingMode, ...]
    proven: float
    reversed: float | None
    limit: float


def buckling_modes(
    solutions: UnitSolutions, coefficients: FloatArray, *, tilt_held: bool, count: int = 2
) -> list[BucklingMode]:
    """Return the lowest positive buckling factors of one load state, lowest first.

    As `part_buckling`, without what is known beside the modes.
    """
    found = part_buckling(solutions, coefficients, tilt_held=tilt_held, count=count)
    return list(found.modes)


def part_buckling(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    *,
    tilt_held: bool,
    twist_held_at: str | None = None,
    count: int = 2,
    prove: bool = True,
    weaker: bool = False,
) -> Buckling:
    """Return the buckling of a part held by its pins, under one load state.

    coefficients   (n_basis,) of the unit loads
    tilt_held      True if the forks hold the ends against tilting out of the plane
    twist_held_at  as `link_solid` has it
    count          how many modes are wanted at most
    prove          True if it is proven that no lower mode was skipped
    weaker         True if a proof of less will do where that fails: `proven` is then below the
                   modes

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for the tied
    bodies of a stack, whose leaves buckle by themselves, and for half of a part.
    """
    solid = link_solid(solutions, tilt_held=tilt_held, twist_held_at=twist_held_at, what="buckling")
    displacement = solutions.displacement @ coefficients
    stress = solutions.recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]
    pins = pins_pressing(solutions, coefficients)
    return solid_buckling(solid, stress, pins, count=count, prove=prove, weaker=weaker)


@dataclass(frozen=True, eq=False)
class RoundContact:
    """A bore on its pin, or a journal in its lug, under small motions u (3 n_nodes,).

    turn     (3 n_nodes,): turn @ u is the mean turn about the axis, displacement along the rim over
             the radius
    columns  of the basis, the unit loads that act here
    lost     (3 n_nodes, n_columns), N mm per unit: lost.T @ u are the moments about the moved axis,
             turned round, of loads that keep their direction and stay at their points of the part
    virials  (n_columns,), N mm per unit: the same for a turn by 1 rad, sum of (x - axis) . f
    """

    turn: FloatArray
    columns: slice
    lost: FloatArray
    virials: FloatArray


def round_contacts(solutions: UnitSolutions) -> list[RoundContact]:
    """Return the round interfaces of a part, of which a pin's pressure does not turn with it."""
    nodes, start = solutions.mesh.nodes, 0
    found = []
    for loads in solutions.interfaces:
        columns = slice(start, start + len(loads.names))
        start = columns.stop
        if "couple" not in loads.names:
            continue
        acting = solutions.loads[:, columns]
        along, across = acting[::3], acting[1::3]  # (n_nodes, n_columns)
        mean = surface_weights(solutions.elements, loads.interface.name)[:, None]
        lost = np.zeros(acting.shape)
        lost[::3] = mean * across.sum(axis=0) - across
        lost[1::3] = along - mean * along.sum(axis=0)
        arm = nodes - loads.interface.centre
        virials = arm[:, 0] @ along + arm[:, 1] @ across
        turn = acting[:, loads.names.index("couple")].copy()
        found.append(RoundContact(turn, columns, lost, virials))
    return found


def pins_pressing(solutions: UnitSolutions, coefficients: FloatArray) -> LowRank:
    """Part of the geometric stiffness by a load state's pins, turned round; N mm.

    coefficients  (n_basis,) of the unit loads

    turn lost' + lost turn' - virial turn turn' of every round interface under the state: then its
    loads have no moment about its axis (docs/theory/buckling.md).
    """
    vectors, weights = [np.zeros((len(solutions.loads), 0))], [np.zeros(0)]
    for contact in round_contacts(solutions):
        state = coefficients[contact.columns]
        lost, virial = contact.lost @ state, float(contact.virials @ state)
        ratio = float(np.linalg.norm(lost) / np.linalg.norm(contact.turn))
        if not ratio > 0.0:
            continue
        scaled = np.stack([contact.turn * np.sqrt(ratio), lost / np.sqrt(ratio)], axis=1)
        own, mix = np.linalg.eigh(np.array([[-virial / ratio, 1.0], [1.0, 0.0]]))
        vectors.append(scaled @ mix)
        weights.append(own)
    return LowRank(np.hstack(vectors), np.concatenate(weights))


def solid_buckling(
    solid: SupportedSolid,
    stress: FloatArray,
    pins: LowRank | None = None,
    *,
    count: int = 2,
    prove: bool = True,
    weaker: bool = False,
) -> Buckling:
    """Return the buckling of a supported solid under a stress state.

    stress  (n_elements, n_q, 6) at the integration points, MPa (fem.recovery)
    pins    of `pins_pressing`; None where all loads keep their direction and their points
    """
    size = float(np.abs(stress).max())
    if not size > 0:
        return Buckling((), np.inf, None, np.inf)
    unit = tensor(stress / size)
    upper = geometric_stiffness(solid.pattern, unit)
    upper.data *= -1.0
    more = None if pins is None else LowRank(pins.vectors, pins.weights / size)
    by_node = full(upper[::3][:, ::3].tocsr())  # the blocks are multiples of the identity

    def times(fields: FloatArray) -> FloatArray:
        found = np.asarray(by_node @ fields.reshape(by_node.shape[0], -1)).reshape(fields.shape)
        return found if more is None else found + more.times(fields)

    def energies(fields: FloatArray) -> tuple[FloatArray, FloatArray]:
        elastic, geometric = elastic_and_geometric_energy(
            solid.elements, solid.material, unit, fields
        )
        return elastic, -geometric if more is None else more.form(fields) - geometric

    limit = _STRESS_LIMIT * solid.material.youngs_modulus
    found = lowest_modes(
        solid,
        upper,
        times,
        energies,
        count,
        beside=more,
        limit=limit,
        prove=prove,
        weaker=weaker,
    )
    modes = tuple(
        _mode(value / size, vector)
        for value, vector in zip(found.values, found.shapes.T, strict=True)
    )
    turned = None if found.negative is None else -found.negative / size
    return Buckling(modes, found.proven / size, turned, limit / size)


def _mode(factor: float, vector: FloatArray) -> BucklingMode:
    shape = vector.reshape(-1, 3)
    shape = shape / np.abs(shape).max()
    sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, 1]).max()
    return BucklingMode(float(factor), "out of plane" if sideways else "in plane", shape)


def worst_buckling(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    starts: Sequence[int],
    *,
    tilt_held: bool,
    twist_held_at: str | None = None,
) -> tuple[int, Buckling] | None:
    """Return the position with the lowest factor found and its modes; None where none buckles.

    coefficients (n_basis, n) of the unit loads over all positions; starts: positions solved first
    """
    fields = []
    measure = solutions.basis.reshape(-1, len(coefficients))  # stress at the surface
    for state in leading_states(measure, coefficients):
        for sign in (1.0, -1.0):
            one = part_buckling(
                solutions,
                sign * state,
                tilt_held=tilt_held,
                twist_held_at=twist_held_at,
                prove=False,
            )
            fields.append(_fields(solutions, one))
    solved: dict[int, Buckling] = {}

    def solve(position: int) -> tuple[float, FloatArray]:
        found = buckling_at(
            solutions,
            coefficients[:, position],
            tilt_held=tilt_held,
            twist_held_at=twist_held_at,
        )
        solved[position] = found
        return (1 / found.modes[0].factor if found.modes else 0.0), _fields(solutions, found)

    def shares(known: FloatArray) -> FloatArray:
        return shares_of(solutions, coefficients, known)

    worst = worst_position(solve, shares, fields, starts=starts, close=_CLOSE)
    return None if worst is None else (worst[0], solved[worst[0]])


def _fields(solutions: UnitSolutions, found: Buckling) -> FloatArray:
    """Shapes (3 n_nodes, k) of the modes."""
    none = np.zeros((len(solutions.displacement), 0))
    return np.column_stack([none, *(mode.shape.ravel() for mode in found.modes)])


def mesh_bar(
    solutions: UnitSolutions,
    state: FloatArray,
    known: Sequence[BucklingMode],
    *,
    twist_held_at: str | None = None,
) -> float:
    """How much a part's share of its buckling load may be off by its mesh, over the share.

    state  (n_basis,) of the unit loads; the ends are free to tilt
    known  its lowest modes

    By the estimated error of its four lowest modes, each of which may be the lowest in truth; those
    beyond them may have twice the largest error. Where a search for four does not converge, of
    those that are known.
    """
    modes = known
    try:
        seen = part_buckling(
            solutions,
            state,
            tilt_held=False,
            twist_held_at=twist_held_at,
            count=_SEEN,
            prove=False,
        ).modes
        modes = seen if len(seen) > len(known) else known
    except SolverError:
        pass
    bars = []
    for mode in modes:
        error = min(energy_error(solutions.recovery, mode.shape.ravel()), 0.999)
        bars.append(_LEAST + _OF_ENERGY * error / (1 - error) ** 3)
    most = [(1 + bar) / mode.factor for mode, bar in zip(modes, bars, strict=True)]
    most.append((1 + 2 * max(bars)) / modes[-1].factor if len(modes) > 1 else 0.0)
    return float(max(most) * known[0].factor - 1)


def buckling_at(
    solutions: UnitSolutions,
    state: FloatArray,
    *,
    tilt_held: bool,
    twist_held_at: str | None = None,
) -> Buckling:
    """Modes of a position, proven where that can be done.

    Far beyond any stress that a metal bears, such as of a part that is pulled, modes are many and
    the search may not find what the count does: then they stand without proof (`proven` is 0).
    Raises SolverError where none is found and it is not proven that there is none.
    """
    found_with = partial(
        part_buckling, solutions, state, tilt_held=tilt_held, twist_held_at=twist_held_at
    )
    try:
        return found_with(weaker=True)
    except SolverError:
        found = found_with(prove=False)
        if not found.modes:
            raise
        return found


def shares_of(solutions: UnitSolutions, coefficients: FloatArray, fields: FloatArray) -> FloatArray:
    """Share (n,) of its lowest factor that each position's load is at least; 0 without any."""
    elements, material = solutions.elements, solutions.material
    none = np.zeros((*elements.weights.shape, 3, 3))
    energy, _ = elastic_and_geometric_energy(elements, material, none, fields)
    values, vectors = np.linalg.eigh(energy)
    kept = values > _DEPENDENT * values[-1]
    whiten = vectors[:, kept] / np.sqrt(values[kept])
    stress = solutions.recovery.quadrature_stress(solutions.displacement, slice(None))
    forms = geometric_forms(elements, stress, fields)
    for contact in round_contacts(solutions):
        turn, lost = contact.turn @ fields, contact.lost.T @ fields
        both = lost[:, :, None] * turn
        both += both.swapaxes(1, 2) - contact.virials[:, None, None] * np.outer(turn, turn)
        forms[contact.columns] -= both
    forms = whiten.T @ forms @ whiten
    states = -np.tensordot(coefficients.T, forms, axes=1)
    return np.asarray(np.linalg.eigvalsh(states)[:, -1])


def leading_states(measure: FloatArray, coefficients: FloatArray) -> list[FloatArray]:
    """Load states (n_basis,) that those of all positions are made of, to a tenth of the largest.

    What each position adds to the ones before it, the largest first.

    measure       (m, n_basis) of each unit load: a state's size is the norm of its combination
    coefficients  (n_basis, n) of the unit loads at the positions
    """
    left = np.linalg.qr(measure, mode="r") @ coefficients
    states = coefficients.copy()
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


def worst_position(
    solve: Callable[[int], tuple[float, FloatArray]],
    shares: Callable[[FloatArray], FloatArray],
    fields: Sequence[FloatArray],
    *,
    starts: Sequence[int] = (),
    close: float,
) -> tuple[int, float] | None:
    """Return the position with the largest share of its buckling load found, and the share.

    solve   a position's share of its lowest buckling load, 0 without one, and its modes (m, k)
    shares  fields (m, k) to the share (n,) that each position has at least
    fields  (m, k) each, of the leading states
    starts  positions solved first
    close   an estimate that is this near the largest share asks for no further position

    None where no position buckles.
    """
    known, solved = list(fields), dict[int, float]()
    waiting = list(dict.fromkeys(starts))
    while len(solved) < _MOST:
        if not waiting:
            together = np.hstack(known) if known else np.zeros((0, 0))
            if not together.shape[1]:
                break
            estimates = shares(together)
            estimates[list(solved)] = 0.0
            likely = int(np.argmax(estimates))
            if not close * estimates[likely] > max(solved.values(), default=0.0):
                break
            waiting.append(likely)
        position = waiting.pop(0)
        solved[position], modes = solve(position)
        known.append(modes)
    largest = max(solved.values(), default=0.0)
    if not largest > 0.0:
        return None
    worst = min(k for k, share in solved.items() if share * (1.0 + _TIE) >= largest)
    return worst, solved[worst]
