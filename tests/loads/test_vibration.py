"""Natural frequencies of held linkages against closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import eigh

from loads import (
    GROUND,
    Angle,
    BeamCompliance,
    Body,
    Fixed,
    JointCompliance,
    Linkage,
    LinkageError,
    MatrixCompliance,
    Prismatic,
    Revolute,
    Slot,
    move,
    trace,
)
from loads.elasticity import LoadState, deflection
from loads.forces import unit_forces
from loads.vibration import _pivot, _pushed, cycle_modes, linkage_modes, load_strains

from .elastic_machines import PACK, elastic, forged, tip_stiffness
from .machine_hammer import HAMMER, hammer
from .transforms import in_mm_and_tonnes
from .vibrating import frequencies, on_carrier, springs

EI, EA, LENGTH, MASS = 2.0e9, 3.0e7, 800.0, 5e-3
TILTED = np.cos(0.3), np.sin(0.3)


def cantilever(body, tip=None, bending=EI, axial=EA):
    bodies, joints = [body], [Fixed("clamp", "carrier", "beam", "O")]
    places = {"beam": (0.0, 0.0, 0.0)}
    if tip is not None:
        bodies.append(tip)
        joints.append(Fixed("tip", "beam", "tip", "E"))
        places["tip"] = (LENGTH, 0.0, 0.0)
    compliance = (BeamCompliance("beam", bending, axial),)
    return on_carrier(bodies, joints, compliance, places)


def bar(mass=MASS, length=LENGTH):
    points = {"O": (0.0, 0.0), "E": (LENGTH, 0.0)}
    return Body("beam", points, mass, mass * length**2 / 12, (length / 2, 0.0))


def test_a_mass_on_a_spring_has_the_root_of_stiffness_over_mass_in_both_directions():
    found, _ = frequencies(springs([2e-3], [450.0]))
    assert_allclose(found[:2], np.sqrt(450.0 / 2e-3) / (2 * np.pi), rtol=1e-12)
    assert np.isinf(found[2:]).all()


@pytest.mark.parametrize("turn", [0.0, 0.7, -2.0])
def test_three_masses_on_springs_have_the_frequencies_of_their_stiffness_matrix(turn):
    """Each of the three twice, along and across; however the machine stands."""
    masses, k = [1e-3, 4e-3, 2e-3], [300.0, 900.0, 500.0]
    stiffness = np.diag([k[0] + k[1], k[1] + k[2], k[2]])
    stiffness -= np.diag(k[1:], 1) + np.diag(k[1:], -1)
    expected = np.sqrt(eigh(stiffness, np.diag(masses), eigvals_only=True)) / (2 * np.pi)
    found, _ = frequencies(springs(masses, k, turn))
    assert_allclose(found[:6], np.repeat(expected, 2), rtol=1e-10)
    assert np.isinf(found[6:]).all()


def test_a_tip_mass_on_a_massless_cantilever_bends_and_stretches_it():
    """3 E I / L3 across, E A / L along; with mass alone there is no third mode."""
    tip = Body("tip", {"E": (0.0, 0.0)}, 1e-2)
    found, _ = frequencies(cantilever(Body("beam", bar().points), tip))
    expected = np.sqrt(np.array([3 * EI / LENGTH**3, EA / LENGTH]) / 1e-2) / (2 * np.pi)
    assert_allclose(found[:2], expected, rtol=1e-10)
    assert np.isinf(found[2:]).all()


def test_a_tip_that_also_turns_has_the_two_frequencies_of_the_beams_stiffness():
    """Stiffness of a cantilever's end: 12, -6 L, 4 L2 times E I / L3."""
    tip = Body("tip", {"E": (0.0, 0.0)}, 1e-2, 900.0)
    found, _ = frequencies(cantilever(Body("beam", bar().points), tip, axial=None))
    end = EI / LENGTH**3 * np.array([[12, -6 * LENGTH], [-6 * LENGTH, 4 * LENGTH**2]])
    expected = np.sqrt(eigh(end, np.diag([1e-2, 900.0]), eigvals_only=True)) / (2 * np.pi)
    assert_allclose(found[:2], expected, rtol=1e-10)


