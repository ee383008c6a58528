"""The tables of a design file that state the linkage and its cycles, as pydantic models.

The models only know each table for itself; what must fit together between the tables is checked
where the design is put together.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, StringConstraints, Tag

from checks.design.errors import nearest
from checks.design.units import (
    AnyConstant,
    Direction2,
    ForceOrMoment,
    ForceOrMomentFromZero,
    Inertia,
    Length,
    LengthOrAngle,
    Mass,
    OffsetLength,
    Point2,
    PositiveAngularSpeed,
    PositiveBending,
    PositiveDamping,
    PositiveFlow,
    PositiveForce,
    PositiveForceOrMoment,
    PositiveLength,
    PositiveMass,
    PositiveMoment,
    PositivePower,
    PositiveStiffness,
    PositiveStress,
    PositiveTime,
    SpeedFromZero,
    Stress,
    SweepAcceleration,
    SweepSpeed,
    TimeFromZero,
)

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_-]*$")]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
Coefficient = Annotated[Number, Field(ge=0)]
Damping = Annotated[Number, Field(gt=0, lt=1)]
Irregularity = Annotated[Number, Field(gt=0, le=0.5)]
# by these pydantic names which of several forms a value has; messages leave them out
TAGS = ("<value>", "<table>", "<piston>", "<against motion>", "<contact>", "<expression>")
Ends = Annotated[list[Length], Field(min_length=2, max_length=2)]


class Table(BaseModel):
    """A table of the file: unknown keys are refused, what was read stays as it was."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Guide(Table):
    """A straight guide of a body in the frame, through the body's first pin, without rotation."""

    along: Direction2 = Field(description="direction of travel in the ground frame")
    ends: Ends | None = Field(
        None, description="how far the body may travel from where it is assembled, two lengths"
    )


class Elastic(Table):
    """How a body gives way: as a beam along its own x axis, or as the part that it is."""

    bending: PositiveBending | None = Field(None, description="bending stiffness E I")
    axial: PositiveForce | None = Field(None, description="stiffness E A against stretching")
    stiffness: Literal["fem"] | None = Field(
        None, description="instead of both: as the body's part does, which is meshed and solved"
    )


class BodyEntry(Table):
    """A rigid body of the linkage."""

    pins: list[str] = Field(
        min_length=1,
        description="points of the body: the frame's origin, then where its x axis points, then "
        "any others; with one pin the axes are the ground's",
    )
    mass: Mass | None = Field(
        None,
        description="of the whole body, instead of its part's and those of pins `fixed_to` it",
    )
    inertia: Inertia | None = Field(
        None,
        description="about the centre of mass; where only a mass is stated the part's, of as much "
        "mass",
    )
    centre: Point2 | None = Field(None, description="centre of mass in the body's frame")
    guide: Guide | None = Field(None, description="the body slides in the frame")
    elastic: Elastic | None = Field(
        None, description="how the body gives way where something pushes back; rigid without it"
    )


class JointEntry(Table):
    """A joint that is no plain pin: a slot, a guide between two bodies, or a weld."""

    kind: Literal["slot", "guide", "fixed"] = Field(
        description="slot: a point on a line of another body; guide: as a slot, and the body does "
        "not turn against the other; fixed: a weld"
    )
    on: str | None = Field(None, description="slot, guide: the body that has the line, or ground")
    through: str | None = Field(None, description="slot, guide: a point of `on` on the line")
    along: str | None = Field(
        None,
        description="slot, guide: a second point of `on` on the line, or a direction in the frame "
        'of `on` such as "1, 0"',
        examples=["1, 0"],
    )
    body: str | None = Field(None, description="slot, guide: the body that slides")
    point: str | None = Field(
        None, description="slot, guide: its point on the line; fixed: the point of the weld"
    )
    ends: Ends | None = Field(
        None, description="slot, guide: how far the point may go from `through`, two lengths"
    )
    bodies: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None, description="fixed: the two bodies, or a body and ground"
    )


class Available(Table):
    """Capacity of a drive between two points: push and pull, or a cylinder and its pressure."""

    push: PositiveForce | None = Field(None, description="largest force that pushes them apart")
    pull: PositiveForce | None = Field(None, description="largest force that pulls them together")
    bore: PositiveLength | None = Field(None, description="diameter of the cylinder's piston")
    rod: OffsetLength | None = Field(None, description="diameter of its rod, on the pulling side")
    pressure: PositiveStress | None = Field(None, description="pressure of the fluid")


