"""Friction between the leaves of a pack over its cycles: what it makes of forces and stresses.

The leaves are beams that press and rub on each other (fem/contact/leaves.py), pressed by what acts
on the pack and by the preloads of its clamp and its bracket. Where a contact imposes a deflection
on the pack, its force follows from the stiffness of the leaves as they stick and slip, with all
else that gives way in the linkage. Where the design is silent, friction is 0.1 to 0.3, and the
leaves are between unpressed and held without slip in clamp and bracket (docs/theory/leaf_packs.md).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import pairwise, product

import numpy as np

import loads
from checks.models.checked import rung_level
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.stress.part_model import RungLevel, RungModel
from fem.contact.leaves import Driven, LeafContact, LeafHistory, LeafStack
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, IntArray
from geometry.parts import LeafPack
from geometry.parts.leaf_pack import as_leaves

FRICTION = (0.1, 0.3)  # dry to greased steel on steel, where a design is silent
_GRIPPED = 1e3  # times the largest force on the pack: a preload under which nothing slips
_HALF_WAY = 1.5  # times moment over thickness: a preload under which a clamp slips in part
_STIFFER = 2.0  # times the bending stiffness: tells how much of a deflection is the pack's
_POSITIONS = 24  # of a cycle, beside its extremes
_LIKELY = 0.8  # of the largest stress: cycles that friction may bring to the top
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
    """

    cases: tuple[Rubbing, ...]
    static: tuple[float, ...]
    fatigue: tuple[float, ...]
    forces: tuple[tuple[float, float], ...]
    missed: float
    cycles: tuple[str, ...]
    positions: int


def cases_of(shape: LeafPack, part_loads: PartLoads) -> tuple[Rubbing, ...]:
    """Friction and preloads that a pack is solved for: what its design leaves open.

    A clamp that is not stated is taken without preload, without slip, and slipping half way: the
    stress falls first, as the clamp takes over, and grows with the stiffness then.
    """
    frictions = FRICTION if shape.friction is None else (shape.friction,)
    gripped = _GRIPPED * part_loads.largest_force
    half = _HALF_WAY * float(np.abs(_moment(part_loads, slice(None))).max()) / shape.thickness

    def taken(name: str, preload: float | None, between: float) -> list[tuple[float, str]]:
        if preload is not None:
            return [(preload, f"{preload / 1e3:g} kN on the {name}")]
        some = [(between, f"{between / 1e3:.3g} kN on the {name}")] if between else []
        return [(0.0, f"no preload of the {name}"), *some, (gripped, f"a {name} without slip")]

    clamps = taken("clamp", shape.clamp_preload, half)
    rods = taken("bracket", shape.rod_preload, 0.0)
    found = []
    for friction, clamp, rod in product(frictions, clamps, rods):
        if friction != frictions[0] and rod[0] == gripped:
            continue  # what slips elsewhere then makes little difference
        words = f"friction {friction:g}, {clamp[1]}, {rod[1]}"
        found.append(Rubbing(friction, clamp[0], rod[0], words))
    return tuple(found)


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


_KEPT = 8
_KNOWN: dict[bytes, Rubbed] = {}


def rubbed(loaded: LoadedPart) -> Rubbed:
    """Solve a pack's friction over the cycles that may decide; equal packs are not solved again.

    Raises ContactError or loads.LinkageError where no contact is found.
    """
    key = _key(loaded)
    if key not in _KNOWN:
        while len(_KNOWN) >= _KEPT:
            del _KNOWN[next(iter(_KNOWN))]
        _KNOWN[key] = _solved(loaded)
    return _KNOWN[key]


def _key(loaded: LoadedPart) -> bytes:
    """Digest of all that a pack's friction depends on: part, duty, loads, and what gives way."""
    part, acting = loaded.part, loaded.loads
    giving = [
        (name, run.linkage.compliance if isinstance(run, loads.CycleLoads) else ())
        for name, run in loaded.runs.items()
    ]
    design = loaded.design.sha256, loaded.design.overrides, loaded.duty
    stated = design, part.geometry, part.material, part.surface, part.reliability, giving
    found = sha256(repr((stated, sorted(acting.cycles.items(), key=str))).encode())
    for arrays in (acting.wrenches, acting.reaches):
        for name in sorted(arrays):
            found.update(np.ascontiguousarray(arrays[name]).tobytes())
    found.update(np.ascontiguousarray(acting.accelerations).tobytes())
    return found.digest()


