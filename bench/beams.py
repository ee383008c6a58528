"""Beams with three pins of random proportions and loads, on which their formula is calibrated.

Each is the one body of the machine of `bench.levers`, pinned to the ground in the middle. The
numbers are drawn from a Sobol sequence between stated bounds; beams that cannot be built are passed
over.
"""

import tempfile
from collections.abc import Iterator, Mapping
from math import cos, exp, log, radians, sin
from pathlib import Path
from typing import Any

from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from bench.levers import MACHINE, REVERSED, SLANT
from checks.design.data import Design
from checks.design.errors import DesignError
from checks.stress.solid_mesh_level import Models

SEED = 20261127
HEIGHT = 120.0  # mm: all stress is in proportion
FORCE = 10_000.0  # N
_BOTH: Mapping[str, tuple[float, float]] = {
    "first stretch / height": (1.5, 6.0),
    "second stretch / height": (1.5, 6.0),
    "end's boss / height": (0.35, 0.6),
    "middle's boss / height": (0.4, 0.65),
    "hole / boss": (0.4, 0.65),
    "overhang / boss": (0.7, 1.2),
}
BOUNDS: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "rhs_beam": {
        **_BOTH,
        "width / height": (0.35, 0.75),
        "wall / height": (0.035, 0.085),
        "corner / wall": (1.2, 2.5),
        "fillet / wall": (0.5, 1.2),
    },
    "i_beam": {
        **_BOTH,
        "width / height": (0.4, 1.0),
        "wall / height": (0.035, 0.07),
        "flange / wall": (1.3, 2.0),
        "root / wall": (1.0, 2.0),
        "fillet / wall": (0.5, 1.2),
        "boss width / wall": (4.0, 12.0),
    },
}
_BEAM = """\
body = "lever"
shape = "{shape}"
interfaces = {{ A = "A", O = "O", B = "B" }}
holes = {{ A = {{ diameter = "{hole:.9g} mm", boss = "{boss:.9g} mm" }}, O = {{ diameter = "{hub_hole:.9g} mm", boss = "{hub:.9g} mm" }}, B = {{ diameter = "{hole:.9g} mm", boss = "{boss:.9g} mm" }} }}
height = "{height:.9g} mm"
width = "{width:.9g} mm"
fillet = "{fillet:.9g} mm"
overhang = "{overhang:.9g} mm"
material = "S355"
surface = "machined"
bearing_arc = "90 deg"
"""  # noqa: E501
_PROFILES = {
    "rhs_beam": 'wall = "{wall:.9g} mm"\ncorner = "{corner:.9g} mm"\n',
    "i_beam": 'web = "{wall:.9g} mm"\nflange = "{flange:.9g} mm"\nroot = "{root:.9g} mm"\n'
    'boss_width = "{boss_width:.9g} mm"\n',
}


def drawn_beams(shape: str, most: int) -> Iterator[tuple[Mapping[str, float], Design, Any]]:
    """Numbers, design and solved cycles of beams of a shape that can be built."""
    bounds = BOUNDS[shape]
    names = [*bounds, "slant at A", "slant at B", "reversed"]
    draws = qmc.Sobol(len(names), seed=SEED)
    made = 0
    for _ in range(8 * most):
        shares = dict(zip(names, (float(x) for x in draws.random()[0]), strict=True))
        try:
            numbers, design, cycles = _beam(shape, shares)
        except DesignError:
            continue
        made += 1
        yield numbers, design, cycles
        if made == most:
            return


def _beam(shape: str, shares: Mapping[str, float]) -> tuple[Mapping[str, float], Design, Any]:
    found = {
        name: exp(log(low) + shares[name] * (log(high) - log(low)))
        for name, (low, high) in BOUNDS[shape].items()
    }
    slants = [radians(SLANT * (2 * shares[f"slant at {end}"] - 1)) for end in "AB"]
    back = REVERSED[0] + shares["reversed"] * (REVERSED[1] - REVERSED[0])
    sizes = {name: size * HEIGHT for name, size in found.items() if name.endswith("/ height")}
    wall, boss, hub = (
        sizes[f"{name} / height"] for name in ("wall", "end's boss", "middle's boss")
    )
    by_wall = {
        key: found.get(f"{name} / wall", 0.0) * wall
        for key, name in (("corner", "corner"), ("flange", "flange"), ("root", "root"),
                          ("fillet", "fillet"), ("boss_width", "boss width"))
    }  # fmt: skip
    text = (MACHINE + _BEAM + _PROFILES[shape]).format(
        ax=-sizes["first stretch / height"], bx=sizes["second stretch / height"], by=0.0,
        dx=sin(slants[0]), dy=cos(slants[0]), wx=-sin(slants[1]), wy=cos(slants[1]),
        force=FORCE, back=back * FORCE, shape=shape, height=HEIGHT,
        width=sizes["width / height"], wall=wall, boss=boss, hub=hub,
        hole=found["hole / boss"] * boss, hub_hole=found["hole / boss"] * hub,
        overhang=found["overhang / boss"] * hub, **by_wall,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "beam.toml"
        file.write_text(text)
        design = read_design(file)
    return found | {"reversed": back}, design, solve_cycles(design, part_masses(design, Models()))
