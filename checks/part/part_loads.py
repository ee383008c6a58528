"""The loads of one part over every cycle of a design, one behind the other, in its own axes.

A `Placing` is where a part stands in its body's frame, and turns the body's loads into its axes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import atan2, cos, hypot, pi, sin

import numpy as np

import loads
from checks.design.data import Cycle, Design, Part
from checks.design.model import StackEntry
from checks.handbook.fits import LARGEST, LEAST, PressFit
from checks.result.words import INTERFERENCE
from geometry.closed_form import closed_body
from geometry.mesh import BoolArray, FloatArray, IntArray, Interface, MassProperties

_LARGEST = 1e33  # N, N mm; squares and cubes of what is larger leave the range of numbers
_MEASURED_FRICTION = 0.3  # coefficient up to which couples of a file count as a pin's friction
_BESIDE = pi / 90  # rad, to which directions of forces in a bore are told apart
_HARDLY = 1e-3  # of a bore's largest force: what presses less has no direction
_OWN_INERTIA = 0.05  # of a pin's largest force: less of weight and inertia does not bend it
Runs = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
TIE = 1e-9  # values that are closer than this, of the largest, are equal


@dataclass(frozen=True)
class Placing:
    """Where a part's frame stands in its body's frame.

    origin  mm, of the part's first interface in the body's frame
    angle   rad, from the body's x axis to the part's
    shifts  mm, interface -> from its point of the linkage to where the part has it, in the part's
            frame
    """

    origin: tuple[float, float]
    angle: float
    shifts: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def to_body(self, properties: MassProperties) -> tuple[float, tuple[float, float], float]:
        """Mass, centre in the body's frame and inertia of a part's mass properties."""
        x, y = properties.centre[:2]
        c, s = cos(self.angle), sin(self.angle)
        centre = (self.origin[0] + c * x - s * y, self.origin[1] + s * x + c * y)
        return properties.mass, centre, properties.inertia

    def reaches(self, history: loads.LoadHistory) -> dict[str, FloatArray]:
        """Where sliding contacts are, (n,) mm along the part's x from the interface's point.

        Raises loads.LinkageError for a contact that does not run along the part's x axis.
        """
        c, s = cos(self.angle), sin(self.angle)
        found = {}
        for k, name in enumerate(history.interfaces):
            x, y = history.reaches[:, k].T
            if not (x.any() or y.any()):
                continue
            found[name] = c * x + s * y
            across = -s * x + c * y
            if np.abs(across).max() > 1e-6 * np.abs(found[name]).max():
                raise loads.LinkageError(
                    f"the contact at {name!r} does not run along the part's x axis: it leaves it "
                    f"by {np.abs(across).max():.4g} mm"
                )
        return found

    def to_part(self, history: loads.LoadHistory) -> tuple[dict[str, FloatArray], FloatArray]:
        """Wrenches (n, 6) per interface and accelerations (n, 4) in the part's own frame."""
        c, s = cos(self.angle), sin(self.angle)
        wrenches = {}
        for k, name in enumerate(history.interfaces):
            wrench = history.wrenches[:, k].copy()
            x, y = wrench[:, 0].copy(), wrench[:, 1].copy()
            wrench[:, 0], wrench[:, 1] = c * x + s * y, -s * x + c * y
            along, across = self.shifts.get(name, (0.0, 0.0))
            wrench[:, 5] -= along * wrench[:, 1] - across * wrench[:, 0]
            wrenches[name] = wrench
        a_x, a_y, alpha, omega2 = history.accelerations.T
        x0, y0 = self.origin
        x = a_x - alpha * y0 - omega2 * x0
        y = a_y + alpha * x0 - omega2 * y0
        return wrenches, np.stack([c * x + s * y, -s * x + c * y, alpha, omega2], axis=1)


@dataclass(frozen=True, eq=False)
class Doubt:
    """Something that is not known of the loads, by what the runs are at its ends.

    words  the doubt, for a reader
    ends   all runs of the design, at the same positions, at each end of the doubt
    speed  True for one about the drive's speed, which multiplies no load by more than 2
    """

    words: str
    ends: tuple[Runs, ...]
    speed: bool = False


