"""Records and baselines made by hand."""

from ballesta.regression.file import MASS, Baseline

STATIC, SHARE = "static: peak von Mises stress", "buckling: elastic load share"
STAGES = {
    "loads": "0" * 12,
    "bar: geometry": "1" * 12,
    "bar: mesh": "2" * 12,
    "pin: geometry": "3" * 12,
    "pin: mesh": "2" * 12,
    "code": "4" * 12,
    "libraries": "5" * 12,
}


def check(value, limit, status="pass", rung="formula", unit="MPa", numerical=0.0, required=1.5):
    """A check as a record has it."""
    return {
        "value": value,
        "unit": unit,
        "safety": limit / value if value else None,
        "status": status,
        "rung": rung,
        "numerical": numerical,
        "above": 0.0,
        "below": 0.0,
        "limit": limit,
        "required": required,
    }


def record(static=200.0, *, mass=4.0, share=0.02, rung="formula", **others):
    """A record of a bar and a pin; `others` are keys of the record to replace."""
    bar = {STATIC: check(static, 355.0, rung=rung), SHARE: check(share, 1.0, unit="")}
    pin = {STATIC: check(100.0, 650.0)}
    return {
        "design": "Press",
        "status": "pass",
        "accuracy": 0.05,
        "parts": {
            "bar": {MASS: mass, "rungs": {"static": rung, "buckling": "formula"}, "checks": bar},
            "pin": {MASS: 1.0, "rungs": {"static": "formula"}, "checks": pin},
        },
        "linkage": {},
        "stages": dict(STAGES),
    } | others


def baseline(shares=None, **values):
    """A baseline of such a record."""
    return Baseline(record(**values), {}, shares or {})