def test_an_even_cantilevers_own_modes_come_out_of_its_mass_in_five_points():
    """Roots of cos cosh = -1: 1.87510, 4.69409 (Clough and Penzien, ch. 18).

    Measured 0.06 and 0.5 %.
    """
    found, _ = frequencies(cantilever(bar(), axial=None))
    unit = np.sqrt(EI / (MASS * LENGTH**3)) / (2 * np.pi)
    assert_allclose(found[0], 1.875104**2 * unit, rtol=1e-3)
    assert_allclose(found[1], 4.694091**2 * unit, rtol=1e-2)


def test_an_even_bar_stretches_with_a_quarter_wave():
    """Pi / 2 sqrt(E A / m L); all mass in the middle gives sqrt(2), 10 % less. Measured 0.6 %."""
    found, _ = frequencies(cantilever(bar(), bending=None))
    expected = np.pi / 2 * np.sqrt(EA / (MASS * LENGTH)) / (2 * np.pi)
    assert_allclose(found[0], expected, rtol=7e-3)


def test_a_rod_between_pins_swings_as_half_a_wave():
    """Pi2 sqrt(E I / m L3); all mass in the middle gives sqrt(48), 30 % less."""
    rod = bar()
    linkage = on_carrier(
        [rod],
        [Revolute("O", "carrier", "beam", "O"), Slot("E", "carrier", "beam", "E", "E", (1.0, 0.0))],
        (BeamCompliance("beam", EI),),
        {"beam": (0.0, 0.0, 0.0)},
        carrier_points={"E": (LENGTH, 0.0)},
    )
    found, _ = frequencies(linkage)
    assert_allclose(found[0], np.pi / 2 * np.sqrt(EI / (MASS * LENGTH**3)), rtol=1e-3)


def test_a_matrix_of_the_same_cantilever_has_the_same_frequency_as_the_beam():
    tip = Body("tip", {"E": (0.0, 0.0)}, 1e-2, 900.0)
    beam = cantilever(Body("beam", bar().points), tip, axial=None)
    matrix = np.zeros((6, 6))
    matrix[4:, 4:] = [[LENGTH**3 / 3, LENGTH**2 / 2], [LENGTH**2 / 2, LENGTH]]
    other = replace(beam, compliance=(MatrixCompliance("beam", ("O", "E"), matrix / EI),))
    assert_allclose(frequencies(other)[0][:2], frequencies(beam)[0][:2], rtol=1e-9)


def test_the_modes_carry_unit_mass_and_do_not_mix():
    """phi' M phi = 1 and phi' M F M phi = 1 / omega2, F from the unit loads' deformations."""
    _, modes = frequencies(cantilever(bar(), Body("tip", {"E": (0.0, 0.0)}, 1e-2, 900.0)))
    finite = np.isfinite(modes.frequencies[0])
    shapes, masses = modes.shapes[0][:, finite], np.diag(modes.lumps.masses)
    assert_allclose(shapes.T @ masses @ shapes, np.eye(finite.sum()), atol=1e-12)
    soft = modes.unit_strains[0].T @ modes.unit_strains[0]
    found = shapes.T @ masses @ soft @ masses @ shapes
    omega = 2 * np.pi * modes.frequencies[0][finite]
    assert_allclose(found * np.outer(omega, omega), np.eye(finite.sum()), atol=1e-7)
    trace_of = np.trace(masses @ soft)
    assert_allclose(np.sum(1 / omega**2), trace_of, rtol=1e-9)  # no mode is missing


def test_mean_motions_of_bodies_have_the_momentum_of_the_mode():
    """A tip mass on a massless beam moves across by 1 / sqrt(m), the carrier does not."""
    tip = Body("tip", {"E": (0.0, 0.0)}, 1e-2)
    _, modes = frequencies(cantilever(Body("beam", bar().points), tip))
    moved = modes.displacements[0, :, :, 0]
    assert_allclose(np.abs(moved[-1]), [0.0, 10.0, 0.0], atol=1e-9)
    assert_allclose(moved[:2], 0.0, atol=1e-9)