@dataclass(frozen=True, eq=False)
class PartDoubt:
    """A doubt, by the loads of one part at its ends."""

    words: str
    ends: tuple["PartLoads", ...]


@dataclass(frozen=True, eq=False)
class PartLoads:
    """Loads on a part at all positions of all cycles.

    wrenches       interface -> (n, 6) N, N mm
    accelerations  (n, 4)
    reaches        interface on which a contact slides -> (n,) mm along x from its centre
    tilt_held_at   interface that takes the couples out of the plane, also those of inertia
    cycles         name -> slice of the n positions
    labels         (n,) where in which cycle, in words
    stretch_of     (n,) stretch of its cycle that each position is in: a phase, or what of it lies
                   between the beginnings and ends of contacts and where friction reverses or
                   rests; at its border the loads may jump; None where every cycle is one stretch
    spins          interface of a pin -> (n,) rad/s, of what turns there against the pin; NaN in
                   measured runs
    path           (n,) coordinate along which the positions of cycles lie, mm or rad; NaN in
                   measured runs; None where it is not known
    doubts         what the loads may be instead
    own_swing      mm along x -> (n,) N across, there: inertia of the part as it bends, beyond its
                   accelerations', in balance by itself
    press_fits     bore -> the bush that is pressed into it, for good
    arc            rad, on which pins press in bores by formula
    rubs           M/(r F) of a bore's friction couple M, radius r and largest force F: its largest,
                   and half of its range with 0 in it; stress that it adds is a doubt (load_doubts)
    """

    wrenches: Mapping[str, FloatArray]
    accelerations: FloatArray
    cycles: Mapping[str, slice]
    labels: tuple[str, ...]
    cycle_names: tuple[str, ...]
    reaches: Mapping[str, FloatArray] = field(default_factory=dict)
    tilt_held_at: str | None = None
    stretch_of: IntArray | None = None
    path: FloatArray | None = None
    doubts: tuple[PartDoubt, ...] = ()
    spins: Mapping[str, FloatArray] = field(default_factory=dict)
    own_swing: Mapping[float, FloatArray] = field(default_factory=dict)
    press_fits: Mapping[str, PressFit] = field(default_factory=dict)
    arc: float = pi
    rubs: tuple[float, float] = (0.0, 0.0)

    @property
    def steps(self) -> IntArray:
        """Positions (m,) after which the loads go on to the next one without a jump."""
        names = np.array(self.cycle_names)
        smooth = names[1:] == names[:-1]
        if self.stretch_of is not None:
            smooth &= self.stretch_of[1:] == self.stretch_of[:-1]
        return np.flatnonzero(smooth)

    def pressed(self, bore: Interface, places: FloatArray, arc: float) -> BoolArray:
        """Which of some places (n, 3) around a bore its pin presses at any position, by angle.

        arc  rad, on which it presses; _BESIDE more counts on either side
        """
        force = self.wrenches[bore.name][:, :2]
        size = np.hypot(*force.T)
        ways = np.arctan2(*force[size > _HARDLY * size.max(initial=0.0)].T[::-1])
        ways = np.unique(np.round(ways / _BESIDE)) * _BESIDE  # half a step off at the most
        away = places[:, :2] - bore.centre[:2]
        turn = np.arctan2(*away.T[::-1])[:, None] - ways
        off = np.abs((turn + pi) % (2 * pi) - pi)
        return np.asarray((off < arc / 2 + 1.5 * _BESIDE).any(axis=1))

    @property
    def largest_force(self) -> float:
        """The largest force on any interface, N."""
        return max(
            float(np.hypot(wrench[:, 0], wrench[:, 1]).max()) for wrench in self.wrenches.values()
        )

    @property
    def is_nothing(self) -> bool:
        """True if no force, couple, weight, inertia or pressed bush acts at any position."""
        wrenches = (wrench.any() for wrench in self.wrenches.values())
        return not (self.accelerations.any() or any(wrenches) or self.press_fits)

    def within(self, before: "PartLoads", share: float) -> bool:
        """True if no load differs by more than a share of its largest value before."""
        pairs = [(self.accelerations, before.accelerations)]
        for name, wrench in self.wrenches.items():
            was = before.wrenches[name]
            pairs += [(wrench[:, :3], was[:, :3]), (wrench[:, 3:], was[:, 3:])]
        pairs += [(reach, before.reaches[name]) for name, reach in self.reaches.items()]
        return all(
            now.shape == was.shape
            and np.abs(now - was).max(initial=0.0) <= share * np.abs(was).max(initial=0.0)
            for now, was in pairs
        )

    def resultant(self, interface: str) -> FloatArray:
        """Size (n,) of the force on an interface, N."""
        wrench = self.wrenches[interface]
        return np.asarray(np.hypot(wrench[:, 0], wrench[:, 1]))


