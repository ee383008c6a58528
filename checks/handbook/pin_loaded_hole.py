"""Stress beside a pin's hole in a flat lug of any outline: plane stress, by series.

With Kolosov's and Muskhelishvili's potentials P = phi', Q = psi' of z = x + i y, the hole's middle
at 0 (Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953, sections
32 to 36)

    sigma_x + sigma_y = 4 Re P,    (sigma_y - sigma_x)/2 + i tau_xy = conj(z) P' + Q

are in equilibrium and compatible whatever P and Q are. Negative powers of z stand for the hole,
powers of z less the outline's middle for the rest; they are complete for a plate with one hole
(Runge). A force (X, Y) on the hole's edge adds, so that displacements close around it,

    P = -(X + i Y) / (2 pi (1 + kappa) z),   Q = kappa (X - i Y) / (2 pi (1 + kappa) z),

kappa = (3 - nu)/(1 + nu). The coefficients are those that meet the tractions on hole and outline
best, by least squares at many points (boundary collocation: Gross, Srawley and Brown, NASA TN
D-2395, 1964; for the strip Howland, Phil. Trans. A 229 (1930) 49). In an infinite plate Bickley's
series (Phil. Trans. A 227 (1928) 383) comes out of it.

Loads and outline are even or odd about the x axis: even states have real coefficients, odd ones
imaginary, and half of the outline tells all.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log, pi
from typing import Self

import numpy as np

from fem.solvers import SolverError
from fem.unit_loads import HARMONICS
from geometry.mesh import FloatArray

ComplexArray = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]


def patterns_of(harmonics: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the patterns of a pin's pressure and friction with some harmonics."""
    waves = (f"{wave} {n}" for n in harmonics for wave in (("cos", "sin") if n else ("cos",)))
    return (*waves, "couple")


PATTERNS = patterns_of(HARMONICS)
# of a bore's stress: by how much contacts exceed that of the assumed arcs (docs/validation.md)
BEYOND_ARCS = 0.07
THINNEST = 0.85  # hole over outline, nearest to each other: thinner rings are not computed
_FEWEST = 9  # powers of 1/z, in number; of z less the middle there are about twice as many
_LEFT = 0.003  # of a power, from the hole's edge to the outline nearest to it
_ON_HOLE = 3  # points on half of its edge, times the powers
_HOLE_WEIGHT = 2.0  # of its rows: there the stress is asked for


@dataclass(frozen=True, eq=False)
class LugOutline:
    """The upper half (y >= 0) of a lug's outline, from its free end to where it is cut, in points.

    points      (m,) x + i y, mm
    normals     (m,) outward, of length 1
    weights     (m,) mm of outline that a point stands for
    forced      (3, m) traction, complex, of a force 1 N along x on the lug, of one along y and of
                a couple 1 N mm, all on the hole and per thickness: what the rest of the part
                answers where it holds the lug, 1/mm and 1/mm2
    stiffening  (m,) mm, area of a stringer along a straight edge over the lug's thickness; 0: free
    """

    points: ComplexArray
    normals: ComplexArray
    weights: FloatArray
    forced: ComplexArray
    stiffening: FloatArray

    @property
    def numbers(self) -> bytes:
        """All of its numbers, to know an equal outline by."""
        rows = (self.points, self.normals, self.weights, *self.forced, self.stiffening)
        return np.array(rows, dtype=complex).tobytes()

    @classmethod
    def of_numbers(cls, numbers: bytes) -> Self:
        """The outline that has these numbers."""
        points, normals, weights, *forced, stiff = np.frombuffer(numbers, complex).reshape(7, -1)
        return cls(points, normals, weights.real, np.array(forced), stiff.real)


