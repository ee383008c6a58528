"""Made-up surfaces with fields, for the live view."""

import numpy as np

from checks.result.live_fields import LiveFields, LivePeak, von_mises
from fem.stress_history import StressHistory


def torus(around=36, across=20, radius=100.0, tube=30.0):
    """A closed surface of around * across nodes in no order; triangles face outwards."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / across
    nodes = np.column_stack(
        [(radius + tube * np.cos(b)) * np.cos(a), (radius + tube * np.cos(b)) * np.sin(a),
         tube * np.sin(b)]
    )  # fmt: skip
    index = np.arange(around * across).reshape(around, across)
    right, up = np.roll(index, -1, axis=0), np.roll(index, -1, axis=1)
    corner = np.roll(right, -1, axis=1)
    quads = [x.ravel() for x in (index, right, corner, up)]
    triangles = np.concatenate(
        [np.column_stack(quads[:3]), np.column_stack([*quads[:1], *quads[2:]])]
    )
    mixed = np.random.default_rng(7).permutation(len(nodes))
    place = np.argsort(mixed)
    return nodes[mixed], place[triangles]


def smooth(nodes, count, seed=0, parts=6):
    """Fields (count, n, parts) of a few waves each, some with a hot place."""
    random = np.random.default_rng(seed)
    size = np.ptp(nodes, axis=0).max()
    waves = random.normal(size=(count, parts, 4, 3)) * 4 / size
    phases = random.uniform(0, 2 * np.pi, size=(count, parts, 4))
    field = np.cos(np.einsum("jpwx,nx->jnpw", waves, nodes) + phases[:, None]).sum(axis=3)
    hot = nodes[random.integers(len(nodes), size=count)]
    near = np.exp(-((nodes[None] - hot[:, None]) ** 2).sum(axis=2) / (0.1 * size) ** 2)
    return field * (1 + 5 * near[:, :, None])


def turning(count, positions, seed=0):
    """Coefficients (count, positions) that turn with the cycle."""
    random = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * np.pi, positions)
    waves = np.array([f(k * angle) for k in (0, 1, 2, 3) for f in (np.cos, np.sin)])
    return random.normal(size=(count, len(waves))) @ waves


def live(stress, coefficients, surface=None, **more):
    """Fields of a part with the peaks that they have. coefficients: cycle -> (M, n)."""
    nodes, triangles = surface or torus()
    history = {
        name: StressHistory(np.arange(len(nodes)), nodes, np.moveaxis(stress, 0, 2), c)
        for name, c in coefficients.items()
    }
    peaks = {name: one.peaks_by_position()[0] for name, one in history.items()}
    return LiveFields(
        nodes=nodes,
        triangles=triangles,
        stress=stress,
        displacement=more.pop("displacement", None),
        coefficients=coefficients,
        peaks=peaks,
        **more,
    )


def peak_of(fields):
    """The peak that would be reported of some fields."""
    cycle = max(fields.peaks, key=lambda name: fields.peaks[name].max())
    position = int(fields.peaks[cycle].argmax())
    stress = von_mises(fields.at(cycle, position))
    return LivePeak(int(stress.argmax()), cycle, position, float(stress.max()), "bore (1, 2, 3)")


def usual(positions=61, count=8, **more):
    """Two cycles, one a tenth of the other, and everything that a part can have."""
    surface = torus()
    stress = smooth(surface[0], count)
    moved = smooth(surface[0], count, seed=1, parts=3) * 1e-4
    coefficients = {
        "work": turning(count, positions),
        "idle": 0.1 * turning(count, 37, seed=2),
    }
    amplitude = np.abs(stress[0, :, 0]) * 20
    fatigue = {"utilisation": amplitude / 300, "amplitude": amplitude, "mean": amplitude / 3}
    fields = live(stress, coefficients, surface, displacement=moved, fatigue=fatigue)
    return live(
        stress, coefficients, surface, displacement=moved, fatigue=fatigue, peak=peak_of(fields),
        **more,
    )  # fmt: skip


def principal_range(stress):
    """Smallest and largest principal stress of stress (..., 6), MPa; 0 is counted in."""
    rows = stress.reshape(-1, 6)
    values = np.linalg.eigvalsh(rows[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3))
    return min(0.0, values.min()), max(0.0, values.max())
