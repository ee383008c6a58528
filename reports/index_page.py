"""The index of a batch: one HTML page that stands alone, with a table of all checks and a plot.

First-order Sobol' indices of a sample that is there: inputs that drive a result.

The index of an input x is S = Var(E[y|x]) / Var(y), the share of the result's variance that would
go if x were known. It needs no further samples where inputs are independent: sorted by x, the
result is E[y|x] over the rank of x plus scatter. The first coefficients of its cosine series hold
E[y|x], by Parseval their squares add up to its variance (EASI and its form by the discrete cosine
transform: docs.sciml.ai, GlobalSensitivity, "EASI Method"). Scatter alone puts its variance evenly
into all n - 1 coefficients, M/(n - 1) of it into the first M, which is taken off:
S = 1 - (1 - S_M) (n - 1)/(n - 1 - M). An input of few values has the means of its groups in place
of a series, with M one less than their number.
"""

import os
from base64 import b64encode
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import inf
from typing import Any
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from checks.result.verdict import Check
from checks.result.words import clean, need_text, safety_text, utilisation_text
from geometry.mesh import FloatArray
from reports.gauge import gauge
from reports.templating import json_markup, page_template, script_hash

FEWEST = 64  # samples: scatter of an index is some sqrt(2 M) / n, 0.06 there
_WAVES = 8
_TOGETHER = 0.3  # correlation of ranks beyond which neither input has an index of its own
_THE_SAME = 1.0 - 1e-9
Values = Sequence[float | str | None]


def first_order(inputs: Mapping[str, Values], result: FloatArray) -> dict[str, float]:
    """Return the first-order index of each input that is independent of the others, 0 to 1.

    inputs  name -> value of each sample, numbers or words
    result  (n,); samples where it is not finite, or an input is missing, are left out

    Inputs that always change together have one index, which each of them shows. None is returned
    for inputs that are linked otherwise, and none at all below `FEWEST` samples.
    """
    used = np.isfinite(result)
    for values in inputs.values():
        used &= np.array([value is not None for value in values], dtype=bool)
    result = result[used]
    if len(result) < FEWEST or np.ptp(result) == 0.0:
        return {}
    ranks = {
        name: _ranks([value for value, kept in zip(values, used, strict=True) if kept])
        for name, values in inputs.items()
    }
    ranks = {name: rank for name, rank in ranks.items() if rank.max() > 0}
    return {
        name: _index(rank, result)
        for name, rank in ranks.items()
        if not any(_linked(rank, other) for other in ranks.values())
    }


def _ranks(values: Values) -> FloatArray:
    """Place of each value among the different ones."""
    return np.unique(np.array(values), return_inverse=True)[1].astype(float)


def _linked(one: FloatArray, other: FloatArray) -> bool:
    """True for two inputs of which one tells of the other, unless they are one and the same."""
    pairs = len(np.unique(np.stack([one, other]), axis=1).T)
    groups = sorted((int(one.max()) + 1, int(other.max()) + 1))
    if pairs == groups[1] < len(one):  # a value of the finer one has one of the other
        return groups[0] < groups[1]
    together = abs(np.corrcoef(one, other)[0, 1])
    return bool(_TOGETHER < together < _THE_SAME)


def _index(rank: FloatArray, result: FloatArray) -> float:
    from scipy.fft import dct

    count, groups = len(result), int(rank.max()) + 1
    spread = result - result.mean()
    if groups <= _WAVES * 2:
        sizes = np.bincount(rank.astype(int))
        free = groups - 1
        held = (np.bincount(rank.astype(int), spread) ** 2 / sizes).sum()
    else:
        free = _WAVES
        series = dct(spread[np.argsort(rank, kind="stable")], norm="ortho")
        held = (series[1 : free + 1] ** 2).sum()
    share = 1.0 - (1.0 - held / (spread @ spread)) * (count - 1) / (count - 1 - free)
    return float(np.clip(share, 0.0, 1.0))


_MOST_INPUTS = 6  # in the table of checks
STATIC_ROWS = 200  # that are there without a script
ORDER = ("FAIL", "crashed", "out of memory", "out of time", "gave up", "wrong input", "not run",
         "UNDECIDED", "pass")  # fmt: skip
_NUMBERS = ("value", "numerical", "model", "model_below", "limit", "required")
_TEXTS = ("part", "check", "quantity", "unit", "status", "cycle", "position", "place", "method",
          "note")  # fmt: skip


@dataclass(frozen=True, eq=False)
class IndexDesign:
    """A design of a batch.

    name, title, file  of the batch, of the design itself, and where it was read from
    status        "pass", "UNDECIDED", "FAIL", or why it has no verdict; error, stage tell more
    note          what else is to be known of it; broken_gates those that the verdict depends on
    mass          kg, of all parts; None if unknown
    checks        as `Check.to_dict`, "basis" may be left out; with "check", its title, and
                  "governing"
    link          of its own page, relative to the index; "" for none
    thumbnail     PNG; empty for none
    """

    name: str
    title: str
    file: str
    status: str
    error: str
    stage: str
    note: str
    broken_gates: Sequence[str]
    mass: float | None
    checks: Sequence[Mapping[str, Any]]
    link: str
    thumbnail: bytes


