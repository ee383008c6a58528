"""Neighbours of variations: the same design with its dimensions on a grid about the file's.

Lengths of parts, forces and numbers of materials that a variation sets are taken to the nearest
point of a grid whose steps are 20 %, about what the file states: none is more than 9.6 % off. All
else of the variation stays. So a variation's neighbour depends on itself and on the file alone, not
on which variations came before, and many share one.
"""

import gc
import math
import re
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from pathlib import Path

from ballesta.design.read import read_design
from ballesta.machine.runs import doubts_of, run_machine
from checks.design.data import Design
from checks.design.errors import DesignError, NumericsError
from checks.ladder.carried import Neighbour, neighbour_of
from checks.part.loaded_part import LoadedPart
from checks.store.store import Store
from checks.stress.kept_models import Models
from fem.solvers import SolverError
from geometry.mesh import MeshError
from loads import LinkageError

STEP = 1.2
_KEPT = 32  # neighbours of a process; each has a mesh of some MB
_PACKAGES = ("ballesta", "checks", "fatigue", "fem", "geometry", "loads")
_ON_GRID = [
    (re.compile(keys), re.compile(rf"(\d+(?:\.\d+)?)\s*({units})"))
    for keys, units in (
        (r"parts\.\w+\..+", "mm|cm|m"),
        (r"(?:cycles|forces)\..+", "N|kN"),
        (r"materials\.\w+\.\w+", "MPa|GPa|kg/m3"),
    )
]
_found: OrderedDict[tuple[str, ...], Neighbour | str] = OrderedDict()


def on_grid(overrides: Sequence[str], stated: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """The overrides ("key=value") with all that has a grid at its nearest points.

    stated  (key, value) of the file without them

    >>> on_grid(["parts.bar.wall=7.2 mm", "material=S355"], [("parts.bar.wall", "6 mm")])
    ('parts.bar.wall=7.2 mm', 'material=S355')
    >>> on_grid(["parts.bar.wall=6.5 mm"], [("parts.bar.wall", "6 mm")])
    ('parts.bar.wall=6 mm',)
    """
    known = dict(stated)
    return tuple(_near(text, known) for text in overrides)


def _sizes(design: Design) -> list[tuple[str, str]]:
    """Keys and values that a design states, and sizes that the files of its parts have."""
    drawn = [
        (f"parts.{name}.{key}", f"{size:.6g} mm")
        for name, part in design.parts.items()
        for key, size in part.geometry.drawn_sizes.items()
    ]
    return [*design.inputs, *drawn]


def _stated(key: str, known: Mapping[str, str]) -> str:
    """The value of a key, or of that key of the part that its part is like; "" without one."""
    while key not in known:
        table, _, name = key.rpartition(".")
        if f"{table}.like" not in known:
            return ""
        key = f"parts.{known[f'{table}.like']}.{name}"
    return known[key]


def _near(override: str, known: Mapping[str, str]) -> str:
    key, _, value = (text.strip() for text in override.partition("="))
    stated = _stated(key, known)
    for keys, values in _ON_GRID:
        here, there = values.fullmatch(value), values.fullmatch(stated.strip())
        if keys.fullmatch(key) and here and there and here[2] == there[2] and float(there[1]):
            ratio = float(here[1]) / float(there[1])
            steps = round(math.log(ratio) / math.log(STEP)) if ratio else 0
            return f"{key}={float(there[1]) * STEP**steps:.6g} {here[2]}" if ratio else override
    return override


class Neighbours:
    """The neighbours of the parts of one variation of a design."""

    def __init__(self, file: Path, overrides: Sequence[str], store: Store | None = None) -> None:
        """Take the overrides that make the variation.

        store  where the neighbours of earlier runs are
        """
        self._file, self._store, self._overrides = file, store, tuple(overrides)

    def of(self, part: str) -> Neighbour | str:
        """The neighbour of a part; in words, why it has none."""
        try:
            overrides = on_grid(self._overrides, _sizes(read_design(self._file)))
            design = read_design(self._file, overrides)
        except DesignError as error:
            return f"its neighbour is refused: {error}"
        key = (str(self._file), design.sha256, *overrides, part)
        if key not in _found:
            while len(_found) >= _KEPT:
                _found.popitem(last=False)
            if self._store is None:
                _found[key] = self._solved(design, part)
            else:
                inputs = (key[1:], [text for _, text in design.sources])
                _found[key] = self._store.remember(
                    "neighbour", _PACKAGES, inputs, lambda: self._solved(design, part)
                )
        _found.move_to_end(key)
        return _found[key]

    def _solved(self, design: Design, part: str) -> Neighbour | str:
        gc.collect()  # an earlier solid's factors refer to themselves in circles: 0.4 GB of a bar
        models = Models()
        try:
            if part not in design.parts:
                return "its neighbour has no such part"
            machine = run_machine(design, models)
            design, doubts = machine.design, doubts_of(machine.design, machine).all
            loaded = LoadedPart.of(design, design.parts[part], machine.all, models, doubts)
            return neighbour_of(loaded, models)
        except (DesignError, NumericsError, MeshError, SolverError, LinkageError) as error:
            return f"its neighbour cannot be solved: {error}"
