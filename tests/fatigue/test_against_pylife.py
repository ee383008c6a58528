"""pyLife (Bosch, Apache-2.0) as an oracle: mean stress, S-N curve, Miner, rainflow."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from pylife.strength import Fatigue
from pylife.strength.meanstress import HaighDiagram
from pylife.stress.collective import LoadCollective
from pylife.stress.rainflow import FourPointDetector, FullRecorder

from fatigue import (
    SNCurve,
    count_closed_cycles,
    fkm_factor,
    miner_damage,
)

N_CYCLES = 400


def random_cycles(seed):
    """Amplitude, mean (R from below -1 to above 0.5, and compression) and counts."""
    rng = np.random.default_rng(seed)
    amplitude = rng.uniform(1.0, 300.0, N_CYCLES)
    return amplitude, amplitude * rng.uniform(-3.0, 6.0, N_CYCLES), rng.uniform(1, 1e5, N_CYCLES)


def collective(amplitude, mean, counts):
    return pd.DataFrame({"range": 2.0 * amplitude, "mean": mean, "cycles": counts})


@pytest.mark.parametrize("sensitivity", [0.05, 0.3, 0.6])
def test_the_fkm_line_is_pylifes_up_to_r_of_one_half(sensitivity):
    """fkm_goodman; above R = 0.5 it goes on with M/3, the guideline does not (FT-08)."""
    amplitude, mean, counts = random_cycles(1)
    ours = amplitude / fkm_factor(amplitude, mean, sensitivity)
    diagram = HaighDiagram.fkm_goodman(pd.Series({"M": sensitivity}))
    theirs = diagram.transform(collective(amplitude, mean, counts), -1.0)["range"] / 2.0
    held = mean <= 3.0 * amplitude
    assert 0.2 < held.mean() < 0.9
    assert_allclose(ours[held], theirs[held], rtol=1e-9)
    assert (theirs[~held] > ours[~held]).all()


def test_the_fkm_line_is_pylifes_five_segments_everywhere():
    """Five segments can say that the factor is constant from R = 0.5 on, and for R > 1."""
    amplitude, mean, counts = random_cycles(2)
    ours = amplitude / fkm_factor(amplitude, mean, 0.3)
    segments = {"M0": 0.3, "M1": 0.1, "M2": 0.1, "M3": 0.0, "M4": 0.0, "R12": 0.25, "R23": 0.5}
    diagram = HaighDiagram.five_segment(pd.Series(segments))
    theirs = diagram.transform(collective(amplitude, mean, counts), -1.0)["range"] / 2.0
    assert_allclose(ours, theirs, rtol=1e-9)


@pytest.mark.parametrize(("variant", "slope_below"), [("original", np.inf), ("haibach", 9.0)])
def test_damage_is_pylifes(variant, slope_below):
    amplitude, mean, counts = random_cycles(3)
    curve = SNCurve(120.0, 2e6, 5.0).below_knee(variant)
    series = pd.Series({"SD": 120.0, "ND": 2e6, "k_1": 5.0, "k_2": slope_below})
    theirs = Fatigue(series).damage(LoadCollective(collective(amplitude, mean, counts)))
    assert (theirs == 0.0).any() == (variant == "original")
    assert miner_damage(amplitude, counts, curve) == pytest.approx(theirs.sum(), rel=1e-12)


def test_closed_cycles_are_pylifes_four_point_count_of_the_settled_history():
    """The third repetition of a history adds just its closed cycles."""
    history = np.random.default_rng(4).normal(size=60)
    found = []
    for n in (3, 4):
        recorder = FullRecorder()
        FourPointDetector(recorder=recorder).process(np.tile(history, n))
        pairs = np.sort([recorder.values_from, recorder.values_to], axis=0).T.tolist()
        found.append(sorted(map(tuple, pairs)))
    for pair in found[0]:
        found[1].remove(pair)
    ours = count_closed_cycles(history)
    n_times = ours.cycle_counts.astype(int)
    pairs = np.repeat(np.stack([ours.valley, ours.peak], axis=1), n_times, axis=0)
    assert_allclose(sorted(map(tuple, pairs.tolist())), sorted(found[1]), atol=1e-14)