@dataclass(frozen=True, eq=False)
class PinLoadedHole:
    """Stress of unit patterns of a pin's pressure on a hole, times the lug's thickness.

    radius   mm
    outline  of the lug
    order    powers of 1/z, in number
    patterns as `fem.unit_loads.bearing_coefficients` has them: pressures cos(n t)/(pi r) per mm of
             thickness, n = 0, 1, 2, 4 (or more, on narrower arcs), whose n = 1 is a force of 1 N,
             and a couple of 1 N mm
    half     the lug's own for the patterns of the half circle, where these are more; else None
    """

    radius: float
    outline: LugOutline
    poisson_ratio: float
    even: FloatArray
    odd: FloatArray
    middle: float
    reach: float
    order: int
    patterns: tuple[str, ...] = PATTERNS
    half: Self | None = None

    def at(self, points: ComplexArray) -> FloatArray:
        """Stress xx, yy, xy (k, 3, 8) in 1/mm at points x + i y of the lug, of the patterns."""
        found = np.zeros((len(points), 3, len(self.patterns)))
        powers = _powers(points, self.radius, self.middle, self.reach, self.order)
        solved = self.patterns
        if self.half is not None:
            known = self.half.patterns
            found[:, :, [self.patterns.index(name) for name in known]] = self.half.at(points)
            solved = tuple(name for name in self.patterns if name not in known)
        for odd, coefficients in ((False, self.even), (True, self.odd)):
            total, deviator = _terms(points, powers, odd=odd)
            own = _fixed(points, self.poisson_ratio, odd=odd)
            half, skew = total @ coefficients / 2, deviator @ coefficients
            names = _names(solved, odd=odd)
            half[:, _forces(names)] += own[0][:, None] / 2
            skew[:, _forces(names)] += own[1][:, None]
            columns = [self.patterns.index(name) for name in names]
            found[:, 0, columns] = half - skew.real
            found[:, 1, columns] = half + skew.real
            found[:, 2, columns] = skew.imag
        return found


def pin_loaded_hole(
    radius: float,
    outline: LugOutline,
    poisson_ratio: float,
    harmonics: tuple[int, ...] = HARMONICS,
) -> PinLoadedHole:
    """Solve a lug for the patterns of a pin's pressure and friction on its hole.

    A lug that was solved before is not solved again. Raises SolverError for a ring that is thinner
    than the series is good for.

    radius     mm, of the hole
    harmonics  of the pressure
    """
    ratio = radius / float(np.abs(outline.points).min())
    if ratio > THINNEST:
        raise SolverError(
            f"the hole takes {ratio:.3g} of its lug, at most {THINNEST:g} is computed by series"
        )
    middle = float((outline.points.real.min() + outline.points.real.max()) / 2)
    reach = float(np.abs(outline.points - middle).max())
    # what the hole needs falls like (radius/distance)^n; both sides of a ring disturb each other
    order, half = max(_FEWEST, ceil(log(_LEFT) / log(ratio))), None
    patterns = solved = patterns_of(harmonics)
    if harmonics != HARMONICS:
        half = pin_loaded_hole(radius, outline, poisson_ratio)
        order = max(order, max(harmonics) + 1)
        solved = tuple(name for name in patterns if name not in half.patterns)
    sizes = middle, reach, order
    even, odd = _coefficients(radius, outline.numbers, poisson_ratio, *sizes, solved)
    return PinLoadedHole(
        radius, outline, poisson_ratio, even, odd, *sizes, patterns=patterns, half=half
    )


@lru_cache(maxsize=32)
def _coefficients(
    radius: float,
    numbers: bytes,
    poisson_ratio: float,
    middle: float,
    reach: float,
    order: int,
    patterns: tuple[str, ...],
) -> tuple[FloatArray, FloatArray]:
    """Coefficients of the even and the odd patterns, solved once for lugs of the same numbers."""
    outline = LugOutline.of_numbers(numbers)
    on_hole = max(25, _ON_HOLE * order)
    angles = (np.arange(on_hole) + 0.5) / on_hole * pi
    rim = radius * np.exp(1j * angles)
    on_rim, on_outline = (_powers(at, radius, middle, reach, order) for at in (rim, outline.points))
    found = []
    for odd in (False, True):
        names = _names(patterns, odd=odd)
        matrix, right = [], []
        for points, powers, normals, weights, inside in (
            (rim, on_rim, -rim / radius, np.full(on_hole, pi * radius / on_hole), True),
            (outline.points, on_outline, outline.normals, outline.weights, False),
        ):
            total, deviator = _terms(points, powers, odd=odd)
            own = _fixed(points, poisson_ratio, odd=odd)
            rows = _traction(total, deviator, normals[:, None])
            fixed = _traction(own[0], own[1], normals)
            if inside:
                wanted = _on_rim(angles, radius, names)
            else:
                wanted = _held(outline, names)
                stiff = outline.stiffening
                if stiff.any():
                    rows = rows + _stringer(points, powers, stiff, poisson_ratio, odd=odd)
                    fixed = fixed + _own_stringer(points, stiff, poisson_ratio, odd=odd)
            wanted[:, _forces(names)] -= fixed[:, None]
            scale = np.sqrt(weights / radius) * (_HOLE_WEIGHT if inside else 1.0)
            for part in (np.real, np.imag):
                matrix.append(part(rows) * scale[:, None])
                right.append(part(wanted) * scale[:, None])
        table, goal = np.concatenate(matrix), np.concatenate(right)
        size = np.linalg.norm(table, axis=0)
        size[size == 0] = 1.0  # an imaginary constant P is a turn of the whole lug
        solved, *_ = np.linalg.lstsq(table / size, goal, rcond=1e-12)
        found.append(solved / size[:, None])
    return found[0], found[1]


