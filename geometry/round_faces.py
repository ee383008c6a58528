"""Round faces of a CAD solid: cylinders by their axis, gathered to holes and journals; fillets.

Whatever kind of surface the file has, a face counts as a cylinder if its normals and points are a
cylinder's: other programs write bores as B-splines or surfaces of revolution.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import degrees, pi, radians
from typing import Any

import numpy as np

from geometry.mesh import FloatArray

FULL_TURN = radians(350.0)  # a seam or a scratch does not make a hole less round
_GRID = 9  # points along each parameter of a face, at which its shape is asked
_EXACT = 1e-6  # of normals and of points over the radius: what may be left of a cylinder
_SAME = 1e-3  # mm and rad, within which faces lie on the same cylinder
_PLAIN = 5e-4  # of a turn: what a hole that takes a pin may miss
_SLANT = 2e-3  # of the diameter: an end may slant by 0.1 deg, as an axis may
_ALONG_EDGE = 9  # points that tell where an edge goes


@dataclass(frozen=True, eq=False)
class Hole:
    """A cylinder that goes all the way round: a bore, or a journal (a shaft's end, a boss).

    kind       "bore" (the material is outside) or "journal" (inside)
    diameter   mm
    centre     (3,) mm, on the axis, at the middle of its surface
    direction  (3,) unit vector along the axis, its largest component positive
    length     mm, along the axis: of its pieces in sum
    piece      mm, of the shortest of them
    faces      CAD tags
    plain      True if nothing cuts into its surface, so that a pin can press on all of it
    """

    kind: str
    diameter: float
    centre: FloatArray
    direction: FloatArray
    length: float
    piece: float
    faces: tuple[int, ...]
    plain: bool

    def __str__(self) -> str:
        return (
            f"{self.kind} of {self.diameter:.6g} mm through {_vector(self.centre)} mm along "
            f"{_vector(self.direction)}, {self.length:.4g} mm long"
        )

    def distance_to(self, point: FloatArray) -> float:
        """Distance of a point from the axis, mm."""
        return float(np.linalg.norm(np.cross(point - self.centre, self.direction)))


@dataclass(frozen=True, eq=False)
class Curvature:
    """Curvature of a face: its smaller radius, mm; concave if the material is outside the arc."""

    face: int
    radius: float
    concave: bool


@dataclass(frozen=True, eq=False)
class _Patch:
    """A face on a cylinder: its span along the axis from `origin`, mm, and points on it.

    edges  (n, k, 3) mm, points along each of its edges
    """

    face: int
    kind: str
    radius: float
    origin: FloatArray
    direction: FloatArray
    low: float
    high: float
    points: FloatArray
    edges: FloatArray


def round_faces(gmsh: Any, solid: int) -> tuple[list[Hole], list[str], list[Curvature]]:
    """Holes and journals of a solid, in words the cylinders that are none, and its curved faces."""
    patches, curved = [], []
    for _, face in gmsh.model.getBoundary([(3, solid)], oriented=False):
        if gmsh.model.getType(2, face) == "Plane":
            continue
        points, normals = grid(gmsh, face)
        found = _curvature(face, points, normals)
        if found is not None:
            curved.append(found)
        fitted = _fitted_cylinder(points.reshape(-1, 3), normals.reshape(-1, 3))
        if fitted is None:
            continue
        origin, direction, radius, sign = fitted
        kind = "journal" if sign > 0 else "bore"
        along = (points.reshape(-1, 3) - origin) @ direction
        patches.append(
            _Patch(
                face,
                kind,
                radius,
                origin,
                direction,
                float(along.min()),
                float(along.max()),
                points,
                _edges(gmsh, face),
            )
        )
    holes: list[Hole] = []
    partial: list[str] = []
    for group in _coaxial(patches):
        whole, others = _pieces(group)
        if whole:
            holes.append(_hole(whole))
        for piece, turn in others:
            first = piece[0]
            partial.append(
                f"{first.kind} of {2 * first.radius:.6g} mm that goes {degrees(turn):.0f} deg round"
            )
    of_holes = {face for hole in holes for face in hole.faces if hole.kind == "journal"}
    order = sorted(holes, key=lambda hole: (hole.kind, hole.diameter, *np.round(hole.centre, 6)))
    return order, partial, [entry for entry in curved if entry.face not in of_holes]


def canonical(direction: FloatArray) -> FloatArray:
    """Return the direction or its opposite: the one whose largest component is positive."""
    largest = int(np.argmax(np.round(np.abs(direction), 6)))
    snapped = np.where(np.abs(direction) < 1e-12, 0.0, direction)
    return np.asarray(snapped * np.sign(direction[largest]) / np.linalg.norm(snapped))


def grid(gmsh: Any, face: int) -> tuple[FloatArray, FloatArray]:
    """Points, mm, and normals over the parameters of a face, (_GRID, _GRID, 3) each.

    gmsh turns the normals of a solid's faces out of the material.
    """
    low, high = gmsh.model.getParametrizationBounds(2, face)
    values = [np.linspace(a, b, _GRID) for a, b in zip(low, high, strict=True)]
    parameters = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).ravel()
    points = np.array(gmsh.model.getValue(2, face, parameters)).reshape(_GRID, _GRID, 3)
    normals = np.array(gmsh.model.getNormal(face, parameters)).reshape(_GRID, _GRID, 3)
    return points, normals


def _edges(gmsh: Any, face: int) -> FloatArray:
    """Points along the edges of a face, (n, _ALONG_EDGE, 3)."""
    points = []
    for _, curve in gmsh.model.getBoundary([(2, face)], combined=False, oriented=False):
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, curve)
        points.append(gmsh.model.getValue(1, curve, np.linspace(low, high, _ALONG_EDGE)))
    return np.concatenate(points).reshape(-1, _ALONG_EDGE, 3)


def _fitted_cylinder(
    points: FloatArray, normals: FloatArray
) -> tuple[FloatArray, FloatArray, float, float] | None:
    """Point of the axis, direction, radius, and 1 where normals point away from the axis.

    The axis is the direction that no normal has a share of; across it points lie at
    centre + radius * normal, which is linear in centre and radius. None if it is no cylinder.
    """
    _, sizes, rows = np.linalg.svd(normals, full_matrices=False)
    if sizes[2] > _EXACT * sizes[0] or sizes[1] < 1e3 * _EXACT * sizes[0]:
        return None
    across = rows[:2]
    flat, level = points @ across.T, normals @ across.T
    unknowns = np.zeros((2 * len(points), 3))
    unknowns[0::2, 0] = unknowns[1::2, 1] = 1.0
    unknowns[:, 2] = level.ravel()
    (x, y, radius), *_ = np.linalg.lstsq(unknowns, flat.ravel(), rcond=None)
    left = np.abs(unknowns @ [x, y, radius] - flat.ravel()).max()
    if left > _EXACT * max(abs(radius), 1.0) or not abs(radius) > 0:
        return None
    direction = canonical(rows[2])
    origin = x * across[0] + y * across[1]
    return origin, direction, abs(float(radius)), float(np.sign(radius))


def _curvature(face: int, points: FloatArray, normals: FloatArray) -> Curvature | None:
    """The sharper of the two bends at the middle of a face; None where it is nearly flat."""
    k = _GRID // 2
    middle, normal = points[k, k], normals[k, k]
    best = 0.0
    for before, after in (
        (points[k - 1, k], points[k + 1, k]),
        (points[k, k - 1], points[k, k + 1]),
    ):
        # the circle through three points: the middle one's height over the chord
        half = float(np.linalg.norm(after - before)) / 2
        height = float((before + after - 2 * middle) @ normal) / 2
        if half > 0:
            bend = 2 * height / (half**2 + height**2)
            best = bend if abs(bend) > abs(best) else best
    if not best:
        return None
    return Curvature(face, 1 / abs(best), bool(best > 0))


def _coaxial(patches: Sequence[_Patch]) -> Iterator[list[_Patch]]:
    """Patches of one kind on one cylinder, in groups."""
    left = list(patches)
    while left:
        first = left.pop(0)
        group = [first]
        for other in list(left):
            middle = other.origin + (other.low + other.high) / 2 * other.direction
            beside = np.linalg.norm(np.cross(middle - first.origin, first.direction))
            if (
                other.kind == first.kind
                and abs(other.radius - first.radius) < _SAME
                and np.linalg.norm(np.cross(other.direction, first.direction)) < _SAME
                and beside < _SAME
            ):
                group.append(other)
                left.remove(other)
        yield group


def _pieces(group: Sequence[_Patch]) -> tuple[list[list[_Patch]], list[tuple[list[_Patch], float]]]:
    """Patches that overlap along the axis together: full turns, and the others with their turn."""
    pieces: list[list[_Patch]] = []
    reached = -np.inf
    for patch in sorted(group, key=lambda patch: patch.low):
        if patch.low > reached - _SAME:
            pieces.append([])
        pieces[-1].append(patch)
        reached = max(reached, patch.high)
    turns = [_turn(piece) for piece in pieces]
    whole = [piece for piece, turn in zip(pieces, turns, strict=True) if turn >= FULL_TURN]
    others = [(p, turn) for p, turn in zip(pieces, turns, strict=True) if turn < FULL_TURN]
    return whole, others


def _turn(piece: Sequence[_Patch]) -> float:
    """Angle that patches cover together, rad."""
    axis, origin = piece[0].direction, piece[0].origin
    across = np.linalg.svd(axis[None])[2][1:]
    spans = []
    for patch in piece:
        arms = (patch.points - origin) @ across.T
        angles = np.arctan2(arms[..., 1], arms[..., 0])
        # whichever parameter goes round, the angle then changes by the patch's arc
        angles = np.unwrap(np.unwrap(angles, axis=0), axis=1)
        spans.append((float(angles.min()), float(angles.max())))
    covered = [(a - turn, b - turn) for a, b in spans for turn in (-2 * pi, 0.0, 2 * pi)]
    covered = [(max(a, -pi), min(b, pi)) for a, b in covered]
    total, reached = 0.0, -pi
    for a, b in sorted(span for span in covered if span[1] > span[0]):
        total += max(0.0, b - max(a, reached))
        reached = max(reached, b)
    return total


def _hole(pieces: Sequence[Sequence[_Patch]]) -> Hole:
    patches = [patch for piece in pieces for patch in piece]
    first = patches[0]
    spans = [(min(p.low for p in piece), max(p.high for p in piece)) for piece in pieces]
    lengths = [high - low for low, high in spans]
    length = sum(lengths)
    # pins press evenly along the length: their force passes through the middle of the surface
    middle = sum((high - low) * (high + low) / 2 for low, high in spans) / length
    return Hole(
        kind=first.kind,
        diameter=2 * first.radius,
        centre=first.origin + middle * first.direction,
        direction=first.direction,
        length=length,
        piece=min(lengths),
        faces=tuple(patch.face for patch in patches),
        plain=all(_is_plain(piece, *span) for piece, span in zip(pieces, spans, strict=True)),
    )


def _is_plain(piece: Sequence[_Patch], low: float, high: float) -> bool:
    """Return True if edges of a piece only end it or run along it, and it has no gap around."""
    for patch in piece:
        for edge in patch.edges:
            along = (edge - patch.origin) @ patch.direction
            beside = edge - patch.origin - along[:, None] * patch.direction
            runs_along = np.linalg.norm(beside - beside[0], axis=1).max() < _SAME
            slack = max(_SAME, _SLANT * 2 * patch.radius)
            ends = min(np.abs(along - low).max(), np.abs(along - high).max()) < slack
            if not (runs_along or ends):
                return False
    return _turn(piece) > (1 - _PLAIN) * 2 * pi


def _vector(values: FloatArray) -> str:
    """A vector to a micrometre, without negative zeros."""
    return "(" + ", ".join(f"{round(float(value), 3) + 0.0:g}" for value in values) + ")"
