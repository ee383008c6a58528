"""A pin tearing out behind its hole: mean shear stress in the two planes, against yield in shear.

The plane taken is the shortest, straight behind the hole's crown (Melcon and Hoblit, Product
Engineering 24 (1953) no. 6, start theirs at 40 degrees, where it is longer).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from checks.design.data import Part
from checks.part.derived import EXACT, Heading, Kind, Series, shear_yield, yield_stress
from checks.part.loaded_part import LoadedPart
from checks.part.lugs import lugs_of
from checks.part.part_loads import first_largest
from checks.result.derivation import Step
from checks.result.verdict import Check
from geometry.cad_body import SolidBody
from geometry.mesh import FloatArray, IntArray, Mesh
from geometry.parts.plate import Plate, as_plate
from geometry.shape import Ligament

SHEAR_OUT = Kind(
    name="shear-out",
    quantity="mean shear stress behind the pin F/(2 A)",
    demand="mean shear stress in two planes behind the hole",
    limit="yield stress over √3",
    require="static",
    source="Melcon and Hoblit 1953; [fits](../theory/fits.md)",
)
KINDS = (SHEAR_OUT,)

_FITS = "docs/theory/fits.md"
_ROUND_OFF = 1e-9  # of a force, turned into the part's axes


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Shear stress tau = F/(2 A) behind the bore where it is largest, if a pin pulls at one."""
    bores = [lug.interface for lug in lugs_of(loaded)]
    body = loaded.measurable
    found = [
        _torn(loaded, bore, ligament)
        for bore in bores
        if body.interfaces[bore].kind == "bore"
        for ligament in ligaments(loaded.part, body, bore)
    ]
    if found and max(check.value for check in found) > 0:
        (most,) = first_largest(np.array([check.value for check in found]))
        yield found[most]


def _torn(loaded: LoadedPart, bore: str, ligament: "Ligament | AllRound") -> Check:
    pull, area = _pull(loaded.loads.wrenches[bore], ligament)
    return loaded.worst(
        Heading(
            kind=SHEAR_OUT,
            place=f"{bore}, towards {ligament.until}",
            basis="yield stress over sqrt 3",
            note=lambda found: (
                f"F = {found['F']:.0f} N that way, A = {found['A']:.4g} mm2 in each of two planes"
            ),
        ),
        [
            Series("F", f"pull of the pin in {bore} towards {ligament.until}", pull, "N",
                   main=True),
            Series("A", "area of one of the two planes behind it", area, "mm2",
                   f"the part's shape: {_FITS}"),
            Step("tau", "mean shear stress in both planes", "F/(2*A)", "MPa", _FITS, main=True),
        ],
        [yield_stress(loaded.part), shear_yield()],
        EXACT,
    )  # fmt: skip


def _pull(wrench: FloatArray, ligament: "Ligament | AllRound") -> tuple[FloatArray, FloatArray]:
    """Force (n,) that tears a ligament, N, and the area (n,) of one plane, mm2."""
    force = wrench[:, :2]
    if isinstance(ligament, AllRound):
        return np.hypot(*force.T), ligament.areas(np.arctan2(force[:, 1], force[:, 0]))
    if ligament.direction is None:
        pull = np.hypot(*force.T)
    else:
        x, y = ligament.direction
        along, size = force @ np.array([x, y]), np.hypot(*force.T)
        pull = np.maximum(along, 0.0)
        if ligament.round:
            aside = np.abs(force @ np.array([-y, x]))
            aside[aside < _ROUND_OFF * size] = 0.0
            pull = np.where(along > 0.0, size, np.minimum(size, aside / ligament.round))
    return pull, np.full(len(pull), ligament.area)


def ligaments(
    part: Part, body: Mesh | SolidBody, interface: str
) -> "Sequence[Ligament] | Sequence[AllRound]":
    """Ligaments that a pin can tear out of a hole: towards the part's end, or into a slot beside.

    Of a plate and of a part from CAD the ligament is measured in the direction of each force.
    """
    plate, known = as_plate(part.geometry), part.geometry.ligaments(interface)
    if plate is not None:
        return [plate_ligament(plate, interface)]
    if known is not None:
        return known
    if not isinstance(body, Mesh):
        raise TypeError("the ligaments of a CAD part are measured on its mesh")
    return [ligament_all_round(body, interface)]


