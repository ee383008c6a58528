"""Unit loads, their superposition over a cycle, and the support that must carry nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from fem.assembly import Elements
from fem.recovery import von_mises
from fem.solvers import factorize
from fem.unit_loads import (
    bearing_coefficients,
    direct_bearing,
    half_cosine_harmonic,
    interface_loads,
    resultants,
)
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import MeshError
from geometry.meshing import mesh_shape

from .blocks import BAR, PIN, TUBE, block, wrench
from .direct_stress import direct_stress

STEEL = Elastic(210e3, 0.3, 7.85e-9)
N_POSITIONS = 10


@pytest.fixture(scope="module")
def bar():
    return solve_unit_loads(mesh_shape(BAR, fineness=0.5), STEEL)


@pytest.fixture(scope="module")
def pin():
    return solve_unit_loads(mesh_shape(PIN, fineness=0.5), STEEL)


@pytest.fixture(scope="module")
def tube():
    return solve_unit_loads(mesh_shape(TUBE, fineness=0.3), STEEL)


def cycle(mass_properties):
    """Wrenches and accelerations at ten positions, in equilibrium for these mass properties.

    The motion and the pin force at the knee are drawn at random; the end's force and couple follow
    from Newton and Euler.
    """
    random = np.random.default_rng(3)
    a = random.uniform(-1, 1, (N_POSITIONS, 4)) * [2e5, 2e5, 1e3, 2e3]
    a[:, 3] = np.abs(a[:, 3])
    knee, end = np.zeros((N_POSITIONS, 6)), np.zeros((N_POSITIONS, 6))
    knee[:, :2] = random.uniform(-2e4, 2e4, (N_POSITIONS, 2))
    knee[:, 5] = random.uniform(-1e4, 1e4, N_POSITIONS)
    m, (cx, cy, _) = mass_properties.mass, mass_properties.centre
    force_x = m * (a[:, 0] - a[:, 2] * cy - a[:, 3] * cx)
    force_y = m * (a[:, 1] + a[:, 2] * cx - a[:, 3] * cy)
    end[:, 0], end[:, 1] = force_x - knee[:, 0], force_y - knee[:, 1]
    about_origin = mass_properties.inertia * a[:, 2] + cx * force_y - cy * force_x
    end[:, 5] = about_origin - knee[:, 5] - BAR.length * end[:, 1]
    return {"knee": knee, "end": end}, a


@pytest.mark.parametrize("n", range(9))
def test_bearing_harmonics_are_the_fourier_coefficients_of_a_half_cosine(n):
    """Against numerical quadrature of max(0, cos t) cos(n t), good to 1e-12."""
    integral, _ = quad(lambda t: np.cos(t) * np.cos(n * t), -np.pi / 2, np.pi / 2, epsabs=1e-13)
    expected = integral / np.pi if n else integral / (2 * np.pi)
    assert_allclose(half_cosine_harmonic(n), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("arc", [82.0, 90.0, 135.0])
def test_harmonics_of_an_arc_make_its_cosine_of_pressure(arc):
    """Against p0 cos(pi t / arc) with a resultant of 1 N, every 5 degrees, to 4 % of the peak.

    p0 is 1 over the integral of cos(pi t / arc) cos t; the columns are times pi.
    """
    wide, push = np.radians(arc), 0.7
    integral, _ = quad(lambda t: np.cos(np.pi * t / wide) * np.cos(t), -wide / 2, wide / 2)
    column = bearing_coefficients([[np.cos(push), np.sin(push), 0.0]], False, wide)[0]
    away = np.radians(np.arange(-180.0, 180.0, 5.0))
    waves = [np.ones(len(away))]
    for n in range(1, 17):
        waves += [np.cos(n * (away + push)), np.sin(n * (away + push))]
    found = column[:-1] @ waves / np.pi
    true = np.where(np.abs(away) < wide / 2, np.cos(np.pi * away / wide), 0.0) / integral
    assert_allclose(found, true, rtol=0, atol=0.04 / integral)
    assert_allclose(column[1:3], [np.cos(push), np.sin(push)], rtol=1e-12)


@pytest.mark.parametrize("inward", [False, True])
def test_a_bearing_pressure_presses_where_the_pin_is(inward):
    """The series at ten directions: largest towards the force on a bore, away from it on a pin."""
    for angle in np.linspace(-3, 3, 10):
        column = bearing_coefficients([[np.cos(angle), np.sin(angle), 5.0]], inward)[0]
        theta = angle + (np.pi if inward else 0.0)
        waves = [1.0] + [f(n * theta) for n in (1, 2, 4) for f in (np.cos, np.sin)]
        # the sum at the most loaded point: 2 (1/pi + 1/2 + 2/(3 pi) - 2/(15 pi))
        assert_allclose(column[:7] @ waves, 1 + 2 / np.pi * (1 + 2 / 3 - 2 / 15), rtol=1e-12)
        assert column[7] == 5.0


@pytest.mark.parametrize("name", ["bar", "pin", "tube"])
def test_every_unit_load_has_the_resultant_it_claims(name, request):
    """The harmonics of order 1 have 1 N, the couple 1 N mm, all others nothing: 1e-9."""
    solutions = request.getfixturevalue(name)
    for unit in solutions.interfaces:
        centre, kind = unit.interface.centre, unit.interface.kind
        got = resultants(solutions.elements, unit.vectors, centre)
        expected = np.zeros_like(got)
        force = {"bore": 1.0, "journal": -1.0, "face": 1.0}[kind]
        axes = {"cos 1": 0, "sin 1": 1, "couple": 5, "F_x": 0, "F_y": 1, "M_z": 5}
        for column, wave in enumerate(unit.names):
            if wave in axes:
                expected[axes[wave], column] = 1.0 if axes[wave] == 5 else force
        reach = unit.interface.radius or TUBE.width
        assert_allclose(got[:3], expected[:3], rtol=0, atol=1e-9)
        assert_allclose(got[3:] / reach, expected[3:] / reach, rtol=0, atol=1e-9)


def test_what_a_faceted_bore_does_to_its_loads_is_measured(bar, tube):
    """Quadratic facets miss the circle by some 1e-6; plane end faces miss nothing but round-off."""
    assert 1e-9 < bar.raw_deviation < 1e-4
    assert tube.raw_deviation < 1e-13


def test_a_bore_whose_loads_are_a_per_cent_off_is_refused(bar):
    """A stated length 1 % above the bore's: the pressure's resultant is 1 % short."""
    knee = bar.mesh.interfaces["knee"]
    with pytest.raises(MeshError, match=r"'knee' miss their resultant by 9\.9e-03 .*limit 1e-03"):
        interface_loads(bar.elements, replace(knee, length=1.01 * knee.length))


def test_a_pin_that_is_meshed_far_too_coarsely_is_refused():
    """Loads that miss, or already the volume: nothing is computed on it."""
    with pytest.raises(MeshError, match=r"limit 1e-0?3"):
        solve_unit_loads(mesh_shape(PIN, fineness=0.12), STEEL)


def test_superposition_is_the_direct_solution_of_the_same_harmonics(bar):
    """Ten positions, each loaded anew by integrating the truncated series over the bores.

    Left over: the correction of the unit loads' resultants (raw_deviation, 2e-6 of the force),
    which one coarse element may feel twenty times.
    """
    wrenches, accelerations = cycle(bar.mesh.mass_properties(STEEL.density))
    coefficients, _ = bar.coefficients(wrenches, accelerations)
    inertia = bar.loads[:, -4:] @ coefficients[-4:]
    for k in range(N_POSITIONS):
        load = inertia[:, k].copy()
        for unit in bar.interfaces:
            surface = bar.elements.surface(unit.interface.name)
            arm = surface.points - unit.interface.centre
            radius, length = unit.interface.radius, unit.interface.length
            fx, fy, couple = wrenches[unit.interface.name][k, [0, 1, 5]]
            size, towards = np.hypot(fx, fy), np.arctan2(fy, fx)
            angle = np.arctan2(arm[..., 1], arm[..., 0])
            t = angle - towards
            series = (
                1 / np.pi
                + np.cos(t) / 2
                + 2 / (3 * np.pi) * np.cos(2 * t)
                - 2 / (15 * np.pi) * np.cos(4 * t)
            )
            pressure = 2 * size / (np.pi * radius * length) * series
            shear = couple / (2 * np.pi * radius**2 * length)
            c, s = np.cos(angle), np.sin(angle)
            traction = np.stack([pressure * c - shear * s, pressure * s + shear * c, 0 * t], -1)
            nodal = np.einsum("aq,fqx,fq->fax", surface.shape, traction, surface.weights)
            np.add.at(load.reshape(-1, 3), surface.nodes, nodal)
        direct = bar.recovery.surface_stress(bar.solve(load[:, None]))[:, :, 0]
        superposed = bar.basis @ coefficients[:, k]
        tolerance = 20 * bar.raw_deviation * np.abs(direct).max()
        assert_allclose(superposed, direct, rtol=0, atol=tolerance)


def test_superposition_is_the_solution_of_its_own_load_vector_to_round_off(bar):
    """cond(K) eps, with one step of refinement: 1e-8 of the largest."""
    wrenches, accelerations = cycle(bar.mesh.mass_properties(STEEL.density))
    coefficients, _ = bar.coefficients(wrenches, accelerations)
    direct = bar.recovery.surface_stress(bar.solve(bar.loads @ coefficients))
    superposed = bar.basis @ coefficients
    assert_allclose(superposed, direct, rtol=0, atol=1e-8 * np.abs(direct).max())


def test_the_series_up_to_four_gives_the_peak_of_a_half_cosine_within_0_4_per_cent(bar):
    """Its stated truncation, at pulls and thrusts of a two-force link in its worst direction."""
    for sign in (1.0, -1.0):
        wrenches = {"knee": wrench(sign * 2e4), "end": wrench(-sign * 2e4)}
        coefficients, _ = bar.coefficients(wrenches, np.zeros((1, 4)))
        superposed = von_mises(bar.basis @ coefficients[:, 0]).max()
        row = {name: value[0] for name, value in wrenches.items()}
        direct = von_mises(direct_stress(bar, row, coefficients[:, 0], [np.pi])[..., 0]).max()
        assert abs(superposed / direct - 1) < 0.004


@pytest.mark.parametrize("arc", [np.pi, np.radians(120)])
@pytest.mark.parametrize("name", ["bar", "pin"])
def test_a_direct_pressure_has_the_force_and_couple_asked_for(name, arc, request):
    solutions = request.getfixturevalue(name)
    unit = solutions.interfaces[0]
    force = np.array([300.0, -400.0, 700.0])
    load = direct_bearing(solutions.elements, unit, force, arc)
    got = resultants(solutions.elements, load[:, None], unit.interface.centre)[[0, 1, 5], 0]
    assert_allclose(got, force, rtol=0, atol=1e-8 * 500)


def test_a_direct_pressure_without_a_force_is_its_couple_alone(pin):
    unit = next(unit for unit in pin.interfaces if unit.interface.name == "eye")
    load = direct_bearing(pin.elements, unit, np.array([0.0, 0.0, 50.0]))
    got = resultants(pin.elements, load[:, None], unit.interface.centre)[[0, 1, 5], 0]
    assert_allclose(got, [0, 0, 50], atol=1e-8)


def test_loads_in_equilibrium_need_no_support(bar):
    """Reactions over the largest force; K's condition leaves 1e-8."""
    wrenches, accelerations = cycle(bar.mesh.mass_properties(STEEL.density))
    coefficients, added = bar.coefficients(wrenches, accelerations)
    assert np.abs(bar.reactions(coefficients)).max() < 1e-8 * 2e4
    # the mesh is not quite symmetric about z = 0: inertia has a moment out of the plane, 3e-9
    assert np.abs(bar.unit_resultants @ coefficients).max() < 1e-8 * 2e4 * BAR.length
    # the mesh's own mass properties: the residual field is what round-off leaves of 2e4 N
    assert np.abs(added[:, :2]).max() < 1e-4 * 2e5


