"""Stress paths and the test series of Nishihara and Kawamoto, for the multiaxial criteria."""

from dataclasses import dataclass

import numpy as np

# Hard steel, limits in reversed bending and in reversed torsion, MPa: public case FT-11.
BENDING_LIMIT, TORSION_LIMIT = 313.9, 196.2


@dataclass(frozen=True)
class BendingTorsion:
    """sigma = bending sin(wt), tau = torsion sin(wt - phase), MPa and degrees, at the limit.

    Nishihara and Kawamoto 1945, as reproduced by Papadopoulos et al. 1997, half of the table. The
    amplitudes are the commonly reproduced ones and are not confirmed against the paper: nothing is
    asserted on how the criteria agree with the tests. `expected` is Findley's parameter over
    its limit for these inputs, which is exact whatever the tests were.
    """

    bending: float
    torsion: float
    phase: float
    expected: float


NISHIHARA_KAWAMOTO = (
    BendingTorsion(138.1, 167.1, 0.0, 1.009544468),
    BendingTorsion(145.7, 176.3, 60.0, 1.059291058),
    BendingTorsion(245.3, 122.6, 0.0, 1.040215137),
    BendingTorsion(252.4, 126.2, 60.0, 1.01490964),
    BendingTorsion(299.1, 62.8, 0.0, 1.017329434),
)


def bending_and_torsion(bending, torsion, phase=0.0, mean=0.0, n_positions=1440):
    """A path (6, n_positions): xx and xy of a round bar's surface, MPa, phase in degrees."""
    angle = 2.0 * np.pi * np.arange(n_positions) / n_positions
    stress = np.zeros((6, n_positions))
    stress[0] = mean + bending * np.sin(angle)
    stress[3] = torsion * np.sin(angle - np.radians(phase))
    return stress


def turned(stress, rotation):
    """The same stresses, (6, ...), in axes turned by an orthogonal matrix."""
    tensor = stress[np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])]
    tensor = np.einsum("ai,bj,ij...->ab...", rotation, rotation, tensor)
    return np.stack([tensor[i, j] for i, j in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]])


def random_rotation(seed):
    """An orthogonal matrix."""
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def random_path(seed, n_positions=90, static=1.0):
    """A smooth closed path (6, n_positions) that is far from proportional, MPa."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(n_positions)[None] / n_positions
    waves = (np.cos(n * angle + s) / n for n, s in ((1, 0.0), (1, 1.5), (2, 0.3), (3, 0.7)))
    return 50.0 * (
        static * rng.normal(size=(6, 1)) + sum(rng.normal(size=(6, 1)) * wave for wave in waves)
    )
