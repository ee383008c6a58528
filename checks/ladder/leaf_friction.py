"""Friction between the leaves of a pack over its cycles: what it makes of forces and stresses.

The leaves are beams that press and rub on each other (fem/contact/leaves.py), pressed by what acts
on the pack and by the preloads of its clamp and its bracket. Where a contact imposes a deflection
on the pack, its force follows from the stiffness of the leaves as they stick and slip, with all
else that gives way in the linkage. Where the design is silent, friction is 0.1 to 0.3, and the
leaves are between unpressed and held without slip in clamp and bracket (docs/theory/leaf_packs.md).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise, product
from weakref import WeakKeyDictionary

import numpy as np

import loads
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.strength.part_strength import endurance_of
from checks.stress.duty_verdict import duty_runs, duty_verdict
from fem.contact.condensed import ContactError
from fem.contact.leaves import Driven, LeafContact, LeafHistory
from fem.leaf_stack import LeafStack
from geometry.mesh import FloatArray, IntArray
from geometry.parts import LeafPack
from geometry.parts.leaf_pack import as_leaves

FRICTION = (0.1, 0.3)  # dry to greased steel on steel, where a design is silent
_GRIPPED = 1e3  # times the largest force on the pack: a preload under which nothing slips
_HALF_WAY = 1.5  # times moment over thickness: a preload under which a clamp slips in part
_STIFFER = 2.0  # times the bending stiffness: tells how much of a deflection is the pack's
_POSITIONS = 4  # of a cycle, beside its extremes
_RIVAL = 1.05  # times its expected stress against the largest: a cycle that is solved as well
# Distance of places where the pack is pressed, and elsewhere: at most so much of its clamp and arm.
_FINE, _COARSE = (0.1, 0.02), (0.5, 0.1)
_TELLING = 0.02  # of the largest force of a contact: enough to read compliances from

_Compliance = loads.BeamCompliance | loads.MatrixCompliance | loads.JointCompliance


@dataclass(frozen=True)
class Rubbing:
    """Friction between leaves: a coefficient, and the preloads of clamp and bracket, N."""

    friction: float
    clamp: float
    rod: float
    words: str


@dataclass(frozen=True)
class Rubbed:
    """Stresses of a pack with friction over those of leaves that slide freely, and its forces.

    static, fatigue   ratio of the stress that decides, by case
    forces            N, largest force of a contact by case: of leaves that slide, with friction
    missed            largest of what equilibrium and laws of contact are missed by, scaled
    cycles            that were solved
    """

    cases: tuple[Rubbing, ...]
    static: tuple[float, ...]
    fatigue: tuple[float, ...]
    forces: tuple[tuple[float, float], ...]
    missed: float
    cycles: tuple[str, ...]


def cases_of(shape: LeafPack, part_loads: PartLoads) -> tuple[Rubbing, ...]:
    """Friction and preloads that a pack is solved for: what its design leaves open.

    A clamp that is not stated is taken without preload, without slip, and slipping half way: the
    stress falls first, as the clamp takes over, and grows with the stiffness then. A bracket that
    is not stated has none, or no slip: with it, only what has been found at an end of the band is
    solved (docs/theory/leaf_packs.md).
    """
    frictions = FRICTION if shape.friction is None else (shape.friction,)
    gripped = _GRIPPED * part_loads.largest_force
    half = _HALF_WAY * float(np.abs(_moment(part_loads.wrenches)).max()) / shape.thickness

    def taken(name: str, preload: float | None, *between: float) -> list[tuple[float, str]]:
        if preload is not None:
            return [(preload, f"{preload / 1e3:g} kN on the {name}")]
        some = [(force, f"{force / 1e3:.3g} kN on the {name}") for force in between if force]
        return [(0.0, f"no preload of the {name}"), *some, (gripped, f"a {name} without slip")]

    clamps = taken("clamp", shape.clamp_preload, half)
    rods = taken("bracket", shape.rod_preload)
    wanted = list(product(frictions, clamps, rods))
    if len(rods) > 1:
        loose, held = rods
        ends = list(dict.fromkeys([clamps[0], clamps[-1]]))
        slipping = clamps[:-1] or clamps
        wanted = [
            *product(frictions, slipping, [loose]),
            *product(frictions[:1], ends, [held]),
        ]
    return tuple(
        Rubbing(friction, clamp, rod, f"friction {friction:g}, {on_clamp}, {on_rod}")
        for friction, (clamp, on_clamp), (rod, on_rod) in wanted
    )


def gives(loaded: LoadedPart, cycle: loads.CycleLoads | loads.MeasuredLoads) -> bool:
    """True if the part's body gives way in front of a contact of the cycle."""
    return (
        isinstance(cycle, loads.CycleLoads)
        and bool(cycle.touches)
        and any(
            isinstance(entry, loads.BeamCompliance | loads.MatrixCompliance)
            and entry.body == loaded.part.body
            for entry in cycle.linkage.compliance
        )
    )


