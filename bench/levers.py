"""Levers with three pins of random proportions and loads, on which their formula is calibrated.

Each is the one body of a machine, pinned to the ground at its middle eye. Forces that turn with it
pull at both ends, one is given and the other one balances it. The numbers are drawn from a Sobol
sequence between stated bounds; levers that cannot be drawn are passed over.
"""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import cos, exp, log, radians, sin
from pathlib import Path
from typing import Any

from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks.design.data import Design
from checks.design.errors import DesignError
from checks.stress.solid_mesh_level import Models

Drawn = tuple[Mapping[str, float], Design, Any]
SEED = 20261125
EYE = 40.0  # mm, of the first end: all stress is in proportion
BOUNDS: Mapping[str, tuple[float, float]] = {
    "first arm / eye": (1.8, 6.0),
    "second arm / eye": (1.8, 6.0),
    "hub / eye": (0.8, 2.0),
    "second eye / eye": (0.7, 1.4),
    "hole / eye": (0.3, 0.6),
    "hub's hole / hub": (0.3, 0.6),
    "thickness / hole": (0.4, 1.6),
    "fillet / eye": (0.2, 1.2),
}
TURNS = {"straight": (0.0, 0.0), "bent": (20.0, 115.0)}  # deg, at the hub
SLANT = 60.0  # deg, of the end's forces from square to their arms, at most
REVERSED = (-1.0, 0.4)  # of the given force: its other end over the first
FORCE = 3000.0  # N
MACHINE = """\
name = "Lever"
ground = ["O"]
gravity = "0, 0 m/s2"
[points]
A = "{ax:.9g}, 0 mm"
O = "0, 0 mm"
B = "{bx:.9g}, {by:.9g} mm"
[bodies.lever]
pins = ["A", "O", "B"]
[forces.drive]
body = "lever"
at = "A"
direction = "{dx:.9g}, {dy:.9g}"
follows = "lever"
[forces.work]
body = "lever"
at = "B"
direction = "{wx:.9g}, {wy:.9g}"
follows = "lever"
[cycles.turn]
coordinate = "lever.angle"
start = "0 deg"
pace = {{ coordinate = "lever.angle", speed = "0.1 rad/s" }}
positions = 3
[[cycles.turn.phases]]
name = "there"
to = "2 deg"
solve = "drive"
forces = {{ work = {{ over = "lever.angle", at = ["-1 deg", "3 deg"], force = ["{force:.9g} N", "{back:.9g} N"] }} }}
[[cycles.turn.phases]]
name = "back"
to = "0 deg"
solve = "drive"
forces = {{ work = {{ over = "lever.angle", at = ["-1 deg", "3 deg"], force = ["{force:.9g} N", "{back:.9g} N"] }} }}
[duty]
cycles = {{ turn = 1e6 }}
[parts.lever]
"""  # noqa: E501
_LEVER = """\
body = "lever"
shape = {{ lever = ["A", "O", "B"], fillet = "{fillet:.9g} mm" }}
interfaces = {{ A = "A", O = "O", B = "B" }}
holes = {{ A = {{ diameter = "{hole:.9g} mm", eye = "{eye:.9g} mm" }}, O = {{ diameter = "{hub_hole:.9g} mm", eye = "{hub:.9g} mm" }}, B = {{ diameter = "{other_hole:.9g} mm", eye = "{other:.9g} mm" }} }}
thickness = "{thickness:.9g} mm"
material = "S355"
surface = "machined"
bearing_arc = "90 deg"
"""  # noqa: E501


def drawn_levers(kind: str, most: int) -> Iterator[Drawn]:
    """Numbers, design and solved cycles of levers, "straight" or "bent", that can be drawn."""
    names = [*BOUNDS, "turn", "slant at A", "slant at B", "reversed"]
    return drawn(names, most, SEED, partial(_lever, kind))


def drawn(
    names: Sequence[str], most: int, seed: int, make: Callable[[Mapping[str, float]], Drawn]
) -> Iterator[Drawn]:
    """Scenes made of shares by name, from 0 to 1 (Sobol), as far as they can be drawn."""
    draws = qmc.Sobol(len(names), seed=seed)
    made = 0
    for _ in range(8 * most):
        shares = dict(zip(names, (float(x) for x in draws.random()[0]), strict=True))
        try:
            found = make(shares)
        except DesignError:
            continue
        made += 1
        yield found
        if made == most:
            return


def _lever(kind: str, shares: Mapping[str, float]) -> Drawn:
    found = {
        name: exp(log(low) + shares[name] * (log(high) - log(low)))
        for name, (low, high) in BOUNDS.items()
    }
    low, high = TURNS[kind]
    turn = radians(low + shares["turn"] * (high - low))
    slants = [radians(SLANT * (2 * shares[f"slant at {end}"] - 1)) for end in "AB"]
    back = REVERSED[0] + shares["reversed"] * (REVERSED[1] - REVERSED[0])
    first, second = (found[f"{arm} arm / eye"] * EYE for arm in ("first", "second"))
    other, hub = found["second eye / eye"] * EYE, found["hub / eye"] * EYE
    hole = found["hole / eye"] * EYE
    text = (MACHINE + _LEVER).format(
        ax=-first, bx=second * cos(turn), by=second * sin(turn),
        dx=sin(slants[0]), dy=cos(slants[0]),
        wx=-sin(turn + slants[1]), wy=cos(turn + slants[1]),
        force=FORCE, back=back * FORCE, fillet=found["fillet / eye"] * EYE, hole=hole, eye=EYE,
        hub_hole=found["hub's hole / hub"] * hub, hub=hub,
        other_hole=found["hole / eye"] * other, other=other,
        thickness=found["thickness / hole"] * hole,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lever.toml"
        file.write_text(text)
        design = read_design(file)
    masses = part_masses(design, Models())
    numbers = found | {"turn, rad": turn, "reversed": back}
    return numbers, design, solve_cycles(design, masses)