def _one_value_or_table(value: object) -> str:
    return "<table>" if isinstance(value, Mapping | BaseModel) else "<value>"


AvailableEntry = Annotated[
    Annotated[PositiveForceOrMoment, Tag("<value>")] | Annotated[Available, Tag("<table>")],
    Discriminator(_one_value_or_table),
]


class CylinderEntry(Table):
    """A cylinder that gives a force between two points: its tube is at the first of them."""

    force: str = Field(description="the force between two points that it gives")
    rod: PositiveLength = Field(description="diameter of the rod")
    bore: PositiveLength = Field(description="inner diameter of the tube")
    wall: PositiveLength = Field(description="wall of the tube")
    closed: PositiveLength = Field(description="between its eyes, rod pushed in")
    stroke: PositiveLength = Field(description="how far the rod comes out")
    tube: PositiveLength = Field(
        description="from the eye of the tube to where the rod leaves its gland"
    )
    material: str = Field(description="of the rod")
    tube_material: str = Field(description="of the tube")
    guide: PositiveLength | None = Field(
        None, description="between the bearings of piston and gland, rod drawn out"
    )
    play: PositiveLength | None = Field(
        None, description="of rod and piston in their bearings, on diameter: it bends the axis"
    )


class ForceEntry(Table):
    """A force: between two points, at a point of a body in a direction, or a torque on a body."""

    between: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None, description="two points; a positive force pulls them together"
    )
    on: str | None = Field(
        None, description="which body takes the force where several share a point of `between`"
    )
    body: str | None = Field(None, description="the body that is pushed")
    at: str | None = Field(
        None,
        description="the point of the body at which the force acts, or where a torque enters it",
    )
    direction: Direction2 | None = Field(
        None, description="direction of the force on the body, in the ground frame"
    )
    follows: str | None = Field(
        None, description="the body in whose frame direction stands and with which it turns"
    )
    turns: str | None = Field(
        None, description="the body that a torque turns; positive turns it counter-clockwise"
    )
    against: str | None = Field(
        None, description="the body that the torque is braced against; the ground without it"
    )
    available: AvailableEntry | None = Field(
        None, description="what the drive can give: in both directions, or as a table"
    )


class PinFriction(Table):
    """Coulomb friction in a pin joint."""

    coefficient: Coefficient = Field(description="coefficient of friction")
    diameter: PositiveLength = Field(description="diameter of the pin")


class SlidingFriction(Table):
    """Coulomb friction in a slot."""

    coefficient: Coefficient = Field(description="coefficient of friction")


class GuideFriction(SlidingFriction):
    """Coulomb friction in a guide."""

    length: PositiveLength | None = Field(
        None,
        description="distance of its two bearings, half of it on either side of its point: they "
        "bear its couple; without it the couple has no friction",
    )


class JointFriction(Table):
    """Coulomb friction of one joint."""

    coefficient: Coefficient = Field(description="coefficient of friction")
    diameter: PositiveLength | None = Field(
        None, description="diameter of the pin; a pin joint needs it"
    )
    length: PositiveLength | None = Field(
        None, description="of a guide: distance of its two bearings, as of `guides`"
    )


class FrictionEntry(Table):
    """Friction of the joints; what is not named runs without friction."""

    pins: PinFriction | None = Field(None, description="every pin joint")
    guides: GuideFriction | None = Field(None, description="every guide")
    slots: SlidingFriction | None = Field(None, description="every slot")
    joints: dict[str, JointFriction] = Field(
        default_factory=dict, description="single joints: a pin joint by its point, others by name"
    )


class ElasticJoints(Table):
    """Elastic joints; bodies state their own stiffness."""

    joints: dict[str, PositiveStiffness] = Field(
        default_factory=dict, description="stiffness of a pin joint by its point, others by name"
    )


