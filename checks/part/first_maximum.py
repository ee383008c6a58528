"""Which of several positions decides where some are equal but for round-off.

Two cycles that pass through the same position load a part alike there, to the last digits or not,
depending on the processor. The first of them is named, so that every machine names the same.
"""

import numpy as np

from geometry.mesh import FloatArray

TIE = 1e-9  # values that are closer than this, of the largest, are equal


def first_largest(values: FloatArray) -> tuple[int, ...]:
    """Return the index, one number per axis, of the first value that equals the largest.

    values  of any shape, at least one; in their order in memory, the last axis runs fastest
    Raises ValueError for no values.
    """
    largest = float(np.max(values))
    equal = np.asarray(values >= largest - TIE * abs(largest))
    return tuple(int(k) for k in np.unravel_index(int(equal.argmax()), equal.shape))
