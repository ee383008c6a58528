"""Beams with three pins of random proportions and loads: their formula beside solids.

    python -m bench.beams [--most 8] [rhs_beam] [i_beam]

Largest stress of the first position by place, solid over formula: outermost fibres, holes, and webs
about the bosses. The solid is one mesh of a half, without error bars: of a hollow section these
take the inner corners, along which it is bent, for notches.

Each beam is the one body of the machine of `bench.levers`, pinned to the ground in the middle. The
numbers are drawn from a Sobol sequence between stated bounds; beams that cannot be built are passed
over.
"""

import argparse
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import chain
from math import cos, exp, log, radians, sin
from pathlib import Path
from typing import Any

import numpy as np

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from bench.levers import MACHINE, REVERSED, SLANT, Drawn, drawn
from checks.design.data import Design
from checks.models import shapes
from checks.part.part_loads import loads_on
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Models
from fem.recovery import von_mises
from geometry.mesh import FloatArray
from geometry.parts import Beam
from geometry.shape import Half

SEED = 20261127
FINENESS = 0.8
FIBRES, HOLES, FEET = "fibres", "holes", "feet"
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
LONG = "long "  # before the shape: beams of longer stretches
_STRETCHES: Mapping[str, tuple[float, float]] = {
    f"{which} stretch / height": (6.0, 12.0) for which in ("first", "second")
}
BOUNDS = {**BOUNDS, **{LONG + shape: {**own, **_STRETCHES} for shape, own in BOUNDS.items()}}
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


def drawn_beams(kind: str, most: int) -> Iterator[Drawn]:
    """Numbers, design and solved cycles of beams of a shape, or long ones, that can be built."""
    names = [*BOUNDS[kind], "slant at A", "slant at B", "reversed"]
    return drawn(names, most, SEED, partial(_beam, kind))


def _beam(kind: str, shares: Mapping[str, float]) -> Drawn:
    found = {
        name: exp(log(low) + shares[name] * (log(high) - log(low)))
        for name, (low, high) in BOUNDS[kind].items()
    }
    shape = kind.removeprefix(LONG)
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


def _places(beam: Beam, points: FloatArray) -> list[str]:
    """Where points of a solid count: in a hole, about a boss, or elsewhere; "" in a boss."""
    found = np.full(len(points), FIBRES)
    for hole in beam.holes:
        away = np.hypot(points[:, 0] - hole.at, points[:, 1])
        found[away < hole.boss / 2 + 2.5 * beam.fillet] = FEET
        found[away < hole.boss / 2 - 1e-3] = ""
        found[away < 0.505 * hole.diameter] = HOLES
    return [str(one) for one in found]


def compared(design: Design, cycles: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Largest stress by place, MPa, of the solid and by formula."""
    part = design.parts["lever"]
    loads, beam = loads_on(design, part, cycles), part.geometry
    model = shapes.model_of(part, loads)
    assert model is not None
    assert isinstance(beam, Beam)
    solved = Models().solutions(Half(beam), FINENESS, elastic_of(part))
    states, _ = solved.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    surface = solved.recovery.surface_stress(solved.moved(states[:, :1]))[:, :, 0]
    own = [
        FEET if name.startswith("foot") else HOLES if name in beam.interfaces else FIBRES
        for name in model.places
    ]
    history = model.history
    by_formula = history.basis @ history.coefficients[:, 0]
    of_solid = _places(beam, solved.mesh.nodes[solved.recovery.points])
    return _largest(of_solid, surface), _largest(own, by_formula)


def _largest(places: list[str], stress: FloatArray) -> dict[str, float]:
    found: dict[str, float] = defaultdict(float)
    for place, value in zip(places, von_mises(stress), strict=True):
        found[place] = max(found[place], float(value))
    found.pop("", None)
    return found


def main() -> None:
    """Compare, and print every beam and the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shapes", nargs="*", default=list(BOUNDS))
    parser.add_argument("--most", type=int, default=8)
    options = parser.parse_args()
    for shape in options.shapes:
        rows = []
        for _, design, cycles in drawn_beams(shape, options.most):
            solid, formula = compared(design, cycles)
            rows.append([solid[place] / formula[place] for place in (FIBRES, HOLES, FEET)])
            rows[-1].append(max(solid.values()) / max(formula.values()))
            told = chain.from_iterable((solid[k], formula[k]) for k in (FIBRES, HOLES, FEET))
            print(shape, *(f"{value:7.1f}" for value in told), *(f"{r:6.3f}" for r in rows[-1]))
        ratios = np.array(rows)
        for name, of in (("median", np.median), ("least", np.min), ("most", np.max)):
            print(f"{shape} {name:6s}", *(f"{value:6.3f}" for value in of(ratios, axis=0)))


if __name__ == "__main__":
    main()
