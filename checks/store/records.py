"""Results as a tree of plain data and pieces of bytes, and back, bit for bit; without pickle.

Only dataclasses and enums of the tool's own packages are made again from what a file says, by
setting their fields: reading runs no code that a file names.
"""

import importlib
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from checks.store.fingerprints import PACKAGES

_MARK = "$"  # the key of a list that stands for something that JSON does not have
_KINDS = "biufcU"
_SMALL = 1000  # bytes

Array = np.ndarray[Any, Any]
Piece = Array | bytes


class RecordError(ValueError):
    """Data that cannot be kept, or kept data that does not fit together."""


def to_record(thing: object) -> tuple[Any, list[Piece]]:
    """Return a tree for JSON and the pieces that it numbers: arrays and bytes.

    Takes what `fingerprints.digest` takes, but no pydantic models, and bytes. Raises RecordError
    for anything else.
    """
    writer = _Writer()
    return writer.tree(thing), writer.pieces


def from_record(tree: Any, pieces: Sequence[Piece]) -> Any:
    """Return what `to_record` was given; raises RecordError where the parts do not fit."""
    try:
        return _read(tree, pieces)
    except RecordError:
        raise
    except (TypeError, ValueError, KeyError, IndexError, AttributeError, ImportError) as error:
        raise RecordError(f"not a record of this version: {error}") from error


class _Writer:
    """Collects pieces; an array that stands in several places is kept once."""

    def __init__(self) -> None:
        self.pieces: list[Piece] = []
        self._known: dict[int, int] = {}

    def tree(self, thing: object) -> Any:
        if thing is None or isinstance(thing, bool):
            return thing
        if isinstance(thing, Enum):
            return _marked("enum", _name(type(thing)), thing.name)
        if isinstance(thing, np.generic):
            return _marked("number", self._piece(np.asarray(thing)))
        if isinstance(thing, int | str):
            return thing
        if isinstance(thing, float):
            return thing if math.isfinite(thing) else _marked("float", repr(thing))
        if isinstance(thing, np.ndarray):
            return _marked("array", self._piece(thing))
        if isinstance(thing, bytes):
            return _marked("bytes", self._piece(thing))
        if isinstance(thing, Path):
            return _marked("path", str(thing))
        if is_dataclass(thing) and not isinstance(thing, type):
            stated = [
                [field.name, self.tree(getattr(thing, field.name))] for field in fields(thing)
            ]
            return _marked("data", _name(type(thing)), stated)
        return self._many(thing)

    def _many(self, thing: object) -> Any:
        if isinstance(thing, Mapping):
            if _MARK not in thing and all(type(key) is str for key in thing):
                return {key: self.tree(value) for key, value in thing.items()}
            pairs = [[self.tree(key), self.tree(value)] for key, value in thing.items()]
            return _marked("mapping", pairs)
        if type(thing) is list:
            return [self.tree(each) for each in thing]
        if type(thing) is tuple:
            return _marked("tuple", [self.tree(each) for each in thing])
        if isinstance(thing, frozenset):
            return _marked("set", sorted((self.tree(each) for each in thing), key=str))
        raise RecordError(f"a {type(thing).__name__} cannot be kept")

    def _piece(self, piece: Piece) -> int:
        if isinstance(piece, np.ndarray) and piece.dtype.kind not in _KINDS:
            raise RecordError(f"an array of {piece.dtype} cannot be kept")
        if id(piece) not in self._known:
            self._known[id(piece)] = len(self.pieces)
            self.pieces.append(piece)  # holds it, so that its id stays its own
        return self._known[id(piece)]


def _marked(*entry: Any) -> dict[str, Any]:
    return {_MARK: list(entry)}


def _name(kind: type) -> str:
    if kind.__module__.partition(".")[0] not in PACKAGES or "." in kind.__qualname__:
        raise RecordError(f"a {kind.__module__}.{kind.__qualname__} cannot be kept")
    return f"{kind.__module__}:{kind.__qualname__}"