def shown_position(cycle: Cycle, values: FloatArray) -> FloatArray:
    """Positions as reports show them."""
    shown = values if cycle.shown is None else cycle.shown.sign * (values - cycle.shown.zero)
    return np.degrees(shown) if cycle.run.coordinate.angular else shown


def shown_name(cycle: Cycle) -> tuple[str, str]:
    """Name and unit of the shown position."""
    name = cycle.shown.name if cycle.shown else cycle.run.coordinate.label
    return name, "deg" if cycle.run.coordinate.angular else "mm"


def shown_of(
    design: Design, name: str, cycle: loads.CycleLoads | loads.MeasuredLoads
) -> tuple[str, str, FloatArray]:
    """Name, unit and values of a cycle's positions as reports show them."""
    if isinstance(cycle, loads.MeasuredLoads):
        turned = cycle.position_unit == "deg"
        values = np.degrees(cycle.positions) if turned else cycle.positions
        return cycle.position_name, cycle.position_unit, values
    stated = design.cycles[name]
    return *shown_name(stated), shown_position(stated, cycle.positions)


def is_loaded(part: Part, cycle: loads.CycleLoads | loads.MeasuredLoads) -> bool:
    """True if a cycle has loads on a part; a measured run may leave bodies out."""
    if isinstance(cycle, loads.CycleLoads):
        return True
    if part.body is not None:
        return part.body in cycle.bodies
    return any(
        load.point == part.joint
        for name in part.interfaces
        if name in cycle.bodies
        for load in cycle.bodies[name].loads
    )


def loads_on(design: Design, part: Part, solved: Runs, doubts: Sequence[Doubt] = ()) -> PartLoads:
    """Gather a part's loads over the solved cycles and the measured runs that have any.

    All of them, inertia included, are multiplied by the design's load factor, which leaves them in
    equilibrium.

    doubts  what the runs may be instead

    Raises loads.LinkageError where a force meets the part at no interface, or nothing loads it.
    """
    placing = part_placing(design, part)
    wrenches: dict[str, list[FloatArray]] = {}
    reaches: dict[str, list[FloatArray]] = {}
    handed: dict[str, list[FloatArray]] = {}
    labels: list[str] = []
    accelerations, names, stretch_of, path = [], [], [], []
    spins: dict[str, list[FloatArray]] = {}
    slices, start = {}, 0
    for name, cycle_loads in solved.items():
        if not is_loaded(part, cycle_loads):
            continue
        history = _with_pins(design, part, _history(part, cycle_loads))
        part_wrenches, part_accelerations = placing.to_part(history)
        for interface in part.beside:
            couples = _handed(part, interface, placing, cycle_loads)
            handed.setdefault(interface, []).append(design.load_factor * couples)
        for interface, wrench in part_wrenches.items():
            wrenches.setdefault(interface, []).append(design.load_factor * wrench)
        for interface, reach in placing.reaches(history).items():
            reaches.setdefault(interface, []).append(reach)
        accelerations.append(design.load_factor * part_accelerations)
        values = cycle_loads.positions
        labels += labels_of(design, name, cycle_loads)
        names += [name] * len(values)
        stretch_of.append(stretches_of(cycle_loads))
        if isinstance(cycle_loads, loads.CycleLoads):
            path.append(_way(design.cycles[name].run, values))
        else:
            path.append(np.full(len(values), np.nan))
        for entry in part.stack:
            spins.setdefault(entry.name, []).append(_spin(cycle_loads, part, entry))
        slices[name] = slice(start, start + len(values))
        start += len(values)
    if not slices:
        raise loads.LinkageError(f"no load acts on it: {', '.join(solved)} have none")
    together = {name: np.concatenate(parts) for name, parts in wrenches.items()}
    largest = max(float(np.abs(wrench).max()) for wrench in together.values())
    if not largest < _LARGEST:
        raise loads.LinkageError(
            f"its loads reach {largest:.3g} N or N mm, at most {_LARGEST:g} can be computed with: "
            "is a unit or an exponent wrong?"
        )
    _tilt(part, together, {name: np.concatenate(parts) for name, parts in handed.items()})
    found = PartLoads(
        together,
        np.concatenate(accelerations),
        slices,
        tuple(labels),
        tuple(names),
        {name: np.concatenate(parts) for name, parts in reaches.items()},
        part.tilt_held_at,
        np.concatenate(stretch_of),
        np.concatenate(path),
        tuple(
            PartDoubt(doubt.words, tuple(loads_on(design, part, e) for e in doubt.ends))
            for doubt in doubts
        ),
        {name: np.concatenate(parts) for name, parts in spins.items()},
        _own_swing(part, placing, {name: solved[name] for name in slices}, design.load_factor),
        part.press_fits,
        rubs=_rubbing(part, solved, together),
    )
    own = (*_of_press_fits(found), *_of_own_inertia(design, part, solved, found))
    return replace(found, doubts=(*found.doubts, *own))


