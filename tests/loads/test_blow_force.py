"""Force of a blow against closed forms: one and two masses, plastic workpieces, Cox' beam."""

import numpy as np
import pytest

from loads import LinkageError, Struck
from loads.blow_force import blow_force

MASS, SPEED, STIFFNESS = 0.04, 400.0, 2e4  # t, mm/s, N/mm


def falling(struck, *, compliance=0.0, speed=SPEED):
    """A free mass strikes."""
    return blow_force(np.zeros(1), np.array([MASS**-0.5]), compliance, speed, struck)


def test_a_mass_leaves_an_elastic_workpiece_after_half_a_period_as_fast_as_it_came():
    found = falling(Struck(STIFFNESS))
    assert found.force.max() == pytest.approx(SPEED * np.sqrt(STIFFNESS * MASS), rel=1e-8)
    assert found.contact == pytest.approx(np.pi * np.sqrt(MASS / STIFFNESS), rel=1e-8)
    assert found.rebound == pytest.approx(SPEED, rel=1e-8)
    assert found.impulse == pytest.approx(2 * MASS * SPEED, rel=2e-3)
    assert (found.depth, found.energy) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert found.missing < 1e-9


def test_a_rigid_plastic_workpiece_takes_all_the_energy_at_its_yield_force():
    found = falling(Struck(yields=1e4))
    energy = 0.5 * MASS * SPEED**2
    assert found.contact == pytest.approx(MASS * SPEED / 1e4, rel=1e-9)
    assert found.depth == pytest.approx(energy / 1e4, rel=1e-9)
    assert found.energy == pytest.approx(energy, rel=1e-9)
    assert found.force.max() == 1e4
    assert found.rebound == 0.0


@pytest.mark.parametrize("behind", [0.0, 0.4, 1.0])
def test_an_elastic_plastic_workpiece_gives_its_elastic_part_back(behind):
    """A share of the compliance may be the linkage's; the workpiece keeps the plastic work."""
    whole = 1 / STIFFNESS
    struck = Struck(1 / ((1 - behind) * whole) if behind < 1 else np.inf, 5e3)
    found = falling(struck, compliance=behind * whole)
    elastic = 0.5 * 5e3**2 * whole
    assert found.force.max() == pytest.approx(5e3, rel=1e-8)
    assert found.depth == pytest.approx((0.5 * MASS * SPEED**2 - elastic) / 5e3, rel=1e-7)
    assert found.energy == pytest.approx(5e3 * found.depth, rel=1e-6)
    assert found.rebound == pytest.approx(5e3 * np.sqrt(whole / MASS), rel=1e-6)


def test_an_anvil_that_stands_on_nothing_is_the_second_of_two_masses():
    found = falling(Struck(STIFFNESS, anvil_mass=0.4, anvil_stiffness=1e-7))
    both = MASS * 0.4 / (MASS + 0.4)
    assert found.force.max() == pytest.approx(SPEED * np.sqrt(STIFFNESS * both), rel=1e-6)
    assert found.contact == pytest.approx(np.pi * np.sqrt(both / STIFFNESS), rel=1e-6)


def test_a_heavy_anvil_stands_still_and_a_light_one_on_a_stiff_bed_is_a_spring():
    """The anvil's own slow swing is no part of a blow; 1/k' = 1/k + 1/k_a without its mass."""
    still, heavy = (
        falling(Struck(STIFFNESS, anvil_mass=mass, anvil_stiffness=1.0 if mass else 0.0))
        for mass in (0.0, 1e6)
    )
    assert heavy.force.max() == pytest.approx(still.force.max(), rel=1e-6)
    assert heavy.times[-1] == pytest.approx(still.times[-1], rel=1e-6)
    light = falling(Struck(STIFFNESS, anvil_mass=1e-9, anvil_stiffness=1e6))
    soft = 1 / STIFFNESS + 1e-6
    assert light.force.max() == pytest.approx(SPEED * np.sqrt(MASS / soft), rel=1e-6)


