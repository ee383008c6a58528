"""Unit loads of a part's interfaces, each with exactly the resultant it claims.

A pin pushes on a bore with a half-cosine pressure whose direction turns during the cycle. Its
Fourier series

    max(0, cos t) = 1/pi + cos(t)/2 + sum_m 2 (-1)^(m+1) / (pi (4 m^2 - 1)) cos(2 m t)

makes the load a sum of the fixed patterns cos(n theta), sin(n theta), n = 0, 1, 2, 4: seven vectors
per bore give every direction and size, although the pressed half of the bore moves
(docs/theory/bearing.md). The patterns are normalised so that n = 1 has the resultant 1 N; the
others have none. A facetted bore gets this wrong by some 1e-5, which is measured, refused above
1e-3, and removed by a small multiple of smooth patterns.

A bore whose pin tilts (plates side by side) also takes couples about x and y: a pressure that
grows linearly along the pin, z cos(theta) and z sin(theta). Contacts that slide are in
fem/sliding.py.

On half of a part, cut at z = 0, the same tractions act, all even in z: half of each resultant in
the plane. Their resultant out of the plane is carried by the cut.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.assembly import Elements, FacetQuadrature
from geometry.mesh import FloatArray, Interface, MassProperties, MeshError

HARMONICS = (0, 1, 2, 4)
# of a cosine on a narrower arc: those left out fall like 1/n^2
OF_ARCS = tuple(range(17))
ACCELERATIONS = ("a_x", "a_y", "alpha", "omega2")
_RAW_LIMIT = 1e-3
IN_PLANE = [0, 1, 5]  # force along x and y, moment about z

Traction = Callable[[FloatArray], FloatArray]
# Unit tractions by name, their resultants (6, n), and what may close a gap: even in z, and odd.
_Patterns = tuple[dict[str, Traction], FloatArray, list[Traction], list[Traction]]


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


def harmonics_of(arc: float) -> tuple[int, ...]:
    """Harmonics of the cosine pressure on an arc, rad: few of the half circle's matter."""
    return HARMONICS if arc >= np.pi else OF_ARCS


def bearing_coefficients(force: FloatArray, inward: bool, arc: float = np.pi) -> FloatArray:
    """Coefficients (n, 8) of a round interface's columns for forces (n, 3): F_x, F_y, M_z.

    Columns: harmonic 0, then cosine and sine of harmonics 1, 2, 4, then the friction couple; on an
    arc narrower than the half circle as many as `OF_ARCS` has. A pin in a bore presses where the
    force points to; a lug on a pin (`inward`) on the opposite side.

    arc  rad, on which p0 cos(pi t / arc) presses
    """
    force = np.atleast_2d(force)
    size = np.hypot(force[:, 0], force[:, 1])
    angle = np.arctan2(force[:, 1], force[:, 0]) + (np.pi if inward else 0.0)
    columns = []
    for n in harmonics_of(arc):
        amplitude = size * (
            2 * half_cosine_harmonic(n)
            if arc >= np.pi
            else arc_harmonic(n, arc) / arc_harmonic(1, arc)
        )
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


def arc_harmonic(n: int, arc: float) -> float:
    """Integral of cos(pi t / arc) cos(n t) over |t| < arc/2; half of it for n = 0.

    With k = pi/arc, 2 k cos(n arc/2)/(k^2 - n^2), and arc/2 for n = k.
    """
    k = np.pi / arc
    if abs(n - k) < 1e-9:
        return arc / 2
    whole = 2 * k * np.cos(n * arc / 2) / (k**2 - n**2)
    return float(whole if n else whole / 2)


def interface_loads(elements: Elements, interface: Interface) -> InterfaceLoads:
    """Return the normalised unit loads of an interface that stays where it is.

    Raises MeshError if the raw ones are too far off, or if it slides (fem/sliding.py).
    """
    builder = _BUILDERS.get(interface.kind)
    if builder is None:
        raise MeshError(
            f"interface {interface.name!r} is a {interface.kind!r}; loads that stay in one place "
            f"are known for {', '.join(_BUILDERS)}"
        )
    surface = elements.surface(interface.name)
    patterns, targets, even, odd = builder(surface, interface, elements.mesh.share)
    smooth = even if elements.mesh.half else [*even, *odd]
    vectors = np.stack([nodal_forces(elements, surface, p) for p in patterns.values()], axis=1)
    smooth_vectors = np.stack([nodal_forces(elements, surface, p) for p in smooth], axis=1)
    reach = interface.radius or float(np.ptp(surface.points.reshape(-1, 3), axis=0).max())
    vectors, raw = with_resultants(
        elements, interface.name, interface.centre, reach, vectors, targets, smooth_vectors
    )
    return InterfaceLoads(interface, tuple(patterns), vectors, raw)


