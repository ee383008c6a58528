"""Error bars of a leaf pack's stress by friction between its leaves."""

from dataclasses import replace
from math import isfinite

from checks.result.derivation import Derivation, Given, Item, Step
from checks.result.verdict import Check

WIDER = "Wider by friction between the leaves"  # the title of their section


def with_friction(
    derivation: Derivation, check: Check, most: float, least: float, words: str
) -> Derivation:
    """Return it with the terms of friction in its model band.

    check  already widened by them
    most   stress of the bonded pack over the stress of free leaves; infinite if unknown
    least  the least with any friction
    """
    bars, value, items = derivation.bars, derivation.value, list[Item]()
    if most > 1 and not isfinite(most):
        bars = replace(bars, above="", words=_joined(bars.words, f"bonded: unknown, {words}"))
    elif most > 1 and isfinite(check.model):
        said = f"stress of the bonded pack over that of leaves that slide: {words}"
        items += [
            Given("f_up", said, most, "", "solved once more"),
            Step("w_up", "friction adds above", f"(f_up - 1)*{value}", check.unit),
        ]
        bars = replace(bars, above=f"{bars.above} w_up".strip())
    if least < 1 and isfinite(check.below):
        said = f"least stress with any friction over that of leaves that slide: {words}"
        items += [
            Given("f_lo", said, least, "", "solved once more"),
            Step("w_lo", "friction adds below", f"(1 - f_lo)*{value}", check.unit),
        ]
        bars = replace(bars, below=f"{bars.below} w_lo".strip())
    if items:
        wider = "friction between the leaves, from sliding to bonded, makes it wider"
        bars = replace(bars, words=_joined(bars.words, wider))
    found = replace(derivation, bars=bars)
    return found.with_items(WIDER, items) if items else found


def _joined(*texts: str) -> str:
    return "; ".join(text for text in texts if text)
