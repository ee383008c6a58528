"""The one solid of a STEP file that is a part, measured in mm, with its round faces.

A plate gets another thickness as its outline, extruded between its two flat faces. That is exact
where every face is square to the pins or parallel to them, and those that are square stand at two
heights: then all sections across the pins are alike. Anything else has no thickness by which it
could be made, such as a rounded edge, a counterbore or a cross hole, and is refused.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from hashlib import sha256
from math import radians
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, MeshError
from geometry.meshing import gmsh_session
from geometry.parameters import MOST_CAD, ParameterError, read_bounded
from geometry.round_faces import Curvature, Hole, grid, round_faces

_START = b"ISO-10303-21;"
_MOST_FACES = 1000  # beyond it, whether faces cross would take longer to find out than to mesh
_ALONG_EDGE = 17  # points that tell where an edge goes
_SLIVER = 1e-5  # of a face: pieces below it are the tolerance of its edges
FIELD = "thickness"
_SQUARE = radians(1e-4)  # a face may slant by so much: 0.2 um on 100 mm, as files are rounded
_KEPT = 1e-6  # of volume over thickness: integrals of the kernel, and what a slant adds
_MOST_TOLD = 3


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
        solid = measured(gmsh, tag, told)
        faces = _faces(gmsh, tag)
        crossing = _crossing(gmsh, path.name, faces)
    return solid if crossing is None else replace(solid, told=(*solid.told, crossing))


def measured(gmsh: Any, tag: int, told: tuple[str, ...]) -> StepSolid:
    """Measure a solid in gmsh's current model; told: in words, what else its file has."""
    holes, partial, curved = round_faces(gmsh, tag)
    occ = gmsh.model.occ
    return StepSolid(
        volume=float(occ.getMass(3, tag)),
        area=float(sum(occ.getMass(2, face) for face in _faces(gmsh, tag))),
        centre=np.array(occ.getCenterOfMass(3, tag)),
        outline=_outline(gmsh),
        tag=tag,
        holes=tuple(holes),
        partial=tuple(partial),
        curved=tuple(curved),
        told=told,
    )


def _faces(gmsh: Any, solid: int) -> list[int]:
    return [face for _, face in gmsh.model.getBoundary([(3, solid)], oriented=False)]


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


# Survey of a STEP file in a process of its own: a damaged file can kill or hold the CAD kernel.
# It has limits on time and memory; what came of a file is kept for as long as our process runs.
SECONDS = 60.0  # of processor time; a file of 1000 faces takes a few
MEMORY = 3 * 2**30  # bytes
_SLOWEST = 10.0  # times the processor time that it may take by the clock
_LOOK_EVERY = 0.02  # s
_PLACE = Path(__file__).resolve().parent.parent  # from where the worker's modules are imported
_CURE = "export it from CAD again, or repair it there"

_kept: dict[tuple[str, str], StepSolid | str] = {}  # by name and digest: what it holds, or problem


def surveyed(path: Path, digest: str) -> StepSolid:
    """Return the solid that `step_file.survey_step` finds in a file of this SHA-256.

    Raises ParameterError (field "shape") as that does, and where the file ends or holds the
    process, or takes too much memory; MeshError where gmsh is not to be loaded.
    """
    key = (path.name, digest)
    if key not in _kept:
        _kept[key] = _survey(path, digest)
    found = _kept[key]
    if isinstance(found, str):
        raise ParameterError("shape", found)
    return found


def _survey(path: Path, digest: str) -> StepSolid | str:
    command = [sys.executable, "-m", "geometry.step_file", str(path.resolve()), digest]
    with tempfile.TemporaryFile() as output:
        try:
            process = subprocess.Popen(
                command, cwd=_PLACE, stdin=subprocess.DEVNULL, stdout=output,
                stderr=subprocess.DEVNULL,
            )  # fmt: skip
        except OSError as error:
            return f"{path.name!r} cannot be read: no process starts for it ({error.strerror})"
        try:
            over = _over_its_limits(process)
        finally:
            process.kill()
            process.wait()
        output.seek(0)
        lines = output.read().decode(errors="replace").splitlines()
    if over:
        return f"{path.name!r} cannot be read: the CAD kernel took more than {over}; {_CURE}"
    try:
        reply = json.loads(lines[-1])
    except (IndexError, ValueError):
        return f"{path.name!r} cannot be read: the CAD kernel crashed on it; {_CURE}"
    if "no_gmsh" in reply:
        raise MeshError(reply["no_gmsh"])
    return str(reply["problem"]) if "problem" in reply else from_plain(reply)


def _over_its_limits(process: subprocess.Popen[bytes]) -> str:
    """Wait until a process ends; "" then, else in words what it took too much of."""
    import psutil

    begun = monotonic()
    try:
        watched = psutil.Process(process.pid)
        while process.poll() is None:
            times = watched.cpu_times()
            if times.user + times.system > SECONDS or monotonic() - begun > _SLOWEST * SECONDS:
                return f"{SECONDS:g} s"
            if watched.memory_info().rss > MEMORY:
                return f"{MEMORY / 2**30:g} GiB of memory"
            try:
                process.wait(_LOOK_EVERY)
            except subprocess.TimeoutExpired:
                continue
    except psutil.Error:  # it has just ended
        process.wait()
    return ""


def to_plain(solid: StepSolid) -> dict[str, Any]:
    """A survey as plain data; numbers keep their last bit in JSON."""
    return {name: _listed(value) for name, value in asdict(solid).items()}


def _listed(data: Any) -> Any:
    if isinstance(data, dict):
        return {name: _listed(value) for name, value in data.items()}
    if isinstance(data, list | tuple):
        return [_listed(value) for value in data]
    return data.tolist() if isinstance(data, np.ndarray | np.generic) else data


def from_plain(data: Mapping[str, Any]) -> StepSolid:
    """The survey that `to_plain` has made plain."""
    arrays = {name: np.array(data[name], dtype=float) for name in ("centre", "outline")}
    tuples = {
        "holes": tuple(_hole(hole) for hole in data["holes"]),
        "partial": tuple(data["partial"]),
        "curved": tuple(Curvature(**face) for face in data["curved"]),
        "told": tuple(data["told"]),
    }
    return StepSolid(**{**data, **arrays, **tuples})


def _hole(data: Mapping[str, Any]) -> Hole:
    arrays = {name: np.array(data[name], dtype=float) for name in ("centre", "direction")}
    return Hole(**{**data, **arrays, "faces": tuple(data["faces"])})


def main() -> None:
    """Survey the file of the first argument, whose SHA-256 is the second."""
    path, digest = Path(sys.argv[1]), sys.argv[2]
    try:
        solid = survey_step(path)
        if file_hash(path) != digest:
            raise ParameterError("shape", f"{path.name!r} was written while it was read")
        reply = to_plain(solid)
    except ParameterError as error:
        reply = {"problem": error.problem}
    except MeshError as error:
        reply = {"no_gmsh": str(error)}
    except Exception as error:  # gmsh raises bare Exception; of damaged shapes anything goes wrong
        told = " ".join(str(error).split())[:200] or type(error).__name__
        reply = {
            "problem": f"{path.name!r} has a shape that cannot be measured ({told}): it is "
            "damaged; repair it in CAD and export it again"
        }
    print(f"\n{json.dumps(reply, allow_nan=False)}")


if __name__ == "__main__":
    main()


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
