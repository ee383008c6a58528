"""A folder of entries, each in one file under the digest of what it was made from.

A file is there whole or not at all, and carries the digest of its own content: what a disk or a
hand has changed is found out, said, and computed again. Nothing that goes wrong with the store
costs a check: it goes on without.

Whole results are found by the text of the design's files: nothing is computed.

A result is kept as a tree of plain data and pieces of bytes, bit for bit; without pickle. Only
dataclasses and enums of the tool's own packages are made again from what a file says, by setting
their fields: reading runs no code that a file names.
"""

import hashlib
import importlib
import json
import math
import os
import secrets
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

import numpy as np

from checks.result.verdict import DesignResult
from checks.store.fingerprints import PACKAGES, code_digest, digest, library_digest

GIB = 2**30
DEFAULT_LIMIT = 10 * GIB
_MAGIC = b"ballesta-store 1\n"
_CHUNK = 1 << 20
_LEFTOVER = 3600.0  # s, after which a temporary file is nobody's any more
_KEPT = 0.9  # of the limit: what is left when the oldest entries had to go
_SHARE = 0.05  # of the limit: after writing so much, what others have written is looked at
_OWN = "checks/store"
_LAST = "result"  # the kind that is removed last: the smallest, and it spares the most
_SUFFIX, _TEMPORARY = ".entry", ".tmp"

T = TypeVar("T")
Say = Callable[[str], None]
if TYPE_CHECKING:
    from checks.design.data import Design
    from checks.design.effort import Effort

# What stopped short for lack of memory may go further on another day.
BY_THE_DAY = "a finer mesh was not solved"
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


def to_standard_error(text: str) -> None:
    """Say what a user should know of the store."""
    print(f"ballesta: store: {text}", file=sys.stderr, flush=True)


class DamagedError(ValueError):
    """A file of the store that is not as it was written."""


class Store:
    """Entries in a folder; safe with several processes at once.

    folder   made when the first entry is written
    limit    bytes, above which the entries that were used longest ago are removed
    say      takes what went wrong, each kind of trouble once
    hits, misses  how often an entry of a kind was found, or had to be computed
    """

    def __init__(
        self, folder: Path, *, limit: int = DEFAULT_LIMIT, say: Say = to_standard_error
    ) -> None:
        self.folder = folder
        self.limit = limit
        self.hits: dict[str, int] = {}
        self.misses: dict[str, int] = {}
        self._say_once, self._said = say, set[str]()
        self._writing = True
        self._size: int | None = None  # of all entries when they were looked at last
        self._unseen = 0  # what was written since

    def remember(
        self,
        kind: str,
        packages: Sequence[str],
        inputs: object,
        compute: Callable[[], T],
    ) -> T:
        """Return the kept result of equal inputs and equal code, else compute and keep it.

        packages  whose code the answer depends on
        inputs    all else that it depends on, as `fingerprints.digest` takes it
        """
        key = Key.of(kind, packages, inputs)
        found = self.get(key)
        if found is None:
            found = (compute(),)
            self.put(key, found[0])
        answer: T = found[0]
        return answer

    def get(self, key: "Key") -> tuple[Any] | None:
        """Return the entry, as the one member of a tuple, or None where there is none to use."""
        path = self.folder / key.path
        found = None
        try:
            with path.open("rb") as stream:
                found = (_read_entry(stream, key),)
            with suppress(OSError):
                os.utime(path)  # used just now
        except FileNotFoundError:
            self._tell_of_other_versions(path)
        except DamagedError as error:
            self._tell(str(path), f"{path} is damaged ({error}); it is computed again")
        except OSError as error:
            self._tell("read", f"{path} cannot be read ({error.strerror}); it is computed again")
        counts = self.misses if found is None else self.hits
        counts[key.kind] = counts.get(key.kind, 0) + 1
        return found

    def put(self, key: "Key", value: object) -> None:
        """Write an entry; where that is not possible say so, and write none any more."""
        if not self._writing:
            return
        path = self.folder / key.path
        try:
            tree, pieces = to_record(value)
            path.parent.mkdir(parents=True, exist_ok=True)
            written = _write_entry(path, key, tree, pieces)
            self._make_room(written)
        except RecordError as error:
            self._tell(key.kind, f"the {key.kind} is not kept: {error}")
        except OSError as error:
            self._writing = False
            self._tell(
                "write",
                f"{self.folder} cannot be written ({error.strerror}); the check goes on without",
            )

    def _tell(self, kind: str, text: str) -> None:
        if kind not in self._said:
            self._said.add(kind)
            self._say_once(text)

    def _tell_of_other_versions(self, path: Path) -> None:
        if "versions" in self._said:
            return
        inputs = path.name.partition(".")[0]
        with suppress(OSError):
            if any(True for _ in path.parent.glob(f"{inputs}.*{_SUFFIX}")):
                self._tell(
                    "versions",
                    f"{self.folder} has entries of other versions of ballesta or its libraries, "
                    "which are not used",
                )

    def _make_room(self, written: int) -> None:
        """Remove the entries used longest ago once all of them exceed the limit."""
        self._unseen += written
        if self._size is None or self._unseen > _SHARE * self.limit:
            self._size = sum(size for _, size, _ in _files(self.folder))
            self._unseen = 0
        if self._size + self._unseen <= self.limit:
            return
        entries = sorted(_files(self.folder), key=_worth)  # other processes have written, too
        left, now = sum(size for _, size, _ in entries), time.time()
        for used, size, file in entries:
            forgotten = file.name.endswith(_TEMPORARY) and now - used > _LEFTOVER
            if forgotten or (left > _KEPT * self.limit and file.name.endswith(_SUFFIX)):
                with suppress(OSError):
                    file.unlink()
                    left -= size
        self._size, self._unseen = left, 0