def test_loads_out_of_equilibrium_lean_on_the_support(bar):
    """1000 N with nothing against it: the three-way sum of the reactions is -1000 N."""
    coefficients = np.zeros((bar.loads.shape[1], 1))
    unit = bar.interfaces[0]
    coefficients[: len(unit.names), 0] = bearing_coefficients([[1000.0, 0.0, 0.0]], False)[0]
    reactions = bar.reactions(coefficients)[:, 0]
    along_x = reactions[bar.held % 3 == 0].sum()
    assert_allclose(along_x, -1000.0, rtol=1e-7)


def test_foreign_mass_properties_are_balanced_by_the_field_that_is_reported(bar):
    """Loads of a bar twice as heavy, pulled along x: m a_x more force than the mesh's inertia
    takes, so the mesh is given another a_x.
    """
    properties = bar.mesh.mass_properties(STEEL.density)
    force = 2 * properties.mass * 1e5
    given = np.array([[1e5, 0.0, 0.0, 0.0]])
    wrenches = {"knee": wrench(force), "end": wrench()}
    coefficients, added = bar.coefficients(wrenches, given)
    # the centre is some 1e-4 mm off the axis, hence the looser comparison of the turn
    assert_allclose(added[0, 0], 1e5, rtol=1e-4)
    assert_allclose(added[0, 1], 0, atol=1e-2 * 1e5)
    assert_allclose(coefficients[-4:, 0], [*(given[0, :3] + added[0]), 0.0])
    # inertia alone, whose moment out of the plane (asymmetric mesh) is 3e-7 of it
    assert np.abs(bar.reactions(coefficients)).max() < 1e-6 * force


