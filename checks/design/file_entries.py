"""Tables of a design file about others: columns of measured loads, holes of a STEP file."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from checks.design.tables import Name, Table
from checks.design.units import (
    DIMENSIONS,
    Angle,
    Fraction,
    Marker,
    Measured,
    Point2,
    PositiveLength,
    Vector,
    measure,
    measure_each,
)

Triple = tuple[float, float, float]
STEP_SUFFIXES = (".step", ".stp")


@dataclass(frozen=True)
class Point(Marker):
    """Marks a text of a pydantic model as a point in space, "250, 0, 0 mm"."""

    def read(self, value: object) -> Triple:
        """Return the point in mm, or raise ValueError."""
        must_be = f'must be three numbers with a unit, such as "250, 0, 0 mm", got "{value}"'
        pieces = value.split(",") if isinstance(value, str) else []
        if len(pieces) != 3:
            raise ValueError(must_be)
        try:
            x, y, z = measure_each(pieces, "length")
        except ValueError as error:
            raise ValueError(f"{must_be}: {error}") from None
        return x, y, z

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        number = r"[^,A-Za-z]*\d[^,]*"
        return {
            "type": "string",
            "pattern": rf"^{number},{number},{number}[A-Za-zµμ]+\s*$",
            "examples": ["250, 0, 0 mm"],
        }


@dataclass(frozen=True)
class PositiveVector(Vector):
    """A pair of which both numbers must be above 0."""

    def read(self, value: object) -> tuple[float, float]:
        """Return the pair in ballesta's units, or raise ValueError."""
        pair = super().read(value)
        if not min(pair) > 0:
            raise ValueError(f'must be above 0 mm both, got "{value}"')
        return pair


def _a_table(value: object) -> object:
    """Refuse a shape that was meant as a STEP file but is not written as a table."""
    if isinstance(value, str):
        file = value if value.lower().endswith(STEP_SUFFIXES) else "bracket.step"
        raise ValueError(f'must be a table, {{ step = "{file}" }}, got "{value}"')
    return value


class StepFile(Table):
    """The shape of a part as CAD has it."""

    step: str = Field(description="STEP file beside this one, with one solid", min_length=1)


class HoleEntry(Table):
    """A hole of the file in which a pin sits, or a journal in a lug."""

    diameter: PositiveLength = Field(description="diameter of the hole in the file")
    at: Annotated[Triple, Point()] | None = Field(
        None,
        description="a point on its axis in the file's own frame, where several have the diameter",
    )
    kind: Literal["bore", "journal"] = Field(
        "bore", description="journal: a shaft's end or a boss that a lug goes round"
    )


StepShape = Annotated[StepFile, BeforeValidator(_a_table)]
Section2 = Annotated[tuple[float, float], PositiveVector("length")]


# The tables of a design file that say how a plate is drawn, and which of its holes take pins.

KINDS = ("lever", "dxf", "svg")  # of a plate's shape: one of these keys of its table
DXF_SUFFIX = ".dxf"
_EXAMPLES = '{ lever = ["A", "B", "C"], fillet = "10 mm" }, { dxf = "plate.dxf" } or { svg = "M" }'


def _a_table_entry(value: object) -> object:
    """Refuse a shape that was meant as a plate but is not written as a table."""
    if isinstance(value, str):
        raise ValueError(f'must be a table, {_EXAMPLES}, got "{value}"')
    return value


class PlateShape(Table):
    """Outline of a plate: of a lever by its eyes, from a DXF file, or an SVG path."""

    lever: list[str] | None = Field(
        None,
        min_length=2,
        description="a lever: the holes one after the other, whose eyes common tangents join",
        examples=['["tail", "saddle", "head"]'],
    )
    fillet: PositiveLength | None = Field(
        None, description="lever: radius on the inner side of every bend"
    )
    dxf: str | None = Field(None, min_length=1, description="DXF file beside this one")
    layers: list[str] = Field(
        default_factory=list,
        description="dxf: layers that have the plate's lines; without it all that are on",
    )
    svg: str | None = Field(
        None, min_length=1, description="path of an SVG drawing, the text of its attribute `d`"
    )
    unit: Literal["mm", "cm", "m", "in", "ft"] | None = Field(
        None, description="of the drawing: of a DXF file that states none, and of a path (mm)"
    )


class PlateHoleEntry(Table):
    """A hole of a plate in which a pin sits."""

    eye: PositiveLength | None = Field(
        None, description="lever: outer diameter of the round eye about the hole"
    )
    diameter: PositiveLength | None = Field(
        None, description="diameter of the hole; of a drawing it may say which hole is meant"
    )
    at: Point2 | None = Field(
        None, description="drawing: the hole's middle in the drawing's own frame"
    )
    layer: str | None = Field(None, description="dxf: layer that the hole stands on")


class BeamHoleEntry(Table):
    """A hole of a beam in which a pin sits, in a round boss."""

    diameter: PositiveLength = Field(description="diameter of the hole")
    boss: PositiveLength = Field(description="outer diameter of the round boss about the hole")


