"""Whole results from the store, found by the text of the design's files: nothing is computed."""

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from checks.result.verdict import DesignResult
from checks.store.fingerprints import PACKAGES
from checks.store.store import Key, Store

if TYPE_CHECKING:
    from checks.design.data import Design
    from checks.design.effort import Effort

# What stopped short for lack of memory may go further on another day.
BY_THE_DAY = "a finer mesh was not solved"


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
