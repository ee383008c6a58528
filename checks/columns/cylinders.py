"""Hydraulic and pneumatic cylinders: buckling over the stroke, bending of the rod, pressure.

A cylinder is a force between two points with dimensions. It carries that force alone: a column of
tube and rod, hinged at its eyes, whose length changes with the stroke (docs/theory/cylinders.md).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

import loads
from checks.design.data import Cylinder, Design
from checks.design.errors import DesignError
from checks.design.materials import Material
from checks.handbook.column_curves import bisected, buckling_force, largest_moments
from checks.part.derived import (
    NO_BAND,
    Band,
    Heading,
    Kind,
    Series,
    demand_over,
    derivation_at,
    derived_check,
)
from checks.part.part_loads import Runs, first_largest, labels_of, stretches_of
from checks.result.derivation import Given, Item, LoadCase, Step
from checks.result.verdict import Check
from checks.strength.sampling import Spline, with_sampling
from geometry.mesh import FloatArray, IntArray

_PAGE = "[cylinders](../theory/cylinders.md)"
BUCKLING = Kind(
    name="buckling",
    quantity="cylinder {}, elastic load share",
    demand="force over the force at which tube and rod buckle as a hinged column at this length",
    limit="1",
    require="buckling",
    source=_PAGE,
)
ROD = Kind(
    name="static",
    quantity="rod of cylinder {}, stress",
    demand="compression or pull, and bending by weight, play and deflection, in the rod",
    limit="yield stress of the rod",
    require="static",
    source=_PAGE,
)
TUBE = Kind(
    name="static",
    quantity="tube of cylinder {}, stress",
    demand="equivalent stress by Tresca of pressure and bending at the bore of the tube",
    limit="yield stress of the tube",
    require="static",
    source=_PAGE,
)
KINDS = (BUCKLING, ROD, TUBE)
NOT_CHECKED = (
    "fatigue, thread, eyes, welds and seals of {}, friction of its eyes, and what its own mass "
    "adds to the loads of the linkage",
    "play of the guides of {}: state guide and play",
    "buckling and stress of {} in {}: measured loads tell no force of a cylinder",
)
_ROUND_OFF = 1e-6  # of the stroke
_CLOSE = 1e-9  # of a yield stress: a root that was sought
_NEVER = 1e12  # a factor on loads that do nothing
_BETWEEN = np.array([0.25, 0.5, 0.75])  # of the steps beside the worst position


def cylinder_checks(design: Design, runs: Runs, *, doubted: bool = False) -> list[Check]:
    """The checks of all cylinders over the computed cycles, with their derivations.

    doubted  True for runs at an end of a doubt, in which a stop may lie beyond the stroke

    Raises DesignError where a cylinder is drawn out beyond its stroke or pushed in beyond it.
    """
    found: list[Check] = []
    if not any(isinstance(run, loads.CycleLoads) for run in runs.values()):
        return found  # what was measured says nothing of it
    for name, cylinder in design.cylinders.items():
        loaded = _Loaded.of(design, name, cylinder, runs)
        if not doubted:
            _check_stroke(loaded)
        found += _checks_of(loaded)
    return found


def not_checked_of(design: Design) -> tuple[str, ...]:
    """Effects that the checks of cylinders leave out."""
    names = list(design.cylinders)
    loose = [name for name in names if not design.cylinders[name].play]
    every, runs = " and ".join(names), " and ".join(design.measured)
    told = [NOT_CHECKED[0].format(every)] if names else []
    told += [NOT_CHECKED[1].format(" and ".join(loose))] if loose else []
    return (*told, *([NOT_CHECKED[2].format(every, runs)] if names and runs else ()))


@dataclass(frozen=True, eq=False)
class _Loaded:
    """A cylinder at the n positions of all cycles.

    push     (n,) N, of its eyes on each other; negative where it pulls
    length   (n,) mm between its eyes
    across   (n,) mm/s2, gravity across its axis times the load factor
    cases    cycle, position in words, and index in its cycle, of each position
    stretch  (n,) between two jumps of the loads; path: (n,) along which the positions lie
    """

    design: Design
    name: str
    cylinder: Cylinder
    push: FloatArray
    length: FloatArray
    across: FloatArray
    cases: Sequence[tuple[str, str, int]]
    stretch: IntArray
    path: FloatArray

    @staticmethod
    def of(design: Design, name: str, cylinder: Cylinder, runs: Runs) -> "_Loaded":
        pushes, reaches, cases, stretches, paths = [], [], [], [], []
        gone = 0
        for run, cycle in runs.items():
            if not isinstance(cycle, loads.CycleLoads):
                continue
            ends = cycle.linkage.force(cylinder.force).coordinate
            assert isinstance(ends, loads.Distance)
            reach = cycle.point(ends.body_b, ends.point_b) - cycle.point(ends.body_a, ends.point_a)
            cases += [(run, told, k) for k, told in enumerate(labels_of(design, run, cycle))]
            pushes.append(-design.load_factor * cycle.efforts[cylinder.force])
            reaches.append(reach)
            stretches.append(gone + stretches_of(cycle))
            gone = int(stretches[-1][-1]) + 1
            paths.append(cycle.positions)
        reach = np.concatenate(reaches)
        length = np.hypot(*reach.T)
        weight = design.load_factor * np.array(design.gravity)
        across = np.abs(reach[:, 0] * weight[1] - reach[:, 1] * weight[0]) / length
        return _Loaded(
            design, name, cylinder, np.concatenate(pushes), length, across, cases,
            np.concatenate(stretches), np.concatenate(paths),
        )  # fmt: skip


def _check_stroke(loaded: _Loaded) -> None:
    cylinder, length = loaded.cylinder, loaded.length
    low, high = cylinder.closed, cylinder.closed + cylinder.stroke
    slack = _ROUND_OFF * cylinder.stroke
    first, last = float(length.min()), float(length.max())
    if first >= low - slack and last <= high + slack:
        return
    raise DesignError(
        loaded.design.file,
        f"cylinders.{loaded.name}.{'closed' if first < low - slack else 'stroke'}",
        f"its eyes come from {first:.4g} to {last:.4g} mm apart in the cycles; closed and stroke "
        f"give it {low:.4g} to {high:.4g} mm",
    )


def _checks_of(loaded: _Loaded) -> Iterator[Check]:
    cylinder = loaded.cylinder
    lengths = (np.full(len(loaded.length), cylinder.tube), loaded.length - cylinder.tube)
    stiffness = (
        cylinder.tube_material.youngs_modulus * cylinder.second_moments[0],
        cylinder.material.youngs_modulus * cylinder.second_moments[1],
    )
    force = buckling_force(lengths, stiffness)
    buckling = _buckling(loaded, force)
    yield buckling
    if buckling.value >= 1.0:
        return  # bent without bound: there is no stress
    tube, rod = (one * loaded.across for one in cylinder.masses)
    apart = cylinder.guide + cylinder.closed + cylinder.stroke - loaded.length
    kink = cylinder.play / apart if cylinder.play else np.zeros(len(force))

    def moments(factor: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest moments (n,) in tube and rod under factors (n,) on all loads, N mm."""
        weights = (factor * tube, factor * rod)
        return largest_moments(factor * loaded.push, lengths, stiffness, weights, kink)

    with np.errstate(divide="ignore"):
        most = force / np.maximum(loaded.push, 0.0)
    yield _rod(loaded, lambda factor: moments(factor)[1], most)
    yield _tube(loaded, lambda factor: moments(factor)[0], most)


