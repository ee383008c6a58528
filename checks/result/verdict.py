"""Result of checking a design: checks with their error bars, gates, and the verdict."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, replace
from enum import StrEnum
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Self

from checks.result.plain_data import plain_fields

if TYPE_CHECKING:
    from checks.result.derivation import Derivation, HandComparison
    from checks.result.live_fields import EncodedPart, LiveFields
    from checks.result.motion import PartsMotion

NOT_MESHED = "not meshed"  # the only field on the surface of a part that no stress is known on
_BARS = ("numerical", "model", "model_below")  # of a check: None in plain data where infinite
_NUMBERS = ("value", "limit", "required", "sampling", "loads", "loads_below", "span")


class Status(StrEnum):
    """The outcome of a check; only PASS is a pass."""

    PASS = "pass"
    UNDECIDED = "UNDECIDED"
    FAIL = "FAIL"


@dataclass(frozen=True)
class Check:
    """One line of the verdict: demand with its bars against a limit with its required safety.

    part, kind        whose check it is; "static", "buckling", "fatigue", "bush"
    quantity          name of `value`
    value             the demand, in `unit`
    numerical         half-width of the numerical error bar, in `unit`; infinite if unknown
    sampling          part of `numerical` for peaks between the positions of the cycle, in `unit`
    loads, loads_below  parts of `model` and `model_below` for loads that are not known for certain
    doubts            these parts one by one: words, above and below the value
    model             model band above the value, in `unit`
    model_below       model band below the value; None if the same as above
    limit             largest value that the part can take, in `unit`
    required          safety that must be shown
    cycle, position   where in which cycle, as shown to people ("press, x = 2 mm")
    place             where on the part
    method            which model gave the value
    basis             where the limit comes from, scatter of strength included
    note              anything that a reader must know, such as a singular edge
    plane, span       in which it buckles as a column, "in plane" or "out of plane", and mm between
                      that column's ends; "" and 0 where it does otherwise, 0 mm where the section
                      `place` does by itself
    derivation        how value, limit and bars come about; None where nobody asked for it
    """

    part: str
    kind: str
    quantity: str
    value: float
    unit: str
    numerical: float
    model: float
    limit: float
    required: float
    cycle: str
    position: str
    place: str
    method: str
    basis: str
    note: str = ""
    model_below: float | None = None
    sampling: float = 0.0
    loads: float = 0.0
    loads_below: float = 0.0
    doubts: tuple[tuple[str, float, float], ...] = ()
    plane: str = ""
    span: float = 0.0
    derivation: "Derivation | None" = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        for name in (*_NUMBERS, *_BARS):  # NumPy writes its own numbers otherwise
            value = getattr(self, name)
            object.__setattr__(self, name, None if value is None else float(value))
        if not self.required > 0 or not self.limit > 0:
            raise ValueError(f"{self.part} {self.kind}: limit and required safety must be above 0")
        if not isfinite(self.value) or self.value < 0:
            raise ValueError(f"{self.part} {self.kind}: the value is {self.value}")
        if not (self.numerical >= 0 and self.model >= 0 and self.below >= 0):
            raise ValueError(f"{self.part} {self.kind}: error bars must not be negative")

    def explained_by(self, derivation: "Derivation | None") -> "Check":
        """Return it with a derivation, if any, whose error bars get the terms of the check's."""
        return replace(self, derivation=derivation and derivation.with_bars_of(self))

    def without(self, doubts: Iterable[tuple[str, float, float]]) -> "Check":
        """Return it without the load bars of some of its doubts; as it is where one has no end."""
        some = list(doubts)
        model = self.model - sum(more for _, more, _ in some)
        below = self.below - sum(less for _, _, less in some)
        if not isfinite(model) or not isfinite(below):
            return self
        return replace(self, model=max(model, 0.0), model_below=max(below, 0.0))

    @property
    def safety(self) -> float:
        """Limit over value; infinite for a part without load."""
        return self.limit / self.value if self.value else inf

    @property
    def utilisation(self) -> float:
        """Value times required safety over limit: at most 1 is enough."""
        return self.value * self.required / self.limit

    @property
    def status(self) -> Status:
        """PASS when the upper end of the bars holds the limit, FAIL when the lower end does not."""
        if self.upper * self.required <= self.limit:
            return Status.PASS
        if self.lower * self.required > self.limit:
            return Status.FAIL
        return Status.UNDECIDED

    @property
    def upper(self) -> float:
        """The upper end of the error bars, in `unit`; infinite if either has no end."""
        return self.value + self.numerical + self.model

    @property
    def lower(self) -> float:
        """The lower end of the error bars, in `unit`; it may lie below 0."""
        return self.value - self.numerical - self.below

    @property
    def below(self) -> float:
        """Model band below the value."""
        return self.model if self.model_below is None else self.model_below

    @property
    def settled_by_mesh(self) -> bool:
        """True if a mesh's smaller bar could still change an UNDECIDED verdict."""
        return (
            self.status is Status.UNDECIDED
            and isfinite(self.numerical)
            and replace(self, numerical=self.sampling).status is not Status.UNDECIDED
        )

    @property
    def between_positions(self) -> Status:
        """Status without the part of the numerical bar for peaks between the positions."""
        if not isfinite(self.numerical):
            return self.status
        return replace(self, numerical=max(self.numerical - self.sampling, 0.0)).status

    def to_dict(self) -> dict[str, Any]:
        """The check as plain data, infinite bars as None; with its derivation if it has one."""
        names = (name for name in self.__dataclass_fields__ if name != "derivation")
        plain = {name: getattr(self, name) for name in names}
        plain |= {name: None for name in ("numerical", "model") if not isfinite(plain[name])}
        plain["doubts"] = [list(doubt) for doubt in self.doubts]
        safety = self.safety if isfinite(self.safety) else None
        derived = {} if self.derivation is None else {"derivation": self.derivation.to_dict()}
        return plain | {
            "model_below": self.below if isfinite(self.below) else None,
            "safety": safety,
            "utilisation": self.utilisation,
            "status": str(self.status),
            **derived,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the check that `to_dict` has written; raises TypeError and ValueError.

        What else stands in the data is left out.
        """
        from checks.result.derivation import derivation_of_data, number_of, text_of

        if not isinstance(data, Mapping):
            raise TypeError(f"{str(data)[:40]!r} is no check")
        own: dict[str, Any] = {bar: inf for bar in _BARS}
        for name in cls.__dataclass_fields__:
            if name not in data:
                continue
            value = data[name]
            try:
                if name == "derivation":
                    own[name] = None if value is None else derivation_of_data(value)
                elif name == "doubts":
                    own[name] = tuple((text_of(w), number_of(a), number_of(b)) for w, a, b in value)
                elif name in _BARS:
                    own[name] = inf if value is None else number_of(value)
                else:
                    own[name] = (number_of if name in _NUMBERS else text_of)(value)
            except TypeError as error:
                raise TypeError(f"{name}: {error}") from error
            except ValueError as error:  # a UnicodeEncodeError has other arguments
                raise ValueError(f"{name}: {error}") from error
        missing = [
            name
            for name, one in cls.__dataclass_fields__.items()
            if one.default is MISSING and name not in own
        ]
        if missing:
            raise TypeError(f"a check must have {', '.join(missing)}")
        check = cls(**own)
        if not isfinite(check.utilisation):
            raise ValueError("a check's utilisation is not finite")
        return check


@dataclass(frozen=True)
class Gate:
    """A measured number that must stay below a limit for the result to be valid.

    meaning  meaning of the number, in words
    binding  True if the verdict depends on it: a drive that is too weak leaves the stresses right
    cure     what makes it hold, a sentence without its full stop; "" where nothing simple does
    key      override that makes it hold, such as "cycles.turn.positions=720"; "" without one
    """

    name: str
    value: float
    limit: float
    meaning: str
    binding: bool = True
    cure: str = ""
    key: str = ""

    @property
    def holds(self) -> bool:
        """True if the result may be trusted in this respect."""
        return bool(self.value <= self.limit)

    @property
    def told(self) -> str:
        """Meaning of the number, followed by the cure if there is one."""
        return f"{self.meaning}. {self.cure}" if self.cure else self.meaning

    def to_dict(self) -> dict[str, Any]:
        """The gate as plain data."""
        return plain_fields(self) | {"holds": self.holds}


@dataclass(frozen=True)
class Way:
    """A way out of an open verdict, or that there is none.

    settles  what it settles: a check or a gate, in words
    text     what is to be done or stated; where nothing settles it, why
    command  that tries it; "" where there is none
    seconds  that it is expected to take; None where that is not known
    """

    settles: str
    text: str
    command: str = ""
    seconds: float | None = None

    @property
    def settled(self) -> list[str]:
        """Each that it settles; a comma in brackets is of a name.

        >>> Way("buckling (frame, share) of the linkage, static of rod", "").settled
        ['buckling (frame, share) of the linkage', 'static of rod']
        """
        return re.split(r", (?![^()]*\))", self.settles)

    def to_dict(self) -> dict[str, Any]:
        """The way as plain data."""
        return plain_fields(self)


@dataclass(frozen=True)
class Change:
    """One input with another value, and its effect: an estimate until a check has verified it.

    key, was, value  the input and its values as written; a dimension has a standard size
    parts            that pass with it, of those that it is meant for
    safety, lower    of the check that then governs these: at its value, at the end of its bars
    required         safety that this check must show
    governing        that check in words
    model            whose error bars the safety has
    mass             t, of all parts; saved is the mass that it takes away
    verified         the verdict of a check by the deciding model; None where none was made
    """

    key: str
    was: str
    value: str
    parts: tuple[str, ...]
    safety: float
    lower: float
    required: float
    governing: str
    model: str
    mass: float
    saved: float
    verified: Status | None = None
    verified_safety: float | None = None

    @property
    def override(self) -> str:
        """The change as `--set` takes it."""
        return f"{self.key}={self.value}"

    def to_dict(self) -> dict[str, Any]:
        """The change as plain data; masses in kg."""
        own = plain_fields(self, "lower", "mass", "saved")
        return own | {
            "lower_safety": self.lower if isfinite(self.lower) else None,
            "mass_kg": 1e3 * self.mass,
            "saved_kg": 1e3 * self.saved,
            "verified": None if self.verified is None else str(self.verified),
        }


def check_ids(checks: Sequence[Check]) -> list[str]:
    """Identifiers of the checks of a part or of the linkage, for programs that compare results.

    Part and kind, as "pin_B/fatigue"; with the quantity where the part has two of the kind, as
    "bar/buckling/column in plane"; counted where that is the same, too. The same checks have the
    same identifiers whatever their values, and whichever other kinds of checks there are.
    """
    kinds = [f"{check.part}/{check.kind}" for check in checks]
    ids = [
        f"{kind}/{check.quantity}" if kinds.count(kind) > 1 else kind
        for check, kind in zip(checks, kinds, strict=True)
    ]
    return [
        f"{name} ({count})" if (count := ids[: k + 1].count(name)) > 1 else name
        for k, name in enumerate(ids)
    ]


def _identified(checks: Sequence[Check]) -> list[dict[str, Any]]:
    """The checks as plain data, each led by its identifier."""
    pairs = zip(check_ids(checks), checks, strict=True)
    return [{"id": name} | check.to_dict() for name, check in pairs]


def status_of(checks: Sequence[Check], gates: Sequence[Gate]) -> Status:
    """FAIL if a check fails, else UNDECIDED if one is or a binding gate breaks, else PASS."""
    outcomes = {check.status for check in checks}
    if Status.FAIL in outcomes:
        return Status.FAIL
    broken = any(not gate.holds and gate.binding for gate in gates)
    if Status.UNDECIDED in outcomes or broken or not checks:
        return Status.UNDECIDED
    return Status.PASS


def deciding_of(checks: Sequence[Check]) -> Check:
    """The check that is nearest to its limit, bars included; a worse status comes first."""
    order = {Status.FAIL: 0, Status.UNDECIDED: 1, Status.PASS: 2}
    return min(
        checks,
        key=lambda c: (
            order[c.status],
            -(c.value + (c.numerical + c.model if isfinite(c.numerical) else 0))
            * (c.required / c.limit),
        ),
    )


@dataclass(frozen=True, eq=False)
class Surface:
    """Fields on the surface of a part, for pictures and files.

    nodes      (n, 3) mm; triangles (m, 3) indices of them
    fields     name -> (n,) values
    peak       index of the node that carries the reported peak stress
    directed   name -> vectors (n, 3) or stress (n, 6), xx, yy, zz, xy, yz, zx, for files
    """

    nodes: Any
    triangles: Any
    fields: Mapping[str, Any]
    peak: int
    directed: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_bare(self) -> bool:
        """True if no stress is known on it: its part was not meshed."""
        return list(self.fields) == [NOT_MESHED]


@dataclass(frozen=True, eq=False)
class RungTried:
    """A model of a part that was tried, or passed over, and the outcome.

    rung      "formula" or "solid"
    seconds   that it took; 0 if it was passed over
    unknowns  that it solved
    checks    its results
    why       why it stopped, went on, or was passed over
    left      kinds of checks that a better model may still settle after it
    expected  s that it would have taken, of one for which there was no time; 0 otherwise
    """

    rung: str
    seconds: float
    unknowns: int
    checks: Sequence[Check]
    why: str
    left: Sequence[str] = ()
    expected: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """The rung as plain data."""
        return plain_fields(self)


@dataclass(frozen=True, eq=False)
class PartResult:
    """Everything that was found about one part.

    meshes   one dict per mesh that was solved: unknowns, elements, peak stress, ...
    charts   plain data of the part's charts (Haigh path)
    mode     the lowest buckling mode: nodes as displaced, exaggerated; one field, its size
    rungs    models that were tried, in their order
    live     fields at every position, for a page; None where none is to be written
    """

    name: str
    shape: str
    material: str
    checks: Sequence[Check]
    gates: Sequence[Gate]
    hand_checks: Sequence["HandComparison"]
    meshes: Sequence[Mapping[str, Any]]
    facts: Mapping[str, Any]
    charts: Mapping[str, Any]
    surface: Surface
    assumed: Sequence[str] = ()
    mode: Surface | None = None
    rungs: Sequence[RungTried] = ()
    live: "LiveFields | EncodedPart | None" = None

    def required_safety(self, kind: str) -> float | None:
        """Return the safety that its first check of a kind requires; None without such a check."""
        return next((check.required for check in self.checks if check.kind == kind), None)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data, without fields on the surface."""
        own = plain_fields(self, "checks", "surface", "mode", "live")
        return own | {"checks": _identified(self.checks)}


@dataclass(frozen=True, eq=False)
class DesignResult:
    """Everything that was found about one design.

    cycles    name -> plain data over the cycle: shown position, forces, efforts
    gates     of the loads
    linkage   checks of the linkage as a whole
    timings   stage -> s
    inputs    every input as (key, value); `defaults` those that the file did not state
    motion    cycle -> how the parts move in it; none of a run that was measured
    assumed_by_design  keys of `assumed` that the design itself marks; the others are the tool's
    ways     out of what is open, the cheapest first (checks/result/ways.py)
    changes  single changes that make it pass, or save mass, best first
    unchanged  why there are no changes, in words; "" where there are, and where none were sought
    date     of the check, as 2026-11-23; "" if not known
    """

    name: str
    file: str
    sha256: str
    overrides: Sequence[str]
    parts: Sequence[PartResult]
    cycles: Mapping[str, Mapping[str, Any]]
    gates: Sequence[Gate]
    warnings: Sequence[str]
    not_checked: Sequence[str]
    assumed: Sequence[tuple[str, str]]
    defaults: Sequence[tuple[str, str]]
    inputs: Sequence[tuple[str, str]]
    source: str
    versions: Mapping[str, str]
    command: str
    timings: Mapping[str, float] = field(default_factory=dict)
    linkage: Sequence[Check] = ()
    motion: "Mapping[str, PartsMotion]" = field(default_factory=dict)
    assumed_by_design: Sequence[str] = ()
    ways: Sequence[Way] = ()
    changes: Sequence[Change] = ()
    date: str = ""
    unchanged: str = ""

    @property
    def checks(self) -> list[Check]:
        """All checks of all parts, in order, then those of the linkage."""
        return [*(check for part in self.parts for check in part.checks), *self.linkage]

    @property
    def status(self) -> Status:
        """FAIL if a check fails, else UNDECIDED if one is or a binding gate breaks, else PASS."""
        return status_of(self.checks, self.all_gates)

    @property
    def all_gates(self) -> list[Gate]:
        """Gates of the loads and of every part."""
        return [*self.gates, *(gate for part in self.parts for gate in part.gates)]

    @property
    def deciding(self) -> Check:
        """The check that is nearest to its limit, bars included; a worse status comes first."""
        return deciding_of(self.checks)

    @property
    def exit_code(self) -> int:
        """0 when every part passes, else 1."""
        return 0 if self.status is Status.PASS else 1

    def _decided_by(self) -> dict[str, str] | None:
        if not self.checks:
            return None
        deciding, owners = self.deciding, [*(part.checks for part in self.parts), self.linkage]
        pairs = (pair for own in owners for pair in zip(check_ids(own), own, strict=True))
        name = next(name for name, check in pairs if check is deciding)
        return {"id": name, "part": deciding.part, "kind": deciding.kind}

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data."""
        own = plain_fields(self, "source", "motion", "ways", "linkage")
        return (
            {"format": "ballesta-result/1"}
            | own
            | {
                "status": str(self.status),
                "exit_code": self.exit_code,
                "decided_by": self._decided_by(),
                "linkage": _identified(self.linkage),
                "ways_out": [way.to_dict() for way in self.ways],
            }
        )
