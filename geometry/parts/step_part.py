"""A part as CAD has it: the one solid of a STEP file, loaded at its named holes and journals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from math import cos, degrees, hypot, radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.bars import RulingSection, Section, fine_cells
from geometry.mesh import FloatArray, Interface, MeshError
from geometry.parameters import ParameterError, check_above
from geometry.round_faces import Hole
from geometry.shape import Body, Region, Shape
from geometry.step_file import StepSolid, extruded, file_hash, import_solid, survey_plate, surveyed

if TYPE_CHECKING:
    from geometry.slices import Slice

_PARALLEL = radians(0.1)
_BORE_ELEMENTS = 9.0  # elements along the radius of a named hole, as in the parametric parts
_FILLET_ELEMENTS = 1.5  # of a fillet or another hole: enough to see there what the error is
_FINEST = 6.0  # times smaller than in general at the most, before any error is known
_MOST_TOLD = 40  # holes in one message
_STATED = 1e-3  # mm, how exactly points are usually stated
_FACETS = 32  # of a full turn: a circle's second moment to 1.3 %
_ALIKE = 1e-6  # of a thickness that is stated twice
_CELLS = 64  # of the whole part
_MARKS = 500  # of the holes' distance: edges that are nearer along x are one
_STRAIGHT = 1e-3  # of the outermost holes' distance: how far holes and centroids may lie beside it
_APART = 1e-6  # mm: sections that are nearer are one
_STEEP = 0.3  # mm per mm: where centroids climb faster, planes cut the bar askew
_OF_TWO = 0.3  # of the area at a hole: the smaller side of one lug; forks have four
_CHANGED = 100.0  # times the thickness in the file, or a part of it: beyond, no unit is meant so
_LUG = 0.1  # of a bore: what a pin presses on is as thick, or dishes (docs/theory/buckling.md)

Triple = tuple[float, float, float]
Pair = tuple[float, float]


@dataclass(frozen=True)
class NamedHole:
    """A hole that is to be found in the file.

    diameter  mm
    at        mm, a point on its axis in the file's own frame, where several have the diameter
    kind      "bore", or "journal": a shaft's end or a boss that a lug goes round
    """

    name: str
    diameter: float
    at: Triple | None = None
    kind: str = "bore"

    def __post_init__(self) -> None:
        check_above(f"holes.{self.name}.diameter", self.diameter, 0)
        if self.kind not in ("bore", "journal"):
            raise ParameterError(
                f"holes.{self.name}.kind", f"must be bore or journal, got {self.kind!r}"
            )


@dataclass(frozen=True)
class StepPart(Shape):
    """The one solid of a STEP file, moved into the part's frame; its interfaces are named holes.

    The first hole's axis is z, its middle the origin, and the second hole stands on +x. z points
    along the axis of the file that is nearest to it, against it where `flip` is set.

    holes      at least two, the first two make the frame
    places     mm, where the linkage has the holes' axes in this frame; None: wherever they are
    tolerance  mm, on diameters, on points of an axis, and on `places`
    section    mm, height and thickness of the stressed section for Marin's size factor, or None
    thickness  mm, along z, of a plate that the file has in another one, or None
    sha256     of the file, by which parts are told apart

    Raises ParameterError for a file or holes that cannot be meant.
    """

    path: Path = field(compare=False)
    holes: tuple[NamedHole, ...]
    places: tuple[Pair, ...] | None = None
    tolerance: float = 0.05
    flip: bool = False
    section: Pair | None = None
    thickness: float | None = None
    sha256: str = field(init=False)

    def __post_init__(self) -> None:
        if len(self.holes) < 2:
            raise ParameterError("holes", f"needs at least two holes, got {len(self.holes)}")
        names = [hole.name for hole in self.holes]
        if len(set(names)) < len(names):
            raise ParameterError("holes", f"two have the same name among {', '.join(names)}")
        if self.places is not None and len(self.places) != len(self.holes):
            raise ValueError(f"{len(self.holes)} holes need as many places, got {self.places}")
        check_above("hole_tolerance", self.tolerance, 0)
        for size in self.section or ():
            check_above("section", size, 0)
        object.__setattr__(self, "sha256", file_hash(self.path))
        self._check_thickness()
        self._check_axes()
        self._check_plain()
        self._check_places()

    @cached_property
    def drawn(self) -> StepSolid:
        """Solid of the file, in the file's own frame."""
        return surveyed(self.path, self.sha256)

    @cached_property
    def solid(self) -> StepSolid:
        """Solid of the part, with its own thickness, in the file's own frame."""
        if self.thickness is None:
            return self.drawn
        return survey_plate(self.path, self.sha256, self._through, self.thickness)

    @cached_property
    def _through(self) -> Triple:
        """Unit vector along the pins in the file's frame."""
        x, y, z = self._match(self.holes[0], self.drawn).direction.tolist()
        return x, y, z

    @cached_property
    def _drawn_thickness(self) -> float:
        """Size of the file's solid along the pins, mm."""
        return float(np.ptp(self.drawn.outline @ self._through))

    @property
    def drawn_sizes(self) -> Mapping[str, float]:
        """The thickness of the file, mm, where the part has it."""
        return {} if self.thickness is not None else {"thickness": self._drawn_thickness}

    def _check_thickness(self) -> None:
        thickness = self.thickness
        if thickness is None:
            return
        check_above("thickness", thickness, 0)
        drawn = self._drawn_thickness
        if not 1 / _CHANGED <= thickness / drawn <= _CHANGED:
            raise ParameterError(
                "thickness",
                f"{thickness:g} mm is more than {_CHANGED:g} times away from the {drawn:.6g} mm "
                f"that {self.path.name} has along its pins; is its unit wrong?",
            )
        if self.section is not None and abs(self.section[1] / thickness - 1) > _ALIKE:
            raise ParameterError(
                "section",
                f"is {self.section[1]:g} mm thick along the pins, but `thickness` is "
                f"{thickness:g} mm; leave it out, or state the same",
            )

    @cached_property
    def found(self) -> Mapping[str, Hole]:
        """The named holes, in the file's own frame."""
        found: dict[str, Hole] = {}
        for named in self.holes:
            hole = self._match(named, self.solid)
            for other, taken in found.items():
                if taken is hole:
                    raise ParameterError(
                        f"holes.{named.name}",
                        f"is the same hole as {other}: {hole}; {self._told_holes()}",
                    )
            found[named.name] = hole
        return found

    def _match(self, named: NamedHole, solid: StepSolid) -> Hole:
        """Return the one hole that a name can mean."""
        key = f"holes.{named.name}"
        wide = [hole for hole in solid.holes if self._has_size(named, hole)]
        fits = [hole for hole in wide if self._is_at(named, hole)]
        what = f"{named.kind} of {named.diameter:g} mm"
        where = ""
        if named.at is not None:
            where = " through ({:g}, {:g}, {:g}) mm".format(*named.at)
        if not fits:
            partial = [entry for entry in solid.partial if entry.startswith(what + " ")]
            only = f"; only a {partial[0]}" if partial else ""
            hints = [_unit_hint(named.diameter, hole.diameter) for hole in solid.holes]
            only += max(hints, key=len, default="")
            raise ParameterError(
                key,
                f"no {what}{where} is in {self.path.name} within {self.tolerance:g} mm"
                f"{only}; {self._told_holes()}",
            )
        if len(fits) > 1:
            raise ParameterError(
                key,
                f"{len(fits)} holes of {self.path.name} are a {what}{where}: `at` must say which, "
                f"by a point of its axis in the file's frame; {self._told_holes()}",
            )
        return fits[0]

    def _has_size(self, named: NamedHole, hole: Hole) -> bool:
        return hole.kind == named.kind and abs(hole.diameter - named.diameter) <= self.tolerance

    def _is_at(self, named: NamedHole, hole: Hole) -> bool:
        return named.at is None or hole.distance_to(np.array(named.at)) <= self.tolerance

    def _told_holes(self) -> str:
        holes = self.drawn.holes
        if not holes:
            return "the part has no round hole or journal"
        more = f"; and {len(holes) - _MOST_TOLD} more" if len(holes) > _MOST_TOLD else ""
        return "there are " + "; ".join(map(str, holes[:_MOST_TOLD])) + more

    def _check_axes(self) -> None:
        first, *others = self.found.items()
        for name, hole in others:
            if abs(float(hole.direction @ first[1].direction)) < cos(_PARALLEL):
                angle = degrees(
                    np.arcsin(np.linalg.norm(np.cross(hole.direction, first[1].direction)))
                )
                raise ParameterError(
                    f"holes.{name}",
                    f"stands at {angle:.3g} deg to {first[0]}: the pins of a plane linkage are "
                    f"parallel (within 0.1 deg); {self._told_holes()}",
                )
        names = list(self.found)
        if not self.length > self.tolerance:
            raise ParameterError(
                f"holes.{names[1]}", f"has the same axis as {names[0]}: there is no x axis"
            )

    def _check_plain(self) -> None:
        for name, hole in self.found.items():
            if not hole.plain:
                raise ParameterError(
                    f"holes.{name}",
                    f"something cuts into the {hole}: a cross hole, a keyway or a slanted end; "
                    "only plain cylinders can be loaded yet, leave the cut out of the CAD model",
                )

    def _check_places(self) -> None:
        if self.places is None:
            return
        first, second, *others = self.found
        stated = hypot(*np.subtract(self.places[1], self.places[0]))
        if abs(stated - self.length) > self.tolerance:
            raise ParameterError(
                f"holes.{second}",
                f"is {self.length:.6g} mm from {first} in {self.path.name} and {stated:.6g} mm in "
                f"the linkage, more than {self.tolerance:g} mm apart"
                + _unit_hint(stated, self.length),
            )
        for name in others:
            here, wanted = self.centre(name)[:2], self._place(name)
            if np.linalg.norm(here - wanted) <= self.tolerance:
                continue
            mirrored = np.linalg.norm(here * [1, -1] - wanted) <= self.tolerance
            hint = f"; flip = {str(not self.flip).lower()} puts it there" if mirrored else ""
            raise ParameterError(
                f"holes.{name}",
                f"is at ({here[0]:.6g}, {here[1]:.6g}) mm in {self.path.name} and at "
                f"({wanted[0]:.6g}, {wanted[1]:.6g}) mm in the linkage, from {first} with x "
                f"towards {second}{hint}",
            )

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the holes; the first two make the frame."""
        return tuple(hole.name for hole in self.holes)

    @property
    def length(self) -> float:
        """Distance of the first two axes in the file, mm."""
        first, second, *_ = self.found.values()
        return second.distance_to(first.centre)

    @cached_property
    def axes(self) -> FloatArray:
        """The part's x, y and z axis in the file's frame, as rows."""
        first, second, *_ = self.found.values()
        z = -first.direction if self.flip else first.direction
        x = second.centre - first.centre
        x = x - (x @ z) * z
        x /= np.linalg.norm(x)
        return np.stack([x, np.cross(z, x), z])

    def centre(self, name: str) -> FloatArray:
        """Middle of a hole's surface in the part's frame, (3,) mm."""
        return self._in_part(self.found[name].centre)

    def _in_part(self, point: FloatArray) -> FloatArray:
        return np.asarray(self.axes @ (point - next(iter(self.found.values())).centre))

    def _place(self, name: str) -> FloatArray:
        """Where the linkage has a hole, (2,) mm, or else where the file has it."""
        if self.places is None:
            return self.centre(name)[:2]
        return np.array(self.places[self.interfaces.index(name)])

    @property
    def shifts(self) -> Mapping[str, Pair]:
        """Offset (x, y) of each hole from its place in the linkage, mm."""
        moved = {name: self.centre(name)[:2] - self._place(name) for name in self.interfaces}
        return {name: (float(x), float(y)) for name, (x, y) in moved.items()}

    @property
    def heights(self) -> Mapping[str, float]:
        """Height z of each hole's middle above the middle of the first hole, mm."""
        return {name: float(self.centre(name)[2]) for name in self.interfaces}

    @cached_property
    def _extents(self) -> FloatArray:
        """Size of the solid along the part's axes, (3,) mm."""
        return np.asarray(np.ptp(self.solid.outline @ self.axes.T, axis=0))

    @property
    def sections(self) -> Sequence[Section]:
        """Sections of a straight bar between two bores, as planes cut it; none of another part."""
        return self._column[0]

    @cached_property
    def net_section(self) -> float | None:
        """Least area beside the holes of two bores that a bar joins, mm2."""
        if not self.sections or any(hole.kind != "bore" for hole in self.holes):
            return None
        return min(one.area for one in bar_slices(self).at_holes)

    @cached_property
    def _column(self) -> tuple[Sequence[Section], str]:
        """Its sections as a column, or why it is not known as one, in words."""
        from geometry.slices import in_stretches

        if len(self.holes) != 2:
            return (), "it has more than two holes"
        try:
            cut = bar_slices(self)
        except MeshError as error:
            return (), f"its sections could not be cut: {error}"
        if not cut.straight:
            return (), "it is no straight bar between its bores, or presses thin lugs"
        if any(one.weak_area < one.area * (1 - _STRAIGHT) for one in cut.between):
            return (), "some of its sections are of several bodies"
        if any(one.weak_area < _OF_TWO * one.area for one in cut.at_holes):
            return (), "it has forks, or a hole with one thin side"
        aside = max(float(np.abs(one.centre).max()) for one in cut.between)
        if aside > _STRAIGHT * self.length:
            return (), f"its sections lie up to {aside:.2g} mm beside the line of its holes"
        ends = [self._place(name) for name in self.interfaces]  # as the linkage compresses it
        return in_stretches(cut.between, hypot(*(ends[1] - ends[0]))), ""

    @property
    def stressed_section(self) -> Pair:
        """The stated section, or one made up from the solid, height and thickness in mm.

        The latter is as high as the solid. Its thickness is 4 V / A, or 4 times the area of a
        section over its outline where that is more, at most the solid's: right for a round or
        square bar or a plate, twice the wall of a tube, which is the safe side.
        """
        return self.section or self._own_section[0]

    @cached_property
    def _own_section(self) -> tuple[Pair, str]:
        """The section made up from the solid, and how its thickness is found, in words."""
        height, thickness = (float(size) for size in self._extents[1:])
        try:
            thickest = max(one.thickness for one in bar_slices(self).cells)
        except MeshError as error:
            return (height, thickness), f"its whole thickness, as it could not be cut: {error}"
        found = min(thickness, max(2 * self.solid.wall, thickest))
        return (height, found), (
            "4 V/A or 4 times a section's area over its outline, at most its thickness"
        )

    def ligaments(self, interface: str) -> None:
        """None: they are measured on the mesh, in all directions."""

    def stated_bore(self, interface: str) -> float | None:
        """Stated diameter of a hole, mm; None for a journal."""
        named = next(hole for hole in self.holes if hole.name == interface)
        return named.diameter if named.kind == "bore" else None

    def bore(self, name: str) -> float:
        """Diameter of a hole in the file, mm; 0 of a journal, which is no hole."""
        hole = self.found[name]
        return hole.diameter if hole.kind == "bore" else 0.0

    @property
    def edges(self) -> FloatArray:
        """Points along the solid's edges in the part's frame, (n, 3) mm."""
        first = next(iter(self.found.values())).centre
        return np.asarray((self.solid.outline - first) @ self.axes.T)

    def bore_key(self, interface: str) -> str:
        """Key of the part's entry that states a hole's diameter."""
        return f"holes.{interface}.diameter"

    @property
    def told(self) -> tuple[str, ...]:
        """Notes on the reading of the file: sentences for the report."""
        said = [*self.drawn.told]
        if self.thickness is not None:
            said.append(
                f"it is {self.thickness:g} mm thick along its pins; {self.path.name} has "
                f"{self._drawn_thickness:.6g} mm, whose flat faces are offset alike"
            )
        why = self._column[1]
        if why:
            said.append(f"no column formula judged it, so yield was not checked by one: {why}")
        if self.section is None:
            (height, thickness), how = self._own_section
            said.append(
                "the stressed section of size factor and strength is "
                f"{height:.3g} x {thickness:.3g} mm: the solid's height, and {how}; `section` "
                "states another"
            )
        for name, (x, y) in self.shifts.items():
            if hypot(x, y) > _STATED:
                said.append(
                    f"{name} is {hypot(x, y):.2g} mm from where the linkage has it; its force acts "
                    "in the hole, with the couple that balances it"
                )
        first = self.interfaces[0]
        for name, z in self.heights.items():
            if abs(z) > _STATED:
                said.append(f"the middle of {name} is {z:.4g} mm out of the plane of {first}'s")
        z = float(self._in_part(self.solid.centre)[2])
        if abs(z) > _STATED:
            said.append(f"the centre of mass is {z:.3g} mm out of the plane of {first}'s middle")
        return tuple(said)

    def build(self, gmsh: Any) -> Body:
        """Read the solid into gmsh's current model and move it into the part's frame."""
        from scipy.spatial.transform import Rotation

        if file_hash(self.path) != self.sha256:
            raise MeshError(f"{self.path.name} has changed since it was first read")
        tag, _ = import_solid(gmsh, self.path)
        if self.thickness is not None:
            tag = extruded(gmsh, tag, self._through, self.thickness)
        assert tag == self.solid.tag, "gmsh numbers what it reads in the order of the file"
        occ, solid = gmsh.model.occ, [(3, tag)]
        occ.translate(solid, *(-next(iter(self.found.values())).centre))
        turn = Rotation.from_matrix(self.axes).as_rotvec()
        angle = float(np.linalg.norm(turn))
        if angle > 1e-14:
            occ.rotate(solid, 0, 0, 0, *(turn / angle), angle)
        occ.synchronize()
        return Body(
            surfaces={name: hole.faces for name, hole in self.found.items()},
            interfaces=self.placed_interfaces,
            size=self.solid.wall,
            regions=[*self._hole_regions(), *self._fillet_regions()],
        )

    @property
    def ruling_sections(self) -> tuple[RulingSection, ...]:
        """Sizes that grade the strength of its material: its holes', and of what lies between."""
        holes = (
            RulingSection(hole.diameter, round=True)
            if hole.kind == "journal"
            else RulingSection(hole.length)
            for hole in self.found.values()
        )
        return (*holes, RulingSection(min(self.stressed_section)))

    @property
    def placed_interfaces(self) -> list[Interface]:
        """Where other parts press on it."""
        return [self._interface(name) for name in self.interfaces]

    def _interface(self, name: str) -> Interface:
        hole = self.found[name]
        size = hole.diameter / 2, hole.length
        return Interface(name, hole.kind, self.centre(name), *size, tilts=True, piece=hole.piece)

    def _hole_regions(self) -> list[Region]:
        return [
            Region(
                [(2, face) for face in hole.faces],
                min(hole.diameter / 2 / _BORE_ELEMENTS, self.solid.wall),
                hole.diameter / 2,
            )
            for hole in self.found.values()
        ]

    def _fillet_regions(self) -> list[Region]:
        """Hollow curves that are sharper than the elements, but for the named holes."""
        size = self.solid.wall
        named = {face for hole in self.found.values() for face in hole.faces}
        groups: dict[float, list[tuple[int, int]]] = {}
        for entry in self.solid.curved:
            wanted = max(entry.radius / _FILLET_ELEMENTS, size / _FINEST)
            if entry.concave and entry.face not in named and wanted < size:
                groups.setdefault(round(wanted, 3), []).append((2, entry.face))
        return [
            Region(faces, wanted, _FILLET_ELEMENTS * wanted)
            for wanted, faces in sorted(groups.items())
        ]


