"""Twenty columns, frames and levers against closed forms and CalculiX: docs/validation.md.

Frames of members (fem/frame.py) have what textbooks solve in closed form. A member of length L
under the force F = E I k^2 whose far end is hinged takes the moment s(kL) E I/L for a turn of its
near end by 1,

    s(x) = x^2 / (1 - x cot x),

from y'' = M/EI - k^2 y; an unloaded beam takes 6 E I/b where its ends turn alike, 2 E I/b where
they turn against each other, 3 E I/b with a hinged far end. CalculiX solves the solids' own
eigenproblem on the same mesh, held alike, under loads that keep their direction.
"""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from bench.fixed_solid import fixed_solid
from fem.buckling import solid_buckling
from fem.deck import write_deck
from fem.frame import Frame, buckling_modes
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.bars import Sections
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, PrismaticTube, SlottedLever
from tests.fem.blocks import BAR, wrench
from tests.fem.buckled_frames import axial_stiffness
from tests.fem.calculix import needs_calculix, run_calculix
from tests.fem.test_frame_buckling import column, factors, slim
from tests.fem.test_frame_lateral import LENGTH as BLADE
from tests.fem.test_frame_lateral import angle_factors, bent, stiffness

STEEL = Elastic(210e3, 0.3, 7.85e-9)
LENGTH, INERTIA = 1000.0, 1e4
UNIT = STEEL.youngs_modulus * INERTIA / LENGTH**2  # N
PIECES = 12
TURN = 0.4  # rad: the frames stand askew, so that no member is along an axis


def planar(corners, bars, held):
    """Lowest force at which a plane frame of bars buckles, over `UNIT`.

    corners  (n, 2) mm
    bars     (start, end, share of the force, share of the inertia)
    held     corner -> which of x, y (askew as the frame) and the turn about z are held
    """
    spin = np.array([[np.cos(TURN), -np.sin(TURN)], [np.sin(TURN), np.cos(TURN)]])
    places, members, axial, inertia = [np.asarray(c, dtype=float) for c in corners], [], [], []
    for start, end, force, share in bars:
        inner = range(len(places), len(places) + PIECES - 1)
        line = [start, *inner, end]
        for k in range(1, PIECES):
            places.append(places[start] + (places[end] - places[start]) * k / PIECES)
        members += [(line[k], line[k + 1]) for k in range(PIECES)]
        axial += [-force] * PIECES
        inertia += [share * INERTIA] * PIECES
    nodes = np.column_stack([np.array(places) @ spin.T, np.zeros(len(places))])
    area, rigid = np.full((len(members), 1), 1e6), np.full((len(members), 1), 1e6)
    none = np.full((len(members), 1), np.inf)
    bending = np.array(inertia)[:, None]
    sections = Sections(area, rigid, bending, rigid, none, none)
    up = np.array([0.0, 1.0, 0.0])
    frame = Frame(nodes, np.array(members), up, sections, STEEL)
    rows = []
    for corner, which in held.items():
        for name in which:
            row = np.zeros(6 * len(nodes))
            if name == "turn":
                row[6 * corner + 5] = 1.0
            else:
                row[6 * corner : 6 * corner + 2] = spin[:, "xy".index(name)]
            rows.append(row)
    still = np.setdiff1d(
        np.arange(6 * len(nodes)), [6 * n + k for n in range(len(nodes)) for k in (0, 1, 5)]
    )
    rows += list(np.eye(6 * len(nodes))[still])
    free = np.linalg.qr(np.array(rows).T, mode="complete")[0][:, len(rows) :]
    stiff = free.T @ frame.dense_stiffness() @ free
    work = free.T @ axial_stiffness(frame, np.array(axial)) @ free
    return float(buckling_modes(stiff, work).factors[0]) / UNIT


def stiffness_of(x):
    return x**2 / (1 - x / np.tan(x))