class Key:
    """The name of an entry.

    kind     what it is, such as "mesh": the folder that it stands in
    inputs   digest of what it was made from
    version  digest of the code and libraries that made it
    """

    def __init__(self, kind: str, inputs: str, version: str) -> None:
        self.kind, self.inputs, self.version = kind, inputs, version

    @classmethod
    def of(cls, kind: str, packages: Sequence[str], inputs: object) -> "Key":
        """Return the key of what some packages, and the store itself, make of some inputs."""
        version = digest(code_digest(_OWN, *packages), library_digest())
        return cls(kind, digest(kind, inputs), version)

    @property
    def path(self) -> str:
        """Where its file stands in the store's folder."""
        name = f"{self.inputs[2:42]}.{self.version[:16]}{_SUFFIX}"
        return f"{self.kind}/{self.inputs[:2]}/{name}"

    @property
    def stated(self) -> dict[str, str]:
        """Kind, inputs and version as the file's head states them."""
        return {"kind": self.kind, "inputs": self.inputs, "version": self.version}


def _write_entry(path: Path, key: Key, tree: Any, pieces: Sequence[Piece]) -> int:
    """Write a file in one step; returns its size. Raises OSError, then nothing is left of it."""
    forms, contents = zip(*map(packed, pieces), strict=True) if pieces else ((), ())
    head = {**key.stated, "pieces": forms, "tree": tree}
    text = zlib.compress(json.dumps(head, allow_nan=False).encode("ascii"), 6)
    content = [len(text).to_bytes(8, "little"), text, *contents]
    found = hashlib.sha256()
    for piece in content:
        found.update(piece)
    temporary = path.with_name(f".{secrets.token_hex(8)}{_TEMPORARY}")
    try:
        with temporary.open("xb") as stream:
            for piece in (_MAGIC, found.digest(), *content):
                stream.write(piece)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
    return len(_MAGIC) + found.digest_size + sum(len(piece) for piece in content)


