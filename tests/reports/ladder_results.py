"""Made-up models that were tried: without a model, without an answer, without a bar."""

from math import inf

from checks.result.verdict import RungTried

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


# markup, an escape sequence and a turned direction, or 10 000 characters
HOSTILE_RUNGS = [
    RungTried(HOSTILE, 1.0, 5, [static(1.0, HOSTILE, place="W" * 10_000, unit=HOSTILE)], HOSTILE),
    RungTried("W" * 10_000, 0.0, 0, [], "W" * 10_000),
]
