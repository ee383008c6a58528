"""Proof that a derivation by a model of stress gives its check's numbers; words where none does."""

from dataclasses import replace
from math import isfinite

from checks.result.derivation import BARS, BarSymbols, Derivation, Given, Item, Section
from checks.result.verdict import Check

MISSED = "the formulas written here do not give all of the check's numbers"
UNKNOWN = "no derivation of this check is known: its numbers are put in as the check has them"


def with_derivation(check: Check, derivation: Derivation) -> Check:
    """Return a check with its derivation, which says so where it misses the check's numbers."""
    derivation = derivation.with_sampling(check).with_loads(check)
    missed = derivation.misses(check)
    if missed and missed not in derivation.unproved:
        said = "; ".join(text for text in (derivation.unproved, f"{MISSED}: {missed}") if text)
        derivation = replace(derivation, unproved=said)
    return replace(check, derivation=derivation)


def unknown(check: Check) -> Derivation:
    """A derivation that derives nothing and says so."""
    source = f"the check, by {check.method}"
    bars, widths = {}, list[Item]()
    for side, name, size in (
        ("numerical", "numerical error bar", check.numerical - check.sampling),
        ("above", "model band above", check.model - check.loads),
        ("below", "model band below", check.below - check.loads_below),
    ):
        if size and isfinite(size):
            bars[side] = f"e_{side}"
            widths.append(Given(f"e_{side}", name, size, check.unit, source))
    return Derivation(
        cases=(),
        sections=(
            Section("Demand", (Given("v", check.quantity, check.value, check.unit, source, True),)),
            Section("Limit", (Given("L", check.basis, check.limit, check.unit, source, True),)),
            Section(BARS, tuple(widths)),
        ),
        value="v",
        limit="L",
        bars=BarSymbols(**bars, words="bars as the check has them"),
        unproved=UNKNOWN,
    )
