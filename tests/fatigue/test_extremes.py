"""The extremes of stress histories: the verdict by hand, and bounds that are never below it.

Values by hand use S_e = 200 MPa, S_u = 400 MPa unless said; Findley has k = 0.156591 and
f = 0.584392 S_e (docs/theory/multiaxial.md), and the limit in torsion is S_e/sqrt(3).
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fatigue import (
    SNCurve,
    count_closed_cycles,
    critical_plane,
    ductile_verdict,
    goodman,
    life_verdict,
    path_bounds,
)
from tests.fatigue.multiaxial_cases import bending_and_torsion, random_rotation, turned

ENDURANCE, ULTIMATE = 200.0, 400.0


def of_path(path, strengths=(ENDURANCE, ULTIMATE), **options):
    return ductile_verdict(np.eye(6)[None], path, *strengths, **options)


def rotating_tension(size, n_positions=72):
    """A tension whose direction turns in a plane: its size, and von Mises' stress, never change."""
    angle = np.pi * np.arange(n_positions) / n_positions
    path = np.zeros((6, n_positions))
    path[0], path[1] = size * np.cos(angle) ** 2, size * np.sin(angle) ** 2
    path[3] = size * np.sin(angle) * np.cos(angle)
    return path


def rotating_shear(size, n_positions=72):
    """A shear that turns about its plane's normal: principal axes turn, their stresses do not."""
    angle = 2.0 * np.pi * np.arange(n_positions) / n_positions
    path = np.zeros((6, n_positions))
    path[4], path[5] = size * np.sin(angle), size * np.cos(angle)
    return path


def uniaxial(*stresses):
    path = np.zeros((6, len(stresses)))
    path[0] = stresses
    return path


def spike(n_positions):
    path = np.zeros((6, n_positions))
    path[[0, 3], n_positions // 3] = 80.0, 80.0 / np.sqrt(3.0)
    return path


SINE = 2.0 / np.sqrt(3.0) - 1.0  # k / sqrt(1 + k**2) = 2 t/b - 1
K = SINE / np.sqrt(1.0 - SINE**2)
PLANE = ENDURANCE / np.sqrt(3.0) * np.sqrt(1.0 + K**2)  # f = t sqrt(1 + k**2), 116.88 MPa
# The plane that a shear t turns in has a circle of it and no normal stress. Planes tilted by b have
# an ellipse, tau_a = t cos b up to 60 degrees, and sigma_n = t sin 2b: F = t (cos b + k sin 2b).
TILT = np.linspace(0.0, 1.0, 100_001)
TILTED = 50.0 * (np.cos(TILT) + K * np.sin(2.0 * TILT)).max() / PLANE

# Path, utilisation by hand, deciding criterion; S_e = 200, S_u = 400 MPa.
EXTREMES = {
    "no stress": (np.zeros((6, 24)), 0.0, "Goodman"),
    "no stress, one position": (np.zeros((6, 1)), 0.0, "Goodman"),
    "constant tension": (uniaxial(*[100.0] * 24), 100.0 / 400.0, "Goodman"),
    "constant compression": (uniaxial(*[-100.0] * 24), 0.0, "Goodman"),
    "one position": (uniaxial(100.0), 100.0 / 400.0, "Goodman"),
    "two positions": (uniaxial(-20.0, 100.0), 60.0 / 200.0 + 40.0 / 400.0, "Goodman"),
    "amplitude above ultimate": (uniaxial(-900.0, 900.0), 4.5, "Goodman"),
    "mean at ultimate": (uniaxial(380.0, 400.0, 420.0), 0.1 + 1.0, "Goodman"),
    "mean at ultimate, no amplitude": (uniaxial(400.0, 400.0), 1.0, "Goodman"),
    "mean beyond ultimate": (uniaxial(900.0, 900.0), 2.25, "Goodman"),
    "fully compressive": (uniaxial(-500.0, -300.0, -400.0), 0.5, "Goodman"),
    # the spike's von Mises stress: 80 sqrt(2); half its tensor (40, 40/sqrt(3) in shear) has the
    # principal stress 20 + sqrt(20**2 + 40**2/3)
    "single spike": (
        spike(1000),
        40.0 * np.sqrt(2.0) / 200.0 + (20.0 + np.sqrt(400.0 + 1600.0 / 3.0)) / 400.0,
        "Goodman",
    ),
    # At right angles the deviators are a shear of the size apart, whose von Mises stress is
    # sqrt(3) times it: amplitude sqrt(3)/2, mean 1/2. Planes at right angles to the tension at some
    # time see half of it in shear, reversed, and all of it as normal stress: 1/2 + k.
    "rotating tension": (rotating_tension(100.0), (50.0 + 100.0 * K) / PLANE, "Findley"),
    "rotating shear": (rotating_shear(50.0), TILTED, "Findley"),
    "rotating shear under a pressure": (
        rotating_shear(50.0) - 900.0 * np.eye(6)[:3].sum(axis=0)[:, None],
        TILTED,
        "Findley",
    ),
    "static pressure under a shear": (
        np.array([[-900.0] * 2] * 3 + [[50.0, -50.0]] + [[0.0] * 2] * 2),
        50.0 * np.sqrt(3.0) / 200.0,
        "Goodman",
    ),
}


@pytest.mark.parametrize("rotation", [None, 4])
@pytest.mark.parametrize("every_point", [True, False])
@pytest.mark.parametrize("name", EXTREMES)
def test_an_extreme_has_the_utilisation_worked_out_by_hand(name, every_point, rotation):
    path, expected, criterion = EXTREMES[name]
    if rotation is not None:
        path = turned(path, random_rotation(rotation))
    verdict = of_path(path, every_point=every_point)
    assert verdict.utilisation[0] == pytest.approx(expected, rel=1e-9, abs=1e-13)
    assert verdict.criterion == criterion
    if expected > 0.0:
        again = of_path(verdict.safety * path, every_point=every_point)
        assert again.safety == pytest.approx(1.0, rel=1e-9)
    elif rotation is None:
        assert verdict.safety == float("inf")


@pytest.mark.parametrize("k", [0.0, K, 0.6])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("name", EXTREMES)
def test_no_bound_lies_below_the_value_of_an_extreme(name, scale, k):
    path = scale * turned(EXTREMES[name][0], random_rotation(7))
    bounds = path_bounds(np.eye(6)[None], path, k)
    exact = goodman(np.eye(6)[None], path, 200.0, 400.0)
    assert bounds.amplitude[0] >= exact.amplitude[0]
    assert bounds.mean[0] >= exact.mean[0]
    assert bounds.findley[0] >= critical_plane(path, k).value


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.integers(0, 100_000),
    st.integers(1, 40),
    st.integers(1, 8),
    st.floats(0.0, 100.0),
    st.sampled_from([0, 9]),
)
def test_no_bound_lies_below_the_value_of_random_tensors(
    seed, n_positions, n_basis, static, decades
):
    """Tensors that jump from position to position, of like and of very unlike sizes."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(8, 6, n_basis)) * 10.0 ** rng.uniform(0, decades, (8, 1, n_basis))
    coefficients = rng.normal(size=(n_basis, n_positions)) + static * rng.normal(size=(n_basis, 1))
    bounds = path_bounds(basis, coefficients, K)
    exact = goodman(basis, coefficients, 200.0, 400.0)
    assert (bounds.amplitude >= exact.amplitude).all()
    assert (bounds.mean >= exact.mean).all()
    for point, tensors in enumerate(basis):
        assert bounds.findley[point] >= critical_plane(tensors @ coefficients, K).value


def test_the_bound_of_the_mean_is_reached_by_a_chord_beside_the_line():
    """Most positions draw the line, a shear of 0.9 a; the longest chord lies h = a/2 beside it.

    Beside it means a deviator of the von Mises stress h, pulling in one direction with 2 h/3: the
    mean of the chord, and the bound but for the two positions' share of 2/3000 in its centre.
    """
    size = 100.0
    path = np.zeros((6, 3000))
    path[4] = 0.9 * size / np.sqrt(3.0) * np.linspace(-1.0, 1.0, 3000)
    path[4, [5, 1500]] = size / np.sqrt(3.0) * np.array([-1.0, 1.0])
    path[:3, [5, 1500]] = size / 2.0 * np.array([[2.0], [-1.0], [-1.0]]) / 3.0
    exact = goodman(np.eye(6)[None], path, 200.0, 400.0).mean[0]
    assert exact == pytest.approx(size / 3.0, rel=1e-12)
    assert 1.0 <= path_bounds(np.eye(6)[None], path, K).mean[0] / exact < 1.01


def test_goodman_decides_on_a_rotating_tension_where_the_mean_costs_more():
    """S_u = 300 MPa: 0.8660/200 + 0.5/300 = 5.997e-3 per MPa, above Findley's 5.618e-3."""
    verdict = of_path(rotating_tension(100.0), (200.0, 300.0))
    assert verdict.criterion == "Goodman"
    assert verdict.safety == pytest.approx(1.0 / (50.0 * (np.sqrt(3.0) / 200.0 + 1.0 / 300.0)))


