"""A plate of a STEP file with another thickness: its outline extruded between its two flat faces.

Exact where every face is square to the pins or parallel to them, and those that are square stand
at two heights: then all sections across the pins are alike. Anything else has no thickness by
which it could be made, such as a rounded edge, a counterbore or a cross hole, and is refused.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from geometry.mesh import FloatArray
from geometry.meshing import gmsh_session
from geometry.parameters import ParameterError
from geometry.round_faces import grid
from geometry.step_file import StepSolid, file_hash, import_solid, measured

FIELD = "thickness"
_SQUARE = radians(1e-4)  # a face may slant by so much: 0.2 um on 100 mm, as files are rounded
_KEPT = 1e-6  # of volume over thickness: integrals of the kernel, and what a slant adds
_MOST_TOLD = 3


@lru_cache(maxsize=64)
def survey_plate(
    path: Path, digest: str, direction: tuple[float, float, float], thickness: float
) -> StepSolid:
    """Measure the plate of a STEP file of this SHA-256 with another thickness, mm.

    direction  unit vector square to its flat faces, in the file's frame

    Raises ParameterError (field "thickness") of a solid that is no plate across it; MeshError where
    gmsh is not to be loaded.
    """
    with gmsh_session() as gmsh:
        tag, told = import_solid(gmsh, path)
        solid = measured(gmsh, extruded(gmsh, tag, direction, thickness), told)
    if file_hash(path) != digest:
        raise ParameterError("shape", f"{path.name!r} was written while it was read")
    return solid


def extruded(gmsh: Any, solid: int, direction: Sequence[float], thickness: float) -> int:
    """Put a plate of a thickness, mm, in the place of that in gmsh's model; return its tag.

    Its middle plane stays where it was. Raises ParameterError as `survey_plate` does.
    """
    axis, occ = np.array(direction), gmsh.model.occ
    low, high = _flat_faces(gmsh, solid, axis)
    ends = [float(np.mean([height for _, height in end])) for end in (low, high)]
    whole = low if len(low) == 1 else high
    if len(whole) > 1:
        raise ParameterError(
            FIELD,
            "cannot be another one than the file's: both flat faces are in pieces "
            f"({len(low)} and {len(high)}); unite them in CAD",
        )
    face, drawn = whole[0][0], ends[1] - ends[0]
    inwards = axis if whole is low else -axis
    area = occ.getMass(3, solid) / drawn
    try:
        made = occ.extrude(occ.copy([(2, face)]), *(thickness * inwards))
        (plate,) = (entity for entity in made if entity[0] == 3)
    except Exception as error:  # gmsh raises bare Exception only
        raise ParameterError(FIELD, f"the CAD kernel could not extrude it: {error}") from None
    occ.remove([(3, solid)], recursive=True)
    # moved last: gmsh then numbers faces and edges as it does whenever they are moved again
    occ.translate([plate], *((drawn - thickness) / 2 * inwards))
    occ.synchronize()
    if abs(occ.getMass(*plate) / thickness / area - 1) > _KEPT:
        raise ParameterError(FIELD, "the CAD kernel changed the outline as it extruded the plate")
    return int(plate[1])


def _flat_faces(
    gmsh: Any, solid: int, axis: FloatArray
) -> tuple[list[tuple[int, float]], list[tuple[int, float]]]:
    """Faces square to the axis with their heights along it, mm: at the low end and at the high one.

    Raises ParameterError unless all other faces are parallel to it.
    """
    flat: list[tuple[int, float]] = []
    askew: list[str] = []
    box = np.array(gmsh.model.getBoundingBox(3, solid))
    near = _SQUARE * float(np.linalg.norm(box[3:] - box[:3]))
    for _, face in gmsh.model.getBoundary([(3, solid)], oriented=False):
        points, normals = (every.reshape(-1, 3) for every in grid(gmsh, face))
        along = normals @ axis
        if np.abs(along).max() < _SQUARE:
            continue
        heights = points @ axis
        if np.linalg.norm(np.cross(normals, axis), axis=1).max() < _SQUARE:
            flat.append((face, float(heights.mean())))
        else:
            middle = ", ".join(f"{x:.4g}" for x in gmsh.model.occ.getCenterOfMass(2, face))
            askew.append(f"{gmsh.model.getType(2, face).lower()} about ({middle}) mm")
    if askew:
        more = f" and {len(askew) - _MOST_TOLD} more" if len(askew) > _MOST_TOLD else ""
        raise ParameterError(
            FIELD,
            "cannot be another one than the file's: it has faces that are neither square to the "
            f"pins nor parallel to them, such as a rounded edge, a chamfer, a draft or a cross "
            f"hole: {'; '.join(askew[:_MOST_TOLD])}{more}; change the thickness in CAD",
        )
    found = sorted(height for _, height in flat)
    levels = [here for here, before in zip(found, [-np.inf, *found], strict=False)
              if here - before > near]  # fmt: skip
    if len(levels) != 2:
        told = ", ".join(f"{level - levels[0]:.6g}" for level in levels)
        raise ParameterError(
            FIELD,
            f"cannot be another one than the file's: its faces square to the pins stand at "
            f"{len(levels)} heights ({told} mm), those of a plate at two; change the thickness in "
            "CAD",
        )
    between = sum(levels) / 2
    return [one for one in flat if one[1] < between], [one for one in flat if one[1] > between]
