"""Every shape of geometry.parts as a page, described by its own code, and its pictures.

`python tools/describe_parts.py` draws the pictures, `python tools/reference.py` writes the page.
"""

import dataclasses
import inspect
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import parts_pictures

from geometry.mesh import Interface
from geometry.meshing import gmsh_session, mesh_shape
from geometry.outlines import Contour, PlateOutline
from geometry.parameters import GIVEN_BY_DESIGN, GIVEN_BY_LINKAGE
from geometry.parts import (
    SHAPES,
    Beam,
    IBeam,
    LeafPack,
    Pin,
    PinHole,
    PlateLink,
    PrismaticTube,
    RhsBeam,
    Seat,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.parts.plate import Eye, Plate, PlateBore, lever_outline


def plate_of(outline: PlateOutline, eyes: Sequence[Eye], thickness: float) -> Plate:
    """A plate with bores where the eyes are."""
    bores = [PlateBore(eye.name, eye.hole, (eye.centre.real, eye.centre.imag)) for eye in eyes]
    return Plate(outline, tuple(bores), thickness)


ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "parts.md"
PICTURES = PAGE.parent / "parts"
_HOLES = (PinHole("A", at=0.0, diameter=20.0, boss=34.0),
          PinHole("C", at=230.0, diameter=20.0, boss=34.0),
          PinHole("B", at=100.0, diameter=26.0, boss=44.0))  # fmt: skip
# Short and thick, so that a small picture shows them; and how fine each is meshed for it.
DRAWN: dict[str, tuple[Any, float]] = {
    "toggle_bar": (
        ToggleBar(
            length=170, width=80, wall=6.3, hole=44, overhang=40, inner_radius=3,
            cutout_length=56, cutout_corner=5,
        ),
        0.45,
    ),
    "rhs_beam": (
        RhsBeam(
            holes=_HOLES, overhang=30, fillet=3, height=80, width=44, wall=5, corner=9,
        ),
        0.45,
    ),
    "i_beam": (
        IBeam(
            holes=_HOLES, overhang=30, fillet=3, height=96, width=60, web=5, flange=8, root=8,
            boss_width=44,
        ),
        0.45,
    ),
    "prismatic_tube": (PrismaticTube(length=100, width=30, wall=3), 0.6),
    "pin": (
        Pin(
            seats=(Seat("lug", at=27, width=10), Seat("eye", width=30, diameter=20)),
            diameter=25,
            step_fillet=1.5,
        ),
        0.6,
    ),
    "plate_link": (PlateLink(length=100, width=30, thickness=10, hole=14), 0.7),
    "tube_rod": (
        TubeRod(
            length=110, tube_diameter=20, wall=2.5, eye_diameter=34, eye_width=24, hole=16, fillet=8
        ),
        0.6,
    ),
    "slotted_lever": (
        SlottedLever(
            length=200, width=40, thickness=12, hole=12, slot_width=16, slot_from=28, slot_to=180,
            overhang=20, boss_diameter=28, boss_height=10,
        ),
        0.7,
    ),
    "leaf_pack": (
        LeafPack(
            length=120, leaves=3, width=40, thickness=9.6, arm=140, overhang=25, clamp_length=40,
            rod_length=30, contact_from=90, contact_to=125, contact_length=10,
        ),
        0.6,
    ),
}  # fmt: skip
_EYES = (Eye("tail", 0j, 12.0, 30.0), Eye("pivot", 80 + 0j, 20.0, 46.0),
         Eye("head", 80 + 60j, 12.0, 30.0))  # fmt: skip
_CURVED = Contour.of(
    (-24 - 20j, 60 - 20j, 110 + 6j, 110 + 46j, 40 + 62j, -24 + 16j),
    (0.0, 0.25, 1.0, -0.12, 0.2, 0.3),
)
# Plates are no shapes with parameters of their own: docs/plates.md shows these.
PLATES: dict[str, tuple[Any, float]] = {
    "lever": (plate_of(lever_outline(_EYES, 12.0), _EYES, 12.0), 0.5),
    "plate": (
        plate_of(
            PlateOutline(
                _CURVED,
                (Contour.round(0j, 8), Contour.round(110 + 26j, 9), Contour.round(38 + 40j, 6),
                 Contour.round(56 + 12j, 14)),
            ),
            (Eye("A", 0j, 16.0, 0.0), Eye("B", 110 + 26j, 18.0, 0.0),
             Eye("C", 38 + 40j, 12.0, 0.0)),
            10.0,
        ),
        0.5,
    ),
}  # fmt: skip
KINDS = {
    "bore": "a pin presses inside a hole",
    "journal": "a lug presses around the pin",
    "face": "a cut end carries the load",
    "clamp": "faces normal to y are squeezed and carried",
    "slide": "a contact moves along x, on one of two faces normal to y",
}
WHO = {GIVEN_BY_DESIGN: "design file", GIVEN_BY_LINKAGE: "linkage"}
HEAD = """\
# The parts

Written by `python tools/reference.py` from `geometry/parts/`; do not edit.

A part of a design file has one of the shapes below. Parameters are lengths with a unit, such as
`"6.3 mm"`, numbers, or whole numbers; what the linkage gives must not be stated. A part that is a
body of the linkage lies along x: its first interface is at the origin, its second at x = `length`,
and z points out of the linkage's plane. It is symmetric about z = 0. At its interfaces other parts
press. Pictures show parts that are shorter than most.
"""
TAIL = """\
## Another part

The geometry of a shape is one file, its formulas are another ([extending](extending.md)). Copy a
short one, `geometry/parts/prismatic_tube.py`, and

1. give the shape its `name`, by which design files call it: it is found by being there;
2. declare its parameters as fields of the frozen dataclass, with `a_length`, `a_number` or
   `a_count` of `geometry/parameters.py`: that one line serves the design file, its schema, its
   messages and this page;
3. refuse in `__post_init__` what cannot be built, with a `ParameterError` that names the parameter,
   the value found and the nearest right one;
4. name its places in `interfaces`, the two pins first, and state what `geometry/shape.py` asks of
   every shape (`placed_interfaces`, `stressed_section`, `ruling_sections`), and of what has it
   `sections` (for columns), `proportions` (for error bars) and `notch_factors`;
5. build it in `build(gmsh)` with gmsh's OpenCASCADE kernel and return a `Body`: CAD faces by name,
   an `Interface` for each place, a general element size, and regions of smaller ones;
6. enter it in `DRAWN` of this tool;
7. test what you can work out by hand: mass, centre, inertia, areas of its surfaces, and every
   refusal (`tests/geometry/`).
"""


def page() -> str:
    """The text of docs/parts.md."""
    return "\n".join([HEAD, *(_described(name, shape) for name, shape in SHAPES.items()), TAIL])


def _described(name: str, shape: type[Any]) -> str:
    example, _ = DRAWN[name]
    lines = [f"## {name}", "", inspect.cleandoc(shape.__doc__ or ""), ""]
    lines += [f"![{name}](parts/{name}.svg)", ""]
    lines += ["| Interface | Kind | What happens there | Surfaces |", "| --- | --- | --- | --- |"]
    for interface in _interfaces(example):
        surfaces = ", ".join(f"`{surface}`" for surface in interface.surfaces)
        label = interface.name
        if not shape.fixed_interfaces():
            label = f"a {'seat' if shape is Pin else 'hole'}, such as {interface.name}"
        lines.append(f"| {label} | {interface.kind} | {KINDS[interface.kind]} | {surfaces} |")
    lines += ["", *_table(shape)]
    if shape is Pin:
        lines += [
            "",
            f"Each of its seats: {inspect.cleandoc(Seat.__doc__ or '')}",
            "",
            *_table(Seat),
        ]
    if issubclass(shape, Beam):
        lines += ["", "Each of its holes, in the table `holes`:", "", *_table(PinHole)]
    factors = ", ".join(f"{value:g} at `{where}`" for where, value in example.notch_factors.items())
    lines += ["", f"Fatigue notch factor, unless stated: {factors}."] if factors else []
    return "\n".join([*lines, ""])


def _interfaces(shape: Any) -> list[Interface]:
    with gmsh_session() as gmsh:
        return list(shape.build(gmsh).interfaces)


def _table(shape: type[Any]) -> list[str]:
    lines = ["| Parameter | Meaning | Kind | Without it | Given by |"]
    lines.append("| --- | --- | --- | --- | --- |")
    for field in dataclasses.fields(shape):
        facts = field.metadata
        if not facts:  # the name of a seat, the seats of a pin: the design file's stack
            continue
        without = _default(field.default, facts["dimension"])
        who = WHO[facts["given_by"]]
        lines.append(
            f"| `{field.name}` | {facts['meaning']} | {facts['dimension']} | {without} | {who} |"
        )
    return lines


def _default(value: object, dimension: str) -> str:
    if value is dataclasses.MISSING:
        return "must be stated"
    if value is None:
        return "see its meaning"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g} mm" if dimension == "length" else f"{value:g}"


def main() -> None:
    """Draw the pictures."""
    PICTURES.mkdir(exist_ok=True)
    for name, (shape, fineness) in (DRAWN | PLATES).items():
        parts_pictures.draw(mesh_shape(shape, fineness=fineness), PICTURES / f"{name}.svg")


if __name__ == "__main__":
    main()
