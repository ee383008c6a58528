"""Unit loads of a part's interfaces, each with exactly the resultant it claims.

A pin pushes on a bore with a half-cosine pressure whose direction turns during the cycle. Its
Fourier series

    max(0, cos t) = 1/pi + cos(t)/2 + sum_m 2 (-1)^(m+1) / (pi (4 m^2 - 1)) cos(2 m t)

makes the load a sum of the fixed patterns cos(n theta), sin(n theta), n = 0, 1, 2, 4: seven vectors
per bore give every direction and size, although the pressed half of the bore moves
(docs/theory/bearing.md). The patterns are normalised so that n = 1 has the resultant 1 N; the
others have none. A facetted bore gets this wrong by some 1e-5, which is measured, refused above
1e-3, and removed by a small multiple of smooth patterns.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.elements import Elements, FacetQuadrature
from geometry.mesh import FloatArray, Interface, MeshError

HARMONICS = (0, 1, 2, 4)
ACCELERATIONS = ("a_x", "a_y", "alpha", "omega2")
_RAW_LIMIT = 1e-3

Traction = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class InterfaceLoads:
    """Unit load vectors of one interface.

    interface      where they act
    names          of the columns
    vectors        (3 n_nodes, n_columns)  N, nodal forces per unit of each column
    raw_deviation  largest relative error of a resultant before it was normalised
    """

    interface: Interface
    names: tuple[str, ...]
    vectors: FloatArray
    raw_deviation: float


def bearing_coefficients(force: FloatArray, inward: bool) -> FloatArray:
    """Coefficients (n, 8) of a round interface's columns for forces (n, 3): F_x, F_y, M_z.

    Columns: harmonic 0, then cosine and sine of harmonics 1, 2, 4, then the friction couple. A pin
    in a bore presses where the force points to; a lug on a pin (`inward`) on the opposite side.
    """
    force = np.atleast_2d(force)
    size = np.hypot(force[:, 0], force[:, 1])
    angle = np.arctan2(force[:, 1], force[:, 0]) + (np.pi if inward else 0.0)
    columns = []
    for n in HARMONICS:
        amplitude = 2 * size * half_cosine_harmonic(n)
        columns.append(amplitude * np.cos(n * angle))
        if n:
            columns.append(amplitude * np.sin(n * angle))
    columns.append(force[:, 2])
    return np.stack(columns, axis=1)


def half_cosine_harmonic(n: int) -> float:
    """Fourier coefficient of cos(n t) in max(0, cos t)."""
    if n == 0:
        return 1 / np.pi
    if n == 1:
        return 0.5
    if n % 2:
        return 0.0
    m = n // 2
    return float(2 * (-1) ** (m + 1) / (np.pi * (4 * m * m - 1)))


def interface_loads(elements: Elements, interface: Interface) -> InterfaceLoads:
    """Return one interface's normalised unit loads; MeshError if the raw ones are too far off."""
    surface = elements.surface(interface.name)
    if interface.kind == "face":
        patterns, targets, smooth = _face_patterns(surface, interface)
    else:
        patterns, targets, smooth = _round_patterns(surface, interface)
    vectors = np.stack([_nodal(elements, surface, p) for p in patterns.values()], axis=1)
    smooth_vectors = np.stack([_nodal(elements, surface, p) for p in smooth], axis=1)
    reach = interface.radius or float(np.ptp(surface.points.reshape(-1, 3), axis=0).max())
    scale = np.r_[np.ones(3), np.full(3, 1 / reach)]
    error = targets - resultants(elements, vectors, interface.centre)
    raw = float(np.abs(error * scale[:, None]).max())
    if raw > _RAW_LIMIT:
        raise MeshError(
            f"loads on {interface.name!r} miss their resultant by {raw:.1e} on this mesh "
            f"(limit {_RAW_LIMIT:.0e}): it needs more elements around the interface"
        )
    available = resultants(elements, smooth_vectors, interface.centre) * scale[:, None]
    correction, *_ = np.linalg.lstsq(available, error * scale[:, None], rcond=1e-9)
    vectors += smooth_vectors @ correction
    left = np.abs((targets - resultants(elements, vectors, interface.centre)) * scale[:, None])
    if left.max() > 1e-9:
        raise MeshError(f"loads on {interface.name!r} keep an unbalanced {left.max():.1e}")
    return InterfaceLoads(interface, tuple(patterns), vectors, raw)