def test_deformations_give_the_same_work_as_virtual_forces_do():
    """F of the toggle's rigid bodies against `deflection` of the same unit loads."""
    linkage = replace(elastic(), friction={}, forces=elastic().forces)
    masses = {"mould": (1e-2, (0.0, 0.0), 0.0)}
    linkage = linkage.with_mass_properties(masses)
    hold = linkage.force("cylinder").coordinate
    path = trace(linkage, Angle("lower"), np.radians(50), np.radians(80))
    motion = move(path.at(np.radians([50.0, 65.0, 80.0])), hold, 1.0, 1)
    modes = linkage_modes(motion, hold)
    pushed = replace(motion, kinematics=type(motion.kinematics)(_pushed(linkage)))
    state = LoadState(unit_forces(pushed, ["push y of mould"], 1.0, "cylinder")[0], None)
    expected = deflection(motion.kinematics, motion.poses, state, state)
    way = int(np.flatnonzero(modes.lumps.way == 1)[0])
    found = np.sum(modes.unit_strains[:, :, way] ** 2, axis=1)
    assert_allclose(found, expected, rtol=1e-10)
    assert_allclose(modes.frequencies[:, 0] * 2 * np.pi, 1 / np.sqrt(1e-2 * found), rtol=1e-9)


LEAF = BeamCompliance("rocker", bending=PACK)


def hammer_modes(parameters=HAMMER):
    linkage = replace(hammer(parameters), compliance=(LEAF,), friction={})
    crank = Angle("crank")
    geometry = trace(linkage, crank, -3.0, 3.0).at(np.radians([-8.075]))
    return linkage_modes(move(geometry, crank, 1.0, 1), crank)


def test_the_hammers_ram_on_its_leaf_has_5_73_hertz_by_hand():
    """K = 51.66 N/mm at 427 mm from the pivot and 39.85 kg, the rocker level and without mass."""
    modes = hammer_modes(HAMMER | {"m3": 0.0, "I3R": 0.0, "m2": 0.0, "I2": 0.0})
    assert (
        abs(modes.motion.poses[0, 3, 2] % np.pi - np.pi) < 1e-3
        or abs(np.sin(modes.motion.poses[0, 3, 2])) < 1e-3
    )
    by_hand = np.sqrt(tip_stiffness(0.427) / 39.85) / (2 * np.pi)
    assert_allclose(by_hand, 5.73, atol=0.005)
    assert_allclose(modes.frequencies[0, 0], by_hand, rtol=1e-4)


def test_the_rockers_mass_slows_the_hammers_ram_as_rayleigh_has_it():
    """Its even bar moves with the leaf's deflection under the ram: energies by integration.

    Rayleigh's quotient is from above; the rod, which only stretches, is left rigid.
    """
    modes = hammer_modes()
    length, ram, rod = np.sqrt(12 * 0.995 / 14.623), 0.427, 0.46
    x = np.linspace(-length / 2, length / 2, 20001)  # along the leaf from the pivot, ram at +0.427
    moment = np.where(x < 0.0, ram * np.clip(1 + x / rod, 0.0, 1.0), np.clip(ram - x, 0.0, ram))
    slope = cumulative_trapezoid(moment / PACK, x, initial=0.0)
    v = cumulative_trapezoid(slope, x, initial=0.0)
    at_pivot, at_rod = (np.interp(place, x, v) for place in (0.0, -rod))
    v = v - at_pivot - (at_pivot - at_rod) / rod * x
    tip = np.interp(ram, x, v)
    assert_allclose(1 / tip, tip_stiffness(ram), rtol=1e-4)
    added = 14.623 / length * np.trapezoid((v / tip) ** 2, x)
    expected = np.sqrt(tip_stiffness(ram) / (39.85 + added)) / (2 * np.pi)
    assert_allclose(modes.frequencies[0, 0], expected, rtol=1e-3)
    assert expected < 5.60


def test_an_angle_that_no_torque_drives_is_held_at_its_pin():
    """A pedal with a mass m at its end L from the pin: a cantilever's sqrt(3 E I/(m L3))."""
    points = {"O": (0.0, 0.0), "E": (LENGTH, 0.0)}
    pedal = Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("pedal", points),
            Body("tip", {"E": (0.0, 0.0)}, MASS),
        ),
        joints=(Revolute("pin", GROUND, "pedal", "O"), Fixed("tip", "pedal", "tip", "E")),
        forces=(),
        assembled={"pedal": (0.0, 0.0, 0.3), "tip": (*LENGTH * np.array(TILTED), 0.3)},
        compliance=(BeamCompliance("pedal", bending=EI),),
    )
    found, _ = frequencies(pedal, Angle("pedal"))
    assert_allclose(found[0], np.sqrt(3 * EI / (MASS * LENGTH**3)) / (2 * np.pi), rtol=1e-9)


