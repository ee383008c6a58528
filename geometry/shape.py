"""The part shapes of design files, and the solids that are built of them to be meshed.

A shape is a frozen dataclass that derives from `Shape`, in a module of its own in `geometry/parts`;
its formula model is a module of its own in `checks/models/shapes` (docs/extending.md).
"""

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, log10
from statistics import median
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeGuard, TypeVar

import numpy as np

from geometry.bars import Bar, RulingSection, Section, Walls
from geometry.mesh import SYMMETRY, FloatArray, Interface, MeshError
from geometry.parameters import GIVEN_BY_LINKAGE as LINKAGE
from geometry.parameters import ParameterError

# Peak beside a pin over the mean of the net section, 2.8 in lugs at least, times Marin's 0.85.
_BORE_PEAK = 2.4


@dataclass(frozen=True)
class Region:
    """A target size near some surfaces or curves.

    entities  (dimension, tag) pairs of gmsh
    size      mm, on the entities
    reach     mm, distance at which the size has grown to the part's general size
    """

    entities: Sequence[tuple[int, int]]
    size: float
    reach: float


@dataclass(frozen=True)
class Body:
    """A solid built in the running gmsh session, and what the mesher must know of it.

    Its lengths are in the unit in which it is built, mm but for very small and very large parts.

    surfaces    name -> tags of its CAD faces
    interfaces  the places where other parts press
    size        general element size
    regions     where elements are smaller
    stacked     True if it is several solids that share faces normal to y (made conformal in gmsh);
                they keep nodes of their own there, with equal displacement along y
    bolted_at   x of the plane in which a stack's solids do not slide on each other either
    half        True if it is the half at z >= 0 of a part (geometry/shape.py)
    """

    surfaces: Mapping[str, Sequence[int]]
    interfaces: Sequence[Interface]
    size: float
    regions: Sequence[Region]
    stacked: bool = False
    bolted_at: float | None = None
    half: bool = False


class Buildable(Protocol):
    """A shape that can build itself with gmsh's OpenCASCADE kernel."""

    def build(self, gmsh: Any) -> Body:
        """Build the solid in gmsh's current model and say what stands where."""
        ...


def faces_where(gmsh: Any, test: Callable[[Any, str], bool]) -> list[int]:
    """Tags of the CAD faces whose bounding box (6,) and type pass the test."""
    found = []
    for _, tag in gmsh.model.getEntities(2):
        box = np.array(gmsh.model.getBoundingBox(2, tag))
        if test(box, gmsh.model.getType(2, tag)):
            found.append(tag)
    return found


@dataclass(frozen=True)
class Ligament:
    """Material behind a hole: mm2 in one shear plane, and the name of its other side.

    direction  unit vector in the part's axes in which a force on the part tears it; None: any
    round      of an end round about the hole, which bears what does not point into the part: the
               part's width over the end's; 0 where the end is not round
    """

    direction: tuple[float, float] | None
    area: float
    until: str
    round: float = 0.0


