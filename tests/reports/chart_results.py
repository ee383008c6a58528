"""Made-up data of every chart, of a press that is sampled at any number of positions."""

from dataclasses import replace
from math import inf

import numpy as np

from checks.result.verdict import RungTried

from . import results


def cycle(n=61, duty=1.1e7):
    """A press stroke: cylinder and process in balance, so that powers cancel."""
    made = results.cycle(n)
    time = np.array(made["time"])
    rate = np.gradient(np.array(made["position"]), time)
    process = np.array(made["efforts"]["process"])
    powers = {"cylinder": -process * rate, "process": process * rate}
    works = {k: float(np.trapezoid(v, time)) for k, v in powers.items()}
    return made | {"powers": powers, "works": works, "duty": duty, "torques": {}}


def haigh(n):
    """A path from nothing to the critical point (40, 35) and back."""
    share = 0.5 - 0.5 * np.cos(np.linspace(0, 2 * np.pi, n))
    share[n // 2] = 1.0
    path = {"mean": (40 * share).tolist(), "amplitude": (35 * share).tolist()}
    return results.haigh() | {"criterion": "Goodman", "paths": {"press": path}}


def fkm(n):
    ratio = np.array([0.0, 1.0, 2.0, 3.0, 10.0])
    factor = np.array([1.0, 0.9, 0.85, 0.8, 0.8])
    line = np.stack([ratio * factor * 150, factor * 150], axis=1)
    return haigh(n) | {"criterion": "FKM", "line": line.tolist(), "sensitivity": 0.1}


def sn(**changes):
    equivalent = 35 / (1 - 40 / 470)
    return {
        "asked": "infinite", "required": 1.3, "chain": "Marin", "why": "", "limit": 150.0,
        "ultimate": 470.0, "endless": True, "allowed": 1.0, "damage": 0.0,
        "line": [[1e3, 420.0], [1e6, 150.0]], "below": [[1e6, 150.0], [1e9, 100.0]],
        "cycles": [[1.1e7, equivalent, 0.0, 1.35 * equivalent], [1.1e7, 1.0, 0.0, 1.3]],
        "left_out": 0.0, "left_damage": 0.0,
    } | changes  # fmt: skip


def column(**changes):
    plane = {"plane": "in plane", "section": "tube", "area": 1000.0, "slenderness": 40.0,
             "stiffest": 40.0, "length": 500.0, "stress": 60.0, "limit": 330.0,
             "law": "Johnson"}  # fmt: skip
    return {
        "youngs_modulus": 210e3, "yield": 355.0, "required": 3.0, "curve": None,
        "cycle": "press", "position": "x = 2 mm",
        "force": {"press": np.linspace(-1e3, 6e4, 183).tolist()},
        "planes": [plane, plane | {"plane": "out of plane", "slenderness": 60.0, "stiffest": 30.0}],
    } | changes  # fmt: skip


CONVERGENCE = {
    "static": [
        {"unknowns": 30123, "value": 138.0, "bar": None},
        {"unknowns": 81234, "value": 141.0, "bar": 3.0},
    ],
    "fatigue": [
        {"unknowns": 30123, "value": 36.0, "bar": None},
        {"unknowns": 81234, "value": 38.0, "bar": 1.0},
    ],
}


def part(n=183, **charts):
    """A part that a formula and a solid were tried for."""
    solid = replace(results.PASSING, method="solid")
    fatigue = replace(results.PASSING, kind="fatigue", value=38.0, limit=150.0, required=1.3,
                      method="solid", numerical=1.0, model=0.0)  # fmt: skip
    formula = replace(solid, method="formula", value=120.0, numerical=0.0, model=30.0)
    unknown = replace(fatigue, method="formula", model=inf)
    rungs = [
        RungTried("formula", 0.02, 0, [formula, unknown], "goes on: fatigue has no error bar"),
        RungTried("formula", 0.0, 0, [], "there is no formula of this shape"),
        RungTried("solid", 12.0, 81234, [solid, fatigue], "stopped: static pass"),
    ]
    data = {"by": "solid", "haigh": haigh(n), "sn": sn(), "column": column(),
            "convergence": CONVERGENCE, "peaks": {}}  # fmt: skip
    return results.part(checks=[solid, fatigue], charts=data | charts, rungs=rungs)


def design(n=61, **charts):
    return results.design(part(3 * n, **charts), cycles={"press": cycle(n)})