@dataclass(frozen=True, eq=False)
class _Cycle:
    """A cycle's loads on the stack at some of its positions.

    columns  (n,) positions of the part's loads
    loads    (n, n_dofs), with `force` (n,) N of its contact in them; 0 without one
    driven   what the contact imposes; None without one
    """

    name: str
    columns: IntArray
    loads: FloatArray
    force: FloatArray
    driven: Driven | None

    def given(self) -> FloatArray:
        """Loads without those of the contact."""
        if self.driven is None:
            return self.loads
        return self.loads - self.force[:, None] * self.driven.direction


def _solved(loaded: LoadedPart) -> Rubbed:
    shape = as_leaves(loaded.part.geometry)
    assert shape is not None
    stack = stack_of(loaded, shape)
    cases = cases_of(shape, loaded.loads)
    contact = LeafContact(stack)
    names = _likely(loaded, stack)
    done: dict[str, tuple[FloatArray, list[LeafHistory], _Cycle]] = {}
    while True:
        for name in names:
            cycle = _cycle(loaded, stack, contact, name)
            free = stack.stress(contact.tied(cycle.loads))
            histories = [
                contact.history(
                    cycle.given() + _pressed(stack, shape, case), case.friction, cycle.driven
                )
                for case in cases
            ]
            done[name] = (free, histories, cycle)
        levels = [_level(loaded, stack, shape, done, k) for k in range(-1, len(cases))]
        static = [level.peak.value / levels[0].peak.value for level in levels[1:]]
        names = _beaten(loaded, stack, done, levels)
        if not names:
            break
    fatigue = [
        static[k]
        if level.fatigue is None or levels[0].fatigue is None or not levels[0].fatigue.value
        else level.fatigue.value / levels[0].fatigue.value
        for k, level in enumerate(levels[1:])
    ]
    driven = [(cycle, h) for _, h, cycle in done.values() if cycle.driven is not None]
    return Rubbed(
        cases,
        tuple(static),
        tuple(fatigue),
        tuple(
            max(
                ((float(cycle.force.max()), float(h[k].force.max())) for cycle, h in driven),
                default=(0.0, 0.0),
            )
            for k in range(len(cases))
        ),
        max(max(h.unbalanced, h.not_complementary) for _, hs, _ in done.values() for h in hs),
        tuple(done),
        sum(len(cycle.columns) for _, _, cycle in done.values()),
    )


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


def _pressed(stack: LeafStack, shape: LeafPack, case: Rubbing) -> FloatArray:
    half, rod = shape.clamp_length / 2, shape.rod_length / 2
    return stack.squeezed((-half, half), case.clamp) + stack.squeezed(
        (shape.length - rod, shape.length + rod), case.rod
    )


def _likely(loaded: LoadedPart, stack: LeafStack) -> list[str]:
    """Cycles of the duty, and those in which the free pack is stressed nearly most."""
    sizes = {name: _size(loaded, columns) for name, columns in loaded.loads.cycles.items()}
    most = max(sizes.values())
    return [
        name for name, size in sizes.items() if size >= _LIKELY * most or name in loaded.duty.cycles
    ]


def _size(loaded: LoadedPart, columns: slice) -> float:
    """Largest bending moment of the contact about the pivot, N mm."""
    return float(np.abs(_moment(loaded.loads, columns)).max())


def _moment(part_loads: PartLoads, columns: slice) -> FloatArray:
    return np.asarray(part_loads.wrenches["contact"][columns, 5])


def _beaten(
    loaded: LoadedPart,
    stack: LeafStack,
    done: Mapping[str, tuple[FloatArray, list[LeafHistory], _Cycle]],
    levels: list[RungLevel],
) -> list[str]:
    """Cycles left out that may be stressed most with friction, by the ratios found elsewhere."""
    sizes = {name: _size(loaded, columns) for name, columns in loaded.loads.cycles.items()}
    touching = {name for name in sizes if gives(loaded, loaded.runs[name])}
    most = max(sizes[name] for name in done)
    found = []
    for name in sizes.keys() - done.keys():
        alike = [other for other in done if (other in touching) == (name in touching)]
        ratio = max(
            (
                float(np.abs(h.stress).max() / np.abs(done[other][0]).max())
                for other in alike
                for h in done[other][1]
            ),
            default=np.inf,
        )
        least = min(level.peak.value for level in levels[1:]) / levels[0].peak.value
        if sizes[name] * ratio >= least * most:
            found.append(name)
    return sorted(found)


