"""Comparison of two results as plain data, thing by thing, for `ballesta diff`.

Results may come from another version of the tool: a value that one of them lacks is named
and left out.

Collects what differs between two results, and reads plain data that may be of any shape.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isclose, isfinite
from typing import Any

from checks.design.units import DIMENSIONS, measure, measure_pair
from checks.result.verdict import Status
from checks.result.words import number, place_text, safety_text
from reports.difference_text import (
    INPUTS,
    LIMITS,
    LOADS,
    MASSES,
    ROUND_OFF,
    SAFETY,
    STRESSES,
    VERDICTS,
    Change,
    DesignDifference,
    Side,
    largest_first,
    relative_change,
)
from reports.files import FORMAT

Data = Mapping[str, Any]


class Changes:
    """Collects changes by group and counts the comparisons."""

    def __init__(self) -> None:
        self.changes: dict[str, list[Change]] = {}
        self.counts: dict[str, int] = {}
        self.only_a: list[str] = []
        self.only_b: list[str] = []
        self.notes: list[str] = []

    def _count(self, group: str) -> None:
        self.counts[group] = self.counts.get(group, 0) + 1
        self.changes.setdefault(group, [])

    def number(
        self,
        group: str,
        of: str,
        what: str,
        pair: tuple[Any, Any],
        unit: str,
        note: str = "",
        scale: float = 0.0,
        none: str = "none",
    ) -> None:
        """Compare two numbers; `none` is what stands for one that is not finite or not there."""
        self._count(group)
        a, b = (number_of(value) for value in pair)
        if a is None or b is None:
            if a is not b:
                before, after = (none if value is None else value for value in (a, b))
                self.changes[group].append(Change(of, what, before, after, unit, None, note))
            return
        if abs(b - a) > ROUND_OFF * max(abs(a), abs(b), scale):
            relative = relative_change(a, b, scale)
            self.changes[group].append(Change(of, what, a, b, unit, relative, note))

    def keep(self, group: str, change: Change | None) -> None:
        """Count a thing, and keep its change if there is one."""
        self._count(group)
        if change is not None:
            self.changes[group].append(change)

    def verdict(self, of: str, what: str, a: str, b: str, note: str) -> None:
        """Compare two verdicts."""
        self.keep(VERDICTS, None if a == b else Change(of, what, a, b, note=note))

    def both(self, kind: str, a: Iterable[str], b: Iterable[str]) -> list[str]:
        """Return the names on both sides; the others are noted as only on one."""
        in_a, in_b = list(a), list(b)
        self.only_a += [f"{kind} {name}" for name in in_a if name not in in_b]
        self.only_b += [f"{kind} {name}" for name in in_b if name not in in_a]
        return [name for name in in_a if name in in_b]

    def lines(self, word: str, a: Any, b: Any) -> None:
        """Note the sentences that only one side has."""
        self.both(f"{word}:", *(dict.fromkeys(map(sentence, list_of(side))) for side in (a, b)))


def table_of(value: Any) -> Data:
    """Return a table, empty for anything else."""
    return value if isinstance(value, Mapping) else {}


def list_of(value: Any) -> Sequence[Any]:
    """Return a list, empty for anything else."""
    return value if isinstance(value, list | tuple) else ()


def tables_of(value: Any) -> list[Data]:
    """Return the tables of a list."""
    return [entry for entry in list_of(value) if isinstance(entry, Mapping)]


def sentence(value: Any) -> str:
    """Return a told thing as one text; of a pair its key and its reason."""
    return ": ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def number_of(value: Any) -> float | None:
    """Return a finite number, None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if isfinite(value) else None


_RANK = {str(Status.FAIL): 0, str(Status.UNDECIDED): 1, str(Status.PASS): 2}
_EXPECTED = ("status", "inputs", "cycles", "parts", "linkage", "gates")
_MASS = "mass [kg]"


