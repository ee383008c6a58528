"""Bending and shear along a pin against what its lugs' forces and arms give by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from checks.by_formula import pin_bending
from checks.handbook.pin_diagrams import PinDiagram, pin_diagram
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from geometry.parts import Pin, Seat

DESIGNS = Path(__file__).parents[3] / "designs"
BRIEF = [
    "cycles.press.positions=31",
    *(
        f"bodies.{body}.{key}"
        for body in ("lower", "upper")
        for key in ('mass="4.14134 kg"', 'inertia="0.0215695 kg m2"', 'centre="125, 0 mm"')
    ),
]
BUSH = 'bush={length="6.3 mm", allowable="140 MPa"}'
LUGS = (
    f'{{body="upper", at="42.95 mm", width="6.3 mm", {BUSH}}}, '
    f'{{body="lower", at="32.65 mm", width="6.3 mm", {BUSH}}}'
)
PLAIN_PIN = f'parts.pin_B.stack=[{LUGS}, {{force="cylinder", at="0 mm", width="43 mm"}}]'


def knee_pin(*overrides):
    """Design, part and loads of the toggle press' knee pin under the brief's masses."""
    design = read_design(DESIGNS / "toggle_press.toml", [*BRIEF, *overrides])
    part = design.parts["pin_B"]
    return design, part, loads_on(design, part, solve_cycles(design, {}))


def pin_checks(loaded):
    return list(pin_bending.checks(loaded))


def wrench(x=0.0, y=0.0, couple_x=0.0, couple_y=0.0):
    return np.array([[x, y, 0.0, couple_x, couple_y, 0.0]])


def size(vectors):
    return np.hypot(vectors[..., 0], vectors[..., 1])


def test_the_knee_pin_is_bent_by_350_newton_metres_at_its_middle():
    """The brief's T-E14: arms from the lugs, the eye's force spread: 349.5 N m, 55.62 MPa at d40.

    By hand: 30.293 kN x 42.95 mm - 30.769 kN x 32.65 mm + 0.476 kN x 43/4 mm along the lower bar is
    302 N m, and across it 5.48 kN x (42.95 - 43/4) mm are 176 N m.
    """
    design, part, loads = knee_pin(PLAIN_PIN)
    evenly = pin_diagram(part.geometry, dict(loads.wrenches))
    assert_allclose(size(evenly.moment).max(), 349.5e3, atol=150)
    bending, shear = pin_checks(LoadedPart(design, part, loads))
    assert (bending.kind, shear.kind) == ("pin bending", "pin shear")
    assert_allclose(bending.value, 55.62, atol=0.03)
    assert bending.model == bending.model_below == 0
    eye = 30.769e3 - 30.293e3  # in the line of the bars, half of it
    across, along = 5.478e3 * (42.95 - 43 / 4), 30.293e3 * 42.95 - 30.769e3 * 32.65 + eye * 43 / 4
    by_hand = 32 * np.hypot(across, along) / (np.pi * 40**3)
    assert_allclose(bending.value, by_hand, rtol=1e-3)
    assert_allclose(bending.limit, 650.0)
    assert bending.place == "z = 0 mm"
    assert "upper 122" in bending.note


def test_the_knee_pin_is_sheared_most_between_the_bars():
    """Half of 61.57 kN over pi 40^2 / 4, times 4/3: 32.66 MPa, against 650 MPa over sqrt 3."""
    design, part, loads = knee_pin(PLAIN_PIN)
    shear = pin_checks(LoadedPart(design, part, loads))[1]
    assert_allclose(shear.value, 4 / 3 * 61.57e3 / 2 / (np.pi * 400), rtol=1e-3)
    assert_allclose(shear.limit, 650 / 3**0.5)
    assert shear.required == design.require.static


def test_a_neck_is_judged_by_its_own_diameter():
    """The same moment in 35 mm: (40/35)^3 times the stress of a plain pin."""
    plain, neck = (pin_checks(LoadedPart(*knee_pin(*more)))[0] for more in ([PLAIN_PIN], []))
    assert_allclose(neck.value / plain.value, (40 / 35) ** 3, rtol=1e-9)
    assert "d = 35 mm" in neck.note


def test_shear_and_moment_vanish_at_both_ends_of_a_pin_in_balance():
    """One-sided lugs and a pair: the couple of fixed_to closes the diagram. Round-off."""
    pin = Pin(
        seats=(
            Seat("pair", at=30.0, width=8.0),
            Seat("left", at=-12.0, width=10.0, single=True),
            Seat("right", at=9.0, width=6.0, single=True),
        ),
        diameter=20.0,
    )
    left, right = np.array([700.0, -300.0]), np.array([150.0, 900.0])
    moment = -12.0 * left + 9.0 * right
    for holder in ("pair", "left"):
        # couple (M_x, M_y) = z x F of both forces, which the holder gives back
        couple = {"couple_x": moment[1], "couple_y": -moment[0]}
        none = {"couple_x": 0.0, "couple_y": 0.0}
        wrenches = {
            "pair": wrench(*-(left + right), **(couple if holder == "pair" else none)),
            "left": wrench(*left, **(couple if holder == "left" else none)),
            "right": wrench(*right),
        }
        diagram = pin_diagram(pin, wrenches)
        assert size(diagram.moment).max() > 5e3
        assert_allclose(diagram.shear[0, [0, -1]], 0, atol=1e-9)
        assert_allclose(diagram.moment[0, [0, -1]], 0, atol=1e-7)


def test_a_fork_bends_its_pin_by_an_eighth_of_the_force_over_widths_and_gaps():
    """M = F/8 (2a + 4c + b) with cheeks of a = 6, a lug of b = 20 and gaps of c = 1 mm."""
    pin = Pin(
        seats=(Seat("fork", at=14.0, width=6.0), Seat("eye", width=20.0, single=True)),
        diameter=10.0,
    )
    diagram = pin_diagram(pin, {"fork": wrench(x=-800.0), "eye": wrench(x=800.0)})
    assert_allclose(size(diagram.moment).max(), 800 / 8 * (2 * 6 + 4 * 1 + 20), rtol=1e-9)


def test_a_pair_of_lugs_takes_a_couple_as_pressures_that_grow_outwards():
    """q = C z / J, J = 2 (w^3/12 + w at^2) = 1601.3: nearly C / (2 at) = 1000 N at +-20 mm."""
    pin = Pin(
        seats=(Seat("pair", at=20.0, width=2.0), Seat("mid", at=0.0, width=4.0, single=True)),
        diameter=20.0,
    )
    wrenches = {"pair": wrench(couple_y=40e3), "mid": wrench(couple_y=-40e3)}
    diagram = pin_diagram(pin, wrenches)
    outside = np.abs(diagram.places) >= 19
    second = 2 * (2**3 / 12 + 2 * 20**2)
    assert_allclose(size(diagram.shear)[0, outside].max(), 40e3 * 2 * 20 / second, rtol=1e-9)


def single_shear(distance):
    """A crank and a rod side by side on one pin, which the crank holds."""
    pin = Pin(
        seats=(
            Seat("crank", at=0.0, width=10.0, single=True),
            Seat("rod", at=distance, width=10.0, single=True),
        ),
        diameter=10.0,
    )
    force = 400.0
    couple = force * distance  # of the rod's force about y, given back by the crank
    return pin, {"crank": wrench(x=-force, couple_y=-couple), "rod": wrench(x=force)}


def test_a_pin_in_single_shear_is_bent_by_force_times_offset_where_it_is_held():
    """q(z) = -F/w - 12 F a z/w^3; at the crank's middle half of F a and F w/8."""
    pin, wrenches = single_shear(10.5)
    pressed = pin_diagram(pin, wrenches)
    # q(z) = -F/w - 12 F a z / w^3 from -w/2: M = -F s^2/(2w) + F a (3 s^2/w^2 - 2 s^3/w^3)
    s = np.linspace(0, 10, 2001)
    exact = -400 * s**2 / 20 + 400 * 10.5 * (3 * s**2 / 100 - 2 * s**3 / 1000)
    assert_allclose(size(pressed.moment).max(), np.abs(exact).max(), rtol=5e-3)


