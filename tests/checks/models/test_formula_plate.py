"""Plates with pins by formula: section forces by hand, holes and bends, against other models."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.by_formula.lug_shear_out import ligaments
from checks.design.materials import known_materials
from checks.handbook.lug_stress import curved_bar
from checks.handbook.pin_loaded_hole import CurvedSection, open_hole
from checks.models.formula_points import Points
from checks.models.plate_buckling import PlateForces
from checks.models.shapes import model_of
from checks.models.shapes.plate import _Arch, stress
from checks.part.part_loads import PartLoads
from checks.part.plate_loads import FlatSection
from fem.recovery import von_mises
from geometry.closed_form import closed_body
from geometry.outlines import Contour, PlateOutline
from geometry.parts import PlateLink
from geometry.parts.plate import Eye, Plate, PlateBore, lever_outline

STEEL = known_materials()["S355"].of(())


def lever(places, *, holes=(12.0,), thickness=10.0, fillet=15.0):
    holes = [*holes, *([holes[-1]] * len(places))]
    eyes = [Eye("ABCD"[k], complex(at), holes[k], eye) for k, (at, eye) in enumerate(places)]
    bores = tuple(PlateBore(e.name, e.hole, (e.centre.real, e.centre.imag)) for e in eyes)
    return Plate(lever_outline(eyes, fillet), bores, thickness)


STRAIGHT = lever(((0, 40), (150, 40), (250, 40)))
BENT = lever(((0, 40), (150, 56), (150 + 100j, 36)))


def part_of(shape):
    return SimpleNamespace(
        name="part", shape="lever", geometry=shape, material=STEEL, bearing_arc=np.pi / 2
    )


def loads_of(wrenches, accelerations=(0, 0, 0, 0)):
    return PartLoads(
        {name: np.array([[*wrench, 0, 0, 0, 0][:6]], float) for name, wrench in wrenches.items()},
        np.array([accelerations], float),
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
    )


def forces_of(shape, loads):
    return PlateForces(part_of(shape), shape, loads, Points(1))


def across(forces, point, way, **ahead):
    """Force along, across, and couple (3,) of a section through a point."""
    section = FlatSection(forces.shape.outline.cut(point, way), forces.shape.thickness)
    return (forces.across(section, forces.is_ahead(section) | ahead) @ forces.acting)[:, 0]


# 2 kN at C lift against 3 kN at A; B holds both and pulls back the 500 N along
LIFTED = {"A": (0, 2000), "B": (-500, -5000), "C": (500, 3000)}


def test_section_forces_of_a_lever_by_hand():
    forces = forces_of(STRAIGHT, loads_of(LIFTED))
    # beyond x = 100: B and C; beyond 200: C, 50 mm further
    assert_allclose(across(forces, 100, 1), [0, -2000, 2000 * 100], atol=1e-6)
    assert_allclose(across(forces, 200, 1), [500, 3000, 3000 * 50], atol=1e-6)
    # from the other side the section is the same one, seen from behind
    assert_allclose(across(forces, 200, -1), [500, 3000, -3000 * 50], atol=1e-6)


def test_section_forces_of_a_bell_crank_by_hand():
    # 3 kN at A, 150 mm off, hold 4.5 kN at C, 100 mm off and square to it
    loads = loads_of({"A": (0, 3000), "B": (4500, -3000), "C": (-4500, 0)})
    forces = forces_of(BENT, loads)
    assert_allclose(across(forces, 60, 1), [0, -3000, 3000 * 60], atol=1e-6)
    assert_allclose(across(forces, 150 + 60j, 1j), [0, 4500, 4500 * 40], atol=1e-6)
    # through the hub the couple about its middle is known, whoever has the pin's force
    for share in (0.0, 1.0):
        section = FlatSection(BENT.outline.cut(150, 1 + 1j), BENT.thickness)
        ahead = forces.is_ahead(section) | {"B": share}
        force = forces.across(section, ahead) @ forces.acting
        arm = (section.centroid - 150) / section.cut.along
        about_hub = force[2, 0] + arm.real * force[1, 0] - arm.imag * force[0, 0]
        assert_allclose(about_hub, 4500 * 100, rtol=1e-9)


def test_a_turning_lever_is_pulled_by_its_own_mass():
    omega = 300.0
    body = closed_body(STRAIGHT)
    mass = body.volume * STEEL.density
    hold = mass * body.centre[0] * omega**2
    loads = loads_of({"A": (-hold, 0), "B": (0, 0), "C": (0, 0)}, (0, 0, 0, omega**2))
    forces = forces_of(STRAIGHT, loads)
    cut = STRAIGHT.outline.cut(200, 1)
    wanted = cut.ahead.first[0] * STRAIGHT.thickness * STEEL.density * omega**2
    assert_allclose(across(forces, 200, 1), [wanted, 0, 0], rtol=1e-9, atol=1e-6 * wanted)


def test_what_foreign_masses_leave_is_made_up_for_by_an_acceleration():
    forces = forces_of(STRAIGHT, loads_of({"A": (0, 100), "B": (0, 0), "C": (0, 0)}))
    whole = sum(across(forces, x, way)[0] for x, way in ((100, 1),))
    assert_allclose(whole, 0, atol=1e-6)
    # at both ends nothing is left
    assert_allclose(across(forces, 269.99999, 1), 0, atol=1)
    assert_allclose(across(forces, -19.99999, 1), 0, atol=1)


def test_open_holes_have_their_known_factors():
    up, aside = np.array([np.pi / 2]), np.array([3 * np.pi / 4])
    assert_allclose(open_hole(up, 0.0), [[3, 2, 0]], atol=1e-12)
    assert_allclose(open_hole(aside, 0.0)[0, 2], 4, atol=1e-12)
    # Howland's strip with a hole of half its width: 4.32 on the gross section, his fit 4.25
    assert_allclose(open_hole(up, 0.5)[0, 0], 4.25, rtol=1e-9)


def test_the_field_of_an_open_hole_in_a_bent_plate_is_free_at_its_edge():
    """Airy's function of the docstring, by differences: sigma_x = g y far away, no traction."""
    a, g = 1.0, 1.0

    def airy(x, y):
        r, t = np.hypot(x, y), np.arctan2(y, x)
        even = (r**3 + a**4 / r) / 8 * np.sin(t)
        odd = (r**3 - 3 * a**4 / r + 2 * a**6 / r**3) / 24 * np.sin(3 * t)
        return g * (even - odd)

    h = 1e-4
    for t in (0.3, 1.1, np.pi / 2):
        for r, rim in ((1.0, True), (40.0, False)):
            x, y = r * np.cos(t), r * np.sin(t)
            xx = (airy(x, y + h) - 2 * airy(x, y) + airy(x, y - h)) / h**2
            yy = (airy(x + h, y) - 2 * airy(x, y) + airy(x - h, y)) / h**2
            xy = -(airy(x + h, y + h) - airy(x + h, y - h) - airy(x - h, y + h)
                   + airy(x - h, y - h)) / (4 * h * h)  # fmt: skip
            c, s = np.cos(t), np.sin(t)
            if rim:
                radial = xx * c * c + yy * s * s + 2 * xy * s * c
                hoop = xx * s * s + yy * c * c - 2 * xy * s * c
                assert_allclose(radial, 0, atol=1e-6)
                assert_allclose((yy - xx) * s * c + xy * (c * c - s * s), 0, atol=1e-6)
                assert_allclose(hoop, open_hole(np.array([t]), 0.0)[0, 1], atol=1e-6)
            else:
                assert_allclose([xx, yy, xy], [y, 0, 0], atol=0.03)