def direct_bearing(
    elements: Elements, interface: Interface, force: FloatArray, arc: float = np.pi
) -> FloatArray:
    """Nodal forces (3 n_nodes,) of one cosine pressure on an arc, without a series.

    force  (3,) F_x, F_y in N and M_z in N mm
    arc    rad, the full angle on which the pressure acts: p0 cos(pi t / arc), |t| < arc/2

    The pressure pattern ends inside elements, so its raw resultant is off by the quadrature, which
    is fine (degree 19), and scaled to be exact.
    """
    inward = interface.kind == "journal"
    surface = elements.surface(interface.name, degree=19)
    direction = np.arctan2(force[1], force[0]) + (np.pi if inward else 0.0)

    def pressure(points: FloatArray) -> FloatArray:
        radial, angle = _radial(points, interface)
        away = (angle - direction + np.pi) % (2 * np.pi) - np.pi
        size = np.where(np.abs(away) < arc / 2, np.cos(np.pi * away / arc), 0.0)
        return np.asarray((-radial if inward else radial) * size[..., None])

    vector = _nodal(elements, surface, pressure)
    size = np.hypot(force[0], force[1])
    if size:
        got = resultants(elements, vector[:, None], interface.centre)[:2, 0]
        vector *= size**2 / (got @ force[:2])
    else:
        vector *= 0.0
    couple = _nodal(elements, surface, _couple(interface))
    correct = _nodal(elements, surface, _round_harmonic(interface, 1, np.sin))
    correct_x = _nodal(elements, surface, _round_harmonic(interface, 1, np.cos))
    smooth = np.stack([correct_x, correct, couple], axis=1)
    rows = [0, 1, 5]
    missing = np.asarray(force) - resultants(elements, vector[:, None], interface.centre)[rows, 0]
    share = np.linalg.solve(resultants(elements, smooth, interface.centre)[rows], missing)
    return np.asarray(vector + smooth @ share)


def acceleration_loads(elements: Elements, density: float) -> FloatArray:
    """Nodal inertia forces (3 n_nodes, 4) per unit a_x, a_y, alpha and omega^2 of the part's frame.

    d'Alembert: -density times the acceleration
    (a_x - alpha y - omega2 x, a_y + alpha x - omega2 y).
    """
    x, y = elements.points[..., 0], elements.points[..., 1]
    zero, one = np.zeros_like(x), np.ones_like(x)
    fields = [(one, zero), (zero, one), (-y, x), (-x, -y)]
    vectors = np.zeros((len(elements.mesh.nodes), 3, 4))
    for column, field in enumerate(fields):
        for axis in range(2):
            density_force = -density * field[axis] * elements.weights
            nodal = np.einsum("eq,qa->ea", density_force, elements.values)
            np.add.at(vectors[:, axis, column], elements.mesh.elements, nodal)
    return vectors.reshape(-1, 4)


def resultants(elements: Elements, vectors: FloatArray, centre: FloatArray) -> FloatArray:
    """Force and moment about `centre` of nodal forces (3 n_nodes, m), as (6, m): N and N mm."""
    forces = vectors.reshape(len(elements.mesh.nodes), 3, -1)
    arms = elements.mesh.nodes - centre
    moment = np.stack(
        [
            arms[:, 1] @ forces[:, 2] - arms[:, 2] @ forces[:, 1],
            arms[:, 2] @ forces[:, 0] - arms[:, 0] @ forces[:, 2],
            arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0],
        ]
    )
    return np.concatenate([forces.sum(axis=0), moment])