def compared(name: str, a: Data, b: Data, paths: tuple[str, str]) -> DesignDifference:
    """Return what differs between two results (`DesignResult.to_dict`, or a result.json)."""
    notes = list(_notes(a, b))
    found = Changes()
    if {"inputs"} <= a.keys() & b.keys():
        _inputs(found, a, b)
    if {"cycles"} <= a.keys() & b.keys():
        _loads(found, table_of(a["cycles"]), table_of(b["cycles"]))
    if {"status"} <= a.keys() & b.keys():
        found.verdict("design", "verdict", str(a["status"]), str(b["status"]), _decided(a, b))
    if {"parts"} <= a.keys() & b.keys():
        _parts(found, _named(a["parts"]), _named(b["parts"]))
    if {"linkage"} <= a.keys() & b.keys():
        _checks(found, "linkage", tables_of(a["linkage"]), tables_of(b["linkage"]))
    if {"gates"} <= a.keys() & b.keys():
        _gates(found, "loads", tables_of(a["gates"]), tables_of(b["gates"]))
    for key, word in (("warnings", "warning"), ("not_checked", "not checked"), ("assumed", "")):
        if {key} <= a.keys() & b.keys():
            found.lines(word or "assumed", a[key], b[key])
    ordered = {
        group: _worst_first(changes) if group == VERDICTS else largest_first(changes)
        for group, changes in found.changes.items()
    }
    return DesignDifference(
        name=name,
        a=_side(a, paths[0]),
        b=_side(b, paths[1]),
        changes=ordered,
        compared=found.counts,
        only_a=found.only_a,
        only_b=found.only_b,
        notes=[*notes, *found.notes],
    )


def _notes(a: Data, b: Data) -> Iterable[str]:
    for label, data in (("A", a), ("B", b)):
        if data.get("format") != FORMAT:
            yield (
                f"{label} has format {data.get('format')!r}, this version writes {FORMAT!r}: "
                "compared as far as it goes"
            )
        missing = [key for key in _EXPECTED if key not in data]
        if missing:
            yield f"{label} has no {', '.join(missing)}: not compared"
    old, new = table_of(a.get("versions")), table_of(b.get("versions"))
    changed = [
        f"{key} {old[key]} → {new[key]}"
        for key in old
        if key in new and old[key] != new[key]  # formulas need no solver
    ]
    if changed:
        yield f"made with different versions, which may change numbers: {', '.join(changed)}"


def _side(data: Data, path: str) -> Side:
    version = table_of(data.get("versions")).get("ballesta", "unknown")
    return Side(
        path=path,
        name=str(data.get("name", "")),
        status=str(data.get("status", "no verdict")),
        made=f"ballesta {version}: {data.get('command', 'no command is told')}",
    )


def _decided(a: Data, b: Data) -> str:
    told = []
    for data in (a, b):
        decided = table_of(data.get("decided_by"))
        told.append(f"{decided.get('part', '?')} {decided.get('kind', '?')}" if decided else "none")
    return f"decided by {told[0]}" + ("" if told[0] == told[1] else f" → {told[1]}")


def _inputs(found: Changes, a: Data, b: Data) -> None:
    before, after = (_stated(data) for data in (a, b))
    for key in dict.fromkeys([*before, *after]):
        old, new = before.get(key), after.get(key)
        note = ""
        if (old is None and new and new[1]) or (new is None and old and old[1]):
            continue  # a default of what the other side does not have
        if old is None or new is None:
            change = Change("", key, old and old[0], new and new[0], note="stated on one side only")
        elif old[0] == new[0] or _alike(old[0], new[0]):
            change = None
        else:
            note = " and ".join(
                f"{side} is the default" for side, value in (("A", old), ("B", new)) if value[1]
            )
            change = Change("", key, old[0], new[0], "", _relative(old[0], new[0]), note)
        found.keep(INPUTS, change)


def _stated(data: Data) -> dict[str, tuple[str, bool]]:
    """Every input by key: its text, and whether it is a default that the file does not state."""
    result = {}
    for group, default in (("defaults", True), ("inputs", False)):
        for pair in list_of(data.get(group)):
            if isinstance(pair, Sequence) and not isinstance(pair, str) and len(pair) == 2:
                result[str(pair[0])] = (str(pair[1]), default)
    return result