def _names(patterns: tuple[str, ...], *, odd: bool) -> tuple[str, ...]:
    """Patterns that are even about the x axis, or odd."""
    return tuple(n for n in patterns if n.startswith("cos") is not odd)


def _forces(names: tuple[str, ...]) -> list[int]:
    """Which of these patterns push with a force."""
    return [k for k, name in enumerate(names) if name in ("cos 1", "sin 1")]


_Powers = tuple[ComplexArray, ComplexArray, ComplexArray]


def _powers(
    points: ComplexArray, radius: float, middle: float, reach: float, order: int
) -> _Powers:
    """Terms (k, m) of a potential, and their first and second derivatives by z."""
    n = np.arange(2, order + 2)
    inverse = (radius / points[:, None]) ** n
    z = points[:, None]
    p = np.arange(2 * order)
    w = (z - middle) / reach
    rising = w**p
    first, second = np.zeros((2, *rising.shape), dtype=complex)
    first[:, 1:] = p[1:] * rising[:, :-1] / reach
    second[:, 2:] = p[2:] * p[1:-1] * rising[:, :-2] / reach**2
    return (
        np.concatenate([inverse, rising], axis=1),
        np.concatenate([-n * inverse / z, first], axis=1),
        np.concatenate([n * (n + 1) * inverse / z**2, second], axis=1),
    )


def _terms(points: ComplexArray, powers: _Powers, *, odd: bool) -> tuple[FloatArray, ComplexArray]:
    """Trace sigma_x + sigma_y and (sigma_y - sigma_x)/2 + i tau_xy of each term of P, then of Q."""
    value, slope, _ = powers
    unit = 1j if odd else 1.0
    trace = np.concatenate([4 * (unit * value).real, np.zeros(value.shape)], axis=1)
    of_p = points.conj()[:, None] * unit * slope
    return trace, np.concatenate([of_p, unit * value], axis=1)


def _fixed(
    points: ComplexArray, poisson_ratio: float, *, odd: bool
) -> tuple[FloatArray, ComplexArray]:
    """Trace and deviator of a force of 1 N along x, or along y, on the hole's edge."""
    kappa = (3 - poisson_ratio) / (1 + poisson_ratio)
    force = 1j if odd else 1.0
    p = -force / (2 * pi * (1 + kappa))
    q = kappa * np.conj(force) / (2 * pi * (1 + kappa))
    return 4 * (p / points).real, -p * points.conj() / points**2 + q / points


def _traction(trace: FloatArray, deviator: ComplexArray, normal: ComplexArray) -> ComplexArray:
    """X + i Y on a surface with an outward normal: (trace/2) n - conj(D n)."""
    return np.asarray(trace / 2 * normal - np.conj(deviator * normal))


def _on_rim(angles: FloatArray, radius: float, names: tuple[str, ...]) -> ComplexArray:
    """Tractions (k, patterns) on the hole's edge: pressures point outward, the couple around."""
    outward = np.exp(1j * angles)
    columns = []
    for name in names:
        if name == "couple":
            columns.append(1j * outward / (2 * pi * radius**2))
            continue
        wave, n = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(n) * angles)
        columns.append(outward * size / (pi * radius))
    return np.stack(columns, axis=1)


def _held(outline: LugOutline, names: tuple[str, ...]) -> ComplexArray:
    """Tractions (m, patterns) that the rest of the part answers."""
    by_name = {"cos 1": 0, "sin 1": 1, "couple": 2}
    columns = [
        outline.forced[by_name[name]] if name in by_name else np.zeros(len(outline.points), complex)
        for name in names
    ]
    return np.stack(columns, axis=1)


