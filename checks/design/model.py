"""Tables and keys of a design file: the pydantic models that read it.

The tables of the linkage and its cycles are in `design_tables`. The parts' parameters are described
by the dataclasses in `geometry.parts`, and their models are made from those.
"""

import dataclasses
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from checks.design.file_entries import (
    STEP_SUFFIXES,
    BeamHoleEntry,
    HoleEntry,
    MeasuredEntry,
    PlateHoleEntry,
    PlateShapeEntry,
    Section2,
    StepFile,
    StepShape,
    is_plate,
)
from checks.design.materials import MaterialEntry
from checks.design.tables import (
    BodyEntry,
    CycleEntry,
    CylinderEntry,
    DriveEntry,
    DynamicsEntry,
    ElasticJoints,
    EventEntry,
    ForceEntry,
    FrictionEntry,
    JointEntry,
    Name,
    Positive,
    Table,
)
from checks.design.units import (
    BY_DIMENSION,
    Acceleration2,
    BearingArc,
    Direction2,
    ForceFromZero,
    Fraction,
    Length,
    OffsetLength,
    Point2,
    PositiveForce,
    PositiveLength,
    PositiveMoment,
    PositivePressureSpeed,
    PositiveStress,
    PositiveTurning,
    PressedFit,
    Rate,
    Roughness,
    StatedFit,
    Survival,
)
from checks.handbook.screws import PropertyClass, ScrewSize
from checks.handbook.weld_details import PARTIAL_FACTOR, DetailName
from geometry.parameters import GIVEN_BY_DESIGN
from geometry.parts import SHAPES, Beam, Pin
from geometry.shape import Shape

SafetyKey = Literal["static", "buckling", "fatigue", "bush"]  # the keys of Requirements


class Requirements(Table):
    """The safety each kind of check must show."""

    static: Positive = Field(1.5, description="safety against yield")
    buckling: Positive = Field(3.0, description="safety against buckling")
    fatigue: Positive = Field(1.3, description="safety against fatigue")
    bush: Positive = Field(1.0, description="safety against the bushes' allowable pressure")


class DutyEntry(Table):
    """How often each cycle runs in the machine's life."""

    cycles: dict[str, Positive] = Field(
        default_factory=dict, description="number of runs by the cycle's name"
    )
    rate: Rate | None = Field(None, description="required number of runs per time")
    life: Literal["infinite", "finite"] = Field(
        "infinite",
        description="infinite: no cycle may exceed the endurance limit; finite: Miner's sum of all "
        "runs may reach allowed_damage",
    )
    allowed_damage: Positive = Field(
        0.3, description="Miner's sum at failure: 0.3 is the FKM guideline's least, 1 Miner's own"
    )
    damage_so_far: Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)] = Field(
        0.0, description="Miner's sum of earlier use"
    )


class Column(Table):
    """The part as a column; lengths where they are not the pins' distance."""

    in_plane: PositiveLength | None = Field(
        None, description="effective length in the plane of the linkage"
    )
    out_of_plane: PositiveLength | None = Field(
        None, description="effective length out of that plane"
    )
    fork_stiffness: PositiveTurning | None = Field(
        None,
        description="stiffness of each end's fork against tilting out of the plane; without it the "
        "ends count as hinged",
    )
    curve: Literal["a0", "a", "b", "c", "d"] | None = Field(
        None,
        description="column curve of Eurocode 3 that decides instead of yield, Johnson and Euler",
    )
    crookedness: PositiveLength | None = Field(
        None,
        description="largest initial deflection; without it 1/1000 of the effective length, or "
        "what Eurocode 3 has for the curve",
    )
    eccentricity: OffsetLength = Field(
        "0 mm",
        validate_default=True,
        description="largest distance of the force from the middle of both ends, such as half the "
        "clearance of the pins",
    )


class MeshEntry(Table):
    """How fine the part's mesh starts."""

    fineness: Positive = Field(1.0, description="2 halves the size of the elements")
    most_unknowns: Annotated[int, Field(strict=True, gt=0)] = Field(
        300_000,
        description="largest number of unknowns; refinement stops there, short of the accuracy",
    )