def _amount(text: str) -> tuple[str, float | tuple[float, float]] | None:
    """Return what a text measures, in ballesta's units, if it measures anything."""
    readings: list[Callable[[], tuple[str, float | tuple[float, float]]]] = [
        lambda: ("fraction", float(text)),
        lambda: (lambda found: (found.dimension, found.value))(measure(text, *DIMENSIONS)),
        lambda: ("pair of lengths", measure_pair(text, "length")),
        lambda: ("pair of accelerations", measure_pair(text, "acceleration")),
    ]
    for reading in readings:
        try:
            return reading()
        except ValueError:
            continue
    return None


def _alike(before: str, after: str) -> bool:
    """True if two texts measure the same, such as 10 mm and 1 cm."""
    old, new = _amount(before), _amount(after)
    if old is None or new is None or old[0] != new[0]:
        return False
    pairs = [value if isinstance(value, tuple) else (value,) for value in (old[1], new[1])]
    return all(isclose(one, other, rel_tol=1e-12) for one, other in zip(*pairs, strict=True))


def _relative(before: str, after: str) -> float | None:
    old, new = _amount(before), _amount(after)
    if old is None or new is None or old[0] != new[0]:
        return None
    if isinstance(old[1], tuple) or isinstance(new[1], tuple):
        return None
    return relative_change(old[1], new[1]) if isfinite(old[1]) and isfinite(new[1]) else None


def _loads(found: Changes, a: Data, b: Data) -> None:
    for name in found.both("cycle", a, b):
        before, after = table_of(a[name]), table_of(b[name])
        for kind, unit, words in (
            ("efforts", "N", "largest {}"),
            ("torques", "N mm", "largest {}"),
            ("links", "N", "largest pin force, {}"),
        ):
            old, new = table_of(before.get(kind)), table_of(after.get(kind))
            peaks = {
                force: (_peak(before, old[force]), _peak(after, new[force]))
                for force in found.both(f"cycle {name}:", old, new)
            }
            scale = max((abs(v) for pair in peaks.values() for v, _ in pair if v), default=0.0)
            for force, (one, other) in peaks.items():
                note = one[1] if one[1] == other[1] else f"{one[1]} → {other[1]}"
                pair = one[0], other[0]
                found.number(
                    LOADS, f"cycle {name}", words.format(force), pair, unit, note, scale=scale
                )
        old, new = table_of(before.get("peaks")), table_of(after.get("peaks"))
        for part in [part for part in old if part in new]:
            pair = _peak(before, old[part])[0], _peak(after, new[part])[0]
            found.number(STRESSES, part, f"largest stress over {name}", pair, "MPa")


def _peak(cycle: Data, values: Any) -> tuple[float | None, str]:
    """The value of the largest size over a cycle, and where it is."""
    numbers = [number_of(value) for value in list_of(values)]
    real = [(k, value) for k, value in enumerate(numbers) if value is not None]
    if not real:
        return None, ""
    k, value = max(real, key=lambda item: abs(item[1]))
    positions = list_of(cycle.get("position"))
    place = number_of(positions[k]) if k < len(positions) else None
    if place is None:
        return value, ""
    shown = f"at {cycle.get('shown_name', 'position')} = {place_text(place)}"
    return value, f"{shown} {cycle.get('unit', '')}".strip()


def _parts(found: Changes, a: Mapping[str, Data], b: Mapping[str, Data]) -> None:
    for name in found.both("part", a, b):
        before, after = a[name], b[name]
        for fact in ("shape", "material"):
            if before.get(fact) != after.get(fact):
                found.notes.append(f"{name}: {fact} {before.get(fact)} → {after.get(fact)}")
        masses = [table_of(part.get("facts")).get(_MASS) for part in (before, after)]
        found.number(MASSES, name, "mass", (masses[0], masses[1]), "kg")
        _checks(found, name, tables_of(before.get("checks")), tables_of(after.get("checks")))
        _gates(found, name, tables_of(before.get("gates")), tables_of(after.get("gates")))