def _stringer(
    points: ComplexArray,
    powers: _Powers,
    stiffening: FloatArray,
    poisson_ratio: float,
    *,
    odd: bool,
) -> ComplexArray:
    """Shear traction that a stringer along an edge y = constant takes off, per term.

    The lug pulls the stringer along: tau ds = -d(A E epsilon_x), E epsilon_x = sigma_x - nu sigma_y
    = (1 - nu) trace/2 - (1 + nu) Re D. Its rate along x is what is added to the traction.
    """
    value, slope, bend = powers
    unit = 1j if odd else 1.0
    trace = np.concatenate([4 * (unit * slope).real, np.zeros(value.shape)], axis=1)
    of_p = unit * slope + points.conj()[:, None] * unit * bend
    deviator = np.concatenate([of_p, unit * slope], axis=1)
    rate = (1 - poisson_ratio) / 2 * trace - (1 + poisson_ratio) * deviator.real
    return np.asarray(-stiffening[:, None] * rate + 0j)


def _own_stringer(
    points: ComplexArray, stiffening: FloatArray, poisson_ratio: float, *, odd: bool
) -> ComplexArray:
    """The same of the force's own fixed terms."""
    kappa = (3 - poisson_ratio) / (1 + poisson_ratio)
    force = 1j if odd else 1.0
    p = -force / (2 * pi * (1 + kappa))
    q = kappa * np.conj(force) / (2 * pi * (1 + kappa))
    z = points
    trace = -4 * (p / z**2).real
    deviator = -p / z**2 + 2 * p * z.conj() / z**3 - q / z**2
    rate = (1 - poisson_ratio) / 2 * trace - (1 + poisson_ratio) * deviator.real
    return np.asarray(-stiffening * rate + 0j)


# Stress at open holes of bent and pulled plates, and in sections of curved plates.


def open_hole(angles: FloatArray, share: float) -> FloatArray:
    """Hoop stress (k, 3) at a hole's edge per unit of what a plate has there without the hole.

    Of sigma_x at its middle, of the rate of sigma_x along y times the radius, and of tau_xy:

        1 - 2 cos 2t,    sin t - sin 3t,    -4 sin 2t

    in a wide plate. The first and third are Kirsch's. The second follows from Airy's function
    g y^3/6 = g r^3 (3 sin t - sin 3t)/24 with the terms r^-1 sin t, r^-1 sin 3t and r^-3 sin 3t
    that free the edge (docs/theory/plates.md). In a plate that is not wide they are raised as the
    nominal stress is that the ligaments have: the first by [2 + (1 - d/W)^3]/3 over 1 - d/W
    (Heywood's fit of Howland's strip, see `notch_factors`), the second by 1/(1 - (d/W)^3).

    share  d/W, diameter over the plate's width
    """
    left = 1 - share
    tension = (2 + left**3) / 3 / left
    bending = 1 / (1 - share**3)
    return np.stack(
        [
            tension * (1 - 2 * np.cos(2 * angles)),
            bending * (np.sin(angles) - np.sin(3 * angles)),
            -4 * np.sin(2 * angles) / left,
        ],
        axis=1,
    )


@dataclass(frozen=True, eq=False)
class CurvedSection:
    """A plate's section whose fibres are arcs about one centre, by Winkler's theory.

    spans      (m, 2) mm, from where to where it has material, by the distance from the centre
    thickness  (m,) mm of each of them, as far as it takes part

    A plane section that shifts and turns strains a fibre, whose length is in proportion to r, by
    a + b/r. The sums of stress and of its moment about the centroid give a and b, so

        sigma = N/A + M (A - r A_m)/(A r (R A_m - A)),    A_m = integral of dA/r,

    R the centroid's r, M above 0 where it pulls the inside (docs/theory/plates.md).
    """

    spans: FloatArray
    thickness: FloatArray

    @property
    def area(self) -> float:
        """Area, mm2."""
        return float(np.diff(self.spans, axis=1)[:, 0] @ self.thickness)

    @property
    def centroid(self) -> float:
        """Distance of its centroid from the centre, mm."""
        return float(np.diff(self.spans**2, axis=1)[:, 0] @ self.thickness) / 2 / self.area

    def stress(self, radii: FloatArray) -> FloatArray:
        """Stress (k, 2) along the fibres at r (k,), MPa per N at the centroid and per N mm."""
        area, mean = self.area, float(np.diff(np.log(self.spans), axis=1)[:, 0] @ self.thickness)
        bent = (area - radii * mean) / (area * radii * (self.centroid * mean - area))
        return np.stack([np.full(len(radii), 1 / area), bent], axis=1)
