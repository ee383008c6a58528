"""Numbers by formula beside a solid's: of its section at mid-length, of the rung `formula`."""

import numpy as np

from checks.design.data import Part
from checks.models import shapes
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import HandComparison
from checks.result.words import number
from checks.stress.solid_mesh_level import Level
from fem.recovery import StressHistory, von_mises
from fem.solvers import SolverError
from fem.unit_loads import ACCELERATIONS
from geometry.bars import Section
from geometry.mesh import FloatArray

_SMALL = 0.05  # share of the other nominal stress below which one is not worth a line
_TOLD = 0.3  # of the largest stress by formula: places that have less are not told
_OWN = "its own weight and inertia as those of an even bar"


def hand_checks(part: Part, loads: PartLoads, level: Level) -> list[HandComparison]:
    """Return what formulas say beside a solid: of columns at mid-length, of all at named places."""
    middle = part.geometry.length / 2
    sections = [one for one in part.geometry.sections if _holds(one, middle)]
    by_section = _at_mid_length(part, sections[0], loads, level) if sections else []
    return by_section + _at_named_places(part, loads, level)


def _holds(section: Section, place: float) -> bool:
    return section.stretch is None or section.stretch[0] <= place <= section.stretch[1]


def _at_mid_length(
    part: Part, section: Section, loads: PartLoads, level: Level
) -> list[HandComparison]:
    """Axial and bending stress, each at the position where it is largest."""
    first, second = (loads.wrenches[name] for name in part.geometry.interfaces[:2])
    length, height = part.geometry.length, section.depth_in_plane
    middle, modulus = length / 2, section.inertia_in_plane / (height / 2)
    left = _own(level, section.area, 0.0, middle, middle)
    right = _own(level, section.area, middle, length, middle)
    axial = (second[:, 0] + right[0] - first[:, 0] - left[0]) / 2
    moment = (second[:, 5] + middle * second[:, 1] + right[1]) / 2
    moment -= (first[:, 5] - middle * first[:, 1] + left[1]) / 2
    by_axial, by_moment = np.abs(axial) / section.area, np.abs(moment) / modulus
    checks = []
    if by_axial.max() > _SMALL * by_moment.max():
        (worst,) = first_largest(by_axial)
        mean, _ = _beam_stress(level, worst, middle, height / 4)
        said = f"F/A = {axial[worst]:.0f} N / {section.area:.1f} mm2, {_OWN}"
        value = float(axial[worst] / section.area)
        checks.append(HandComparison("axial stress at mid-length", value, mean, "MPa", said))
    if by_moment.max() > _SMALL * by_axial.max():
        (worst,) = first_largest(by_moment)
        _, slope = _beam_stress(level, worst, middle, height / 4)
        said = f"M h/(2 I), M = {abs(moment[worst]) / 1e3:.3g} N m, {_OWN}"
        value, bent = float(by_moment[worst]), abs(slope) * height / 2
        checks.append(HandComparison("bending stress at mid-length", value, bent, "MPa", said))
    return checks


def _own(
    level: Level, area: float, start: float, stop: float, about: float
) -> tuple[FloatArray, FloatArray]:
    """Force along x (n,) and moment about a place (n,) of a bar's own weight and inertia.

    An even bar along x from `start` to `stop`, d'Alembert: -rho A (a_x - omega^2 x) along x and
    -rho A (a_y + alpha x) across, with all that the model's inertia balances.
    """
    a_x, a_y, alpha, omega2 = level.coefficients[-len(ACCELERATIONS) :]
    even = -level.solutions.material.density * area
    first = (stop**2 - start**2) / 2
    along = even * (a_x * (stop - start) - omega2 * first)
    lever = first - about * (stop - start)
    second = (stop**3 - start**3) / 3 - about * first
    return along, even * (a_y * lever + alpha * second)


def _beam_stress(level: Level, position: int, place: float, window: float) -> tuple[float, float]:
    """Axial stress, MPa, and its slope across the plane, MPa/mm, on the surface near x = place.

    Least squares of a + b y + c z + d x + e x y over the surface points within the window. Half of
    a part stands for both: the stress is even in z.
    """
    points = level.history.points
    near = np.abs(points[:, 0] - place) < window
    x, y, z = (points[near] - np.array([place, 0.0, 0.0])).T
    terms = np.stack([np.ones_like(x), y, x, x * y, *([] if level.half else [z])], axis=1)
    found = np.linalg.lstsq(terms, level.history.at(position)[near, 0], rcond=None)[0]
    return float(found[0]), float(found[1])


def _at_named_places(part: Part, loads: PartLoads, level: Level) -> list[HandComparison]:
    """Von Mises stress where the rung `formula` has most of it at each of its named places.

    A formula places a peak at a nominal section; the solid's is the largest at the same position on
    the surface within a quarter of the part's height. A place that has none there is left out, and
    so are all of a part that has no formula.
    """
    try:
        model = shapes.model_of(part, loads)
    except SolverError:  # the ladder tells why
        return []
    if model is None or loads.is_nothing:
        return []
    history, checks = model.history, []
    peaks, names = history.peaks_by_point(), np.array(model.places)
    reach = part.geometry.stressed_section[0] / 4
    for name in dict.fromkeys(model.places):
        own = np.flatnonzero(names == name)
        point = own[[int(peaks[own].argmax())]]
        place = history.points[point[0]]
        away = np.linalg.norm(level.history.points - _mirrored(place, level), axis=1)
        if peaks[point[0]] < _TOLD * peaks.max() or away.min() > reach:
            continue
        one = StressHistory(point, place[None], history.basis[point], history.coefficients)
        (position,) = first_largest(one.peaks_by_position()[0])
        where = ", ".join(number(float(x) + 0.0) for x in np.round(place, 3))
        checks.append(
            HandComparison(
                f"peak von Mises stress by formula: {name}",
                float(peaks[point[0]]),
                float(von_mises(level.history.at(position))[away <= reach].max()),
                "MPa",
                f"rung formula at ({where}) mm, {loads.labels[position]}; the model's largest "
                f"within {number(reach)} mm",
            )
        )
    return checks


def _mirrored(place: FloatArray, level: Level) -> FloatArray:
    return np.array([*place[:2], abs(place[2])]) if level.half else place