def _unit_hint(stated: float, found: float) -> str:
    """Return a hint at mixed-up units if the ratio of two lengths suggests one, else ""."""
    apart = max(stated / found, found / stated)
    for factor, unit in ((25.4, "inches"), (1000.0, "metres"), (10.0, "centimetres")):
        if abs(apart / factor - 1) < 1e-3:
            return f"; {factor:g} times apart: were {unit} and mm mixed up?"
    return ""


@dataclass(frozen=True, eq=False)
class BarSlices:
    """Sections of a part along the line of its holes, x.

    cuts      (m + 1,) mm, ends of the cells of the whole part
    cells     at the middle of each
    at_holes  at the holes
    between   between the outermost holes, bores and journals left out, wherever an edge ends, too
    straight  True for a bar whose sections are square to it, without thin lugs
    """

    cuts: FloatArray
    cells: Sequence["Slice"]
    at_holes: Sequence["Slice"]
    between: Sequence["Slice"]
    straight: bool


@lru_cache(maxsize=16)
def bar_slices(shape: StepPart) -> BarSlices:
    """Cut a part along the line of its holes; raises MeshError.

    A batch asks for the same part again and again.
    """
    from geometry.cad_body import cad_skin
    from geometry.slices import sliced

    skin = cad_skin(shape, _FACETS)
    low, high = float(skin.nodes[:, 0].min()), float(skin.nodes[:, 0].max())
    centres = [shape.centre(name) for name in shape.interfaces]
    along = np.sort([float(centre[0]) for centre in centres])
    cuts = fine_cells(np.array([low, *(x for x in along if low < x < high), high]), _CELLS)
    cells = sliced(skin, (cuts[1:] + cuts[:-1]) / 2)
    named = zip(shape.found.values(), centres, strict=True)
    radii = {float(centre[0]): hole.diameter / 2 for hole, centre in named}
    first, last = along[0] + radii[along[0]], along[-1] - radii[along[-1]]
    step = max(last - first, 0.0) / _MARKS
    marks = np.unique(np.round(shape.edges[:, 0] / step)) * step if step else cuts[:0]
    places = np.union1d((marks[1:] + marks[:-1]) / 2, [one.place for one in cells])
    between = sliced(skin, places[(places > first) & (places < last)])
    at_holes = sliced(skin, along)
    aside = max(float(np.abs(centre[1:]).max()) for centre in centres)
    straight = aside <= _STRAIGHT * float(along[-1] - along[0]) and _is_bar(
        between, at_holes, max(shape.bore(name) for name in shape.interfaces)
    )
    return BarSlices(cuts, cells, at_holes, between, straight)


def _is_bar(between: Sequence["Slice"], at_holes: Sequence["Slice"], widest: float) -> bool:
    """True for sections square to the bar, and lugs that are not thin beside the widest bore."""
    if len(between) < 2:
        return False
    places, centres = (
        np.array([getattr(one, of) for one in between]) for of in ("place", "centre")
    )
    apart = np.append(True, np.diff(places) > _APART)
    steep = np.abs(np.gradient(centres[apart], places[apart], axis=0)).max()
    lugs = [one.weak_area / one.breadth for one in at_holes]
    return bool(steep < _STEEP and min(lugs) > _LUG * widest)
