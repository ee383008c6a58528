"""Digests of all that a result depends on: inputs by stage, code, libraries.

Equal digests mean equal bits in. Nothing is compared by its printed form: what has no canonical
form here is refused.
"""

import hashlib
import platform
import struct
import sys
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem.threads import policy

if TYPE_CHECKING:
    from checks.design.data import Design, Part

PACKAGES = ("ballesta", "reports", "checks", "fem", "fatigue", "loads", "geometry")
_LIBRARIES = (
    "gmsh", "mkl", "numpy", "pypardiso", "rainflow", "scikit-fem", "scikit-sparse", "scipy"
)  # fmt: skip
_MESH = ("fineness", "most_unknowns")
_GEOMETRY = ("shape", "geometry")
_NOT_LOADS = frozenset(
    ["name", "file", "source", "sources", "sha256", "inputs", "overrides", "accuracy", "require",
     "duty", "parts", "materials", "defaults_used", "assumed"]
)  # fmt: skip

Update = Callable[[bytes], object]


def digest(*things: object) -> str:
    """Return the sha256, in hex, of a canonical form of some data.

    Takes None, bool, int, float (by its bits), str, Path (as text), enums, numpy arrays and
    numbers, sequences, mappings (in their order, in which sums over them are made), sets, and
    dataclasses and pydantic models of these, without what they leave out of comparison. Raises
    TypeError for anything else.
    """
    found = hashlib.sha256()
    _add(found.update, things)
    return found.hexdigest()


def _add(update: Update, thing: object) -> None:
    if thing is None or isinstance(thing, bool):
        _tagged(update, b"c", str(thing).encode())
    elif isinstance(thing, Enum):
        _tagged(update, b"e", type(thing).__qualname__.encode())
        _add(update, thing.value)
    elif isinstance(thing, int):
        _tagged(update, b"i", str(int(thing)).encode())
    elif isinstance(thing, float):
        _tagged(update, b"f", struct.pack("<d", thing))
    elif isinstance(thing, str):
        _tagged(update, b"s", thing.encode("utf-8", "surrogatepass"))
    elif isinstance(thing, Path):
        _tagged(update, b"p", str(thing).encode("utf-8", "surrogateescape"))
    elif _is_numpy(thing):
        _add_array(update, thing)
    elif is_dataclass(thing) and not isinstance(thing, type):
        names = [field.name for field in fields(thing) if field.compare]
        _add_fields(update, thing, names)
    elif _is_model(thing):
        _add_fields(update, thing, list(type(thing).model_fields))  # type: ignore[attr-defined]
    else:
        _add_many(update, thing)


def _add_many(update: Update, thing: object) -> None:
    if isinstance(thing, Mapping):
        _tagged(update, b"m", str(len(thing)).encode())
        for key, value in thing.items():
            _add(update, key)
            _add(update, value)
    elif isinstance(thing, Set):
        _tagged(update, b"u", str(len(thing)).encode())
        for each in sorted(digest(member) for member in thing):
            update(each.encode())
    elif isinstance(thing, Sequence) and not isinstance(thing, bytes | bytearray | memoryview):
        _tagged(update, b"l", str(len(thing)).encode())
        for member in thing:
            _add(update, member)
    else:
        raise TypeError(f"a {type(thing).__name__} has no canonical form to take a digest of")


def _tagged(update: Update, tag: bytes, content: bytes) -> None:
    update(tag + len(content).to_bytes(8, "little"))
    update(content)


def _add_fields(update: Update, thing: object, names: Sequence[str]) -> None:
    _tagged(update, b"d", type(thing).__qualname__.encode())
    for name in names:
        _tagged(update, b"n", name.encode())
        _add(update, getattr(thing, name))


def _is_numpy(thing: object) -> bool:
    numpy = sys.modules.get("numpy")  # without it nothing here is an array
    return numpy is not None and isinstance(thing, numpy.ndarray | numpy.generic)


def _is_model(thing: object) -> bool:
    pydantic = sys.modules.get("pydantic")
    return pydantic is not None and isinstance(thing, pydantic.BaseModel)


def _add_array(update: Update, thing: Any) -> None:
    import numpy as np

    array = np.asarray(thing)
    if array.dtype.kind not in "biufcSU":
        raise TypeError(f"an array of {array.dtype} has no canonical form to take a digest of")
    array = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("<"), copy=False))
    _tagged(update, b"a", f"{array.dtype.str} {np.shape(thing)}".encode())
    update(array.tobytes())


@cache
def code_digest(*packages: str) -> str:
    """Return the sha256 of the files of the tool's packages, all of them unless some are named.

    Sources and data files alike, as they are at the first call.
    """
    root = Path(__file__).resolve().parents[2]
    found = hashlib.sha256()
    for package in packages or PACKAGES:
        files = [path for path in (root / package).rglob("*") if _is_source(root, path)]
        if not files:
            raise FileNotFoundError(f"no package {package} stands beside ballesta in {root}")
        for path in sorted(files, key=lambda path: path.relative_to(root).parts):
            _tagged(found.update, b"p", path.relative_to(root).as_posix().encode())
            _tagged(found.update, b"t", path.read_bytes())
    return found.hexdigest()


def _is_source(root: Path, path: Path) -> bool:
    parts = path.relative_to(root).parts
    hidden = any(part == "__pycache__" or part.startswith(".") for part in parts)
    return not hidden and path.suffix not in (".pyc", ".tmp", ".orig") and path.is_file()


@cache
def library_digest() -> str:
    """Return the sha256 of `libraries`."""
    return digest(libraries())


@cache
def libraries() -> Mapping[str, str]:
    """Versions that numbers depend on besides our code: libraries, Python, processor, threads."""
    return {
        **{name: _version(name) for name in _LIBRARIES},
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "platform": f"{sys.platform} {platform.machine()}",
        "processor": _processor(),
        "threads": policy(),  # sums come in another order with others
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    """The type of the processor: linear algebra picks its code by it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor()
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor())


def stages_of(design: "Design") -> dict[str, str]:
    """Return the digest of everything that a result is made from, by stage.

    "loads" (the linkage, its cycles and the masses that are stated), for every part
    "PART: geometry", "PART: mesh", "PART: material" and "PART: judgement" (all else that is stated
    of it, the duty, and the safeties to be shown), then "code" and "libraries".
    """
    names = [field.name for field in fields(design) if field.name not in _NOT_LOADS]
    stages = {"loads": digest({name: getattr(design, name) for name in names})}
    for part in design.parts.values():
        stages |= _stages_of_part(design, part)
    return {**stages, "code": code_digest(), "libraries": library_digest()}


def _stages_of_part(design: "Design", part: "Part") -> dict[str, str]:
    stated = {field.name: getattr(part, field.name) for field in fields(part)}
    own = {stage: {name: stated.pop(name) for name in names} for stage, names in _STAGES}
    own["mesh"]["accuracy"] = design.accuracy
    own["judgement"] = {**stated, "duty": design.duty, "require": design.require}
    return {f"{part.name}: {stage}": digest(values) for stage, values in own.items()}


_STAGES = (("geometry", _GEOMETRY), ("mesh", _MESH), ("material", ("material",)))
