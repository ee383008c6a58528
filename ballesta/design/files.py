"""Files that a design takes from: itself, those it is like, tables; and values set over them."""

import copy
import hashlib
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import loads
from checks.design.errors import DesignError, Problems, listed, nearest, no_such
from checks.design.model import DesignFile
from geometry.parameters import MOST_TEXT, ParameterError, read_bounded

Way = tuple[str | int, ...]
WITH_LIKE = ("bodies", "cycles", "parts")
_OPTIONAL_TABLES = {
    "require", "joints", "forces", "friction", "friction.pins", "friction.guides",
    "friction.slots", "friction.joints", "elastic", "elastic.joints", "cylinders", "cycles",
    "events", "duty", "duty.cycles", "drive", "drive.brake", "dynamics", "materials", "parts",
    "assumed",
}  # fmt: skip
_OPTIONAL_IN_ENTRY = {"column", "mesh", "pace", "shown", "stop", "guide", "interfaces", "forces",
                      "bush", "elastic", "friction", "available", "offsets", "fits", "bore_edges",
                      "contacts"}  # fmt: skip
HUGE_NUMBER = "a whole number that TOML does not have: at most 9 223 372 036 854 775 807"
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


@dataclass(frozen=True)
class Override:
    """One value of a design to be replaced: the way to it, its text as written."""

    path: Way
    value: object

    @property
    def key(self) -> str:
        """The dotted key."""
        return dotted(self.path)


def dotted(path: Way) -> str:
    """Return the way to a value as messages show it, such as cycles.press.phases[1].to."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)[1:]


def split_key(key: str) -> Way | None:
    """Return the steps of a dotted key, or None when it is not one."""
    steps: list[str | int] = []
    for piece in key.strip().split("."):
        found = list(_STEP.finditer(piece))
        if not found or "".join(match[0] for match in found) != piece or found[0][1] is None:
            return None
        steps += [match[1] if match[1] is not None else int(match[2]) for match in found]
    return tuple(steps)


def parse_override(text: str) -> Override:
    """Return what `parts.bar.wall=5mm` asks for; the value is TOML if it parses, else text.

    >>> parse_override("parts.bar.wall=5 mm")
    Override(path=('parts', 'bar', 'wall'), value='5 mm')
    """
    key, equals, value = text.partition("=")
    path = split_key(key)
    if not equals or path is None or not value.strip():
        raise DesignError(
            Path("--set"), text, "must be written key=value, such as parts.bar.wall=5mm"
        )
    try:
        parsed = tomllib.loads(f"value = {value.strip()}")
    except tomllib.TOMLDecodeError:
        return Override(path, value.strip())
    except (ValueError, RecursionError):
        raise DesignError(Path("--set"), dotted(path), "cannot be read as a value") from None
    if huge_number_at(parsed) is not None:
        raise DesignError(Path("--set"), dotted(path), HUGE_NUMBER)
    return Override(path, parsed["value"] if len(parsed) == 1 else value.strip())


def huge_number_at(data: object, way: Way = ()) -> Way | None:
    """The way to a whole number of more than 64 bits in parsed TOML, None without one."""
    if isinstance(data, int):
        return None if -(2**63) <= data < 2**63 else way
    entries: Iterable[tuple[str | int, object]] = ()
    if isinstance(data, dict | list):
        entries = data.items() if isinstance(data, dict) else enumerate(data)
    found = (huge_number_at(value, (*way, step)) for step, value in entries)
    return next((way for way in found if way is not None), None)


def apply_override(data: dict[str, Any], override: Override, file: Path) -> None:
    """Put the value into the file's data, in place; a way that leads nowhere is a DesignError."""
    here: Any = data
    for depth, step in enumerate(override.path):
        last = depth == len(override.path) - 1
        way = dotted(override.path[:depth])
        if isinstance(here, list):
            if not isinstance(step, int) or step >= len(here):
                raise DesignError(
                    file, override.key, f"{way} is a list of {len(here)}, counted from 0: {way}[0]"
                )
        elif not isinstance(here, dict) or isinstance(step, int):
            raise DesignError(file, override.key, f"{way} has nothing inside that can be set")
        elif last:
            pass
        elif step not in here:
            here[step] = _inherited(data, override.path[: depth + 1])
            if here[step] is None:
                raise DesignError(file, override.key, _no_key(step, here))
        if last:
            here[step] = override.value
        else:
            here = here[step]


def _no_key(step: str, here: Mapping[str, object]) -> str:
    known = [key for key, value in here.items() if value is not None]
    guess = nearest(step, known)
    hint = f"did you mean {guess}?" if guess else f"there are {listed(known)}"
    return f"nothing is named {step!r}, {hint}"