@pytest.mark.parametrize("turn", [1, -1])
def test_of_several_pins_the_one_at_the_origin_of_the_body_holds_its_angle(turn):
    pins = [Revolute("one", "rod", "lever", "A"), Revolute("other", "rod", "crank", "O")][::turn]
    bodies = [Body(name, {"A": (9.0, 0.0), "O": (0.0, 0.0)}) for name in ("rod", "lever", "crank")]
    linkage = SimpleNamespace(joints=pins, body={body.name: body for body in bodies}.get)
    assert _pivot(linkage, Angle("rod")) == "O"


def test_frequencies_do_not_depend_on_the_units_of_the_linkage():
    metres = replace(hammer(), compliance=(LEAF,))
    crank = Angle("crank")
    found = []
    small = replace(
        in_mm_and_tonnes(metres), compliance=(BeamCompliance("rocker", bending=PACK * 1e6),)
    )
    for linkage in (metres, small):
        geometry = trace(linkage, crank, -1.0, 1.0).at(np.array([0.0, 0.5]))
        found.append(linkage_modes(move(geometry, crank, 1.0, 1), crank).frequencies[:, 0])
    assert_allclose(found[0], found[1], rtol=1e-9)


def test_frequencies_are_those_of_the_place_however_fast_and_whichever_way_it_runs():
    linkage = replace(hammer(), compliance=(LEAF,))
    crank = Angle("crank")
    geometry = trace(linkage, crank, -1.0, 1.0).at(np.array([-0.5, 0.5]))
    found = [
        linkage_modes(move(geometry, crank, speed, way), crank).frequencies[:, 0]
        for speed, way in ((1.0, 1), (9.0, 1), (4.0, -1))
    ]
    assert_allclose(found[1], found[0], rtol=1e-12)
    assert_allclose(found[2], found[0], rtol=1e-12)


def test_deformations_of_a_cycles_loads_are_the_deflection_of_its_contact():
    """Against `deflection` under the ram; without inertia both lump the rocker at its pivot."""
    cycle = forged(parameters=HAMMER | {"I3R": 0.0})
    modes = cycle_modes(cycle)
    ram = int(np.flatnonzero(modes.lumps.bodies == 4)[1])
    assert modes.lumps.way[ram] == 1
    found = np.einsum("nr,nr->n", modes.unit_strains[:, :, ram], load_strains(modes, cycle))
    assert_allclose(found, cycle.contacts["work"].deflection, rtol=1e-9, atol=1e-12)


def test_modes_at_some_positions_are_those_of_the_whole_cycle_there():
    cycle = forged()
    some = np.array([0, 7, 3])
    alone, there = cycle_modes(cycle, some), cycle_modes(cycle).at(some)
    assert len(alone.frequencies) == 3
    assert_allclose(alone.frequencies, there.frequencies, rtol=1e-12)
    assert_allclose(alone.unit_strains, there.unit_strains, rtol=1e-9, atol=1e-15)


def test_a_linkage_without_elasticity_or_without_mass_is_refused():
    with pytest.raises(LinkageError, match="nothing of the linkage is elastic"):
        frequencies(replace(springs([1e-3], [1.0]), compliance=()))
    bare = springs([1e-3], [1.0])
    bare = bare.with_mass_properties(
        {name: (0.0, (0.0, 0.0), 0.0) for name in ("carrier", "mass 0")}
    )
    with pytest.raises(LinkageError, match="no body of the linkage has mass"):
        frequencies(bare)


def test_a_matrix_that_gives_energy_back_is_refused():
    tip = Body("tip", {"E": (0.0, 0.0)}, 1e-2)
    matrix = np.diag([0.0, 0.0, 0.0, 1e-3, -1e-4, 0.0])
    linkage = cantilever(Body("beam", bar().points), tip)
    linkage = replace(linkage, compliance=(MatrixCompliance("beam", ("O", "E"), matrix),))
    with pytest.raises(LinkageError, match="gives energy back"):
        frequencies(linkage)


def test_a_softer_joint_never_raises_a_frequency():
    soft = [frequencies(springs([1e-3, 2e-3], [k, 400.0]))[0][:4] for k in (100.0, 200.0, 400.0)]
    assert (np.diff(soft, axis=0) > 0.0).all()