class Bush(Table):
    """A plain bush between pin and lug, pressed into the lug's bore."""

    material: str | None = Field(
        None,
        description="name of its material, or of its back's; without it as stiff as steel: softer "
        "ones even what a bent pin presses at edges and widen the arc",
    )
    length: PositiveLength = Field(description="bearing length in one lug")
    allowable: PositiveStress = Field(description="allowable mean pressure")
    pv: PositivePressureSpeed | None = Field(
        None, description="allowable mean pressure times sliding speed"
    )
    fit: PressedFit | None = Field(
        None,
        description="how it is pressed in: ISO fit such as `H7/p6`, or the interference on "
        "diameter such as `0.02 .. 0.05 mm`; the stress that it leaves in the lug for good then "
        "joins that of the loads, and its bore closes, which narrows `fits`; where it is not "
        "stated neither is counted",
    )


class StackEntry(Table):
    """A lug on a pin, or a pair of them at +-`at`: a body's, or the eye of a force."""

    body: str | None = Field(None, description="the body that the lug belongs to, or ground")
    force: str | None = Field(None, description="the force that acts through this eye")
    at: Length = Field(description="distance of the lug's mid-plane from the pin's")
    single: bool = Field(
        False, description="one lug at `at`, which may then be below 0; no second one at -`at`"
    )
    width: PositiveLength = Field(
        description="width of the lug on the pin, up to the length of the part's hole"
    )
    diameter: PositiveLength | None = Field(None, description="the pin's in this lug, if stepped")
    bush: Bush | None = None

    @property
    def name(self) -> str:
        """Name of the body or force that turns on the pin here."""
        return self.body or self.force or ""


class PartEntry(Table):
    """Keys of every part, whatever its shape."""

    material: str = Field(description="name of a material", examples=["S355"])
    surface: Literal["ground", "machined", "cold_drawn", "hot_rolled", "as_forged"] = Field(
        "hot_rolled", description="surface finish, for the endurance limit"
    )
    bearing_arc: BearingArc = Field(
        "90 deg",
        validate_default=True,
        description="narrowest arc on which a pin may press; the model band runs to 180 deg; "
        "where it is not stated 7 % further in bores, and contact up to H7/f7 decides what stays "
        "open",
    )
    reliability: Survival = Field(
        "99 %",
        validate_default=True,
        description="share of parts that must survive; of Marin's chain only",
    )
    strength: Literal["marin", "fkm"] = Field(
        "marin",
        description="chain that the fatigue strength comes from: Marin's factors, or the FKM "
        "guideline with the support of the stress gradient; never both",
    )
    roughness: Roughness | None = Field(
        None, description="roughness Rz, for FKM's chain only; without it the surface finish's"
    )
    column: Column = Field(default=Column.model_validate({}))
    mesh: MeshEntry = Field(default=MeshEntry.model_validate({}))


class ContactEntry(Table):
    """A pin or roller on one of a part's sliding contacts."""

    radius: PositiveLength = Field(description="radius of the pin or roller that presses there")
    material: str | None = Field(
        None, description="name of its material; without it steel that is as strong as the part"
    )


class WeldEntry(Table):
    """A weld all round a part, or along both faces of a flat one, across its axis."""

    at: Length = Field(
        description="distance from the part's first interface, along the part; of a beam from the "
        "outermost hole that `holes` names first"
    )
    between: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None,
        description="of a lever or drawn plate: two neighbouring holes, `at` from the first along "
        "the line to the second; where it has no more it may be left out",
    )
    detail: DetailName | None = Field(
        None, description="detail of EN 1993-1-9, tables 8.3 to 8.6, which has its category"
    )
    category: PositiveStress | None = Field(
        None,
        description="instead of `detail`: range of nominal stress that 2e6 cycles endure, of "
        "another source",
    )
    throat: PositiveLength | None = Field(
        None,
        description="throat of a fillet weld: its root is checked, too, and its static strength",
    )
    length: PositiveLength | None = Field(
        None, description="l of the table's drawing, where the category depends on it"
    )
    partial_factor: Annotated[float, Field(strict=True, ge=1, allow_inf_nan=False)] = Field(
        PARTIAL_FACTOR,
        description="least safety of its fatigue, where `require.fatigue` is lower: the partial "
        "factor of table 3.1, 1 to 1.35",
    )


