"""Error bars of the deciding check one by one: how far each alone moves its safety."""

from dataclasses import dataclass, replace
from math import isfinite

from markupsafe import Markup

from checks.result.verdict import Check
from checks.result.words import clipped, safety_text
from reports.gauge import gauge


@dataclass(frozen=True)
class Share:
    """A source of doubt by itself.

    ends      safety at both ends of its bar, in words
    decides   True if the check has another status with this bar than without any
    """

    name: str
    gauge: Markup
    ends: str
    decides: bool


def shares(check: Check) -> list[Share]:
    """Sources of a check's error bars, the widest first; those of no size are left out."""
    mesh = check.numerical - check.sampling if isfinite(check.numerical) else check.numerical
    words = check.derivation.bars.words if check.derivation else ""
    said = words.partition("model: ")[2]
    found = [
        (
            f"model: {said}" if said else "model",
            check.model - check.loads,
            check.below - check.loads_below,
        ),
        ("loads that are not known for certain", check.loads, check.loads_below),
        ("mesh and numerics", mesh, mesh),
        ("between the positions of the cycle", check.sampling, check.sampling),
    ]
    found = [(name, above, below) for name, above, below in found if above > 0 or below > 0]
    found.sort(key=lambda each: -(each[1] + each[2]))
    return [_share(check, *each) for each in found]


def _share(check: Check, name: str, above: float, below: float) -> Share:
    bare = replace(check, numerical=0.0, model=0.0, model_below=0.0)
    alone = replace(bare, model=above, model_below=below)
    least = check.limit / alone.upper if isfinite(above) else 0.0
    most = check.limit / alone.lower if alone.lower > 0 else float("inf")
    ends = f"{safety_text(least, check.required)} to " + (
        safety_text(most, check.required) if isfinite(most) else "any"
    )
    return Share(clipped(name, 120), gauge(alone), ends, alone.status is not bare.status)