def test_a_held_cylinder_holds_the_toggle_and_its_mould():
    """Near the dead centre the bars in line: 1/k = 2 L / E A + 1/400 under the mould."""
    linkage = elastic().with_mass_properties({"mould": (1e-2, (0.0, 0.0), 0.0)})
    hold = linkage.force("cylinder").coordinate
    path = trace(linkage, Angle("lower"), np.radians(80), np.radians(89.99))
    modes = linkage_modes(move(path.at(np.radians([80.0, 89.99])), hold, 1.0, 1), hold)
    stiffness = 1 / (500.0 / (210e3 * 1857.0) + 1 / 400e3)
    expected = np.sqrt(stiffness / 1e-2) / (2 * np.pi)
    assert_allclose(modes.frequencies[1, 0], expected, rtol=1e-5)
    assert JointCompliance("C", 400e3) in linkage.compliance


def test_a_mass_beside_the_beams_axis_bends_it_when_it_is_pulled_along():
    """Unit force along in the middle, 6 mm beside: half of L / E A + 36 mm2 L / E I."""
    body = Body("beam", bar().points, 1e-3, 0.0, (LENGTH / 2, 6.0))
    _, modes = frequencies(cantilever(body, Body("tip", {"E": (0.0, 0.0)}, 1e-2)))
    way = int(np.flatnonzero((modes.lumps.bodies == 2) & (modes.lumps.way == 0))[0])
    found = np.sum(modes.unit_strains[0, :, way] ** 2)
    assert_allclose(found, (LENGTH / EA + 36.0 * LENGTH / EI) / 2, rtol=1e-10)


@pytest.mark.parametrize("ends", [(0.0, 0.0), (0.5, 1.0), (0.0, 1.0)])
def test_a_rod_with_heavy_pins_swings_between_them_as_without(ends):
    """Pi^2 sqrt(E I / m L^3); the even bar of its mass and inertia was up to 73 % longer."""
    heavy = np.array([*ends]) * MASS
    mass = MASS + heavy.sum()
    centre = (MASS / 2 + heavy[1]) * LENGTH / mass
    inertia = MASS * (LENGTH**2 / 12 + (LENGTH / 2 - centre) ** 2)
    inertia += heavy @ np.array([centre, LENGTH - centre]) ** 2
    points = {"O": (0.0, 0.0), "E": (LENGTH, 0.0)}
    rod = Body("beam", points, mass, inertia, (centre, 0.0))
    slide = Body("shoe", {"E": (0.0, 0.0)})
    joints = [
        Revolute("O", "carrier", "beam", "O"),
        Revolute("E", "beam", "shoe", "E"),
        Prismatic("guide", "carrier", "shoe", "O", "E", (1.0, 0.0)),
    ]
    found, _ = frequencies(
        on_carrier(
            [rod, slide],
            joints,
            (BeamCompliance("beam", EI, None),),
            {"beam": (0.0, 0.0, 0.0), "shoe": (LENGTH, 0.0, 0.0)},
        )
    )
    assert_allclose(found[0], np.pi / 2 * np.sqrt(EI / (MASS * LENGTH**3)), rtol=1e-3)


def test_the_lumps_of_a_moving_beam_have_the_inertia_that_its_joints_feel():
    """The hammer's rod at 10 rad/s: all its loads, weight and inertia balance."""
    cycle = forged(speed=10.0, height=-1.0)
    rod = BeamCompliance("rod", PACK)
    cycle = replace(cycle, linkage=replace(cycle.linkage, compliance=(LEAF, rod)))
    modes = cycle_modes(cycle)
    own = modes.lumps.of(2)
    assert len(own) == 14
    loads = modes.lumps.inertia_loads(modes.motion)[:, own]
    found = np.einsum("nkd,nd->nk", modes.lumps.wrenches(cycle.poses[:, :, 2])[:, :, own], loads)
    joints = sum(load.force for load in cycle.body_loads("rod"))
    assert_allclose(found[:, :2], -joints, atol=1e-9 * np.abs(joints).max())
    centre = cycle.poses[:, 2, 2]
    arms = [0.6375 * np.stack([np.cos(centre), np.sin(centre)], axis=1) * s for s in (-1.0, 1.0)]
    turning = 0.0
    for load in cycle.body_loads("rod"):
        x, y = arms[0 if load.point == "B" else 1].T
        turning = turning + x * load.force[:, 1] - y * load.force[:, 0] + load.moment
    assert_allclose(found[:, 2], -turning, atol=1e-9 * np.abs(joints).max())
