"""The tables of a design file that say how a plate is drawn, and which of its holes take pins."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from checks.design.tables import Table
from checks.design.units import Point2, PositiveLength

KINDS = ("lever", "dxf", "svg")  # of a plate's shape: one of these keys of its table
DXF_SUFFIX = ".dxf"
_EXAMPLES = '{ lever = ["A", "B", "C"], fillet = "10 mm" }, { dxf = "plate.dxf" } or { svg = "M" }'


def _a_table(value: object) -> object:
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


def is_plate(shape: Any) -> bool:
    """True for what a design file may mean as a plate's shape."""
    if isinstance(shape, str):
        return shape in ("lever", "plate") or shape.lower().endswith(DXF_SUFFIX)
    if isinstance(shape, dict):
        return any(key in shape for key in (*KINDS, "fillet", "layers"))
    return isinstance(shape, PlateShape)


PlateShapeEntry = Annotated[PlateShape, BeforeValidator(_a_table)]