# Shear planes behind a hole of parts whose ends are not known as numbers.

FAR = 3.0  # hole diameters of material behind which nothing tears (docs/theory/fits.md)
_SECTOR = np.radians(np.linspace(-40.0, 40.0, 9))  # where on the hole's edge a plane may begin
_LEVELS = 9  # sections over the length of the hole
_AT_ONCE = 32  # directions
_PIECES = 8  # flat ones along a side of a curved facet: 1/64 of the error of its chord


@dataclass(frozen=True, eq=False)
class _Outline:
    """Section of the body's surface by a plane z = const: m straight pieces.

    starts, ends  (m, 2) mm, from the hole's axis
    outward       (m, 2) normals, not of unit length
    pinned        (m,) whether a piece is of another bore
    """

    starts: FloatArray
    ends: FloatArray
    outward: FloatArray
    pinned: npt.NDArray[np.bool_]

    def shortest(self, radius: float, angles: FloatArray) -> FloatArray:
        """Shortest way (k,) through material, mm, of the rays behind the hole at angles (k,), rad.

        Infinite where it is held.
        """
        along = np.stack([np.cos(angles), np.sin(angles)])
        across = np.stack([-along[1], along[0]])
        side = radius * np.sin(_SECTOR)[:, None]
        a, b = ((points @ across).T[:, None] for points in (self.starts, self.ends))
        met = (a > side) != (b > side)
        share = (side - a) / np.where(a == b, 1.0, b - a)
        from_, step = ((x @ along).T[:, None] for x in (self.starts, self.ends - self.starts))
        ways = from_ + share * step - radius * np.cos(_SECTOR)[:, None]
        met &= ways > 0
        leaves = (self.outward @ along).T[:, None] > 0
        out = np.where(met & leaves, ways, np.inf)
        first = out.min(axis=2)
        into = np.where(met & ~leaves & (ways < first[..., None]), ways, 0.0).max(axis=2)
        held = self.pinned[out.argmin(axis=2)]
        return np.asarray(np.where(held, np.inf, first - into).min(axis=1))


