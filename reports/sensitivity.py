"""First-order Sobol' indices of a sample that is there: inputs that drive a result.

The index of an input x is S = Var(E[y|x]) / Var(y), the share of the result's variance that would
go if x were known. It needs no further samples where inputs are independent: sorted by x, the
result is E[y|x] over the rank of x plus scatter. The first coefficients of its cosine series hold
E[y|x], by Parseval their squares add up to its variance (EASI and its form by the discrete cosine
transform: docs.sciml.ai, GlobalSensitivity, "EASI Method"). Scatter alone puts its variance evenly
into all n - 1 coefficients, M/(n - 1) of it into the first M, which is taken off:
S = 1 - (1 - S_M) (n - 1)/(n - 1 - M). An input of few values has the means of its groups in place
of a series, with M one less than their number.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from geometry.mesh import FloatArray

FEWEST = 64  # samples: scatter of an index is some sqrt(2 M) / n, 0.06 there
_WAVES = 8
_TOGETHER = 0.3  # correlation of ranks beyond which neither input has an index of its own
_THE_SAME = 1.0 - 1e-9
Values = Sequence[float | str | None]


def first_order(inputs: Mapping[str, Values], result: FloatArray) -> dict[str, float]:
    """Return the first-order index of each input that is independent of the others, 0 to 1.

    inputs  name -> value of each sample, numbers or words
    result  (n,); samples where it is not finite, or an input is missing, are left out

    Inputs that always change together have one index, which each of them shows. None is returned
    for inputs that are linked otherwise, and none at all below `FEWEST` samples.
    """
    used = np.isfinite(result)
    for values in inputs.values():
        used &= np.array([value is not None for value in values], dtype=bool)
    result = result[used]
    if len(result) < FEWEST or np.ptp(result) == 0.0:
        return {}
    ranks = {
        name: _ranks([value for value, kept in zip(values, used, strict=True) if kept])
        for name, values in inputs.items()
    }
    ranks = {name: rank for name, rank in ranks.items() if rank.max() > 0}
    return {
        name: _index(rank, result)
        for name, rank in ranks.items()
        if not any(_linked(rank, other) for other in ranks.values())
    }


def _ranks(values: Values) -> FloatArray:
    """Place of each value among the different ones."""
    return np.unique(np.array(values), return_inverse=True)[1].astype(float)


def _linked(one: FloatArray, other: FloatArray) -> bool:
    """True for two inputs of which one tells of the other, unless they are one and the same."""
    pairs = len(np.unique(np.stack([one, other]), axis=1).T)
    groups = sorted((int(one.max()) + 1, int(other.max()) + 1))
    if pairs == groups[1] < len(one):  # a value of the finer one has one of the other
        return groups[0] < groups[1]
    together = abs(np.corrcoef(one, other)[0, 1])
    return bool(_TOGETHER < together < _THE_SAME)


def _index(rank: FloatArray, result: FloatArray) -> float:
    from scipy.fft import dct

    count, groups = len(result), int(rank.max()) + 1
    spread = result - result.mean()
    if groups <= _WAVES * 2:
        sizes = np.bincount(rank.astype(int))
        free = groups - 1
        held = (np.bincount(rank.astype(int), spread) ** 2 / sizes).sum()
    else:
        free = _WAVES
        series = dct(spread[np.argsort(rank, kind="stable")], norm="ortho")
        held = (series[1 : free + 1] ** 2).sum()
    share = 1.0 - (1.0 - held / (spread @ spread)) * (count - 1) / (count - 1 - free)
    return float(np.clip(share, 0.0, 1.0))