def with_resultants(
    elements: Elements,
    name: str,
    centre: FloatArray,
    reach: float,
    vectors: FloatArray,
    targets: FloatArray,
    smooth: FloatArray,
) -> tuple[FloatArray, float]:
    """Return nodal forces that have their resultants exactly, and their error before.

    vectors  (3 n_nodes, m) raw loads, which must be right to 1e-3
    targets  (6, m)         the forces N and moments N mm about `centre` that they stand for; half
                            a part takes half of them, in its plane only
    smooth   (3 n_nodes, k) loads of which the smallest sum that closes the gap is added
    reach    mm, by which moments are compared with forces

    Errors are shares of a load's own resultant, of 1 N where it has none: any size is judged alike.
    """
    rows = IN_PLANE if elements.mesh.half else list(range(6))
    scale = np.r_[np.ones(3), np.full(3, 1 / reach)][rows, None] / elements.mesh.share
    wanted = elements.mesh.share * targets[rows]
    own = np.abs(wanted * scale).max(axis=0)
    own = np.where(own > 0.0, own, 1.0)
    error = (wanted - resultants(elements, vectors, centre)[rows]) * scale
    raw = float(np.abs(error / own).max())
    if raw > _RAW_LIMIT:
        raise MeshError(
            f"loads on {name!r} miss their resultant by {raw:.1e} on this mesh "
            f"(limit {_RAW_LIMIT:.0e}): it needs more elements around the interface"
        )
    available = resultants(elements, smooth, centre)[rows] * scale
    for _ in range(2):  # the second step removes the round-off of the first
        correction, *_ = np.linalg.lstsq(available, error, rcond=1e-9)
        vectors = vectors + smooth @ correction
        error = (wanted - resultants(elements, vectors, centre)[rows]) * scale
    left = float(np.abs(error / own).max())
    if left > 1e-9:
        raise MeshError(f"loads on {name!r} keep an unbalanced {left:.1e}")
    return vectors, raw


def direct_bearing(
    elements: Elements, loads: InterfaceLoads, force: FloatArray, arc: float = np.pi
) -> FloatArray:
    """Nodal forces (3 n_nodes,) of one cosine pressure on an arc, without a series.

    loads  the unit loads of the bore or journal
    force  (3,) F_x, F_y in N and M_z in N mm; half a part takes half of it
    arc    rad, the full angle on which the pressure acts: p0 cos(pi t / arc), |t| < arc/2

    The pressure pattern ends inside elements, so its raw resultant is off by the quadrature, which
    is fine (degree 19); it is scaled, and unit loads close what is left.
    """
    interface = loads.interface
    inward = interface.kind == "journal"
    force = elements.mesh.share * np.asarray(force)
    surface = elements.surface(interface.name, degree=19)
    direction = np.arctan2(force[1], force[0]) + (np.pi if inward else 0.0)

    def pressure(points: FloatArray) -> FloatArray:
        radial, angle = _radial(points, interface)
        away = (angle - direction + np.pi) % (2 * np.pi) - np.pi
        size = np.where(np.abs(away) < arc / 2, np.cos(np.pi * away / arc), 0.0)
        return np.asarray((-radial if inward else radial) * size[..., None])

    vector = np.zeros(len(loads.vectors))
    missing, size = force, np.hypot(force[0], force[1])
    if size:
        vector = nodal_forces(elements, surface, pressure)
        got = resultants(elements, vector[:, None], interface.centre)[:2, 0]
        vector *= size**2 / (got @ force[:2])
        missing = force - resultants(elements, vector[:, None], interface.centre)[IN_PLANE, 0]
    closing = [loads.names.index(name) for name in ("cos 1", "sin 1", "couple")]
    sign = -1.0 if inward else 1.0
    share = missing / (elements.mesh.share * np.array([sign, sign, 1.0]))
    return np.asarray(vector + loads.vectors[:, closing] @ share)


def harmonic_vectors(elements: Elements, interface: Interface, last: int) -> FloatArray:
    """Nodal forces (3 n_nodes, 2 last + 1) of unit harmonics of pressure on a bore or journal.

    The mean, 1/(2 pi R L), then cosine and sine of 1 to `last`, cos(n angle)/(pi R L): work with a
    displacement is the harmonic of its radial part. Those of n = 1 are 1 N along x and y exactly,
    the others have no resultant; half a part takes its half. Raises MeshError where the mesh is too
    coarse for them.
    """
    surface = elements.surface(interface.name)
    patterns = [_times(0.5, _round_harmonic(interface, 0, np.cos))]
    for n in range(1, last + 1):
        patterns += [_round_harmonic(interface, n, np.cos), _round_harmonic(interface, n, np.sin)]
    targets = np.zeros((6, len(patterns)))
    targets[[0, 1], [1, 2]] = -1.0 if interface.kind == "journal" else 1.0
    _, _, even, odd = _round_patterns(surface, interface, elements.mesh.share)
    smooth = even if elements.mesh.half else [*even, *odd]
    vectors, _raw = with_resultants(
        elements,
        interface.name,
        interface.centre,
        interface.radius,
        np.stack([nodal_forces(elements, surface, pattern) for pattern in patterns], axis=1),
        targets,
        np.stack([nodal_forces(elements, surface, pattern) for pattern in smooth], axis=1),
    )
    return vectors


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


