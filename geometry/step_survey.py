"""Survey of a STEP file in a process of its own: a damaged file can kill or hold the CAD kernel.

The process has limits on time and memory; what came of a file is kept for as long as ours runs.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from geometry.mesh import MeshError
from geometry.parameters import ParameterError
from geometry.round_faces import Curvature, Hole
from geometry.step_file import StepSolid, file_hash, survey_step

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
    command = [sys.executable, "-m", "geometry.step_survey", str(path.resolve()), digest]
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