def pins_carried(design: Design, body: str | None) -> Iterator[tuple[Part, MassProperties]]:
    """Pins whose mass a body has besides its part's: all that turn with it.

    None where the design states the mass of the body, which is the whole body's.
    """
    stated = design.stated_masses.get(body or "")
    for pin in design.parts.values() if stated is not None and stated.mass is None else ():
        if pin.joint is not None and pin.fixed_to == body:
            solid = closed_body(pin.geometry)
            assert solid is not None, "a pin's volume is known by formula"
            yield pin, solid.mass_properties(pin.material.density)


def _with_pins(design: Design, part: Part, history: loads.LoadHistory) -> loads.LoadHistory:
    """The loads on a part with weight and inertia of the pins that turn with it, in their bores."""
    wrenches = history.wrenches.copy()
    for pin, mass in pins_carried(design, part.body):
        x, y = design.bodies[str(part.body)].points[str(pin.joint)]
        a_x, a_y, alpha, omega2 = history.accelerations.T
        pull = np.stack([a_x - alpha * y - omega2 * x, a_y + alpha * x - omega2 * y], axis=1)
        for k, interface in enumerate(history.interfaces):
            if part.interfaces[interface] == pin.joint:
                wrenches[:, k, :2] -= mass.mass * pull
                wrenches[:, k, 5] -= mass.inertia * alpha
    return replace(history, wrenches=wrenches)


def _rubbing(part: Part, runs: Runs, wrenches: Mapping[str, FloatArray]) -> tuple[float, float]:
    """Friction of the pins in a part's bores and on its journals, as `PartLoads.rubs`.

    Of a couple that a drive brings in as well no more counts than the friction may be. A steady one
    has 0 in its range, as the force may turn in the bore.
    """
    steady = swing = 0.0
    radii = {face.name: face.radius for face in part.geometry.placed_interfaces}
    for name, arm in _friction_arms(part, runs).items():
        couple, force = wrenches[name][:, 5], np.hypot(*wrenches[name][:, :2].T).max()
        most, per = arm * force, radii[name] * force
        if most:
            steady = max(steady, min(np.abs(couple).max(), most) / per)
            swing = max(swing, min(np.ptp(np.append(couple, 0.0)) / 2, most) / per)
    return float(steady), float(swing)


