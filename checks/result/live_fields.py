"""Fields of a part at every node of its surface, at every position of every cycle."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fem.stress_history import DEVIATOR
from geometry.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from checks.result.verdict import Surface

RealArray = npt.NDArray[np.floating[Any]]

_TOGETHER = 256  # points whose principal stresses are found together

FATIGUE = ("utilisation", "amplitude", "mean")


@dataclass(frozen=True)
class LivePeak:
    """The peak stress that is reported of a part.

    node      of the surface
    cycle     its name; position is one of that cycle's
    value     MPa, von Mises
    place     in words
    """

    node: int
    cycle: str
    position: int
    value: float
    place: str


@dataclass(frozen=True, eq=False)
class LiveFields:
    """Fields on the surface of a part: stress = sum_j stress[j] coefficients[cycle][j, position].

    nodes         (n, 3) mm, in the part's frame
    triangles     (m, 3) indices of them, seen from outside against the clock
    stress        (M, n, 6) MPa per unit load; xx, yy, zz, xy, yz, zx. M = 0: none is known
    displacement  (M, n, 3) mm per unit load, rigid motion taken off; None: not known
    coefficients  name of a cycle -> (M, n_positions); cycles that do not load the part are missing
    fatigue       utilisation [1], amplitude and mean [MPa] over the duty, (n,) each, where known;
                  utilisation without the required safety
    judged        True if that utilisation, times the required safety, is what the check judges;
                  a finite life is counted otherwise
    decides       True if checks are decided by this stress; one of a mesh to look at decides none
    estimated     True if it is by section forces, without the peaks that checks count
    missing       field -> why there is none, in words
    notes         what else a reader should know of the fields, in words
    peaks         name of a cycle -> (n_positions,) MPa, largest von Mises stress at each position
    peak          that is reported; None without stress
    mode          (n, 3) its buckling mode, the largest motion of all parts 1; None: unknown

    Unit fields are kept in single precision: a result that was stored gives the same page.
    Raises ValueError for shapes that do not fit each other, and for NaN and infinity.
    """

    nodes: FloatArray
    triangles: IntArray
    stress: RealArray
    displacement: RealArray | None
    coefficients: Mapping[str, FloatArray]
    peaks: Mapping[str, FloatArray]
    fatigue: Mapping[str, RealArray] = field(default_factory=dict)
    judged: bool = False
    decides: bool = True
    estimated: bool = False
    missing: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    peak: LivePeak | None = None
    mode: RealArray | None = None

    def __post_init__(self) -> None:
        single = np.float32
        object.__setattr__(self, "nodes", np.asarray(self.nodes, dtype=np.float64))
        object.__setattr__(self, "triangles", np.asarray(self.triangles, dtype=np.int64))
        object.__setattr__(self, "stress", np.asarray(self.stress, dtype=single))
        if self.displacement is not None:
            object.__setattr__(self, "displacement", np.asarray(self.displacement, dtype=single))
        if self.mode is not None:
            object.__setattr__(self, "mode", np.asarray(self.mode, dtype=single))
        fatigue = {name: np.asarray(values, dtype=single) for name, values in self.fatigue.items()}
        object.__setattr__(self, "fatigue", fatigue)
        self._check_shapes()
        self._check_numbers()

    @property
    def n_fields(self) -> int:
        """Number of unit loads, M."""
        return len(self.stress)

    def at(self, cycle: str, position: int) -> FloatArray:
        """Stress (n, 6) at a position of a cycle, MPa."""
        weights = self.coefficients[cycle][:, position]
        return np.asarray(np.einsum("jnc,j->nc", self.stress.astype(np.float64), weights))

    def moved(self, cycle: str, position: int) -> FloatArray | None:
        """Displacement (n, 3) at a position of a cycle, mm; None where it is not known."""
        if self.displacement is None:
            return None
        weights = self.coefficients[cycle][:, position]
        return np.asarray(np.einsum("jnc,j->nc", self.displacement.astype(np.float64), weights))

    def _check_shapes(self) -> None:
        n, count = len(self.nodes), len(self.stress)
        moved = None if self.displacement is None else self.displacement.shape
        shapes: list[tuple[str, Any, Any]] = [
            ("nodes", self.nodes.shape, (n, 3)),
            ("triangles", self.triangles.shape, (len(self.triangles), 3)),
            ("stress", self.stress.shape, (count, n, 6)),
            ("displacement", moved or (count, n, 3), (count, n, 3)),
            ("mode", (n, 3) if self.mode is None else self.mode.shape, (n, 3)),
            *((name, values.shape, (n,)) for name, values in self.fatigue.items()),
            *(
                (f"coefficients of {name!r}", values.shape, (count, values.shape[-1]))
                for name, values in self.coefficients.items()
            ),
            ("cycles of the peaks", set(self.peaks), set(self.coefficients)),
            *(
                (f"peaks of {name!r}", self.peaks[name].shape, (values.shape[-1],))
                for name, values in self.coefficients.items()
                if name in self.peaks
            ),
        ]
        for what, found, expected in shapes:
            if found != expected:
                raise ValueError(f"live fields: {what} must have shape {expected}, got {found}")
        if not n:
            raise ValueError("live fields: a surface needs nodes, got none")
        low, high = self.triangles.min(initial=0), self.triangles.max(initial=0)
        if low < 0 or high >= n:
            raise ValueError(f"live fields: triangles name nodes {low} to {high} of {n}")
        if self.peak is not None and not 0 <= self.peak.node < n:
            raise ValueError(f"live fields: the peak is at node {self.peak.node} of {n}")

    def _check_numbers(self) -> None:
        arrays: dict[str, npt.NDArray[Any]] = {"nodes": self.nodes, "stress": self.stress}
        if self.displacement is not None:
            arrays["displacement"] = self.displacement
        if self.mode is not None:
            arrays["mode"] = self.mode
        arrays |= self.fatigue
        arrays |= {f"coefficients of {name!r}": c for name, c in self.coefficients.items()}
        arrays |= {f"peaks of {name!r}": values for name, values in self.peaks.items()}
        for what, values in arrays.items():
            bad = np.argwhere(~np.isfinite(values))
            if len(bad):
                place = ", ".join(str(k) for k in bad[0])
                raise ValueError(
                    f"live fields: {what} holds {values[tuple(bad[0])]} at [{place}]; one such "
                    "number would spoil every position"
                )


@dataclass(frozen=True, eq=False)
class EncodedPart:
    """A part as a page carries it.

    head      its entry in the header, without its name and the number of its block
    text      base64
    estimate  its utilisation for a still, where it is estimated
    """

    head: Mapping[str, Any]
    text: str
    estimate: "Surface | None" = None


def with_required_safety(live: LiveFields, required: float | None) -> LiveFields:
    """The fields with the required safety in the utilisation: 1 is the limit.

    required  safety against fatigue; None where no check asks for one
    """
    if required is None or "utilisation" not in live.fatigue:
        return replace(live, judged=False)
    return replace(
        live, fatigue={**live.fatigue, "utilisation": required * live.fatigue["utilisation"]}
    )


def grey(nodes: Any, triangles: Any, why: str) -> LiveFields:
    """A surface (nodes (n, 3) mm, triangles (m, 3)) without fields, and why it has none."""
    count = len(nodes)
    names = ("mises", "principal", "displacement", *FATIGUE)
    return LiveFields(
        nodes=nodes,
        triangles=triangles,
        stress=np.zeros((0, count, 6), dtype=np.float32),
        displacement=None,
        coefficients={},
        peaks={},
        missing=dict.fromkeys(names, why),
        notes=(why,),
    )


def von_mises(stress: npt.NDArray[Any]) -> FloatArray:
    """Von Mises stress (...) of stress (..., 6), MPa."""
    return np.asarray(np.sqrt(((stress @ DEVIATOR.T) ** 2).sum(axis=-1)))


def largest_principal(rows: FloatArray, known: float = 0.0) -> float:
    """Largest size of a principal stress of stress (n, 6), MPa, or `known` if that is larger.

    No principal value of a deviator exceeds 2/3 of its von Mises stress: points that cannot hold
    the extreme by that bound are not looked at.
    """
    bounds = np.abs(rows[:, :3].mean(axis=1)) + von_mises(rows) * (2 / 3)
    left = np.flatnonzero(bounds > known)
    left = left[np.argsort(-bounds[left], kind="stable")]
    for first in range(0, len(left), _TOGETHER):
        some = left[first : first + _TOGETHER]
        if bounds[some[0]] <= known:
            break
        known = max(known, _highest(rows[some]))
    return known


def _highest(rows: FloatArray) -> float:
    """Largest size of a principal stress of rows (n, 6)."""
    tensor = rows[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    return float(np.abs(np.linalg.eigvalsh(tensor)).max(initial=0.0))
