"""Checks by formulas of a part's loads, and what derivations share: load cases, common givens.

Kinds of checks: their names, what they compare, and the safety that they must show.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from checks.design.data import Part
from checks.design.model import Requirements, SafetyKey
from checks.part.part_loads import PartLoads
from checks.result.derivation import (
    BARS,
    Acting,
    BarSymbols,
    Derivation,
    Given,
    Item,
    LoadCase,
    Section,
    Step,
    value_of,
)
from checks.result.formulas import Value, evaluate_each
from checks.result.verdict import Check
from geometry.mesh import FloatArray


@dataclass(frozen=True)
class Kind:
    """A kind of check; docs/reference/checks.md lists all of them.

    name      of the kind, such as "bush"
    quantity  name of the value; {} stands for the interface, body or plane that it is of
    demand    the value, in words
    limit     where the limit comes from, in words
    require   key of `require` whose safety it must show
    source    literature and pages of the documentation, in Markdown
    """

    name: str
    quantity: str
    demand: str
    limit: str
    require: SafetyKey
    source: str

    def safety(self, required: Requirements) -> float:
        """The safety that its checks must show."""
        value: float = getattr(required, self.require)
        return value

    def has(self, check: str) -> bool:
        """True for the kind and quantity, "kind: quantity", of one of its checks."""
        pieces = map(re.escape, f"{self.name}: {self.quantity}".split("{}"))
        return re.fullmatch(".+".join(pieces), check) is not None


@dataclass(frozen=True, eq=False)
class Series:
    """A given number with a value (n,) for each position of a part's loads."""

    symbol: str
    meaning: str
    values: FloatArray
    unit: str = ""
    source: str = "the loads"
    main: bool = False

    def at(self, position: int) -> Given:
        """The number at one position."""
        value = float(self.values[position])
        return Given(self.symbol, self.meaning, value, self.unit, self.source, self.main)


@dataclass(frozen=True)
class Heading:
    """Texts of a check beside its numbers.

    of    the interface, body or plane that its quantity is of
    note  in words, or of the values of all symbols at the worst position
    plane, span  of a column, as `Check` has them
    """

    kind: Kind
    place: str
    basis: str
    of: str = ""
    unit: str = "MPa"
    note: str | Callable[[Mapping[str, Value]], str] = ""
    plane: str = ""
    span: float = 0.0


@dataclass(frozen=True)
class Band:
    """Formulas of the model band above and below a value: the last item of each, "" for none."""

    above: Sequence[Item] = ()
    below: Sequence[Item] = ()
    words: str = "a formula has no mesh"

    @property
    def bars(self) -> BarSymbols:
        """The symbols of its ends."""
        above, below = (items[-1].symbol if items else "" for items in (self.above, self.below))
        return BarSymbols(above=above, below=below, words=self.words)


NO_BAND = Band()
EXACT = Band(words="a formula has no mesh; its limit is one of mean stress")


def demand_over(items: Sequence[Series | Item]) -> FloatArray:
    """Value (n,) of the last of some items at every position; raises FormulaError."""
    scope: dict[str, Value] = {}
    for item in items:
        if isinstance(item, Series):
            scope[item.symbol] = np.asarray(item.values, dtype=np.float64)
        elif isinstance(item, Step):
            scope[item.symbol] = evaluate_each(item.formula, scope)
        else:
            scope[item.symbol] = value_of(item, scope)
    return np.asarray(scope[items[-1].symbol])


VALUE = "v"  # the symbol of a check's value in formulas that are asked for by `at_value`


def at_value(check: Check, items: Sequence[Item]) -> float:
    """The last of some items whose formulas use a check's value as `VALUE`; raises FormulaError."""
    return float(demand_over([Given(VALUE, check.quantity, check.value), *items]))


