"""Frequencies of solids against MD-01 to MD-04 (docs/validation.md)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bench.fixed_solid import fixed_solid, free_vibration
from fem.assembly import Elements
from fem.lowest_modes import solid_vibration
from fem.unit_solutions import Elastic, solve_unit_loads

from ...boundary_value import unknowns
from ...fem.blocks import block
from ..solids.meshes import mapped, on
from .solids import bar, clamped, guided, steel

NAFEMS = Elastic(200e3, 0.3, 8e-9)
THIN = 5.0  # mm, of 1000: shear and rotary inertia take 0.02 % off the third frequency


def beam(beta_length):
    """Frequencies of a square bar of 1000 mm in bending, Hz."""
    speed = np.sqrt(210e3 * THIN**2 / 12 / 7.85e-9)
    return (np.asarray(beta_length) / 1000) ** 2 * speed / (2 * np.pi)


def test_a_bar_along_its_axis_has_the_frequencies_of_a_rod():
    """MD-01: 0.01 % on mode 1, 0.1 % on mode 3; without Poisson's ratio and motion across."""
    mesh = bar((10, 1, 1), 1000.0, THIN, THIN)
    across = unknowns(np.arange(len(mesh.nodes)), "yz")
    solid = fixed_solid(mesh, steel(0.0), np.union1d(across, unknowns(on(mesh, "x0"))))
    found = solid_vibration(solid, count=3).hertz
    errors = found / [1293.0485, 3879.1456, 6465.2427] - 1
    assert (np.abs(errors) < [1e-5, 1e-4, 1e-3]).all()


@pytest.mark.parametrize(
    ("end", "beta_length"),
    [
        ((), (1.8751041, 4.6940911, 7.8547574)),
        (("y", "z"), (3.9266023, 7.0685827)),
    ],
)
def test_a_slender_bar_has_the_frequencies_of_a_beam_in_pairs(end, beta_length):
    """MD-01, clamped-free and clamped-pinned: 0.01 % on mode 1, 0.1 % on mode 3."""
    errors = []
    for bricks in (40, 80):
        mesh = bar((bricks, 1, 1), 1000.0, THIN, (-THIN / 2, THIN / 2))
        rows = guided(mesh, Elements(mesh), "x1", end) if end else None
        found = solid_vibration(clamped(mesh, steel(0.0), rows), count=2 * len(beta_length))
        errors.append(np.abs(found.hertz / beam(np.repeat(beta_length, 2)) - 1))
    assert (errors[1] < 1e-3).all()
    assert (errors[1] < errors[0] / 2).all()


def test_a_floating_bar_has_the_frequencies_of_a_free_beam_and_no_rigid_ones():
    """MD-01 and MD-04: the six rigid motions are left out, not listed as zeros."""
    solutions = solve_unit_loads(block((60, 1, 1), (1000.0, THIN, THIN)), steel(0.0))
    found = free_vibration(solutions, count=6)
    assert_allclose(found.hertz, beam(np.repeat([4.7300407, 7.8532046, 10.995608], 2)), rtol=2e-3)
    assert found.angular[-1] < found.proven


def test_the_tapered_membrane_of_nafems_has_its_frequencies():
    """MD-02 (FV32): 0.1 %; a slice of half the thickness whose middle plane stays plane."""
    reference = [44.617, 130.0095, 162.6887, 245.986, 379.717, 391.4042]

    def trapezium(x, y, z):
        return 1e4 * x, (5e3 - 4e3 * x) * (y - 0.5), 25.0 * z

    errors = []
    for counts in ((8, 4, 1), (16, 8, 1)):
        mesh = mapped(counts, trapezium, 1e4 * 3e3 * 25)
        held = np.union1d(unknowns(on(mesh, "x0"), "xy"), unknowns(on(mesh, "z0"), "z"))
        found = solid_vibration(fixed_solid(mesh, NAFEMS, held), count=6)
        errors.append(np.abs(found.hertz / reference - 1))
    assert (errors[1] < 1e-3).all()
    assert (errors[1] < errors[0] / 2).all()


@pytest.mark.slow
def test_the_thick_plate_of_nafems_has_the_frequencies_of_exact_elasticity():
    """MD-03 (N): 0.1 % for nine modes, with three pairs of equal ones among them."""
    reference = [45.971212, 109.85686, 109.85686, 155.04342, 155.04342]
    reference += [168.81929, 205.86461, 205.86461, 219.26451]
    errors = []
    for counts in ((10, 10, 2), (24, 24, 3)):
        mesh = bar(counts, 1e4, 1e4, 1e3)
        sides = (unknowns(on(mesh, "x0", "x1"), "yz"), unknowns(on(mesh, "y0", "y1"), "xz"))
        found = solid_vibration(fixed_solid(mesh, NAFEMS, np.union1d(*sides)), count=9)
        errors.append(np.abs(found.hertz / reference - 1))
    assert (errors[1] < 1e-3).all()
    assert (errors[1] < errors[0] / 3).all()


@pytest.mark.slow
def test_the_thick_plate_held_across_at_its_sides_alone_is_softer():
    """MD-03 (F), first mode 44.178 Hz +- 0.02: 0.2 %, on a quarter."""
    errors = []
    for counts in ((6, 6, 2), (12, 12, 3)):
        mesh = bar(counts, 5e3, 5e3, 1e3)
        held = [unknowns(on(mesh, f"{axis}0"), axis) for axis in "xy"]
        held.append(unknowns(on(mesh, "x1", "y1"), "z"))
        solid = fixed_solid(mesh, NAFEMS, np.unique(np.concatenate(held)))
        errors.append(abs(solid_vibration(solid, count=1).hertz[0] / 44.178 - 1))
    assert errors[1] < 1e-3
    assert errors[1] < errors[0] / 3
