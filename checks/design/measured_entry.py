"""The table of a design file that says which columns of a file are whose loads and motion."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from checks.design.tables import Name, Table
from checks.design.units import DIMENSIONS, Angle, Fraction, Marker, Measured, measure


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
