"""Vibration added to a cycle, against exact solutions of the equation of motion."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from loads import Angle, LinkageError
from loads.harmonics import (
    SAMPLES,
    CycleResponse,
    _response,
    cycle_response,
    dynamic_factor,
    rise_of,
    sampled,
    with_vibration,
)
from loads.vibration import _most_alike, followed, linkage_modes, motion_of

from .elastic_machines import forged
from .vibrating import once_along, shaken, springs

MASS, STROKE, TIME = 2e-3, 50.0, 0.5  # the foot's cycle takes 2 TIME


def spring(ratio):
    """Stiffness that gives the mass its frequency at 1 / ratio of the cycle's rate."""
    return MASS * (np.pi / TIME / ratio) ** 2


def along(response):
    """The mode along the rail; the one across it is never excited."""
    return max(response.responses, key=lambda mode: mode.share)


def test_the_hammers_harmonics_three_and_four_at_10_rad_s_amplify_as_by_hand():
    """Undamped, 5.73 Hz: +3.3 and -4.3."""
    ratios = np.array([3.0, 4.0]) * 10.0 / (2 * np.pi * 5.73)
    factors = dynamic_factor(ratios, 0.0)
    assert_allclose(factors.real, [3.3, -4.3], atol=0.05)
    assert_allclose(factors.imag, 0.0, atol=1e-15)


def test_in_resonance_the_factor_is_one_over_twice_the_damping_a_quarter_turn_behind():
    assert_allclose(dynamic_factor(1.0, 0.02), -25.0j)


@pytest.mark.parametrize(("ratio", "damping"), [(0.3, 0.02), (0.9, 0.05), (1.6, 0.1), (0.995, 0.2)])
def test_a_shaken_mass_moves_as_the_integrated_equation_of_motion(ratio, damping):
    """One harmonic: x'' + 2 zeta omega x' + omega2 x = -foot'', until it has settled.

    Loads are linear between 4000 positions, 0.015 s apart where the foot turns: 1e-4 of them.
    """
    stiffness = spring(ratio)
    cycle = shaken(MASS, stiffness, STROKE, TIME)
    found = along(cycle_response(cycle, damping))
    omega, rate = np.sqrt(stiffness / MASS), np.pi / TIME

    def motion(t, state):
        foot = STROKE / 2 * rate**2 * np.cos(rate * t)
        return [state[1], -2 * damping * omega * state[1] - omega**2 * state[0] - foot]

    settled = np.ceil(30.0 / (damping * omega) / (2 * TIME)) * 2 * TIME
    exact = solve_ivp(
        motion, (0, settled + 2 * TIME), [0.0, 0.0], rtol=1e-9, atol=1e-9, dense_output=True
    ).sol(settled + found.times)[0]
    # the response is the root of twice the energy: omega sqrt(m) x, of either sign
    scaled = exact * omega * np.sqrt(MASS)
    sign = np.sign(scaled @ found.dynamic)
    assert_allclose(sign * found.dynamic, scaled, atol=2e-4 * np.abs(scaled).max())
    assert_allclose(found.amplification, abs(dynamic_factor(ratio, damping)), rtol=3e-4)
    assert_allclose(found.deviation, abs(dynamic_factor(ratio, damping) - 1), atol=1e-3)
    assert [one.number for one in found.harmonics if one.amplitude > 1e-3] == [1]