class PaceEntry(Table):
    """How fast the cycle runs: a coordinate's speed, a cylinder's flow, a law for each stroke."""

    coordinate: str = Field(
        description="the coordinate that sets the pace", examples=["cylinder.length"]
    )
    speed: SweepSpeed | None = Field(
        None, description="magnitude of the coordinate's rate; its direction follows the phase"
    )
    acceleration: SweepAcceleration | None = Field(
        None, description="acceleration of the coordinate along its way; above 0 the speed rises"
    )
    flow: PositiveFlow | None = Field(
        None,
        description="instead of speed, for the length of a force whose `available` has bore and "
        "rod: volume in time, at the pressure in the cylinder, that fills one side of it",
    )
    cushion: PositiveLength | None = Field(
        None,
        description="with flow: way before the end of each stroke (phases in one direction) along "
        "which the piston is braked evenly to rest",
    )
    law: Literal["harmonic", "cycloidal", "polynomial"] | None = Field(
        None, description="instead of speed: every stroke goes from rest to rest by this law"
    )
    time: PositiveTime | None = Field(None, description="with law: duration of each stroke")


class ShownEntry(Table):
    """The position as reports show it: sign * (coordinate - zero)."""

    name: str = Field(description="name of the displayed position")
    zero: LengthOrAngle = Field(description="the coordinate where the displayed position is 0")
    sign: Literal[1, -1] = Field(1, description="-1 counts the other way")


class StopEntry(Table):
    """The stop at the end of the travel."""

    basis: Literal["assumed", "mechanical"] = Field(
        description="mechanical: a stop ends the travel there; assumed: nothing does"
    )
    tolerance: LengthOrAngle = Field(
        description="+- deviation of the travel's end; of a mechanical stop the loads at both of "
        "its ends are in the error bars"
    )


class TableLaw(Table):
    """A force that follows a table, linear between its points: in the file, or in a CSV file."""

    over: str = Field(description="the coordinate it depends on", examples=["crank.angle"])
    at: list[LengthOrAngle] | None = Field(None, description="rising values of the coordinate")
    force: list[ForceOrMoment] | None = Field(None, description="the force at each of them")
    table: str | None = Field(
        None, description="instead of at and force: a CSV file of two columns, beside this file"
    )
    units: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None, description="units of the two columns", examples=[["mm", "N"]]
    )


Pressures = Annotated[
    Annotated[Stress, Tag("<value>")] | Annotated[list[Stress], Tag("<table>")],
    Discriminator(lambda value: "<table>" if isinstance(value, list | tuple) else "<value>"),
]


class PistonLaw(Table):
    """A pressure on a piston that pushes along the force: constant, or in a table."""

    pressure: Pressures | None = Field(
        None,
        description="over the surroundings; a list beside `at`; of a force between two points it "
        "pushes them apart, with `rod` it pulls them together",
        examples=["60 bar"],
    )
    bore: PositiveLength = Field(description="diameter of the piston")
    rod: PositiveLength | None = Field(
        None, description="diameter of the rod, where the pressure is on its side"
    )
    over: str | None = Field(
        None, description="the coordinate that a table depends on", examples=["crank.angle"]
    )
    at: list[LengthOrAngle] | None = Field(None, description="rising values of the coordinate")
    table: str | None = Field(
        None, description="instead of at and pressure: a CSV file of two columns"
    )
    units: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None, description="units of the two columns", examples=[["deg", "bar"]]
    )


class OpposingLaw(Table):
    """A force against the motion of its own coordinate: dry, viscous, or a table over the speed."""

    dry: PositiveForceOrMoment | None = Field(
        None, description="its size at any speed, such as the rubbing of a wiper or a seal"
    )
    viscous: PositiveDamping | None = Field(None, description="besides, times the speed")
    at_speed: list[SpeedFromZero] | None = Field(
        None, description="instead of both: rising speeds from 0, with resistance"
    )
    resistance: list[ForceOrMomentFromZero] | None = Field(
        None, description="its size at each speed, linear between"
    )


class ExpressionLaw(Table):
    """A force by a formula over coordinates and their rates, whose numbers carry units."""

    expression: str = Field(
        description="+ - * / **, sqrt, exp, log, sin, cos, tan, asin, acos, atan, abs, min and max "
        "of numbers, names of `where`, coordinates such as B.x or crank.angle, and rate(B.x)",
        examples=["-F * (L / gas.length)**1.2"],
    )
    where: dict[str, AnyConstant] | None = Field(
        None, description="its constants by name", examples=['{ F = "400 N", L = "260 mm" }']
    )


class AnvilEntry(Table):
    """An anvil that a blow moves."""

    mass: PositiveMass = Field(description="of the anvil, with what stands on it")
    stiffness: PositiveStiffness = Field(description="between it and the ground")


