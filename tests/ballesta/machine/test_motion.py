from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.motion import PartSkin, kept_rows, layers, part_frame
from ballesta.machine.motion import _distance as distance_from
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.result.motion import MOST_POSITIONS, motion_gaps
from checks.store.store import from_record, to_record
from geometry.closed_form import closed_body
from reports.live.section import _motion

from ...lighter import buckling_of_no_linkage, without_fatigue
from ...reports.motion_results import placed
from ...small_machine import PLATE, machine, solved

DESIGNS = Path(__file__).parents[3] / "designs"


FEW = {  # positions, yet more than are kept
    "toggle_press": (),
    "slider_crank": (),
    "quick_return": ("cycles.at_4.positions=385",),
}


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.slow if name == "quick_return" else ()) for name in FEW
    ],
)
def checked(request):
    """A machine's design and result by formulas alone: motion needs no mesh and no fatigue."""
    design = read_design(DESIGNS / f"{request.param}.toml", FEW[request.param])
    design = without_fatigue(design)
    with buckling_of_no_linkage():
        return design, check_design(design, effort=Effort("formula"), live=True)


def interface_places(design, part, motion):
    """Joint -> where the part has it in the machine's frame (k, 2), from its geometry and pose."""
    geometry, pose = part.geometry, motion.parts[part.name]
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    if part.body is None:
        return {part.joint: pose[:, :2]}
    points = design.bodies[part.body].points
    first, second = (points[part.interfaces[name]] for name in geometry.interfaces[:2])
    own = {
        geometry.interfaces[0]: 0.0,
        geometry.interfaces[1]: np.hypot(*np.subtract(second, first)),
    }
    return {
        part.interfaces[name]: np.stack([pose[:, 0] + c * x, pose[:, 1] + s * x], axis=1)
        for name, x in own.items()
    }


def test_interfaces_of_parts_at_one_joint_coincide_at_every_position(checked):
    """Each place comes from another body's pose and its part's own length: 1e-6 mm of closing."""
    design, result = checked
    assert list(result.motion) == list(design.cycles)
    compared = 0
    for motion in result.motion.values():
        places = [interface_places(design, part, motion) for part in design.parts.values()]
        for one, other in combinations(places, 2):
            for joint in one.keys() & other.keys():
                assert_allclose(one[joint], other[joint], rtol=0, atol=1e-6)
                compared += 1
    assert compared >= 2


def test_pin_forces_are_those_of_the_checks_and_cancel_on_a_pin(checked):
    design, result = checked
    for name, motion in result.motion.items():
        links = result.cycles[name]["links"]
        assert set(motion.pins) == set(links)
        for label, pin in motion.pins.items():
            size = np.hypot(*pin.force.T)
            assert_allclose(size, np.asarray(links[label])[motion.index], rtol=1e-9, atol=1e-9)
        for part in design.parts.values():
            if part.body is None:
                on_pin = [pin.force for pin in motion.pins.values() if pin.on == part.name]
                largest = max(np.abs(force).max() for force in on_pin)
                assert_allclose(np.sum(on_pin, axis=0), 0, atol=1e-9 * largest)


def test_action_is_reaction_between_a_part_and_its_pin(checked):
    """What a lug does to the pin is the opposite of what the pin does to the lug, in one frame.

    The pin hands its own weight to the lug that it turns with, here at rest but for 1 % of it.
    """
    design, result = checked
    of_body = {part.body: part for part in design.parts.values() if part.body}
    compared = 0
    for motion in result.motion.values():
        for pin in design.parts.values():
            if pin.body is not None:
                continue
            for lug in pin.interfaces:
                part = of_body.get(lug)
                if part is None:
                    continue
                at = next(i for i, point in part.interfaces.items() if point == pin.joint)
                on_part = motion.pins[f"{part.name} {at}"].force
                on_pin = motion.pins[f"{pin.name} {lug}"].force
                weight = np.zeros(2)
                if pin.fixed_to == lug and design.stated_masses[lug].mass is None:
                    body = closed_body(pin.geometry)
                    weight = body.volume * pin.material.density * np.array(design.gravity)
                close = 1e-6 * np.abs(on_pin).max() + 0.01 * np.abs(weight).max()
                assert_allclose(on_part, weight - on_pin, atol=close)
                compared += 1
    assert compared >= 1


def test_a_sliding_force_acts_where_the_contact_is(checked):
    """The block of the quick return is in the lever's slot at its own point a, wherever that is."""
    design, result = checked
    if "slot" not in design.slides:
        return
    slide = design.slides["slot"]
    for motion in result.motion.values():
        contact = motion.point(slide.body_b, slide.point_b)
        assert_allclose(motion.pins["lever slot"].place, contact, atol=1e-6)
        assert np.ptp(motion.travel("slot")) > 10


def test_every_peak_and_both_ends_are_among_the_kept_positions(checked):
    _, result = checked
    for name, motion in result.motion.items():
        n = len(result.cycles[name]["position"])
        assert len(motion.index) <= MOST_POSITIONS
        assert motion.index[0] == 0
        assert motion.index[-1] == n - 1
        for peaks in result.cycles[name]["peaks"].values():
            assert int(np.argmax(peaks)) in motion.index


