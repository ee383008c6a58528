"""Scalar readings of solids with known answers, on meshes like a user's, at any fineness.

Error bars are calibrated with them: `CASES` names each quantity, its reference and how far to
trust it, and solves it with every element size divided by `fineness`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fem.recovery import von_mises
from fem.unit_solutions import determinate_hold
from geometry.bars import rectangle_torsion

from ...boundary_value import SolidProblem, traction_load, uniform_load, unknowns
from . import bodies, fields, problems
from .problems import STEEL, held

XX, YY, ZZ, XY, YZ, ZX = range(6)


@dataclass(frozen=True)
class Reading:
    """One quantity on one mesh.

    value    recovered at the named point
    scatter  of the elements that meet there (Recovery.scatter); None for a displacement
    size     mm, of the elements at the named point
    """

    value: float
    scatter: float | None
    size: float


@dataclass(frozen=True)
class Case:
    """A quantity with a reference.

    quantity     what is read, and where
    exactness    "exact" or "converged"
    uncertainty  of the reference, in its unit
    order        with which the quantity converges
    """

    id: str
    quantity: str
    reference: float
    exactness: str
    uncertainty: float
    solve: Callable[[float], Reading]
    order: float = 2.0


def _read(solution, place, size, of):
    """A reading of `solution`: of stress (6,) at a place."""
    value = of(solution.stress_at(place))
    return Reading(float(value), solution.scatter_at(place), size)


@lru_cache(maxsize=8)
def _ring(fineness):
    return problems.pressed_ring(bodies.ring_body(50, 100, 25, 25, 12.5).mesh(fineness))


def _ring_reading(place, size, of):
    return lambda fineness: _read(_ring(fineness), place, size / fineness, of)


@lru_cache(maxsize=8)
def _plate(fineness):
    return problems.thick_plate(bodies.plate_body(220.0).mesh(fineness))


@lru_cache(maxsize=8)
def _shell(fineness, side):
    """Eighth of a spherical shell, 100 MPa on its inside ("x0") or outside ("x1")."""
    mesh = bodies.shell_body(50, 100, 30, 12.5).mesh(fineness)
    supports = held(mesh, ("y1", "x"), ("y0", "y"), ("z0", "z"))
    problem = SolidProblem(mesh, STEEL, supports)
    return problem.solve(traction_load(problem.elements, side, lambda _, normals: -100.0 * normals))


def _pulled(mesh, sides, field, supports):
    """A body whose sides carry the tractions of an exact stress field."""
    problem = SolidProblem(mesh, STEEL, supports)
    load = sum(
        traction_load(
            problem.elements, side, lambda x, n: np.einsum("...ij,...j->...i", field(x), n)
        )
        for side in sides
    )
    return problem.solve(load)


@lru_cache(maxsize=8)
def _cavity(fineness):
    mesh = bodies.cavity_body(10, 40, 14, 2.5).mesh(fineness)
    supports = held(mesh, ("x0", "x"), ("y0", "y"), ("z0", "z"))
    return _pulled(
        mesh, ("x1", "y1", "z1"), lambda x: fields.around_a_cavity(x, 10, 100, 0.3), supports
    )


@lru_cache(maxsize=8)
def _hole(fineness):
    mesh = bodies.hole_body(10, 40, 5, 10, 2.5).mesh(fineness)
    supports = held(mesh, ("x0", "x"), ("y0", "y"), ("z0", "z"), ("z1", "z"))
    return _pulled(mesh, ("x1", "y1"), lambda x: fields.around_a_hole(x, 10, 100, 0.3), supports)


@lru_cache(maxsize=8)
def _curved(fineness):
    """FE-10 without strain along z, which leaves the stress in the plane as it is."""
    mesh = bodies.ring_body(30, 50, 5, 7.0, 7.0).mesh(fineness)
    corner = [int(np.argmin(np.abs(mesh.nodes - p).sum(axis=1))) for p in ((0, 30, 0), (0, 50, 0))]
    pins = np.r_[unknowns(np.array(corner[:1]), "xy"), unknowns(np.array(corner[1:]), "x")]
    supports = np.union1d(held(mesh, ("z0", "z"), ("z1", "z")), pins)
    return _pulled(
        mesh, ("y0", "y1"), lambda x: fields.in_a_curved_bar(x, 30, 50, 100, 0.3), supports
    )


@lru_cache(maxsize=8)
def _disc(fineness):
    return problems.turning_disc(bodies.ring_body(50, 200, 2.0, 30, 10).mesh(fineness))


@lru_cache(maxsize=8)
def _cantilever(fineness):
    mesh = bodies.bar_body(100.0, 20.0, 10.0, 6.0, (50.0, 10.0, 0.0)).mesh(fineness)
    problem = SolidProblem(mesh, STEEL, held(mesh, ("x0", "xyz")))
    return problem.solve(uniform_load(problem.elements, "x1", (0.0, 1000.0, 0.0)))


@lru_cache(maxsize=8)
def _torsion(fineness, width):
    """A bar of width x 10 mm, six widths long, under end torques of 1 N mm."""
    length = 6.0 * width
    mesh = bodies.bar_body(length, width, 10.0, 4.0, (length / 2, 0.0, 5.0)).mesh(fineness)
    return problems.twisted_bar(mesh, width, 10.0)


def _shear(stress):
    return np.hypot(stress[XY], stress[ZX])


def _torsion_reading(width):
    def solve(fineness):
        place = (3.0 * width, 0.0, 5.0)
        modulus = float(rectangle_torsion(width, 10.0)[1])
        reading = _read(_torsion(fineness, width), place, 4.0 / fineness, _shear)
        return Reading(reading.value * modulus, reading.scatter * modulus, reading.size)

    return solve


@lru_cache(maxsize=8)
def _shaft(fineness):
    """A round bar, r = 10 mm: end tractions of torsion (1) and bending (0.5), 100 MPa each."""
    mesh = bodies.shaft_body(10.0, 60.0, 5.0).mesh(fineness)
    problem = SolidProblem(mesh, STEEL, determinate_hold(mesh.nodes))

    def field(points):
        stress = np.zeros((*points.shape[:-1], 3, 3))
        stress[..., 0, 0] = 5.0 * points[..., 1]
        stress[..., 0, 1] = stress[..., 1, 0] = -10.0 * points[..., 2]
        stress[..., 0, 2] = stress[..., 2, 0] = 10.0 * points[..., 1]
        return stress

    return _pulled(mesh, ("x0", "x1"), field, problem.held)


@lru_cache(maxsize=8)
def _turning_bar(fineness):
    mesh = bodies.bar_body(100.0, 20.0, 20.0, 10.0).mesh(fineness)
    return problems.turning_bar(mesh, omega=1500.0)


@lru_cache(maxsize=8)
def _twisted(fineness):
    counts = tuple(max(round(n * fineness), 1) for n in (16, 3, 1))
    return problems.twisted_beam((counts[0], 2 * -(-counts[1] // 2), counts[2]))


def _twisted_reading(load):
    return lambda fineness: Reading(_twisted(fineness)[load], None, 0.75 / fineness)


def _of(component):
    return lambda stress: stress[component]


def _at(solved, place, size, component):
    return lambda fineness: _read(solved(fineness), place, size / fineness, _of(component))


def _exact(id_, quantity, reference, solve, uncertainty=0.0):
    return Case(id_, quantity, reference, "exact", uncertainty, solve)


_SPIN = 7.85e-9 * 1500.0**2 * 100.0**2 / 2

CASES = (
    _exact("FE-04", "thick cylinder: hoop stress at the bore", 166.6666667,
           _ring_reading((50, 0, 0), 12.5, _of(YY))),
    _exact("FE-04", "thick cylinder: von Mises stress at the bore", 231.3246876,
           _ring_reading((50, 0, 0), 12.5, von_mises)),
    _exact("FE-04", "thick cylinder: hoop stress outside", 66.66666667,
           _ring_reading((100, 0, 0), 25.0, _of(YY))),
    Case("FE-08", "LE10: sigma_yy at D", -5.385, "converged", 0.02,
         _at(_plate, (2000, 0, 600), 220.0, YY)),
    Case("FE-12", "twisted beam: tip deflection (a)", 0.0054247, "converged", 2e-7,
         _twisted_reading(0)),
    Case("FE-12", "twisted beam: tip deflection (b)", 0.0017534, "converged", 1e-7,
         _twisted_reading(1)),
    _exact("FE-05 3-D", "hole in a slab: hoop stress across the pull", 300.0,
           _at(_hole, (0, 10, 0), 2.5, XX)),
    _exact("FE-05 3-D", "hole in a slab: hoop stress in line with the pull", -100.0,
           _at(_hole, (10, 0, 0), 2.5, YY)),
    _exact("FE-10 3-D", "curved bar: hoop stress inside", -77.968651,
           _at(_curved, (0, 30, 0), 7.0, XX)),
    _exact("FE-10 3-D", "curved bar: hoop stress outside", 46.781191,
           _at(_curved, (0, 50, 0), 7.0, XX)),
    _exact("FE-17 3-D", "turning disc: hoop stress at the bore", 262.484375,
           _at(_disc, (50, 0, 0), 10.0, YY), uncertainty=0.003),
    _exact("FE-17 3-D", "turning disc: hoop stress at the rim", 71.140625,
           _at(_disc, (200, 0, 0), 30.0, YY), uncertainty=0.003),
    _exact("FE-18 3-D", "turning bar: stress at the root", _SPIN,
           _at(_turning_bar, (0, 10, 10), 10.0, XX)),
    _exact("FE-14 3-D", "square bar in torsion: peak shear times T / W", 1.0,
           _torsion_reading(10.0)),
    _exact("FE-14 3-D", "flat bar 2:1 in torsion: peak shear times T / W", 1.0,
           _torsion_reading(20.0)),
    _exact("cantilever", "fibre stress half way along", -1000.0 * 50.0 * 10.0 * 12 / (10 * 20**3),
           _at(_cantilever, (50, 10, 0), 6.0, XX)),
    _exact("shaft", "round bar: shear of torsion at its skin", 100.0,
           _at(_shaft, (30, 10, 0), 5.0, ZX)),
    _exact("shaft", "round bar: stress of bending at its skin", 50.0,
           _at(_shaft, (30, 10, 0), 5.0, XX)),
    _exact("Lame sphere", "spherical shell: hoop stress inside, pressed inside", 500 / 7,
           lambda f: _read(_shell(f, "x0"), (50, 0, 0), 12.5 / f, _of(YY))),
    _exact("Lame sphere", "spherical shell: hoop stress outside, pressed inside", 150 / 7,
           lambda f: _read(_shell(f, "x0"), (100, 0, 0), 30.0 / f, _of(YY))),
    _exact("Lame sphere", "spherical shell: hoop stress inside, pressed outside", -1200 / 7,
           lambda f: _read(_shell(f, "x1"), (50, 0, 0), 12.5 / f, _of(YY))),
    _exact("Goodier", "spherical cavity: axial stress at its equator", 2250 / 11,
           _at(_cavity, (10, 0, 0), 2.5, ZZ)),
    _exact("Goodier", "spherical cavity: hoop stress at its pole", -750 / 11,
           _at(_cavity, (0, 0, 10), 2.5, XX)),
)  # fmt: skip
