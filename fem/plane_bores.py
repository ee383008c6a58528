"""Unit loads on a part seen as a sheet: bores, cut ends, clamps, sliding contacts, inertia.

The columns of each interface are those of the solid (fem/unit_loads.py, fem/sliding.py), so that
the same coefficients over the cycle belong to them. Each has exactly the resultant in the plane
that it stands for; what quadrature on curved sides misses of it is measured, refused above 1e-3,
and removed by the smallest sum of smooth tractions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.plane import PlaneModel, Traction
from fem.sliding import sliding_coefficients, stations
from fem.unit_loads import HARMONICS, bearing_coefficients
from geometry.mesh import FloatArray, Interface, MeshError

_RAW_LIMIT = 1e-3
_GAUSS = np.polynomial.legendre.leggauss(3)  # a hat's half times a quadratic shape function


@dataclass(frozen=True, eq=False)
class PlaneLoads:
    """Unit loads of one interface of a sheet.

    names          of the columns
    vectors        (2 n_nodes, n_columns) N, nodal forces per unit of each column
    raw_deviation  largest relative error of a resultant before it was normalised
    """

    interface: Interface
    names: tuple[str, ...]
    vectors: FloatArray
    raw_deviation: float

    def coefficients(self, planar: FloatArray, reach: FloatArray | None = None) -> FloatArray:
        """Coefficients (n, n_columns) for forces and couples (n, 3): F_x, F_y, M_z; N, N mm.

        reach (n,) mm, of a sliding contact along x from the interface's centre
        """
        if self.interface.kind == "slide":
            if reach is None:
                raise ValueError(
                    f"interface {self.interface.name!r} slides: its loads need the place of the "
                    "contact at every position"
                )
            return sliding_coefficients(self.interface, planar, reach)
        if self.interface.kind == "bore":
            return bearing_coefficients(planar, inward=False)
        return planar


def plane_loads(model: PlaneModel, interface: Interface) -> PlaneLoads:
    """Return the normalised unit loads of an interface.

    Raises MeshError if the raw ones miss their resultants by more than 1e-3, or for an interface
    whose kind has none in the plane.
    """
    builder = _BUILDERS.get(interface.kind)
    if builder is None:
        raise MeshError(
            f"interface {interface.name!r} is a {interface.kind!r}; loads in the plane are known "
            f"for {', '.join(_BUILDERS)}"
        )
    return builder(model, interface)


def acceleration_vectors(model: PlaneModel, density: float) -> FloatArray:
    """Nodal inertia forces (2 n_nodes, 4) per unit a_x, a_y, alpha, omega^2 of the part's frame.

    d'Alembert: -density times (a_x - alpha y - omega2 x, a_y + alpha x - omega2 y), t/mm3.
    """
    fields: list[Callable[[FloatArray], FloatArray]] = [
        lambda p: np.broadcast_to([1.0, 0.0], p.shape),
        lambda p: np.broadcast_to([0.0, 1.0], p.shape),
        lambda p: np.stack([-p[..., 1], p[..., 0]], axis=-1),
        lambda p: -p,
    ]
    return np.stack([-density * model.loads(body=field) for field in fields], axis=1)


def plane_resultants(nodes: FloatArray, vectors: FloatArray, centre: FloatArray) -> FloatArray:
    """Force and moment about `centre` (2,) of nodal forces (2 n_nodes, m), (3, m): N and N mm."""
    forces = vectors.reshape(len(nodes), 2, -1)
    arms = nodes - centre
    moment = arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0]
    return np.concatenate([forces.sum(axis=0), moment[None]])


def direct_bore(model: PlaneModel, interface: Interface, force: FloatArray) -> FloatArray:
    """Nodal forces (2 n_nodes,) of one half-cosine pressure on a bore, without a series.

    force (2,) N. The pressure ends inside an element, so its raw resultant is off by the
    quadrature; the smallest sum of smooth tractions closes the gap.
    """
    size = float(np.hypot(*force))
    direction = np.array(force) / (size or 1.0)

    def pressure(points: FloatArray, _: FloatArray) -> FloatArray:
        radial = _radial(points, interface)
        amount = np.maximum(radial @ direction, 0.0) * 2 / np.pi
        return np.asarray(radial * (amount / (interface.radius * interface.length))[..., None])

    vector = size * model.loads({interface.name: pressure})
    smooth = [_round(interface, 1, np.cos), _round(interface, 1, np.sin), _couple(interface)]
    smooth_vectors = np.stack([model.loads({interface.name: t}) for t in smooth], axis=1)
    centre, nodes = interface.centre[:2], model.mesh.nodes
    missing = np.r_[force, 0.0] - plane_resultants(nodes, vector[:, None], centre)[:, 0]
    share = np.linalg.solve(plane_resultants(nodes, smooth_vectors, centre), missing)
    return np.asarray(vector + smooth_vectors @ share)


def _radial(points: FloatArray, interface: Interface) -> FloatArray:
    arm = points - interface.centre[:2]
    return np.asarray(arm / np.linalg.norm(arm, axis=-1, keepdims=True))


def _round(interface: Interface, n: int, wave: Callable[[FloatArray], FloatArray]) -> Traction:
    base = 1 / (np.pi * interface.radius * interface.length)

    def traction(points: FloatArray, _: FloatArray) -> FloatArray:
        radial = _radial(points, interface)
        angle = np.arctan2(radial[..., 1], radial[..., 0])
        return np.asarray(base * wave(n * angle)[..., None] * radial)

    return traction


def _couple(interface: Interface) -> Traction:
    size = 1 / (2 * np.pi * interface.radius**2 * interface.length)

    def traction(points: FloatArray, _: FloatArray) -> FloatArray:
        radial = _radial(points, interface)
        return np.asarray(size * np.stack([-radial[..., 1], radial[..., 0]], axis=-1))

    return traction


def _bore(model: PlaneModel, interface: Interface) -> PlaneLoads:
    patterns: dict[str, Traction] = {}
    for n in HARMONICS:
        patterns[f"cos {n}"] = _round(interface, n, np.cos)
        if n:
            patterns[f"sin {n}"] = _round(interface, n, np.sin)
    patterns["couple"] = _couple(interface)
    names = list(patterns)
    targets = np.zeros((3, len(names)))
    smooth = ["cos 1", "sin 1", "couple"]
    for row, name in enumerate(smooth):
        targets[row, names.index(name)] = 1.0
    vectors = np.stack([model.loads({interface.name: t}) for t in patterns.values()], axis=1)
    closing = vectors[:, [names.index(name) for name in smooth]]
    return _normalised(model, interface, names, vectors, targets, closing, interface.radius)


def _face(model: PlaneModel, interface: Interface) -> PlaneLoads:
    """Even tractions on a cut end normal to x, and one along x that grows with y."""
    centre = interface.centre[:2]

    def linear(points: FloatArray, _: FloatArray) -> FloatArray:
        return np.stack([-(points - centre)[..., 1], np.zeros(points.shape[:-1])], axis=-1)

    return _stretched(model, interface, linear)


def _clamp(model: PlaneModel, interface: Interface) -> PlaneLoads:
    """Even tractions on faces normal to y, and one along y that grows with x."""
    centre = interface.centre[:2]

    def linear(points: FloatArray, _: FloatArray) -> FloatArray:
        return np.stack([np.zeros(points.shape[:-1]), (points - centre)[..., 0]], axis=-1)

    return _stretched(model, interface, linear)


def _stretched(model: PlaneModel, interface: Interface, linear: Traction) -> PlaneLoads:
    tractions = [_even(0), _even(1), linear]
    vectors = np.stack([model.loads({interface.name: t}) for t in tractions], axis=1)
    centre = interface.centre[:2]
    sizes = np.diag(plane_resultants(model.mesh.nodes, vectors, centre))
    vectors = vectors / sizes
    on = model.mesh.nodes[model.mesh.edge_nodes(interface.name)]
    reach = float(np.ptp(on, axis=0).max())
    names = ["F_x", "F_y", "M_z"]
    return _normalised(model, interface, names, vectors, np.eye(3), vectors, reach)


def _even(axis: int) -> Traction:
    return lambda points, _: np.broadcast_to(np.eye(2)[axis], points.shape)


def _normalised(
    model: PlaneModel,
    interface: Interface,
    names: list[str],
    vectors: FloatArray,
    targets: FloatArray,
    closing: FloatArray,
    reach: float,
) -> PlaneLoads:
    """Add the smallest sum of three closing loads that gives each column its resultant.

    targets (3, m) N, N mm; reach mm, by which moments are compared with forces
    """
    nodes, centre = model.mesh.nodes, interface.centre[:2]
    scale = np.array([1.0, 1.0, 1 / reach])[:, None]
    gap = (targets - plane_resultants(nodes, vectors, centre)) * scale
    raw = float(np.abs(gap).max())
    if raw > _RAW_LIMIT:
        raise MeshError(
            f"loads on {interface.name!r} miss their resultant by {raw:.1e} on this mesh (limit "
            f"{_RAW_LIMIT:.0e}): it needs more elements around the interface"
        )
    available = plane_resultants(nodes, closing, centre) * scale
    for _ in range(2):  # the second step removes the round-off of the first
        vectors = vectors + closing @ np.linalg.solve(available, gap)
        gap = (targets - plane_resultants(nodes, vectors, centre)) * scale
    left = float(np.abs(gap).max())
    if left > 1e-9:
        raise MeshError(f"loads on {interface.name!r} keep an unbalanced {left:.1e}")
    return PlaneLoads(interface, tuple(names), vectors, raw)


def _slide(model: PlaneModel, interface: Interface) -> PlaneLoads:
    """Three columns for each station of the way, as fem/sliding.py has them."""
    places = stations(interface)
    spacing = float(places[1] - places[0])
    heights = [_height(model, interface, name) for name in interface.surfaces]
    lever = (heights[1] - interface.centre[1]) / (heights[1] - heights[0])
    friction = (lever, 1 - lever)
    columns, deviation = [], 0.0
    for place in places:
        middle = np.array([interface.centre[0] + place, interface.centre[1]])
        hats = [_hat(model, name, middle[0], spacing) for name in interface.surfaces]
        along = np.zeros(2 * len(model.mesh.nodes))
        for hat, share in zip(hats, friction, strict=True):
            along[0::2] += share * hat
        for vector, axis, sign in ((hats[0], 1, 1.0), (hats[1], 1, -1.0), (along, 0, 1.0)):
            column = vector if axis == 0 else np.zeros_like(along)
            if axis == 1:
                column[1::2] = sign * vector
            got = plane_resultants(model.mesh.nodes, column[:, None], middle)[:, 0]
            got[axis] -= sign
            deviation = max(deviation, float(np.abs(got / [1, 1, spacing]).max()))
            columns.append(column)
    if deviation > 1e-9:  # hats are integrated exactly: the flank is too short or not straight
        raise MeshError(
            f"loads on {interface.name!r} miss their resultant by {deviation:.1e}: its surfaces "
            f"must be straight and reach {spacing:.4g} mm beyond the contact's way"
        )
    names = tuple(f"{kind} {i}" for i in range(len(places)) for kind in "+-t")
    return PlaneLoads(interface, names, np.stack(columns, axis=1), deviation)


def _height(model: PlaneModel, interface: Interface, name: str) -> float:
    """Height y of a straight edge along x; MeshError if it is not."""
    places = model.mesh.nodes[model.mesh.edge_nodes(name)]
    if not np.ptp(places[:, 1]) <= 1e-6 * np.ptp(places[:, 0]):
        raise MeshError(f"edge {name!r} of {interface.name!r} must be straight and along x")
    return float(places[:, 1].mean())


def _hat(model: PlaneModel, name: str, centre: float, spacing: float) -> FloatArray:
    """Shares (n_nodes,) of 1 N spread as a hat of half width `spacing` along an edge.

    Each half of the hat is integrated exactly over the part of it that lies in each piece.
    """
    pieces = model.mesh.edges[name]
    first, last = model.mesh.nodes[pieces[:, :2], 0].T
    shares = np.zeros(len(model.mesh.nodes))
    points, weights = (_GAUSS[0] + 1) / 2, _GAUSS[1] / 2
    for side in (-1.0, 1.0):
        ends = np.sort([centre, centre + side * spacing])
        low, high = np.clip(np.sort([first, last], axis=0), *ends)
        at = low[:, None] + (high - low)[:, None] * points
        s = (at - first[:, None]) / (last - first)[:, None]
        shape = np.stack([(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)])
        amount = (1 - np.abs(at - centre) / spacing) * weights * (high - low)[:, None]
        np.add.at(shares, pieces, np.einsum("akq,kq->ka", shape, amount))
    return shares / spacing  # the hat's own area


_BUILDERS: dict[str, Callable[[PlaneModel, Interface], PlaneLoads]] = {
    "bore": _bore,
    "face": _face,
    "clamp": _clamp,
    "slide": _slide,
}