@dataclass(frozen=True)
class Shape(ABC):
    """A part in its own axes: x along it, z along the pins, lengths in mm.

    The first interface is at the origin, the second at x = `length`.

    name             by which design files call the shape; "" for one that has another way in
    may_buckle       False for what has no compression along x worth a check
    stressed_evenly  True where axial force decides, for Marin's load factor
    middle_plane     True if z = 0 is a plane of symmetry, at which `named` finds a half, too
    """

    name: ClassVar[str] = ""
    stressed_evenly: ClassVar[bool] = False
    middle_plane: ClassVar[bool] = False
    may_buckle: ClassVar[bool] = True
    if TYPE_CHECKING:  # a field of most shapes

        @property
        def length(self) -> float:
            """Distance of the first two interfaces; of a pin its whole length, mm."""
            ...

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the places where other parts press, a constant of most shapes.

        Empty for a pin, whose stack has them.
        """
        return ()

    @classmethod
    def fixed_interfaces(cls) -> tuple[str, ...]:
        """The names of `interfaces` where all parts of the shape have the same; else none."""
        names = cls.interfaces
        return names if isinstance(names, tuple) else ()

    @property
    def pin_places(self) -> dict[str, float]:
        """Places along x, mm, of the first two interfaces by name."""
        return dict(zip(self.interfaces[:2], (0.0, self.length), strict=True))

    @abstractmethod
    def build(self, gmsh: Any) -> Body:
        """Build the solid in gmsh's current model and say what stands where."""

    def named(self, gmsh: Any) -> Body:
        """Return the body that stands in gmsh's current model, the solid or its half at z >= 0."""
        raise NotImplementedError(f"{type(self).__name__} has no middle plane")

    @property
    @abstractmethod
    def placed_interfaces(self) -> list[Interface]:
        """The interfaces, where they stand and how large they are."""

    @property
    @abstractmethod
    def stressed_section(self) -> tuple[float, ...]:
        """Height in the plane and thickness, or one diameter, mm, for Marin's size factor."""

    @property
    @abstractmethod
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material."""

    @property
    def sections(self) -> Sequence[Section]:
        """Sections that are compressed along the length, as columns; none of what is bent."""
        return ()

    @property
    def net_section(self) -> float | None:
        """Least area, mm2, beside the holes of its two bores; None where that is not known."""
        return None

    @property
    def shank_decides(self) -> bool:
        """True where a bar between bores is so thin that its even stress is above their peaks."""
        net = self.net_section
        if net is None or not self.sections:
            return False
        return _BORE_PEAK * min(section.area for section in self.sections) < net

    @property
    def walls(self) -> Sequence[Walls]:
        """Stretches across which a weld may run, the stress there known; none of most shapes.

        A shape that has them tells its `profile`, of which the forces at a weld are.
        """
        return ()

    @property
    def notch_factors(self) -> Mapping[str, float]:
        """Fatigue notch factors by surface, of what the mesh does not show."""
        return {}

    @property
    def proportions(self) -> Mapping[str, float]:
        """Ratios of its sizes, by name, on which the error of its formula model depends.

        Names such as "hole / width"; one that begins with "length / " has no upper end in buckling.
        Empty for a shape whose proportions are not known: then no band of solids holds for it.
        """
        return {}

    def link(self, poisson_ratio: float) -> Bar | None:
        """The bar that it is between its first two interfaces; None for a shape that is no bar.

        Sections are taken without the bores: a pin fills them, and in compression its force enters
        beyond. With the linkage's other links it makes the frame whose buckling is checked.
        """
        return None

    @property
    def profile(self) -> Bar | None:
        """The bar that it is from end to end, bores taken out; None where that is not known.

        Section forces at its welds follow from it.
        """
        return None

    @property
    def bending(self) -> tuple[float, float, str] | None:
        """Least second moment in the plane, mm4, least area, mm2, and what it is of, in words.

        All along the part, for the vibration of the linkage; None for a shape that is no bar.
        """
        if not self.sections:
            return None
        least = min(self.sections, key=lambda section: section.inertia_in_plane)
        return least.inertia_in_plane, min(one.area for one in self.sections), least.name

    def ligaments(self, interface: str) -> Sequence[Ligament] | None:
        """Ligaments that a pin can tear out of a bore; None where they are measured on the mesh."""
        return ()

    def outward(self, interface: str) -> tuple[tuple[float, float], str]:
        """Direction from a bore to the end of the part behind it, and that end in words."""
        if interface == self.interfaces[0]:
            return (-1.0, 0.0), "the end at x < 0"
        return (1.0, 0.0), f"the end at x > {self.length:g} mm"

    def stated_bore(self, interface: str) -> float | None:
        """Stated diameter of the bore at an interface, mm; None where it has no bore there."""
        bores = {one.name: 2 * one.radius for one in self.placed_interfaces if one.kind == "bore"}
        return bores.get(interface)

    def bore_key(self, interface: str) -> str:
        """Key of the part's entry that states that diameter."""
        return "hole"

    @property
    def clear_width(self) -> float | None:
        """Clear width, mm, between the walls of a part that is loaded on its end faces."""
        return None

    @property
    def cheeks_at(self) -> float | None:
        """Height +-z of the middles of the cheeks of a part that has two, mm."""
        return None

    @property
    def cheeks_turn(self) -> float:
        """Least turn of one of its two cheeks under a couple of the pressure in its bore, with it.

        Times E over the couple, 1/mm3; 0 where it is not known: then it may be held.
        """
        return 0.0

    @property
    def told(self) -> Sequence[str]:
        """Notes on the reading of its file: sentences for the report."""
        return ()

    @property
    def drawn_sizes(self) -> Mapping[str, float]:
        """Sizes that its file has, mm, by the keys of the part's entry that would change them."""
        return {}

    @property
    def heights(self) -> Mapping[str, float]:
        """Height z, mm, of the middle of each interface that is not in the middle plane."""
        return {}

    @property
    def shifts(self) -> Mapping[str, tuple[float, float]]:
        """Interface -> mm, from its point of the linkage to where the part has it."""
        return {}


# Half of a part that is its own mirror image about z = 0, for loads that are so too. A load without
# a component out of the plane acts alike, mirrored, on both sides of the middle plane: half the
# part, with no displacement along z where it was cut, gives the same stress with half the unknowns
# (docs/theory/symmetry.md).
_BESIDE = 1e-6  # of its size: how far the mirror image of a surface may lie beside the part
_UNEVEN = 1e-3  # of its volume: the kernel integrates that of slender rods to some 3e-4 only
_PLACES = (0.07, 0.29, 0.5, 0.71, 0.93)  # of a face's two parameters: where it is compared


