"""A part under loads of any size, in any unit, turned, far away, rounded and renumbered."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from fatigue import goodman
from fem.recovery import von_mises
from fem.stress_history import StressHistory
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import Mesh
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

from ...boundary_value import SolidProblem, body_load, pressure_load
from ..solids.bodies import ring_body
from ..solids.problems import STEEL, held
from ..solids.test_patch import EXACT, patch, solved

LOADS = tuple(10.0**k for k in range(-9, 10, 2))
AWAY = (1.0, 1e3, 1e5, 1e6, 9e6)
ROUNDED = (1e-9, 1e-6, 1e-3)
LINK = PlateLink(length=60, width=24, thickness=8, hole=10, second_hole=12)
ENDURANCE, ULTIMATE = 180.0, 600.0


class Answers(NamedTuple):
    """What a check would tell: largest von Mises stress, MPa, and Goodman utilisation.

    stress  (n_points, 6, 12) MPa
    energy  (12,) N mm, of strain
    """

    peak: float
    utilisation: float
    stress: np.ndarray
    energy: np.ndarray


@cache
def link():
    """The plate link, solved for unit loads."""
    return solve_unit_loads(mesh_shape(LINK, fineness=0.6), STEEL)


def answers(solved, factor=1.0, *, length=1.0, force=1.0, pressure=1.0):
    """Pull, bend and swing a link; forces scaled by `factor`, in units of so many N, mm and MPa.

    Twelve positions of a turning force at both ends, with the couple that balances it.
    """
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    pull = np.stack([1000 + 500 * np.cos(angle), 200 * np.sin(angle)], axis=1) * factor / force
    wrenches = {name: np.zeros((12, 6)) for name in ("first", "second")}
    wrenches["first"][:, :2], wrenches["second"][:, :2] = -pull, pull
    wrenches["first"][:, 5] = -pull[:, 1] * 60 / length
    coefficients, _ = solved.coefficients(wrenches, np.zeros((12, 4)))
    nodes = solved.recovery.points
    history = StressHistory(nodes, solved.mesh.nodes[nodes], solved.basis, coefficients)
    limits = np.full(len(nodes), ENDURANCE / pressure)
    result = goodman(history.basis, coefficients, limits, ULTIMATE / pressure, cycle="swing")
    stress = np.stack([history.at(k) for k in range(12)], axis=-1)
    peak = float(von_mises(np.moveaxis(stress, 1, -1)).max())
    moved, pushed = solved.displacement @ coefficients, solved.loads @ coefficients
    energy = (moved * pushed).sum(axis=0) / 2
    return Answers(peak, float(result.utilisation.max()), stress, energy)


def load_scale(factor):
    """Largest deviation of stress and of Goodman utilisation from `factor` times those of 1."""
    one, other = answers(link()), answers(link(), factor)
    return (
        float(np.abs(other.stress / factor - one.stress).max() / np.abs(one.stress).max()),
        other.peak / factor / one.peak - 1,
        other.utilisation / factor / one.utilisation - 1,
    )


def in_metres():
    """The same mesh in m, N, Pa, kg: deviations of stress, strain energy, Goodman utilisation."""
    mesh, scale = link().mesh, 1e-3
    interfaces = {
        name: replace(
            face, centre=scale * face.centre, radius=scale * face.radius, length=scale * face.length
        )
        for name, face in mesh.interfaces.items()
    }
    metres = replace(
        mesh, nodes=scale * mesh.nodes, interfaces=interfaces, volume_cad=1e-9 * mesh.volume_cad
    )
    other = solve_unit_loads(metres, Elastic(210e9, 0.3, 7850.0))
    one, two = answers(link()), answers(other, length=1e3, pressure=1e-6)
    return (
        float(np.abs(1e-6 * two.stress - one.stress).max() / np.abs(one.stress).max()),
        float(np.abs(1e3 * two.energy / one.energy - 1).max()),
        two.utilisation / one.utilisation - 1,
    )


def turn(degrees, axis=(1.0, 2.0, 3.0)):
    """Rotation matrix about an axis (Rodrigues)."""
    angle, along = np.radians(degrees), np.array(axis) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), along)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@cache
def _ring():
    return ring_body(50.0, 100.0, 25.0, 16.0, 12.0).mesh(1.0)


def _pressed(mesh, direction=(0.0, 0.0, 1.0)):
    problem = SolidProblem(mesh, STEEL, held(mesh, ("z1", "xyz")))
    load = pressure_load(problem.elements, "x0", 80.0)
    weight = 0.02 * np.array(direction)
    load += body_load(problem.elements, lambda points: np.broadcast_to(weight, points.shape))
    return problem.solve(load)


@cache
def _ring_stress():
    return von_mises(_pressed(_ring()).stress)


def turned(degrees):
    """Largest deviation of the von Mises stress of a ring that is turned with its loads."""
    by = turn(degrees)
    found = von_mises(_pressed(replace(_ring(), nodes=_ring().nodes @ by.T), by[:, 2]).stress)
    return float(np.abs(found - _ring_stress()).max() / _ring_stress().max())


def moved(sizes):
    """Largest error of an even stress in the patch test, `sizes` times its size from the origin."""
    mesh = patch()
    away = sizes * np.array([0.6, 0.64, 0.48])
    stress, _ = solved(Mesh(mesh.nodes + away, mesh.elements, {}, {}, 1.0))
    return float(np.abs(stress - EXACT).max() / EXACT.max())


def rounded(step):
    """Largest change of the link's stress and of its peak where coordinates are rounded, mm."""
    mesh = link().mesh
    other = solve_unit_loads(replace(mesh, nodes=step * np.round(mesh.nodes / step)), STEEL)
    one, two = answers(link()), answers(other)
    return (
        float(np.abs(two.stress - one.stress).max() / np.abs(one.stress).max()),
        two.peak / one.peak - 1,
    )


def renumbered():
    """Largest deviation of the ring's von Mises stress where nodes and elements are shuffled."""
    mesh, shuffle = _ring(), np.random.default_rng(5)
    place = shuffle.permutation(len(mesh.nodes))
    nodes = np.empty_like(mesh.nodes)
    nodes[place] = mesh.nodes
    elements = place[mesh.elements][shuffle.permutation(len(mesh.elements))]
    surfaces = {name: place[facets] for name, facets in mesh.surfaces.items()}
    other = _pressed(replace(mesh, nodes=nodes, elements=elements, surfaces=surfaces))
    found = np.empty(len(mesh.nodes))
    found[other.problem.recovery.points] = von_mises(other.stress)
    found = found[place[mesh.surface_nodes]]
    return float(np.abs(found - _ring_stress()).max() / _ring_stress().max())
