"""A design that was read and fits together: plain data in N, mm, s, tonne and rad."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ballesta.design_model import Column, Requirements, StackEntry
from ballesta.materials import Material
from geometry.parts import Pin, PrismaticTube, ToggleBar

GROUND = "ground"
Pair = tuple[float, float]


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


@dataclass(frozen=True)
class Force:
    """A force; exactly one of `between` and `body` is used.

    between    ((body, point), (body, point)): positive pulls the two together
    body, at, direction    acts on the body at its point, unit direction in the ground frame
    """

    name: str
    between: tuple[tuple[str, str], tuple[str, str]] | None
    body: str | None
    at: str | None
    direction: Pair | None
    available: float | None  # N


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
class Phase:
    """A stretch of a cycle up to `to` (mm or rad): the forces given (N) and the one solved for."""

    name: str
    to: float
    given: Mapping[str, float]
    solve: str


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
    """A cycle, swept in one coordinate from `start` through the phases; mm, rad, s."""

    name: str
    coordinate: Coordinate
    start: float
    pace: Coordinate
    pace_speed: float
    positions: int
    shown: Shown | None
    stop: Stop | None
    phases: tuple[Phase, ...]


@dataclass(frozen=True)
class Duty:
    """How often each cycle runs in the machine's life; rate in 1/s."""

    cycles: Mapping[str, float]
    rate: float | None


@dataclass(frozen=True)
class Part:
    """A part: a body of the linkage, or the pin of a joint (then `stack` tells its lugs)."""

    name: str
    shape: str
    geometry: ToggleBar | PrismaticTube | Pin
    material: Material
    body: str | None
    joint: str | None
    interfaces: Mapping[str, str]  # interface of the shape -> point; of a pin: lug -> joint
    fixed_to: str | None
    stack: tuple[StackEntry, ...]
    surface: str
    bearing_arc: float  # rad
    column: Column
    reliability: float
    fineness: float


@dataclass(frozen=True)
class Design:
    """A machine to be checked, as its file states it.

    joints           point -> the bodies it joins, the ground first where it takes part
    friction         joint (point, or "guide:<body>") -> its friction
    defaults_used    (key, value) that the file does not state and ballesta took
    assumed          (key, reason) that the file marks as an assumption
    claims           (part, kind of check) -> the claimed safety and who claims it
    """

    name: str
    file: Path
    source: str
    sha256: str
    overrides: tuple[str, ...]
    accuracy: float
    require: Requirements
    gravity: Pair
    ground: tuple[str, ...]
    points: Mapping[str, Pair]
    bodies: Mapping[str, Body]
    joints: Mapping[str, tuple[str, ...]]
    forces: Mapping[str, Force]
    friction: Mapping[str, Friction]
    cycles: Mapping[str, Cycle]
    duty: Duty
    parts: Mapping[str, Part]
    materials: Mapping[str, Material]
    defaults_used: tuple[tuple[str, str], ...]
    assumed: tuple[tuple[str, str], ...]
    claims: Mapping[tuple[str, str], tuple[float, str]]
