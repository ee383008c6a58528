"""Unit loads of a contact that moves along x: a pin in a slot, a block on a leaf.

The contact's way is divided by stations, at most half its length apart. At each station it presses
as a hat: most at the station, nothing at its neighbours and beyond. The hats add up to one
everywhere, so two neighbouring ones with the shares (1 - t, t) stand for a force between them, with
its size and its moment exactly. Per station there are three columns:

    "+ i"  1 N along +y, a pressure on the surface named with "+"
    "- i"  1 N along -y, a pressure on the surface named with "-"
    "t i"  1 N along +x, a friction shared by both surfaces

each with the moment of a force at the station, on the level of the interface's centre. A block that
cannot turn also presses with a couple: its ends press against each other on neighbouring stations,
on the two pairs whose middles are next to it, with shares that put the couple where the block is
(within half a spacing of the way's end: on the last pair).

Quadrature over a surface cut along lines x = constant, for loads that have kinks there.

Each facet is cut into triangles that lie between two neighbouring lines. A load that is smooth
between the lines is then integrated without an error on straight-sided facets, whatever the size
of the facets.
"""

from dataclasses import dataclass

import numpy as np

from fem.assembly import Elements
from fem.unit_loads import InterfaceLoads, with_resultants
from geometry.mesh import FloatArray, IntArray, Interface, Mesh, MeshError

_DEGREE = 6  # a linear load, linear along z, times quadratic shape functions, and two to spare


@dataclass(frozen=True, eq=False)
class FacetStrips:
    """Quadrature points of the cut triangles of one surface.

    nodes    (m, 6)       node indices of the facet that each triangle lies in
    shape    (m, n_q, 6)  the facet's shape functions at the points
    points   (m, n_q, 3)  mm
    weights  (m, n_q)     mm2
    """

    nodes: IntArray
    shape: FloatArray
    points: FloatArray
    weights: FloatArray

    def nodal_forces(self, traction: FloatArray, n_nodes: int) -> FloatArray:
        """Nodal forces (3 n_nodes,) of a traction (m, n_q, 3) at the points, MPa."""
        forces = np.zeros((n_nodes, 3))
        nodal = np.einsum("mqa,mqx,mq->max", self.shape, traction, self.weights, optimize=True)
        np.add.at(forces, self.nodes, nodal)
        return forces.ravel()


def cut_along_x(mesh: Mesh, surface: str, lines: FloatArray) -> FacetStrips:
    """Quadrature over a named surface, cut at the places x = `lines`, mm."""
    import skfem

    facets = mesh.surfaces[surface]
    corners = np.broadcast_to(np.eye(3), (len(facets), 3, 3))  # barycentric, (m, corner, 3)
    owner: IntArray = np.arange(len(facets), dtype=np.int64)
    across = mesh.nodes[facets[:, :3], 0]  # x of the facets' corners
    for line in lines:
        corners, owner = _cut(corners, owner, across - line)
    rule, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTri, _DEGREE)
    inside = np.stack([1 - rule.sum(axis=0), *rule], axis=1)  # (n_q, 3)
    places = np.matmul(inside, corners)  # (m, n_q, 3) barycentric in the facet
    share = np.abs(np.linalg.det(corners))  # of the facet's area
    nodes = facets[owner]
    at = mesh.nodes[nodes]
    t, r, s = np.moveaxis(places, -1, 0)
    shape = np.stack(
        [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * r * t, 4 * r * s, 4 * s * t],
        axis=-1,
    )
    zero = np.zeros_like(r)
    by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s], axis=-1)
    by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)], axis=-1)
    areas = np.linalg.norm(np.cross(by_r @ at, by_s @ at), axis=-1)
    return FacetStrips(nodes, shape, shape @ at, areas * weights * share[:, None])