def test_a_blow_that_is_over_before_the_modes_answer_is_not_resolved():
    """Contact of half a period, pi sqrt(m/k) = 1.6 ms, and 0.16 ms, before a mode of 3 kHz."""
    omega, along = np.array([0.0, 3e3 * 2 * np.pi]), np.array([0.99 / MASS, 0.01 / MASS]) ** 0.5
    slow, fast = (
        blow_force(omega, along, 0.0, SPEED, Struck(stiffness)) for stiffness in (1.6e5, 1.6e7)
    )
    assert slow.unresolved == pytest.approx(3 / (np.pi * np.sqrt(MASS / 1.6e5) * 3e3), rel=0.05)
    assert slow.unresolved < 1 < fast.unresolved


@pytest.mark.slow
def test_a_mass_that_strikes_a_light_beam_bends_it_as_cox_has_it():
    """Both go on with one speed, the beam in its static shape, of which 17/35 of the mass counts.

    u = 3 x/L - 4 (x/L)^3 up to midspan; the mean of u^2 is 17/35. So v' = v/(1 + 17/35 r), and the
    energy bends the beam by v' sqrt(M (1 + 17/35 r)/k), k = 48 E I / L^3. The beam's own modes
    n = 1, 3, 5 ... have omega = (n pi)^2 sqrt(E I/(m L^3)) and, at midspan, phi = +-sqrt(2/m).
    """
    x = np.linspace(0.0, 0.5, 20001)
    assert 2 * np.trapezoid((3 * x - 4 * x**3) ** 2, x) == pytest.approx(17 / 35, rel=1e-6)
    share, spring = 0.1, 500.0
    beam = share * MASS
    order = np.arange(1, 16, 2)
    omega = (order * np.pi) ** 2 * np.sqrt(spring / 48 / beam)
    along = np.sqrt(2 / beam) * (-1.0) ** (order // 2)
    found = blow_force(np.r_[0.0, omega], np.r_[MASS**-0.5, along], 0.0, SPEED, Struck(40 * spring))
    midspan = found.modal[:, 1:] @ along
    factor = 1 + 17 / 35 * share
    assert midspan.max() == pytest.approx(
        SPEED / factor * np.sqrt(MASS * factor / spring), rel=0.02
    )


def test_modes_without_a_say_are_left_out_and_stiff_ones_follow_statically():
    """A mass on a spring behind it, and stiff modes at the point that strikes: 1/k' = 1/k + c."""
    omega = np.r_[0.0, np.geomspace(1e5, 1e6, 40)]
    along = np.r_[MASS**-0.5, np.full(40, 1e5 * np.sqrt(1e-6 / 40))]
    found = blow_force(omega, along, 0.0, SPEED, Struck(STIFFNESS))
    assert found.kept < len(omega)
    soft = 1 / STIFFNESS + float((along[1:] ** 2 / omega[1:] ** 2).sum())
    assert found.force.max() == pytest.approx(SPEED * np.sqrt(MASS / soft), rel=1e-3)
    at = int(found.force.argmax())
    assert found.modal[at, -1] == pytest.approx(found.force[at] * along[-1] / omega[-1] ** 2)


def test_damping_takes_what_is_missing_from_the_rebound():
    """Energy given is found in modes, workpiece and damping; a spring behind is damped."""
    omega, along = np.array([0.0, 900.0]), np.array([0.2 / MASS, 0.9 / MASS]) ** 0.5
    loose = blow_force(omega, along, 0.0, SPEED, Struck(STIFFNESS), 0.0)
    damped = blow_force(omega, along, 0.0, SPEED, Struck(STIFFNESS), 0.1)
    assert max(loose.missing, damped.missing) < 1e-8
    assert damped.rebound < loose.rebound


def test_what_a_drive_presses_on_yields_until_it_is_no_longer_followed():
    """A spring behind the mass, which the drive presses on: the force stays where it yields."""
    found = blow_force(np.array([300.0]), np.array([MASS**-0.5]), 0.0, SPEED, Struck(2e3, 2e3))
    assert found.contact == np.inf
    assert found.lasts == found.times[-1]
    assert found.force[-1] == found.force.max() == pytest.approx(2e3)
    assert found.energy == pytest.approx(2e3 * found.depth, rel=1e-6)
    assert found.rebound == 0.0


def test_what_cannot_be_struck_is_refused():
    with pytest.raises(LinkageError, match="must yield or have a stiffness"):
        Struck()
    with pytest.raises(LinkageError, match="must be above 0"):
        Struck(-1.0)
    with pytest.raises(LinkageError, match="has a mass and a stiffness"):
        Struck(1.0, anvil_mass=1.0)
