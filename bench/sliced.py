"""Buckling of parts from CAD by the sections that planes cut, beside their solids.

    python -m bench.sliced          what solids of the shapes have, exported to STEP and read again
    python -m bench.sliced odd      shapes that only CAD draws, with solids of their own

adds to bench/rungs/sliced.jsonl: share of the load by the solid, by the bar of its sections, and
the bound (checks/models/shapes/step_part.py).
"""

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.rung_beyond import drawn
from bench.rung_beyond import known as solids_beyond
from bench.rung_truth import with_buckling
from bench.rung_variations import SCENES, Machines
from bench.swept import CAMPAIGNS, loaded_of, step_rod
from checks.design.data import Part
from checks.ladder.levels import Asked
from checks.ladder.solid import check_solid
from checks.models import shapes
from checks.models.checked import MOST_FAR, MOST_PULLED, stress_share
from checks.part.part_loads import PartLoads
from fem.threads import one_thread
from geometry.parts.step_part import NamedHole, StepPart
from tests.geometry.step_files import write_step

FILE = Path(__file__).parent / "rungs" / "sliced.jsonl"
_LENGTH, _BORE = 161.0, 12.0  # of the rod of a crank and slider


def _link(gmsh: Any, width: float = 30, thick: float = 8, taken: float = 0.0) -> Any:
    """A plate between two pins, its middle `taken` mm narrower on both sides; its tag."""
    occ = gmsh.model.occ
    plate = occ.addBox(-20, -width / 2, -thick / 2, _LENGTH + 40, width, thick)
    if taken:
        sides = [
            (
                3,
                occ.addBox(
                    25, side * width / 2 - taken, -thick, _LENGTH - 50, 2 * taken, 2 * thick
                ),
            )
            for side in (-1, 1)
        ]
        ((_, plate),), _ = occ.cut([(3, plate)], sides)
    return plate


def _bored(gmsh: Any, solids: list[int], height: float = 60.0) -> None:
    """Unite the solids and bore both pins' holes."""
    occ = gmsh.model.occ
    first, *others = [(3, tag) for tag in solids]
    if others:
        (first, *_), _ = occ.fuse([first], others)
    bores = [(3, occ.addCylinder(x, 0, -height, 0, 0, 2 * height, _BORE / 2)) for x in (0, _LENGTH)]
    occ.cut([first], bores)


def _waisted(gmsh: Any) -> None:
    _bored(gmsh, [_link(gmsh, taken=11.0)])


def _ribbed(gmsh: Any) -> None:
    """A plate with a rib on one side only: its centroids stand beside the pins' plane."""
    rib = gmsh.model.occ.addBox(15, -3, 0, _LENGTH - 30, 6, 14)
    _bored(gmsh, [_link(gmsh, thick=5), rib])


def _slotted(gmsh: Any) -> None:
    """Two rails beside a long slot."""
    plate = _link(gmsh, width=34)
    slot = gmsh.model.occ.addBox(35, -9, -30, _LENGTH - 70, 18, 60)
    ((_, plate),), _ = gmsh.model.occ.cut([(3, plate)], [(3, slot)])
    _bored(gmsh, [plate])


def _profiled(gmsh: Any) -> None:
    """An I: pockets on both faces of a thick plate."""
    occ = gmsh.model.occ
    plate = _link(gmsh, thick=16)
    pockets = [(3, occ.addBox(18, -11, z, _LENGTH - 36, 22, 30)) for z in (2.0, -32.0)]
    ((_, plate),), _ = occ.cut([(3, plate)], pockets)
    _bored(gmsh, [plate])


def _stepped(gmsh: Any) -> None:
    """A rod of 10 mm and of 16 mm between square eyes."""
    occ = gmsh.model.occ
    eyes = [occ.addBox(x - 14, -14, -10, 28, 28, 20) for x in (0, _LENGTH)]
    thin = occ.addCylinder(10, 0, 0, 80, 0, 0, 5)
    thick = occ.addCylinder(85, 0, 0, _LENGTH - 95, 0, 0, 8)
    _bored(gmsh, [*eyes, thin, thick])


def _swan(gmsh: Any) -> None:
    """A link whose middle stands 12 mm beside the line of its pins."""
    occ = gmsh.model.occ
    at = [(-18, 0), (20, 0), (60, 12), (100, 12), (140, 0), (180, 0)]
    corners = [(x, y - 10) for x, y in at] + [(x, y + 10) for x, y in reversed(at)]
    points = [occ.addPoint(x, y, -4) for x, y in corners]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    solid = next(tag for dim, tag in occ.extrude([(2, face)], 0, 0, 8) if dim == 3)
    _bored(gmsh, [solid])


