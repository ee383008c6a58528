"""Numbers as a page's script unpacks them: reports/live/data.js reads what is written here."""

import gzip
import json
from base64 import b64encode
from typing import Any

import numpy as np
import numpy.typing as npt

_STEPS = 60_000  # of a quantity's range: of a path of 600 mm each is 0.01 mm


def packed_json(data: Any) -> str:
    """Base64 of gzip of JSON; equal data give equal text."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def series(values: npt.NDArray[Any]) -> dict[str, Any]:
    """Numbers (k,) as whole differences of steps, each right to half a step of their range.

    A series is {from, step, d}: value k is from + step * (d[0] + ... + d[k]), `d` being whole.
    """
    low, high = float(values.min()), float(values.max())
    start = float(f"{low:.9g}")
    step = float(f"{(high - low) / _STEPS:.6g}")
    if step == 0.0:
        return {"from": start, "step": 0, "d": [0] * len(values)}
    whole = np.rint((values - start) / step).astype(int)
    return {"from": start, "step": step, "d": np.diff(whole, prepend=0).tolist()}
