"""Changes to a design before it is read: `--set key=value` and tables that are `like` another."""

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from checks.design.errors import DesignError, Problems, listed, nearest, no_such

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
