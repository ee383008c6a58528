"""Welded details by name, with their categories in tables 8.3 to 8.6 of EN 1993-1-9:2005.

Read in the text of UNI EN 1993-1-9:2005, pages 9 to 16 and 23 to 27; the categories of tables 8.3
to 8.5 also in another transcription, of the English text. Tubes of table 8.6 with walls above 8 mm
are not raised to the higher category that the table allows for some. For attachments that are
longer than detail 5 of that table has them it points to table 8.4.
"""

from dataclasses import dataclass
from math import inf, nextafter
from typing import Literal

STANDARD = "EN 1993-1-9:2005"
ROOT = "table 8.5, detail 3"
ROOT_CATEGORY, SHEAR_CATEGORY = 36.0, 80.0  # MPa, of the root; of shear in figure 7.2 the least
PARTIAL_FACTOR = 1.35  # table 3.1: safe life, high consequence of failure
HIGHEST = 160.0  # MPa, category in figure 7.1
_SIZE = 25.0  # mm, thickness above which table 8.3 lowers a category by (25/t)^0.2

Outline = Literal["round", "rectangular", "flat", "I"]
DetailName = Literal[
    "tube on plate by fillet",
    "tube on plate by butt",
    "tube end to end by butt",
    "tube in socket by fillet",
    "attachment on tube",
    "bar on plate by fillet",
    "bar on plate penetrated",
    "bar end to end from one side",
    "bar end to end from one side tested",
    "attachment across bar",
    "attachment along bar",
    "attachment on edge",
    "end to end by butt from both sides",
    "end to end by butt from both sides tested",
    "stiffener from flange to flange",
]


@dataclass(frozen=True)
class Row:
    """A detail of a table, for parts of one outline.

    where       table and detail
    by_length   (largest l in mm, category in MPa), rising in l; l is infinite where it has no part
    walls       mm, walls that it is for: above the first, up to the second
    throat      whether its root carries load, so that its throat must be stated
    size        whether thick walls lower its category
    """

    name: DetailName
    outline: Outline
    where: str
    by_length: tuple[tuple[float, float], ...]
    walls: tuple[float, float] = (0.0, inf)
    throat: bool = False
    size: bool = False

    @property
    def longest(self) -> float:
        """The largest l that it is for, mm."""
        return self.by_length[-1][0]

    @property
    def by_size(self) -> bool:
        """True if its category depends on l."""
        return len(self.by_length) > 1 or self.longest < inf


def _any(category: float) -> tuple[tuple[float, float], ...]:
    return ((inf, category),)