def index_html(
    title: str,
    designs: Sequence[IndexDesign],
    varied: Mapping[str, Values],
    left_out: int = 0,
) -> str:
    """Page as text; the same designs give the same page.

    varied    inputs in which the designs differ: name -> value per design
    left_out  how many more there are
    """
    script = _script()
    counts = Counter(design.status for design in designs)
    columns = [] if left_out else columns_of(varied)
    shares = {} if left_out else _shares(designs, varied)
    return page_template("index").render(
        title=title,
        designs=designs,
        counts=[(status, counts[status]) for status in ORDER if counts[status]],
        tones=tone,
        lead=lead(counts),
        varied=[_spread(name, values, shares.get(name)) for name, values in varied.items()],
        shared=bool(shares),
        columns=columns,
        left_out=left_out,
        rows=[
            _static_row(design, [varied[name][index] for name in columns])
            for index, design in enumerate(designs[:STATIC_ROWS])
        ],
        static_rows=STATIC_ROWS,
        data=json_markup(
            _data(designs, varied) | {"columns": [list(varied).index(name) for name in columns]}
        ),
        script=Markup(script),
        script_hash=Markup(script_hash(script)),
    )


def columns_of(varied: Mapping[str, Values]) -> list[str]:
    """Inputs that are columns of the table of checks: those that all designs state, at most six."""
    return [name for name, values in varied.items() if None not in values][:_MOST_INPUTS]


def lead(counts: Mapping[str, int]) -> str:
    """Return the leading sentence: number of designs that pass, and the status of the others."""
    total = sum(counts.values())
    if not total:
        return "No design was checked."
    others = [
        f"{counts[status]} {status}" for status in ORDER if status != "pass" and counts[status]
    ]
    passed = counts["pass"]
    rest = f" The others: {', '.join(others)}." if others else ""
    return f"{passed} of {total} design{'s' * (total > 1)} pass{'es' * (passed == 1)}.{rest}"


def tone(status: str) -> str:
    """Colour class of a status; a design without a verdict has not passed."""
    return status if status in ("pass", "UNDECIDED") else "FAIL"


def _shares(designs: Sequence[IndexDesign], varied: Mapping[str, Values]) -> dict[str, float]:
    """First-order indices of the utilisation of variations of one design."""
    if len({design.file for design in designs}) != 1:
        return {}
    governing = [
        next((check["utilisation"] for check in design.checks if check["governing"]), None)
        for design in designs
    ]
    return first_order(varied, np.array(governing, dtype=float))


def _spread(name: str, values: Values, share: float | None) -> dict[str, Any]:
    """Range of an input, in words, and its share of the result's variance."""
    present = [value for value in values if value is not None]
    different = list(dict.fromkeys(present))
    numbers = [value for value in present if isinstance(value, float)]
    if numbers and len(numbers) == len(present):
        told = f"{min(numbers):.6g} to {max(numbers):.6g}"
    else:
        told = ", ".join(str(value) for value in different[:6]) + ", …" * (len(different) > 6)
    return {
        "name": name,
        "count": len(different),
        "told": told,
        "missing": len(values) - len(present),
        "share": "–" if share is None else f"{share:.0%}",
    }


def _static_row(design: IndexDesign, inputs: Values) -> dict[str, Any]:
    """Row of a design in the table without a script."""
    check = next((check for check in design.checks if check["governing"]), None)
    row = {
        "design": design,
        "href": quote(os.fsencode(design.link)),
        "inputs": ["" if v is None else f"{v:.6g}" if isinstance(v, float) else v
                   for v in inputs],
        "part": "", "check": "", "safety": "", "need": "", "utilisation": "", "gauge": "",
        "told": "; ".join(filter(None, [design.error, *design.broken_gates, design.note])),
    }  # fmt: skip
    if check is None:
        return row
    safety = inf if check["safety"] is None else check["safety"]
    return row | {
        "part": check["part"],
        "check": check["check"],
        "safety": safety_text(safety, check["required"]),
        "need": need_text(check["required"]),
        "utilisation": utilisation_text(check["utilisation"]),
        "gauge": gauge(Check.from_dict({"basis": "", **check})),
    }


def _data(designs: Sequence[IndexDesign], varied: Mapping[str, Values]) -> dict[str, Any]:
    """Everything that the script needs: columns of numbers, and texts by their place in a list."""
    texts: dict[str, int] = {}

    def known(text: object) -> int:
        return texts.setdefault(clean(text), len(texts))

    owned = [(index, check) for index, design in enumerate(designs) for check in design.checks]
    checks: dict[str, list[Any]] = {
        "design": [index for index, _ in owned],
        "governing": [1 if check["governing"] else 0 for _, check in owned],
    }
    for name in _TEXTS:
        checks[name] = [known(check[name]) for _, check in owned]
    for name in _NUMBERS:
        checks[name] = [check[name] for _, check in owned]
    return {
        "order": ORDER,
        "designs": [
            {
                "name": clean(design.name),
                "title": clean(design.title),
                "file": clean(design.file),
                "status": design.status,
                "tone": tone(design.status),
                "told": clean("; ".join(filter(None, [
                    design.error, f"last step: {design.stage}" if design.stage else "",
                    *(f"validity check does not hold: {gate}" for gate in design.broken_gates),
                    design.note,
                ]))),
                "mass": design.mass,
                "link": quote(os.fsencode(design.link)),
                "picture": b64encode(design.thumbnail).decode(),
            }
            for design in designs
        ],
        "varied": [
            {"name": clean(name), "values": [clean(v) if isinstance(v, str) else v for v in values]}
            for name, values in varied.items()
        ],
        "checks": checks,
        "texts": list(texts),
    }  # fmt: skip


@cache
def _script() -> str:
    folder = files("reports").joinpath("templates")
    return "".join(
        folder.joinpath(f"{n}.js").read_text(encoding="utf-8") for n in ("gauge", "index")
    )
