"""A design that was read and fits together: plain data in N, mm, s, tonne and rad."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from checks.design.materials import Material
from checks.design.model import Column, Requirements, StackEntry
from checks.design.strength import FkmStrength
from checks.design.tables import DynamicsEntry
from geometry.parts import Pin, PrismaticTube, ToggleBar
from loads import MeasuredLoads

GROUND = "ground"
Pair = tuple[float, float]
TwoNames = tuple[str, str]


@dataclass(frozen=True)
class Elastic:
    """How a body gives way along its x axis: E I in N mm2, E A in N; None is rigid.

    as_part  it gives way as its meshed part does, in all ways, instead
    """

    bending: float | None
    axial: float | None
    as_part: bool = False


@dataclass(frozen=True)
class Body:
    """A rigid body: its points in its own frame, and where the frame is when assembled.

    The frame's origin is the first pin and its x axis points to the second; with one pin its axes
    are the ground's. `mass`, `inertia` (about the centre) and `centre` (in the frame) are None
    where they come from the part of this body.
    """

    name: str
    pins: tuple[str, ...]
    points: Mapping[str, Pair]  # mm
    position: Pair  # mm, of the frame's origin in the ground frame
    angle: float  # rad, of the frame's x axis
    mass: float | None  # t
    inertia: float | None  # t mm2
    centre: Pair | None  # mm
    guide: Pair | None  # unit direction in the ground frame, through the first pin
    part: str | None
    guide_ends: Pair | None = None  # mm of travel from where the body is assembled
    elastic: Elastic | None = None


@dataclass(frozen=True)
class SlidingJoint:
    """A point of a body that stays on a line of another body or the ground.

    kind       "slot", or "guide": then the body does not turn against `on`
    on         the body that has the line, or ground
    through    its point on the line
    direction  of the line, unit vector in the frame of `on`
    body, point    what slides
    ends       mm along the direction from `through`, or None
    """

    name: str
    kind: str
    on: str
    through: str
    direction: Pair
    body: str
    point: str
    ends: Pair | None


@dataclass(frozen=True)
class Weld:
    """Two bodies (the ground may be one) that are fixed to each other at a point."""

    name: str
    bodies: TwoNames
    point: str


@dataclass(frozen=True)
class Force:
    """A force or torque; exactly one of `between`, `body` and `turns` is used.

    between    ((body, point), (body, point)): positive pulls the two together
    body, at, direction    acts on the body at its point, unit direction in the ground frame
    turns, against, at     a torque on `turns`, positive counter-clockwise, braced against another
               body or the ground; `at` is the point of `turns` where it enters, or None
    limits     N or N mm that the drive can give with a positive and with a negative sign, or None
    """

    name: str
    between: tuple[tuple[str, str], tuple[str, str]] | None
    body: str | None
    at: str | None
    direction: Pair | None
    limits: Pair | None
    turns: str | None = None
    against: str = GROUND

    @property
    def dimension(self) -> str:
        """`force` or `moment`."""
        return "force" if self.turns is None else "moment"


@dataclass(frozen=True)
class Friction:
    """Coulomb friction of one joint; radius in mm, 0 in a guide."""

    coefficient: float
    radius: float


@dataclass(frozen=True)
class Coordinate:
    """What is swept: "x" or "y" of a point, "angle" of a body, "length" of a force."""

    name: str
    what: str

    @property
    def dimension(self) -> str:
        """`angle` or `length`."""
        return "angle" if self.what == "angle" else "length"

    def __str__(self) -> str:
        return f"{self.name}.{self.what}"


@dataclass(frozen=True)
class TableLaw:
    """A force (N or N mm) tabled over rising values (mm or rad) of a coordinate."""

    coordinate: Coordinate
    values: tuple[float, ...]
    forces: tuple[float, ...]


@dataclass(frozen=True)
class ContactLaw:
    """A workpiece or stop that pushes along the force, from first touch at a coordinate.

    at         mm, of the force's own coordinate: of the point along its axis, or the length
    stiffness  N/mm, None is rigid
    stops      the body stands still along the force while it touches
    """

    coordinate: Coordinate
    at: float
    stiffness: float | None
    stops: bool


Law = float | TableLaw | ContactLaw


@dataclass(frozen=True)
class Phase:
    """A stretch of a cycle up to `to` (mm or rad): the forces given and the one solved for.

    given  by force: N or N mm where it is constant, else its law
    """

    name: str
    to: float
    given: Mapping[str, Law]
    solve: str


@dataclass(frozen=True)
class Pace:
    """How fast a cycle runs; exactly one of `speed` and `law` is used.

    speed, acceleration    mm/s or rad/s along the way, mm/s2 or rad/s2
    law, time  every stroke goes from rest to rest by this law, in `time` s
    """

    coordinate: Coordinate
    speed: float | None
    acceleration: float
    law: str | None
    time: float | None


@dataclass(frozen=True)
class Shown:
    """The position as reports show it: sign * (coordinate - zero)."""

    name: str
    zero: float
    sign: int


@dataclass(frozen=True)
class Stop:
    """What ends the travel, "assumed" or "mechanical", within +- tolerance (mm or rad)."""

    basis: str
    tolerance: float


@dataclass(frozen=True)
class Cycle:
    """A cycle, swept in one coordinate from `start` through the phases; mm, rad, s.

    friction  of this cycle's own, or None where the design's holds
    """

    name: str
    coordinate: Coordinate
    start: float
    pace: Pace
    positions: int
    shown: Shown | None
    stop: Stop | None
    phases: tuple[Phase, ...]
    friction: Mapping[str, Friction] | None = None

    @property
    def has_contact(self) -> bool:
        """Whether something is touched in any of its phases."""
        laws = (law for phase in self.phases for law in phase.given.values())
        return any(isinstance(law, ContactLaw) for law in laws)


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
class Roller:
    """A pin or roller on a part's sliding contact: radius in mm, None for steel as strong."""

    radius: float
    material: Material | None