def nodal_forces(elements: Elements, surface: FacetQuadrature, traction: Traction) -> FloatArray:
    """Nodal forces (3 n_nodes,), N, of a traction, MPa, at points (..., 3) of a surface."""
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


def _round_patterns(surface: FacetQuadrature, interface: Interface, _share: float) -> _Patterns:
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
    along_cos = _round_harmonic(interface, 1, np.cos, along=True)
    along_sin = _round_harmonic(interface, 1, np.sin, along=True)
    even = [
        _round_harmonic(interface, 1, np.cos),
        _round_harmonic(interface, 1, np.sin),
        _couple(interface),
    ]
    if interface.tilts:
        # the pattern z cos(theta) / r of _round_harmonic turns about y by the integral of
        # z**2 / (2 pi r**2 L) over the surface, z sin(theta) as much about -x
        lever = surface.points[..., 2] - interface.centre[2]
        second = float((surface.weights * lever**2).sum())
        size = sign * 2 * np.pi * interface.radius**2 * interface.length / second
        patterns["M_x"], patterns["M_y"] = _times(-size, along_sin), _times(size, along_cos)
        targets = np.column_stack([targets, np.eye(6)[:, [3, 4]]])
    return patterns, targets, even, [along_cos, along_sin]


def _times(factor: float, traction: Traction) -> Traction:
    return lambda points: factor * traction(points)


def _uniform(axis: int, area: float) -> Traction:
    def traction(points: FloatArray) -> FloatArray:
        field = np.zeros(points.shape)
        field[..., axis] = 1 / area
        return field

    return traction


def _linear(axis: int, by: int, interface: Interface, divisor: float) -> Traction:
    """Traction along one axis that grows with another one from the interface's centre."""

    def traction(points: FloatArray) -> FloatArray:
        field = np.zeros(points.shape)
        field[..., axis] = (points - interface.centre)[..., by] / divisor
        return field

    return traction


def _planar_targets() -> FloatArray:
    targets = np.zeros((6, 3))
    targets[[0, 1, 5], [0, 1, 2]] = 1.0
    return targets


def _face_patterns(surface: FacetQuadrature, interface: Interface, share: float) -> _Patterns:
    weights = surface.weights / share
    area = float(weights.sum())
    arm = surface.points - interface.centre
    second = {axis: float((weights * arm[..., axis] ** 2).sum()) for axis in (1, 2)}

    def twist(points: FloatArray) -> FloatArray:
        field, lever = np.zeros(points.shape), points - interface.centre
        field[..., 1], field[..., 2] = -lever[..., 2], lever[..., 1]
        return field / (second[1] + second[2])

    forces = [_uniform(axis, area) for axis in range(3)]
    bending = [_linear(0, axis, interface, -second[axis]) for axis in (1, 2)]
    patterns = {"F_x": forces[0], "F_y": forces[1], "M_z": bending[0]}
    # an uneven mesh puts the centre of its weights beside the centre: a shear then twists a little
    return patterns, _planar_targets(), [*forces[:2], bending[0]], [forces[2], bending[1], twist]


def _clamp_patterns(surface: FacetQuadrature, interface: Interface, share: float) -> _Patterns:
    """Friction along x, and a pressure along y that is even or grows with x, on both faces."""
    weights = surface.weights / share
    area = float(weights.sum())
    arm = surface.points - interface.centre
    second = [float((weights * arm[..., axis] ** 2).sum()) for axis in range(3)]
    friction, pressure = _uniform(0, area), _uniform(1, area)
    couple = _linear(1, 0, interface, second[0])
    patterns = {"F_x": friction, "F_y": pressure, "M_z": couple}
    across = [_linear(axis, 2, interface, second[2]) for axis in (0, 1)]
    return patterns, _planar_targets(), [friction, pressure, couple], across


_Builder = Callable[[FacetQuadrature, Interface, float], _Patterns]
_BUILDERS: dict[str, _Builder] = {
    "bore": _round_patterns,
    "journal": _round_patterns,
    "face": _face_patterns,
    "clamp": _clamp_patterns,
}


def inertia_of(properties: MassProperties) -> FloatArray:
    """Forces along x and y and moment about the origin of a rigid body's inertia, (3, 4).

    A column for each of ACCELERATIONS at 1: -m a, and -I alpha - r x m a about the origin.
    """
    mass, (x, y) = properties.mass, properties.centre[:2]
    about_origin = properties.inertia + mass * (x * x + y * y)
    return np.array(
        [
            [-mass, 0.0, mass * y, mass * x],
            [0.0, -mass, -mass * x, mass * y],
            [mass * y, -mass * x, -about_origin, 0.0],
        ]
    )
