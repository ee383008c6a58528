"""Results as files: JSON for programs, VTU for ParaView. A file is there whole or not at all."""

import json
import os
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.verdict import DesignResult, PartResult

FORMAT = "ballesta-result/1"
_on_a_line = json.JSONEncoder(allow_nan=False, ensure_ascii=False).encode


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Path to write to, beside `path`, which it replaces in one step when all went well."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        yield temporary
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it is whole or as before, also after the machine has lost its power."""
    with replacing(path) as temporary, temporary.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def plain(data: Any) -> Any:
    """Plain data as JSON knows it: arrays as lists, null for what is infinite or no number."""
    if type(data) is float:
        return data if isfinite(data) else None
    if isinstance(data, str):  # a lone half of a surrogate pair cannot be written as UTF-8
        return data if data.isascii() else data.encode(errors="replace").decode()
    if data is None or isinstance(data, bool):
        return data
    if isinstance(data, list | tuple) and all(type(item) is float for item in data):
        return [item if isfinite(item) else None for item in data]
    if isinstance(data, Mapping):
        return {plain(str(key)): plain(value) for key, value in data.items()}
    if isinstance(data, np.ndarray | np.generic):
        return plain(data.tolist())
    if isinstance(data, int):
        return int(data)
    if isinstance(data, float):
        return float(data) if isfinite(data) else None
    if isinstance(data, Sequence):
        return [plain(item) for item in data]
    if isinstance(data, Path):
        return plain(str(data))
    raise TypeError(f"a result holds {type(data).__name__}, which no JSON file can")


def write_json(result: DesignResult, path: str | Path) -> None:
    """Write the result as JSON: keys in the order of the result, numbers to the last digit.

    A list of numbers stands on one line.
    """
    text = _over_lines(plain(result.to_dict()))
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8", newline="\n")


def _over_lines(data: Any, start: str = "\n") -> str:
    """JSON with a line for each value: `json.dumps` does that in Python, number by number."""
    within = f"{start} "
    if isinstance(data, dict) and data:
        lines = [f"{_on_a_line(key)}: {_over_lines(item, within)}" for key, item in data.items()]
        return f"{{{within}{f',{within}'.join(lines)}{start}}}"
    if isinstance(data, list) and any(isinstance(item, str | list | dict) for item in data):
        lines = [_over_lines(item, within) for item in data]
        return f"[{within}{f',{within}'.join(lines)}{start}]"
    return _on_a_line(data)


def read_json(path: str | Path) -> dict[str, Any]:
    """Read what `write_json` wrote, as plain data."""
    data = json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_refuse)
    found = data.get("format") if isinstance(data, dict) else type(data).__name__
    if found != FORMAT:
        raise ValueError(f"{path}: expected a result of format {FORMAT!r}, got {found!r}")
    assert isinstance(data, dict)
    return data


def _refuse(constant: str) -> None:
    raise ValueError(f"a result holds no {constant}, it would be null")


def write_volume(
    path: Path,
    nodes: npt.NDArray[np.float64],
    elements: npt.NDArray[np.int64],
    fields: Mapping[str, npt.NDArray[np.float64]],
) -> None:
    """Write ten-node tetrahedra with fields at their nodes as .vtu, in single precision."""
    import meshio

    mesh = meshio.Mesh(
        nodes.astype(np.float32),
        [("tetra10", elements)],
        point_data={name: values.astype(np.float32) for name, values in fields.items()},
    )
    with replacing(path) as temporary:
        meshio.write(temporary, mesh, file_format="vtu")


def write_pvd(path: Path, steps: Sequence[tuple[float, str]]) -> None:
    """Write a ParaView collection: (time, file beside it) for each step."""
    from xml.sax.saxutils import quoteattr  # loads the modules of network connections: 50 ms

    lines = [
        f'<DataSet timestep="{time:.9g}" part="0" file={quoteattr(file)}/>' for time, file in steps
    ]
    text = "\n".join(
        ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1"><Collection>', *lines]
    )
    with replacing(path) as temporary:
        temporary.write_text(f"{text}\n</Collection></VTKFile>\n", encoding="utf-8")


def write_vtu(part: PartResult, path: str | Path) -> None:
    """Write the surface of a part with its fields, mm and the unit that the field's name states.

    Displacement is a vector, stress a symmetric tensor, in ParaView's order of the six components.
    """
    import meshio

    surface = part.surface
    mesh = meshio.Mesh(
        np.asarray(surface.nodes, dtype=float),
        [("triangle", np.asarray(surface.triangles, dtype=np.int64))],
        point_data={
            name: np.asarray(values)
            for name, values in (*surface.fields.items(), *surface.directed.items())
        },
    )
    with replacing(path) as temporary:
        meshio.write(temporary, mesh, file_format="vtu")