def _inherited(data: dict[str, Any], path: Way) -> Any:
    """Return the table that a missing table stands for: from `like`, or empty if optional."""
    if dotted(path) in _OPTIONAL_TABLES or (path[0] == "materials" and len(path) == 2):
        return {}
    if path[0] in WITH_LIKE and len(path) == 3:
        entries, name, seen = data[str(path[0])], path[1], set()
        while name in entries and name not in seen and isinstance(entries[name], dict):
            seen.add(name)
            if entries[name].get(path[2]) is not None:
                return copy.deepcopy(entries[name][path[2]])
            name = entries[name].get("like")
    if path[-1] in _OPTIONAL_IN_ENTRY:
        return {}
    return None


def resolve_like(data: dict[str, Any], problems: Problems) -> dict[Way, Way]:
    """Fill every table that is `like` another, in place.

    Returns where each inherited value is written: its way -> the way to the original.
    """
    origins: dict[Way, Way] = {}
    for section in WITH_LIKE:
        entries = data.get(section)
        if not isinstance(entries, dict):
            continue
        done: set[str] = set()
        for name in entries:
            _resolve(section, name, entries, done, (), origins, problems)
    return origins


def _resolve(
    section: str,
    name: str,
    entries: dict[str, Any],
    done: set[str],
    chain: tuple[str, ...],
    origins: dict[Way, Way],
    problems: Problems,
) -> None:
    entry = entries[name]
    if name in done or not isinstance(entry, dict) or "like" not in entry:
        return
    done.add(name)
    key, model = f"{section}.{name}.like", entry.pop("like")
    chain = (*chain, name)
    if not isinstance(model, str):
        problems.add(key, f"must be the name of another table in {section}, got {model!r}")
    elif model in chain:
        problems.add(key, f"goes round in a circle: {' is like '.join((*chain, model))}")
    elif model not in entries:
        others = [other for other in entries if other != name]
        problems.add(key, no_such("table in " + section, model, others))
    elif isinstance(entries[model], dict):
        _resolve(section, model, entries, done, chain, origins, problems)
        for inherited, value in entries[model].items():
            if inherited not in entry:
                entry[inherited] = copy.deepcopy(value)
                source = (section, model, inherited)
                origins[section, name, inherited] = origins.get(source, source)


# The files themselves.


@dataclass
class Sources:
    """Every file that was read for a design, and which of them states what.

    texts    path as written -> text, in the order of reading, bases first
    written  dotted key -> the file that states it; of a table the last one that adds to it
    overridden  dotted keys that were set from outside
    """

    file: Path
    texts: dict[Path, str] = field(default_factory=dict)
    written: dict[str, Path] = field(default_factory=dict)
    overridden: set[str] = field(default_factory=set)

    @property
    def sha256(self) -> str:
        """Checksum of all texts, one after the other."""
        return hashlib.sha256("".join(self.texts.values()).encode()).hexdigest()

    def file_of(self, key: str) -> Path:
        """Return the file that states a key, or the table that it is missing from."""
        while key:
            if key in self.written:
                return self.written[key]
            key = key[: max(key.rfind("."), key.rfind("["), 0)]
        return self.file

    def override(self, key: str) -> None:
        """Note that a key was set from outside; errors there are the file's own."""
        self.written[key] = self.file
        self.overridden.add(key)

    def replaces(self, older: str, key: str) -> bool:
        """True if a key, or the table that would hold it, was stated after an older key, or set."""
        by_set = any(
            key == other or key.startswith((f"{other}.", f"{other}[")) for other in self.overridden
        )
        order = [*self.texts]
        return by_set or order.index(self.file_of(key)) > order.index(self.file_of(older))

    def read_beside(self, key: str, name: str, most: int = MOST_TEXT) -> str:
        """Return the text of a file that is named relative to the file that states the key.

        most  bytes that it may have
        """
        stated = self.file_of(key)
        path = stated.parent / name
        self.texts[path] = text = read_text(path, NamedFile(stated, key, name), most)
        return text


@dataclass(frozen=True)
class NamedFile:
    """Where a file is named that cannot be read: errors are told there."""

    file: Path
    key: str
    name: str

    def error(self, problem: str) -> DesignError:
        """Return the error."""
        return DesignError(self.file, self.key, f"{self.name!r} cannot be read: {problem}")


def read_design_files(file: Path) -> tuple[dict[str, Any], Sources]:
    """Return the data of a design file merged over the files that it is like, and all sources.

    Tables merge key by key; lists and values of the later file replace those of the base.
    """
    sources = Sources(file)
    return _merged(file, None, (), sources), sources