@dataclass(frozen=True, eq=False)
class _Cycle:
    """A cycle at some of its positions, with leaves that slide freely.

    at        (n,) which of the cycle's positions
    wrenches  interface -> (n, 6)
    reach     (n,) mm, where the contact presses
    loads     (n, n_dofs) on the stack
    stress    (n, count, 2, 2 (k - 1)) MPa
    touched   name of the contact that imposes a deflection; "" without one
    force     (n,) N, of that contact; 0 where nothing is imposed, as in a blow, whose loads stand
    """

    at: IntArray
    wrenches: Mapping[str, FloatArray]
    reach: FloatArray
    loads: FloatArray
    stress: FloatArray
    touched: str
    force: FloatArray

    def peaks(self, stress: FloatArray) -> FloatArray:
        """Largest stress (2,) where loads are given, and where a deflection is; 0 without such."""
        each = np.abs(stress).reshape(len(stress), -1).max(axis=1)
        return np.array([each[some].max(initial=0.0) for some in (self.force == 0, self.force > 0)])


_SOLVED: WeakKeyDictionary[LoadedPart, Rubbed | str] = WeakKeyDictionary()


def rubbed(loaded: LoadedPart) -> Rubbed | str:
    """A pack's friction over the cycles that may decide, or why it is not known.

    Solved once for a loaded part, which never changes and is all that the answer depends on.
    """
    if loaded not in _SOLVED:
        try:
            _SOLVED[loaded] = _Pack(loaded).rubbed()
        except (ContactError, loads.LinkageError) as error:
            _SOLVED[loaded] = f"it cannot be solved: {error}"
    return _SOLVED[loaded]


def _slowly(loaded: LoadedPart) -> LoadedPart:
    """The part with contacts as if slowly in the cycles that swing by blows.

    There a stiffer pack carries more in proportion to its stiffness; where it swings, a speed
    imposes its force, v sqrt(k m), which grows by the root of it: the band holds that, too.
    """
    swinging = (isinstance(run, loads.CycleLoads) and run.swings for run in loaded.runs.values())
    if not any(swinging):
        return loaded
    runs = {
        name: run.slowly if isinstance(run, loads.CycleLoads) else run
        for name, run in loaded.runs.items()
    }
    return replace(loaded, runs=runs, loads=loads_on(loaded.design, loaded.part, runs))