def _friction_arms(part: Part, runs: Runs) -> dict[str, float]:
    """The largest friction couple of a pin over its force, mm, by the part's bores and journals.

    A file that has couples tells no coefficient.
    """
    arms = {face.name: 0.0 for face in part.geometry.placed_interfaces if face.radius}  # no clamps
    radii = {face.name: face.radius for face in part.geometry.placed_interfaces}
    for run in runs.values():
        for name in arms:
            if isinstance(run, loads.MeasuredLoads):
                found = [_MEASURED_FRICTION * radii[name]] if part.body in run.bodies else []
            else:
                found = [
                    own.coefficient * own.radius
                    for joint in run.linkage.joints
                    if isinstance(joint, loads.Revolute)
                    and joint.point == part.interfaces[name]
                    and part.body in (joint.body_a, joint.body_b)
                    and (own := run.linkage.friction.get(joint.name)) is not None
                ]
            arms[name] = max(arms[name], *found, 0.0)
    return arms


def _of_own_inertia(design: Design, part: Part, runs: Runs, found: PartLoads) -> list[PartDoubt]:
    """Weight and inertia of a pin itself, which its lugs do not hand it, as a doubt of its loads.

    Spread along the pin they bend and shear it by no more than such a share of its largest force in
    the lug that is farthest from the body that holds it.
    """
    if part.fixed_to is None or not found.largest_force:
        return []
    solid, pull = closed_body(part.geometry), float(np.hypot(*design.gravity))
    assert solid is not None, "a pin's volume is known by formula"
    holder, joint = part.fixed_to, str(part.joint)
    for run in runs.values():
        if isinstance(run, loads.MeasuredLoads):
            moved = run.bodies[holder].pull_at(joint, run.gravity) if holder in run.bodies else None
        elif holder == loads.GROUND:
            moved = None
        else:
            moved = run.acceleration(holder, joint) - np.array(design.gravity)
        if moved is not None:
            pull = max(pull, float(np.hypot(*moved.T).max()))
    mass = solid.mass_properties(part.material.density).mass
    share = design.load_factor * mass * pull / found.largest_force
    if share <= _OWN_INERTIA:
        return []
    wrenches = {name: (1 + share) * wrench for name, wrench in found.wrenches.items()}
    words = f"weight and inertia of the pin itself, {100 * share:.2g} % of its largest force"
    return [PartDoubt(words, (replace(found, wrenches=wrenches, doubts=()),))]


def _way(cycle: loads.Cycle, values: FloatArray) -> FloatArray:
    """Positions (n,) of a cycle; turns of an event go on where the last one ended."""
    if all(phase.begin is None for phase in cycle.phases):
        return values
    start, stop = cycle.spans[0]
    steps = np.diff(values)
    steps[steps * (stop - start) < 0.0] = 0.0
    return np.append(values[:1], values[0] + np.cumsum(steps))


def _of_press_fits(loads: PartLoads) -> list[PartDoubt]:
    """The ranges of interference that the bushes may have, all at one end: a doubt of the loads.

    One at a time another bush at its middle would hold the peak.
    """
    ranges = [
        f"the bush in {bore}, {fit.least:.3g} to {fit.largest:.3g} mm"
        for bore, fit in loads.press_fits.items()
        if fit.least < fit.largest
    ]
    ends = (
        replace(
            loads,
            press_fits={bore: fit.at(share) for bore, fit in loads.press_fits.items()},
            doubts=(),
        )
        for share in (LEAST, LARGEST)
    )
    return [PartDoubt(f"{INTERFERENCE} {' and of '.join(ranges)}", tuple(ends))] if ranges else []


def _own_swing(part: Part, placing: Placing, runs: Runs, factor: float) -> dict[float, FloatArray]:
    """Inertia of a part as it bends, as in `PartLoads`; none of a part beside its body's x axis."""
    c, s = cos(placing.angle), sin(placing.angle)
    cycles = {name: run for name, run in runs.items() if isinstance(run, loads.CycleLoads)}
    found = {name: run.own_swing.get(str(part.body)) for name, run in cycles.items()}
    swings = {name: own for name, own in found.items() if own is not None}
    if not swings or abs(s) > TIE:
        return {}
    places = next(iter(swings.values())).places[0]
    return {
        c * (x - placing.origin[0]): np.concatenate(
            [
                factor * c * swings[name].across[:, k]
                if name in swings
                else np.zeros(len(run.positions))
                for name, run in runs.items()
            ]
        )
        for k, x in enumerate(places.tolist())
    }


