"""Linkages that buckle as one: the toggle's two bars and its knee, forks, the worst position."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks.columns.link_joints import JointRows, forces_of
from checks.columns.linkage_frame import COARSE, FINE, least_factor, linkage_check, worst_mode
from checks.columns.linkage_search import IN, SOFT, STIFF, FreeMotions, Search
from checks.result.verdict import Status
from checks.stress.solid_mesh_level import Models
from fem.frame_joints import PlacedLinks
from tests.small_machine import MACHINE, machine, solved

DESIGNS = Path(__file__).parents[3] / "designs"
BAR = """
[parts.rod]
body = "rod"
shape = "tube_rod"
interfaces = { first = "A", second = "B" }
material = "S275"
tube_diameter = "8 mm"
eye_diameter = "14 mm"
eye_width = "8 mm"
hole = "6 mm"
fillet = "3 mm"
"""


def at_positions(cycle, count):
    return replace(cycle, run=replace(cycle.run, n_positions=count))


def press(name):
    """The full pull of a toggle press up to x = 2 mm; bars without mass, 0.3 % of the force."""
    design = read_design(DESIGNS / f"{name}.toml")
    cycle = at_positions(design.cycles["capacity"], 25)
    design = replace(design, cycles={"capacity": cycle})
    return design, solve_cycles(design, {})


def largest_compression(runs):
    bar = next(load for load in runs["capacity"].body_loads("upper") if load.point == "A")
    return float(np.hypot(*bar.force[-1]))


def pulled_sideways(runs, force):
    """Share of a half wave's stiffness that the pull of the cylinder, always towards D, adds.

    A half wave a of the column P of 500 mm does P pi^2 a^2 / 4 L, the pull T at B T a^2 / 2 l.
    """
    knee = runs["capacity"].point("lower", "B")[-1]
    distance = np.hypot(*(knee - np.array([-350.0, 250.0])))
    return 11e3 / distance * 2 * 500 / (np.pi**2 * force)


@pytest.mark.parametrize(
    ("name", "width", "euler", "status"),
    [
        ("toggle_press_30x30", 30.0, 3.30, Status.PASS),
        ("toggle_press_as_sized", 13.0, 0.217, Status.FAIL),
    ],
)
def test_both_bars_of_the_toggle_buckle_together_as_one_column_of_half_a_metre(
    name, width, euler, status
):
    """T-E6: Euler over 500 mm, with shear (Engesser), a kink that twists the bars, the pull at B.

    At the knee the bars meet at an angle: from the moment M sin of each half wave, tan(gamma) M
    twists both, which adds 2 tan^2(gamma) E I/G J to the flexibility.
    """
    design, runs = press(name)
    mode = worst_mode(design, runs)
    force = largest_compression(runs)
    inner = width - 3.2
    area, inertia = width**2 - inner**2, (width**4 - inner**4) / 12
    shear = 210e3 / 2.6
    column = np.pi**2 * 210e3 * inertia / 500**2
    assert_allclose(column / force, euler, rtol=5e-3)
    engesser = 1 / (1 / column + 1 / (shear * 20 / 48 * area))
    kink = 2 * (np.sqrt(1 - 0.996**2) / 0.996) ** 2  # cos(gamma) = 249/250
    kink *= 210e3 * inertia / (shear * 1.6 * (width - 1.6) ** 3)
    wanted = engesser / force / (1 + kink) / (1 - pulled_sideways(runs, force))
    assert_allclose(mode.factor, wanted, rtol=3e-3)
    assert (mode.plane, mode.cycle, mode.index) == ("out of plane", "capacity", 24)
    assert mode.position == "x = 2 mm full_pull"
    one = np.pi**2 * 210e3 * inertia / 250**2  # in plane: each bar for itself, the drive held
    assert_allclose(
        mode.other_plane, 1 / (1 / one + 1 / (shear * 20 / 48 * area)) / force, rtol=1e-3
    )
    assert_allclose([mode.shares["lower"], mode.shares["upper"]], 0.5, atol=0.01)
    assert_allclose(mode.places["lower"][0], mode.places["upper"][0], atol=1e-9)  # the knee
    assert_allclose(mode.shape["lower"][0, :3], mode.shape["upper"][0, :3], atol=1e-9)
    assert_allclose(np.abs(mode.shape["lower"][0, :3]), [0, 0, 1], atol=1e-9)
    check = linkage_check(design, mode)
    assert check.status == status
    assert (check.part, check.kind, check.limit) == ("linkage", "buckling", 1.0)
    assert check.value == pytest.approx(1 / mode.factor)
    assert check.below == pytest.approx(1 / mode.factor - 1 / mode.stiff_factor)


def test_the_toggle_as_built_is_so_stiff_that_the_cheeks_beside_its_cut_out_sway_first():
    """pi^2/2 E I/c^2 of 80 x 6.3 mm cheeks, free over 16 mm; the whole column has 180 by hand.

    Engesser with I = 1.68e6, A = 1.86e3: 1.40e7 N and 6.3e7 N give 1.14e7 N on 61.5 kN.
    """
    design, runs = press("toggle_press")
    mode = worst_mode(design, runs)
    cheek = 80 * 6.3**3 / 12
    wanted = np.pi**2 / 2 * 210e3 * cheek / 16**2 / largest_compression(runs)
    assert mode.plane == "out of plane"
    assert_allclose(mode.factor, wanted, atol=max(mode.error, 2e-3 * wanted))
    assert mode.error < 0.01 * mode.factor
    assert linkage_check(design, mode).status is Status.PASS


def test_the_pull_of_the_cylinder_holds_the_knee_sideways():
    design, runs = press("toggle_press_30x30")
    search = Search(design, runs, COARSE)
    pulled = search.factor("capacity", 24, SOFT)
    efforts = {**runs["capacity"].efforts, "cylinder": np.zeros(25)}
    without = Search(design, {"capacity": replace(runs["capacity"], efforts=efforts)}, COARSE)
    alone = without.factor("capacity", 24, SOFT)
    share = pulled_sideways(runs, largest_compression(runs))
    assert_allclose(alone / pulled, 1 - share, rtol=2e-3)


@pytest.mark.parametrize("turned", ["400 N", "-400 N"])
def test_no_position_has_a_lower_factor_than_the_one_that_is_told(tmp_path, turned):
    """All 25 positions one by one, in both planes, on the fine frame."""
    design = machine(
        tmp_path,
        BAR,
        f'cycles.turn.phases=[{{name="round", to="449 deg", '
        f'forces={{push="{turned}"}}, solve="drive"}}]',
    )
    runs = solved(design)
    mode = worst_mode(design, runs)
    search = Search(design, runs, FINE)
    factors = {
        (case.plane, k): search.factor("turn", k, case) for case in (IN, SOFT) for k in range(25)
    }
    known = {place: factor for place, factor in factors.items() if factor is not None}
    least = min(known, key=lambda place: known[place])
    assert (mode.plane, mode.index) == least or known[least] == pytest.approx(mode.factor, 1e-9)
    assert mode.factor == pytest.approx(known[least], rel=1e-9)


def test_no_position_of_any_case_is_worse_than_those_that_are_ranked_first():
    """Soft forks, stiff ones and in the plane; the largest force is where stiff forks hold best."""
    design = read_design(DESIGNS / "slider_crank.toml")
    name, *_ = design.cycles
    design = replace(design, cycles={name: at_positions(design.cycles[name], 25)})
    search = Search(design, solve_cycles(design, {}), COARSE)
    ranked = search.ranked()
    for case in (IN, SOFT, STIFF):
        worst = max(search.largest_inverses([(name, k) for k in range(25)], case).values())
        assert worst > 0
        assert ranked[case][0][0] == pytest.approx(worst, rel=1e-9)


def test_stiffer_forks_never_lower_the_factor(tmp_path):
    design = machine(tmp_path, BAR)
    runs = solved(design)
    search = Search(design, runs, COARSE)
    for k in range(25):
        soft = search.factor("turn", k, SOFT)
        stiff = search.factor("turn", k, STIFF)
        assert stiff is None or (soft is not None and soft <= stiff * (1 + 1e-9))


def test_stated_forks_have_the_bound_that_they_state_and_no_band(tmp_path):
    """Stiff ones the lower end of the check that knows neither, soft ones its value."""
    design = machine(tmp_path, BAR, 'cycles.turn.phases[0].to="449 deg"')  # else on a shaft
    runs = solved(design)
    unknown = linkage_check(design, worst_mode(design, runs))
    assert unknown.below > 0.1 * unknown.value
    for forks, value in (("soft", unknown.value), ("stiff", unknown.value - unknown.below)):
        stated = replace(design, forks=forks)
        mode = worst_mode(stated, runs)
        check = linkage_check(stated, mode)
        assert mode.forks == forks
        assert check.value == pytest.approx(value, rel=1e-9)
        assert check.below == check.model == 0.0
        assert f"{forks} forks as stated" in check.note


def test_the_rod_of_a_crank_and_slider_buckles_in_the_plane_between_its_hinges(tmp_path):
    """Euler and Engesser of 8 mm round steel, 161 mm long, in the plane; the crank is rigid."""
    design = machine(tmp_path, BAR)
    runs = solved(design)
    search = Search(design, runs, FINE)
    length = np.hypot(144, 72)
    area, inertia = np.pi * 16, np.pi * 4**4 / 4
    column = np.pi**2 * 210e3 * inertia / length**2
    critical = 1 / (1 / column + 1 / (210e3 / 2.6 * 6 / 7 * area))
    forces = search._forces["turn"].bars[1]
    for k in (4, 12, 20):
        axial = forces.axial(k)
        assert axial.max() < 0
        found = search.factor("turn", k, IN)
        assert_allclose(found, critical / -axial.mean(), rtol=3e-3)  # inertia varies along it


def test_a_drive_holds_its_body_at_the_pin_with_what_it_turns_against(tmp_path):
    """Whichever pin the body names first: the crank is a cantilever from O, as its shaft holds it.

    Held at A, where it sways, it would have the same Euler load but for the rod's own stiffness,
    which is 2e-4 here; a lever of three pins had 19 %.
    """
    text = """