def test_curved_sections_are_winklers_and_carry_what_acts_on_them():
    whole = CurvedSection(np.array([[5.0, 15.0]]), np.array([2.0]))
    bent = whole.stress(np.array([5.0]))[0, 1]
    assert_allclose(bent, curved_bar(10.0, 5.0) * 6 / (2.0 * 10.0**2), rtol=1e-12)
    with_hole = CurvedSection(np.array([[5.0, 9.0], [12.0, 20.0]]), np.full(2, 3.0))
    r, w = np.polynomial.legendre.leggauss(12)
    total = np.zeros((2, 2))
    for low, high in with_hole.spans:
        at = (high + low) / 2 + (high - low) / 2 * r
        stress_at = with_hole.stress(at) * (w * (high - low) / 2 * 3.0)[:, None]
        total[0] += stress_at.sum(axis=0)
        total[1] -= ((at - with_hole.centroid)[:, None] * stress_at).sum(axis=0)
    assert_allclose(total, np.eye(2), atol=1e-9)  # a couple above 0 pulls the inside


def test_a_plate_that_is_a_flat_link_has_the_links_stress():
    link = PlateLink(length=120.0, width=40.0, thickness=10.0, hole=16.0)
    outer = Contour.of((-20j, 120 - 20j, 120 + 20j, 20j), (0.0, 1.0, 0.0, 1.0))
    outline = PlateOutline(outer, (Contour.round(0, 8), Contour.round(120, 8)))
    bores = (PlateBore("first", 16, (0, 0)), PlateBore("second", 16, (120, 0)))
    plate = Plate(outline, bores, 10.0)
    for pull in (9000.0, -9000.0):
        ends = {"first": (-pull, 0, 0, 0, 0, 5e3), "second": (pull, 0, 0, 0, 0, -5e3)}
        loads = loads_of(ends)
        own, wanted = (model_of(part_of(shape), loads) for shape in (plate, link))
        peaks = [von_mises(model.history.at(0)).max() for model in (own, wanted)]
        assert_allclose(peaks[0], peaks[1], rtol=0.02)
        if pull < 0:
            assert_allclose(own.buckling.share, wanted.buckling.share, rtol=0.05)
        else:  # the couples alone: a solid of 13 000 unknowns has 3.50e-4, links 35 % more
            assert_allclose(own.buckling.share, 3.50e-4, rtol=0.1)
            assert own.buckling.share < wanted.buckling.share
    for name in ("first", "second"):
        (found,) = ligaments(part_of(plate), closed_body(plate), name)
        outward = np.pi if name == "first" else 0.0
        beyond, between = found.areas(np.array([outward, np.pi - outward]))
        assert_allclose(beyond, 10.0 * (20 - 8), rtol=0.02)
        assert between == np.inf


