"""Rigid bodies with named points, the joints and forces between them, and how they give way."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from math import degrees, hypot, inf, isfinite
from typing import ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Vector = tuple[float, float]
Pose = tuple[float, float, float]

GROUND = "ground"


class LinkageError(ValueError):
    """A linkage, or a cycle of it, that cannot be computed as stated."""


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the end of an error message about an unknown name: the nearest right one, or all."""
    names = sorted(known)
    close = get_close_matches(name, names, n=1, cutoff=0.5)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known are {', '.join(names)}" if names else "none is known"


@dataclass(frozen=True)
class Body:
    """A rigid body with named points, all in its own frame.

    The body named ``ground`` is the frame of the machine: it does not move and has no mass.

    points   mm, of the body frame, by name
    mass     tonne (or the unit that goes with the other units)
    inertia  tonne mm2, about the centre of mass
    centre   mm, centre of mass in the body frame
    """

    name: str
    points: Mapping[str, Vector] = field(default_factory=dict)
    mass: float = 0.0
    inertia: float = 0.0
    centre: Vector = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.name:
            raise LinkageError("a body has no name")
        for quantity, value in (("mass", self.mass), ("inertia", self.inertia)):
            if not (isfinite(value) and value >= 0.0):
                raise LinkageError(
                    f"body {self.name!r}: {quantity} must be 0 or above, got {value:g}"
                )
        if self.name == GROUND and (self.mass or self.inertia):
            raise LinkageError("body 'ground' does not move and takes no mass or inertia")
        for point, place in (*self.points.items(), ("centre", self.centre)):
            if len(place) != 2 or not all(isfinite(value) for value in place):
                raise LinkageError(
                    f"body {self.name!r}: point {point!r} must be two numbers, got {place}"
                )

    def place(self, point: str) -> Vector:
        """Return where a named point is in the body frame."""
        if point not in self.points:
            raise LinkageError(
                f"body {self.name!r} has no point {point!r}; {nearest(point, self.points)}"
            )
        return self.points[point]

    def with_mass_properties(self, mass: float, centre: Vector, inertia: float) -> Self:
        """Return the same body with other mass properties (inertia about the centre)."""
        return replace(self, mass=mass, centre=centre, inertia=inertia)


# Joints between bodies, coordinates that measure bodies, forces and friction.


def _check_direction(owner: str, direction: Vector) -> None:
    if len(direction) != 2 or not 0.0 < hypot(*direction) < float("inf"):
        raise LinkageError(f"{owner}: the direction must be a vector, got {direction}")


def _check_ends(owner: str, ends: tuple[float, float] | None) -> None:
    if ends is not None and not (len(ends) == 2 and -inf < ends[0] < ends[1] < inf):
        raise LinkageError(f"{owner}: its ends must be two rising numbers, got {ends}")


@dataclass(frozen=True)
class _AtOnePoint:
    """A joint at a point that both bodies know by the same name."""

    name: str
    body_a: str
    body_b: str
    point: str

    @property
    def point_a(self) -> str:
        """The joint's point on body a."""
        return self.point

    @property
    def point_b(self) -> str:
        """The joint's point on body b."""
        return self.point


_At = TypeVar("_At", bound=_AtOnePoint)


@dataclass(frozen=True)
class Revolute(_AtOnePoint):
    """A pin: the point of this name on body a and on body b stay together."""

    n_constraints: ClassVar[int] = 2


@dataclass(frozen=True)
class Fixed(_AtOnePoint):
    """A weld: the point of this name stays together and the bodies keep their assembled angle."""

    n_constraints: ClassVar[int] = 3


@dataclass(frozen=True)
class _OnLine:
    """A joint whose point b of body b stays on a line of body a.

    point_a    a point of body a on the line
    direction  of the line, in the frame of body a (any length)
    ends       mm along the direction from point a, between which point b may be; None: no ends
    """

    name: str
    body_a: str
    body_b: str
    point_a: str
    point_b: str
    direction: Vector
    ends: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        _check_direction(f"joint {self.name!r}", self.direction)
        _check_ends(f"joint {self.name!r}", self.ends)


@dataclass(frozen=True)
class Slot(_OnLine):
    """A pin in a slot: point b of body b stays on a line of body a; friction-free force is normal.

    Fields are those of every joint on a line: names, points, direction of the line and its ends.
    """

    n_constraints: ClassVar[int] = 1


@dataclass(frozen=True)
class Prismatic(_OnLine):
    """A guide: as a slot, and body b keeps its assembled angle to body a."""

    n_constraints: ClassVar[int] = 2


Joint = Revolute | Prismatic | Slot | Fixed


def shared_pins(joints: Iterable[Joint]) -> list[list[Revolute]]:
    """Return the pins of a linkage, each as the joints that pair the bodies on it.

    One joint fewer than bodies; which bodies they pair is up to who wrote them.
    """
    return _joined(joint for joint in joints if isinstance(joint, Revolute))