class BoltsEntry(Table):
    """Screws that hold a cap, a flange or a block at one of a part's interfaces."""

    at: str = Field(description="interface whose force the screws carry")
    opens: Direction2 = Field(
        description="direction in the part's frame of the force on the part there that opens the "
        "joint: against its x axis for the cap at a rod's first interface"
    )
    count: Annotated[int, Field(strict=True, gt=0)] = Field(
        description="number of screws, which share the force"
    )
    size: ScrewSize = Field(description="thread, of coarse pitch")
    property_class: PropertyClass = Field(description="property class of ISO 898-1")
    largest_preload: PositiveForce | None = Field(
        None, description="instead of `torque`: largest preload of one screw"
    )
    torque: PositiveMoment | None = Field(
        None,
        description="largest tightening torque; with the least friction it makes the largest "
        "preload",
    )
    thread_friction: Annotated[float, Field(strict=True, ge=0, le=1, allow_inf_nan=False)] = Field(
        description="friction in the thread: the least beside `torque`, the largest beside "
        "`largest_preload`, which it twists; 0 for a screw that is stretched without a torque"
    )
    head_friction: Annotated[float, Field(strict=True, gt=0, le=1, allow_inf_nan=False)] | None = (
        Field(None, description="of a torque: least friction under the head or nut that turns")
    )
    head_diameter: PositiveLength | None = Field(
        None, description="of a torque: mean diameter of that face, (outer + hole)/2"
    )
    tightening_factor: Annotated[float, Field(strict=True, ge=1, allow_inf_nan=False)] = Field(
        description="largest preload over the least, of the way to tighten"
    )
    settling: ForceFromZero = Field(description="preload that the screw loses as surfaces settle")
    joint_constant: Annotated[float, Field(strict=True, gt=0, lt=1, allow_inf_nan=False)] = Field(
        description="share C of a force on the joint that the screw takes: its stiffness over that "
        "of screw and clamped parts together"
    )
    prying: Annotated[float, Field(strict=True, ge=1, allow_inf_nan=False)] = Field(
        1.0, description="force on the most loaded screw over the mean, with prying and bending"
    )
    pushed_beside: Annotated[bool, Field(strict=True)] = Field(
        False,
        description="a force against `opens` goes beside the joint, as in the cap of a rod, and "
        "takes nothing off the screws",
    )
    partial_factor: Annotated[float, Field(strict=True, ge=1, allow_inf_nan=False)] = Field(
        PARTIAL_FACTOR,
        description="least safety of their fatigue, where `require.fatigue` is lower: the partial "
        "factor of table 3.1, 1 to 1.35",
    )


EvenEdges = Literal["run_in"]


class BodyPartEntry(PartEntry):
    """A part that is a body of the linkage."""

    body: str = Field(description="the body that this part is")
    interfaces: dict[str, str] = Field(
        description="interface of the shape = point of the body that it sits at, or the name of "
        "the slot or guide that slides on it"
    )
    offsets: dict[str, Length] = Field(
        default_factory=dict,
        description="interface = how far above the part's middle plane its force acts: plates side "
        "by side; where a pin is fixed in the part, its stack says so without",
    )
    fits: dict[str, StatedFit] = Field(
        default_factory=dict,
        description="bore = ISO fit of its pin such as `H7/f7`, or the clearance on diameter such "
        "as `0.02 .. 0.06 mm`, in a bush as it is before it is pressed in: a solid then solves "
        "where the pin presses, over all of it, and cheaper models take the arc from it and from "
        "the force, instead of `bearing_arc`",
    )
    bore_edges: dict[str, EvenEdges] = Field(
        default_factory=dict,
        description="bore = its edges have run in, so that a pin that bends in its stack presses "
        "evenly along the bore all the same; where it is not stated edges are sharp, and the model "
        "band holds what a bent pin presses there",
    )
    contacts: dict[str, ContactEntry] = Field(
        default_factory=dict,
        description="sliding interface = the pin or roller on it; without it a flat block",
    )
    welds: list[WeldEntry] = Field(
        default_factory=list,
        description="welds across the part; none that is not stated is checked",
    )
    bolts: list[BoltsEntry] = Field(
        default_factory=list,
        description="screws that hold a cap or flange at an interface; none that is not stated is "
        "checked",
    )
    tilt_held_at: str | None = Field(
        None,
        description="interface that takes the couples which the offsets leave, and holds the twist "
        "of a part that buckles; else one without an offset, on the ground if there is one, the "
        "first of the body's pins",
    )