def test_a_lever_turned_and_mirrored_has_the_same_peak():
    loads = {"A": (300, 3000), "B": (4200, -3000), "C": (-4500, 0)}
    turned = lever(((0, 40), (150, 56), (150 - 100j, 36)))
    mirrored = {name: (x, -y) for name, (x, y) in loads.items()}
    one = stress(part_of(BENT), BENT, loads_of(loads))
    other = stress(part_of(turned), turned, loads_of(mirrored))
    peaks = [von_mises(model.history.at(0)).max() for model in (one, other)]
    assert_allclose(peaks[0], peaks[1], rtol=1e-6)
    assert_allclose(one.buckling.share, other.buckling.share, rtol=1e-6)
    assert_allclose(one.deflection, other.deflection, rtol=1e-6)


def test_a_lever_drawn_in_other_axes_has_the_same_stress_around_its_bores():
    """The places around a bore follow the lever: every 10 deg of its axes gave up to 0.4 % less."""
    loads = {"A": (300, 3000), "B": (4200, -3000), "C": (-4500, 0)}
    turn = np.exp(1j * np.radians(37.0))
    turned = lever(((0, 40), (150 * turn, 56), ((150 + 100j) * turn, 36)))
    along = {name: complex(*force) * turn for name, force in loads.items()}
    acting = {name: (force.real, force.imag) for name, force in along.items()}
    models = [
        stress(part_of(shape), shape, loads_of(forces))
        for shape, forces in ((BENT, loads), (turned, acting))
    ]
    for name in "ABC":
        found = [
            von_mises(model.history.at(0))[np.array(model.places) == name].max() for model in models
        ]
        assert_allclose(found[1], found[0], rtol=1e-9)


