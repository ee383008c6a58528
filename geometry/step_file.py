"""The one solid of a STEP file that is a part, measured in mm, with its round faces."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from geometry.bounded_files import MOST_CAD, read_bounded
from geometry.mesh import FloatArray
from geometry.meshing import gmsh_session
from geometry.parameters import ParameterError
from geometry.round_faces import Curvature, Hole, round_faces

_START = b"ISO-10303-21;"
_MOST_FACES = 1000  # beyond it, whether faces cross would take longer to find out than to mesh
_ALONG_EDGE = 17  # points that tell where an edge goes
_SLIVER = 1e-5  # of a face: pieces below it are the tolerance of its edges


@dataclass(frozen=True, eq=False)
class StepSolid:
    """The solid of a STEP file, in the file's own frame.

    volume, area  mm3, mm2
    centre        (3,) mm, of its volume
    outline       (n, 3) mm, points along its edges, by which its size in a direction is known
    tag           of the solid in gmsh, the same whenever the file is read
    holes         every bore and journal that goes all the way round
    partial       in words, the cylinders that do not
    curved        every curved face but journals
    told          in words, what else the file has, or what could not be found out
    """

    volume: float
    area: float
    centre: FloatArray
    outline: FloatArray
    tag: int
    holes: tuple[Hole, ...]
    partial: tuple[str, ...]
    curved: tuple[Curvature, ...]
    told: tuple[str, ...]

    @property
    def wall(self) -> float:
        """Thickness of a thin wall of this volume and surface, mm: 2 V / A."""
        return 2 * self.volume / self.area


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file; ParameterError where there is none."""
    try:
        return sha256(read_bounded(path, MOST_CAD)).hexdigest()
    except OSError as error:
        said = (error.strerror or str(error)).lower()
        raise ParameterError("shape", f"{path.name!r} cannot be read: {said}") from None


def survey_step(path: Path) -> StepSolid:
    """Read and measure the solid of a STEP file.

    Raises ParameterError (field "shape") unless the file holds exactly one valid solid.
    """
    with gmsh_session() as gmsh:
        tag, told = import_solid(gmsh, path)
        holes, partial, curved = round_faces(gmsh, tag)
        faces = [face for _, face in gmsh.model.getBoundary([(3, tag)], oriented=False)]
        solid = StepSolid(
            volume=float(gmsh.model.occ.getMass(3, tag)),
            area=float(sum(gmsh.model.occ.getMass(2, face) for face in faces)),
            centre=np.array(gmsh.model.occ.getCenterOfMass(3, tag)),
            outline=_outline(gmsh),
            tag=tag,
            holes=tuple(holes),
            partial=tuple(partial),
            curved=tuple(curved),
            told=told,
        )
        crossing = _crossing(gmsh, path.name, faces)
    return solid if crossing is None else replace(solid, told=(*solid.told, crossing))


def import_solid(gmsh: Any, path: Path) -> tuple[int, tuple[str, ...]]:
    """Read a STEP file into gmsh's current model, in mm: tag of its one solid, what was left out.

    Raises ParameterError (field "shape") in the words of somebody who exports from CAD.
    """
    name = path.name
    try:
        with path.open("rb") as file:
            start = file.read(256)
    except OSError as error:
        said = (error.strerror or str(error)).lower()
        raise ParameterError("shape", f"{name!r} cannot be read: {said}") from None
    if not start.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(_START):
        raise ParameterError(
            "shape",
            f"{name!r} is no STEP file, which would begin with {_START.decode()!r}: export the "
            "part from CAD as STEP (AP203, AP214 or AP242)",
        )
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    try:
        with _quiet():
            gmsh.model.occ.importShapes(str(path), highestDimOnly=False, format="step")
    except Exception:  # gmsh raises bare Exception only
        raise ParameterError(
            "shape", f"{name!r} cannot be read: it is damaged or cut off; export it from CAD again"
        ) from None
    gmsh.model.occ.synchronize()
    tag = _only_solid(gmsh, name)
    left_out = _remove_others(gmsh, tag)
    told = (f"{name} also has {left_out}, which are left out",) if left_out else ()
    _check_volume(gmsh, name, tag)
    return tag, told


