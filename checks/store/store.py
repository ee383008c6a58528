"""A folder of entries, each in one file under the digest of what it was made from.

A file is there whole or not at all, and carries the digest of its own content: what a disk or a
hand has changed is found out, said, and computed again. Nothing that goes wrong with the store
costs a check: it goes on without.

Whole results are found by the text of the design's files: nothing is computed.
"""

import hashlib
import json
import os
import secrets
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

from checks.result.verdict import DesignResult
from checks.store.fingerprints import PACKAGES, code_digest, digest, library_digest
from checks.store.records import Piece, RecordError, from_record, packed, to_record, unpacked

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
