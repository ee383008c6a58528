"""Variations of the machines' parts on which the rungs of the ladder are compared.

Each scene is a part of one of the designs under that design's own loads. Its dimensions are
multiplied by factors drawn from a Sobol sequence between stated bounds; what the part's shape
refuses, and what no longer fits its loads, is passed over, so that a scene's variations are those
of the first draws that fit.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from math import exp, log
from typing import Any

import numpy as np
from scipy.stats import qmc

from ballesta.design.read import read_design
from ballesta.machine.elastic_parts import compliances_of
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from bench.beams import BOUNDS, drawn_beams
from bench.levers import TURNS, Drawn, drawn_levers
from checks.design.data import Design, Part
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart, check_reach
from checks.part.part_loads import PartLoads, Runs, loads_on
from checks.stress.solid_mesh_level import Models
from geometry.cad_body import cad_body
from geometry.mesh import MeshError
from geometry.parameters import ParameterError
from geometry.parts import Pin

SEED = 20261121
_DRAWS = 8  # at most this many times as many as are wanted

Range = tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """A part of a design, how many variations of it, and bounds of the factors on its dimensions.

    count   variations besides the part as it is
    bounds  dimension -> smallest and largest factor
    """

    design: str
    part: str
    count: int
    bounds: Mapping[str, Range]

    @property
    def name(self) -> str:
        """Design and part, as `design/part`."""
        return f"{self.design}/{self.part}"


_LINK: Mapping[str, Range] = {
    "width": (0.8, 1.6),
    "thickness": (0.6, 1.8),
    "hole": (0.6, 1.25),
    "second_hole": (0.6, 1.25),
}
_PIN: Mapping[str, Range] = {
    "diameter": (0.75, 1.4),
    "step_fillet": (0.5, 1.8),
    "seat width": (0.6, 1.0),
}
_BAR: Mapping[str, Range] = {
    "width": (0.75, 1.5),
    "wall": (0.6, 1.6),
    "hole": (0.6, 1.2),
    "overhang": (0.8, 1.4),
    "inner_radius": (0.6, 1.6),
    "cutout_length": (0.8, 1.8),
    "cutout_corner": (0.6, 2.0),
}
_SLOTTED: Mapping[str, Range] = {
    "width": (0.85, 1.6),
    "thickness": (0.6, 1.8),
    "hole": (0.7, 1.3),
    "slot_width": (0.6, 1.15),
    "boss_diameter": (0.8, 1.1),
    "boss_height": (0.6, 1.4),
    "boss_fillet": (0.6, 1.6),
}
SCENES = (
    Scene("toggle_press", "bar_upper", 36, _BAR),
    Scene("toggle_press_30x30", "bar_upper", 7, {"width": (0.7, 1.8), "wall": (0.6, 2.0)}),
    Scene("toggle_press", "pin_B", 20, _PIN),
    Scene("slider_crank", "crank", 20, _LINK),
    Scene("slider_crank", "rod", 14, _LINK),
    Scene("slider_crank", "pin_A", 14, _PIN),
    Scene("quick_return", "crank", 16, _LINK),
    Scene("quick_return", "rod", 12, _LINK),
    Scene("quick_return", "lever", 22, _SLOTTED),
    Scene("quick_return", "pin_B", 10, _PIN),
    Scene(
        "spring_hammer",
        "rod",
        16,
        {
            "tube_diameter": (0.7, 1.03),
            "wall": (0.6, 1.8),
            "eye_diameter": (0.9, 1.3),
            "eye_width": (0.9, 1.2),
            "hole": (0.6, 1.1),
            "fillet": (0.5, 2.0),
        },
    ),
    Scene(
        "gallery/gas_engine",
        "rod",
        8,
        {
            "tube_diameter": (0.7, 1.3),
            "eye_diameter": (0.9, 1.3),
            "eye_width": (0.75, 1.2),
            "hole": (0.6, 1.15),
            "fillet": (0.5, 1.6),
        },
    ),
    Scene(
        "gallery/steam_engine",
        "rod",
        8,
        {
            "tube_diameter": (0.65, 1.6),
            "eye_diameter": (0.8, 1.3),
            "eye_width": (0.8, 1.6),
            "hole": (0.6, 1.25),
            "fillet": (0.25, 1.5),
        },
    ),
    Scene(
        "gallery/punching_press",
        "pitman",
        8,
        {
            "tube_diameter": (0.6, 1.15),
            "eye_diameter": (0.8, 1.2),
            "eye_width": (0.75, 1.35),
            "hole": (0.65, 1.3),
            "fillet": (0.5, 3.0),
        },
    ),
    Scene("spring_hammer", "pin_B", 9, _PIN),
    Scene("spring_hammer", "pin_C", 9, _PIN),
    Scene("spring_hammer", "pin_R", 9, _PIN),
    Scene(
        "spring_hammer",
        "leaves",
        12,
        {
            "width": (0.7, 1.6),
            "thickness": (0.7, 1.4),
            "clamp_length": (0.6, 1.5),
            "contact_length": (0.7, 1.5),
        },
    ),
    Scene("gallery/gripper", "upper_link", 10, _LINK),
    Scene("gallery/gripper", "upper_arm", 6, _LINK),
    Scene("gallery/sickle_mower", "pitman", 9, _LINK),
    Scene("gallery/crank_rocker", "coupler", 7, _LINK),
    Scene("gallery/crank_rocker", "rocker", 6, _LINK),
    Scene("gallery/air_compressor", "rod", 7, _LINK),
    Scene("gallery/push_pull_clamp", "link", 4, _LINK),
    Scene("gallery/shaper", "lever", 10, _SLOTTED),
    Scene("gallery/yoke_actuator", "yoke", 8, _SLOTTED),
    Scene("gallery/tail_lift", "lower_arm", 7, _BAR),
    Scene("gallery/tail_lift", "upper_arm", 7, _BAR),
    Scene("straight", "lever", 40, {}),
    Scene("bent", "lever", 40, {}),
    Scene("rhs_beam", "lever", 40, {}),
    Scene("i_beam", "lever", 40, {}),
    Scene("long rhs_beam", "lever", 10, {}),
    Scene("long i_beam", "lever", 10, {}),
)
# by design: parts whose machines are drawn with them, how many are wanted -> these
DRAWN: Mapping[str, Callable[[int], Iterator[Drawn]]] = {
    **{kind: partial(drawn_levers, kind) for kind in TURNS},
    **{shape: partial(drawn_beams, shape) for shape in BOUNDS},
}


@dataclass(frozen=True, eq=False)
class Variation:
    """One variation of a scene: number 0 is the part as it is.

    factors  dimension -> factor on it
    runs     name -> loads of the whole machine in a cycle, with the part as it is
    """

    scene: Scene
    number: int
    factors: Mapping[str, float]
    design: Design
    part: Part
    loads: PartLoads
    runs: Runs

    @property
    def name(self) -> str:
        """`design/part/number`."""
        return f"{self.scene.name}/{self.number}"


class Machines:
    """The designs of the scenes with their cycles, each solved once."""

    def __init__(self, folder: str = "designs") -> None:
        self._folder = folder
        self._solved: dict[str, tuple[Design, Any]] = {}

    def solved(self, name: str) -> tuple[Design, Any]:
        """A design and its solved cycles."""
        if name not in self._solved:
            design = read_design(f"{self._folder}/{name}.toml")
            models = Models()
            masses = part_masses(design, models)
            cycles = solve_cycles(design, masses, compliances_of(design, models))
            self._solved[name] = design, cycles
        return self._solved[name]

    def variations(self, scene: Scene) -> Iterator[Variation]:
        """The part of a scene as it is, then its variations; those alone of drawn parts."""
        if scene.design in DRAWN:
            for number, (numbers, design, cycles) in enumerate(DRAWN[scene.design](scene.count)):
                part = design.parts[scene.part]
                loads = loads_on(design, part, cycles)
                yield Variation(scene, number, numbers, design, part, loads, cycles)
            return
        design, cycles = self.solved(scene.design)
        # bands compare solids on assumed arcs
        part = replace(design.parts[scene.part], clearances={})
        loads = loads_on(design, part, cycles)
        yield Variation(scene, 0, {}, design, part, loads, cycles)
        made = 0
        for factors in _factors(scene, part):
            if made == scene.count:
                return
            try:
                changed = replace(part, geometry=varied(part.geometry, factors))
                check_reach(
                    LoadedPart(design, changed, loads), cad_body(changed.geometry).interfaces
                )
            except (ParameterError, MeshError, DesignError):
                continue
            made += 1
            yield Variation(scene, made, factors, design, changed, loads, cycles)


def _factors(scene: Scene, part: Part) -> Iterator[Mapping[str, float]]:
    """Factors on the dimensions that the part has and that are not 0."""
    names = [name for name in scene.bounds if _has(part.geometry, name)]
    low = np.log([scene.bounds[name][0] for name in names])
    high = np.log([scene.bounds[name][1] for name in names])
    draws = qmc.Sobol(len(names), seed=SEED)
    for _ in range(_DRAWS * scene.count):
        drawn = np.exp(low + (high - low) * draws.random()[0])
        yield dict(zip(names, (float(value) for value in drawn), strict=True))


def _has(shape: Any, name: str) -> bool:
    return name == "seat width" or bool(getattr(shape, name, None))


def varied(shape: Any, factors: Mapping[str, float]) -> Any:
    """A shape with some of its dimensions multiplied; raises ParameterError where it refuses.

    A pin's `diameter` takes the diameters of its seats along, `seat width` means all of them.
    """
    known = {field.name for field in fields(shape)}
    changes = {n: f * getattr(shape, n) for n, f in factors.items() if n in known}
    if isinstance(shape, Pin):
        wide, thick = factors.get("seat width", 1.0), factors.get("diameter", 1.0)
        changes["seats"] = tuple(
            replace(
                seat,
                width=wide * seat.width,
                diameter=None if seat.diameter is None else thick * seat.diameter,
            )
            for seat in shape.seats
        )
    return replace(shape, **changes)


def log_middle(bounds: Range) -> float:
    """The factor in the middle of its bounds, as they are drawn."""
    return exp((log(bounds[0]) + log(bounds[1])) / 2)