[parts.crank]
body = "crank"
shape = "plate_link"
interfaces = { first = "O", second = "A" }
material = "S275"
width = "8 mm"
thickness = "8 mm"
hole = "4 mm"
"""
    factors = []
    for turned in (False, True):
        folder = tmp_path / str(turned)
        folder.mkdir()
        path = folder / "machine.toml"
        whole = MACHINE + text
        if turned:
            for old, new in (
                ('pins = ["O", "A"]', 'pins = ["A", "O"]'),
                ('start = "90 deg"', 'start = "270 deg"'),
                ('to = "450 deg"', 'to = "630 deg"'),
            ):
                assert old in whole
                whole = whole.replace(old, new)
        path.write_text(whole, encoding="utf-8")
        design = read_design(path)
        mode = worst_mode(design, solve_cycles(design, part_masses(design, Models())))
        assert mode.plane == "in plane"
        factors.append(mode.factor)
    assert_allclose(factors[0], factors[1], rtol=1e-6)


@pytest.mark.parametrize("forks", [None, "soft", "stiff"])
@pytest.mark.parametrize("name", ["toggle_press", "toggle_press_30x30"])
def test_the_factor_alone_is_that_of_the_mode(name, forks):
    design, runs = press(name)
    design = replace(design, forks=forks)
    mode = worst_mode(design, runs)
    assert_allclose(least_factor(design, runs, FreeMotions()), mode.factor, rtol=1e-12)


def test_twice_the_force_halves_the_factor():
    design, runs = press("toggle_press_30x30")
    run = runs["capacity"]
    twice = replace(
        run,
        reactions={
            name: replace(load, force=2 * load.force) for name, load in run.reactions.items()
        },
        efforts={name: 2 * effort for name, effort in run.efforts.items()},
    )
    one, two = (Search(design, {"capacity": r}, COARSE) for r in (run, twice))
    for case in (IN, SOFT):
        halves = two.factor("capacity", 24, case)
        assert halves == pytest.approx(one.factor("capacity", 24, case) / 2, rel=1e-9)


def test_runs_in_the_same_poses_share_the_motions_their_joints_leave_free(tmp_path, monkeypatch):
    """Other loads in other poses share nothing; each run has the factor it has alone."""
    solutions = []
    solve = PlacedLinks.unit_motions
    monkeypatch.setattr(
        PlacedLinks, "unit_motions", lambda *a: solutions.append(len(solutions)) or solve(*a)
    )
    design = machine(tmp_path, BAR, "cycles.turn.positions=25")
    turned = machine(tmp_path, BAR, "cycles.turn.positions=25", "cycles.turn.start=41 deg")
    run = solved(design)["turn"]
    pushed = {name: replace(f, force=3 * f.force) for name, f in run.reactions.items()}
    threefold = replace(
        run, reactions=pushed, efforts={name: 3 * effort for name, effort in run.efforts.items()}
    )
    motions = FreeMotions()
    for runs, shared in (
        ({"turn": run}, False),
        ({"turn": threefold}, True),
        (solved(turned), False),
    ):
        solutions.clear()
        together = worst_mode(design, runs, motions)
        assert (not solutions) == shared
        alone = worst_mode(design, runs)
        assert together.factor == pytest.approx(alone.factor, rel=1e-9)
        assert together.index == alone.index


def test_a_linkage_without_bars_or_cycles_has_no_mode(tmp_path):
    design = machine(tmp_path, "")
    assert worst_mode(design, solved(design)) is None
    assert worst_mode(design, {}) is None
    assert least_factor(design, solved(design), FreeMotions()) is None
    assert least_factor(design, {}, FreeMotions()) is None


@pytest.mark.parametrize("positions", [25, 1301])  # fewer and more than are asked at first
def test_a_linkage_that_is_only_pulled_has_no_mode(tmp_path, positions):
    """The crank points at the slider, which pulls both: nothing is compressed."""
    design = machine(
        tmp_path, BAR, f"cycles.turn.positions={positions}", 'points.A="60, 0 mm"',
        'points.B="220, 0 mm"', 'cycles.turn.start="0 deg"', 'cycles.turn.phases[0].to="20 deg"',
        'cycles.turn.phases[0].forces.push="-4000 N"',
    )  # fmt: skip
    runs = solved(design)
    (rod,) = (load for load in runs["turn"].body_loads("rod") if load.point == "B")
    assert (np.hypot(*rod.force.T) > 1e3).all()
    assert worst_mode(design, runs) is None


FOUR_BAR = """
name = "Four-bar"
points = { A = "0, 0 mm", B = "0, 60 mm", C = "200, 160 mm", D = "200, 0 mm" }
ground = ["A", "D"]
bodies.crank = { pins = ["A", "B"], mass = "0.5 kg", centre = "30, 0 mm", inertia = "1e-4 kg m2" }
bodies.rod = { pins = ["B", "C"] }
bodies.rocker = { pins = ["C", "D"], mass = "2 kg", centre = "80, 0 mm", inertia = "4e-3 kg m2" }
forces.motor = { turns = "crank", at = "A" }
forces.work = { body = "rocker", at = "C", direction = "-1, 0" }
[cycles.turn]
coordinate = "crank.angle"
start = "90 deg"
positions = 25
pace = { coordinate = "crank.angle", speed = "60 rpm" }
phases = [{ name = "turn", to = "450 deg", forces = { work = "2 kN" }, solve = "motor" }]
[duty]
cycles = { turn = 1e7 }
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "B", second = "C" }
material = "S355"
width = "30 mm"
thickness = "10 mm"
hole = "12 mm"
"""


def test_a_crank_that_turns_round_holds_a_four_bar_that_would_swing_about_its_supports(tmp_path):
    """Crank and rocker stand square to A-D at the start: soft forks at A and D let both swing.

    The shaft holds the crank upright, so the rod is built in at B: with C held by the rocker
    only along z, it lies between Euler's columns hinged and built in at one end, 223.6 mm.
    """
    (tmp_path / "four_bar.toml").write_text(FOUR_BAR, encoding="utf-8")
    design = read_design(tmp_path / "four_bar.toml")
    runs = solved(design)
    search = Search(design, runs, COARSE)
    search._forces = {
        name: forces_of(search.model, JointRows(search.model, run)) for name, run in runs.items()
    }
    with pytest.raises(ValueError, match="can move without strain"):
        search.factor("turn", 0, SOFT)
    mode = worst_mode(design, runs)
    assert mode.compression > 1e3
    assert mode.plane == "out of plane"
    assert 223.6 / 2 < mode.effective_length < 223.6 * 1.5


def test_a_four_bar_that_soft_forks_let_swing_about_its_supports_is_open(tmp_path, monkeypatch):
    """The same on pins in place of a shaft, its forks unstated: any other check goes on."""
    monkeypatch.setattr("checks.columns.linkage_search.shafts", lambda _: frozenset())
    (tmp_path / "four_bar.toml").write_text(FOUR_BAR, encoding="utf-8")
    design = read_design(tmp_path / "four_bar.toml")
    runs = solved(design)
    stiff = worst_mode(replace(design, forks="stiff"), runs)
    mode = worst_mode(design, runs)
    check = linkage_check(design, mode)
    assert (mode.factor, mode.loose, stiff.loose) == (stiff.factor, True, False)
    assert check.status is Status.UNDECIDED
    assert "no error bar: with soft forks the linkage moves out of the plane" in check.note
    assert least_factor(design, runs, FreeMotions()) == stiff.factor
    with pytest.raises(ValueError, match=r'without strain where .* state forks = "stiff"$'):
        worst_mode(replace(design, forks="soft"), runs)


@pytest.mark.slow
def test_a_crank_whose_block_nothing_else_holds_sideways_is_held_by_the_slot(monkeypatch):
    """Quick return, were its crank no shaft: it is pinned to the ground and to the block only."""
    monkeypatch.setattr("checks.columns.linkage_search.shafts", lambda _: frozenset())
    design = read_design(DESIGNS / "quick_return.toml")
    cycle = at_positions(design.cycles["at_10_loaded"], 37)
    design = replace(design, cycles={"at_10_loaded": cycle})
    mode = worst_mode(design, solve_cycles(design, {}))
    assert mode.slots_hold
    assert "slots hold sideways" in linkage_check(design, mode).note
    assert mode.body == "rod"


def test_without_a_mode_of_stiff_forks_nothing_of_the_load_share_is_certain(tmp_path):
    """What stiff forks hold altogether may hold: a share of 2 with soft ones is no failure yet."""
    design = machine(tmp_path, BAR)
    mode = replace(worst_mode(design, solved(design)), factor=0.5, stiff_factor=0.6, error=0.01)
    assert linkage_check(design, mode).status is Status.FAIL
    open_ended = linkage_check(design, replace(mode, stiff_factor=None))
    assert open_ended.below == open_ended.value == 2.0
    assert open_ended.status is Status.UNDECIDED


def test_bodies_that_are_no_bars_are_named_as_rigid(tmp_path):
    design = machine(tmp_path, BAR)
    mode = worst_mode(design, solved(design))
    assert mode.rigid == ("crank", "slider")
    assert linkage_check(design, mode).note.endswith("; taken as rigid: crank, slider")


def test_round_off_along_the_bars_is_no_load(tmp_path):
    """400 N on the slider; joint forces of 1e-14 of their size are what a solution leaves of none.

    Taken for a load, they had a factor of 1e16; of larger ones the count of modes failed.
    """
    design = machine(tmp_path)
    (run,) = solved(design).values()

    def with_forces(share):
        loads = {
            name: replace(load, force=share * load.force, moment=share * load.moment)
            for name, load in run.reactions.items()
        }
        return {"turn": replace(run, reactions=loads)}

    assert worst_mode(design, with_forces(1e-14)) is None
    small, whole = (worst_mode(design, with_forces(share)) for share in (1e-6, 1.0))
    assert small.factor == pytest.approx(1e6 * whole.factor, rel=1e-6)


LEVER = """
name = "Pedal"
ground = ["O"]
[points]
O = "0, 0 mm"
A = "200, 0 mm"
[bodies.pedal]
pins = ["O", "A"]
mass = "0.5 kg"
inertia = "1e-3 kg m2"
centre = "75, 0 mm"
[forces.drive]
turns = "pedal"
at = "O"
[forces.foot]
body = "pedal"
at = "A"
direction = "-1, 0"
[cycles.step]
coordinate = "pedal.angle"
start = "0 deg"
pace = { coordinate = "pedal.angle", speed = "1 rad/s" }
positions = 25
phases = [{ name = "down", to = "-20 deg", forces = { foot = "400 N" }, solve = "drive" }]
[parts.pedal]
body = "pedal"
shape = "plate_link"
interfaces = { first = "O", second = "A" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
"""


def test_a_lever_on_one_pin_is_held_by_its_bearing(tmp_path):
    """A flagpole of 200 mm under 400 N along it: Euler with twice its length.

    Its weight and inertia make some 1 % of the force. Without a bearing it could tilt about the
    pin without strain, and the whole check ended there.
    """
    path = tmp_path / "pedal.toml"
    path.write_text(LEVER, encoding="utf-8")
    design = read_design(path)
    mode = worst_mode(design, solve_cycles(design, {}))
    euler = pi**2 * 210e3 * 30 * 8**3 / 12 / (4 * 200.0**2)
    assert mode.plane == "out of plane"
    assert mode.factor == pytest.approx(euler / 400.0, rel=0.02)


STIFF_CRANK = (
    BAR
    + """
[materials.steel]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
density = "7850 kg/m3"
yield_stress = "275 MPa"
ultimate_stress = "410 MPa"
[parts.crank]
body = "crank"
shape = "plate_link"
interfaces = { first = "O", second = "A" }
material = "steel"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
"""
)


def test_a_bar_a_billion_times_as_stiff_as_another_leaves_the_mode_its_digits(tmp_path):
    """Fuzz: leaves 6 m wide beside a rod of 20 mm ended as a SolverError, no mode below itself.

    A crank that does not bend is a rigid body: the factor tends to that of one, from below.
    """
    rigid = machine(tmp_path, BAR)
    alone = worst_mode(rigid, solved(rigid))
    design = machine(tmp_path, STIFF_CRANK, "parts.crank.thickness=4000 mm")
    mode = worst_mode(design, solved(rigid))
    assert (mode.cycle, mode.index, mode.plane) == (alone.cycle, alone.index, alone.plane)
    assert_allclose(mode.factor, alone.factor, rtol=2e-3)
    assert mode.error >= abs(mode.factor - alone.factor)


def test_bars_that_double_precision_cannot_hold_together_are_named(tmp_path):
    """The crank rocks, so no shaft holds it: all that stops it out of plane is the rod."""
    rocks = (
        'cycles.turn.phases=[{ name = "there", to = "270 deg", forces = { push = "400 N" }, '
        'solve = "drive" }]'
    )
    design = machine(tmp_path, STIFF_CRANK, "parts.crank.thickness=4e6 mm", rocks)
    with pytest.raises(
        loads.LinkageError,
        match=r"as far as double precision tells: crank is \S+ times as stiff against bending as "
        "rod; check the sections and lengths of both",
    ):
        worst_mode(design, solved(machine(tmp_path, BAR, rocks)))