@pytest.mark.parametrize("component", [2, 3, 4])
def test_a_wrench_out_of_the_plane_is_refused(bar, component):
    out = wrench(1000.0)
    out[0, component] = 1.0
    with pytest.raises(ValueError, match="'knee' carries forces along z or moments about x or y"):
        bar.coefficients({"knee": out, "end": wrench(-1000.0)}, np.zeros((1, 4)))


def test_the_choice_of_support_does_not_change_the_stress():
    """Two determinate holds: only the rigid motion differs."""
    first = solve_unit_loads(block((4, 2, 2), (20.0, 5.0, 4.0), distortion=0.2), STEEL)
    nodes = first.mesh.nodes
    a, b, c = (
        int(np.argmin(np.linalg.norm(nodes - p, axis=1)))
        for p in ([0, 0, 0], [20, 0, 0], [0, 5, 4])
    )
    held = np.sort([3 * a, 3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2, 3 * c + 1])
    assert not np.array_equal(held, first.held)
    free = np.setdiff1d(np.arange(len(first.loads)), held)
    factor = factorize(first.stiffness[free][:, free].tocsr())
    displacement = np.zeros_like(first.displacement)
    displacement[free] = factor.solve(first.loads[free])[0]
    second = replace(first, held=held, factor=factor, displacement=displacement)
    wrenches = {"start": wrench(30.0, 500.0, 100.0), "end": wrench(70.0, -400.0, 900.0)}
    coefficients, _ = first.coefficients(wrenches, np.array([[1e3, 2e3, 50.0, 400.0]]))
    assert np.abs(second.reactions(coefficients)).max() < 1e-8 * 500
    one, other = first.basis @ coefficients, second.basis @ coefficients
    assert_allclose(one, other, rtol=0, atol=1e-8 * np.abs(one).max())