class StepPartEntry(BodyPartEntry):
    """A part that is one solid of a STEP file; its interfaces are holes that the entry names."""

    shape: StepShape
    holes: dict[Name, HoleEntry] = Field(min_length=2, description="interface = its hole")
    hole_tolerance: PositiveLength = Field(
        "0.05 mm",
        validate_default=True,
        description="largest difference of diameters and places between file and linkage",
    )
    section: Section2 | None = Field(
        None,
        description="stressed section: height in the linkage's plane, across the line from the "
        "first hole to the second, and thickness along the pins; for the endurance limit's size "
        "factor and the size that the material's strengths are of",
    )
    thickness: PositiveLength | None = Field(
        None,
        description="thickness along the pins of a plate that the file has in another one: its two "
        "flat faces are offset alike; of a part with other faces than square and parallel to the "
        "pins it is refused",
    )
    flip: Annotated[bool, Field(strict=True)] = Field(
        False, description="turn the part round, so that its other side is up"
    )


class PlatePartEntry(BodyPartEntry):
    """A flat plate with any number of pins: a lever, or a plate from a drawing.

    Its interfaces are holes that the entry names; the points of the linkage say where they are. Of
    a drawing the point of the first pin of the body is the origin of the part's frame.
    """

    shape: PlateShapeEntry
    thickness: PositiveLength = Field(description="thickness of the plate")
    holes: dict[Name, PlateHoleEntry] = Field(min_length=2, description="interface = its hole")
    hole_tolerance: PositiveLength = Field(
        "0.05 mm",
        validate_default=True,
        description="largest difference of diameters and places between drawing and linkage",
    )
    flip: Annotated[bool, Field(strict=True)] = Field(
        False, description="drawing: turn the plate round, so that its other side is up"
    )


class BeamPartEntry(BodyPartEntry):
    """A straight beam of a profile with any number of pins on its middle line.

    Its interfaces are holes that the entry names; the points of the linkage say where they are. The
    outermost hole that `holes` names first is the origin of the part's frame.
    """

    holes: dict[Name, BeamHoleEntry] = Field(min_length=2, description="interface = its hole")


class PinPartEntry(PartEntry):
    """A part that joins bodies at a point."""

    joint: str = Field(
        description="the point whose bodies the pin joins, or at which a force meets one body"
    )
    fixed_to: str = Field(
        description="the body that the pin turns with; of three bodies and more on a pin with "
        "friction the others rub on it"
    )
    stack: list[StackEntry] = Field(min_length=1, description="the lugs on the pin")


def shape_model(name: str, shape: type[Shape]) -> type[PartEntry]:
    """Return the model of the parts of one shape, made from the shape's parameters."""
    own: dict[str, Any] = {"shape": (Literal[name], Field(description=shape.__doc__))}
    for parameter in dataclasses.fields(shape):
        if parameter.metadata.get("given_by") != GIVEN_BY_DESIGN:
            continue
        own[parameter.name] = (
            BY_DIMENSION[parameter.metadata["dimension"]],
            Field(
                ... if parameter.default is dataclasses.MISSING else parameter.default,
                description=parameter.metadata["meaning"],
            ),
        )
    base: type[PartEntry] = BeamPartEntry if issubclass(shape, Beam) else BodyPartEntry
    if shape is Pin:
        base = PinPartEntry
    model: type[PartEntry] = create_model(shape.__name__ + "Part", __base__=base, **own)
    model.__doc__ = shape.__doc__
    return model