class WorkpieceEntry(Table):
    """How a workpiece answers to a blow: elastic, plastic, or elastic up to where it yields."""

    stiffness: PositiveStiffness | None = Field(
        None, description="of the workpiece and what lies beneath it"
    )
    yields: PositiveForce | None = Field(
        None, description="force at which it is pressed in for good, as far as the blow goes"
    )
    anvil: AnvilEntry | None = Field(
        None,
        description="without it nothing beneath the workpiece moves",
        examples=['{ mass = "500 kg", stiffness = "50 kN/mm" }'],
    )


class ContactLaw(Table):
    """A workpiece or stop that pushes back along the force when it is touched, and never pulls."""

    touches: str = Field(description="the coordinate along which it pushes", examples=["D.y"])
    at: LengthOrAngle = Field(description="the coordinate at first touch")
    stiffness: PositiveStiffness | None = Field(
        None,
        description="stiffness of the workpiece or stop; without it rigid, and the linkage must be "
        "elastic",
    )
    stops: bool | None = Field(
        None,
        strict=True,
        description="true, the default for a force on a body: the body stands still along the "
        "force while it touches",
    )
    restitution: Annotated[Number, Field(ge=0, le=1)] | None = Field(
        None,
        description="speed after over speed before a blow, 0 without rebound; without it blows are "
        "told from 0 to 1",
    )
    blow: WorkpieceEntry | None = Field(
        None,
        description="how it answers to a blow, whose force and loads are then solved",
        examples=['{ yields = "30 kN" }'],
    )


def _kind_of_law(value: object) -> str:
    laws: dict[str, type[Table]] = {
        "<contact>": ContactLaw,
        "<against motion>": OpposingLaw,
        "<piston>": PistonLaw,
        "<expression>": ExpressionLaw,
        "<table>": TableLaw,
    }
    if isinstance(value, Mapping):
        owners = {key: tag for tag, law in reversed(laws.items()) for key in law.model_fields}
        owners |= dict.fromkeys(TableLaw.model_fields, "<table>")
        near = [nearest(str(key), owners) for key in value]
        found = {owners[key] for key in near if key is not None}
        return next((tag for tag in laws if tag in found), "<table>")
    return next((tag for tag, law in laws.items() if isinstance(value, law)), "<value>")


LawEntry = Annotated[
    Annotated[ForceOrMoment, Tag("<value>")]
    | Annotated[TableLaw, Tag("<table>")]
    | Annotated[PistonLaw, Tag("<piston>")]
    | Annotated[ExpressionLaw, Tag("<expression>")]
    | Annotated[OpposingLaw, Tag("<against motion>")]
    | Annotated[ContactLaw, Tag("<contact>")],
    Discriminator(_kind_of_law),
]


class PhaseEntry(Table):
    """A stretch of the cycle with its forces."""

    name: Name = Field(description="name of the phase")
    to: LengthOrAngle = Field(description="where the swept coordinate arrives")
    forces: dict[str, LawEntry] = Field(
        default_factory=dict,
        description="forces that are given: constant, tabled, of a piston, by a formula, against "
        "the motion, or a contact",
    )
    solve: str = Field(description="the force that follows from the others")


class CycleEntry(Table):
    """A cycle of the machine, swept in one coordinate, phase after phase."""

    coordinate: str = Field(
        description="the swept coordinate: <point>.x, <point>.y, <body>.angle or <force>.length",
        examples=["A.y"],
    )
    start: LengthOrAngle = Field(description="where the coordinate starts")
    pace: PaceEntry
    positions: Annotated[int, Field(strict=True, ge=2, le=20_000)] = Field(
        361, description="least number of positions over all phases"
    )
    shown: ShownEntry | None = None
    stop: StopEntry | None = None
    friction: FrictionEntry | None = Field(
        None, description="in this cycle, instead of the file's friction"
    )
    phases: list[PhaseEntry] = Field(min_length=1)