def _cycle(loaded: LoadedPart, stack: LeafStack, sliding: LeafContact, name: str) -> _Cycle:
    part_loads = loaded.loads
    columns = part_loads.cycles[name]
    run = loaded.runs[name]
    chosen = _chosen(_moment(part_loads, columns), run)
    at = columns.start + chosen
    shape = as_leaves(loaded.part.geometry)
    assert shape is not None
    wrenches = {key: w[at] for key, w in part_loads.wrenches.items()}
    reach = _reach(part_loads, shape)[at]
    own = stack.balanced(_on_stack(stack, shape, wrenches, wrenches, reach))
    force, driven = np.zeros(len(at)), None
    if gives(loaded, run):
        assert isinstance(run, loads.CycleLoads)
        (touched,) = run.touches
        force = np.abs(run.efforts[touched][chosen])
        unit, share = _per_force(loaded, name, touched, chosen)
        direction = stack.balanced(_on_stack(stack, shape, unit, wrenches, reach))
        free = sliding.tied(own)
        stiff = np.einsum("nd,nd->n", direction, sliding.tied(direction))
        soft = share * stiff
        imposed = np.einsum("nd,nd->n", direction, free) + soft * force
        imposed[force == 0] = np.nan
        driven = Driven(direction, imposed, soft)
    return _Cycle(name, at, own, force, driven)


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


def _reach(part_loads: PartLoads, shape: LeafPack) -> FloatArray:
    """Where the contact presses, x in mm (n,)."""
    middle = np.full(len(part_loads.accelerations), -(shape.contact_from + shape.contact_to) / 2)
    return part_loads.reaches.get("contact", middle)


def _on_stack(
    stack: LeafStack,
    shape: LeafPack,
    wrenches: Mapping[str, FloatArray],
    like: Mapping[str, FloatArray],
    reach: FloatArray,
) -> FloatArray:
    """Loads (n, n_dofs) of wrenches on the faces of the leaves that those of `like` push on."""
    half, rod, tip = shape.clamp_length / 2, shape.rod_length / 2, shape.contact_length / 2
    result = np.zeros((len(reach), stack.n_dofs))
    for k, x in enumerate(reach):
        for name, span in (
            ("pivot", (-half, half)),
            ("rod", (shape.length - rod, shape.length + rod)),
            ("contact", (float(x) - tip, float(x) + tip)),
        ):
            own, other = wrenches[name][k], like[name][k]
            arm = (span[0] + span[1]) / 2 if name == "contact" else 0.0
            sizes, pushed = (stack.spread(span, w[1], w[5] - arm * w[1]) for w in (own, other))
            result[k] += stack.on_faces(sizes, pushed)
            along = stack.spread(span, own[0], 0.0) / stack.count
            for leaf in range(stack.count):
                result[k, stack.dof(leaf, 0)] += along
    return result


