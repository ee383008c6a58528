"""The machines in designs/ solved as their files state them, against independent numbers."""

import pickle
import random
import re
from pathlib import Path

import numpy as np
import pytest

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import linkage_of

DESIGNS = Path(__file__).parents[3] / "designs"
# of bars without a part to take them from: mass t, centre mm, inertia t mm2 of a slender bar
BAR = (4.14134e-3, (125.0, 0.0), 4.14134e-3 * 250.0**2 / 12)


def solved(design, cycle):
    stated = design.cycles[cycle]
    bars = {name: BAR for name in ("upper", "lower") if name in design.bodies}
    linkage = linkage_of(design, bars, stated)
    return loads.run_cycle(linkage, stated.run)


@pytest.mark.parametrize(
    ("machine", "cycle", "low", "high", "digit"),
    [
        ("spring_hammer", "at_3", -47.74, 50.66, 0.005),
        ("spring_hammer", "at_5", -50.24, 54.57, 0.005),
        ("spring_hammer", "at_6", -53.03, 58.56, 0.005),
        ("spring_hammer", "at_10", -75.65, 87.67, 0.005),
        ("quick_return", "at_4", -6.6, 0.9, 0.05),
    ],
)
def test_the_torque_of_the_drive_goes_as_far_as_an_independent_solution(
    machine, cycle, low, high, digit
):
    """Newton-Euler solutions of the machines' rigid linkages; half a unit of the last digit."""
    torque = solved(read_design(DESIGNS / f"{machine}.toml"), cycle).efforts["drive"] / 1e3
    assert (torque.min(), torque.max()) == pytest.approx((low, high), abs=digit)


def test_the_quick_return_needs_ten_times_the_torque_under_its_blow():
    """Independent solution: 68 N m with 200 N on the hammer at 4 rad/s."""
    design = read_design(DESIGNS / "quick_return.toml")
    assert solved(design, "at_4_loaded").efforts["drive"].max() == pytest.approx(68e3, abs=500)


def test_the_slider_crank_works_against_its_weight_only():
    """Independent solution at 1 rad/s: weights 0.0705 N m, inertia 0.0017 N m at most."""
    torque = solved(read_design(DESIGNS / "slider_crank.toml"), "bench").efforts["drive"]
    assert np.abs(torque).max() == pytest.approx(70.5, abs=1.7)


@pytest.mark.parametrize(
    ("file", "force"), [("toggle_press", 61184.0), ("toggle_press_friction", 51278.0)]
)
def test_friction_takes_a_sixth_of_the_toggle_press_force(file, force):
    """Independent solution at x = 2 mm with 11 kN of pull: 61 184 N, with friction 51 278 N."""
    press = solved(read_design(DESIGNS / f"{file}.toml"), "press")
    assert press.efforts["process"].max() == pytest.approx(force, abs=1.0)


def test_the_rigid_workpiece_of_the_hammer_is_pressed_by_the_leaves_only():
    """Twice the height, twice the bending: the blow grows by k cos2, 45.8 N/mm x 0.907 x 10 mm.

    The stiffness at the lower dead centre is n 3 E I / (x2 (x + l3)); the ram's weight hangs on
    both, and the rocker's speed of turning changes little: 1 %.
    """
    design = read_design(DESIGNS / "spring_hammer.toml")
    ten, twenty = (
        solved(design, cycle).efforts["workpiece"].max()
        for cycle in ("at_5_work_10", "at_5_work_20")
    )
    assert twenty - ten == pytest.approx(45.8 * 0.907 * 10, rel=1e-2)


def test_the_order_of_tables_in_a_file_does_not_matter(tmp_path):
    """Round-off only: the unknowns of the linkage stand in another order."""
    text, chance = (DESIGNS / "quick_return.toml").read_text(), random.Random(3)
    head, *sections = re.split(r"\n(?=\[)", text)
    wanted = solved(read_design(DESIGNS / "quick_return.toml"), "at_10_loaded").efforts["drive"]
    for number in range(3):
        chance.shuffle(sections)
        file = tmp_path / f"shuffled_{number}.toml"
        file.write_text("\n".join([head, *sections]))
        torque = solved(read_design(file), "at_10_loaded").efforts["drive"]
        assert torque == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("file", sorted(DESIGNS.glob("*.toml")), ids=lambda file: file.stem)
def test_a_design_survives_the_way_between_processes_and_assumes_what_it_says(file):
    design = read_design(file)
    copied = pickle.loads(pickle.dumps(design))
    assert (copied.cycles, copied.joints, copied.sources) == (
        design.cycles,
        design.joints,
        design.sources,
    )
    assert all(reason for _, reason in design.assumed)