class MotorEntry(Table):
    """A motor by its plate, and the gear between it and the angle that sets the pace."""

    power: PositivePower = Field(description="rated, at its shaft", examples=["5.5 kW"])
    speed: PositiveAngularSpeed = Field(description="rated", examples=["1455 rpm"])
    free_speed: PositiveAngularSpeed = Field(
        description="without load; the synchronous speed of an asynchronous motor",
        examples=["1500 rpm"],
    )
    breakdown: Annotated[Number, Field(gt=1)] | None = Field(
        None,
        description="breakdown torque of an asynchronous motor over its rated torque; without it "
        "the torque falls along a straight line: direct current, servos",
    )
    starting: Positive | None = Field(
        None,
        description="torque at standstill of an asynchronous motor over its rated torque, which a "
        "start needs; a straight line over the speed leads from there to the breakdown torque",
    )
    torque_limit: PositiveMoment | None = Field(
        None, description="torque that the controller of a motor without breakdown lets through"
    )
    inertia: Inertia = Field(0.0, description="of the rotor", examples=["0.018 kg m2"])
    ratio: Annotated[Number, Field(ge=1e-3, le=1e5)] | None = Field(
        None,
        description="speed of the motor over the angle's; without it the one that has the cycles' "
        "speed at the rated speed",
    )
    efficiency: Annotated[Number, Field(gt=0, le=1)] = Field(1.0, description="of the gear")


class BrakeEntry(Table):
    """A brake on the angle that the motor turns; on the motor's shaft, torque times ratio."""

    torque: PositiveMoment = Field(description="against the motion", examples=["120 N m"])
    delay: TimeFromZero = Field(0.0, description="from the command until the torque is there")


class EventEntry(Table):
    """A start or stop of a cycle that drive.motor turns; the duty counts it as a cycle."""

    cycle: str = Field(description="the cycle that it leads to or leaves", examples=["turn"])
    kind: Literal["start", "coast", "brake"] = Field(
        description="start: from rest by the motor; coast: to rest without motor and brake; brake: "
        "to rest by drive.brake"
    )
    at: LengthOrAngle | None = Field(
        None,
        description="the cycle's coordinate as it begins; without it the worst of 12 places of a "
        "turn, by the largest force of a joint",
    )
    turns: Annotated[Number, Field(gt=0, le=100)] | None = Field(
        None,
        description="of a start, after which it is followed no more; without it until the speed is "
        "within 1 % of the steady one",
    )
    motor: Literal["off", "on"] = Field(
        "off",
        description="of a brake: on drives on against it, off gives no torque from the command",
    )
    positions: Annotated[int, Field(strict=True, ge=2, le=20_000)] | None = Field(
        None, description="least number of positions; without it a turn has those of its cycle"
    )


class DriveEntry(Table):
    """How the machine's drive holds its speed: at most one of control, irregularity and motor.

    A flywheel goes alone or with a motor; a brake needs a motor.
    """

    control: Literal["constant"] | None = Field(
        None,
        description="the drive holds its speed whatever the torque: a servo, or a motor far "
        "stronger than the machine",
    )
    flywheel: Inertia | None = Field(
        None,
        description="inertia about the driven coordinate besides the bodies' own; without a "
        "motor the drive's torque then is even",
        examples=["1.4 kg m2"],
    )
    irregularity: Irregularity | None = Field(
        None, description="(fastest - slowest) / mean speed over a turn, as the drive keeps it"
    )
    motor: MotorEntry | None = Field(
        None,
        description="turns the cycles, whose stated speed is then where the solution begins",
        examples=[
            '{ power = "5.5 kW", speed = "1455 rpm", free_speed = "1500 rpm", breakdown = 2.9 }'
        ],
    )
    brake: BrakeEntry | None = Field(
        None, description="of events", examples=['{ torque = "120 N m", delay = "50 ms" }']
    )


class DynamicsEntry(Table):
    """How the vibration of the linkage is judged."""

    damping: Damping = Field(
        0.02, description="damping ratio of every mode: 0.01 welded steel to 0.05 bolted joints"
    )
    rise: PositiveTime | None = Field(
        None,
        description="rise time of loads that jump from one phase to the next; without "
        "it four periods of the mode, a tenth of the time between jumps or 5 % of the cycle, "
        "whichever is least",
    )
    apply: bool = Field(False, strict=True, description="true: the loads include the vibration")
    cushioned: list[str] = Field(
        default_factory=list,
        description="points whose pins cross their play without a hit as their force reverses: a "
        "film of oil, a preload or friction slows them; without it hits of pins with a stated fit "
        "are in the error bars",
        examples=['["A"]'],
    )
