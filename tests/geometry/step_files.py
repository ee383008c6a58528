"""STEP files of small parts, written by gmsh's OpenCASCADE kernel as CAD programs do."""

from dataclasses import fields
from pathlib import Path

from geometry.meshing import gmsh_session
from geometry.parts import PlateLink
from geometry.parts.step_part import NamedHole, StepPart

LINK = PlateLink(length=60, width=24, thickness=8, hole=10, second_hole=12)
HOLES = (NamedHole("first", 10), NamedHole("second", 12))
_MILLIMETRE = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )"
_INCH = """( CONVERSION_BASED_UNIT('INCH',#90001) LENGTH_UNIT() NAMED_UNIT(#90002) );
#90001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90003);
#90002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
#90003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )"""


def write_step(path: Path, *builders) -> Path:
    """Write what the builders leave in gmsh's model, one after the other; each takes gmsh."""
    with gmsh_session() as gmsh:
        for build in builders:
            build(gmsh)
        gmsh.model.occ.synchronize()
        loose = [p for p in gmsh.model.getEntities(0) if not len(gmsh.model.getAdjacencies(*p)[0])]
        gmsh.model.occ.remove(loose)  # middles of arcs
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def scaled_link(factor):
    """Builder: the plate link, larger."""
    sizes = {size.name: factor * getattr(LINK, size.name) for size in fields(LINK)}
    return PlateLink(**sizes).build


def moved(axis, angle, by):
    """Builder: everything turned about an axis through the origin, rad, then shifted, mm."""

    def move(gmsh):
        occ = gmsh.model.occ
        occ.rotate(occ.getEntities(3), 0, 0, 0, *axis, angle)
        occ.translate(occ.getEntities(3), *by)

    return move


def in_inches(path: Path) -> Path:
    """Say of a file in mm that its numbers are inches."""
    path.write_text(_replaced(path.read_text(), _MILLIMETRE, _INCH))
    return path


def in_metres(path: Path) -> Path:
    """Say of a file in mm that its numbers are metres."""
    path.write_text(_replaced(path.read_text(), "SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"))
    return path


def _replaced(text, old, new):
    assert text.count(old) == 1
    return text.replace(old, new)


def plate_with(*tools, size=(100, 40, 8)):
    """Builder: a plate from x = y = -20, z = 0, less cylinders (x, y, z, dx, dy, dz, radius)."""

    def build(gmsh):
        occ = gmsh.model.occ
        plate = occ.addBox(-20, -20, 0, *size)
        occ.cut([(3, plate)], [(3, occ.addCylinder(*tool)) for tool in tools])

    return build


def hole(x, y, diameter):
    """A hole through the plate."""
    return (x, y, -1, 0, 0, 10, diameter / 2)


def link_file(folder: Path, *changes) -> Path:
    """The plate link as a STEP file."""
    return write_step(folder / "link.step", LINK.build, *changes)


def link_part(path: Path, **values) -> StepPart:
    """The plate link as CAD has it."""
    return StepPart(path, HOLES, **values)