class Mirrored(Buildable, Protocol):
    """A shape that says of itself that it is its own mirror image about z = 0.

    Its surface must cross that plane at right angles, where it does.
    """

    middle_plane: ClassVar[bool]

    @property
    def length(self) -> float:
        """Distance between its first two interfaces, mm."""
        ...

    def named(self, gmsh: Any) -> Body:
        """Return the body that stands in gmsh's current model, the solid or its half at z >= 0."""
        ...


def has_middle_plane(shape: Buildable) -> TypeGuard[Mirrored]:
    """Return True if a shape may be halved at a middle plane."""
    return bool(getattr(shape, "middle_plane", False))


@dataclass(frozen=True)
class Half:
    """The half at z >= 0 of a shape, to be meshed in its place."""

    whole: Mirrored

    def __post_init__(self) -> None:
        if not has_middle_plane(self.whole):
            raise MeshError(f"a {type(self.whole).__name__} has no middle plane to be halved at")

    def build(self, gmsh: Any) -> Body:
        """Build the shape in gmsh's current model and cut it.

        Raises MeshError if its halves are not alike.
        """
        self.whole.build(gmsh)
        occ = gmsh.model.occ
        solids = gmsh.model.getEntities(3)
        low, high = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        size = float((high - low).max())
        _check_mirror_image(gmsh, size)
        before = _volume(gmsh)
        start, extent = low[:2] - size, high - low + 2 * size
        occ.intersect(solids, [(3, occ.addBox(*start, 0.0, *extent))])
        occ.synchronize()
        if abs(2 * _volume(gmsh) / before - 1) > _UNEVEN:
            raise MeshError(f"the cut at z = 0 leaves {_volume(gmsh) / before:.6g} of the volume")
        body = self.whole.named(gmsh)
        near = 1e-6 * size
        cut = faces_where(
            gmsh, lambda box, kind: kind == "Plane" and bool(np.abs(box[[2, 5]]).max() < near)
        )
        return replace(
            body,
            surfaces={**body.surfaces, SYMMETRY: cut},
            interfaces=[replace(interface, tilts=False) for interface in body.interfaces],
            half=True,
        )


def _volume(gmsh: Any) -> float:
    """Volume of the bodies in the model."""
    return float(sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3)))


def _check_mirror_image(gmsh: Any, size: float) -> None:
    """MeshError unless the mirror images of points on every face lie on faces of the part.

    Points, not integrals: the kernel's volume of a slender rod errs by more than a step of 0.1 mm
    in it is worth.
    """
    near = _BESIDE * size
    solids = gmsh.model.getEntities(3)
    faces = [tag for _, tag in gmsh.model.getBoundary(solids, oriented=False)]
    boxes = np.array([gmsh.model.getBoundingBox(2, tag) for tag in faces]).reshape(-1, 2, 3)
    for tag in faces:
        image = _points_of(gmsh, tag) * [1, 1, -1]
        beside = np.full(len(image), np.inf)
        for other, (low, high) in zip(faces, boxes, strict=True):
            asked = ((image > low - near) & (image < high + near)).all(axis=1) & (beside > near)
            if asked.any():
                closest, _ = gmsh.model.getClosestPoint(2, other, image[asked].ravel())
                away = np.linalg.norm(image[asked] - np.reshape(closest, (-1, 3)), axis=1)
                beside[asked] = np.minimum(beside[asked], away)
        if beside.max(initial=0.0) > near:
            x, y, z = image[beside.argmax()] * [1, 1, -1]
            raise MeshError(
                f"the part is not its own mirror image about z = 0: its surface at x = {x:.6g}, "
                f"y = {y:.6g}, z = {z:.6g} mm has none at z = {-z:.6g} mm"
            )