Moments = Callable[[FloatArray], FloatArray]


def _load_factor(stress: Moments, most: FloatArray, limit: float) -> FloatArray:
    """Factor (n,) on all loads with which a stress comes to its limit, at most `most` (n,).

    stress  under factors (n,) on all loads, rises at least as fast as these
    most    above 1
    """
    with np.errstate(divide="ignore"):
        straight = np.minimum(limit / stress(np.ones(len(most))), _NEVER)
    low, high = np.minimum(straight, 1.0), np.minimum(np.maximum(straight, 1.0), most)
    return bisected(lambda factor: stress(factor) <= limit, low, high)[0]


def _buckling(loaded: _Loaded, force: FloatArray) -> Check:
    cylinder = loaded.cylinder
    one, two = (f"{value:.4g}" for value in cylinder.second_moments)
    demand: list[Series | Item] = [
        Series("N", "push of the cylinder", np.maximum(loaded.push, 0.0), "N", main=True),
        Series("L", "between its eyes", loaded.length, "mm", main=True),
        Series("N_E", f"elastic buckling force of tube ({one} mm4 over {cylinder.tube:.4g} mm) and "
               f"rod ({two} mm4), hinged at both eyes", force, "N",
               "eigenvalue: docs/theory/cylinders.md", main=True),
        Step("share", "share of the buckling force", "N/N_E", main=True),
    ]  # fmt: skip
    limit = [Given("one", "the load itself", 1.0, "", "at 1 it buckles", main=True)]
    heading = Heading(
        BUCKLING,
        f"cylinder {loaded.name}",
        "linear eigenvalue of a column of two lengths; the rod within the tube stiffens nothing",
        of=loaded.name,
        unit="",
    )
    return _worst(loaded, heading, demand, limit, unproved="N_E is the least root of an equation "
                  "without a formula for it")  # fmt: skip