def _per_force(
    loaded: LoadedPart, name: str, touched: str, chosen: IntArray
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Wrenches per unit of a contact's force, and what else gives way over what the pack does.

    From the cycle solved once more with a stiffer pack. The deflection of a force F that lifts the
    linkage by `lift` is F (rest + pack) = -lift.
    """
    run = loaded.runs[name]
    assert isinstance(run, loads.CycleLoads)
    other = _stiffened(loaded, name)
    part_loads = loads_on(loaded.design, loaded.part, {name: other})
    columns = loaded.loads.cycles[name]
    force, again = np.abs(run.efforts[touched]), np.abs(other.efforts[touched])
    there = np.interp(run.times, other.times, again)
    both = _telling(force) & (np.interp(run.times, other.times, _telling(again)) == 1)
    if not both.any():
        raise loads.LinkageError(
            f"{name}: its contact hardly presses, so that the pack's share of what gives way is "
            "not known"
        )
    at, change = run.times[both], (there - force)[both]
    times = run.times[chosen]
    unit = {}
    for key, wrench in loaded.loads.wrenches.items():
        second = part_loads.wrenches[key]
        rate = [
            (np.interp(at, other.times, second[:, j]) - wrench[columns][both, j]) / change
            for j in range(6)
        ]
        unit[key] = np.stack([np.interp(times, at, row) for row in rate], axis=1)
    ways = [
        np.interp(at, cycle.times, -cycle.touches[touched].lift) / size[both]
        for cycle, size in ((run, force), (other, there))
    ]
    own = (ways[0] - ways[1]) / (1 - 1 / _STIFFER)
    share = np.maximum(ways[0] / own - 1, 0.0)
    return unit, np.asarray(np.interp(times, at, share))


def _telling(force: FloatArray) -> FloatArray:
    return np.asarray(force > _TELLING * force.max(initial=0.0))


def _stiffened(loaded: LoadedPart, name: str) -> loads.CycleLoads:
    """Solve a cycle again with a body that bends less."""
    cycle = loaded.runs[name]
    assert isinstance(cycle, loads.CycleLoads)

    def stiffer(entry: _Compliance) -> _Compliance:
        if isinstance(entry, loads.JointCompliance) or entry.body != loaded.part.body:
            return entry
        if isinstance(entry, loads.MatrixCompliance):
            return replace(entry, matrix=entry.matrix / _STIFFER)
        bending = None if entry.bending is None else _STIFFER * entry.bending
        return replace(entry, bending=bending)

    linkage = replace(
        cycle.linkage, compliance=tuple(stiffer(entry) for entry in cycle.linkage.compliance)
    )
    return loads.run_cycle(linkage, loaded.design.cycles[name].run)


def _level(
    loaded: LoadedPart,
    stack: LeafStack,
    shape: LeafPack,
    done: Mapping[str, tuple[FloatArray, list[LeafHistory], _Cycle]],
    case: int,
) -> RungLevel:
    """Stress of the beams' faces over the solved positions, judged; case -1 slides freely."""
    slices, columns, stresses, start = {}, [], [], 0
    for name, (free, histories, cycle) in done.items():
        stresses.append(free if case < 0 else histories[case].stress)
        columns.append(cycle.columns)
        slices[name] = slice(start, start + len(cycle.columns))
        start += len(cycle.columns)
    stress = np.concatenate(stresses).reshape(start, -1).T
    part_loads = _at(loaded.loads, np.concatenate(columns), slices)
    n = len(stress)
    heights = (np.arange(stack.count) - stack.count / 2) * stack.thickness
    y = np.repeat(
        np.stack([heights, heights + stack.thickness], axis=1).ravel(), len(stack.stress_places)
    )
    x = np.tile(stack.stress_places, 2 * stack.count)
    basis = np.zeros((n, 6, n))
    basis[:, 0] = np.eye(n)
    model = RungModel(
        rung="leaves that rub",
        history=StressHistory(np.arange(n), np.stack([x, y, np.zeros(n)], axis=1), basis, stress),
        places=["leaf"] * n,
        fretting=np.where(np.abs(x) <= shape.clamp_length / 2 + 1e-9, shape.clamp_factor, 1.0),
        numerical=0.0,
        residual=0.0,
        deflection=0.0,
        buckling=None,
        neglects="",
        units=[("stress", "MPa")] * n,
    )
    return rung_level(loaded.under(part_loads), model)


def _at(part_loads: PartLoads, columns: IntArray, slices: Mapping[str, slice]) -> PartLoads:
    """Loads at some positions only."""
    stretch, path = part_loads.stretch_of, part_loads.path
    return replace(
        part_loads,
        wrenches={name: w[columns] for name, w in part_loads.wrenches.items()},
        accelerations=part_loads.accelerations[columns],
        cycles=slices,
        labels=tuple(part_loads.labels[k] for k in columns),
        cycle_names=tuple(part_loads.cycle_names[k] for k in columns),
        reaches={name: r[columns] for name, r in part_loads.reaches.items()},
        stretch_of=None if stretch is None else stretch[columns],
        path=None if path is None else path[columns],
        doubts=(),
        spins={name: s[columns] for name, s in part_loads.spins.items()},
    )