@pytest.mark.parametrize("forces", [("drive",), ("brake", "drive"), ("drive", "brake")])
def test_loads_with_vibration_are_those_of_the_mass_that_really_moves(forces):
    """The spring's force is k x of the exact solution, the drive's what shakes both.

    A given force along the drive's coordinate stays as given, wherever it is listed.
    """
    ratio, damping = 0.7, 0.05
    cycle = shaken(MASS, spring(ratio), STROKE, TIME, forces)
    vibrating = with_vibration(cycle, cycle_response(cycle, damping))
    rate = np.pi / TIME
    size = STROKE / 2 * rate**2
    factor = dynamic_factor(ratio, damping)
    exact = MASS * size * (factor * np.exp(1j * rate * cycle.times)).real
    assert_allclose(
        cycle.reactions["spring 0"].force[:, 0], MASS * size * np.cos(rate * cycle.times)
    )
    force = vibrating.reactions["spring 0"].force[:, 0]
    assert_allclose(force, exact, atol=1e-3 * np.abs(exact).max())
    shaken_too = vibrating.efforts["drive"] - cycle.efforts["drive"]
    assert_allclose(shaken_too, force - cycle.reactions["spring 0"].force[:, 0], atol=1e-9)
    for name in set(forces) - {"drive"}:
        assert (vibrating.efforts[name] == 7.0).all()


def test_loads_with_vibration_keep_every_body_in_equilibrium():
    cycle = forged(speed=10.0, height=-1.0)
    vibrating = with_vibration(cycle, cycle_response(cycle, 0.02))
    assert max(vibrating.equilibrium_residual.values()) < 1e-12
    assert vibrating.power_balance_error < 1e-9
    at_pivot = [np.hypot(*c.reactions["R"].force.T).max() for c in (cycle, vibrating)]
    assert at_pivot[1] > 1.3 * at_pivot[0]


def test_the_joint_forces_of_vibration_deform_the_modes_by_what_their_responses_differ():
    cycle = forged(speed=10.0, height=-1.0)
    response = cycle_response(cycle, 0.02)
    again = cycle_response(with_vibration(cycle, response), 0.02)
    first, second = response.responses[0], again.responses[0]
    top = np.abs(first.dynamic).max()
    # the leaf's mass moves with its body as a whole in the second one, and bent in the first
    assert_allclose(second.slow, first.dynamic, atol=2e-2 * top)
    assert np.abs(first.slow - first.dynamic).max() > 0.3 * top


def test_a_slow_machine_is_not_amplified_and_a_fast_one_is():
    found = [
        along(cycle_response(shaken(MASS, spring(r), STROKE, TIME), 0.02)) for r in (0.01, 0.5)
    ]
    assert found[0].deviation < 1e-3
    assert_allclose(found[1].deviation, 1 / 3, atol=2e-3)


def test_a_machine_far_above_resonance_is_not_called_quasi_static():
    """The response shrinks, and is nothing like the slow one."""
    found = along(cycle_response(shaken(MASS, spring(5.0), STROKE, TIME), 0.02))
    assert found.amplification < 0.05
    assert found.deviation > 1.0


def test_the_worst_frequency_lies_in_the_range_over_the_cycle():
    response = cycle_response(forged(speed=10.0, height=-1.0), 0.02)
    first = response.responses[0]
    assert first.lowest <= first.worst <= first.highest
    assert first.highest / first.lowest > 1.05
    assert first.share > 0.99
    third = next(one for one in first.harmonics if one.number == 3.0)
    assert_allclose(third.factor, abs(dynamic_factor(30 / (2 * np.pi * first.worst), 0.02)))


def test_a_sudden_load_overshoots_as_the_step_response_has_it_and_a_slow_one_does_not():
    """1 + exp(-pi zeta / sqrt(1 - zeta2)) of a step; a rise of eight periods has next to nothing.

    The step before has left 0.2 %; a step between two samples is a part of one early, 1 % of 1/20.
    """
    times = np.array([0.0, 1.0, 1.0, 2.0])
    values = np.array([0.0, 0.0, 1.0, 1.0])
    peaks = []
    for rise in (0.0, 0.4):
        even, samples, jump = sampled(times, values, rise)
        spectrum = np.fft.rfft(samples)
        factor = dynamic_factor(np.arange(len(spectrum)) / 2.0 / 19.77, 0.05)
        peaks.append(np.fft.irfft(spectrum * factor, SAMPLES).max())
        assert jump == 1.0
        assert_allclose(np.diff(even), 2.0 / SAMPLES)
    assert_allclose(peaks[0], 1 + np.exp(-np.pi * 0.05 / np.sqrt(1 - 0.05**2)), atol=5e-3)
    assert_allclose(peaks[1], 1.0, atol=5e-3)