def _rod(loaded: _Loaded, moments: Moments, most: FloatArray) -> Check:
    """Of the rod: axial force and the largest moment."""
    cylinder = loaded.cylinder
    known: list[Series | Item] = [
        Series("N", "force of the cylinder", np.abs(loaded.push), "N", main=True),
        Given("d", "diameter of the rod", cylinder.rod, "mm", "design"),
        Step("A", "section of the rod", "pi*d^2/4", "mm2"),
        Step("W", "section modulus of the rod", "pi*d^3/32", "mm3"),
    ]  # fmt: skip
    stress = [Step("S_n", "largest stress of the rod under them", "n*N/A + M/W", "MPa", main=True)]
    heading = Heading(
        ROD, f"rod of cylinder {loaded.name}",
        "beam of second order, hinged at both eyes; value is the yield stress over the factor on "
        "all loads with which it yields, or buckles", of=loaded.name,
    )  # fmt: skip
    return _until_yield(loaded, heading, cylinder.material, known, moments, stress, most)


def _tube(loaded: _Loaded, moments: Moments, most: FloatArray) -> Check:
    """Of the tube: pressure, and the largest moment where that is more across the bore."""
    cylinder = loaded.cylinder
    area = np.where(loaded.push > 0.0, *cylinder.areas)
    known: list[Series | Item] = [
        Series("N", "force of the cylinder", np.abs(loaded.push), "N", main=True),
        Series("A_p", "area that the pressure acts on", area, "mm2"),
        Given("D", "bore", cylinder.bore, "mm", "design"),
        Given("D_o", "outer diameter of the tube", cylinder.outer, "mm", "design"),
        Step("W", "section modulus of the tube", "pi*(D_o^4 - D^4)/(32*D_o)", "mm3"),
        Given("p_a", "pressure that its drive has available, 0 if not stated", cylinder.pressure,
              "MPa", "design"),
        Step("p", "pressure that gives the force, or that a stop lets rise", "max(N/A_p, p_a)",
             "MPa", main=True),
        Step("sigma_h", "hoop stress at the bore, by Lame", "p*(D_o^2 + D^2)/(D_o^2 - D^2)", "MPa"),
    ]  # fmt: skip
    stress = [
        Step("S_n", "largest difference of principal stresses under them",
             "n*sigma_h + max(n*p, M/W)", "MPa", main=True),
    ]  # fmt: skip
    below = [Step("b_lo", "von Mises' stress is at most this much less", "(1 - sqrt(3)/2)*sigma",
                  "MPa")]  # fmt: skip
    heading = Heading(
        TUBE, f"tube of cylinder {loaded.name}",
        "Lame's thick tube, Tresca: holds for ends that carry the pressure's axial force, and "
        "for ends that do not; value is the yield stress over the factor on all loads with which "
        "it yields, or buckles", of=loaded.name,
    )  # fmt: skip
    return _until_yield(
        loaded, heading, cylinder.tube_material, known, moments, stress, most, Band(below=below)
    )


