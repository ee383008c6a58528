"""Bushes in bores: waves against radial finite elements, thin layers and beams on them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from fem.contact.beds import Lug, RoundBar
from fem.contact.condensed import CondensedContact
from fem.contact.cylinder_waves import Lining, bore_waves, lined_bore_waves
from fem.contact.hats import Hats, disc_flexibility, lining_flexibility, sheet_flexibility
from fem.contact.line_load import line_load
from fem.contact.persson import persson_half_arc
from tests.line_loads import unevenness

STEEL, BRONZE = (210e3, 0.3), (90e3, 0.34)


def by_energy(n, k, lining, bore, far=40.0, count=400):
    """Displacement E u/(p R) of a lined bore, R = 1, under p cos(n a) cos(k z), by its energy.

    Linear elements along the radius for u cos cos, v sin cos, w cos sin; held at `far`. No Bessel
    functions, no harmonic potentials. Steps grow with the radius; twice as many miss a quarter.
    """
    grown = np.geomspace(1.0, far, count)
    r = np.sort(np.r_[grown, lining.ratio])
    size = 3 * len(r)
    stiff = np.zeros((size, size))
    elastic = [(lining.youngs_modulus, lining.poisson_ratio), bore]
    for i, h in enumerate(np.diff(r)):
        young, nu = elastic[int(r[i] + h / 2 > lining.ratio)]
        law = np.diag([1.0] * 3 + [0.0] * 3) * (1 - 2 * nu) + np.pad(np.full((3, 3), nu), (0, 3))
        law += np.diag([0.0] * 3 + [(1 - 2 * nu) / 2] * 3)
        law *= young / ((1 + nu) * (1 - 2 * nu))
        at = np.arange(3 * i, 3 * i + 6)
        for t, weight in zip((0.2113248654, 0.7886751346), (h / 2, h / 2), strict=True):
            here = r[i] + t * h
            shape, slope = np.array([1 - t, t]), np.array([-1.0, 1.0]) / h
            strain = np.zeros((6, 6))
            for j in (0, 1):
                s, d = shape[j], slope[j]
                strain[:, 3 * j : 3 * j + 3] = [
                    [d, 0, 0], [s / here, n * s / here, 0], [0, 0, k * s],
                    [-n * s / here, d - s / here, 0], [-k * s, 0, d], [0, -k * s, -n * s / here],
                ]  # fmt: skip
            stiff[np.ix_(at, at)] += weight * here * strain.T @ law @ strain
    free = np.arange(size - 3)
    if n == 0:
        free = free[free % 3 != 1]
    load = np.zeros(size)
    load[0] = 1.0
    return np.linalg.solve(stiff[np.ix_(free, free)], load[free])[0] * bore[0]


@pytest.mark.parametrize(("n", "k"), [(0, 0.5), (1, 0.5), (1, 2.0), (2, 0.3), (5, 3.0), (3, 8.0)])
@pytest.mark.parametrize("lining", [Lining(1.1, *BRONZE), Lining(1.3, 3e3, 0.4)])
def test_waves_in_a_lined_bore_have_the_least_energy(n, k, lining):
    """1e-3, which linear elements miss at most here, from below as the energy's least is."""
    found = lined_bore_waves(n, np.array([k]), *STEEL, lining)[n, 0]
    assert_allclose(by_energy(n, k, lining, STEEL), found, rtol=1e-3)
    assert found > 1.01 * bore_waves(n, np.array([k]), 0.3)[n, 0]


def test_a_bush_of_the_bores_own_material_is_none():
    """1e-6 even where waves are long, and both kinds of solution nearly the same; no overflow."""
    x = np.array([0.01, 0.3, 5.0, 300.0, 1200.0])
    for ratio in (1.01, 1.1, 3.0):
        lined = lined_bore_waves(48, x, *STEEL, Lining(ratio, *STEEL))
        assert_allclose(lined, bore_waves(48, x, 0.3), rtol=1e-6)


def test_a_thin_soft_layer_gives_way_by_its_thickness_over_its_constrained_modulus():
    """M = E (1 - nu)/((1 + nu)(1 - 2 nu)): its faces are held; 1 % for a layer of 0.01 R."""
    young, nu = 20.0, 0.35
    added = lined_bore_waves(6, np.array([0.5]), *STEEL, Lining(1.01, young, nu))
    added -= bore_waves(6, np.array([0.5]), 0.3)
    modulus = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    assert_allclose(added[:, 0], 0.01 * STEEL[0] / modulus, rtol=0.01)


def test_a_bronze_bush_adds_what_it_gives_more_than_steel_in_its_place():
    """By hand, t/R (E/M_b - 1/m_s) with m = (1 - nu)/((1 + nu)(1 - 2 nu)): 2 mm on 20 mm
    0.1 (2.333 x 0.650 - 0.743) = 0.0774 of R/E; the exact ring 0.083 to 0.091 for n = 2 to 10.
    Short waves see the bush alone, 2 (1 - nu^2)/n of it less that of steel.
    """
    lining = Lining(1.1, *BRONZE)
    added = lined_bore_waves(400, np.array([0.01]), *STEEL, lining)[:, 0]
    added -= bore_waves(400, np.array([0.01]), 0.3)[:, 0]
    assert_allclose(added[2:11], 0.0774, rtol=0.2)
    alone = 2 / 400 * ((1 - 0.34**2) * 210 / 90 - (1 - 0.3**2))
    assert_allclose(added[400], alone, rtol=0.01)


