"""The hammer's leaves as ballesta's solid, and the statics that explain its stress."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from documents_designs import Floats, design, run
from documents_hammer import MODULUS
from hammer_leaf import (
    CONDITIONS,
    DESIGN,
    LEAVES,
    MATERIALS,
    NOTES,
    OWN,
    SECOND,
    Condition,
    leaf_limit,
    nominal,
    pack,
    part,
    table,
)

import fatigue
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.result.verdict import Check
from checks.strength.part_strength import elastic_of, endurance_of
from checks.stress.solid_mesh_level import Level, Models, solve_level

MODELS = Models()
SECTION = LEAVES * MODULUS  # mm3
FINENESS = 0.7


@cache
def leaf_loads() -> PartLoads:
    """Return the loads on the leaves over all conditions, one behind the other."""
    cycles = {condition.cycle: run(DESIGN, condition.cycle) for condition in CONDITIONS}
    return loads_on(design(DESIGN), part(OWN), cycles)


@cache
def level(fineness: float = FINENESS) -> Level:
    """Return the leaves solved on one mesh over all conditions."""
    leaves = part(OWN)
    return solve_level(
        MODELS.solutions(leaves.geometry, fineness, elastic_of(leaves)),
        fineness,
        leaf_loads(),
        endurance_of(leaves).value,
        leaves.material.ultimate_stress,
        {condition.cycle: 1.0 for condition in CONDITIONS},
        leaves.geometry.notch_factors,
    )


# -- by statics


@dataclass(frozen=True, eq=False)
class Bending:
    """Bending stress of the leaves in a section left of R, MPa (n,), > 0: upper face in tension.

    ram      the ram's force on its lever arm to the section
    weight   of the leaves' own arm
    inertia  of the arm as it turns with the rocker
    closing  of the acceleration that closes the balance of the leaves with the rocker's loads
    clamp    of its force, spread evenly over its length
    """

    ram: Floats
    weight: Floats
    inertia: Floats
    closing: Floats
    clamp: Floats

    @property
    def total(self) -> Floats:
        """All of it."""
        return self.ram + self.weight + self.inertia + self.closing + self.clamp


def bending(section: float) -> Bending:
    """Return the bending stress at a distance of R [mm], at most half a clamp, over all conditions.

    The loads are those of the rocker, whose weight the thesis puts at R; the leaves have another
    mass and middle. They balance with accelerations ay and alpha from both sums,
    F_y = m (ay + x alpha) and M_R = m x ay + I_R alpha, as the solid has them.
    """
    shape, loads = pack(), leaf_loads()
    density = elastic_of(part(OWN)).density * LEAVES * shape.width * shape.thickness  # t/mm
    arm, right = shape.arm, shape.length + shape.overhang
    mass = density * (arm + right)
    first = density * (right**2 - arm**2) / 2
    second = density * (arm**3 + right**3) / 3
    contact, rod, pivot = (loads.wrenches[name] for name in ("contact", "rod", "pivot"))
    force = (contact + rod + pivot)[:, 1]
    moment = contact[:, 5] + rod[:, 5] + pivot[:, 5] + rod[:, 1] * shape.length
    balance = np.array([[mass, first], [first, second]])
    ay, alpha = np.linalg.solve(balance, np.stack([force, moment]))
    gravity, turning = loads.accelerations[:, 1], loads.accelerations[:, 2]  # R stands still
    lever = (arm - section) ** 2 / 2
    # of r (r - section) from the section to the end
    growing = (arm**3 - section**3) / 3 - section * (arm**2 - section**2) / 2
    half = shape.clamp_length / 2
    return Bending(
        ram=-contact[:, 1] * (-loads.reaches["contact"] - section) / SECTION,
        weight=density * gravity * lever / SECTION,
        inertia=-density * turning * growing / SECTION,
        closing=density * ((ay - gravity) * lever - (alpha - turning) * growing) / SECTION,
        clamp=-pivot[:, 1] * (half - section) ** 2 / (4 * half) / SECTION,
    )


def solid_bending(section: float, at: Level) -> Floats:
    """Return the stress along the leaf (n,) of the solid's upper face, mean across its width."""
    shape = pack()
    x, y, z = at.history.points.T
    near = np.abs(x + section) < (0.01 if section else shape.thickness / 3)
    top = np.abs(y - LEAVES * shape.thickness / 2) < 1e-6
    chosen = near & top & (np.abs(z) < 0.45 * shape.width)
    if chosen.sum() < 3:
        raise SystemExit(f"the mesh has {chosen.sum()} points at {section:g} mm")
    found: Floats = at.history.basis[chosen, 0].mean(axis=0) @ at.coefficients
    return found


def over(condition: Condition) -> slice:
    """Return the positions of a condition in the loads."""
    return leaf_loads().cycles[condition.cycle]