def _nodal(elements: Elements, surface: FacetQuadrature, traction: Traction) -> FloatArray:
    field = traction(surface.points) * surface.weights[..., None]
    nodal = np.einsum("aq,fqx->fax", surface.shape, field)
    vector = np.zeros((len(elements.mesh.nodes), 3))
    np.add.at(vector, surface.nodes, nodal)
    return vector.ravel()


def _radial(points: FloatArray, interface: Interface) -> tuple[FloatArray, FloatArray]:
    """Return the unit vector away from the interface's exact axis, and its angle."""
    arm = points - interface.centre
    angle = np.arctan2(arm[..., 1], arm[..., 0])
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1), angle


def _round_harmonic(
    interface: Interface, n: int, wave: Callable[[FloatArray], FloatArray], along: bool = False
) -> Traction:
    sign = -1.0 if interface.kind == "journal" else 1.0
    base = sign / (np.pi * interface.radius * interface.length)

    def traction(points: FloatArray) -> FloatArray:
        radial, angle = _radial(points, interface)
        size = base * wave(n * angle)
        if along:
            size = size * (points[..., 2] - interface.centre[2]) / interface.radius
        return np.asarray(radial * size[..., None])

    return traction


def _couple(interface: Interface) -> Traction:
    size = 1 / (2 * np.pi * interface.radius**2 * interface.length)

    def traction(points: FloatArray) -> FloatArray:
        radial, _angle = _radial(points, interface)
        tangent = np.stack([-radial[..., 1], radial[..., 0], radial[..., 2]], axis=-1)
        return np.asarray(size * tangent)

    return traction


def _round_patterns(
    surface: FacetQuadrature, interface: Interface
) -> tuple[dict[str, Traction], FloatArray, list[Traction]]:
    patterns: dict[str, Traction] = {}
    for n in HARMONICS:
        patterns[f"cos {n}"] = _round_harmonic(interface, n, np.cos)
        if n:
            patterns[f"sin {n}"] = _round_harmonic(interface, n, np.sin)
    patterns["couple"] = _couple(interface)
    targets = np.zeros((6, len(patterns)))
    sign = -1.0 if interface.kind == "journal" else 1.0
    names = list(patterns)
    targets[0, names.index("cos 1")] = sign
    targets[1, names.index("sin 1")] = sign
    targets[5, names.index("couple")] = 1.0
    smooth = [
        _round_harmonic(interface, 1, np.cos),
        _round_harmonic(interface, 1, np.sin),
        _couple(interface),
        _round_harmonic(interface, 1, np.cos, along=True),
        _round_harmonic(interface, 1, np.sin, along=True),
    ]
    return patterns, targets, smooth


def _face_patterns(
    surface: FacetQuadrature, interface: Interface
) -> tuple[dict[str, Traction], FloatArray, list[Traction]]:
    area = float(surface.weights.sum())
    arm = surface.points - interface.centre
    second = {axis: float((surface.weights * arm[..., axis] ** 2).sum()) for axis in (1, 2)}

    def uniform(axis: int) -> Traction:
        def traction(points: FloatArray) -> FloatArray:
            field = np.zeros(points.shape)
            field[..., axis] = 1 / area
            return field

        return traction

    def bending(axis: int) -> Traction:
        def traction(points: FloatArray) -> FloatArray:
            field = np.zeros(points.shape)
            field[..., 0] = -(points - interface.centre)[..., axis] / second[axis]
            return field

        return traction

    def twist(points: FloatArray) -> FloatArray:
        field, lever = np.zeros(points.shape), points - interface.centre
        field[..., 1], field[..., 2] = -lever[..., 2], lever[..., 1]
        return field / (second[1] + second[2])

    patterns = {"F_x": uniform(0), "F_y": uniform(1), "M_z": bending(1)}
    targets = np.zeros((6, 3))
    targets[[0, 1, 5], [0, 1, 2]] = 1.0
    # an uneven mesh puts the centre of its weights beside the centre: a shear then twists a little
    return patterns, targets, [*(uniform(i) for i in range(3)), bending(1), bending(2), twist]
