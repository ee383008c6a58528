"""The stress at surface points over a cycle, as a basis times coefficients.

    stress(point, :, position) = sum_j basis[point, :, j] * coefficients[j, position]

    basis         (n_points, 6, n_basis)    MPa per unit of each unit load
    coefficients  (n_basis, n_positions)    the units that act

The six components stand in the order of COMPONENTS, in every array of this package.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")

# Where each component of COMPONENTS stands in the symmetric 3 x 3 tensor.
_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])

_ROOT3 = float(np.sqrt(3.0))

# Rows: xx - (yy + zz)/2, sqrt(3)/2 (yy - zz), sqrt(3) times each shear stress.
_DEVIATOR = np.array(
    [
        [1.0, -0.5, -0.5, 0.0, 0.0, 0.0],
        [0.0, _ROOT3 / 2.0, -_ROOT3 / 2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, _ROOT3, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, _ROOT3, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, _ROOT3],
    ]
)

# Numbers in one block of the stress history, 8 bytes each; measured, the caches like this size.
BLOCK = 400_000

_MANY = 1000  # points from which on fewer unit loads pay for being found
_WORTH = 0.7  # of the unit loads: with more left nothing is gained
_NOTHING = 1e-14  # of the largest singular value


def deviatoric_basis(basis: FloatArray) -> FloatArray:
    """Return (n_points, 5, n_basis) vectors whose Euclidean norm is the von Mises stress.

    With a = xx - (yy+zz)/2 and b = sqrt(3)/2 (yy-zz),
    a**2 + b**2 = xx**2 + yy**2 + zz**2 - xx*yy - yy*zz - zz*xx, and von Mises' equivalent stress
    squared is that plus 3 (xy**2 + yz**2 + zx**2): Ilyushin's five-dimensional stress space.
    """
    return np.asarray(_DEVIATOR @ basis, dtype=np.float64)


def von_mises(stress: FloatArray) -> FloatArray:
    """Return the von Mises stress, MPa, of stresses whose last axis holds the six components.

    >>> float(von_mises(np.array([3.0, 3.0, 3.0, 4.0, 0.0, 0.0])) / np.sqrt(3.0))
    4.0
    """
    return np.asarray(np.linalg.norm(stress @ _DEVIATOR.T, axis=-1))


def principal_stresses(stress: FloatArray) -> FloatArray:
    """Return the three principal stresses, MPa, smallest first: (..., 6) to (..., 3).

    >>> principal_stresses(np.array([0.0, 0.0, 0.0, 4.0, 0.0, 0.0])).tolist()
    [-4.0, 0.0, 4.0]
    """
    return np.asarray(np.linalg.eigvalsh(stress[..., _TENSOR]))


def check_history(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return both arrays as floats, or say which point or position cannot be used."""
    basis = np.asarray(basis, dtype=np.float64)
    coefficients = np.asarray(coefficients, dtype=np.float64)
    if basis.ndim != 3 or basis.shape[1] != 6 or coefficients.ndim != 2:
        raise ValueError(
            "the stress history needs a basis (n_points, 6, n_basis) and coefficients "
            f"(n_basis, n_positions), got {basis.shape} and {coefficients.shape}"
        )
    if basis.shape[2] != coefficients.shape[0]:
        raise ValueError(
            f"the basis holds {basis.shape[2]} unit loads, the coefficients {coefficients.shape[0]}"
        )
    if basis.shape[0] == 0 or coefficients.shape[1] == 0:
        raise ValueError(
            "the stress history needs at least one point and one position, got "
            f"{basis.shape[0]} points and {coefficients.shape[1]} positions"
        )
    if not np.isfinite(basis).all():
        bad = np.flatnonzero(~np.isfinite(basis).all(axis=(1, 2)))
        raise ValueError(
            f"the stress basis is not finite at point {bad[0]} ({len(bad)} of {len(basis)} points)"
        )
    if not np.isfinite(coefficients).all():
        bad = np.flatnonzero(~np.isfinite(coefficients).all(axis=0))
        raise ValueError(
            f"the coefficients are not finite at position {bad[0]} "
            f"({len(bad)} of {coefficients.shape[1]} positions)"
        )
    return basis, coefficients


