"""Report of a part besides its checks: gates, meshes, facts, assumptions.

Numbers by formula stand beside a solid's: of its section at mid-length, of the rung `formula`.
"""

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

import fatigue
from checks.design.data import Part
from checks.models import shapes
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, first_largest
from checks.part.pressed_along import SOFT_LUGS, Stack, why_even
from checks.result.derivation import HandComparison
from checks.result.verdict import Gate
from checks.result.words import CONTACT, number
from checks.stress.beyond_even import unevenness
from checks.stress.pins_in_bores import CLEARANCES, MIDDLE, Contact
from checks.stress.solid_mesh_level import Level
from fem.contact.condensed import ALLOWED as CONTACT_LIMIT
from fem.recovery import LARGEST_RATIO, MEANING, von_mises
from fem.solvers import BACKWARD_LIMIT, SolverError
from fem.stress_history import StressHistory
from fem.unit_loads import ACCELERATIONS
from fem.unit_solutions import has_bearings
from geometry.bars import Section
from geometry.mesh import FloatArray, Interface, MassProperties, Mesh

_LOAD_LIMIT, _RAW_LIMIT = 1e-6, 1e-3
_NO_COUPLE = 1e-6  # of the largest force times the part's size
_ROUND = ("bore", "journal")

# Largest displacement over size. Linear theory leaves out that a bent beam's ends draw together:
# its moments are too large by 0.6 (w/L)^2 for a cantilever and, as its half is one, by 2.4 (w/L)^2
# for a beam between two supports. At 0.03 that is 0.2 %, less than a peak repeats from mesh to mesh
# (docs/theory/fits.md).
SMALL_DISPLACEMENT = 0.03
_SMALL = 0.05  # share of the other nominal stress below which one is not worth a line
_TOLD = 0.3  # of the largest stress by formula: places that have less are not told
_OWN = "its own weight and inertia as those of an even bar"


def gates_of(loaded: LoadedPart, levels: Sequence[Level], properties: MassProperties) -> list[Gate]:
    """Measured numbers that must stay below their limits for the part's result to be valid.

    properties  of the part, with which the linkage was solved
    """
    part, loads = loaded.part, loaded.loads
    level = levels[-1]
    solutions = level.solutions
    slender = np.abs(solutions.moved(level.coefficients[:, level.peak.position])).max()
    size = float(np.ptp(solutions.mesh.nodes, axis=0).max())
    gates = []
    if not _stated_mass(loaded):
        driving = levels[0]  # the whole part
        gates.append(
            Gate(
                f"{part.name}: balance",
                driving.balance_residual(loads, properties),
                _LOAD_LIMIT,
                "resultant of the loads with the part's own inertia, over the largest pin force",
            )
        )
    return [
        *gates,
        Gate(
            f"{part.name}: loads on the mesh",
            level.load_residual(loads),
            _LOAD_LIMIT,
            "force and moment that reached each interface less those asked for, at every position, "
            "over the largest pin force",
        ),
        *(
            ()
            if level.contact is None
            else (
                Gate(
                    f"{part.name}{CONTACT}",
                    level.contact.residual,
                    CONTACT_LIMIT,
                    "gaps and pressures that do not exclude each other, or forces that the "
                    "pressure misses, at every position, scaled by the largest of each",
                ),
            )
        ),
        Gate(
            f"{part.name}: support reactions",
            level.reaction_residual(loads),
            _LOAD_LIMIT,
            "what the determinate support carries, over the largest pin force",
        ),
        Gate(
            f"{part.name}: raw unit loads",
            solutions.raw_deviation,
            _RAW_LIMIT,
            "resultants of the unit loads on the faceted surfaces before they were normalised",
        ),
        Gate(
            f"{part.name}: equation residual",
            solutions.residual,
            BACKWARD_LIMIT,
            f"backward error of the unit loads' solutions ({solutions.factor.solver})",
        ),
        Gate(
            f"{part.name}: small displacements",
            float(slender) / size,
            SMALL_DISPLACEMENT,
            "largest displacement over the part's size; linear theory makes bending moments too "
            "large by up to 2.4 times its square, 0.2 % at the limit",
        ),
        Gate(
            f"{part.name}: compressible material",
            part.material.poisson_ratio,
            LARGEST_RATIO,
            MEANING,
        ),
    ]


