"""Write docs/hammer_leaf.md: the hammer's leaves by hand, and ballesta's solid beside it.

`--check` writes nothing and exits 1 if the page would change. The nominal stress at the pivot comes
from the loads of the rigid linkage; the solid's side stands in hammer_leaf_solid.py.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from documents_designs import Floats, crossed, design, run
from documents_hammer import FINE, MODULUS, TOUCH, R, law_stress
from written_page import write_or_check

import fatigue
from checks.design.data import Part
from geometry.parts import LeafPack

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "hammer_leaf.md"
NOTES = Path(__file__).parent / "hammer_leaf_notes.md"
SECOND = "## By the solid"
DESIGN = "spring_hammer"
LEAVES = 3

# The brief of the machine has 430 MPa for S275; ballesta's own S275 has the standard's least, 410.
STATED = {
    "youngs_modulus": "210 GPa",
    "poisson_ratio": "0.3",
    "density": "7850 kg/m3",
    "yield_stress": "275 MPa",
    "ultimate_stress": "430 MPa",
    "ductile": "true",
    "source": "stated with the machine",
}
MATERIALS = {
    "S275, 430 MPa": (
        *(f"materials.S275_430.{key}={value}" for key, value in STATED.items()),
        "parts.leaves.material=S275_430",
    ),
    "51CrV4": ("parts.leaves.material=51CrV4",),
}
OWN = "S275 of the design, 410 MPa"
SLOW = ("cycles.at_5.pace.speed=0.001 rad/s",)


@dataclass(frozen=True)
class Condition:
    """A speed of the pulley [rad/s] and the height of a rigid workpiece [mm], 0 for none."""

    speed: int
    work: int

    @property
    def cycle(self) -> str:
        """Its cycle in the design."""
        return f"at_{self.speed}" + (f"_work_{self.work}" if self.work else "")

    @property
    def words(self) -> str:
        """Its name on the page."""
        return f"{self.speed} rad/s, " + (f"{self.work} mm" if self.work else "no workpiece")


CONDITIONS = tuple(Condition(speed, work) for speed in (5, 10) for work in (0, 10, 20))


@dataclass(frozen=True)
class Leaf:
    """Bending stress of a leaf over a turn, MPa, on its upper face; on the lower with other sign.

    low, high  bent down by the ram is positive
    """

    low: float
    high: float

    @property
    def amplitude(self) -> float:
        """Half the range."""
        return (self.high - self.low) / 2

    @property
    def mean(self) -> float:
        """Of the face on which it is tension."""
        return abs(self.high + self.low) / 2

    def goodman(self, limit: float, ultimate: float) -> float:
        """Return the safety with both growing, 1/(s_a/S_e + s_m/S_u)."""
        return 1.0 / float(fatigue.goodman_utilisation(self.amplitude, self.mean, limit, ultimate))

    def langer(self, yielding: float) -> float:
        """Return the safety against yielding in the first cycle, S_y/(s_a + s_m)."""
        return yielding / (self.amplitude + self.mean)


def part(material: str) -> Part:
    """Return the design's leaves in a material of MATERIALS, or OWN."""
    return design(DESIGN, MATERIALS.get(material, ())).parts["leaves"]


def pack() -> LeafPack:
    """Return the shape of the design's leaves."""
    shape = part(OWN).geometry
    assert isinstance(shape, LeafPack)
    return shape


def leaf_limit(leaves: Part, surface: str | None = None, reliability: float | None = None) -> float:
    """Return the endurance limit of a leaf at its clamp, as the design states it or changed."""
    return marin_limit(leaves, surface, reliability).value / leaves.geometry.notch_factors["pivot"]


def marin_limit(
    leaves: Part, surface: str | None = None, reliability: float | None = None
) -> fatigue.EnduranceLimit:
    """Return Marin's limit of a leaf away from its clamp."""
    shape = leaves.geometry
    return fatigue.endurance_limit(
        leaves.material.ultimate_stress,
        leaves.surface if surface is None else surface,
        equivalent_diameter=fatigue.rectangle_equivalent_diameter(*shape.stressed_section),
        reliability=leaves.reliability if reliability is None else reliability,
    )


def nominal_history(cycle: str, overrides: tuple[str, ...] = ()) -> Floats:
    """Return the bending stress at R over a turn [MPa]: three leaves share the moment of the ram.

    Left of the pivot, bent down positive.
    """
    turn = run(DESIGN, cycle, overrides)
    arm = turn.point("ram", "D") - np.array(R)
    return crossed(arm, -turn.reactions["slot"].force) / (LEAVES * MODULUS)


def nominal(condition: Condition) -> Leaf:
    """Return the nominal stress at R."""
    found = nominal_history(condition.cycle)
    return Leaf(float(found.min()), float(found.max()))


def weight_stress() -> float:
    """Return the stress at R [MPa] by the ram's weight alone: the least of a turn without speed."""
    return float(nominal_history("at_5", SLOW).min())


# -- what other choices would make of it


