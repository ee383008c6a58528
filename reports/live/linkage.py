"""The motion of the whole linkage for the page: where parts are and which forces act on them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from checks.result.motion import Motion
from checks.result.verdict import DesignResult, PartResult
from reports.packed import packed_json, series


def motion_text(result: DesignResult) -> str:
    """Packed JSON: a list over the cycles, null where nobody knows the motion.

    A cycle's motion is {index, parts, pins}: `index` (k) the positions of the cycle that are kept;
    `parts`, one for each part of the result or null, {x, y, angle: series, z} in mm and rad;
    `pins` [{on: index of the part, minor, z, x, y, fx, fy: series}] in mm and N; a minor one acts
    on a pin, against those on the bodies that it joins. reports/packed.py says what a series is.
    "" where no cycle has a motion.
    """
    if not result.motion:
        return ""
    return packed_json(
        [
            _motion(result.motion[name], result.parts) if name in result.motion else None
            for name in result.cycles
        ]
    )


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