@dataclass(frozen=True, eq=False)
class AllRound:
    """Material behind a hole, in whatever direction a force on the part points.

    outlines  sections over the length of the hole, of which the worst counts
    radius    of the hole, mm
    height    that it tears along, mm
    """

    outlines: Sequence[_Outline]
    radius: float
    height: float
    until: ClassVar[str] = "the wall that the force points at"

    def areas(self, angles: FloatArray) -> FloatArray:
        """Area (n,), mm2, of the shortest shear plane for forces at angles (n,), rad.

        A plane begins at the hole's edge, at most 40 degrees from the force's direction, runs
        parallel to it and ends where it first leaves the material. It is infinite where nothing
        tears: behind FAR diameters of material, and towards another bore, whose pin is in the way.
        """
        lengths = np.full(len(angles), np.inf)
        for first in range(0, len(angles), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            for outline in self.outlines:
                lengths[some] = np.minimum(
                    lengths[some], outline.shortest(self.radius, angles[some])
                )
        lengths[lengths > FAR * 2 * self.radius] = np.inf
        return self.height * lengths


@lru_cache(maxsize=4)
def ligament_all_round(mesh: Mesh, name: str) -> AllRound:
    """The ligament behind a bore, as the shear planes are on the mesh.

    Asked for again under every doubt of the loads.
    """
    outlines = [_outline(mesh, name, level) for level in _levels(mesh, name)]
    interface = mesh.interfaces[name]
    return AllRound(outlines, interface.radius, interface.length)


def plate_ligament(plate: Plate, name: str) -> AllRound:
    """The ligament behind a plate's bore, by the contours of its outline."""
    own = next(bore for bore in plate.bores if bore.name == name)
    starts, ends, pinned = [], [], []
    for contour in (plate.outline.outer, *plate.outline.inner):
        flat = contour.flat[:: 1 if contour is plate.outline.outer else -1]
        circle = contour.circle
        is_bore = circle is not None and any(
            abs(circle[0] - bore.centre) < bore.diameter / 4
            for bore in plate.bores
            if contour is not plate.outline.outer
        )
        if is_bore and circle is not None and abs(circle[0] - own.centre) < own.diameter / 4:
            is_bore = False
        starts.append(flat)
        ends.append(np.roll(flat, -1))
        pinned.append(np.full(len(flat), is_bore))
    from_, to = (np.concatenate(rows) - own.centre for rows in (starts, ends))
    outward = -1j * (to - from_)
    starts_, ends_, normals = (
        np.column_stack([rows.real, rows.imag]) for rows in (from_, to, outward)
    )
    outline = _Outline(starts_, ends_, normals, np.concatenate(pinned))
    return AllRound([outline], own.diameter / 2, plate.thickness)


def _levels(mesh: Mesh, name: str) -> FloatArray:
    """Heights z, mm, that are inside the bore, in each cheek of a fork."""
    middles = mesh.nodes[mesh.surfaces[name][:, :3], 2].mean(axis=1)
    shares = (np.arange(_LEVELS) + 0.5) / _LEVELS
    return np.asarray(np.quantile(middles, shares, method="closest_observation"))


def _outline(mesh: Mesh, name: str, level: float) -> _Outline:
    facets = mesh.boundary
    low, high = (pick(mesh.nodes[facets, 2], axis=1) for pick in (np.min, np.max))
    facets = facets[(low <= level) & (high > level)]
    shape, triangles = _split()
    pinned = np.repeat(_of_other_bores(mesh, name, facets), len(triangles))
    points = np.einsum("pa,fax->fpx", shape, mesh.nodes[facets])
    corners = points[:, triangles].reshape(-1, 3, 3)
    corners = corners - np.r_[mesh.interfaces[name].centre[:2], level]
    above = corners[:, :, 2] > 0
    cut = above.any(axis=1) & ~above.all(axis=1)
    corners, above, pinned = corners[cut], above[cut], pinned[cut]
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), above.argmin(axis=1))
    rows = np.arange(len(corners))
    apex, *others = (corners[rows, (alone + k) % 3] for k in range(3))
    starts, ends = (
        (apex - apex[:, 2:] / (apex[:, 2:] - other[:, 2:]) * (apex - other))[:, :2]
        for other in others
    )
    outward = np.cross(others[0] - apex, others[1] - apex)[:, :2]
    return _Outline(starts, ends, outward, pinned)


@cache
def _split() -> tuple[FloatArray, IntArray]:
    """Shape functions (p, 6) of a six-node facet at some points, and flat pieces (k, 3) of them."""
    steps = [(i, j) for i in range(_PIECES + 1) for j in range(_PIECES + 1 - i)]
    at = {place: row for row, place in enumerate(steps)}
    r, s = np.array(steps).T / _PIECES
    t = 1 - r - s
    shape = [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
    upright = [[at[i, j], at[i + 1, j], at[i, j + 1]] for i, j in steps if i + j < _PIECES]
    between = [
        [at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]] for i, j in steps if i + j < _PIECES - 1
    ]
    return np.stack(shape, axis=1), np.array(upright + between)


def _of_other_bores(mesh: Mesh, name: str, facets: IntArray) -> npt.NDArray[np.bool_]:
    """True (n,) for facets (n, 6) of a bore besides the named one."""
    others = [
        mesh.surfaces[other]
        for other, interface in mesh.interfaces.items()
        if other != name and interface.kind == "bore"
    ]
    if not others:
        return np.zeros(len(facets), dtype=bool)
    # mid-side nodes belong to the facets of one surface only, but for those at its edges
    return np.asarray(np.isin(facets[:, 3:], np.concatenate(others)).all(axis=1))
