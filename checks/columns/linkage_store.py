"""The buckling mode of a linkage from the store.

It is computed of a design from which everything has been taken out that only judges parts, so that
no answer can depend on what its key does not hold.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import loads
from checks.columns.linkage_frame import worst_mode
from checks.columns.linkage_search import LinkageMode
from checks.design.data import Design, Part
from checks.store.store import Store

_PACKAGES = ("checks", "fem", "geometry", "loads")


def stored_mode(
    store: Store, design: Design, solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
) -> LinkageMode | None:
    """Return `linkage_frame.worst_mode`; raises loads.LinkageError."""
    bare = unjudged(design)
    return store.remember(
        "linkage_mode", _PACKAGES, (bare, solved), lambda: worst_mode(bare, solved)
    )


def unjudged(design: Design) -> Design:
    """The design without its texts and without what only judges parts or meshes them."""
    left: dict[str, Any] = {"require": None, "duty": None, "drive": None}
    return replace(
        design,
        name="",
        file=Path(),
        source="",
        sources=(),
        sha256="",
        inputs=(),
        overrides=(),
        accuracy=nan,
        defaults_used=(),
        assumed=(),
        parts={name: _unjudged_part(part) for name, part in design.parts.items()},
        **left,
    )


def _unjudged_part(part: Part) -> Part:
    return replace(
        part,
        surface="",
        reliability=nan,
        fkm=None,
        bearing_arc=nan,
        arc_stated=False,
        fineness=nan,
        most_unknowns=0,
    )