def mesh_row(level: Level) -> dict[str, float | int | str]:
    """One mesh of the part, as plain data."""
    mesh = level.solutions.mesh
    return {
        "fineness": level.fineness,
        "unknowns": level.unknowns,
        "elements": len(mesh.elements),
        "peak": level.peak.value,
        "amplitude of equal safety": level.fatigue.value if level.fatigue else 0.0,
        "smallest scaled det J": mesh.jacobian_minimum,
        "mesher": mesh.mesher,
        "solver": level.solutions.factor.solver,
    }


def facts_of(
    part: Part,
    loads: PartLoads,
    mass: MassProperties,
    size: float,
    limit: fatigue.EnduranceLimit | None,
) -> dict[str, float | str]:
    """Mass properties, strengths, largest forces and, where there are any, couples, by name.

    size   mm, of the part
    limit  by Marin's chain; None for a part of the other chain
    """
    facts: dict[str, float | str] = {
        "mass [kg]": mass.mass * 1e3,
        "centre of mass x [mm]": float(mass.centre[0]),
        "inertia about the centre [kg m2]": mass.inertia * 1e-3,
        "yield stress [MPa]": part.material.yield_stress,
        "ultimate stress [MPa]": part.material.ultimate_stress,
    }
    if limit is not None:
        facts["endurance limit [MPa]"] = limit.value
        facts["Marin factors"] = (
            f"surface {limit.surface:.3f}, size {limit.size:.3f}, load {limit.load:.3f}, "
            f"temperature {limit.temperature:.3f}, reliability {limit.reliability:.3f} on "
            f"{limit.uncorrected:.4g} MPa"
        )
    least = _NO_COUPLE * loads.largest_force * size
    for name, wrench in loads.wrenches.items():
        facts[f"largest force at {name} [N]"] = float(loads.resultant(name).max())
        couple = float(np.abs(wrench[:, 5]).max())
        if couple > least:
            facts[f"largest couple at {name} [N m]"] = couple * 1e-3
    return facts


def assumed_of(loaded: LoadedPart, level: Level) -> list[str]:
    """Assumptions of the model, in words."""
    said = []
    if level.contact is not None:
        said += _contact_words(level, level.contact, loaded.part)
    if has_bearings(level.solutions, level.solved_bores):
        said.append(
            f"{'other pins' if level.contact else 'pins'} press with a cosine pressure, even along "
            f"their length, on {degrees(loaded.part.bearing_arc):.0f} to 180 deg"
            + ("; both cheeks carry the same share" if _has_cheeks(level.solutions.mesh) else "")
        )
    if _has_couples(level):
        said.append(
            "a couple about a bore's axis enters as an even tangential traction; keys, splines and "
            "press fits that bring it in are not modelled"
        )
    stated = _stated_mass(loaded)
    if stated:
        added = np.abs(level.added).max(axis=0)
        said.append(
            f"the body's {stated} of the design file stand for the model's; a residual inertia "
            f"field up to ({added[0]:.3g}, {added[1]:.3g}) mm/s2 and {added[2]:.3g} rad/s2 "
            "balances the loads on the mesh"
        )
    if loaded.loads.own_swing:
        said.append(
            "where the linkage vibrates or is struck, the part has a rigid body's inertia: its "
            "bending by its own inertia is left out"
        )
    points, angles = level.edges
    if len(points):
        stress = von_mises(level.history.at(level.peak.position))[points]
        said.append(
            f"sharp re-entrant edges of up to {degrees(float(angles.max())):.0f} deg: no finite "
            f"stress there; {float(stress.max()):.3g} MPa on this mesh"
        )
    return said


def _contact_words(level: Level, contact: Contact, part: Part) -> list[str]:
    """Assumptions of the contact of pins, in words, with where the clearances are from."""
    by = f" ({part.fit_assumed})" if part.fit_assumed else ""
    along = unevenness(contact, level.peak.position)
    said = []
    for name, fit in contact.pins.fits.items():
        words = (
            f"{name}: {fit.material} with {fit.least:.4g} to {fit.largest:.4g} mm of clearance{by} "
            "presses where contact without friction says, even along its length; the value is that "
            "of the middle, the model band holds all of them"
        )
        if name in along:
            words += f"; the pin bends ({SOFT_LUGS}), which presses {along[name]} at the peak's "
            words += f"position, {_in_band(part, name, fit.stack)}"
        words += "; both cheeks carry the same share" if _cheeks(contact, name) else ""
        said.append(words)
    return said