def statics_rows(section: float) -> Iterator[tuple[Condition, list[float]]]:
    """Yield what makes the largest and smallest stress of a section, MPa, and what the solid has.

    Ram, weight, inertia, closing, clamp, all of it, solid: first where it is lowest, then highest.
    """
    parts, solid = bending(section), solid_bending(section, level())
    for condition in CONDITIONS:
        turn = over(condition)
        row = []
        for k in (parts.total[turn].argmin(), parts.total[turn].argmax()):
            at = turn.start + int(k)
            shares = (parts.ram, parts.weight, parts.inertia, parts.closing, parts.clamp)
            row += [float(share[at]) for share in shares]
            row += [float(parts.total[at]), float(solid[at])]
        yield condition, row


# -- by the check


def check(condition: Condition, material: str) -> dict[str, Check]:
    """Return ballesta's stress checks of sliding leaves, by kind, for one condition as the duty."""
    changes = (*MATERIALS.get(material, ()), f"duty.cycles={{{condition.cycle}=1e7}}")
    stated = design(DESIGN, changes)
    leaves = stated.parts["leaves"]
    cycles = {condition.cycle: run(DESIGN, condition.cycle)}
    loads = loads_on(stated, leaves, cycles)
    result = check_solid(LoadedPart(stated, leaves, loads), MODELS)
    return {found.kind: found for found in result.checks if found.kind in ("static", "fatigue")}


def edge_safety(condition: Condition, material: str) -> float:
    """Return the solid's Goodman safety if fretting acts at the edges of the clamp alone."""
    at, leaves = level(), part(material)
    half = pack().clamp_length / 2
    x = at.history.points[:, 0]
    faces = np.isin(at.history.nodes, at.solutions.mesh.surfaces["pivot"])
    edges = faces & (np.abs(np.abs(x) - half) < 0.01)
    limit = leaf_limit(leaves)
    limits = np.full(len(x), endurance_of(leaves).value)
    limits[edges] = limit
    turn = np.ascontiguousarray(at.coefficients[:, over(condition)])
    found = fatigue.goodman(at.history.basis, turn, limits, leaves.material.ultimate_stress)
    return 1.0 / float(found.utilisation.max())


# -- the page


def _tenth(value: float) -> str:
    """A stress without a negative zero."""
    return f"{round(value, 1) + 0.0:.1f}"


def statics_table(section: float) -> str:
    """Return what makes the stress of a section, and the solid's."""
    head = ["Condition", "Ram", "Weight", "Inertia", "Closing", "Clamp", "Sum", "Solid", "Apart"]
    rows = []
    for condition, row in statics_rows(section):
        low, high = row[:7], row[7:]
        cells = [f"{_tenth(a)} … {_tenth(b)}" for a, b in zip(low, high, strict=True)]
        apart = max(abs(low[6] - low[5]), abs(high[6] - high[5]))
        rows.append([condition.words, *cells, f"{apart:.1f}"])
    return table(head, rows)


def verdict_row(condition: Condition, material: str) -> list[float]:
    """Return Goodman's safeties: nominal, solid, if fretting acts at the edge only; yield safeties.

    And the solid's numerical error in %.
    """
    leaves, leaf = part(material), nominal(condition)
    ultimate, yielding = leaves.material.ultimate_stress, leaves.material.yield_stress
    found = check(condition, material)
    bar = found["fatigue"]
    return [
        leaf.goodman(leaf_limit(leaves), ultimate),
        bar.safety,
        edge_safety(condition, material),
        100 * bar.numerical / bar.value,
        leaf.langer(yielding),
        found["static"].safety,
    ]


def verdict_table(material: str, conditions: Sequence[Condition] = CONDITIONS) -> str:
    """Return the nominal safeties and the solid's for conditions in one material."""
    head = ["Condition", "Nominal", "Solid", "Fretting at the edges only"]
    head += ["Numerical error", "Yield, nominal", "Yield, solid"]
    rows = []
    for condition in conditions:
        row = verdict_row(condition, material)
        cells = [f"{value:.2f}" for value in row]
        cells[3] = f"{row[3]:.1f} %"
        rows.append([condition.words, *cells])
    return table(head, rows)


def solid_part() -> str:
    """Return the page's part on the solid."""
    shape = pack()
    turn, parts = over(Condition(10, 0)), bending(0.0)
    at = turn.start + int(parts.total[turn].argmax())
    line = elastic_of(part(OWN)).density * LEAVES * shape.width * shape.thickness
    mine = [f"{name}:\n\n{verdict_table(name)}\n" for name in MATERIALS]
    mine.append(f"{OWN}:\n\n{verdict_table(OWN, CONDITIONS[:3:2])}")
    _, title, second = NOTES.read_text(encoding="utf-8").partition(SECOND)
    return title + second.format(
        pivot=statics_table(0.0),
        edge=statics_table(shape.clamp_length / 2),
        verdicts="\n".join(mine),
        unknowns=level().unknowns,
        level=f"{line * 9800.0 * shape.arm**2 / 2 / SECTION:.2f}",
        turning=f"{100 * parts.inertia[at] / parts.ram[at]:.1f}",
        both=f"{100 * (parts.inertia[at] + parts.weight[at]) / parts.ram[at]:.1f}",
    )
