"""The tables of a design file that say which holes of a STEP file take the part's pins."""

import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

from checks.design.tables import Table
from checks.design.units import PositiveLength, Vector, measure

Triple = tuple[float, float, float]
STEP_SUFFIXES = (".step", ".stp")
_NUMBER_AND_UNIT = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(\S.*?)?\s*")


@dataclass(frozen=True)
class Point:
    """Marks a text of a pydantic model as a point in space, "250, 0, 0 mm"."""

    def read(self, value: object) -> Triple:
        """Return the point in mm, or raise ValueError."""
        must_be = f'must be three numbers with a unit, such as "250, 0, 0 mm", got "{value}"'
        pieces = value.split(",") if isinstance(value, str) else []
        if len(pieces) != 3:
            raise ValueError(must_be)
        last = _NUMBER_AND_UNIT.fullmatch(pieces[2])
        unit = last[1] if last is not None and last[1] else ""
        try:
            x, y, z = (
                measure(piece.strip() if _has_unit(piece) else f"{piece.strip()} {unit}", "length")
                for piece in pieces
            )
        except ValueError as error:
            raise ValueError(f"{must_be}: {error}") from None
        return x.value, y.value, z.value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
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


def _has_unit(piece: str) -> bool:
    found = _NUMBER_AND_UNIT.fullmatch(piece)
    return found is not None and found[1] is not None


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