def test_a_bent_lever_told_from_its_other_end_buckles_alike():
    """Its axes are turned by 90 degrees then: the pressure in its bores was along x, not the arm.

    Held against twisting at B, and sideways at C, the nearest, in both.
    """
    loads = {"A": (300, 3000), "B": (4200, -3000), "C": (-4500, 0)}
    other_way = lever(((0, 36), (100, 56), (100 - 150j, 40)))
    turned = {b: (-loads[a][1], loads[a][0]) for a, b in zip("ABC", "CBA", strict=True)}
    shares = [
        stress(part_of(shape), shape, replace(loads_of(acting), tilt_held_at="B")).buckling.share
        for shape, acting in ((BENT, loads), (other_way, turned))
    ]
    assert_allclose(shares[1], shares[0], rtol=1e-6)


def test_the_bend_is_stressed_like_a_curved_bar():
    loads = loads_of({"A": (0, 3000), "B": (4500, -3000), "C": (-4500, 0)})
    model = stress(part_of(BENT), BENT, loads)
    here = np.array([place == "hollow edge beside B" for place in model.places])
    assert here.any()
    # about 33 mm from fillet to hub's outside: 450 N m bend it, no less than a straight bar
    found = von_mises(model.history.at(0))[here].max()
    depth = min(BENT.outline.reach(150, (1 - 1j) / 2**0.5), 60) * 2
    assert found > 450e3 * 6 / (10 * depth**2) * 0.9


def test_the_ligament_outside_of_a_bend_is_a_two_hinged_arch():
    """Its chord lengthens by what bends it, N R (cos t - cos a), and by its axial force."""
    arch = _Arch(radius=10.0, width=4.0, half=0.8)
    t, weight = np.polynomial.legendre.leggauss(20)
    along, rise = arch.half * t, arch.middle * (np.cos(arch.half * t) - np.cos(arch.half))
    bent = weight @ rise**2 * arch.half * arch.middle / (4.0**3 / 12)  # E = N = thickness = 1
    straight = 2 * arch.half * arch.middle / 4.0
    assert_allclose(arch.share, straight / (straight + bent), rtol=1e-12)
    assert_allclose(arch.rise, rise[np.argmin(abs(along))], rtol=1e-2)
    assert _Arch.of(STRAIGHT, STRAIGHT.bores[1]).share == 1.0
    assert_allclose(_Arch.of(BENT, BENT.bores[1]).half, np.pi / 4, rtol=1e-12)
    assert_allclose(_Arch.of(BENT, BENT.bores[1]).radius, BENT.bores[1].diameter / 2)


def test_shapes_without_a_formula_say_so():
    hook = Contour.of(
        (-20 - 20j, 120 - 20j, 120 + 80j, -20 + 80j, -20 + 50j, 90 + 50j, 90 + 10j, -20 + 10j),
        (0.0,) * 8,
    )
    outline = PlateOutline(hook, (Contour.round(0 - 5j, 6), Contour.round(0 + 65j, 6)))
    bores = (PlateBore("A", 12, (0, -5)), PlateBore("B", 12, (0, 65)))
    loads = loads_of({"A": (0, -10), "B": (0, 10)})
    plate = Plate(outline, bores, 10.0)
    assert stress(part_of(plate), plate, loads) is None  # no straight way between its pins
    window = Contour.of((60 - 5j, 80 - 5j, 80 + 5j, 60 + 5j), (0.0,) * 4)
    straight = Plate(
        PlateOutline(STRAIGHT.outline.outer, (*STRAIGHT.outline.inner, window)),
        STRAIGHT.bores,
        10.0,
    )
    assert stress(part_of(straight), straight, loads_of(LIFTED)) is None