def stretches_of(cycle: loads.CycleLoads | loads.MeasuredLoads) -> IntArray:
    """Number (n,) of the stretch of a cycle, between two jumps, that each position is in."""
    jumps = np.diff(cycle.phase_of) != 0
    if isinstance(cycle, loads.CycleLoads):
        touches = () if cycle.swings else cycle.touches.values()  # a swing has its own contact
        for touch in touches:
            jumps |= touch.touching[1:] != touch.touching[:-1]
        for load in cycle.reactions.values():
            for rubbing in (load.friction_couple, load.friction_force):
                way = np.sign(rubbing)  # 0 at rest
                jumps |= way[1:] != way[:-1]
    return np.concatenate([[0], np.cumsum(jumps)])


def labels_of(
    design: Design, name: str, cycle: loads.CycleLoads | loads.MeasuredLoads
) -> tuple[str, ...]:
    """Where in the cycle its positions are, in words."""
    shown, unit, values = shown_of(design, name, cycle)
    told = {name, *loads.MeasuredLoads.phases}
    phases = tuple("" if phase in told else f" {phase}" for phase in cycle.phases)
    return _labels(shown, unit, tuple(values.tolist()), tuple(cycle.phase_of.tolist()), phases)


@lru_cache(maxsize=16)
def _labels(
    shown: str,
    unit: str,
    values: tuple[float, ...],
    phase_of: tuple[int, ...],
    phases: tuple[str, ...],
) -> tuple[str, ...]:
    """Where in the cycle positions are, in words: the same for every part and every variation."""
    return tuple(
        f"{shown} = {value:.4g} {unit}{phases[phase]}"
        for value, phase in zip(values, phase_of, strict=True)
    )


def _handed(
    part: Part,
    interface: str,
    placing: Placing,
    cycle_loads: loads.CycleLoads | loads.MeasuredLoads,
) -> FloatArray:
    """Couples (n, 2) about x and y, N mm, that a pin fixed in a part hands it of the other lugs.

    A lug's force F on the pin at z above the part's middle plane has the couple z x F.
    """
    lugs = part.beside[interface]
    seats = {name: name for name in lugs}
    history = cycle_loads.pin_history(part.interfaces[interface], seats, str(part.body))
    forces, _ = Placing((0.0, 0.0), placing.angle).to_part(history)
    couples = [
        z * np.stack([-f[:, 1], f[:, 0]], axis=1)
        for f, z in ((forces[name], height) for name, height in lugs.items())
    ]
    return np.asarray(np.sum(couples, axis=0))


def _tilt(part: Part, wrenches: Mapping[str, FloatArray], handed: Mapping[str, FloatArray]) -> None:
    """Add the couples of forces that act beside the part's middle plane, and what balances them.

    A force F at height z has the couple z x F: (-z F_y, z F_x) about x and y.

    handed  interface -> (n, 2) N mm, couples of a pin that is fixed there
    """
    heights = interface_heights(part)
    if not handed and not any(part.offsets.values()) and not any(heights.values()):
        return
    left = np.zeros((len(next(iter(wrenches.values()))), 2))
    for name, wrench in wrenches.items():
        acts, centre = part.offsets.get(name, 0.0) + heights.get(name, 0.0), heights.get(name, 0.0)
        for height, couple in ((acts - centre, wrench[:, 3:5]), (acts, left)):
            couple[:, 0] -= height * wrench[:, 1]
            couple[:, 1] += height * wrench[:, 0]
    for name, couple in handed.items():
        wrenches[name][:, 3:5] += couple
        left += couple
    wrenches[part.tilt_held_at][:, 3:5] -= left


def interface_heights(part: Part) -> Mapping[str, float]:
    """Height z, mm, of the middle of each interface that is not in the part's middle plane."""
    return part.geometry.heights