def _until_yield(
    loaded: _Loaded,
    heading: Heading,
    material: Material,
    known: Sequence[Series | Item],
    moments: Moments,
    stress: Sequence[Step],
    most: FloatArray,
    band: Band = NO_BAND,
) -> Check:
    """Bending grows faster than the loads: the safety is the factor n on all of them at yield.

    known    items that the factor does not change
    moments  N mm (n,), largest under factors (n,) on all loads
    stress   S_n under n times the loads, of `known`, n and their moment M
    most     factors (n,) with which it buckles
    """

    def under(factor: FloatArray) -> list[Series | Item]:
        """Items up to the largest stress under factors (n,) on all loads."""
        return [
            Given("R_e", f"yield stress of {material.name}", material.yield_stress, "MPa",
                  material.source, main=True),
            *known,
            Series("n", "factor on all loads, sought until it yields or buckles", factor, "",
                   "docs/theory/cylinders.md", main=True),
            Series("M", "largest moment under n times the loads: weight, play and deflection",
                   moments(factor), "N mm", "docs/theory/cylinders.md", main=True),
            *stress,
        ]  # fmt: skip

    factor = _load_factor(lambda n: demand_over(under(n)), most, material.yield_stress)
    demand = [
        *under(factor),
        Step("sigma", "the yield stress over the factor", "R_e/n", "MPa", main=True),
    ]
    return _worst(loaded, heading, demand, [], band, equal=("S_n", "R_e"))


def _worst(
    loaded: _Loaded,
    heading: Heading,
    demand: Sequence[Series | Item],
    limit: Sequence[Item],
    band: Band = NO_BAND,
    unproved: str = "",
    equal: tuple[str, str] | None = None,
) -> Check:
    """The check of a demand against a limit at the position where it is largest.

    limit  items of the limit; empty where the first item of the demand is it
    equal  symbols that agree there, unless it buckles before
    """
    values = demand_over(demand)
    (position,) = first_largest(values)
    cycle, place, index = loaded.cases[position]
    case = LoadCase("", cycle, place, index, ())
    derivation = derivation_at(case, position, demand, limit, band)
    derivation = replace(derivation, unproved=unproved)
    if equal:
        reached, sought = (derivation.number(symbol) for symbol in equal)
        if abs(reached - sought) <= _CLOSE * sought:
            derivation = replace(derivation, equal=(equal,))
    required = loaded.design.require
    check = derived_check("linkage", cycle, place, heading, derivation, required)
    return with_sampling(check, _rise(loaded, values, position))


def _rise(loaded: _Loaded, values: FloatArray, position: int) -> float:
    """How far a value rises beside a position, by a spline through its stretch."""
    own = np.flatnonzero(loaded.stretch == loaded.stretch[position])
    path = loaded.path[own] * np.sign(loaded.path[own[-1]] - loaded.path[own[0]])
    if len(own) < 3 or not (np.diff(path) > 0.0).all():
        return 0.0
    k = position - int(own[0])
    steps = [i for i in (k - 1, k) if 0 <= i < len(own) - 1]
    places = np.concatenate([path[i] + _BETWEEN * (path[i + 1] - path[i]) for i in steps])
    found = Spline.through(path, values[own]).at(places)
    return max(0.0, float(found.max()) - float(values[position]))
