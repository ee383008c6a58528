"""Proof that the formulas of a derivation give the numbers of its check."""

from collections.abc import Iterator, Sequence
from math import isfinite

from checks.result.derivation import Derivation
from checks.result.formulas import FormulaError
from checks.result.verdict import Check

ROUND_OFF = 1e-9  # of a check's value: how far its formulas may miss it


def misses(derivation: Derivation, check: Check) -> str:
    """Differences of a derivation from its check's value, limit and bars, in words; "" for none.

    An infinite bar has no formula: the words of the bars must say why.
    """
    number, bars = derivation.number, derivation.bars
    try:
        pairs = [
            ("a value", number(derivation.value), check.value),
            ("a limit", number(derivation.limit), check.limit),
            *((one, number(one), number(other)) for one, other in derivation.equal),
        ]
        told = [
            f"the formulas give {what} of {found:.9g}, where {wanted:.9g} must stand"
            for what, found, wanted in pairs
            if not (isfinite(wanted) and abs(found - wanted) <= ROUND_OFF * abs(wanted))
        ]
        for name, size, symbols in (
            ("numerical bar", check.numerical, bars.numerical),
            ("model band above", check.model, bars.above),
            ("model band below", check.below, bars.below),
        ):
            told += _missed_bar(derivation, name, size, symbols.split(), abs(check.value))
    except FormulaError as error:
        return f"the formulas give no number: {error}"
    return "; ".join(told)


def _missed_bar(
    derivation: Derivation, name: str, size: float, symbols: Sequence[str], value: float
) -> Iterator[str]:
    found = sum(derivation.number(symbol) for symbol in symbols)
    if not isfinite(size):
        if symbols:
            yield f"the formulas give a {name} of {found:.9g}, where an infinite one must stand"
        elif not derivation.bars.words:
            yield f"nothing says why the {name} is infinite"
    elif not abs(found - size) <= ROUND_OFF * max(value, size):
        if symbols:
            yield f"the formulas give a {name} of {found:.9g}, where {size:.9g} must stand"
        else:
            yield f"no formula gives the {name} of {size:.9g}"
