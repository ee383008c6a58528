"""Proportions of parts and loads within those of the solids that a rung was compared with."""

from dataclasses import replace

import numpy as np
import pytest

from checks.design.effort import AUTO
from checks.ladder.climb import climb_cheap, start_climb
from checks.models import bands, shapes
from checks.models.bands import ARC, SHARE, proportions_of, unknown_load
from checks.models.shapes import family_of
from checks.part.loaded_part import LoadedPart
from geometry.parts import Pin, Seat

from ...small_machine import loads_of, machine
from .wide_bands import bands_of

PULLED = {"first": [[-10.0, 0.0, 0.0]] * 4, "second": [[10.0, 0.0, 0.0]] * 4}
ROD = """
[parts.rod]
body = "rod"
shape = "tube_rod"
interfaces = { first = "A", second = "B" }
material = "S275"
tube_diameter = "14 mm"
wall = "1.6 mm"
eye_diameter = "24 mm"
eye_width = "17 mm"
hole = "10 mm"
fillet = "5 mm"
"""


@pytest.fixture
def plate(tmp_path):
    return machine(tmp_path).parts["rod"]


def turned_round(wrenches):
    return {name: [[-value for value in row] for row in rows] for name, rows in wrenches.items()}


def test_a_pushed_part_is_not_like_a_pulled_one(plate):
    pulled = proportions_of(plate, loads_of(PULLED))
    pushed = proportions_of(plate, loads_of(turned_round(PULLED)))
    assert (pulled[SHARE + "pulled"], pulled[SHARE + "pushed"]) == (1.0, 0.0)
    assert (pushed[SHARE + "pulled"], pushed[SHARE + "pushed"]) == (0.0, 1.0)


def test_loads_across_and_couples_are_told_over_the_largest_force(plate):
    """50 N and 30 N across over 50 N; 800 N mm over 50 N times the length of 161 mm."""
    bent = {"first": [[-40.0, -30.0, 800.0]] * 2, "second": [[40.0, 30.0, 0.0]] * 2}
    found = proportions_of(plate, loads_of(bent))
    assert found[SHARE + "across"] == pytest.approx(0.6)
    wanted = 800.0 / (50.0 * plate.geometry.length)
    assert found[SHARE + "couple over its size"] == pytest.approx(wanted)


def test_which_interface_is_the_second_one_decides_no_proportion(plate):
    """What inertia takes of a force along the rod counts at the end that has more of it."""
    loads = {"first": [[-100.0, 5.0, 0.0], [30.0, 5.0, 0.0]],
             "second": [[60.0, -5.0, 0.0], [-90.0, -5.0, 0.0]]}  # fmt: skip
    other = turned_round({"first": loads["second"], "second": loads["first"]})
    found, again = (proportions_of(plate, loads_of(one)) for one in (loads, other))
    assert found == pytest.approx(again)
    assert found[SHARE + "pulled"] == pytest.approx(100.0 / np.hypot(100.0, 5.0))
    assert found[SHARE + "pushed"] == pytest.approx(90.0 / np.hypot(100.0, 5.0))


def test_the_arc_of_contact_is_one_of_them(plate):
    narrow = replace(plate, bearing_arc=np.radians(31.0))
    assert proportions_of(narrow, loads_of(PULLED))[ARC] == pytest.approx(31.0)


def test_a_rod_between_forks_beside_each_other_has_no_bars_and_goes_to_the_solid(tmp_path):
    design = machine(tmp_path, ROD)
    loads = loads_of(PULLED)
    rod = design.parts["rod"]
    assert not unknown_load(rod, loads)
    loads.wrenches["first"][:, 4] = 400.0  # N mm, as an offset of 40 mm gives
    assert "couples out of the plane, up to 400 N mm" in unknown_load(rod, loads)
    state = start_climb(LoadedPart(design, rod, loads))
    assert climb_cheap(state, AUTO)
    assert all("couples" in c.note for tried in state.tried for c in tried.checks)