@dataclass(frozen=True)
class Part:
    """A part: a body of the linkage, or the pin of a joint (then `stack` tells its lugs)."""

    name: str
    shape: str
    geometry: ToggleBar | PrismaticTube | Pin
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


@dataclass(frozen=True)
class Design:
    """A machine to be checked, as its file states it.

    source           text of the file itself; sources: (path, text) of every file it takes from,
                     the file itself last but for the tables in CSV files
    sha256           of the texts of all sources, one after the other
    inputs           (key, value) of everything that the files and the overrides state
    joints           pins: point -> the bodies it joins, the ground first where it takes part
    slides, welds    the joints that are no pins; guides on the ground are with their body
    friction         joint (point, name of the slot or guide, or "guide:<body>") -> its friction
    elastic_joints   joint, named as for friction -> its stiffness, N/mm
    irregularity     largest share by which the drive's speed may vary to count as even
    dynamics         how the vibration of the linkage is judged
    defaults_used    (key, value) that the file does not state and ballesta took
    assumed          (key, reason) that the file marks as an assumption
    claims           (part, kind of check) -> the claimed safety and who claims it
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
    gravity: Pair
    ground: tuple[str, ...]
    points: Mapping[str, Pair]
    bodies: Mapping[str, Body]
    joints: Mapping[str, tuple[str, ...]]
    slides: Mapping[str, SlidingJoint]
    welds: Mapping[str, Weld]
    forces: Mapping[str, Force]
    friction: Mapping[str, Friction]
    elastic_joints: Mapping[str, float]
    irregularity: float
    dynamics: DynamicsEntry
    cycles: Mapping[str, Cycle]
    measured: Mapping[str, MeasuredRun]
    duty: Duty
    parts: Mapping[str, Part]
    materials: Mapping[str, Material]
    defaults_used: tuple[tuple[str, str], ...]
    assumed: tuple[tuple[str, str], ...]
    claims: Mapping[tuple[str, str], tuple[float, str]]
