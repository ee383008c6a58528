"""The endurance limit by Marin's factors, as docs/theory/strength.md has it."""

from checks.design.data import Part
from checks.result.derivation import Given, Item, Section, Step
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.part_strength import endurance_of, equivalent_diameter, evenly_stressed
from checks.stress.stress_result import Stressed
from fatigue.marin import (
    LARGEST_SPECIMEN_LIMIT,
    LOADS,
    ROTATING_AREA,
    SURFACES,
    round_equivalent_diameter,
)

BOOK = "Shigley, 9th ed."


def limit_section(part: Part) -> Section:
    """S_e of a part away from notches, from the ultimate strength S_u."""
    return Section("Limit: endurance limit by Marin's factors", tuple(_items(part)))


def at_point(level: Stressed, use: FatigueUse, point: int) -> list[Item]:
    """The endurance limit S_p at a point, where fretting may lower it."""
    factor = use.limit / float(level.limits[point])
    return [
        Given("K_f", "fretting or fatigue notch factor there", factor, "", "the part's shape"),
        Step("S_p", "endurance limit at the point", "S_e/K_f", "MPa"),
    ]


def _ultimate(part: Part) -> Given:
    material = part.material
    said = f"ultimate strength of {material.name}"
    return Given("S_u", said, material.ultimate_stress, "MPa", material.source)


def _items(part: Part) -> list[Item]:
    load = "axial" if evenly_stressed(part) else "bending"
    limit = endurance_of(part)
    return [
        _ultimate(part),
        *_specimen(part),
        _surface(part),
        *_size(part),
        Given("k_c", f"load: {load}", LOADS[load], "", f"{BOOK}, eq. 6-26"),
        Given("k_d", "temperature: 20 °C", limit.temperature, "", f"{BOOK}, eq. 6-27"),
        Given("R", "share of parts that survive", part.reliability, "", "the design, reliability"),
        Step("k_e", "reliability", "1 - 0.08*quantile(R)", "", f"{BOOK}, eq. 6-29"),
        Step(
            "S_e",
            "endurance limit of the part, fully reversed",
            "k_a*k_b*k_c*k_d*k_e*S_e0",
            "MPa",
            f"Marin: {BOOK}, eq. 6-18",
            main=True,
        ),
    ]


def _specimen(part: Part) -> list[Item]:
    said, ratio = "of a polished rotating-beam specimen", part.material.endurance_ratio
    if ratio is None:
        formula = f"min(0.5*S_u, {LARGEST_SPECIMEN_LIMIT:g})"
        return [Step("S_e0", f"endurance limit {said}", formula, "MPa", f"{BOOK}, eq. 6-8")]
    return [
        Given("q", f"endurance limit {said} over the ultimate strength", ratio, "",
              "the material, endurance_ratio"),
        Step("S_e0", f"endurance limit {said}", "q*S_u", "MPa"),
    ]  # fmt: skip


def _surface(part: Part) -> Step:
    """The power law of table 6-2, but no more than any smoother finish has, nor than 1."""
    smoother = list(SURFACES)[: list(SURFACES).index(part.surface) + 1]
    laws = ", ".join(
        f"{SURFACES[name][0]:g}*S_u^{SURFACES[name][1]:g}"
        for name in dict.fromkeys(reversed(smoother))
    )
    said = f"surface: {part.surface}; not above a smoother finish's"
    return Step("k_a", said, f"min(1, {laws})", "", f"{BOOK}, eq. 6-19, table 6-2")


def _size(part: Part) -> list[Item]:
    if evenly_stressed(part):
        return [Given("k_b", "size: none in axial force", 1.0, "", f"{BOOK}, eq. 6-21")]
    section = part.geometry.stressed_section
    found: list[Item] = []
    if len(section) == 1:
        found.append(Given("D", "diameter that is bent", section[0], "mm", "the part's shape"))
        formula, equation = "0.370*D", "6-24"
        if equivalent_diameter(part) > round_equivalent_diameter(*section):
            said = "area with 95 % of the largest amplitude, over D^2"
            found.append(Given("A_95", said, part.bent_area, "", "the pin's forces over the cycle"))
            formula, equation = f"sqrt(A_95/{ROTATING_AREA:g})*D", "6-22"
    else:
        found += [
            Given("B", "width that is bent", section[0], "mm", "the part's shape"),
            Given("H", "height that is bent", section[1], "mm", "the part's shape"),
        ]
        formula, equation = "0.808*sqrt(B*H)", "6-25"
    law = "1.51*d_e^-0.157" if equivalent_diameter(part) > 51.0 else "min(1, (d_e/7.62)^-0.107)"
    turning = "not turning" if equation in ("6-24", "6-25") else "its load goes round it"
    return [
        *found,
        Step("d_e", f"equivalent diameter, {turning}", formula, "mm", f"{BOOK}, eq. {equation}"),
        Step("k_b", "size", law, "", f"{BOOK}, eq. 6-20"),
    ]