def test_the_offset_of_plates_side_by_side_bends_their_pin_in_proportion():
    """F (a - w/2) at the face of the crank."""
    moments = []
    for distance in (15.0, 25.0):
        diagram = pin_diagram(*single_shear(distance))
        at = np.flatnonzero(diagram.places == 5.0)
        moments.append(size(diagram.moment)[0, at].max())
    assert_allclose(moments, [400.0 * 10.0, 400.0 * 20.0], rtol=1e-12)


def section(shear, moment):
    places, diameter, none = np.array([0.0]), np.array([20.0]), np.zeros((1, 1))
    return PinDiagram(places, diameter, np.array([[shear]]), np.array([[moment]]), none)


def test_shear_in_the_plane_of_bending_adds_nothing_to_the_larger_of_both():
    """sigma^2 u + 3 tau^2 (1 - u)^2 with u = (y/r)^2 has its largest value at an end."""
    both = section([5e4, 0.0], [4e5, 0.0])
    expected = max(both.bending_stress[0, 0], 3**0.5 * both.shear_stress[0, 0])
    assert_allclose(both.equivalent_peaks[0, 0], expected, rtol=1e-12)
    assert 0.5 < both.bending_stress[0, 0] / (3**0.5 * both.shear_stress[0, 0]) < 2