def test_parts_that_share_a_joint_do_not_stand_in_each_other_where_they_meet(checked):
    """At a joint of two parts, no stretch of z is filled by both."""
    design, result = checked
    motion = next(iter(result.motion.values()))
    surfaces = {part.name: part.surface for part in result.parts}
    bodies = [part for part in design.parts.values() if part.body is not None]
    for one, other in combinations(bodies, 2):
        for joint in set(one.interfaces.values()) & set(other.interfaces.values()):
            filled = []
            for part in (one, other):
                place = interface_places(design, part, motion)[joint][0]
                surface = surfaces[part.name]
                nodes = placed(motion, part.name, surface.nodes, 0)
                away = np.hypot(*(nodes[:, :2] - place).T)
                near = (away <= 1.05 * away.min())[surface.triangles].any(axis=1)
                z = nodes[surface.triangles[near], 2]
                filled.append(np.column_stack([z.min(axis=1), z.max(axis=1)]))
            low = np.maximum(filled[0][:, None, 0], filled[1][None, :, 0])
            high = np.minimum(filled[0][:, None, 1], filled[1][None, :, 1])
            assert (high <= low + 1e-9).all(), (one.name, other.name)


# the rod's frame runs from A to C, so the plate stands askew in it; and the crank as a plate
ASKEW = """
[forces.tug]
body = "rod"
at = "C"
direction = "1, 0"
"""
CRANK = PLATE.replace("parts.rod", "parts.crank").replace('"rod"', '"crank"')
CRANK = CRANK.replace('first = "A", second = "B"', 'first = "O", second = "A"')


def askew(folder):
    forces = 'cycles.turn.phases[0].forces={push="400 N", tug="0 N"}'
    pins = 'bodies.rod.pins=["A", "C", "B"]'
    return machine(folder, PLATE + ASKEW, 'points.C="40, 100 mm"', pins, forces)


def test_a_part_that_stands_askew_in_its_body_ends_at_its_second_joint(tmp_path):
    design = askew(tmp_path)
    part = design.parts["rod"]
    points = design.bodies["rod"].points
    assert abs(points["B"][1] - points["A"][1]) > 50
    cycle = solved(design)["turn"]
    frame = part_frame(design, part, cycle)
    along = np.stack([np.cos(frame[:, 2]), np.sin(frame[:, 2])], axis=1)
    length = np.hypot(*np.subtract(points["B"], points["A"]))
    assert_allclose(frame[:, :2], cycle.point("rod", "A"), atol=1e-9)
    assert_allclose(frame[:, :2] + length * along, cycle.point("rod", "B"), atol=1e-6)


def test_the_distance_from_a_joint_is_that_in_the_part_s_own_frame(tmp_path):
    design = askew(tmp_path)
    points = design.bodies["rod"].points
    length = np.hypot(*np.subtract(points["B"], points["A"]))
    nodes = np.array([[0.0, 0.0, 1.0], [length, 0.0, 2.0], [length, 5.0, -1.0]])
    skin = PartSkin(nodes, np.array([[0, 1, 2]]))
    rod = design.parts["rod"]
    assert_allclose(distance_from(design, rod, skin, "B"), [length, 0.0, 5.0], atol=1e-9)
    aside = distance_from(design, rod, skin, "C")
    assert aside[:2] == pytest.approx(
        [np.hypot(*np.subtract(points["C"], points[k])) for k in "AB"]
    )


def test_plates_side_by_side_stand_where_their_offsets_meet(tmp_path):
    """The crank's pin pushes 1 mm below its middle, the rod's 9 mm above its own."""
    offsets = ('parts.crank.offsets={second="-1 mm"}', 'parts.rod.offsets={first="9 mm"}')
    design = machine(tmp_path, CRANK + PLATE, *offsets)
    motion = check_design(design, effort=Effort("formula"), live=True).motion["turn"]
    assert "drawn aside" not in motion.layers_told
    assert motion.layer["rod"] - motion.layer["crank"] == pytest.approx(-1 - 9)
    assert motion.pins["crank second"].z == pytest.approx(motion.layer["crank"] - 1)
    assert motion.pins["rod first"].z == pytest.approx(motion.layer["rod"] + 9)
    assert motion.pins["rod second"].z == pytest.approx(motion.layer["rod"])


def test_an_eye_above_its_part_s_plane_is_at_its_lug_s_height_on_the_pin():
    lug = SimpleNamespace(body="rod", at=10.0, single=True)
    pin = SimpleNamespace(name="pin", body=None, joint="A", stack=[lug], interfaces={}, offsets={})
    rod = SimpleNamespace(
        name="rod", body="rod", joint=None, stack=[], interfaces={"eye": "A"}, offsets={},
        geometry=SimpleNamespace(heights={"eye": 4.0}),
    )  # fmt: skip
    design = SimpleNamespace(parts={"pin": pin, "rod": rod}, pins={"A": ("rod",)}, slides={})
    height, _ = layers(design, {})
    assert height["rod"] + 4.0 == pytest.approx(height["pin"] + 10.0)