def _cut(corners: FloatArray, owner: IntArray, level: FloatArray) -> tuple[FloatArray, IntArray]:
    """Cut triangles where a function that is linear in each facet is zero.

    level  (n_facets, 3) the function at the facets' corners
    """
    value = np.einsum("mca,ma->mc", corners, level[owner])
    value[np.abs(value) < 1e-9 * np.abs(level).max(axis=1)[owner][:, None]] = 0.0
    crossed = (value.min(axis=1) < 0) & (value.max(axis=1) > 0)
    kept, kept_owner = corners[~crossed], owner[~crossed]
    corners, owner, value = corners[crossed], owner[crossed], value[crossed]
    side = np.sign(value)
    side[side == 0] = 1.0
    alone = np.argmax(side * side.sum(axis=1, keepdims=True) < 0, axis=1)  # on a side by itself
    turn = (alone[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn[:, :, None], axis=1)
    value = np.take_along_axis(value, turn, axis=1)
    first, second, third = np.moveaxis(corners, 1, 0)

    def crossing(k: int) -> FloatArray:
        along = (value[:, 0] / (value[:, 0] - value[:, k]))[:, None]
        return np.asarray(first + along * (corners[:, k] - first))

    left, right = crossing(1), crossing(2)
    parts = [(first, left, right), (left, second, third), (left, third, right)]
    return (
        np.concatenate([kept, *(np.stack(part, axis=1) for part in parts)]),
        np.concatenate([kept_owner, owner, owner, owner]),
    )


_OUTSIDE = 1e-6  # of its way: how far a contact may leave it
_FLAT = 1e-6  # of their length: how far the surfaces may be from planes normal to y


def stations(interface: Interface) -> FloatArray:
    """Places (n,) mm of the hats along x from the interface's centre, at least two.

    They divide the way evenly and are at most `patch` apart. A way shorter than the patch has two
    stations that stand a little beyond its ends, so that their hats still end where the surfaces
    have to, `patch` beyond the way.
    """
    low, high = interface.travel
    if not (interface.patch > 0 and high >= low):
        raise MeshError(
            f"interface {interface.name!r}: a sliding contact needs a patch above 0 mm and a "
            f"travel that rises, got {interface.patch:g} mm and {low:g} to {high:g} mm"
        )
    if high - low < interface.patch:
        half = (2 * interface.patch + high - low) / 6
        middle = (low + high) / 2
        return np.array([middle - half, middle + half])
    return np.linspace(low, high, int(np.ceil((high - low) / interface.patch - 1e-9)) + 1)


def sliding_loads(elements: Elements, interface: Interface) -> InterfaceLoads:
    """Return the normalised unit loads of a sliding contact, three per station.

    Raises MeshError if its surfaces are not flat, do not reach as far as it presses, or are too
    coarse.
    """
    places = stations(interface)
    spacing = float(places[1] - places[0])
    lines = np.r_[places[0] - spacing, places, places[-1] + spacing]
    levels = [_level(elements, interface, name, lines[[0, -1]]) for name in interface.surfaces]
    lines = lines + interface.centre[0]
    plus, minus = (cut_along_x(elements.mesh, name, lines) for name in interface.surfaces)
    friction = _shares(interface, *levels)
    part = elements.mesh.share  # half a part takes half of each force
    columns, deviations = [], []
    for place in places:
        centre = interface.centre + np.array([place, 0.0, 0.0])
        hats = [_Hat(elements, strips, centre, spacing) for strips in (plus, minus)]
        up = part * hats[0].force(1) / hats[0].size
        down = part * hats[1].force(1) / hats[1].size
        along = part * sum(
            share * hat.force(0) / hat.size for share, hat in zip(friction, hats, strict=True)
        )
        for load, axis, sign, smooth in (
            (up, 1, 1.0, hats[0].pressures()),
            (-down, 1, -1.0, hats[1].pressures()),
            (along, 0, 1.0, [*(hat.force(0) for hat in hats), *(hat.tilted(0) for hat in hats)]),
        ):
            target = np.zeros((6, 1))
            target[axis] = sign
            exact, raw = with_resultants(
                elements,
                interface.name,
                centre,
                spacing,
                np.asarray(load)[:, None],
                target,
                np.stack(smooth, axis=1),
            )
            columns.append(exact[:, 0])
            deviations.append(raw)
    names = tuple(f"{kind} {i}" for i in range(len(places)) for kind in "+-t")
    return InterfaceLoads(interface, names, np.stack(columns, axis=1), max(deviations))


def sliding_coefficients(interface: Interface, planar: FloatArray, reach: FloatArray) -> FloatArray:
    """Coefficients (n, 3 n_stations) of the columns of a contact.

    planar  (n, 3) F_x, F_y N and M_z N mm about the interface's centre
    reach   (n,) mm, of the contact along x from the centre

    Raises ValueError where the contact is outside its travel.
    """
    planar, reach = np.atleast_2d(planar), np.asarray(reach, dtype=float)
    if reach.shape != (len(planar),):
        raise ValueError(
            f"interface {interface.name!r}: {len(planar)} positions need as many places of the "
            f"contact, got shape {reach.shape}"
        )
    _check_way(interface, reach)
    places = stations(interface)
    spacing = places[1] - places[0]
    before, share = _between(places, reach)
    pressed, rubbed = np.zeros((2, len(reach), len(places)))
    for place, part in ((before, 1 - share), (before + 1, share)):
        _add(pressed, place, part * planar[:, 1])
        _add(rubbed, place, part * planar[:, 0])
    couple = (planar[:, 2] - reach * planar[:, 1]) / spacing
    middles = (places[1:] + places[:-1]) / 2
    pair, share = _between(middles, np.clip(reach, middles[0], middles[-1]))
    for first, part in ((pair, 1 - share), (np.minimum(pair + 1, len(places) - 2), share)):
        _add(pressed, first, -part * couple)
        _add(pressed, first + 1, part * couple)
    columns = np.stack([np.maximum(pressed, 0), np.maximum(-pressed, 0), rubbed], axis=2)
    return columns.reshape(len(reach), -1)


def _between(places: FloatArray, at: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number of the place before each one asked for, and its share of the way to the next."""
    if len(places) == 1:
        return np.zeros(len(at), dtype=np.int64), np.zeros(len(at))
    before = np.clip(np.searchsorted(places, at, side="right") - 1, 0, len(places) - 2)
    share = (at - places[before]) / (places[before + 1] - places[before])
    return before.astype(np.int64), share


def _add(table: FloatArray, columns: IntArray, values: FloatArray) -> None:
    table[np.arange(len(columns)), columns] += values


def _check_way(interface: Interface, reach: FloatArray) -> None:
    low, high = interface.travel
    tolerance = _OUTSIDE * max(high - low, interface.patch)
    outside = np.maximum(low - reach, reach - high)
    if len(reach) and not outside.max() <= tolerance:
        worst = int(np.argmax(np.where(np.isnan(outside), np.inf, outside)))
        raise ValueError(
            f"interface {interface.name!r}: at position {worst + 1} of {len(reach)} the contact is "
            f"at x = {reach[worst]:.7g} mm from its centre, outside its travel of {low:.7g} to "
            f"{high:.7g} mm"
        )


def _level(elements: Elements, interface: Interface, name: str, ends: FloatArray) -> float:
    """Height y of a surface over the centre; MeshError if it is not flat or is too short."""
    nodes = elements.mesh.nodes[np.unique(elements.mesh.surfaces[name])] - interface.centre
    length = float(np.ptp(nodes[:, 0]))
    if not np.ptp(nodes[:, 1]) <= _FLAT * length:
        raise MeshError(
            f"surface {name!r} must be flat and normal to y, its heights differ by "
            f"{np.ptp(nodes[:, 1]):.3g} mm"
        )
    low, high = float(nodes[:, 0].min()), float(nodes[:, 0].max())
    if low > ends[0] + 1e-6 * length or high < ends[1] - 1e-6 * length:
        raise MeshError(
            f"surface {name!r} reaches from x = {low:.6g} to {high:.6g} mm from the centre, the "
            f"contact presses from {ends[0]:.6g} to {ends[1]:.6g} mm"
        )
    return float(nodes[:, 1].mean())


def _shares(interface: Interface, plus: float, minus: float) -> tuple[float, float]:
    """Share of a friction that each surface carries, without a couple: half each, as a rule."""
    share = minus / (minus - plus) if minus != plus else np.nan
    if not 0 <= share <= 1:
        raise MeshError(
            f"interface {interface.name!r}: its centre must be between its surfaces, which are at "
            f"y = {plus:.6g} and {minus:.6g} mm from it"
        )
    return share, 1 - share


class _Hat:
    """A hat-shaped load at one station, and the same load tilted along x and along z."""

    def __init__(
        self, elements: Elements, strips: FacetStrips, centre: FloatArray, spacing: float
    ) -> None:
        arm = strips.points - centre
        height = 1 - np.abs(arm[..., 0]) / spacing
        near = height.max(axis=1) > 0
        self._strips = FacetStrips(
            strips.nodes[near], strips.shape[near], strips.points[near], strips.weights[near]
        )
        self._n_nodes = len(elements.mesh.nodes)
        self._arm = arm[near]
        self._height = np.maximum(height[near], 0)
        self._spacing = spacing
        self.size = float((self._height * self._strips.weights).sum())

    def force(self, axis: int) -> FloatArray:
        """Nodal forces along an axis, as the hat."""
        return self._nodal(axis, self._height)

    def tilted(self, axis: int) -> FloatArray:
        """Nodal forces along an axis, as the hat times z."""
        return self._nodal(axis, self._height * self._arm[..., 2] / self._spacing)

    def pressures(self) -> list[FloatArray]:
        """Nodal forces along y, as the hat, and as the hat times x and times z."""
        sloping = self._nodal(1, self._height * self._arm[..., 0] / self._spacing)
        return [self.force(1), sloping, self.tilted(1)]

    def _nodal(self, axis: int, size: FloatArray) -> FloatArray:
        traction = np.zeros((*size.shape, 3))
        traction[..., axis] = size
        return self._strips.nodal_forces(traction, self._n_nodes)