def test_shear_across_the_plane_of_bending_adds_in_full():
    """The rim that is bent most is the rim that the shear runs along: sigma^2 + 3 tau^2."""
    both = section([0.0, 5e4], [4e5, 0.0])
    by_hand = np.hypot(32 * 4e5 / (np.pi * 8000), 3**0.5 * 16 * 5e4 / (3 * np.pi * 400))
    assert_allclose(both.equivalent_peaks[0, 0], by_hand, rtol=1e-9)


def test_friction_in_the_lugs_twists_a_pin_between_them():
    """A pair and a lug between with 6 N m of friction: 3 N m on either side, against the shear."""
    pin = Pin(
        seats=(Seat("pair", at=20.0, width=4.0), Seat("mid", at=0.0, width=8.0)), diameter=10.0
    )
    force, couple = 500.0, 6e3
    wrenches = {"pair": wrench(x=-force), "mid": wrench(x=force)}
    straight = pin_diagram(pin, {k: v.copy() for k, v in wrenches.items()})
    wrenches["pair"][0, 5], wrenches["mid"][0, 5] = -couple, couple
    twisted = pin_diagram(pin, wrenches)
    assert_allclose(np.abs(twisted.torque).max(), 3e3)
    assert_allclose(twisted.torque[0, [0, -1]], 0, atol=1e-9)
    more = twisted.shear_stress.max() - straight.shear_stress.max()
    assert_allclose(more, 16 * 3e3 / (np.pi * 1000), rtol=1e-12)
    # half of it is bent by 5 N m at most: sigma^2 + 3 tau^2 at a rim without shear
    between = np.abs(twisted.places - 10.0).argmin()
    bent = straight.bending_stress[0, between]
    twist = twisted.twist_stress[0, between]
    (found,) = PinDiagram(
        twisted.places[[between]],
        twisted.diameter[[between]],
        twisted.shear[:, [between]],
        twisted.moment[:, [between]],
        twisted.torque[:, [between]],
    ).equivalent_peaks
    assert found[0] >= np.hypot(bent, 3**0.5 * twist)


@pytest.mark.parametrize("friction", [0.0, 4e3])
def test_the_formulas_of_a_pin_give_what_its_diagrams_have(friction):
    """Evaluated at the section and position that the diagrams find; the very same but round-off."""
    lugs = (
        Seat(name, at=at, width=10.0, single=True)
        for name, at in (("a", -20.0), ("b", 0.0), ("c", 20.0))
    )
    pin = Pin(seats=tuple(lugs), diameter=10.0)
    wrenches = {  # the couple of forces across each other, 20 mm apart, is given back by a
        "a": wrench(y=-500.0, couple_x=500.0 * 20, couple_y=-400.0 * 20),
        "b": wrench(x=-400.0, y=500.0),
        "c": wrench(x=400.0),
    }
    wrenches["a"][:, 5], wrenches["c"][:, 5] = -friction, friction
    design, part, loads = knee_pin(PLAIN_PIN)
    shares = np.sin(np.arange(len(loads.labels)))[:, None]
    wrenches = {name: shares * own for name, own in wrenches.items()}
    loaded = LoadedPart(design, replace(part, geometry=pin), replace(loads, wrenches=wrenches))
    diagram = pin_diagram(pin, wrenches, ends_only=True)
    expected = [diagram.bending_stress, diagram.shear_stress, diagram.equivalent_peaks]
    found = pin_checks(loaded)
    assert len(found) == (3 if friction else 2)
    for check, own in zip(found, expected, strict=False):
        assert_allclose(check.value, own.max(), rtol=1e-12)
        assert check.model == check.below == 0
    assert ("T" in found[1].derivation.values) is bool(friction)