class _Pack:
    """A loaded pack: its cycles with leaves that slide, and what is solved of them by case."""

    def __init__(self, loaded: LoadedPart) -> None:
        shape = as_leaves(loaded.part.geometry)
        assert shape is not None
        self.loaded, self.shape = _slowly(loaded), shape
        loaded = self.loaded
        self.stack = stack_of(loaded, shape)
        self.contact = LeafContact(self.stack)
        self.cycles = {name: self.cycle(name) for name in loaded.loads.cycles}
        self.driven: dict[str, Driven | None] = {}
        self.cases = cases_of(shape, loaded.loads)
        self.solved: list[dict[str, LeafHistory]] = [{} for _ in self.cases]

    def rubbed(self) -> Rubbed:
        """Solve the cycles of the duty, those stressed most with sliding leaves, and their rivals.

        A rival's stress may be the largest of a case, by the ratios to sliding that others have.
        """
        free = {name: cycle.peaks(cycle.stress) for name, cycle in self.cycles.items()}
        firsts = [name for name in free if name in self.loaded.duty.cycles]
        for k in (0, 1):
            largest = max(free, key=lambda name: float(free[name][k]))
            firsts += [largest] if free[largest][k] else []
        for case, solved in zip(self.cases, self.solved, strict=True):
            wanted = list(dict.fromkeys(firsts))
            while wanted:
                solved |= {name: self.history(name, case) for name in wanted}
                found = {name: self.cycles[name].peaks(solved[name].stress) for name in solved}
                ratios = np.max(
                    [found[name] / free[name].clip(min=1e-300) for name in found], axis=0
                )
                most = max(peaks.max() for peaks in found.values())
                wanted = [
                    name
                    for name in free
                    if name not in solved and _RIVAL * (ratios * free[name]).max() >= most
                ]
        most = max(float(peaks.max()) for peaks in free.values())
        static = [
            max(float(np.abs(history.stress).max()) for history in solved.values()) / most
            for solved in self.solved
        ]
        sliding = self.amplitude({name: cycle.stress for name, cycle in self.cycles.items()})
        fatigue = (
            static
            if not sliding
            else [
                self.amplitude({name: history.stress for name, history in solved.items()}) / sliding
                for solved in self.solved
            ]
        )
        return Rubbed(
            self.cases,
            tuple(static),
            tuple(fatigue),
            tuple(
                max(
                    (float(self.cycles[name].force.max()), float(history.force.max()))
                    for name, history in solved.items()
                )
                for solved in self.solved
            ),
            max(max(h.unbalanced, h.not_complementary) for s in self.solved for h in s.values()),
            tuple(name for name in self.cycles if any(name in solved for solved in self.solved)),
        )

    def history(self, name: str, case: Rubbing) -> LeafHistory:
        """A cycle with the friction and preloads of a case."""
        cycle, shape, stack = self.cycles[name], self.shape, self.stack
        if name not in self.driven:
            self.driven[name] = self.imposed(name) if cycle.force.any() else None
        driven, given = self.driven[name], cycle.loads
        if driven is not None:
            given = given - cycle.force[:, None] * driven.direction
        half, rod = shape.clamp_length / 2, shape.rod_length / 2
        pressed = stack.squeezed((-half, half), case.clamp)
        pressed += stack.squeezed((shape.length - rod, shape.length + rod), case.rod)
        return self.contact.history(given + pressed, case.friction, driven)

    def amplitude(self, stress: Mapping[str, FloatArray]) -> float:
        """Largest amplitude of equal safety over the duty, MPa, by cycle; 0 without a duty."""
        part, stack = self.loaded.part, self.stack
        runs, start, columns = {}, 0, []
        for name in self.loaded.duty.cycles:
            if name in stress:
                columns.append(stress[name].reshape(len(stress[name]), -1).T)
                runs[name] = slice(start, start := start + len(stress[name]))
        if not runs:
            return 0.0
        x = np.tile(stack.stress_places, 2 * stack.count)
        clamped = np.abs(x) <= self.shape.clamp_length / 2 + 1e-9
        limit = endurance_of(part).value
        limits = limit / np.where(clamped, self.shape.clamp_factor, 1.0)
        basis = np.zeros((len(x), 6, start))
        basis[:, 0] = np.concatenate(columns, axis=1)
        ultimate, paths = part.material.ultimate_stress, duty_runs(runs, runs)
        found = duty_verdict(basis, np.eye(start), limits, limit, ultimate, paths)
        assert found is not None
        return found.peak.value

    def cycle(self, name: str) -> _Cycle:
        """A cycle with leaves that slide freely."""
        acting, run = self.loaded.loads, self.loaded.runs[name]
        columns = acting.cycles[name]
        wrenches = {key: wrench[columns] for key, wrench in acting.wrenches.items()}
        at = _chosen(_moment(wrenches), run)
        wrenches = {key: wrench[at] for key, wrench in wrenches.items()}
        reach = np.full(len(at), -(self.shape.contact_from + self.shape.contact_to) / 2)
        if "contact" in acting.reaches:
            reach = acting.reaches["contact"][columns][at]
        own = self.on_stack(wrenches, wrenches, reach)
        touched, force = "", np.zeros(len(at))
        if gives(self.loaded, run):
            assert isinstance(run, loads.CycleLoads)
            (touched,) = run.touches
            pressed = np.where(loads.moments_of_blows(run), 0.0, np.abs(run.efforts[touched]))
            force = pressed[at]
        stress = self.stack.stress(self.contact.tied(own))
        return _Cycle(at, wrenches, reach, own, stress, touched, force)

    def imposed(self, name: str) -> Driven:
        """The deflection by a contact that leaves that slide have, at each position."""
        cycle = self.cycles[name]
        unit, share = _per_force(self.loaded, name, cycle.touched, cycle.at)
        direction = self.on_stack(unit, cycle.wrenches, cycle.reach)
        slid = self.contact.tied(direction)
        soft = share * np.einsum("nd,nd->n", direction, slid)
        imposed = np.einsum("nd,nd->n", slid, cycle.loads) + soft * cycle.force
        return Driven(direction, np.where(cycle.force > 0, imposed, np.nan), soft)

    def on_stack(
        self,
        wrenches: Mapping[str, FloatArray],
        like: Mapping[str, FloatArray],
        reach: FloatArray,
    ) -> FloatArray:
        """Balanced loads (n, n_dofs) of wrenches on the faces that those of `like` push on.

        reach  (n,) mm, where the contact presses
        """
        shape, stack, still = self.shape, self.stack, np.zeros(1)
        found = np.zeros((len(reach), stack.n_dofs))
        for name, centres, length, arms in (
            ("pivot", still, shape.clamp_length, still),
            ("rod", still + shape.length, shape.rod_length, still),
            ("contact", reach, shape.contact_length, reach),
        ):
            spans = [(x - length / 2, x + length / 2) for x in centres.tolist()]
            even = np.array([stack.spread(span, 1.0, 0.0) for span in spans])
            turning = np.array([stack.spread(span, 0.0, 1.0) for span in spans])
            sizes, pushed = (
                w[:, 1, None] * even + (w[:, 5] - arms * w[:, 1])[:, None] * turning
                for w in (wrenches[name], like[name])
            )
            found += stack.on_faces(sizes, pushed)
            along = wrenches[name][:, :1] * even / stack.count
            for leaf in range(stack.count):
                found[:, stack.dof(leaf, 0)] += along
        return stack.balanced(found)