def _checks(found: Changes, part: str, a: Sequence[Data], b: Sequence[Data]) -> None:
    before, after = _keyed(a), _keyed(b)
    for key in found.both(f"check {part}:", before, after):
        old, new = before[key], after[key]
        unit = str(new.get("unit", ""))
        if old.get("unit") != new.get("unit"):
            found.notes.append(
                f"{part} {key}: in {old.get('unit')!r} and {unit!r}, only its verdict is compared"
            )
        else:
            note = _other_model(old, new)
            pair = old.get("value"), new.get("value")
            found.number(STRESSES, part, key, pair, unit, note)
            limits = old.get("limit"), new.get("limit")
            found.number(LIMITS, part, key, limits, unit)
            needed = old.get("required"), new.get("required")
            found.number(LIMITS, part, f"{key}, required safety", needed, "")
            safety = old.get("safety"), new.get("safety")
            needs = _needs(old, new)
            found.number(SAFETY, part, key, safety, "", needs, none="not loaded")
        before_after = str(old.get("status", "none")), str(new.get("status", "none"))
        found.verdict(part, key, *before_after, note=_verdict_note(old, new))


def _keyed(checks: Sequence[Data]) -> dict[str, Data]:
    """Checks by kind and quantity; further ones of the same are counted."""
    result: dict[str, Data] = {}
    for check in checks:
        key = base = f"{check.get('kind', '?')}: {check.get('quantity', '?')}"
        count = 1
        while key in result:
            count += 1
            key = f"{base} ({count})"
        result[key] = check
    return result


def _other_model(old: Data, new: Data) -> str:
    """Say where a demand comes from another model or stands at another place."""
    told = []
    if old.get("method") != new.get("method"):
        told.append(f"model: {old.get('method')} → {new.get('method')}")
    for key in ("place", "cycle", "position"):
        if old.get(key) != new.get(key):
            told.append(f"{key}: {old.get(key)} → {new.get(key)}")
    return "; ".join(told)


def _needs(old: Data, new: Data) -> str:
    before, after = number_of(old.get("required")), number_of(new.get("required"))
    if before is None or after is None:
        return ""
    changed = "" if before == after else f" → {after:g}"
    return f"{before:g}{changed} required"


def _verdict_note(old: Data, new: Data) -> str:
    values = [number_of(side.get("safety")) for side in (old, new)]
    safeties = " → ".join("not loaded" if v is None else safety_text(v) for v in values)
    model = _other_model({"method": old.get("method")}, {"method": new.get("method")})
    return "; ".join(filter(None, [safeties, _needs(old, new), model]))


def _gates(found: Changes, owner: str, a: Sequence[Data], b: Sequence[Data]) -> None:
    before, after = ({str(gate.get("name")): gate for gate in gates} for gates in (a, b))
    for name in found.both(f"validity check {owner}:", before, after):
        words = [_gate_word(side[name]) for side in (before, after)]
        values = [number_of(side[name].get("value")) for side in (before, after)]
        told = " → ".join("no number" if value is None else number(value) for value in values)
        found.verdict(owner, f"validity check {name}", words[0], words[1], told)


def _gate_word(gate: Data) -> str:
    if gate.get("holds"):
        return "holds"
    return "broken" if gate.get("binding", True) else "does not hold"


def _worst_first(changes: Sequence[Change]) -> list[Change]:
    """The design's verdict, then what became worse by most, then what became better."""

    def order(change: Change) -> tuple[bool, bool, int]:
        before, after = _RANK.get(str(change.before)), _RANK.get(str(change.after))
        if before is None or after is None:
            return change.of != "design", change.after == "holds", 0
        return change.of != "design", after > before, -abs(after - before)

    return sorted(changes, key=order)


def _named(parts: Any) -> dict[str, Data]:
    return {str(part.get("name")): part for part in tables_of(parts)}
