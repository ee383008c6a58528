"""Peaks and stresses with exact or converged references, as an ordinary user would compute them.

Every case is solved on an unstructured mesh whose element at the hot spot is, at fineness 1, a
quarter or a fifth of the radius there. The readings are by the plane kernel's own rule: `value` at
the named point or the largest over the nodes of an edge, `scatter` of the elements that meet at
that node (0 at a mid-side node of the boundary, which has one element only), `size` of the
elements there. Made to calibrate error bars: how many of them hold the reference?
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from . import problems, problems_exact
from .readings import (
    Measure,
    Reading,
    along,
    hoop,
    node_at,
    out_of_plane,
    peak,
    principal,
    radial,
    read,
    shear,
    von_mises,
)

FINENESSES = (0.7, 1.0, 1.4, 2.0)
Place = tuple[float, float] | str  # a point, or an edge to take the peak of


@dataclass(frozen=True)
class Case:
    """One scalar with a reference.

    exactness    "exact" or "converged"
    uncertainty  of the reference, in its unit
    solve        fineness -> Reading
    order        with which the quantity converges: 1 where a pressure ends
    """

    id: str
    quantity: str
    reference: float
    exactness: str
    uncertainty: float
    solve: Callable[[float], Reading]
    order: float = 2.0


def _plane(problem: Callable, size: float, place: Place, measure: Measure, fineness: float):
    solution = problem(fineness)
    if isinstance(place, str):
        value, node = peak(solution, place, measure)
    else:
        value, node = read(solution, place, measure), node_at(solution, *place)
    return Reading(value, float(solution.scatter[node]), size / fineness)


def _torsion(problem: Callable, size: float, place: tuple[float, float], fineness: float):
    section = problem(fineness)
    node = section.mesh.nearest_node(*place)
    assert np.allclose(section.mesh.nodes[node], place, rtol=0, atol=1e-9)
    value = float(np.hypot(*section.shear[node]))
    return Reading(value, float(section.scatter[node]), size / fineness)


def _hole_under_cosines() -> list[Case]:
    at = partial(partial, _plane, problems_exact.hole_under_cosines, 2.5)
    end, middle = 400 / np.pi, 400 / np.pi - 100.0
    of_sheet = 2e-4 * end
    name = "hole under |cos|"
    return [
        Case(name, "hoop at the end of the arc", end, "exact", of_sheet, at((0, 10), hoop), 1.0),
        Case(name, "hoop in its middle", middle, "exact", of_sheet, at((10, 0), hoop)),
    ]


def _exact(id_: str, quantity: str, reference: float, solve: Callable[[float], Reading]) -> Case:
    return Case(id_, quantity, reference, "exact", 0.0, solve)


def _converged(id_, quantity, reference, uncertainty, solve) -> Case:
    return Case(id_, quantity, reference, "converged", uncertainty, solve)


def _cantilever() -> list[Case]:
    at = partial(partial, _plane, problems_exact.cantilever, 3.0)
    return [
        _exact("FE-03", "fibre stress at the root", 2000.0, at((0, -6), along(0))),
        _exact("FE-03", "shear stress at the root's middle", 125.0, at((0, 0), shear)),
    ]


def _cylinder() -> list[Case]:
    sector = partial(partial, _plane, partial(problems.pressed_cylinder, "strain"))
    slice_ = partial(partial, _plane, partial(problems.pressed_cylinder, "axisymmetric"))
    plane, whole = partial(sector, 10.0), partial(slice_, 10.0)
    inner, outer = 500 / 3, 200 / 3
    bore = float(np.sqrt(((inner + 100) ** 2 + (20 - inner) ** 2 + 120**2) / 2))
    return [
        _exact("FE-04", "plane strain: hoop at the bore", inner, plane((50, 0), hoop)),
        _exact("FE-04", "plane strain: radial at the bore", -100.0, plane((50, 0), radial)),
        _exact("FE-04", "plane strain: von Mises at the bore", bore, plane((50, 0), von_mises)),
        _exact("FE-04", "plane strain: hoop outside", outer, sector(16.0, (100, 0), hoop)),
        _exact("FE-04", "axisymmetric: hoop at the bore", inner, whole((50, 0), out_of_plane)),
        _exact("FE-04", "axisymmetric: radial at the bore", -100.0, whole((50, 0), along(0))),
        _exact("FE-04", "axisymmetric: von Mises at the bore", bore, whole((50, 0), von_mises)),
        _exact("FE-04", "axisymmetric: hoop outside", outer, slice_(16.0, (100, 0), out_of_plane)),
    ]


def _infinite_sheets() -> list[Case]:
    kirsch = partial(partial, _plane, problems.kirsch)
    sharp = partial(
        partial,
        _plane,
        partial(problems_exact.elliptic_hole, 10.0, 5.0),
        problems_exact.tip_size(10.0, 5.0),
    )
    blunt = partial(
        partial,
        _plane,
        partial(problems_exact.elliptic_hole, 5.0, 10.0),
        problems_exact.tip_size(5.0, 10.0),
    )
    return [
        _exact("FE-05", "hoop beside the load", 300.0, kirsch(2.5, (0, 10), hoop)),
        _exact("FE-05", "hoop in line with the load", -100.0, kirsch(2.5, (10, 0), hoop)),
        _exact("FE-05", "stress a radius away", 121.875, kirsch(5.0, (0, 20), along(0))),
        _exact("ellipse 2:1 across", "peak at the sharp tip", 500.0, sharp((10, 0), along(90))),
        _exact("ellipse 2:1 across", "stress at the flat tip", -100.0, sharp((0, 5), along(0))),
        _exact("ellipse 2:1 along", "peak at the flat tip", 200.0, blunt((5, 0), along(90))),
        _exact("ellipse 2:1 along", "stress at the sharp tip", -100.0, blunt((0, 10), along(0))),
    ]


def _strips() -> list[Case]:
    """FE-06, net stress 1."""
    factors = {0.1: 2.732517, 0.2: 2.522053, 0.4: 2.248293, 0.5: 2.1738, 0.8: 2.069981}
    cases = []
    for ratio, factor in factors.items():
        at = partial(partial, _plane, partial(problems.strip, ratio), problems.strip_size(ratio))
        cases.append(_converged("FE-06", f"Kt,net, d/W = {ratio}", factor, 2e-6, at((0, 1), hoop)))
        if ratio == 0.5:
            edge = at((0, 2), along(0))
            cases.append(_converged("FE-06", "edge of the strip", 0.35437, 1e-5, edge))
    return cases


def _notches() -> list[Case]:
    ellipse = partial(_plane, problems.ellipse, 200.0)
    ring = partial(partial, _plane, problems.ring_with_end_force, 5.0)
    flat = partial(_plane, partial(problems.fillet, "tension"), 1.0)
    bent = partial(_plane, partial(problems.fillet, "bending"), 1.0)
    turned = partial(_plane, partial(problems.fillet, "round"), 1.0)
    edge = "fillet"
    return [
        _converged(
            "FE-07", "sigma_yy at D", 92.65818, 2e-5, partial(ellipse, (2000, 0), along(90))
        ),
        _exact("FE-10", "hoop inside", -77.968651, ring((0, 30), hoop)),
        _exact("FE-10", "hoop outside", 46.781191, ring((0, 50), hoop)),
        _converged("FE-15", "Kt flat tension", 2.29467, 2e-4, partial(flat, edge, principal)),
        _converged("FE-15", "Kt flat bending", 1.8972, 5e-4, partial(bent, edge, principal)),
        _converged("FE-15", "Kt round tension", 2.1142, 5e-4, partial(turned, edge, principal)),
    ]


def _lug() -> list[Case]:
    at = partial(partial, _plane, problems.lug, 2.5)
    side = 10 * 0.5**0.5
    return [
        _converged("FE-16", "hoop at 90 deg", 111.78, 0.02, at((0, 10), hoop)),
        _converged("FE-16", "hoop at 0 deg", -7.42683, 1e-5, at((10, 0), hoop)),
        _converged("FE-16", "hoop at 45 deg", 48.9452, 1e-4, at((side, side), hoop)),
        _converged("FE-16", "hoop at 135 deg", 20.0243, 2e-4, at((-side, side), hoop)),
        _converged("FE-16", "hoop at 180 deg", -35.32038, 1e-5, at((-10, 0), hoop)),
        _converged("FE-16", "von Mises peak", 113.441, 2e-3, at("pressed", von_mises)),
    ]


def _discs() -> list[Case]:
    solid = partial(partial, _plane, partial(problems.disc, 0.0), 30.0)
    bored = partial(partial, _plane, partial(problems.disc, 50.0))
    return [
        _exact("FE-17", "solid: centre", 129.525, solid((0, 0), along(0))),
        _exact("FE-17", "solid: hoop at the rim", 54.95, solid((200, 0), hoop)),
        _exact("FE-17", "hole: hoop at the bore", 262.484375, bored(12.5, (50, 0), hoop)),
        _exact("FE-17", "hole: hoop at the rim", 71.140625, bored(30.0, (200, 0), hoop)),
        _exact("FE-17", "hole: largest radial", 72.8578125, bored(17.5, (0, 100), radial)),
    ]


def _spheres() -> list[Case]:
    """Goodier (1933): a cavity in a bar, nu = 0.3; Lame: a shell under pressure."""
    cavity = partial(partial, _plane, problems_exact.spherical_cavity, 0.25)
    shell = partial(partial, _plane, problems_exact.spherical_shell)
    nu = problems_exact.NU
    equator, pole = ((27 - 15 * nu) / (14 - 10 * nu), -(3 + 15 * nu) / (14 - 10 * nu))
    return [
        _converged("cavity", "axial at its equator", equator, 5e-4, cavity((1, 0), along(90))),
        _converged("cavity", "hoop at its pole", pole, 5e-4, cavity((0, 1), along(0))),
        _exact("shell", "hoop at the bore", 500 / 7, shell(10.0, (50, 0), out_of_plane)),
        _exact("shell", "von Mises at the bore", 1200 / 7, shell(10.0, (50, 0), von_mises)),
        _exact("shell", "hoop outside", 150 / 7, shell(16.0, (100, 0), out_of_plane)),
    ]


def _torsion_cases() -> list[Case]:
    """Largest shear stress per unit torque; FE-14, Timoshenko and Goodier, articles 104, 106."""
    cases = []
    for breadth, factor in ((1, 4.803875538), (2, 4.067051989), (10, 3.201791838)):
        solve = partial(
            _torsion, partial(problems_exact.twisted_rectangle, breadth), 0.25, (0, -0.5)
        )
        cases.append(_exact("FE-14", f"largest shear, b/t = {breadth}", factor / breadth, solve))
    ellipse = partial(_torsion, problems_exact.twisted_ellipse, 0.4, (0, 1))
    triangle = partial(_torsion, problems_exact.twisted_triangle, 0.2, (0, 0))
    return [
        *cases,
        _exact("twisted ellipse 2:1", "largest shear", 1 / np.pi, ellipse),
        _exact("twisted triangle", "largest shear", 20.0, triangle),
    ]


CASES: tuple[Case, ...] = (
    *_cantilever(),
    *_cylinder(),
    *_infinite_sheets(),
    *_hole_under_cosines(),
    *_strips(),
    *_notches(),
    *_lug(),
    *_discs(),
    *_spheres(),
    *_torsion_cases(),
)
