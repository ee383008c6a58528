"""Whether a derivation gives its check's numbers, and what stands for one that is not known."""

from dataclasses import replace
from math import isfinite

from checks.result.derivation import Bars, Derivation, Given, Item, Section
from checks.result.verdict import Check

BARS = "Error bars"  # the title of their section, in every derivation
MISSED = "the formulas written here do not give all of the check's numbers"
_BETWEEN = "e_pos"  # the symbol of what sampling misses
UNKNOWN = "no derivation of this check is known: its numbers are put in as the check has them"


def with_derivation(check: Check, derivation: Derivation) -> Check:
    """Return a check with its derivation, which says so where it misses the check's numbers."""
    derivation = _with_sampling(check, derivation)
    missed = derivation.misses(check)
    if missed and missed not in derivation.unproved:
        said = "; ".join(text for text in (derivation.unproved, f"{MISSED}: {missed}") if text)
        derivation = replace(derivation, unproved=said)
    return replace(check, derivation=derivation)


def _with_sampling(check: Check, derivation: Derivation) -> Derivation:
    """The derivation with what the positions of the cycle miss among its numerical bars."""
    bars = derivation.bars
    if not check.sampling or not isfinite(check.numerical) or _BETWEEN in bars.numerical.split():
        return derivation
    said = "what the check rises by between the positions of the cycle, with a margin"
    item = Given(_BETWEEN, said, check.sampling, check.unit, "docs/theory/error_bars.md")
    *before, last = derivation.sections
    if last.title == BARS:
        sections = (*before, replace(last, items=(*last.items, item)))
    else:
        sections = (*derivation.sections, Section(BARS, (item,)))
    numerical = f"{bars.numerical} {_BETWEEN}".strip()
    return replace(derivation, sections=sections, bars=replace(bars, numerical=numerical))


def unknown(check: Check) -> Derivation:
    """A derivation that derives nothing and says so."""
    source = f"the check, by {check.method}"
    bars, widths = {}, list[Item]()
    for side, name, size in (
        ("numerical", "numerical error bar", check.numerical - check.sampling),
        ("above", "model band above", check.model),
        ("below", "model band below", check.below),
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
        bars=Bars(**bars, words="bars as the check has them"),
        unproved=UNKNOWN,
    )
