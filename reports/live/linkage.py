"""The motion of the whole linkage for the page: where parts are and which forces act on them."""

import gzip
import json
from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from reports.motion import Motion
from reports.verdict import DesignResult, PartResult

_STEPS = 60_000  # of a quantity's range: of a path of 600 mm each is 0.01 mm


def motion_text(result: DesignResult) -> str:
    """Base64 of gzip of JSON: a list over the cycles, null where nobody knows the motion.

    A cycle's motion is {index, parts, pins}: `index` (k) the positions of the cycle that are kept;
    `parts`, one for each part of the result or null, {x, y, angle: series, z} in mm and rad;
    `pins` [{on: index of the part, minor, z, x, y, fx, fy: series}] in mm and N; a minor one acts
    on a pin, against those on the bodies that it joins. A series is {from, step, d}: value k is
    from + step * (d[0] + ... + d[k]), `d` being whole numbers.
    "" where no cycle has a motion.
    """
    if not result.motion:
        return ""
    data = [
        _motion(result.motion[name], result.parts) if name in result.motion else None
        for name in result.cycles
    ]
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def _motion(motion: Motion, shown: Sequence[PartResult]) -> dict[str, Any]:
    names = [part.name for part in shown]
    parts: list[dict[str, Any] | None] = []
    for name in names:
        pose = motion.parts.get(name)
        if pose is None:
            parts.append(None)
            continue
        x, y, angle = (series(values) for values in np.asarray(pose).T)
        parts.append({"x": x, "y": y, "angle": angle, "z": round(float(motion.layer[name]), 4)})
    pins = [
        {
            "on": names.index(pin.on),
            "minor": shown[names.index(pin.on)].shape == "pin",
            "z": round(float(pin.z), 4),
            "x": series(pin.place[:, 0]),
            "y": series(pin.place[:, 1]),
            "fx": series(pin.force[:, 0]),
            "fy": series(pin.force[:, 1]),
        }
        for pin in motion.pins.values()
        if pin.on in names
    ]
    return {"index": np.asarray(motion.index).tolist(), "parts": parts, "pins": pins}


def series(values: npt.NDArray[Any]) -> dict[str, Any]:
    """Numbers (k,) as whole differences of steps, each right to half a step of their range."""
    low, high = float(values.min()), float(values.max())
    start = float(f"{low:.9g}")
    step = float(f"{(high - low) / _STEPS:.6g}")
    if step == 0.0:
        return {"from": start, "step": 0, "d": [0] * len(values)}
    whole = np.rint((values - start) / step).astype(int)
    return {"from": start, "step": step, "d": np.diff(whole, prepend=0).tolist()}
