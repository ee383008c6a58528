"""Refusal of a number among many: a message with the fault, its first place and its count."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def refuse(
    bad: npt.NDArray[np.bool_], problem: str, values: npt.NDArray[np.generic], item: str = "cycle"
) -> None:
    """Raise ValueError with the problem, its first place and the value there, where any is bad."""
    if not bad.any():
        return
    place = np.argwhere(bad)[0].tolist()
    names = ["point", item][2 - len(place) :]
    where = ", ".join(f"{name} {index}" for name, index in zip(names, place, strict=True))
    raise ValueError(
        f"{problem}: {values[tuple(place)]:g}"
        + (f" at {where} ({bad.sum()} of {bad.size})" if place else "")
    )