def stack_of(loaded: LoadedPart, shape: LeafPack) -> LeafStack:
    """The pack's leaves as beams, with places where it is pressed and at the bolt."""
    half, rod, tip = shape.clamp_length / 2, shape.rod_length / 2, shape.contact_length / 2
    fine, coarse = (
        min(of_clamp * shape.clamp_length, of_arm * shape.arm)
        for of_clamp, of_arm in (_FINE, _COARSE)
    )
    stops = [
        (-shape.arm, coarse),
        (-shape.contact_to - tip, fine),
        (-shape.contact_from + tip, coarse),
        (-half, fine),
        (0.0, fine),
        (half, coarse),
        (shape.length - rod, 2 * fine),
        (shape.length + rod, coarse),
        (shape.length + shape.overhang, 0.0),
    ]
    places = [stops[0][0]]
    for (start, size), (end, _) in pairwise(stops):
        if end - start > 1e-6 * shape.thickness:
            pieces = max(1, round(np.ceil((end - start) / size - 1e-9)))
            places += list(np.linspace(start, end, pieces + 1)[1:])
    found = np.array(places)
    return LeafStack(
        found,
        int(shape.leaves),
        shape.width,
        shape.thickness,
        loaded.part.material.youngs_modulus,
        loaded.part.material.poisson_ratio,
        bolted=int(np.abs(found).argmin()),
    )


