"""A made-up ladder of two parts: rungs without a model, without an answer, without a bar."""

from math import inf

from checks.result.verdict import RungTried
from reports.ladder_summary import LadderPart, LadderResult

from .results import HOSTILE, check

STATIC = {"kind": "static", "limit": 355.0, "required": 1.5}
SHARE = {
    "kind": "buckling", "quantity": "elastic load share", "unit": "", "limit": 1.0,
    "required": 3.0, "numerical": 0.0,
}  # fmt: skip


def static(value, method, **changes):
    return check(**(STATIC | {"value": value, "method": method} | changes))


def share(value, method, **changes):
    return check(**(SHARE | {"value": value, "method": method, "model": 0.01} | changes))


FORMULA = RungTried(
    "formula", 0.0123, 0,
    [static(200.0, "formula", numerical=0.0, model=30.0, model_below=10.0), share(0.02, "formula")],
    "stopped: static pass, 1.5 times its bars included",
)  # fmt: skip
BEAM = RungTried(
    "beam", 0.25, 312, [static(210.0, "beam", numerical=inf), share(0.021, "beam")], "goes on"
)
NONE = RungTried("beam", 0.0, 0, [], "there is no beam of this shape")
SOLID = RungTried(
    "solid 1", 14.2, 48201, [static(207.0, "solid"), share(0.021, "solid (one mesh)")], "stopped"
)
LEFT = RungTried("solid", 0.0, 0, [], "no time: about 30 s, 2 s are left; it may settle static")


def part(name="bar_upper", **changes):
    values = {
        "name": name, "shape": "toggle_bar", "material": "S355", "kinds": ("static", "buckling"),
        "rungs": [FORMULA, BEAM, SOLID], "tried": [FORMULA], "chosen": FORMULA.checks,
    }  # fmt: skip
    return LadderPart(**(values | changes))


def ladder(*parts, **changes):
    values = {
        "name": "Toggle press", "file": "designs/toggle_press.toml", "sha256": "ab" * 32,
        "overrides": [], "parts": list(parts or (part(), part("pin_B", rungs=[FORMULA, NONE]))),
        "solids": "solid F is a check with mesh.fineness F",
        "command": "ballesta ladder designs/toggle_press.toml",
    }  # fmt: skip
    return LadderResult(**(values | changes))


def hostile():
    """Names with markup, an escape sequence and a turned direction, or of 10 000 characters."""
    long = "W" * 10_000
    bad = RungTried(HOSTILE, 1.0, 5, [static(1.0, HOSTILE, place=long, unit=HOSTILE)], HOSTILE)
    left = RungTried(long, 0.0, 0, [], long)
    odd = part(
        HOSTILE, shape=long, material=HOSTILE, rungs=[bad, left], tried=[bad, left],
        chosen=bad.checks,
    )  # fmt: skip
    return ladder(
        odd, part(long), name=long + HOSTILE, file=HOSTILE, overrides=[HOSTILE, long],
        command=HOSTILE, solids=HOSTILE, sha256=HOSTILE,
    )  # fmt: skip
