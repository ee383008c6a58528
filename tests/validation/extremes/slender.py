"""Bars from stocky to a thousand times as long as high: frames and solids against beam theory."""

from typing import NamedTuple

import numpy as np

from fem.recovery import von_mises
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.bars import rectangle

from ...boundary_value import SolidProblem, traction_load, unknowns
from ...fem.blocks import block, wrench
from ...fem.solved_frames import Frame

RATIOS = (1, 3, 10, 30, 100, 300, 1000)
E = 210e3
HEIGHT = 10.0
FORCE, COUPLE = 100.0, 1e5


class Frames(NamedTuple):
    """Tip deflection of a frame over Timoshenko's, less 1, and its residual."""

    error: float
    residual: float


class Bent(NamedTuple):
    """A solid bar under two couples, by the unit loads of a check.

    stress    largest error of the von Mises stress at the surface over its largest value
    turn      error of the angle between the ends over the angle
    reaction  largest support reaction over couple / height
    gate      largest support reaction over the force of a clamped bar under one across its tip
    residual  backward error of the solve
    """

    stress: float
    turn: float
    reaction: float
    gate: float
    residual: float


class Cantilever(NamedTuple):
    """A solid cantilever: tip deflection over the exact one, less 1; longest side of a brick.

    balance  force of the supports and the load over the largest nodal force of the supports
    """

    error: float
    aspect: float
    balance: float


def timoshenko(ratio):
    """Tip deflection of a square cantilever with nu = 0 under FORCE, mm."""
    length, area = ratio * HEIGHT, HEIGHT**2
    bending = FORCE * length**3 / (3 * E * HEIGHT**4 / 12)
    return bending + FORCE * length / (5 / 6 * E / 2 * area)


def framed(ratio, members=7):
    """The cantilever of frame members: exact for any length, so that round-off is left."""
    x = np.linspace(0, ratio * HEIGHT, members + 1)
    nodes = np.stack([x, 0 * x, 0 * x], axis=1)
    ends = np.stack([np.arange(members), np.arange(1, members + 1)], axis=1)
    square = rectangle(HEIGHT, HEIGHT)
    frame = Frame(nodes, ends, np.array([0, 1.0, 0]), square, Elastic(E, 0.0, 0.0))
    solution = frame.held(np.arange(6)).solve(frame.nodal(members, [0, FORCE, 0, 0, 0, 0]))
    tip = float(solution.displacement[6 * members + 1, 0])
    return Frames(tip / timoshenko(ratio) - 1, float(solution.residual))


def bent(ratio):
    """The bar under two couples: a quadratic field, which the elements hold, so round-off is left.

    Stress M y / I, angle M L / (E I).
    """
    length = ratio * HEIGHT
    mesh = block((max(2, ratio // 20), 2, 2), (length, HEIGHT, HEIGHT), start=(0, -5, -5))
    solved = solve_unit_loads(mesh, Elastic(E, 0.3, 7.85e-9))
    coefficients, _ = solved.coefficients(
        {"start": wrench(mz=-COUPLE), "end": wrench(mz=COUPLE)}, np.zeros((1, 4))
    )
    across, _ = solved.coefficients(
        {"start": wrench(fy=-FORCE, mz=-FORCE * length), "end": wrench(fy=FORCE)}, np.zeros((1, 4))
    )
    inertia = HEIGHT**4 / 12
    y = mesh.nodes[solved.recovery.points, 1]
    found = von_mises(solved.basis @ coefficients[:, 0])
    exact = COUPLE * np.abs(y) / inertia
    u = (solved.displacement @ coefficients[:, 0]).reshape(-1, 3)
    turns = [_turn(mesh, u, x) for x in (0.0, length)]
    return Bent(
        float(np.abs(found - exact).max() / exact.max()),
        float((turns[1] - turns[0]) / (COUPLE * length / (E * inertia)) - 1),
        float(np.abs(solved.reactions(coefficients)).max() / (COUPLE / HEIGHT)),
        float(np.abs(solved.reactions(across)).max() / FORCE),
        solved.residual,
    )


def _turn(mesh, displacement, x):
    """Mean slope -du_x/dy of the section at x."""
    on = np.isclose(mesh.nodes[:, 0], x, rtol=0, atol=1e-6)
    return -np.polyfit(mesh.nodes[on, 1], displacement[on, 0], 1)[0]


def cantilever(ratio, count):
    """A solid bar with nu = 0 under a tip force: `count` by 2 by 2 bricks, six elements each.

    Both ends carry what the exact field asks for (Timoshenko and Goodier, Theory of Elasticity,
    section 21, with nu = 0), so that no length is too short for it:
    u_x = -F/(E I) (L x - x^2/2) y - F/(6 I G) y^3,
    u_y = F/(E I) (L x^2/2 - x^3/6) + F c^2 x/(2 I G)
    """
    length, c, inertia, shear = ratio * HEIGHT, HEIGHT / 2, HEIGHT**4 / 12, E / 2
    mesh = block((count, 2, 2), (length, HEIGHT, HEIGHT), start=(0, -5, -5))
    clamped = np.flatnonzero(mesh.nodes[:, 0] < 1e-9)
    held = unknowns(clamped)
    given = np.zeros((len(clamped), 3))
    given[:, 0] = -FORCE / (6 * inertia * shear) * mesh.nodes[clamped, 1] ** 3

    def parabola(points, _):
        along = FORCE / (2 * inertia) * (c**2 - points[..., 1] ** 2)
        return along[..., None] * np.array([0.0, 1.0, 0.0])

    problem = SolidProblem(mesh, Elastic(E, 0.0, 0.0), held)
    load = traction_load(problem.elements, "end", parabola)
    solution = problem.solve(load, given.ravel())
    tip = float(solution.displacement_at((length, 0, 0))[1])
    exact = FORCE * length**3 / (3 * E * inertia) + FORCE * c**2 * length / (2 * inertia * shear)
    carried = solution.reactions.reshape(-1, 3).sum(axis=0)
    return Cantilever(
        tip / exact - 1,
        length / count / (HEIGHT / 2),
        float(np.abs(carried + np.array([0, FORCE, 0])).max() / np.abs(solution.reactions).max()),
    )
