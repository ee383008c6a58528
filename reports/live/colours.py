"""Colours of the live view and of stills, from one file."""

import json
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from geometry.mesh import FloatArray


@cache
def colour_maps() -> dict[str, Any]:
    """Maps by name: of matplotlib, as base64 of 256 times red, green, blue; and "use".

    That of utilisations has the colours `low` up to 1 and `high` above, each evenly spread; of 256
    of them `least` is the last of `low` where little or nothing is above 1.
    """
    text = files("reports.live").joinpath("colour_maps.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def use_colours(uses: FloatArray, end: float) -> FloatArray:
    """Red, green, blue (n, 3), 0 to 255, of utilisations (n,); end of their scale, above 1."""
    low, high = (np.array(colour_maps()["use"][name]) for name in ("low", "high"))
    over = uses[:, None] > 1
    return np.where(over, _between(high, (uses - 1) / (end - 1)), _between(low, uses))


def _between(stops: FloatArray, share: FloatArray) -> FloatArray:
    return np.stack([np.interp(share, np.linspace(0, 1, len(stops)), c) for c in stops.T], axis=1)