def choices() -> Iterator[tuple[str, tuple[float, float, float, float]]]:
    """Yield Goodman's safety in S275 of 430 MPa under other choices, for four conditions."""
    leaves = part("S275, 430 MPa")
    ultimate = leaves.material.ultimate_stress
    shown = [nominal(Condition(*key)) for key in ((5, 0), (10, 0), (5, 20), (10, 20))]
    stated = leaf_limit(leaves)

    def safeties(limit: float, on_mean: float = 1.0) -> tuple[float, float, float, float]:
        a, b, c, d = (leaf.goodman(limit, ultimate / on_mean) for leaf in shown)
        return a, b, c, d

    yield "as stated", safeties(stated)
    yield "50 % survive", safeties(leaf_limit(leaves, reliability=0.5))
    yield "99.9 % survive", safeties(leaf_limit(leaves, reliability=0.999))
    yield "as forged", safeties(leaf_limit(leaves, surface="as_forged"))
    factor = leaves.geometry.notch_factors["pivot"]
    yield "fretting factor on the mean too", safeties(stated, factor)
    strict = leaf_limit(leaves, reliability=0.999)
    yield "99.9 % and the factor on the mean too", safeties(strict, factor)
    a, b, _, _ = safeties(stated)
    c, d = (_law(speed, 20).goodman(stated, ultimate) for speed in (5, 10))
    yield "force of the thesis' law (6.8) for the contact", (a, b, c, d)


def _law(speed: int, work: int) -> Leaf:
    """The stress with (6.8) on ballesta's motion, which acts from where the dies are `work` apart.

    It jumps there (H-E14 of docs/documents.md), so the ram hangs on the leaves up to that place.
    """
    turn = run(DESIGN, f"at_{speed}", FINE)
    hangs = turn.point("ram", "D")[:, 1] > TOUCH + work
    free = nominal_history(f"at_{speed}", FINE)[hangs]
    return Leaf(-law_stress(speed, work), float(free.max()))


# -- the page


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def hand_table() -> str:
    """Return the hand values: stress at R, Goodman and yield for both materials."""
    head = ["Condition", "Stress at R", "Range", "Amplitude", "Mean"]
    for name in MATERIALS:
        head += [f"{name}: Goodman", "yield"]
    rows = []
    for condition in CONDITIONS:
        leaf = nominal(condition)
        row = [condition.words, f"{leaf.low:.1f} … {leaf.high:.1f}"]
        row += [f"{value:.1f}" for value in (2 * leaf.amplitude, leaf.amplitude, leaf.mean)]
        for name in MATERIALS:
            leaves = part(name)
            material = leaves.material
            safety = leaf.goodman(leaf_limit(leaves), material.ultimate_stress)
            row += [f"{safety:.2f}", f"{leaf.langer(material.yield_stress):.2f}"]
        rows.append(row)
    return table(head, rows)


def limits_table() -> str:
    """Return the endurance limits of the leaf and their factors."""
    head = ["Material", "S_u", "S_y", "S_u/2", "surface", "size", "99 %", "1/1.3", "S_e"]
    rows = []
    for name in (*MATERIALS, OWN):
        leaves = part(name)
        limit = marin_limit(leaves)
        stated = leaves.material
        row = [name, f"{stated.ultimate_stress:g}", f"{stated.yield_stress:g}"]
        row += [f"{limit.uncorrected:g}"]
        factors = (limit.surface, limit.size, limit.reliability)
        fretting = 1 / leaves.geometry.notch_factors["pivot"]
        row += [f"{factor:.3f}" for factor in (*factors, fretting)]
        rows.append([*row, f"{leaf_limit(leaves):.1f}"])
    return table(head, rows)


def choices_table() -> str:
    """Return Goodman's safety under other choices."""
    head = ["", "5 rad/s", "10 rad/s", "5 rad/s, 20 mm", "10 rad/s, 20 mm"]
    rows = [[words, *(f"{value:.2f}" for value in values)] for words, values in choices()]
    return table(head, rows)


def hand_part() -> str:
    """Return the page's part by hand."""
    spring, worst = part("51CrV4"), nominal(Condition(10, 20))
    ultimate = spring.material.ultimate_stress
    first, _, _ = NOTES.read_text(encoding="utf-8").partition(SECOND)
    return first.format(
        spring=f"{worst.goodman(leaf_limit(spring), ultimate):.2f}",
        ground=f"{worst.goodman(leaf_limit(spring, 'ground'), ultimate):.1f}",
        weight=f"{weight_stress():.1f}",
        limits=limits_table(),
        table=hand_table(),
        choices=choices_table(),
    )


def page() -> str:
    """Return docs/hammer_leaf.md."""
    from hammer_leaf_solid import solid_part

    return hand_part() + solid_part()


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page, or say whether it is up to date."""
    return write_or_check(PAGE, page(), "tools/hammer_leaf.py", __doc__, arguments)


if __name__ == "__main__":
    sys.exit(main())