def derivation_at(
    case: LoadCase,
    position: int,
    demand: Sequence[Series | Item],
    limit: Sequence[Item],
    band: Band,
) -> Derivation:
    """Of the last item of a demand against a limit at one of all positions.

    limit  its items; empty where the first item of the demand is it
    """
    there = [item.at(position) if isinstance(item, Series) else item for item in demand]
    sections = [("Demand", there), ("Limit", limit), (BARS, (*band.above, *band.below))]
    return Derivation(
        cases=(case,),
        sections=tuple(Section(title, tuple(items)) for title, items in sections if items),
        value=demand[-1].symbol,
        limit=(limit or demand[:1])[-1].symbol,
        bars=band.bars,
    )


def derived_check(
    part: str,
    cycle: str,
    position: str,
    heading: Heading,
    derivation: Derivation,
    required: Requirements,
) -> Check:
    """A check at a position of a cycle, in words, whose numbers are those of its derivation."""
    bars, note = derivation.bars, heading.note
    above, below = (derivation.number(one) if one else 0.0 for one in (bars.above, bars.below))
    return Check(
        part=part,
        kind=heading.kind.name,
        quantity=heading.kind.quantity.format(heading.of),
        value=derivation.number(derivation.value),
        unit=heading.unit,
        numerical=0.0,
        model=above,
        model_below=below,
        limit=derivation.number(derivation.limit),
        required=heading.kind.safety(required),
        cycle=cycle,
        position=position,
        place=heading.place,
        method="formula",
        basis=heading.basis,
        note=note if isinstance(note, str) else note(derivation.values),
        plane=heading.plane,
        span=heading.span,
        derivation=derivation,
    )


def load_case(part: Part, loads: PartLoads, position: int, symbol: str = "") -> LoadCase:
    """Loads on a part at one of all positions of all cycles."""
    cycle = loads.cycle_names[position]
    return LoadCase(
        symbol=symbol,
        cycle=cycle,
        position=loads.labels[position],
        index=int(position) - loads.cycles[cycle].start,
        acting=tuple(
            Acting(name, part.interfaces.get(name, ""), numbers(wrench[position]))
            for name, wrench in loads.wrenches.items()
        ),
        accelerations=numbers(loads.accelerations[position]),
    )


def position_of(loads: PartLoads, check: Check) -> int:
    """Which of all positions a check's cycle and position are; of equal ones the first."""
    for k, (cycle, label) in enumerate(zip(loads.cycle_names, loads.labels, strict=True)):
        if cycle == check.cycle and label == check.position:
            return k
    raise ValueError(f"{check.part} {check.kind}: no position is {check.cycle}, {check.position}")


def numbers(values: Iterable[float]) -> tuple[float, ...]:
    """Plain numbers of an array."""
    return tuple(float(value) for value in values)


def amplitude_and_mean(compressed: str, source: str) -> Section:
    """Amplitude and mean of the longest chord, from s_1 to s_2.

    compressed  what is said of a mean in compression, which counts as 0
    """
    mean = f"mean: largest principal stress of the middle{compressed}"
    return Section(
        "Amplitude and mean",
        (
            Step(
                "sigma_a",
                "amplitude: half the chord, von Mises",
                "von_mises((s_1 - s_2)/2)",
                "MPa",
                source,
                main=True,
            ),
            Step(
                "sigma_m",
                mean,
                "max(0, largest_principal((s_1 + s_2)/2))",
                "MPa",
                source,
                main=True,
            ),
        ),
    )


def yield_stress(part: Part) -> Given:
    """The yield stress of a part's material."""
    return Given(
        "S_y",
        f"yield stress of {part.material.name}, guaranteed minimum",
        part.material.yield_stress,
        "MPa",
        part.material.source,
        main=True,
    )


def shear_yield() -> Step:
    """The yield stress in shear by von Mises."""
    return Step("tau_y", "yield stress in shear", "S_y/sqrt(3)", "MPa", "von Mises", main=True)


def young(part: Part) -> Given:
    """Young's modulus of a part's material."""
    return Given(
        "E",
        f"Young's modulus of {part.material.name}",
        part.material.youngs_modulus,
        "MPa",
        part.material.source,
    )