def _moment(wrenches: Mapping[str, FloatArray]) -> FloatArray:
    """Moment (n,) of the contact about the pivot, N mm."""
    return np.asarray(wrenches["contact"][:, 5])


def _chosen(moment: FloatArray, run: loads.CycleLoads | loads.MeasuredLoads) -> IntArray:
    """Positions of a cycle, its extremes and both sides of its contacts' ends among them."""
    n = len(moment)
    found = set(np.linspace(0, n - 1, min(n, _POSITIONS)).round().astype(int).tolist())
    found |= {int(moment.argmax()), int(moment.argmin()), int(np.abs(moment).argmin())}
    if isinstance(run, loads.CycleLoads):
        for touched, touch in run.touches.items():
            ends = np.flatnonzero(touch.touching[1:] != touch.touching[:-1])
            found |= set(ends.tolist()) | set((ends + 1).tolist())
            found.add(int(np.abs(run.efforts[touched]).argmax()))
    return np.array(sorted(found))


def _per_force(
    loaded: LoadedPart, name: str, touched: str, chosen: IntArray
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Wrenches per unit of a contact's force, and what else gives way over what the pack does.

    From the cycle solved once more with a stiffer pack. The deflection of a force F that lifts the
    linkage by `lift` is F (rest + pack) = -lift.
    """
    whole, columns = loaded.runs[name], loaded.loads.cycles[name]
    assert isinstance(whole, loads.CycleLoads)
    kept = np.flatnonzero(~loads.moments_of_blows(whole))
    run = loads.at_rows(whole, kept)
    linkage = replace(
        run.linkage,
        compliance=tuple(_stiffer(entry, loaded.part.body) for entry in run.linkage.compliance),
    )
    other = loads.run_at_positions(run, linkage, loaded.design.cycles[name].run)
    wrenches = loads_on(loaded.design, loaded.part, {name: other}).wrenches
    force, again = np.abs(run.efforts[touched]), np.abs(other.efforts[touched])
    telling = np.flatnonzero((force > _TELLING * force.max()) & (again > _TELLING * again.max()))
    if not len(telling):
        raise loads.LinkageError(
            f"{name}: its contact hardly presses, so that the pack's share of what gives way is "
            "not known"
        )
    change = (again - force)[telling, None]
    rates = {
        key: (wrenches[key] - wrench[columns][kept])[telling] / change
        for key, wrench in loaded.loads.wrenches.items()
    }
    ways = [
        -cycle.touches[touched].lift[telling] / size[telling]
        for cycle, size in ((run, force), (other, again))
    ]
    own = (ways[0] - ways[1]) / (1 - 1 / _STIFFER)
    share = np.maximum(ways[0] / own - 1, 0.0)

    def at(values: FloatArray) -> FloatArray:
        return np.asarray(np.interp(chosen, kept[telling], values))

    unit = {key: np.stack([at(row) for row in rate.T], axis=1) for key, rate in rates.items()}
    return unit, at(share)


def _stiffer(entry: _Compliance, body: str | None) -> _Compliance:
    """A compliance of the body as if it bent less; others as they are."""
    if isinstance(entry, loads.JointCompliance) or entry.body != body:
        return entry
    if isinstance(entry, loads.MatrixCompliance):
        return replace(entry, matrix=entry.matrix / _STIFFER)
    return replace(entry, bending=None if entry.bending is None else _STIFFER * entry.bending)