@pytest.mark.parametrize("radius", [4.0, 8.0])
def test_a_round_window_raises_the_stress_beside_it(radius):
    windowed = Plate(
        PlateOutline(
            STRAIGHT.outline.outer, (*STRAIGHT.outline.inner, Contour.round(200 + 0j, radius))
        ),
        STRAIGHT.bores,
        10.0,
    )
    pull = loads_of({"A": (0, 0), "B": (-5000, 0), "C": (5000, 0)})
    model = stress(part_of(windowed), windowed, pull)
    here = np.array([place == "round window" for place in model.places])
    even = 5000 / (10 * 40)
    wanted = (2 + (1 - radius / 20) ** 3) / (1 - radius / 20) * even
    assert_allclose(von_mises(model.history.at(0))[here].max(), wanted, rtol=0.02)


def test_a_plate_with_a_branch_buckles_alike_whatever_the_order_of_its_bores():
    """O holds its twist, and of the others C stands next to that, beside the way from A to B."""
    at = {"O": 0, "A": -100, "B": 120, "C": 60j}
    corners = (
        -130 - 25j,
        150 - 25j,
        150 + 25j,
        23 + 25j,
        23 + 85j,
        -23 + 85j,
        -23 + 25j,
        -130 + 25j,
    )
    outer, shares = Contour.of(corners, (0.0,) * 8), []
    loads = loads_of({"O": (0, -300, 0, 0, 0, -9600), "A": (0, 120), "B": (0, 180), "C": (0, 0)})
    for order in ("AOBC", "BOAC"):
        bores = tuple(PlateBore(k, 16.0, (complex(at[k]).real, complex(at[k]).imag)) for k in order)
        outline = PlateOutline(outer, tuple(Contour.round(at[k], 8) for k in order))
        shape = Plate(outline, bores, 8.0)
        model = model_of(part_of(shape), replace(loads, tilt_held_at="O"))
        shares.append(model.buckling.share)
    assert_allclose(shares[1], shares[0], rtol=1e-9)


@pytest.mark.parametrize(("thickness", "plane"), [(60.0, "in plane"), (10.0, "out of plane")])
def test_a_straight_lever_buckles_as_a_column(thickness, plane):
    """In its plane from end to end; out of it held at A and the pin next to it, beyond that free.

    Out of it cot ka + cot kb = 1/(k a) of the arms between where pins press, 8/(3 pi) of a bore's
    radius off their middles; the bores take some of its stiffness, a tenth at most.
    """
    shape = lever(((0, 40), (150, 40), (250, 40)), thickness=thickness)
    loads = loads_of({"A": (1000, 0), "B": (0, 0), "C": (-1000, 0)})
    model = model_of(part_of(shape), loads)
    assert model.buckling.words.startswith(plane)
    young = STEEL.youngs_modulus
    if plane == "in plane":
        share = 1000.0 * 250.0**2 / (np.pi**2 * young * thickness * 40**3 / 12)
        assert model.buckling.share == pytest.approx(share, rel=1e-6)
        return
    a, b = (arm - 4 / (3 * np.pi) * 12.0 for arm in (150.0, 100.0))
    k = np.linspace(0.3, 0.9, 60001) * np.pi / a
    left = 1 / np.tan(k * a) + 1 / np.tan(k * b) - 1 / (k * a)
    (critical,) = k[1:][(left[1:] < 0) & (left[:-1] >= 0)] ** 2 * young * 40 * thickness**3 / 12
    assert 1.0 < model.buckling.share * critical / 1000.0 < 1.1