def _points_of(gmsh: Any, tag: int) -> FloatArray:
    """Places on a face, (n, 3): those of a grid of its parameters that lie within its edges."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    grid = np.stack(np.meshgrid(_PLACES, _PLACES), axis=-1).reshape(-1, 2)
    places = [at for at in low + grid * (high - low) if gmsh.model.isInside(2, tag, at, True)]
    return np.reshape(gmsh.model.getValue(2, tag, np.ravel(places)), (-1, 3))


# Sizes of a shape: the smallest and largest that a part of a machine has, and their ratio.
LEAST, MOST = 1e-6, 1e7  # mm: a nanometre and 10 km
FARTHEST = 1e6  # largest over smallest size of one part: squares and cubes stay within double
_NO_SIZES = ("at",)  # where something stands: 0 but for round-off is one of them


def sizes_of(shape: Any) -> dict[str, float]:
    """Return every length of a shape that is not 0, mm, without its sign; of seats as a `stack`."""
    return dict(_sizes(shape))


def _sizes(shape: Any) -> Iterator[tuple[str, float]]:
    for parameter in dataclasses.fields(shape):
        value = getattr(shape, parameter.name)
        if parameter.name == "seats":
            for index, seat in enumerate(value):
                yield from ((f"stack[{index}].{key}", size) for key, size in _sizes(seat))
        elif parameter.name == "holes":
            for hole in value:
                yield from ((f"holes.{hole.name}.{key}", size) for key, size in _sizes(hole))
        elif parameter.metadata.get("dimension") == "length":
            many = value if isinstance(value, tuple) else (value,)
            for index, size in enumerate(many):
                if size:
                    name = parameter.name if value is size else f"{parameter.name}[{index}]"
                    yield name, abs(float(size))


def far_apart(sizes: dict[str, float]) -> tuple[str, str]:
    """Return the key of the size that is farthest from the usual one, and that at the other end."""
    least, most = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    usual = median(sizes.values())
    return (most, least) if sizes[most] / usual > usual / sizes[least] else (least, most)


def key_of(shape: type[Any] | Any, name: str) -> str:
    """Return the key that a size comes from: distances between pins follow from `interfaces`."""
    linked = (f.name for f in dataclasses.fields(shape) if f.metadata.get("given_by") == LINKAGE)
    return "interfaces" if name in linked else name


def check_sizes(shape: Any) -> None:
    """Raise ParameterError where a size is none of a machine's part, or far from its others.

    Numbers beyond that are accepted by no model: a mesh cannot have both sizes, and a frame's
    stiffness loses its digits.
    """
    sizes = sizes_of(shape)
    small = {name: size for name, size in sizes.items() if name.rpartition(".")[2] not in _NO_SIZES}
    for name, size in sizes.items():
        least = LEAST if name in small else 0.0
        if not least <= size <= MOST:
            raise ParameterError(
                name,
                f"must be between {LEAST:g} and {MOST:g} mm, as of any part of a machine, got "
                f"{size:g} mm; is its unit wrong?",
            )
    if not small:
        return
    known = {name: size for name, size in sizes.items() if size >= min(small.values())}
    odd, other = far_apart(known)
    ratio = max(known.values()) / min(known.values())
    if ratio > FARTHEST:
        raise ParameterError(
            odd,
            f"{sizes[odd]:g} mm is too far from {other} = {sizes[other]:g} mm: the largest size "
            f"of a part may be {FARTHEST:g} times the smallest; is its unit wrong?",
        )


# The unit of length in which a shape is built and meshed, so that its size is 3 to 3000 of them.
#
# gmsh and its CAD kernel have absolute tolerances, 1e-8 and 1e-7 of whatever the unit is: a part
# of 1 um or of 1 km has no mesh by them, or another one than the same part has in mm. Units are
# 1000 times apart, so that most parts of machines are meshed in mm.

_LEAST = 3.0  # of a unit: the largest length that a shape states is from here to 1000 times as much
_DECADES = 3  # between units

T = TypeVar("T")


def unit_of(shape: Any) -> float:
    """Return the unit in mm, a power of 1000, by the largest length that a shape states.

    1 for a shape that states none, such as a file from CAD.
    """
    whole = getattr(shape, "whole", shape)
    sizes = sizes_of(whole) if dataclasses.is_dataclass(whole) else {}
    if not sizes:
        return 1.0
    steps = floor(log10(max(sizes.values()) / _LEAST) / _DECADES)
    return float(f"1e{_DECADES * steps}")


def in_unit(shape: T, unit: float) -> T:
    """Return a shape with its lengths in a unit of so many mm, to the 12 digits they have."""
    if unit == 1.0:
        return shape
    changed: T = _changed(shape, lambda length: float(f"{length / unit:.12g}"))
    return changed


def _changed(shape: Any, change: Callable[[float], float]) -> Any:
    """Return a shape with every length changed; of seats and of a shape that is halved, too."""
    changed: dict[str, Any] = {}
    for parameter in dataclasses.fields(shape):
        name, value = parameter.name, getattr(shape, parameter.name)
        if name == "whole":
            changed[name] = _changed(value, change)
        elif name in ("seats", "holes"):
            changed[name] = tuple(_changed(one, change) for one in value)
        elif parameter.metadata.get("dimension") == "length" and value is not None:
            many = isinstance(value, tuple)
            changed[name] = tuple(change(one) for one in value) if many else change(value)
    return dataclasses.replace(shape, **changed)
