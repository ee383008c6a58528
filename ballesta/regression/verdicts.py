"""Changed verdicts, and checks so near their limit that another mesh turns them."""

from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

from ballesta.regression.bands import Band, largest_bar

_ORDER = ("pass", "UNDECIDED", "FAIL")


def is_mesh_noise(
    before: str, now: Mapping[str, Any], kind: str, accuracy: float, band: Band
) -> bool:
    """True if a verdict would be as before with a number that re-meshing gives as well.

    before  the verdict so far
    now     the check as a record has it, with its bars

    That is a value within the band, and a numerical bar from nothing to the largest that a band
    holds for; bars of the model, limit and required safety are taken as they are now. A verdict now
    that its own numbers do not give is no noise.
    """
    largest = largest_bar(str(now["rung"]), kind, accuracy)
    if largest is None or band.width is None or now["numerical"] is None:
        return False
    low, high = (now["value"] * (1 + sign * band.width) for sign in (-1, 1))
    bar, limit, required = largest * high, now["limit"], now["required"]
    above, below = _model_bars(now)
    if now["status"] != _verdict(now):
        return False
    if before == "pass":
        return bool((low + above) * required <= limit)
    if before == "FAIL":
        return bool((high - below) * required > limit)
    return bool((high + bar + above) * required > limit and (low - bar - below) * required <= limit)


def _verdict(check: Mapping[str, Any]) -> str:
    """The verdict that the numbers of a check give, as `Check.status` has it."""
    bar, (above, below) = check["numerical"] * check["value"], _model_bars(check)
    if (check["value"] + bar + above) * check["required"] <= check["limit"]:
        return "pass"
    failed = (check["value"] - bar - below) * check["required"] > check["limit"]
    return "FAIL" if failed else "UNDECIDED"


def _model_bars(check: Mapping[str, Any]) -> tuple[float, float]:
    above, below = (inf if check[name] is None else check[name] for name in ("above", "below"))
    return above, below


def worst(verdicts: Iterable[str]) -> str:
    """The worst of some verdicts, pass of none."""
    return max(verdicts, key=_ORDER.index, default=_ORDER[0])
