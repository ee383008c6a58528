"""A design that was read and fits together: plain data in N, mm, s, tonne and rad."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import NamedTuple

import loads
from checks.design.materials import Material
from checks.design.model import BoltsEntry, Column, Requirements, StackEntry
from checks.design.strength import FkmStrength
from checks.design.tables import DriveEntry, DynamicsEntry
from checks.handbook.fits import PressFit
from geometry.bars import Walls
from geometry.shape import Shape
from loads import MeasuredLoads

Pair = tuple[float, float]


class StatedMass(NamedTuple):
    """Mass [t], centre [mm, body frame] and inertia about it [t mm2]; None as the part has it."""

    mass: float | None
    centre: Pair | None
    inertia: float | None


@dataclass(frozen=True)
class Shown:
    """The position as reports show it: sign * (coordinate - zero)."""

    name: str
    zero: float
    sign: int


@dataclass(frozen=True)
class Stop:
    """The stop of the travel, "assumed" or "mechanical", within +- tolerance (mm or rad)."""

    basis: str
    tolerance: float


@dataclass(frozen=True)
class Cycle:
    """A cycle as `loads` runs it, and what else the file says of it.

    friction  by joint of the linkage, or None where the design's holds
    entries   number in the file of each phase, where phases were split at reversals
    event     the start or stop that it is, of another cycle
    """

    run: loads.Cycle
    shown: Shown | None = None
    stop: Stop | None = None
    friction: Mapping[str, loads.Friction] | None = None
    entries: tuple[int, ...] = ()
    event: loads.EventRun | None = None

    def entry(self, phase: int) -> int:
        """Number in the file of a phase."""
        return self.entries[phase] if self.entries else phase

    @property
    def has_contact(self) -> bool:
        """True if something is touched in any of its phases."""
        laws = (law for phase in self.run.phases for law in phase.given.values())
        return any(isinstance(law, loads.Contact) for law in laws)


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """A run whose loads stand in a file; its bodies are without mass here.

    file       as the design names it
    tolerance  share of the largest force on a body that may be left of its balance
    assumed    (key, reason) of what the file does not have
    """

    name: str
    file: str
    tolerance: float
    loads: MeasuredLoads
    assumed: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Duty:
    """How often each cycle runs in the machine's life; rate in 1/s.

    life            "infinite": no cycle may exceed the endurance limit; "finite": Miner's sum
    allowed_damage  Miner's sum at which a part counts as used up
    damage_so_far   what of it earlier use has taken
    """

    cycles: Mapping[str, float]
    rate: float | None
    life: str = "infinite"
    allowed_damage: float = 0.3
    damage_so_far: float = 0.0


@dataclass(frozen=True)
class Cylinder:
    """A hydraulic or pneumatic cylinder: what gives the force between two points.

    rod, bore, outer  mm, diameters of the rod, and of the tube inside and outside
    closed            mm, between its eyes, rod pushed in; stroke: mm, how far it comes out
    tube              mm, from the eye of the tube to the outer end of its gland
    guide             mm, between the bearings of piston and gland, rod drawn out; 0 if not stated
    play              mm, of the rod and the piston in them, on diameter; 0 if not stated
    pressure          MPa, that its drive has available; 0 if not stated
    """

    force: str
    rod: float
    bore: float
    outer: float
    closed: float
    stroke: float
    tube: float
    material: Material
    tube_material: Material
    guide: float = 0.0
    play: float = 0.0
    pressure: float = 0.0

    @property
    def second_moments(self) -> tuple[float, float]:
        """Second moments of area, mm4, of tube and rod."""
        return pi / 64 * (self.outer**4 - self.bore**4), pi / 64 * self.rod**4

    @property
    def areas(self) -> tuple[float, float]:
        """Areas, mm2, that pressure acts on as it pushes and as it pulls."""
        return pi / 4 * self.bore**2, pi / 4 * (self.bore**2 - self.rod**2)

    @property
    def masses(self) -> tuple[float, float]:
        """Masses per length, t/mm, of the tube with the rod in it, and of the rod."""
        rod = pi / 4 * self.rod**2 * self.material.density
        tube = pi / 4 * (self.outer**2 - self.bore**2) * self.tube_material.density
        return tube + rod, rod


@dataclass(frozen=True)
class Roller:
    """A pin or roller on a part's sliding contact: radius in mm, None for steel as strong."""

    radius: float
    material: Material | None


@dataclass(frozen=True)
class Weld:
    """A weld across a part.

    at              mm, from `first`, or the first of `between`
    walls           that it stands on
    category        MPa, range of nominal stress in the walls that 2e6 cycles endure
    where           where the category is from
    throat          mm; None of a weld without a root that carries load
    partial_factor  least safety of its fatigue
    first           the part's first interface, of a beam the first of its outermost holes
    between         two neighbouring holes of a plate
    """

    at: float
    walls: Walls
    category: float
    where: str
    throat: float | None
    partial_factor: float
    first: str
    between: tuple[str, ...] = ()

    @property
    def place(self) -> str:
        """Where it is, which tells it from the part's others."""
        arm = f" from {self.between[0]} to {self.between[1]}" if self.between else ""
        return f"{self.at:g} mm{arm}"

    @property
    def told(self) -> str:
        """Where it is, with what it is measured from."""
        return self.place if self.between else f"{self.place} from {self.first}"


COMPARED_ARC = pi / 2  # of contact, rad: the narrowest on which formulas were compared with solids