STEP, PLATE = "step", "plate"
PART_MODELS: dict[str, type[PartEntry]] = {
    **{name: shape_model(name, shape) for name, shape in SHAPES.items()},
    STEP: StepPartEntry,
    PLATE: PlatePartEntry,
}


def _kind_of_part(value: Any) -> Any:
    """Return the name of the model of a part: its shape, `step` or `plate` where it is a table."""
    shape = value.get("shape") if isinstance(value, dict) else getattr(value, "shape", None)
    if is_plate(shape):
        return PLATE
    if isinstance(shape, dict | StepFile):
        return STEP
    return STEP if isinstance(shape, str) and shape.lower().endswith(STEP_SUFFIXES) else shape


def _union() -> Any:
    union: Any = None
    for name, model in PART_MODELS.items():
        tagged: Any = Annotated[model, Tag(name)]
        union = tagged if union is None else union | tagged
    return Annotated[union, Discriminator(_kind_of_part)]


def _flat(value: object) -> object:
    """Turn nested tables of reasons into dotted keys: TOML nests keys that are not quoted."""
    if not isinstance(value, dict):
        return value
    result: dict[str, object] = {}
    for key, entry in value.items():
        if isinstance(entry, dict):
            inner = _flat(entry)
            assert isinstance(inner, dict)
            result.update({f"{key}.{rest}": reason for rest, reason in inner.items()})
        else:
            result[key] = entry
    return result


class DesignFile(Table):
    """A machine to be checked: its linkage, its cycles, its duty and its parts."""

    name: str = Field(description="name of the machine")
    accuracy: Fraction = Field(
        "3 %",
        validate_default=True,
        description="numerical error of the judged stress to which meshes are refined",
    )
    require: Requirements = Field(default=Requirements.model_validate({}))
    load_factor: Positive = Field(
        1.0,
        description="factor on all loads of parts, of cylinders and of the linkage, weight and "
        "inertia included; motion, drives and contacts of the linkage are found without it",
    )
    gravity: Acceleration2 = Field(
        "0, -9.81 m/s2", validate_default=True, description="in the ground frame"
    )
    ground: list[str] = Field(default_factory=list, description="points fixed to the frame")
    points: dict[Name, Point2] = Field(
        description="one position in which the linkage is assembled, in the ground frame"
    )
    bodies: dict[Name, BodyEntry]
    joints: dict[Name, JointEntry] = Field(
        default_factory=dict,
        description="joints that are no plain pins; a point shared by bodies is a pin by itself",
    )
    forces: dict[Name, ForceEntry] = Field(default_factory=dict)
    cylinders: dict[Name, CylinderEntry] = Field(
        default_factory=dict, description="what gives a force between two points, to be checked"
    )
    friction: FrictionEntry = Field(default=FrictionEntry.model_validate({}))
    elastic: ElasticJoints = Field(
        default=ElasticJoints.model_validate({}),
        description="joints that give way where something pushes back; the others are rigid",
    )
    cycles: dict[Name, CycleEntry] = Field(default_factory=dict)
    events: dict[Name, EventEntry] = Field(
        default_factory=dict,
        description="starts and stops of cycles that drive.motor turns; they count as cycles",
    )
    measured: dict[Name, MeasuredEntry] = Field(
        default_factory=dict, description="runs whose loads stand in a file; they count as cycles"
    )
    duty: DutyEntry = Field(default=DutyEntry.model_validate({}))
    drive: DriveEntry = Field(default=DriveEntry.model_validate({}))
    dynamics: DynamicsEntry = Field(default=DynamicsEntry.model_validate({}))
    forks: Literal["soft", "stiff"] | None = Field(
        None,
        description="how pins hold their bodies against tilting out of the plane as the linkage "
        "buckles: stiff, they share all tilts; soft, they do not; without it both are in the bars",
    )
    materials: dict[Name, MaterialEntry] = Field(default_factory=dict)
    parts: dict[Name, _union()] = Field(default_factory=dict)  # type: ignore[valid-type]
    assumed: Annotated[dict[str, str], BeforeValidator(_flat)] = Field(
        default_factory=dict,
        description="dotted key of this file = why it is assumed; every result lists it",
    )