def root(function, low, high):
    """x^2 at the root, x = kL."""
    return brentq(function, low, high, xtol=1e-13) ** 2


COLUMNS = {
    "hinged": ("hinged", "hinged", np.pi**2),
    "clamped and free": ("clamped", "free", np.pi**2 / 4),
    "clamped and hinged": ("clamped", "hinged", root(lambda x: np.tan(x) - x, 4.4, 4.6)),
    "clamped": ("clamped", "clamped", 4 * np.pi**2),
}


@pytest.mark.parametrize("name", list(COLUMNS))
def test_even_columns(name):
    start, end, exact = COLUMNS[name]
    assert_allclose(factors(column(16), start, end)[0] / UNIT, exact, rtol=5e-5)


def test_a_column_of_two_sections():
    """Half as stiff beyond the middle: tan(a) tan(a sqrt 2) = sqrt 2, a = k_1 L/2."""

    def tip(x):
        return slim(np.where(x < 500, INERTIA, INERTIA / 2))

    share = np.sqrt(2)
    exact = 4 * root(lambda a: np.tan(a) * np.tan(a * share) - share, 0.5, 0.9)
    assert_allclose(factors(column(16, tip), "clamped", "free")[0] / UNIT, exact, rtol=1e-5)


# corners: feet 0 and 1, heads 2 and 3; b = 1.5 h, the beam three times as stiff
PORTAL = [(0, 0), (1500, 0), (0, 1000), (1500, 1000)]
BARS = [(0, 2, 1.0, 1.0), (1, 3, 1.0, 1.0), (2, 3, 0.0, 3.0)]
BEAM = 3.0 / 1.5  # (E I/b of the beam) / (E I/h of a column)
FRAMES = {
    "portal on hinges sways": (
        (PORTAL, BARS, {0: "xy", 1: "xy"}),
        root(lambda x: x * np.tan(x) - 6 * BEAM, 0.1, 1.57),
    ),
    "portal on clamped feet sways": (
        (PORTAL, BARS, {0: ("x", "y", "turn"), 1: ("x", "y", "turn")}),
        root(lambda x: np.tan(x) / x + 1 / (6 * BEAM), 1.6, 3.14),
    ),
    "portal on hinges, held aside": (
        (PORTAL, BARS, {0: "xy", 1: "xy", 2: "x"}),
        root(lambda x: stiffness_of(x) + 2 * BEAM, 3.2, 4.4),
    ),
    "column under a beam with a hinged end": (
        (
            [(0, 0), (0, 1000), (1500, 1000)],
            [(0, 1, 1.0, 1.0), (1, 2, 0.0, 3.0)],
            {0: "xy", 2: "xy"},
        ),
        root(lambda x: stiffness_of(x) + 3 * BEAM, 3.2, 4.45),
    ),
    "column over two spans, 1 and 0.6": (
        (
            [(0, 0), (0, 1000), (0, 1600)],
            [(0, 1, 1.0, 1.0), (1, 2, 1.0, 1.0)],
            {0: "xy", 1: "x", 2: "x"},
        ),
        root(lambda x: stiffness_of(x) + stiffness_of(0.6 * x) / 0.6, 3.2, 4.4),
    ),
    "crank of a heavy and a light arm, clamped and free": (
        (
            [(0, 0), (0, 1000), (0, 1800)],
            [(0, 1, 1.0, 1.0), (1, 2, 1.0, 0.25)],
            {0: ("x", "y", "turn")},
        ),
        root(lambda x: np.tan(x) * np.tan(2 * 0.8 * x) - 2, 0.3, 0.98),
    ),
}


@pytest.mark.parametrize("name", list(FRAMES))
def test_plane_frames(name):
    given, exact = FRAMES[name]
    assert_allclose(planar(*given), exact, rtol=5e-5)


LATERAL = {
    "blade evenly bent (Prandtl)": (lambda n: bent(n, by_force=False) * BLADE, np.pi, 1e-4),
    "blade with a force at its end": (lambda n: bent(n, by_force=True) * BLADE**2, 4.013, 2e-4),
}