@pytest.mark.parametrize("rise", [0.0, 0.3])
def test_sampling_keeps_the_mean_and_what_is_away_from_jumps(rise):
    times = np.array([0.0, 0.7, 0.7, 1.0, 2.0])
    values = np.array([1.0, 2.0, -3.0, 0.0, 0.5])
    even, samples, jump = sampled(times, values, rise)
    away = (np.abs(even - 0.7) > 0.16) & (even > 0.16) & (even < 1.84)
    before = even < 0.7
    left = np.interp(even, times[:2], values[:2])
    right = np.interp(even, times[2:], values[2:])
    assert_allclose(samples[away], np.where(before, left, right)[away], atol=1e-12)
    assert jump == 5.0
    exact = (1.5 * 0.7 - 1.5 * 0.3 + 0.25 * 1.0) / 2.0
    assert_allclose(samples.mean(), exact, atol=2e-3)


def test_the_largest_sum_of_overlaps_is_found_whether_or_not_two_rows_want_one_column():
    apart = np.array([[0.1, 0.9, 0.0], [0.8, 0.7, 0.2]])
    same = np.array([[0.1, 0.9, 0.0], [0.5, 0.8, 0.2]])
    assert _most_alike(apart).tolist() == [1, 0]
    assert _most_alike(same).tolist() == [1, 0]  # 0.9 + 0.5 > 0.1 + 0.8