def fork(lining, clearance=0.0, diameter=20.0, eye=20.0):
    """40 kN on an eye between two cheeks, 1 mm apart; all with the same bush."""
    faces = eye / 2 + 1, eye + 1
    bar = RoundBar((-faces[1] - 5, faces[1] + 5), (diameter,), *STEEL)
    held = 0.0, clearance, lining
    return line_load(
        bar,
        [
            Lug(-faces[1], -faces[0], (-20e3, 0.0), *STEEL, *held),
            Lug(-eye / 2, eye / 2, (40e3, 0.0), *STEEL, *held),
            Lug(faces[0], faces[1], (-20e3, 0.0), *STEEL, *held),
        ],
    )


def test_the_softer_the_bush_the_evener_a_bent_pin_presses():
    """Steel in place of steel changes nothing; the softest evens all to 1 %."""
    linings = [None, *(Lining(1.2, e, 0.3) for e in (210e3, 90e3, 10e3, 1e3, 10.0))]
    found = [unevenness(fork(lining), 1, 1.0) for lining in linings]
    assert_allclose(found[1], found[0], rtol=1e-6)
    assert (np.diff(found[1:]) < 0).all()
    assert found[0] > 1.1
    assert_allclose(found[-1], 1.0, atol=0.01)


def test_a_pin_in_a_soft_thin_bush_is_a_beam_on_an_elastic_foundation():
    """Hetenyi's free beam, loaded at both faces of its lug (tests/fem/test_line_load.py).

    Springs c = t/M around, pressed by (cos) over half the circle: p = d cos(a)/c carries
    q = pi R d/(2 c). Slender, 5 mm on 200 mm; hats to 1 %, the layer's own shear to 1 %.
    """
    diameter, length, u, nu, ratio = 5.0, 200.0, 0.8, 0.3, 1.05
    inertia = np.pi * diameter**4 / 64
    springs = 4 * STEEL[0] * inertia * (2 * u / length) ** 4
    radius = diameter / 2
    modulus = springs * (ratio - 1) * radius * 2 / (np.pi * radius)
    young = modulus * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    faces = length / 2 + 1e-3, length / 2 + 0.2
    found = line_load(
        RoundBar((-faces[1], faces[1]), (diameter,), *STEEL),
        [
            Lug(-faces[1], -faces[0], (-1e3, 0.0), *STEEL),
            Lug(-length / 2, length / 2, (2e3, 0.0), *STEEL, lining=Lining(ratio, young, nu)),
            Lug(faces[0], faces[1], (-1e3, 0.0), *STEEL),
        ],
        patches=24,
    )

    def shape(x):
        bx = 2 * u / length * x
        return np.cosh(bx) * np.cos(bx) + np.tanh(u) * np.tan(u) * np.sinh(bx) * np.sin(bx)

    x = np.linspace(-length / 2, length / 2, 4001)
    wanted = shape(found.hats[1].nodes) / np.trapezoid(shape(x), x) * length
    ours = found.intensity(1) * length / 2e3
    assert wanted.max() > 1.2
    assert_allclose(ours, wanted, atol=0.03 * wanted.max())


def test_a_loose_pin_touches_a_wider_arc_of_a_soft_bush():
    """Bare: Persson's arc. A bush of a thousandth of steel's modulus: that of springs alone.

    p = (d cos(a) - C)/c, c = t/M, C half the clearance, out to cos(b) = C/d; their resultant is
    (R/c) (d (b + sin(b) cos(b)) - 2 C sin(b)).
    """
    hats, force, clearance = Hats.even(144), 1000.0, 0.05
    arcs = []
    for lining in (None, Lining(1.1, *BRONZE), Lining(1.1, 210.0, 0.3)):
        c = disc_flexibility(hats, 1.0, *STEEL, strain=True)
        c += sheet_flexibility(hats, 1.0, *STEEL, strain=True)
        if lining:
            c += lining_flexibility(hats, 1.0, *STEEL, lining)
        state = CondensedContact((c + c.T) / 2, hats.directions).solve(
            np.full(144, clearance / 2), np.array([force, 0.0])
        )
        arcs.append(np.degrees(hats.arc(state.forces / hats.extents)))
    softness = 2 * (1 - 0.3**2) / STEEL[0]
    wanted = 2 * np.degrees(persson_half_arc(clearance / 2 / softness / force))
    assert_allclose(arcs[0], wanted, rtol=0.03)
    assert arcs[0] < arcs[1] < arcs[2]
    springs = 0.1 * (1 + 0.3) * (1 - 2 * 0.3) / (1 - 0.3) / 210.0

    def missing(b):
        carried = (b + np.sin(b) * np.cos(b)) / np.cos(b) - 2 * np.sin(b)
        return clearance / 2 * carried / springs - force

    assert_allclose(arcs[2], 2 * np.degrees(brentq(missing, 0.1, 1.57)), rtol=0.03)