def test_a_plate_far_beside_its_forces_is_not_like_those_compared(tmp_path):
    """The formula's 33.7 + 3.0 MPa against 39.9 of a solid: 21.3 mm beside a width of 20 mm.

    Solids were compared up to 0.57 of the force times the width; the shipped crank has 0.46.
    """
    design = machine(tmp_path)
    plate = design.parts["rod"]
    width = plate.geometry.width
    for arm, known in ((0.45, True), (0.94, False)):
        loads = loads_of(PULLED)
        loads.wrenches["first"][:, 4] = 10.0 * arm * width
        name = "couple out of the plane / force x width"
        scales = {name: proportions_of(plate, loads)[name]}
        assert scales[name] == pytest.approx(arm)
        for kind in ("static", "fatigue"):
            found = bands.band_of(family_of(plate, loads, kind), "formula", kind, scales)
            assert isinstance(found, bands.Band) is known
    assert "couple out of the plane / force x width is 0.94" in found.why


BAR = """
[parts.rod]
body = "rod"
shape = "toggle_bar"
interfaces = { knee = "A", end = "B" }
material = "S355"
width = "60 mm"
wall = "5 mm"
inner_radius = "3 mm"
hole = "34 mm"
overhang = "36 mm"
cutout_length = "48 mm"
cutout_corner = "5 mm"
bearing_arc = "90 deg"
"""


def test_a_bar_that_couples_turn_to_and_fro_under_a_steady_push_has_no_bar_of_fatigue(tmp_path):
    """The bar of 161 mm is pushed by 8 kN, with the couple of a friction of 0.3, and 0.29 of it.

    Between 140 mm a solid swings by 14.8 MPa under it, the formula by 10.2 + 4.0. Where the push
    swings, too, the solid has 25.3, the formula 23.9 + 3.3.
    """
    design = machine(tmp_path, BAR)

    def judged(first, second):
        rows = [[push, 0.0, share * push * 17.0] for push, share in (first, second)]
        loads = loads_of({"knee": rows, "end": [[-x, 0.0, -couple] for x, _, couple in rows]})
        state = start_climb(LoadedPart(design, design.parts["rod"], loads))
        state.by_formula()
        return state.best["static"].check, state.best["fatigue"].check

    static, fatigue = judged((8000.0, 0.29), (8000.0, -0.29))
    assert np.isfinite(static.model)
    assert fatigue.model == np.inf
    assert "couples swing by up to 78.9 N m in bores whose forces swing by up to" in fatigue.note
    for check in judged((8000.0, 0.29), (80.0, 0.0)):
        assert np.isfinite(check.model)
    static, fatigue = judged((8000.0, 0.4), (80.0, 0.0))
    assert static.model == fatigue.model == np.inf
    assert "couples are up to 54.4 N m in bores whose forces are up to 8000 N" in static.note


def test_a_plate_knows_couples_out_of_its_plane(plate):
    loads = loads_of(PULLED)
    loads.wrenches["first"][:, 4] = 400.0
    assert not unknown_load(plate, loads)


def test_a_rung_that_lost_some_of_the_loads_has_no_bars(tmp_path, plate, monkeypatch):
    monkeypatch.setattr(bands, "_data", lambda: bands_of(formula=0.1))
    design, build = machine(tmp_path), shapes.model_of

    def leaving(part, loads):
        return replace(build(part, loads), residual=2e-6)

    monkeypatch.setattr(shapes, "model_of", leaving)
    state = start_climb(LoadedPart(design, plate, loads_of(PULLED)))
    state.by_formula()
    check = state.best["static"].check
    assert "leaves 2e-06 of the loads" in check.note
    assert check.model == np.inf
    assert "static" in state.open


def test_a_pin_in_single_and_paired_lugs_is_a_family_of_its_own(tmp_path, plate):
    seats = (Seat("a", width=10.0, at=20.0), Seat("b", width=8.0, at=11.0, single=True))
    part = replace(plate, geometry=Pin(diameter=12.0, seats=seats))
    names = {"a": [[1.0, 0.0, 0.0]], "b": [[-1.0, 0.0, 0.0]]}
    assert family_of(part, loads_of(names), "static").endswith("in single and paired lugs")