def is_plate(shape: Any) -> bool:
    """True for what a design file may mean as a plate's shape."""
    if isinstance(shape, str):
        return shape in ("lever", "plate") or shape.lower().endswith(DXF_SUFFIX)
    if isinstance(shape, dict):
        return any(key in shape for key in (*KINDS, "fillet", "layers"))
    return isinstance(shape, PlateShape)


PlateShapeEntry = Annotated[PlateShape, BeforeValidator(_a_table_entry)]


@dataclass(frozen=True)
class Unit(Marker):
    """Marks a text of a pydantic model as the unit of a column, of one of the dimensions.

    What is kept is one of the unit in ballesta's own.
    """

    dimensions: tuple[str, ...]

    def read(self, value: object) -> Measured:
        """Return one of the unit, or raise ValueError."""
        examples = " or ".join(
            DIMENSIONS[name].example.partition(" ")[2] for name in self.dimensions
        )
        if not isinstance(value, str) or not value.strip() or value.strip()[0].isdigit():
            raise ValueError(f"must be a unit such as {examples}, got {value!r}")
        return measure(f"1 {value}", *self.dimensions)

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        examples = [DIMENSIONS[name].example.partition(" ")[2] for name in self.dimensions]
        return {"type": "string", "examples": examples}


PositionUnit = Annotated[Measured, Unit(("angle", "length", "time"))]
TimeUnit = Annotated[Measured, Unit(("time",))]
AngleUnit = Annotated[Measured, Unit(("angle",))]
ForceUnit = Annotated[Measured, Unit(("force",))]
MomentUnit = Annotated[Measured, Unit(("moment",))]
AccelerationUnit = Annotated[Measured, Unit(("acceleration",))]
SpinUnit = Annotated[Measured, Unit(("angular speed",))]
TurnUnit = Annotated[Measured, Unit(("angular acceleration",))]
Frame = Literal["ground", "body"]
Sign = Literal[1, -1]
TwoColumns = Annotated[list[str], Field(min_length=2, max_length=2)]


class PositionColumn(Table):
    """The column that the run goes through, such as an angle or the time."""

    column: str = Field(description="name of the column")
    unit: PositionUnit = Field(description="of its numbers")
    name: str | None = Field(None, description="as reports call it; default the column's name")


class TimeColumn(Table):
    """When each row was taken."""

    column: str = Field(description="name of the column")
    unit: TimeUnit = Field(description="of its numbers")


class AngleColumn(Table):
    """The angle of a body's x axis in the ground frame, counter-clockwise."""

    column: str | None = Field(None, description="name of the column")
    unit: AngleUnit | None = Field(None, description="of its numbers")
    constant: Angle | None = Field(
        None, description="instead of a column, for a body that does not turn"
    )


class SpinColumn(Table):
    """The angular velocity of a body, counter-clockwise."""

    column: str = Field(description="name of the column")
    unit: SpinUnit = Field(description="of its numbers")


class TurnColumn(Table):
    """The angular acceleration of a body, counter-clockwise."""

    column: str = Field(description="name of the column")
    unit: TurnUnit = Field(description="of its numbers")


class AccelerationColumns(Table):
    """The acceleration of a body's centre of mass, without gravity."""

    columns: TwoColumns = Field(description="names of the columns, along x and y")
    unit: AccelerationUnit = Field(description="of their numbers")
    frame: Frame = Field("ground", description="whose axes x and y are")


class ForceColumns(Table):
    """A force at a point of a body."""

    columns: TwoColumns = Field(description="names of the columns, along x and y")
    unit: ForceUnit = Field(description="of their numbers")
    sign: Sign = Field(1, description="-1: the file has the force BY the body, not on it")
    frame: Frame = Field("ground", description="whose axes x and y are")


class MomentColumn(Table):
    """A moment at a point of a body, counter-clockwise."""

    column: str = Field(description="name of the column")
    unit: MomentUnit = Field(description="of its numbers")
    sign: Sign = Field(1, description="-1: the file has the moment BY the body, not on it")


class AtPoint(Table):
    """All that acts on a body at one of its points."""

    force: ForceColumns | None = None
    moment: MomentColumn | None = None


class MeasuredBodyEntry(Table):
    """Motion and loads of one body."""

    angle: AngleColumn | None = None
    acceleration: AccelerationColumns | None = None
    angular_velocity: SpinColumn | None = None
    angular_acceleration: TurnColumn | None = None
    at: dict[Name, AtPoint] = Field(min_length=1, description="loads, by the point of the body")


class MeasuredEntry(Table):
    """A run whose loads stand in a file; no linkage is solved for it."""

    loads: str = Field(description="CSV file beside this one, names of the columns in line 1")
    position: PositionColumn
    time: TimeColumn | None = None
    tolerance: Fraction = Field(
        "1 %",
        validate_default=True,
        description="largest unbalanced load of a body, over the largest force on it",
    )
    bodies: dict[Name, MeasuredBodyEntry] = Field(min_length=1)
