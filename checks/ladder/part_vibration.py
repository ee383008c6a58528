"""Natural frequencies of a part by itself, its pins standing still."""

import numpy as np

from checks.design.data import Part
from checks.store.solutions import remembered
from fem.unit_solutions import UnitSolutions
from fem.vibration import link_vibration

_COUNT = 2


def frequency_facts(part: Part, solutions: UnitSolutions) -> dict[str, float | str]:
    """The lowest natural frequencies of a part of one body between its pins, by name.

    On the mesh given, ends free to tilt, which is the lower bound of what forks make of them.
    Nothing for pins, for stacks and for parts with fewer than two interfaces.
    """
    if part.body is None or solutions.ties is not None or len(solutions.interfaces) < 2:
        return {}
    found = remembered(
        solutions,
        "vibration",
        (False, _COUNT),
        lambda: link_vibration(solutions, tilt_held=False, count=_COUNT),
    )
    said = [
        f"{hertz:.4g} {_plane(shape)}"
        for hertz, shape in zip(found.hertz, found.shapes, strict=True)
    ]
    name = "natural frequencies between still pins, forks that let it tilt [Hz]"
    return {name: ", ".join(said) + "; counted: none is lower"}


def _plane(shape: np.typing.NDArray[np.float64]) -> str:
    """In which plane a mode (n_nodes, 3) moves most."""
    sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, :2]).max()
    return "out of plane" if sideways else "in plane"
