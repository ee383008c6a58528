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
    derivation = _with_loads(check, _with_sampling(check, derivation))
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
    numerical = f"{bars.numerical} {_BETWEEN}".strip()
    return replace(_with_bar(derivation, item), bars=replace(bars, numerical=numerical))


def _with_loads(check: Check, derivation: Derivation) -> Derivation:
    """The derivation with what is not known of the loads among its model bands."""
    for side, symbol, size, whole in (
        ("above", "e_load", check.loads, check.model),
        ("below", "e_load_lo", check.loads_below, check.below),
    ):
        known = getattr(derivation.bars, side)
        if not size or not isfinite(whole) or symbol in known.split():
            continue
        said = f"the check under loads that are not known for certain, {side} its value"
        item = Given(symbol, said, size, check.unit, "docs/theory/error_bars.md")
        bars = replace(derivation.bars, **{side: f"{known} {symbol}".strip()})
        derivation = replace(_with_bar(derivation, item), bars=bars)
    return derivation


def _with_bar(derivation: Derivation, item: Item) -> Derivation:
    """The derivation with one more of what its error bars are made of."""
    *before, last = derivation.sections
    if last.title == BARS:
        sections = (*before, replace(last, items=(*last.items, item)))
    else:
        sections = (*derivation.sections, Section(BARS, (item,)))
    return replace(derivation, sections=sections)


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
        bars=Bars(**bars, words="bars as the check has them"),
        unproved=UNKNOWN,
    )