_TUBE = (0.0, 12.5)  # mm, walls of table 8.6
_THIN = (0.0, 8.0)
_TUBES: tuple[Outline, ...] = ("round", "rectangular")
_PLATES: tuple[Outline, ...] = ("flat", "I")
_ON_TUBE = "table 8.6, detail 5, for l above 100 mm table 8.4, detail 1"
_TEE = "table 8.5, detail 1"
_ACROSS = ((50.0, 80.0), (80.0, 71.0))
# l = 50 mm stands in no row of table 8.5: it counts as longer
_SHORT = ((nextafter(50.0, 0.0), 80.0), (80.0, 71.0), (100.0, 63.0), (120.0, 56.0))
_BY_WALL = (
    ((0.0, 20.0), (*_SHORT, (inf, 56.0))),
    ((20.0, 30.0), (*_SHORT, (inf, 50.0))),
    ((30.0, 50.0), (*_SHORT, (200.0, 50.0), (inf, 45.0))),
    ((50.0, inf), (*_SHORT, (200.0, 50.0), (300.0, 45.0), (inf, 40.0))),
)
ROWS = (
    Row("tube on plate by fillet", "round", "table 8.6, detail 8", _any(40.0), _THIN, throat=True),
    Row(
        "tube on plate by fillet",
        "rectangular",
        "table 8.6, detail 9",
        _any(36.0),
        _THIN,
        throat=True,
    ),
    Row("tube on plate by butt", "round", "table 8.6, detail 6", _any(50.0), _TUBE),
    Row("tube on plate by butt", "rectangular", "table 8.6, detail 7", _any(45.0), _TUBE),
    Row("tube end to end by butt", "round", "table 8.6, detail 3", _any(71.0), _TUBE),
    Row("tube end to end by butt", "rectangular", "table 8.6, detail 4", _any(56.0), _TUBE),
    Row("tube in socket by fillet", "round", "table 8.5, detail 12", _any(40.0), throat=True),
    *(
        Row("attachment on tube", outline, _ON_TUBE, ((100.0, 71.0), (inf, 56.0)), _TUBE)
        for outline in _TUBES
    ),
    *(
        Row("bar on plate by fillet", "flat", _TEE, lengths, walls, throat=True)
        for walls, lengths in _BY_WALL
    ),
    *(Row("bar on plate penetrated", "flat", _TEE, own, walls) for walls, own in _BY_WALL),
    Row("bar end to end from one side", "flat", "table 8.3, detail 13", _any(36.0)),
    Row(
        "bar end to end from one side tested",
        "flat",
        "table 8.3, detail 13",
        _any(71.0),
        size=True,
    ),
    *(
        row
        for outline in _PLATES
        for row in (
            Row("attachment across bar", outline, "table 8.4, detail 6", _ACROSS),
            Row(
                "attachment along bar",
                outline,
                "table 8.4, detail 1",
                (*_ACROSS, (100.0, 63.0), (inf, 56.0)),
            ),
            Row("attachment on edge", outline, "table 8.4, detail 5", _any(40.0)),
            Row(
                "end to end by butt from both sides tested",
                outline,
                "table 8.3, detail 11",
                _any(80.0),
                size=True,
            ),
        )
    ),
    Row("stiffener from flange to flange", "I", "table 8.4, detail 7", _ACROSS),
    Row("end to end by butt from both sides", "I", "table 8.3, detail 12", _any(63.0)),
)


def category_of(
    name: DetailName, outline: Outline, wall: float, length: float | None
) -> tuple[float, Row]:
    """Category, MPa, of a detail on a part, and the row that it is from.

    wall    mm, thickness of the tube's wall or of the bar
    length  mm, l as the row's drawing has it; None where it is not stated

    Raises ValueError for a detail that the tables do not have for such a part, with what they have.
    """
    rows = [row for row in ROWS if row.name == name and row.outline == outline]
    if not rows:
        fitting = sorted({row.name for row in ROWS if row.outline == outline})
        raise ValueError(
            f"{STANDARD} has it for no {_PARTS[outline]}, which the part is there; for such a part "
            f"there are {'; '.join(fitting)}"
        )
    fits = [row for row in rows if row.walls[0] < wall <= row.walls[1]]
    if not fits:
        most = max(row.walls[1] for row in rows)
        others = sorted(
            {
                one.name
                for one in ROWS
                if one.outline == outline and one.walls[0] < wall <= one.walls[1]
            }
        )
        also = f"; for such a wall there are {'; '.join(others)}" if others else ""
        raise ValueError(
            f"{STANDARD}, {rows[0].where}, is for walls up to {most:g} mm, the part has "
            f"{wall:g} mm there{also}, or a stated category"
        )
    (row,) = fits
    if row.by_size and length is None:
        raise ValueError(
            f"its category in {STANDARD}, {row.where}, depends on l of the table's drawing: "
            "state length"
        )
    if not row.by_size and length is not None:
        raise ValueError(f"{STANDARD}, {row.where}, asks for no length; leave length out")
    if length is not None and length > row.longest:
        raise ValueError(
            f"{STANDARD}, {row.where}, is for l up to {row.longest:g} mm, got {length:g} mm; "
            "state a category of another source"
        )
    category = next(own for most, own in row.by_length if length is None or length <= most)
    return category * (min(1.0, _SIZE / wall) ** 0.2 if row.size else 1.0), row


_PARTS = {
    "round": "round tube",
    "rectangular": "rectangular tube",
    "flat": "flat bar",
    "I": "I section",
}