def test_double_the_load_is_double_the_stress(bar):
    wrenches, accelerations = cycle(bar.mesh.mass_properties(STEEL.density))
    once, _ = bar.coefficients(wrenches, accelerations)
    twice, _ = bar.coefficients({k: 2 * w for k, w in wrenches.items()}, 2 * accelerations)
    assert_allclose(twice, 2 * once, rtol=1e-9, atol=1e-6)


def test_bending_of_a_tube_by_end_couples_is_navier():
    """sigma = -M y / I away from nothing at all: the unit couple is Navier's own distribution.

    M acts on the end x = L, its opposite on x = 0: constant moment. Round-off, 1e-8.
    """
    mesh = block((3, 2, 2), (20.0, 6.0, 4.0), start=(0.0, -3.0, -2.0))
    solutions = solve_unit_loads(mesh, STEEL)
    coefficients, _ = solutions.coefficients(
        {"start": wrench(mz=-900.0), "end": wrench(mz=900.0)}, np.zeros((1, 4))
    )
    stress = solutions.basis @ coefficients[:, 0]
    y = mesh.nodes[solutions.recovery.points, 1]
    exact = np.zeros_like(stress)
    exact[:, 0] = -900.0 * y / (4 * 6**3 / 12)
    assert_allclose(stress, exact, rtol=0, atol=1e-8 * np.abs(exact).max())


def test_a_surface_is_integrated_over_its_own_area(bar):
    """Both cheeks of the knee's bore, pi d 2 t; the facets' shape functions add up to 1."""
    surface = Elements(bar.mesh).surface("knee")
    assert_allclose(surface.weights.sum(), np.pi * BAR.hole * 2 * BAR.wall, rtol=1e-4)
    assert_allclose(surface.shape.sum(axis=0), 1.0, rtol=1e-13)


def test_loads_on_a_thin_uneven_end_face_meet_all_six_resultants():
    """12 x 1.5 mm tube: the weights of its mesh lie beside the middle, a plain shear twists it."""
    from geometry.parts import PrismaticTube

    tube = PrismaticTube(length=150.0, width=12.0, wall=1.5, inner_radius=0.5)
    elements = Elements(mesh_shape(tube, fineness=0.7))
    for interface in elements.mesh.interfaces.values():
        loads = interface_loads(elements, interface)
        got = resultants(elements, loads.vectors, interface.centre)
        wanted = np.zeros((6, 3))
        wanted[[0, 1, 5], [0, 1, 2]] = 1.0
        assert_allclose(got, wanted, atol=1e-9)