@pytest.mark.parametrize("n_positions", [3, 10, 1000])
def test_a_spike_counts_in_full_however_rare_it_is(n_positions):
    verdict = of_path(spike(n_positions))
    assert verdict.utilisation[0] == pytest.approx(EXTREMES["single spike"][1], rel=1e-12)
    assert n_positions // 3 in verdict.pair


@pytest.mark.parametrize("mean", [-100.0, 0.0, 120.0])
def test_a_thousand_million_cycles_are_endured_just_up_to_the_verdict_s_safety(mean):
    """Miner with an endurance limit: no damage below it, and 1000 times what is allowed at it."""
    path = bending_and_torsion(70.0, 0.0, mean=mean, n_positions=72)
    safety = of_path(path).safety
    curve = SNCurve(knee_amplitude=ENDURANCE, knee_cycles=1e6, slope=5.0)
    for factor, endures in ((1.0 - 1e-9, True), (1.0 + 1e-9, False)):
        duty = count_closed_cycles(factor * safety * path[0]).repeated(1e9)
        assert bool((life_verdict(duty, curve, ULTIMATE).damage <= 1.0).all()) is endures
    duty = count_closed_cycles(path[0]).repeated(1e9)
    assert life_verdict(duty, curve, ULTIMATE).safety[0] == pytest.approx(safety, rel=1e-9)


def test_half_the_endurance_limit_applied_a_thousand_million_times_by_haibach():
    """1e9 cycles over 1e6 at the knee, slope 2 k - 1 = 9 below it: 1000 / 2**9."""
    curve = SNCurve(knee_amplitude=ENDURANCE, knee_cycles=1e6, slope=5.0).below_knee("haibach")
    duty = count_closed_cycles([-100.0, 100.0]).repeated(1e9)
    verdict = life_verdict(duty, curve, ULTIMATE)
    assert verdict.damage[0] == pytest.approx(1000.0 / 512.0, rel=1e-12)
