"""Positions of every cycle at which a part's fields are looked at in full precision."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from checks.result.live_fields import FloatArray, IntArray, LiveFields, von_mises
from reports.live.accuracy import STRESS_METRIC, lost_in_single

POSITIONS = 24  # of all cycles together at least
_LEAST = 4  # of each cycle
_ALIKE = 1e-5  # of a cycle's peak: round-off between fields and the peaks told beside them


@dataclass(frozen=True, eq=False)
class Sample:
    """Fields in full precision at some positions of every cycle, its peak among them.

    positions  cycle -> (k,) ascending
    stress     cycle -> (n, 6, k) MPa
    mises      cycle -> (n, k) MPa
    peaks      cycle -> largest von Mises stress, MPa
    lost       cycle -> what single precision of the unit fields may cost that, MPa
    """

    positions: Mapping[str, IntArray]
    stress: Mapping[str, FloatArray]
    mises: Mapping[str, FloatArray]
    peaks: Mapping[str, float]
    lost: Mapping[str, float]


def looked_at(live: LiveFields) -> Sample:
    """Sample the cycles that load a part, evenly and at the peak of each.

    Raises ValueError if the fields do not have the peaks that the solver found.
    """
    each = max(_LEAST, -(-POSITIONS // max(1, len(live.coefficients))))
    positions, stress, mises, peaks = {}, {}, {}, {}
    lost = lost_in_single(live.stress, live.coefficients, STRESS_METRIC)
    fields = live.stress.reshape(live.n_fields, -1).astype(np.float64)
    for name, coefficients in live.coefficients.items():
        count = coefficients.shape[1]
        even = np.rint(np.linspace(0, count - 1, min(each, count))).astype(np.int64)
        peak = live.peaks[name]
        at = positions[name] = np.union1d(even, [int(peak.argmax())])
        stress[name] = (fields.T @ coefficients[:, at]).reshape(len(live.nodes), 6, -1)
        mises[name] = von_mises(stress[name].swapaxes(1, 2))
        peaks[name] = float(peak.max())
        off = np.abs(mises[name].max(axis=0) - peak[at])
        if off.max() > _ALIKE * peaks[name] + lost[name]:
            worst = int(off.argmax())
            raise ValueError(
                f"live fields: the peak at position {at[worst]} of {name!r} is "
                f"{peak[at[worst]]:.6g} MPa, but the fields have {mises[name][:, worst].max():.6g}"
            )
    return Sample(positions, stress, mises, peaks, lost)