def _only_solid(gmsh: Any, name: str) -> int:
    solids = [tag for _, tag in gmsh.model.getEntities(3)]
    if len(solids) == 1:
        return int(solids[0])
    if not solids:
        faces, curves = (len(gmsh.model.getEntities(dimension)) for dimension in (2, 1))
        if not faces and not curves:
            raise ParameterError("shape", f"{name!r} has no geometry; export the part as a solid")
        found = _count(faces, "face") if faces else _count(curves, "curve")
        raise ParameterError(
            "shape",
            f"{name!r} has no solid, only {found}; close the part in CAD (sew or knit its surfaces "
            "to a solid) and export the solid",
        )
    volumes = ", ".join(f"{gmsh.model.occ.getMass(3, tag) / 1e3:.4g} cm3" for tag in solids[:6])
    more = ", ..." if len(solids) > 6 else ""
    raise ParameterError(
        "shape",
        f"{name!r} has {len(solids)} solids of {volumes}{more}, a part is one; export the part "
        "alone instead of the assembly, or unite its bodies in CAD",
    )


def _remove_others(gmsh: Any, solid: int) -> str:
    """Remove faces and curves that do not bound the solid; return them in words."""
    own = {(3, solid)}
    for dimension in (3, 2, 1):
        entities = [entity for entity in own if entity[0] == dimension]
        own |= {
            (dim, abs(tag))
            for dim, tag in gmsh.model.getBoundary(entities, combined=False, oriented=False)
        }
    others = [e for e in gmsh.model.getEntities() if e not in own and e[0] < 3]
    if not others:
        return ""
    faces = [face for dimension, face in others if dimension == 2]
    below = {
        tag
        for face in faces
        for _, tag in gmsh.model.getBoundary([(2, face)], combined=False, oriented=False)
    }
    curves = [curve for dimension, curve in others if dimension == 1 and curve not in below]
    for dimension in (2, 1, 0):
        gmsh.model.occ.remove([entity for entity in others if entity[0] == dimension])
    gmsh.model.occ.synchronize()
    counted = [(len(faces), "loose face"), (len(curves), "loose curve")]
    return " and ".join(_count(number, what) for number, what in counted if number)


def _check_volume(gmsh: Any, name: str, solid: int) -> None:
    """ParameterError unless the solid's faces enclose a volume."""
    box = np.array(gmsh.model.getBoundingBox(3, solid))
    size = float(np.linalg.norm(box[3:] - box[:3]))
    if not gmsh.model.occ.getMass(3, solid) > 1e-9 * size**3:
        raise ParameterError(
            "shape",
            f"{name!r} has a solid without a volume: its faces cross; repair it in CAD and export "
            "it again",
        )


def _outline(gmsh: Any) -> FloatArray:
    points = []
    for _, curve in gmsh.model.getEntities(1):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
        points.append(gmsh.model.getValue(1, curve, np.linspace(low, high, _ALONG_EDGE)))
    return np.concatenate(points).reshape(-1, 3)


def _crossing(gmsh: Any, name: str, faces: list[int]) -> str | None:
    """Raise ParameterError where faces of the solid cross; return why that is unknown, or None.

    All faces are cut by each other, which leaves the faces of a valid solid as they are. gmsh's
    model is of no use afterwards.
    """
    unknown = f"whether faces of {name} cross was not found out"
    if len(faces) > _MOST_FACES:
        return f"{unknown}: it has {len(faces)} faces; a mesh could not be made if they did"
    occ = gmsh.model.occ
    middles = {face: occ.getCenterOfMass(2, face) for face in faces}
    try:
        with _quiet():
            _, pieces = occ.fragment([(2, face) for face in faces], [])
    except Exception as error:  # gmsh raises bare Exception only
        return f"{unknown}: the CAD kernel gave up ({error}); a mesh could not be made if they did"
    owners: dict[int, int] = {}
    crossed = []
    for face, parts in zip(faces, pieces, strict=True):
        areas = np.array([occ.getMass(2, tag) for _, tag in parts])
        whole = np.count_nonzero(areas > _SLIVER * areas.sum())
        shared = any(tag in owners for _, tag in parts)
        owners |= {tag: face for _, tag in parts}
        if whole > 1 or shared:
            crossed.append(face)
    if not crossed:
        return None
    places = "; ".join(
        "(" + ", ".join(f"{value:.4g}" for value in middles[face]) + ")" for face in crossed[:4]
    )
    raise ParameterError(
        "shape",
        f"{name!r} has a solid that crosses itself: {_count(len(crossed), 'face')} cut by others, "
        f"about {places} mm; repair it in CAD and export it again",
    )


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what OpenCASCADE prints from standard output, where a result may be expected."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
