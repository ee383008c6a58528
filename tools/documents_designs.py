"""Designs, their motion and their loads, for the tools that write docs/documents.md."""

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of
from checks.design.data import Design

Floats = NDArray[np.float64]
DESIGNS = Path(__file__).parent.parent / "designs"


@cache
def design(name: str, overrides: tuple[str, ...] = ()) -> Design:
    """Return a design of designs/, changed by overrides ("key=value")."""
    return read_design(DESIGNS / f"{name}.toml", overrides)


@cache
def run(name: str, cycle: str, overrides: tuple[str, ...] = ()) -> loads.CycleLoads:
    """Return the loads of a cycle of a design that states all its masses."""
    found = design(name, overrides)
    stated = found.cycles[cycle]
    return loads.run_cycle(linkage_of(found, {}, stated), stated.run)


def crossed(a: Floats, b: Floats) -> Floats:
    """Return the moment of forces b (n, 2) at arms a (n, 2), counter-clockwise."""
    moment: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return moment
