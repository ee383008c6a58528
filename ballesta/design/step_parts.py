"""Makes the geometry of a part from its STEP file and from where the linkage has its holes."""

from collections.abc import Iterator, Mapping
from math import atan2, cos, sin

from ballesta.design.files import Sources
from checks.design.data import Pair, Part
from checks.design.model import StepPartEntry
from geometry.bounded_files import MOST_CAD, read_bounded
from geometry.parts.step_part import NamedHole, StepPart


def step_geometry(
    key: str, entry: StepPartEntry, points: Mapping[str, Pair], sources: Sources
) -> StepPart:
    """Return the part's geometry; the STEP file's text is added to the sources.

    Raises DesignError for a file that cannot be read, ParameterError where it is not the part.
    """
    shape = f"{key}.shape.step"
    path = sources.file_of(shape).parent / entry.shape.step
    add_to_sources(shape, entry.shape.step, sources)
    at = [points[point] for point in entry.interfaces.values()]
    return StepPart(
        path=path,
        holes=tuple(
            NamedHole(name, hole.diameter, hole.at, hole.kind)
            for name in entry.interfaces
            for hole in (entry.holes[name],)
        ),
        places=tuple(from_frame(at[0], at[1], point) for point in at),
        tolerance=entry.hole_tolerance,
        flip=entry.flip,
        section=entry.section,
    )


def told_of_steps(parts: Mapping[str, Part]) -> Iterator[tuple[str, str]]:
    """Reading of each part's STEP file or drawing: its key, and unit and holes in words."""
    for name, part in parts.items():
        yield from ((f"parts.{name}.shape", said) for said in part.geometry.told)


def add_to_sources(key: str, name: str, sources: Sources) -> None:
    """Read a CAD file's text; names in it may be in any encoding, which changes no geometry."""
    path = sources.file_of(key).parent / name
    try:
        text = read_bounded(path, MOST_CAD)
        text.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        if isinstance(error, UnicodeDecodeError):
            sources.texts[path] = text.decode("latin-1")
            return
    sources.read_beside(key, name, MOST_CAD)


def from_frame(origin: Pair, towards: Pair, point: Pair) -> Pair:
    """Return a point in the frame with its x axis from one point towards another."""
    angle = atan2(towards[1] - origin[1], towards[0] - origin[0])
    x, y = point[0] - origin[0], point[1] - origin[1]
    return cos(angle) * x + sin(angle) * y, cos(angle) * y - sin(angle) * x