def edges_words(loaded: LoadedPart, bent: Mapping[str, float]) -> list[str]:
    """Assumptions: edges that are stated to have run in, and what that takes away, in words.

    bent  kind of check -> MPa, with all bent pins
    """
    said = []
    for bore, edges in loaded.part.bore_edges.items():
        words = f"bore_edges.{bore} = {edges}, as stated: pressed evenly along the pin"
        stack = loaded.stack(bore)
        if stack is None or bore not in loaded.uneven:
            said.append(f"{words}; it takes nothing away: no bent pin is known to press there")
            continue
        by = ", ".join(
            f"{kind} would be up to {value:.4g} MPa"
            for kind, value in bent.items()
            if value and not (kind == "static" and stack.yields_even())
        )
        said.append(f"{words}; bent, {by}" if by else words)
    return said


def _in_band(part: Part, name: str, stack: Stack | None) -> str:
    """Which checks have what a bent pin presses in their band, and why others do not."""
    assert stack is not None
    fatigue, static = (why_even(part, name, stack, static=one) for one in (False, True))
    if fatigue:
        return f"in no band: {fatigue}"
    if static:
        return f"which the band of fatigue holds as well, of static not: {static}"
    return "which the band holds as well"


def _cheeks(contact: Contact, name: str) -> bool:
    mesh = contact.pins.solutions.mesh
    return _in_pieces(mesh, mesh.interfaces[name])


def contact_facts(level: Level) -> dict[str, float | str]:
    """Where pins whose fit is stated press at the position of the peak, by name."""
    contact = level.contact
    if contact is None:
        return {}
    peak = np.array([level.peak.position])
    found: dict[str, float | str] = {}
    for name, fit in contact.pins.fits.items():
        said = []
        shares = [MIDDLE] if fit.least == fit.largest else sorted(CLEARANCES)
        for share in shares:
            bore = contact.over(peak, share).bores[name]
            arc = degrees(bore.arcs[0])
            most = bore.pressures[:, 0].max()
            said.append(f"{fit.clearance(share):.4g} mm: {arc:.0f} deg, {most:.4g} MPa")
        found[f"contact in {name}, clearance: arc, largest pressure"] = "; ".join(said)
    return found


def _has_cheeks(mesh: Mesh) -> bool:
    """True if a bore or journal is in two pieces, one above the other."""
    return any(
        _in_pieces(mesh, interface)
        for interface in mesh.interfaces.values()
        if interface.kind in _ROUND
    )


def _in_pieces(mesh: Mesh, interface: Interface) -> bool:
    """True if an interface has nothing at some height; half of it ends at z = 0."""
    heights = mesh.nodes[mesh.surfaces[interface.name], 2]
    order = heights.min(axis=1).argsort()
    low, high = heights.min(axis=1)[order], np.maximum.accumulate(heights.max(axis=1)[order])
    gaps = np.r_[low[1:] - high[:-1], low[0] if mesh.half else 0.0]
    return bool(gaps.max() > 1e-6 * interface.length)


def _has_couples(level: Level) -> bool:
    """True if a couple about its axis acts on a bore or journal."""
    forces, couples = [0.0], [0.0]
    names = [name for unit in level.solutions.interfaces for name in unit.names]
    for name, acting in zip(names, np.abs(level.coefficients), strict=False):  # then inertia's
        if name == "couple":
            couples.append(float(acting.max()))
        elif not name.startswith("M_"):
            forces.append(float(acting.max()))
    size = float(np.ptp(level.solutions.mesh.nodes, axis=0).max())
    return max(couples) > _NO_COUPLE * max(forces) * size


def _stated_mass(loaded: LoadedPart) -> str:
    """Mass properties that the part's body states itself, in words."""
    stated = loaded.stated._asdict()
    return ", ".join(name for name, value in stated.items() if value is not None)


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
