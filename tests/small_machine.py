"""A crank that pushes a slider by a rod, with parts to choose, and loads on one part by hand."""

import numpy as np

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from checks.part.part_loads import PartLoads

MACHINE = """
name = "Crank and slider"
ground = ["O"]
[points]
O = "0, 0 mm"
A = "0, 60 mm"
B = "144, -12 mm"
[bodies.crank]
pins = ["O", "A"]
mass = "0.1 kg"
inertia = "1e-4 kg m2"
centre = "30, 0 mm"
[bodies.rod]
pins = ["A", "B"]
mass = "0.2 kg"
inertia = "5e-4 kg m2"
centre = "80, 0 mm"
[bodies.slider]
pins = ["B"]
mass = "0.5 kg"
guide = { along = "1, 0" }
[forces.drive]
turns = "crank"
at = "O"
[forces.push]
body = "slider"
at = "B"
direction = "-1, 0"
[cycles.turn]
coordinate = "crank.angle"
start = "90 deg"
pace = { coordinate = "crank.angle", speed = "10 rad/s" }
positions = 25
phases = [{ name = "round", to = "450 deg", forces = { push = "400 N" }, solve = "drive" }]
[duty]
cycles = { turn = 1e6 }
"""
PLATE = """
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "A", second = "B" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
mesh = { fineness = 0.5 }
"""


def machine(folder, text=PLATE, *overrides):
    """The design of the crank and slider with further tables."""
    path = folder / "machine.toml"
    path.write_text(MACHINE + text, encoding="utf-8")
    return read_design(path, list(overrides))


def solved(design):
    """Its cycles."""
    return solve_cycles(design, {})


def loads_of(wrenches, reaches=None):
    """Loads of one cycle from (F_x, F_y, M_z) per position and interface."""
    full = {}
    for name, rows in wrenches.items():
        full[name] = np.zeros((len(rows), 6))
        full[name][:, [0, 1, 5]] = rows
    n = len(next(iter(full.values())))
    return PartLoads(
        full,
        np.zeros((n, 4)),
        {"turn": slice(0, n)},
        tuple(f"k = {k}" for k in range(n)),
        ("turn",) * n,
        {name: np.asarray(values, dtype=float) for name, values in (reaches or {}).items()},
    )


class Meshed:
    """The one body of a loaded part: a mesh, also where a body that is not meshed is asked for."""

    def __init__(self, mesh):
        self._mesh = mesh

    def body(self, _shape):
        return self._mesh

    def measured(self, _shape, _fineness):
        return self._mesh
