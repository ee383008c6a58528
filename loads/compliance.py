"""Compliance of a linkage: bodies and joints with small elastic deflections, as numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from loads.bodies import FloatArray, LinkageError


@dataclass(frozen=True)
class BeamCompliance:
    """A body that bends and shortens along its own x axis, which its loaded points lie on.

    bending  N mm2, stiffness E I; None does not bend
    axial    N, stiffness E A; None does not shorten
    """

    body: str
    bending: float | None = None
    axial: float | None = None

    def __post_init__(self) -> None:
        if self.bending is None and self.axial is None:
            raise LinkageError(f"body {self.body!r}: its elasticity states neither E I nor E A")
        for name, value in (("bending", self.bending), ("axial", self.axial)):
            if value is not None and not (isfinite(value) and value > 0.0):
                raise LinkageError(
                    f"body {self.body!r}: its {name} stiffness must be above 0, got {value:g}"
                )


@dataclass(frozen=True, eq=False)
class MatrixCompliance:
    """A body's compliance at its points, for loads on it in its own axes.

    points  m names of points of the body
    slides  slot or guide whose line the body has -> (k,) mm, rising places along the line's
            direction from the point it goes through, between which its contact stays
    matrix  (3 m + 3 k, 3 m + 3 k) mm/N, rad/N, rad/(N mm): displacements x, y and turn of every
            point, then of every place of every slide, for forces x, y and couple there; held
            anyhow, as long as the body can deform

    Two neighbouring places share a contact between them linearly, which keeps its force and moment;
    it moves as they do with the same shares, which keeps the work. Of its deflection that misses up
    to h^2/4 times the curvature there, h being the distance of the two.
    """

    body: str
    points: tuple[str, ...]
    matrix: FloatArray
    slides: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, places in self.slides.items():
            if len(places) < 2 or not np.isfinite(places).all() or min(np.diff(places)) <= 0.0:
                raise LinkageError(
                    f"body {self.body!r}: its compliance under joint {name!r} needs at least two "
                    f"places along the line that rise, got {places}"
                )
        size = 3 * self.n_places
        count = self.n_places - len(self.points)
        matrix = np.asarray(self.matrix, dtype=float)
        if matrix.shape != (size, size):
            along = f" and {count} places along lines" if count else ""
            raise LinkageError(
                f"body {self.body!r}: the compliance of {len(self.points)} points{along} is "
                f"{size} x {size}, got {matrix.shape}"
            )
        if not np.isfinite(matrix).all():
            raise LinkageError(f"body {self.body!r}: its compliance holds finite numbers only")
        if np.abs(matrix - matrix.T).max(initial=0.0) > 1e-6 * np.abs(matrix).max(initial=0.0):
            raise LinkageError(f"body {self.body!r}: its compliance is not symmetric")

    @property
    def n_places(self) -> int:
        """Number of points, and of places along lines."""
        return len(self.points) + sum(len(places) for places in self.slides.values())


@dataclass(frozen=True)
class JointCompliance:
    """A joint that gives way in the direction of its force: pin, bearing, or frame behind it.

    stiffness  N/mm
    """

    joint: str
    stiffness: float

    def __post_init__(self) -> None:
        if not (isfinite(self.stiffness) and self.stiffness > 0.0):
            raise LinkageError(
                f"joint {self.joint!r}: its stiffness must be above 0, got {self.stiffness:g}"
            )


Compliance = BeamCompliance | MatrixCompliance | JointCompliance