@pytest.mark.parametrize("name", list(LATERAL))
def test_levers_that_twist_aside(name):
    of, exact, error = LATERAL[name]
    coarse, fine = of(8), of(16)
    assert_allclose((fine + (fine - coarse) / 3) / stiffness(), exact, rtol=error)


def test_a_right_angle_of_blades():
    """Argyris' 622.2 N mm with J = b t^3/3; Saint-Venant's J is 1.26 % less."""
    coarse, fine = (np.array(angle_factors(pieces)) for pieces in (8, 16))
    exact = 622.2 * np.sqrt(1 - 0.63 * 0.6 / 30)
    assert_allclose(fine + (fine - coarse) / 3, exact, rtol=5e-4)


LEVER = SlottedLever(
    length=200, width=36, thickness=8, hole=10, slot_width=12, slot_from=70, slot_to=130
)
SOLIDS = {  # shape, fineness, forces along and across at the second interface, N
    "square tube, pushed": (PrismaticTube(length=120, width=13, wall=1.6), 0.3, -1e3, 0.0),
    "flat link, pushed": (PlateLink(length=160, width=20, thickness=8, hole=10), 0.3, -1e3, 0.0),
    "slim link, pushed and bent": (
        PlateLink(length=160, width=40, thickness=2, hole=10), 0.3, -50.0, 300.0,
    ),
    "slotted lever, bent": (LEVER, 0.5, 0.0, 1e3),
    "slotted lever, pushed and bent": (LEVER, 0.5, -1e3, 500.0),
    "toggle bar, pushed": (BAR, 0.5, -1e4, 0.0),
}  # fmt: skip


SLOW = ("slotted lever, pushed and bent", "toggle bar, pushed")


@needs_calculix
@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow if one in SLOW else ()) for one in SOLIDS]
)
def test_solids_beside_calculix(name, tmp_path):
    """Two lowest factors, held at the six displacements of the stress analysis; as it prints."""
    shape, fineness, along, across = SOLIDS[name]
    solutions = solve_unit_loads(mesh_shape(shape, fineness=fineness), STEEL)
    first, second = (loads.interface for loads in solutions.interfaces[:2])
    arm = float(second.centre[0] - first.centre[0])
    ends = {first.name: wrench(-along, -across, -across * arm), second.name: wrench(along, across)}
    others = {one.interface.name: wrench() for one in solutions.interfaces[2:]}
    reaches = {name: np.full(1, arm / 2) for name in others}
    state = solutions.coefficients(ends | others, np.zeros((1, 4)), reaches)[0][:, 0]
    moved = (solutions.displacement @ state)[:, None]
    stress = solutions.recovery.quadrature_stress(moved, slice(None))[..., 0]
    held = fixed_solid(solutions.mesh, STEEL, solutions.held)
    ours = [mode.factor for mode in solid_buckling(held, stress).modes]
    deck = tmp_path / "part.inp"
    write_deck(deck, solutions.mesh, STEEL, solutions.held, solutions.loads @ state, name)
    text = deck.read_text(encoding="ascii")
    text = text.replace("*STEP\n*STATIC\n", "*STEP\n*BUCKLE\n6, 1e-5\n")
    text = re.sub(r"\*NODE FILE\n.*?(?=\*END STEP)", "", text, flags=re.DOTALL)
    deck.write_text(text, encoding="ascii")
    _, printed = run_calculix(deck)
    table = printed.read_text(encoding="ascii").split("B U C K L I N G", 1)[1]
    theirs = [float(m[1]) for m in re.finditer(r"^\s+\d+\s+([-+.\dE]+)\s*$", table, re.M)]
    positive = sorted(factor for factor in theirs if factor > 0)
    assert_allclose(ours, positive[: len(ours)], rtol=2e-6)