def _channel(gmsh: Any) -> None:
    """A U of 2.5 mm: open, thin, its web beside the pins' plane."""
    occ = gmsh.model.occ
    plate = _link(gmsh, width=30, thick=20)
    hollow = occ.addBox(-30, -12.5, -7.5, _LENGTH + 60, 25, 30)
    ((_, plate),), _ = occ.cut([(3, plate)], [(3, hollow)])
    _bored(gmsh, [plate])


ODD: dict[str, Callable[[Any], None]] = {
    "waisted": _waisted, "ribbed": _ribbed, "slotted": _slotted, "profiled": _profiled,
    "stepped": _stepped, "swan": _swan, "channel": _channel,
}  # fmt: skip


@dataclass(frozen=True)
class Sliced:
    """A part's share of its buckling load by its solid, by the bar, and the bound (or None)."""

    name: str
    shape: str
    solid: float
    bar: float
    most: float | None
    weakest: float | None
    by_stress: float


def of_part(name: str, part: Part, loads: PartLoads, solid: float, shape: str) -> Sliced | None:
    """The bar of a STEP part beside its solid's share; None where there is no formula."""
    model = shapes.model_of(part, loads)
    if model is None or model.buckling is None or not model.buckling.share > 0:
        return None
    load, most = model.buckling, None
    by_stress = stress_share(part, model)
    if load.weakest is not None:
        times = MOST_PULLED if load.pulled else MOST_FAR
        most = times * load.weakest + load.local * by_stress
    return Sliced(name, shape, solid, load.share, most, load.weakest, by_stress)


def as_step(part: Part, folder: Path) -> Part | None:
    """The part exported to STEP and read again; None where a pin is not in a bore."""
    faces = part.geometry.placed_interfaces
    if len(faces) != 2 or any(face.kind != "bore" for face in faces):
        return None
    path = write_step(folder / "part.step", part.geometry.build)
    holes = tuple(
        NamedHole(face.name, 2 * face.radius, (float(face.centre[0]), 0.0, float(face.centre[2])))
        for face in faces
    )
    return replace(part, geometry=StepPart(path, holes))


def exported() -> Iterator[Sliced | None]:
    """The shapes whose solids are known."""
    machines, truths, beyond = Machines(), with_buckling(), solids_beyond()
    for scene in SCENES:
        some: list[tuple[str, Part, PartLoads, float]] = []
        wanted = {
            name: line for name, line in truths.items() if name.rsplit("/", 1)[0] == scene.name
        }
        last = max((int(name.rsplit("/", 1)[1]) for name in wanted), default=-1)
        for variation in machines.variations(scene):
            if variation.number > last:
                break
            checks = wanted.get(variation.name, {}).get("checks", {}).values()
            some += [(variation.name, variation.part, variation.loads, one["value"])
                     for one in checks if one["kind"] == "buckling"]  # fmt: skip
        for way in ("", "pulled", "pushed") if scene.bounds else ():
            for number, (name, _, _, part, loads) in enumerate(drawn(machines, scene, way)):
                line = beyond.get(f"{name} buckled", {})
                if "buckling" in line.get("solid", {}):
                    some.append((name, part, loads, line["solid"]["buckling"][0]))
                if number > 12:
                    break
        for name, part, loads, solid in some:
            with TemporaryDirectory() as folder:
                step = as_step(part, Path(folder))
                yield step and of_part(name, step, loads, solid, part.shape)


def odd() -> Iterator[Sliced | None]:
    """Shapes that only CAD draws, as the rod of a crank and slider."""
    for name, build in ODD.items():
        with TemporaryDirectory() as folder:
            file = step_rod(Path(folder))
            write_step(Path(folder) / "rod.step", build)
            loaded, models = loaded_of(replace(CAMPAIGNS["step_rod"], file=file), ())
            asked = Asked(frozenset({"buckling"}), modes=False)
            checks = check_solid(loaded, models, asked=asked).checks
            solid = next(one.value for one in checks if one.method.startswith("solid"))
            yield of_part(name, loaded.part, loaded.loads, solid, "odd")


@one_thread()
def main() -> None:
    """Add to the record."""
    known = (
        {json.loads(line)["name"] for line in FILE.read_text().splitlines()}
        if FILE.exists()
        else set()
    )
    for one in odd() if sys.argv[1:] == ["odd"] else exported():
        if one is not None and one.name not in known:
            with FILE.open("a") as file:
                file.write(json.dumps(vars(one)) + "\n")


if __name__ == "__main__":
    main()