def shared_points(joints: Iterable[Joint]) -> list[list[_AtOnePoint]]:
    """Return the points at which bodies are pinned or welded, each as its joints.

    Which of the bodies that are welded there a pin pairs is up to who wrote them, too.
    """
    return _joined(joint for joint in joints if isinstance(joint, _AtOnePoint))


def _joined(joints: Iterable[_At]) -> list[list[_At]]:
    points: list[list[_At]] = []
    for joint in joints:
        on = [point for point in points if any(_at_one_point(joint, other) for other in point)]
        points = [point for point in points if point not in on]
        points.append([*(other for point in on for other in point), joint])
    return points


def _at_one_point(one: _AtOnePoint, other: _AtOnePoint) -> bool:
    bodies = {one.body_a, one.body_b} & {other.body_a, other.body_b}
    return one.point == other.point and bool(bodies)


@dataclass(frozen=True)
class PointCoordinate:
    """Position of a point along a direction of the ground frame, from its origin [mm].

    follows  body in whose frame the direction stands and with which it turns. Along such a
             direction a point has a speed, so that a force along it has power, but no position:
             the way depends on the path. It serves forces only, not a sweep, pace or table.
    """

    body: str
    point: str
    direction: Vector
    follows: str = GROUND
    angular: ClassVar[bool] = False

    def __post_init__(self) -> None:
        _check_direction(self.label, self.direction)

    @property
    def label(self) -> str:
        """The coordinate as messages call it."""
        x, y = (float(value) for value in self.direction)
        if self.follows != GROUND:
            return f"{self.point} along ({x:g}, {y:g}) of {self.follows}"
        if x and y:
            return f"{self.point} along ({x:g}, {y:g})"
        return f"{'-' if x + y < 0.0 else ''}{self.point}.{'x' if x else 'y'}"

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it measures."""
        return (self.body,)


@dataclass(frozen=True)
class Distance:
    """Distance between two points of two bodies [mm].

    force  name of the force whose length it is, for messages; "" where they name the points
    """

    body_a: str
    point_a: str
    body_b: str
    point_b: str
    force: str = field(default="", compare=False)
    angular: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """The coordinate as messages call it."""
        return f"{self.force}.length" if self.force else f"distance {self.point_a}-{self.point_b}"

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it measures."""
        return (self.body_a, self.body_b)


@dataclass(frozen=True)
class Angle:
    """Angle of a body, ccw, from the ground frame or from another body [rad].

    point  where a torque along this coordinate enters the body (and the other body, if it has
           that point); needed only to hand the body's loads to a model of the part
    """

    body: str
    relative_to: str = GROUND
    point: str | None = None
    angular: ClassVar[bool] = True

    @property
    def label(self) -> str:
        """The coordinate as messages call it."""
        return f"{self.body}.angle"

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it measures."""
        return (self.body, self.relative_to)


Coordinate = PointCoordinate | Distance | Angle


def same_coordinate(one: Coordinate, other: Coordinate) -> bool:
    """Return True for one coordinate, however it is stated."""
    match one, other:
        case Angle(), Angle():
            return (one.body, one.relative_to) == (other.body, other.relative_to)
        case Distance(), Distance():
            ends, others = ({(d.body_a, d.point_a), (d.body_b, d.point_b)} for d in (one, other))
            return ends == others
        case PointCoordinate(), PointCoordinate():
            return one == other
    return False


def in_words(coordinate: Coordinate, value: float) -> str:
    """Return a value of a coordinate as messages show it: angles in degrees."""
    if coordinate.angular:
        return f"{degrees(value):.7g} deg"
    return f"{value:.7g} mm"


def place_in_words(coordinate: Coordinate, value: float) -> str:
    """Return a place of the motion as messages show it, such as A.y = 300 mm."""
    return f"{coordinate.label} = {in_words(coordinate, value)}"


@dataclass(frozen=True)
class Force:
    """A force (torque for an angle): positive times ``sign`` acts to increase its coordinate.

    A pulling cylinder is a distance with sign -1.
    """

    name: str
    coordinate: Coordinate
    sign: int = 1

    def __post_init__(self) -> None:
        if self.sign not in (1, -1):
            raise LinkageError(f"force {self.name!r}: sign must be 1 or -1, got {self.sign}")


@dataclass(frozen=True)
class Friction:
    """Coulomb friction of a joint: coefficient, for a pin its radius, for a guide its length [mm].

    A guide of a length has two bearings in that distance, half of it on either side of its point,
    which bear its couple; of length 0 its couple rubs nowhere.
    """

    coefficient: float
    radius: float = 0.0
    length: float = 0.0

    def __post_init__(self) -> None:
        numbers = {"coefficient": self.coefficient, "radius": self.radius, "length": self.length}
        for quantity, value in numbers.items():
            if not (isfinite(value) and value >= 0.0):
                raise LinkageError(f"friction: {quantity} must be 0 or above, got {value:g}")


# Compliance of a linkage: bodies and joints with small elastic deflections, as numbers.


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