def read_text(file: Path, named: NamedFile | None = None, most: int = MOST_TEXT) -> str:
    """Return the text of a file; its errors are told at the key that names it, if one does."""

    def error(problem: str, where: str = "cannot be read") -> DesignError:
        return DesignError(file, where, problem) if named is None else named.error(problem)

    try:
        content = read_bounded(file, most)
    except FileNotFoundError:
        beside = sorted(other.name for other in file.parent.glob(f"*{file.suffix}"))
        guess = nearest(file.name, beside) if named else None
        hint = f", did you mean {guess}?" if guess else ""
        raise error(f"there is no such file{hint}") from None
    except IsADirectoryError:
        kind = "file" if named else "design file"
        raise error(f"is a directory, not a {kind}") from None
    except (OSError, ValueError) as reason:
        strerror = getattr(reason, "strerror", None) or str(reason)
        raise error(str(strerror).lower()) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        line = content.count(b"\n", 0, reason.start) + 1
        raise error("is not UTF-8 text; save the file as UTF-8", f"line {line}") from None
    return text.replace("\r\n", "\n")


def _merged(
    file: Path, named: NamedFile | None, chain: tuple[Path, ...], sources: Sources
) -> dict[str, Any]:
    text = read_text(file, named)
    if not text.strip():
        if named is not None:
            raise named.error("the file is empty")
        raise DesignError(file, "cannot be read", "the file is empty; ballesta new writes one")
    data = _parsed(file, text)
    huge = huge_number_at(data)
    if huge is not None:
        raise DesignError(file, dotted(huge), HUGE_NUMBER)
    chain = (*chain, file)
    base: dict[str, Any] = {}
    if "like" in data:
        name = data.pop("like")
        if not isinstance(name, str) or not name.strip():
            raise DesignError(
                file, "like", f'must be another design file such as "press.toml", got {name!r}'
            )
        other = file.parent / name
        if _place(other) in map(_place, chain):
            circle = " is like ".join(path.name for path in (*chain, other))
            raise DesignError(file, "like", f"goes round in a circle: {circle}")
        base = _merged(other, NamedFile(file, "like", name), chain, sources)
    sources.texts[file] = text
    _merge(base, data, (), file, sources)
    return base


def _place(file: Path) -> Path:
    try:
        return file.resolve()
    except (OSError, ValueError, RuntimeError):  # no such place; reading it tells why
        return file


def _merge(
    into: dict[str, Any], data: dict[str, Any], way: Way, file: Path, sources: Sources
) -> None:
    for key, value in data.items():
        here = (*way, key)
        sources.written[dotted(here)] = file
        if isinstance(value, dict) and isinstance(into.get(key), dict):
            _merge(into[key], value, here, file, sources)
            continue
        if key in into:
            inside = (f"{dotted(here)}.", f"{dotted(here)}[")
            for known in [known for known in sources.written if known.startswith(inside)]:
                del sources.written[known]
        into[key] = copy.deepcopy(value)
        _mark(value, here, file, sources)


def _mark(value: object, way: Way, file: Path, sources: Sources) -> None:
    """Note that a value and everything inside it is stated in a file."""
    sources.written[dotted(way)] = file
    entries = value.items() if isinstance(value, dict) else ()
    for step, entry in entries:
        _mark(entry, (*way, step), file, sources)


@lru_cache(maxsize=32)
def _toml(text: str) -> dict[str, Any]:
    """The tables of a text, parsed once: variations of a design read its files again and again."""
    return tomllib.loads(text)


# tomllib's words where a line ends between braces
_IN_BRACES = ("Invalid initial character for a key part", "Unclosed inline table")


def _parsed(file: Path, text: str) -> dict[str, Any]:
    try:
        return dict(_toml(text))
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        place = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)$", message)
        what = message[: place.start()] if place else message
        if place and place[1]:
            where = f"line {place[1]}, column {place[2]}"
            left = text.split("\n")[int(place[1]) - 1][int(place[2]) - 1 :].strip()
            if what in _IN_BRACES and (not left or left.startswith("#")):
                what = f"{what}: a table in braces must end on the line that it begins on"
        else:
            where = f"line {text.count(chr(10)) + 1}, at the end"
        raise DesignError(file, where, f"is not TOML: {what}") from None
    except ValueError:  # Python reads no number of more than 4300 digits
        raise DesignError(file, "cannot be read", f"has {HUGE_NUMBER}") from None
    except RecursionError:
        raise DesignError(file, "cannot be read", "is not TOML: nested too deeply") from None


# A design while it is read.


@dataclass(frozen=True)
class Reading:
    """Entries of a design, its sources, and what is wrong with them.

    forces, joints  of those entries that are in order
    """

    file: DesignFile
    sources: Sources
    problems: Problems
    forces: Mapping[str, loads.Force]
    joints: Mapping[str, Sequence[loads.Joint]]


@contextmanager
def telling(problems: Problems, key: str) -> Iterator[None]:
    """Note what is refused within as a problem of a key, or of one below it, and go on.

    A ParameterError without words stands for what was told already.
    """
    try:
        yield
    except ParameterError as error:
        if error.problem:
            problems.add(f"{key}.{error.field}" if error.field else key, error.problem)
    except DesignError as error:
        problems.take(error)