def test_modes_are_followed_through_a_crossing():
    """The columns of the two lowest are exchanged half way, and signs are mixed."""
    response = cycle_response(forged(speed=5.0, height=-1.0), 0.02)
    modes = response.modes
    n = len(modes.frequencies)
    order = np.tile(np.arange(modes.shapes.shape[2]), (n, 1))
    order[n // 2 :, :2] = [1, 0]
    signs = np.where(np.arange(n) % 3 == 1, -1.0, 1.0)
    rows = np.arange(n)[:, None]
    mixed = replace(
        modes, shapes=np.swapaxes(modes.shapes[rows, :, order], 1, 2) * signs[:, None, None]
    )
    columns, found, back = followed(mixed, 2)
    assert (columns[: n // 2] == [0, 1]).all()
    assert (columns[n // 2 :] == [1, 0]).all()
    steady, signs_before, _ = followed(modes, 2)
    assert (steady == [0, 1]).all()
    assert_allclose(found * signs[:, None], signs_before)
    assert (back != 0.0).all()


def test_a_cycle_that_does_not_come_back_and_no_damping_are_refused():
    cycle = once_along(springs([1e-3], [1.0]))
    with pytest.raises(LinkageError, match="'out' does not end where it starts"):
        cycle_response(cycle, 0.02)
    with pytest.raises(LinkageError, match=r"damping ratio must be above 0, got 0: nothing"):
        cycle_response(shaken(MASS, 1.0, STROKE, TIME), 0.0)


def test_loads_with_vibration_need_a_force_where_the_pace_is_set():
    cycle = forged(speed=10.0, height=-1.0)
    cycle = replace(cycle, pace=Angle("rod"))
    modes = linkage_modes(motion_of(cycle), Angle("crank"))
    response = CycleResponse(replace(modes, holder="hold rod.angle"), 1.0, 0.02, (), None, None)
    with pytest.raises(LinkageError, match=r"no force acts along rod\.angle"):
        with_vibration(cycle, response)


def test_a_mode_that_comes_back_reversed_has_half_harmonics():
    """Half a cosine wave over the cycle goes on as one; unreversed it would jump by its range."""
    times = np.linspace(0.0, 2.0, 801)
    values = np.cos(np.pi * times / 2.0)
    frequency = np.full(801, 2.5)
    found = _response(1, times, values, frequency, 0.02, 0.0, 1.0, -1.0)
    assert found.jump < 1e-12
    assert found.harmonics[0].number == 0.5
    assert_allclose(found.harmonics[0].amplitude, 1.0, atol=1e-4)
    assert_allclose(found.amplification, abs(dynamic_factor(0.1, 0.02)), rtol=1e-3)
    assert_allclose((found.times[-1], found.slow[-1]), (2.0, -1.0), atol=1e-4)
    assert_allclose(_response(1, times, values, frequency, 0.02, 0.0, 1.0, 1.0).jump, 2.0)


def on_and_off(time):
    """A load that is on for the second half of a cycle."""
    return np.array([0.0, time / 2, time / 2, time]), np.array([0.0, 0.0, 1.0, 1.0])


def test_jumps_without_a_stated_rise_do_not_smooth_away_a_load_in_resonance():
    """Half range of the first harmonic 2/pi, times 1/(2 zeta), at a mode of the cycle's own rate.

    A rise of four periods of the mode, 0.4 s of a cycle of 0.1 s, left nothing of the load.
    """
    times, values = on_and_off(0.1)
    frequency = np.full(4, 10.0)
    default = _response(1, times, values, frequency, 0.02, None, 1.0, 1.0)
    assert default.rise == pytest.approx(0.005)
    assert_allclose(np.ptp(default.slow), 1.0)
    assert_allclose(default.deviation, 2 / np.pi / 0.04, rtol=0.03)


def test_the_rise_that_is_taken_is_short_against_mode_cycle_and_time_between_jumps():
    times, values = on_and_off(10.0)
    assert rise_of(times, values, 10.0, 10.0) == 0.4
    assert rise_of(times, values, 1.0, 10.0) == 0.5
    one_jump = np.array([0.0, 10.0]), np.array([0.0, 1.0])
    assert rise_of(*one_jump, 1.0, 10.0) == 0.5
    times, values = np.array([0.0, 9.0, 9.0, 9.2, 9.2, 10.0]), np.array([0, 0, 1, 1, 0, 0.0])
    assert rise_of(times, values, 10.0, 10.0) == pytest.approx(0.02)
    over_the_end = np.array([0.0, 0.3, 0.3, 10.0]), np.array([1.0, 1.0, 0.0, 0.0])
    assert rise_of(*over_the_end, 10.0, 10.0) == pytest.approx(0.03)
    values = np.array([0.0, 0.0, 1e-3, 1e-3, 0.0, 1.0])  # phases that end, and hardly a jump
    assert rise_of(times, values, 10.0, 10.0) == 0.4


@pytest.mark.parametrize("rise", [0.6, 1.6, 2.6, 7.3])
def test_a_rise_of_any_length_goes_through_the_cycles_before_and_after(rise):
    """Harmonics 2/(pi h) of the load, times cos(pi h r)/(1 - 4 h2 r2) of the half wave's slope."""
    _, samples, _ = sampled(*on_and_off(1.0), rise)
    h = np.array([1, 3, 5])
    found = 2 * np.abs(np.fft.rfft(samples)[h]) / SAMPLES
    expected = 2 / np.pi / h * np.abs(np.cos(np.pi * h * rise) / (1 - 4 * h**2 * rise**2))
    assert_allclose(found, expected, atol=1e-6)
    assert_allclose(samples.mean(), 0.5, atol=1e-3)


def test_a_resonance_inside_the_range_is_found_however_sharp_it_is():
    """Third harmonic at 10.025 Hz, between two even steps of 9 to 11 Hz; 1/(2 zeta) wide 0.01."""
    times = np.linspace(0.0, 3 / 10.025, 2001)
    values = np.cos(2 * np.pi * 10.025 * times)
    found = _response(1, times, values, np.linspace(9.0, 11.0, 2001), 5e-4, 0.0, 1.0, 1.0)
    assert_allclose(found.worst, 10.025, rtol=1e-9)
    assert_allclose(found.amplification, 1000.0, rtol=1e-3)
