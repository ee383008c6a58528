"""Report of a part besides its checks: gates, meshes, facts, assumptions."""

from collections.abc import Mapping, Sequence
from math import degrees

import numpy as np

import fatigue
from checks.design.data import Part
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import SOFT_LUGS, Stack, why_even
from checks.result.verdict import Gate
from checks.result.words import CONTACT
from checks.stress.beyond_even import unevenness
from checks.stress.pins_in_bores import CLEARANCES, MIDDLE, Contact
from checks.stress.solid_mesh_level import Level
from fem.contact.condensed import ALLOWED as CONTACT_LIMIT
from fem.recovery import LARGEST_RATIO, MEANING, von_mises
from fem.solvers import BACKWARD_LIMIT
from fem.unit_solutions import has_bearings
from geometry.mesh import Interface, MassProperties, Mesh

_LOAD_LIMIT, _RAW_LIMIT = 1e-6, 1e-3
_NO_COUPLE = 1e-9  # of the largest force times the part's size
_ROUND = ("bore", "journal")

# Largest displacement over size. Linear theory leaves out that a bent beam's ends draw together:
# its moments are too large by 0.6 (w/L)^2 for a cantilever and, as its half is one, by 2.4 (w/L)^2
# for a beam between two supports. At 0.03 that is 0.2 %, less than a peak repeats from mesh to mesh
# (docs/theory/fits.md).
SMALL_DISPLACEMENT = 0.03


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