def _history(part: Part, cycle_loads: loads.CycleLoads | loads.MeasuredLoads) -> loads.LoadHistory:
    if part.body is not None:
        return cycle_loads.part_history(part.body, part.interfaces)
    assert part.joint is not None
    assert part.fixed_to is not None
    seats = {name: name for name in part.interfaces}
    return cycle_loads.pin_history(part.joint, seats, part.fixed_to)


def _spin(
    cycle: loads.CycleLoads | loads.MeasuredLoads, part: Part, entry: StackEntry
) -> FloatArray:
    """Angular speed (n,) of a lug against the pin, which turns with a body, rad/s; NaN: unknown."""
    if not isinstance(cycle, loads.CycleLoads):
        return np.full(len(cycle.positions), np.nan)
    assert part.fixed_to is not None
    own = cycle.velocities[:, cycle.body_index(part.fixed_to), 2]
    if entry.body is not None:
        return np.asarray(cycle.velocities[:, cycle.body_index(entry.body), 2] - own)
    assert entry.force is not None
    coordinate = cycle.linkage.force(entry.force).coordinate
    if not isinstance(coordinate, loads.Distance):
        return np.asarray(-own)  # a force whose direction does not turn
    ends = ((coordinate.body_b, coordinate.point_b), (coordinate.body_a, coordinate.point_a))
    reach = cycle.point(*ends[0]) - cycle.point(*ends[1])
    rate = _velocity(cycle, *ends[0]) - _velocity(cycle, *ends[1])
    across = reach[:, 0] * rate[:, 1] - reach[:, 1] * rate[:, 0]
    return np.asarray(across / (reach**2).sum(axis=1) - own)


def _velocity(cycle: loads.CycleLoads, body: str, point: str) -> FloatArray:
    """Velocity (n, 2) of a point of a body, mm/s."""
    row = cycle.body_index(body)
    arm = cycle.point(body, point) - cycle.poses[:, row, :2]
    spin = cycle.velocities[:, row, 2:]
    return np.asarray(cycle.velocities[:, row, :2] + spin * np.stack([-arm[:, 1], arm[:, 0]], 1))


# Which of several positions decides where some are equal but for round-off.
#
# Two cycles that pass through the same position load a part alike there, to the last digits or
# not, depending on the processor. The first of them is named, so that every machine names the
# same.


def first_largest(values: FloatArray) -> tuple[int, ...]:
    """Return the index, one number per axis, of the first value that equals the largest.

    values  of any shape, at least one; in their order in memory, the last axis runs fastest
    Raises ValueError for no values.
    """
    largest = float(np.max(values))
    equal = np.asarray(values >= largest - TIE * abs(largest))
    return tuple(int(k) for k in np.unravel_index(int(equal.argmax()), equal.shape))


def part_placing(design: Design, part: Part) -> Placing:
    """Place of a part in its body's frame.

    A body's part has its first interface at the origin and the second along x. A pin has its joint
    at the origin; its x is the x of the body that it is fixed to; where this has the ground's
    axes it points to the farthest point of the linkage, so that a machine that is drawn turned has
    the same pin under the same loads.
    """
    if part.body is None:
        return Placing((0.0, 0.0), _pin_angle(design, part))
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    angle = atan2(second[1] - first[1], second[0] - first[0])
    return Placing(first, angle, part.geometry.shifts)


def _pin_angle(design: Design, part: Part) -> float:
    """Angle of a pin's x axis in the frame of the body that it is fixed to, rad."""
    assert part.joint is not None
    if part.fixed_to != loads.GROUND and len(design.bodies[str(part.fixed_to)].points) > 1:
        return 0.0
    x0, y0 = design.points[part.joint]
    arms = [(x - x0, y - y0) for x, y in design.points.values()]
    x, y = max(arms, key=lambda arm: round(hypot(*arm), 9))
    return atan2(y, x)


def interface_distance(design: Design, part: Part) -> float:
    """Distance of a body part's first two interfaces, mm."""
    assert part.body is not None
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in part.geometry.interfaces[:2])
    return hypot(second[0] - first[0], second[1] - first[1])