def test_layers_are_as_stated_and_what_is_drawn_aside_is_told(checked):
    """The bars of the press have their cheeks at one height: the pin's stack cannot be drawn."""
    _, result = checked
    motion = next(iter(result.motion.values()))
    layer, told = motion.layer, motion.layers_told
    assert "as the pins' stacks and the offsets state it" in told
    if "crank" in layer and "pin_A" in layer:
        assert layer["rod"] - layer["crank"] == pytest.approx(10.5)
        assert layer["pin_A"] == layer["crank"]
        assert "drawn aside" not in told
    elif "lever" in layer:
        assert layer["rod"] - layer["lever"] == pytest.approx(17.25)
        assert "drawn aside so that parts do not stand in each other: crank by" in told
    else:
        assert layer["bar_lower"] != layer["bar_upper"]
        assert told.count("drawn aside so that parts do not stand in each other") == 1
        assert "each other: bar_lower by 6.5 mm." in told


def test_a_motion_survives_the_store_bit_for_bit(checked):
    _, result = checked
    for motion in result.motion.values():
        again = from_record(*to_record(motion))
        assert again.linkage == motion.linkage
        assert again.layer == motion.layer
        for name, pose in motion.parts.items():
            assert (again.parts[name] == pose).all()
        for label, pin in motion.pins.items():
            assert (again.pins[label].force == pin.force).all()


def test_a_check_that_nobody_looks_at_keeps_no_motion(tmp_path):
    """A batch without reports would carry some MB for each design."""
    assert check_design(machine(tmp_path), effort=Effort("formula")).motion == {}


def test_a_result_tells_of_cycles_without_motion(checked):
    _, result = checked
    assert motion_gaps(result) == []
    measured = replace(result, cycles={**result.cycles, "run on the rig": {}})
    (told,) = motion_gaps(measured)
    assert told.startswith("run on the rig: no motion is shown")


@pytest.mark.parametrize("n", [2, 361, 362, 729, 5000])
def test_kept_rows_hold_what_is_wanted_and_are_spread(n):
    phase_of = np.zeros(n, dtype=int)
    phase_of[n // 2 :] = 1
    rows = kept_rows(phase_of, [n // 3])
    assert len(rows) == min(n, MOST_POSITIONS)
    assert (np.diff(rows) > 0).all()
    assert {0, n - 1, n // 3, n // 2 - 1, n // 2} <= {*rows.tolist()}
    assert np.diff(rows).max() <= 2 * max(1, n / MOST_POSITIONS) + 1


def test_more_wanted_rows_than_may_be_kept_keep_the_first():
    rows = kept_rows(np.zeros(1000, dtype=int), range(900), most=10)
    assert len(rows) == 10
    assert {0, 999} <= {*rows.tolist()}


@pytest.mark.parametrize(("turns", "n"), [(1, 3601), (50, 3601), (50, 1201), (7, 362)])
def test_between_kept_rows_no_body_turns_by_more_than_six_degrees_if_it_can_be(turns, n):
    angle = np.linspace(0.0, 2 * np.pi * turns, n)
    turned = np.stack([angle, 0.3 * np.sin(angle)], axis=1)
    rows = kept_rows(np.zeros(n, dtype=int), [n // 3], turned=turned)
    each = 360 * turns / (n - 1)
    assert np.degrees(np.abs(np.diff(turned[rows], axis=0)).max()) <= max(6.0, each) + 1e-6
    assert {0, n - 1, n // 3} <= {*rows.tolist()}
    if turns == 1:
        assert len(rows) == MOST_POSITIONS
    place = 100 * np.stack([np.cos(angle), np.sin(angle)], axis=1)  # of a crank's pin
    shown = np.stack([np.interp(np.arange(n), rows, column[rows]) for column in place.T], axis=1)
    assert np.linalg.norm(shown - place, axis=1).max() < 0.15


def test_a_pair_of_lugs_presses_a_pin_at_its_own_heights_and_the_page_draws_half_at_each():
    """The press' cheeks at 42.95 and 32.65 mm on both sides of the cylinder's eye in the middle."""
    result = check_design(
        read_design(DESIGNS / "toggle_press.toml"), effort=Effort("formula"), live=True
    )
    motion = result.motion["press"]
    middle = motion.layer["pin_B"]
    for body, height in (("upper", 42.95), ("lower", 32.65)):
        assert_allclose(motion.pins[f"pin_B {body}"].halves, [middle - height, middle + height])
    assert motion.pins["pin_B cylinder"].halves == ()
    number_of = [part.name for part in result.parts].index("pin_B")
    drawn = [pin for pin in _motion(motion, result.parts)["pins"] if pin["on"] == number_of]
    assert sorted(pin["z"] - middle for pin in drawn) == pytest.approx(
        [-42.95, -32.65, 0.0, 32.65, 42.95]
    )