def with_fewer_loads(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same history by as few unit loads as it has to round-off.

    Of few points, or where hardly any unit load would go, both come back as they are.
    """
    n_loads, n_positions = coefficients.shape
    if len(basis) < max(_MANY, n_positions):
        return basis, coefficients
    turn, fewer = fewer_loads(basis, coefficients)
    if len(fewer) > _WORTH * n_loads:
        return basis, coefficients
    return (basis.reshape(-1, n_loads) @ turn).reshape(len(basis), 6, -1), fewer


def fewer_loads(
    basis: FloatArray, coefficients: FloatArray, lost: float = _NOTHING
) -> tuple[FloatArray, FloatArray]:
    """Return the shares (n_basis, m) of unit loads in as few that do for a history, and these.

    Their coefficients are (m, n_positions). Unit loads that act in step, such as the waves of a
    pressure that only grows, are one load.

    lost  of the largest singular value of the coefficients, each times the largest stress of its
          unit load: less is left out
    """
    sizes = np.maximum(basis.max(axis=(0, 1)), -basis.min(axis=(0, 1)))
    sizes[sizes == 0.0] = 1.0
    turn, values, paths = np.linalg.svd(sizes[:, None] * coefficients, full_matrices=False)
    count = max(1, int(np.count_nonzero(values > lost * values[0])))
    return turn[:, :count] / sizes[:, None], values[:count, None] * paths[:count]


def point_blocks(n_points: int, numbers_per_point: int) -> Iterator[slice]:
    """Yield slices over the points whose history holds about BLOCK numbers each."""
    size = max(1, BLOCK // max(1, numbers_per_point))
    for start in range(0, n_points, size):
        yield slice(start, min(start + size, n_points))


def von_mises_peaks(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the largest von Mises stress of each point over the cycle, MPa, and its position.

    Both have shape (n_points,). Of equal peaks the first position is named.
    """
    basis, coefficients = check_history(basis, coefficients)
    vectors = deviatoric_basis(basis)
    n_points, n_positions = len(basis), coefficients.shape[1]
    peak = np.empty(n_points)
    position = np.empty(n_points, dtype=np.intp)
    for block in point_blocks(n_points, 5 * n_positions):
        path = vectors[block] @ coefficients
        squared = np.einsum("pdk,pdk->pk", path, path)
        position[block] = squared.argmax(axis=1)
        peak[block] = np.sqrt(squared.max(axis=1))
    return peak, position


# Refusal of a number among many: a message with the fault, its first place and its count.


def refuse(
    bad: npt.NDArray[np.bool_], problem: str, values: npt.NDArray[np.generic], item: str = "cycle"
) -> None:
    """Raise ValueError with the problem, its first place and the value there, where any is bad."""
    if not bad.any():
        return
    place = np.argwhere(bad)[0].tolist()
    names = ["point", item][2 - len(place) :]
    where = ", ".join(f"{name} {index}" for name, index in zip(names, place, strict=True))
    raise ValueError(
        f"{problem}: {values[tuple(place)]:g}"
        + (f" at {where} ({bad.sum()} of {bad.size})" if place else "")
    )


def checked_cycles(amplitude: npt.ArrayLike, mean: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return amplitudes and means, MPa, as floats of one shape; ValueError names a bad cycle."""
    amplitude = np.asarray(amplitude, dtype=np.float64)
    mean = np.asarray(mean, dtype=np.float64)
    refuse(~np.isfinite(amplitude), "the amplitude is not finite", amplitude)
    refuse(~np.isfinite(mean), "the mean stress is not finite", mean)
    refuse(amplitude < 0.0, "the amplitude, half the range, is below 0 MPa", amplitude)
    amplitude, mean = np.broadcast_arrays(amplitude, mean)
    return amplitude, mean
