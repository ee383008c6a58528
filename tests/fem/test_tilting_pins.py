"""Couples about x and y on plates that are mounted side by side, and clamps that hold them."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.assembly import Elements
from fem.unit_loads import interface_loads, resultants
from fem.unit_solutions import Elastic, has_bearings, solve_unit_loads
from geometry.mesh import Interface, MeshError
from geometry.meshing import mesh_shape
from geometry.parts.plate_link import PlateLink

from .blocks import PIN, block, wrench
from .direct_stress import direct_stress
from .stacks import clamped, patch

STEEL = Elastic(210e3, 0.3, 7.85e-9)
LINK = PlateLink(length=150.0, width=20.0, thickness=10.0, hole=10.0)


@pytest.fixture(scope="module")
def link():
    return solve_unit_loads(mesh_shape(LINK, fineness=0.6), STEEL)


def loaded(moment_x=0.0, moment_y=0.0, force=0.0):
    """Wrenches of one position: couples on the second hole, their opposite on the first."""
    second = wrench(fx=force)
    second[0, 3:5] = moment_x, moment_y
    return {"first": -second, "second": second}


def solved(link, wrenches):
    return link.coefficients(wrenches, np.zeros((1, 4)))[0]


def wanted(unit):
    """Resultants (6, n) that the columns of a bore, journal or clamp claim."""
    axes = {"cos 1": 0, "sin 1": 1, "couple": 5, "M_x": 3, "M_y": 4, "F_x": 0, "F_y": 1, "M_z": 5}
    sign = -1.0 if unit.interface.kind == "journal" else 1.0
    expected = np.zeros((6, len(unit.names)))
    for column, name in enumerate(unit.names):
        if name in axes:
            expected[axes[name], column] = sign if "1" in name else 1.0
    return expected


@pytest.mark.parametrize("kind", ["bore", "journal"])
def test_tilting_pins_have_couples_of_1_n_mm_about_x_and_y_and_no_force(link, kind):
    """Bores of a plate, journals of a pin (one lug pair and the eye between): 1e-12."""
    if kind == "bore":
        elements, interfaces = link.elements, link.mesh.interfaces.values()
    else:
        elements = Elements(mesh_shape(PIN, fineness=0.5))
        interfaces = [replace(i, tilts=True) for i in elements.mesh.interfaces.values()]
    for interface in interfaces:
        unit = interface_loads(elements, interface)
        assert unit.interface.kind == kind
        assert unit.names[-2:] == ("M_x", "M_y")
        got = resultants(elements, unit.vectors, interface.centre)
        scale = np.r_[np.ones(3), np.full(3, 1 / interface.radius)][:, None]
        assert_allclose(got * scale, wanted(unit) * scale, rtol=0, atol=1e-12)
        assert unit.raw_deviation < 1e-3


def test_a_tilting_pin_presses_outwards_more_the_farther_from_the_middle(link):
    """M_y pushes to +x above z = 0 and to -x below: the sum of |F_x| z over z^2 is even."""
    unit = link.interfaces[1]
    force = unit.vectors[:, unit.names.index("M_y")].reshape(-1, 3)
    z = link.mesh.nodes[:, 2]
    assert force[z > 1, 0].sum() > 0
    assert_allclose(force[z > 0.1, 0].sum(), -force[z < -0.1, 0].sum(), rtol=0.05)
    assert_allclose(force[:, 0] @ z, 1.0, rtol=1e-9)
    # linear pressure on z = -5..5: 1.5 M / t on either side, less what the nodes at 0 take
    assert 0.12 < force[z > 0.1, 0].sum() <= 0.151


def test_a_couple_about_y_bends_the_plate_out_of_its_plane(link):
    """M z / I_y at the middle of the link, Navier within 1 %; nothing about z."""
    stress = (link.basis @ solved(link, loaded(moment_y=4000.0)))[:, :, 0]
    at = link.mesh.nodes[link.recovery.points]
    near = np.abs(at[:, 0] - 75) < 12
    exact = 4000.0 * at[near, 2] / (LINK.width * LINK.thickness**3 / 12)
    assert near.sum() > 30
    assert_allclose(stress[near, 0], exact, rtol=0, atol=0.01 * np.abs(exact).max())


def test_a_couple_about_x_twists_the_plate(link):
    """Largest shear M / (c1 b t^2), c1 = 0.246 for b / t = 2 (Timoshenko and Goodier, 3rd ed.,
    section 109), at the middle of the wide side; the recovery's linear continuation leaves 5 %.
    """
    stress = (link.basis @ solved(link, loaded(moment_x=4000.0)))[:, :, 0]
    at = link.mesh.nodes[link.recovery.points]
    here = (np.abs(at[:, 0] - 75) < 15) & (np.abs(at[:, 1]) < 1.5) & (at[:, 2] > 4.9)
    assert here.any()
    expected = -4000.0 / (0.246 * LINK.width * LINK.thickness**2)
    assert_allclose(stress[here, 3].mean(), expected, rtol=0.05)


def test_balanced_couples_need_no_support(link):
    coefficients = solved(link, loaded(moment_x=300.0, moment_y=-4000.0, force=500.0))
    assert np.abs(link.reactions(coefficients)).max() < 1e-7 * 500


@pytest.mark.parametrize(
    ("component", "words"),
    [
        (3, r"a couple about x of 50 N mm at position 2 of 2; the part moves in its plane only"),
        (4, r"a couple about y of 50 N mm at position 2 of 2"),
    ],
)
def test_couples_out_of_the_plane_that_nothing_balances_are_refused(link, component, words):
    one = loaded(force=500.0)
    wrenches = {name: np.concatenate([load, load]) for name, load in one.items()}
    wrenches["second"][1, component] = 50.0
    with pytest.raises(ValueError, match=words):
        link.coefficients(wrenches, np.zeros((2, 4)))


def test_forces_at_two_levels_are_refused_without_the_couple_between_them():
    """A pin pulled at z = 0 and held at z = 12: 500 N times 12 mm about y are missing."""
    pin = mesh_shape(PIN, fineness=0.5)
    interfaces = {name: replace(i, tilts=True) for name, i in pin.interfaces.items()}
    lug = pin.surfaces["lug"]
    one = lug[pin.nodes[lug][..., 2].mean(axis=1) > 0]
    height = pin.nodes[one][..., 2]
    middle = (height.min() + height.max()) / 2
    interfaces["lug"] = replace(
        interfaces["lug"], centre=np.array([0, 0, middle]), length=float(np.ptp(height))
    )
    single = solve_unit_loads(
        replace(pin, surfaces={**pin.surfaces, "lug": one}, interfaces=interfaces), STEEL
    )
    assert_allclose(middle, 20.0, atol=1e-6)
    pull = wrench(fx=500.0)
    with pytest.raises(ValueError, match=r"a couple about y of -1e\+04 N mm at position 1 of 1"):
        single.coefficients({"lug": -pull, "eye": pull}, np.zeros((1, 4)))
    held = -pull
    held[0, 4] = 500.0 * middle
    coefficients, _ = single.coefficients({"lug": held, "eye": pull}, np.zeros((1, 4)))
    assert np.abs(single.reactions(coefficients)).max() < 1e-6 * 500
    total = single.unit_resultants @ coefficients
    assert np.abs(total[:3]).max() < 1e-9 * 500
    assert np.abs(total[3:]).max() < 1e-9 * 500 * 20


def test_a_force_along_z_is_refused_of_a_tilting_pin_too(link):
    out = loaded(force=100.0)
    out["second"][0, 2] = 1.0
    with pytest.raises(ValueError, match="'second' carries forces along z up to 1"):
        solved(link, out)


def test_direct_pressures_keep_the_couples_of_tilting_pins(link):
    """Without a force the direct solution is the couples' own; with one the series' within 1 %."""
    assert has_bearings(link)
    for force, tolerance in ((0.0, 1e-9), (2000.0, 0.01)):
        wrenches = loaded(moment_y=4000.0, force=force)
        coefficients = solved(link, wrenches)[:, 0]
        row = {name: value[0] for name, value in wrenches.items()}
        direct = direct_stress(link, row, coefficients, [np.pi])[..., 0]
        series = link.basis @ coefficients
        at = np.abs(link.mesh.nodes[link.recovery.points][:, 0] - 75) < 40
        assert_allclose(direct[at], series[at], rtol=0, atol=tolerance * np.abs(series).max())
        assert np.abs(series[at]).max() > 10


def clamped_block():
    """A block held by a clamp about x = 30 and pushed at its end faces."""
    mesh = block((12, 2, 2), (60.0, 6.0, 4.0), start=(0.0, -3.0, -2.0))
    return clamped(mesh, "clamp", 30.0, 10.0)


def test_a_clamp_has_the_resultants_it_claims():
    """1e-12; on plane faces nothing had to be corrected."""
    elements = Elements(clamped_block())
    unit = interface_loads(elements, elements.mesh.interfaces["clamp"])
    assert unit.names == ("F_x", "F_y", "M_z")
    got = resultants(elements, unit.vectors, unit.interface.centre)
    assert_allclose(got, wanted(unit), rtol=0, atol=1e-12)
    assert unit.raw_deviation < 1e-13


def test_an_uneven_clamp_is_corrected_to_its_resultants_or_refused():
    """Half of one facet missing on one side is 1/16 of a side: refused. A centre 5e-5 of the
    clamp's length aside is put right: 12 e/l of the couple's own share of force, 6e-4.
    """
    mesh = clamped_block()
    aside = replace(mesh.interfaces["clamp"], centre=np.array([30.001, 0.0005, 0.0005]))
    unit = interface_loads(Elements(mesh), aside)
    assert 1e-5 < unit.raw_deviation < 1e-3
    got = resultants(Elements(mesh), unit.vectors, aside.centre)
    assert_allclose(got, wanted(unit), rtol=0, atol=1e-12)
    one_side = {**mesh.surfaces, "clamp": patch(mesh, y=3.0, x=(20.0, 40.0))}
    with pytest.raises(MeshError, match="loads on 'clamp' miss their resultant"):
        interface_loads(Elements(replace(mesh, surfaces=one_side)), mesh.interfaces["clamp"])


def test_a_clamp_presses_along_y_and_rubs_along_x_on_both_faces():
    elements = Elements(clamped_block())
    unit = interface_loads(elements, elements.mesh.interfaces["clamp"])
    y, x = elements.mesh.nodes[:, 1], elements.mesh.nodes[:, 0]
    for column, axis in enumerate((0, 1, 1)):
        force = unit.vectors[:, column].reshape(-1, 3)
        assert np.abs(np.delete(force, axis, axis=1)).max() < 1e-14
        assert_allclose(np.abs(y[np.abs(force).max(axis=1) > 1e-14]), 3.0)
        if column < 2:
            assert_allclose(force[y > 0, axis].sum(), 0.5, rtol=1e-12)
    couple = unit.vectors[:, 2].reshape(-1, 3)[:, 1]
    # pressure 12 M (x - 30) / (2 b l^3): 0.75 M / l on each half and face
    assert_allclose(couple[(x > 30) & (y > 0)].sum(), 0.75 / 20, rtol=0.05)


def test_a_block_bent_over_its_clamp_has_naviers_stress_beside_it():
    """200 N down on either end, 400 N up at the clamp: F x y / I at x = 15, recovered to 3 %."""
    solutions = solve_unit_loads(clamped_block(), STEEL)
    assert not has_bearings(solutions)
    wrenches = {"start": wrench(fy=-200.0), "end": wrench(fy=-200.0), "clamp": wrench(fy=400.0)}
    coefficients, added = solutions.coefficients(wrenches, np.zeros((1, 4)))
    assert np.abs(added).max() < 1e-3
    stress = (solutions.basis @ coefficients)[:, :, 0]
    at = solutions.mesh.nodes[solutions.recovery.points]
    for side in (-1, 1):
        here = np.isclose(at[:, 0], 15) & np.isclose(at[:, 1], 3 * side)
        expected = 200.0 * 15 * 3 * side / (4 * 6**3 / 12)
        assert_allclose(stress[here, 0].mean(), expected, rtol=0.03)
    row = {name: value[0] for name, value in wrenches.items()}
    direct = direct_stress(solutions, row, coefficients[:, 0], [np.pi])[..., 0]
    assert_allclose(direct, stress, rtol=0, atol=1e-8 * np.abs(stress).max())


def test_a_kind_of_interface_that_is_not_known_is_refused():
    elements = Elements(clamped_block())
    weld = Interface("clamp", "weld", np.zeros(3))
    with pytest.raises(MeshError, match="'clamp' is a 'weld'; loads that stay in one place are"):
        interface_loads(elements, weld)