def _class(name: str) -> Any:
    module, _, kind = name.partition(":")
    if module.partition(".")[0] not in PACKAGES:
        raise RecordError(f"{name} is none of the tool's own")
    found = getattr(importlib.import_module(module), kind)
    if not isinstance(found, type) or not (is_dataclass(found) or issubclass(found, Enum)):
        raise RecordError(f"{name} is no dataclass")
    return found


def _read(tree: Any, pieces: Sequence[Piece]) -> Any:
    if isinstance(tree, list):
        return [_read(each, pieces) for each in tree]
    if not isinstance(tree, dict):
        return tree
    if _MARK not in tree:
        return {key: _read(value, pieces) for key, value in tree.items()}
    what, *rest = tree[_MARK]
    return _READERS[what](pieces, *rest)


def _data(pieces: Sequence[Piece], name: str, stated: Any) -> Any:
    kind = _class(name)
    values = {key: _read(value, pieces) for key, value in stated}
    if [field.name for field in fields(kind)] != list(values):
        raise RecordError(f"{name} has other fields than were kept")
    made = object.__new__(kind)  # what was kept has been checked when it was made
    for key, value in values.items():
        object.__setattr__(made, key, value)
    return made


_READERS: Mapping[str, Callable[..., Any]] = {
    "array": lambda pieces, k: pieces[k],
    "bytes": lambda pieces, k: pieces[k],
    "data": _data,
    "enum": lambda _, name, member: _class(name)[member],
    "float": lambda _, text: float(text),
    "mapping": lambda pieces, pairs: {_read(k, pieces): _read(v, pieces) for k, v in pairs},
    "number": lambda pieces, k: pieces[k][()],
    "path": lambda _, text: Path(text),
    "set": lambda pieces, members: frozenset(_read(each, pieces) for each in members),
    "tuple": lambda pieces, members: tuple(_read(each, pieces) for each in members),
}


def packed(piece: Piece) -> tuple[dict[str, Any], Any]:
    """Description of a piece for its reader, and its bytes as a buffer.

    The order of an array's axes in memory is kept where they are dense, for sums depend on it.
    """
    form: dict[str, Any] = {}
    content: Any = piece
    if isinstance(piece, np.ndarray):
        order = _axes(piece)
        dense = np.ascontiguousarray(piece.transpose(order))
        content = dense.reshape(-1).view(np.uint8).data
        shape = [piece.shape[axis] for axis in order]
        form = {"type": piece.dtype.str, "shape": shape, "order": order}
    form |= {"size": len(content), "zlib": _shrinks(piece)}
    if form["zlib"]:
        content = zlib.compress(content, 1)
    return form | {"kept": len(content)}, content


def unpacked(stream: BinaryIO, form: Mapping[str, Any]) -> Piece:
    """Return the next piece of a stream; raises RecordError where it ends before."""
    if "type" not in form:
        return bytes(_content(stream, form))
    found = np.empty(form["shape"], dtype=np.dtype(form["type"]))
    if found.dtype.kind not in _KINDS or found.nbytes != form["size"]:
        raise RecordError(f"an array of {found.dtype} in {form['size']} bytes cannot be kept")
    found.reshape(-1).view(np.uint8)[:] = np.frombuffer(_content(stream, form), dtype=np.uint8)
    return np.asarray(found.transpose(np.argsort(form["order"]))) if form["order"] else found


def _content(stream: BinaryIO, form: Mapping[str, Any]) -> bytes:
    content = stream.read(form["kept"])
    if form["zlib"]:
        content = zlib.decompress(content)
    if len(content) != form["size"]:
        raise RecordError("a piece ends too early")
    return content


def _shrinks(piece: Piece) -> bool:
    """True if packing is worth its time: texts, whole numbers, and arrays that are mostly zero."""
    if isinstance(piece, bytes):
        return len(piece) > _SMALL
    if piece.nbytes <= _SMALL:
        return False
    return piece.dtype.kind != "f" or 2 * int(np.count_nonzero(piece)) < piece.size


def _axes(array: Array) -> list[int]:
    """Axes from the widest step in memory to the narrowest."""
    return sorted(range(array.ndim), key=lambda axis: -abs(array.strides[axis]))