@dataclass(frozen=True)
class Part:
    """A part: a body of the linkage, or the pin of a joint (then `stack` tells its lugs)."""

    name: str
    shape: str
    geometry: Shape
    material: Material
    body: str | None
    joint: str | None
    interfaces: Mapping[str, str]  # interface -> point, or slot that runs on it; of a pin: -> joint
    fixed_to: str | None
    offsets: Mapping[str, float]  # interface -> mm above the middle plane at which its force acts
    tilt_held_at: str  # the interface that takes the couples out of the plane that are left
    stack: tuple[StackEntry, ...]
    surface: str
    bearing_arc: float  # rad
    column: Column
    reliability: float
    fineness: float
    most_unknowns: int
    contacts: Mapping[str, Roller] = field(default_factory=dict)  # by sliding interface
    fkm: FkmStrength | None = None  # None: Marin's chain
    arc_stated: bool = False  # whether the file states `bearing_arc`, so knows the clearance
    # interface without an offset -> lugs of the pin that is fixed there -> mm beside the part
    beside: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # bore -> least and largest clearance of its pin, mm on diameter, where the file states its fit
    clearances: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    welds: tuple[Weld, ...] = ()
    bolts: tuple[BoltsEntry, ...] = ()
    bushes: Mapping[str, Material] = field(default_factory=dict)  # of a pin: lug -> its bush's
    # bore -> "run_in" edges, as stated: pressed evenly along
    bore_edges: Mapping[str, str] = field(default_factory=dict)
    least_arc: float = pi  # rad, narrowest on which pins press by stated or assumed fits
    press_fits: Mapping[str, PressFit] = field(default_factory=dict)  # bore -> bush pressed into it
    # of a pin under loads: area with 95 % of its largest stress amplitude, over d^2
    bent_area: float = 0.0
    fit_assumed: str = ""  # where `clearances` are from if the file states no fit, in words

    @property
    def loose_pin(self) -> bool:
        """True if a stated fit leaves a narrower arc than solids compare."""
        return self.least_arc < COMPARED_ARC

    @property
    def narrowest_arc(self) -> float:
        """The narrowest arc, rad, on which pins press in its bores, assumed or by their fits."""
        return min(self.bearing_arc, self.least_arc)


@dataclass(frozen=True)
class Design:
    """A machine to be checked, as its file states it.

    source           text of the file itself; sources: (path, text) of every file it takes from,
                     the file itself last but for the tables in CSV files
    sha256           of the texts of all sources, one after the other
    inputs           (key, value) of everything that the files and the overrides state
    ground           its points, and those that guides go through, "guide:<body>"
    bodies           that move; the points begin with the frame's origin and where its x axis
                     points; mass properties that the file leaves to the part are 0
    assembled        body -> pose of its frame
    stated_masses    body with a part -> what the file states beside it
    pins             point -> the bodies it joins, the ground first where it takes part
    joints           by name in the file: guides on the ground as "guide:<body>", slots, guides and
                     welds by their own, pins by their point (of three bodies it is two joints)
    available        force -> N or N mm that its drive can give with a positive and with a negative
                     sign
    friction         by joint of the linkage
    compliance       of bodies and joints
    as_parts         bodies that give way as their meshed parts do
    drive            how the drive holds its speed
    dynamics         how the vibration of the linkage is judged
    forks            how pins hold tilts as the linkage buckles, "soft" or "stiff"; None: not known
    defaults_used    (key, value) that the file does not state and ballesta took
    assumed          (key, reason) that the file marks as an assumption
    events           starts and stops as stated; solved they stand among the cycles
    """

    name: str
    file: Path
    source: str
    sources: tuple[tuple[str, str], ...]
    sha256: str
    inputs: tuple[tuple[str, str], ...]
    overrides: tuple[str, ...]
    accuracy: float
    require: Requirements
    load_factor: float
    gravity: Pair
    points: Mapping[str, Pair]
    ground: loads.Body
    bodies: Mapping[str, loads.Body]
    assembled: Mapping[str, loads.Pose]
    stated_masses: Mapping[str, StatedMass]
    pins: Mapping[str, tuple[str, ...]]
    joints: Mapping[str, tuple[loads.Joint, ...]]
    forces: Mapping[str, loads.Force]
    available: Mapping[str, Pair]
    friction: Mapping[str, loads.Friction]
    compliance: tuple[loads.Compliance, ...]
    as_parts: tuple[str, ...]
    drive: DriveEntry
    dynamics: DynamicsEntry
    forks: str | None
    cycles: Mapping[str, Cycle]
    measured: Mapping[str, MeasuredRun]
    duty: Duty
    parts: Mapping[str, Part]
    materials: Mapping[str, Material]
    defaults_used: tuple[tuple[str, str], ...]
    assumed: tuple[tuple[str, str], ...]
    events: Mapping[str, loads.Event] = field(default_factory=dict)
    cylinders: Mapping[str, Cylinder] = field(default_factory=dict)

    @property
    def slides(self) -> Mapping[str, loads.Slot | loads.Prismatic]:
        """Slots and guides by name in the file."""
        return {
            name: joint
            for name, joined in self.joints.items()
            for joint in joined
            if isinstance(joint, loads.Slot | loads.Prismatic)
        }

    def part_of(self, body: str) -> Part | None:
        """Return the part that a body is."""
        return next((part for part in self.parts.values() if part.body == body), None)

    def stated_mass(self, part: Part) -> StatedMass:
        """Return what the file states of the mass of a part's body."""
        return StatedMass(None, None, None) if part.body is None else self.stated_masses[part.body]