def _read_entry(stream: BinaryIO, key: Key) -> Any:
    """Return what an entry holds; raises DamagedError."""
    if stream.read(len(_MAGIC)) != _MAGIC:
        raise DamagedError("not of this format")
    expected, found = stream.read(32), hashlib.sha256()
    start = stream.tell()
    while chunk := stream.read(_CHUNK):
        found.update(chunk)
    if found.digest() != expected:
        raise DamagedError("its content is not what was written")
    stream.seek(start)
    try:
        head = json.loads(zlib.decompress(stream.read(int.from_bytes(stream.read(8), "little"))))
        if {name: head[name] for name in key.stated} != key.stated:
            raise DamagedError("it is the entry of something else")
        pieces = [unpacked(stream, form) for form in head["pieces"]]
        return from_record(head["tree"], pieces)
    except (zlib.error, ValueError, KeyError, TypeError) as error:
        raise DamagedError(str(error)) from error


def _worth(entry: tuple[float, int, Path]) -> tuple[bool, float]:
    """Sort key of removal, the least first: stages, then whole results, by their last use."""
    used, _, file = entry
    return file.parent.parent.name == _LAST, used


def _files(folder: Path) -> Iterator[tuple[float, int, Path]]:
    """When each file of a store was used last, its size, and its path."""
    for file in folder.glob("*/*/*"):
        with suppress(OSError):
            status = file.stat()
            yield status.st_mtime, status.st_size, file


@dataclass(frozen=True, eq=False)
class KeptResult:
    """The result of a design, and the files that were written of it.

    texts  path as the design has it -> sha256 of its text, of every file that it takes from
    files  name -> content, of report.html, result.json and one .vtu per part; none where the
           report was not written, or lacks pictures that another run may have
    """

    texts: Mapping[str, str]
    result: DesignResult
    files: Mapping[str, bytes]


def recalled_result(
    store: Store | None, path: Path, overrides: Sequence[str], effort: "Effort"
) -> KeptResult | None:
    """Return what an equal check of the same files has found; None where there was none."""
    if store is None or effort.within is not None:
        return None
    text = next(iter(_readings(path)), None)
    found = None if text is None else store.get(_key(path, text, overrides, effort))
    if found is None:
        return None
    kept: KeptResult = found[0]
    equal = all(sha256 in _readings(Path(name)) for name, sha256 in kept.texts.items())
    return kept if equal else None


def keep_result(
    store: Store | None,
    design: "Design",
    effort: "Effort",
    result: DesignResult,
    files: Mapping[str, bytes],
) -> None:
    """Keep a result, unless the clock or a lack of memory has cut it short."""
    by_the_day = any(BY_THE_DAY in check.note for check in result.checks)
    if store is None or effort.within is not None or by_the_day:
        return
    texts = {name: _sha256(text) for name, text in design.sources}
    key = _key(design.file, _sha256(design.source), design.overrides, effort)
    store.put(key, KeptResult(texts, result, files))


def keep_files(
    store: Store | None,
    path: Path,
    overrides: Sequence[str],
    effort: "Effort",
    kept: KeptResult,
    files: Mapping[str, bytes],
) -> None:
    """Keep the files of a result that was kept without them."""
    if store is not None and files:
        key = _key(path, kept.texts[str(path)], overrides, effort)
        store.put(key, replace(kept, files=files))


def _key(path: Path, text: str, overrides: Sequence[str], effort: "Effort") -> Key:
    return Key.of("result", PACKAGES, (str(path), text, tuple(overrides), effort))


def _readings(path: Path) -> list[str]:
    """The sha256 of a file's text as it may have been read: as UTF-8, else byte by byte."""
    try:
        content = path.read_bytes()
    except OSError:
        return []
    texts = []
    with suppress(UnicodeDecodeError):
        texts.append(content.decode("utf-8-sig").replace("\r\n", "\n"))
    return [_sha256(text) for text in (*texts, content.decode("latin-1"))]


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
