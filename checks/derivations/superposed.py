"""The stress at a point of a part as the sum of its unit loads.

Of it, Findley's criterion on the critical plane of a path that is not proportional.

And the endurance limit by Marin's factors, as docs/theory/strength.md has it.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from checks.design.data import Part
from checks.models.formula_points import columns_of
from checks.part.derived import load_case, numbers
from checks.part.part_loads import PartLoads
from checks.result.derivation import Derivation, Given, Item, Section, Step, Superposition, UnitLoad
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.part_strength import endurance_of, equivalent_diameter, evenly_stressed
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import RungLevel, Stressed, UnitName
from fatigue import critical_plane, findley_criterion
from fatigue.marin import (
    LARGEST_SPECIMEN_LIMIT,
    LOADS,
    ROTATING_AREA,
    SURFACES,
    round_equivalent_diameter,
)
from fatigue.shear_planes import DUCTILE, CriticalPlane, resolved_shear, smallest_circles
from geometry.mesh import FloatArray

_SOURCE = "Findley 1959; Papadopoulos et al. 1997: docs/theory/multiaxial.md"

PATTERNS = (
    "cos n and sin n of a bore or journal: a pressure that goes round it as cos nθ or sin nθ; "
    "n = 1 carries the force, the others have no resultant, and together they are the half-cosine "
    "pressure of a pin (docs/theory/bearing.md). Unit loads that add nothing here are left out"
)
CONTACT = (
    "contact cos n and contact sin n are in the same way the long waves of the pressure of a pin "
    "whose fit is stated, as its contact was solved; a short wave is what of it no element "
    "follows, and makes stress at the bore only (docs/theory/contact.md)"
)

PRESSED = (
    "cos 0 of a bore that a bush is pressed into has the even pressure between them as well "
    "(docs/theory/press_fits.md)"
)
BOOK = "Shigley, 9th ed."


def units_of(level: Stressed) -> Sequence[UnitName]:
    """Name of each unit load of a level with where it acts, and the unit of its coefficient."""
    if isinstance(level, RungLevel):
        return level.model.units
    if isinstance(level, Level):
        own = [(unit.interface.name, unit.names) for unit in level.solutions.interfaces]
        return columns_of(own)
    raise TypeError(f"the unit loads of a {type(level).__name__} have no names")


def patterns_of(level: Stressed) -> str:
    """Meaning of the names of a level's unit loads."""
    told = [PATTERNS]
    if isinstance(level, Level) and level.contact is not None:
        told.append(CONTACT)
    if isinstance(level, Level) and level.lasting:
        told.append(PRESSED)
    return ". ".join(told)


def superposed(
    level: Stressed, loads: PartLoads, point: int, position: int, symbol: str
) -> Superposition:
    """The stress at a point of a level at one of all positions, unit load by unit load."""
    basis = level.history.basis[point]
    coefficients = level.coefficients[:, position]
    acts = np.flatnonzero((basis * coefficients).any(axis=0))
    names = units_of(level)
    return Superposition(
        symbol,
        f"stress at {level.place(point)}",
        f"{loads.cycle_names[position]}, {loads.labels[position]}",
        tuple(
            UnitLoad(
                names[k][0],
                names[k][1],
                float(coefficients[k]),
                tuple(float(one) for one in basis[:, k]),
            )
            for k in acts.tolist()
        ),
        _source(level),
    )


def _source(level: Stressed) -> str:
    if isinstance(level, Level):
        body = "half of the part" if level.half else "the part"
        return f"solved on a mesh of {body} with {level.unknowns} unknowns"
    return "handbook stress of the place per unit: docs/theory/rungs.md"


def findley(part: Part, loads: PartLoads, level: Stressed, use: FatigueUse) -> Derivation:
    """Of the amplitude of equal safety of the worst plane of the worst point."""
    point = use.worst(level).point
    run = level.judged_duty.runs[level.judged_duty.worst_run]
    stress = np.asarray(level.history.basis[point] @ level.coefficients[:, run])
    plane = level.judged_duty.worst.plane or critical_plane(stress, findley_criterion().k)
    across = _normals(stress, plane)
    carriers, most, least = _carriers(stress, plane), int(across.argmax()), int(across.argmin())
    places = list(dict.fromkeys([*carriers, most, least]))
    symbols = {place: f"s_{number}" for number, place in enumerate(places, 1)}
    named = {int(run[place]): symbol for place, symbol in symbols.items()}
    circle = [symbols[place] for place in carriers]
    return Derivation(
        cases=tuple(load_case(part, loads, k, symbol) for k, symbol in named.items()),
        sections=(
            Section(
                "Stress at the point, at the positions that carry the criterion",
                tuple(superposed(level, loads, point, k, symbol) for k, symbol in named.items()),
            ),
            Section(
                "On the critical plane",
                (
                    Given(
                        "n",
                        "normal of the plane with the largest parameter, found by a search that "
                        "proves its bound",
                        numbers(plane.normal),
                        "",
                        _SOURCE,
                    ),
                    *_shear(circle, stress[:, carriers], plane),
                    Step(
                        "sigma_n",
                        "largest normal stress of the cycle, or half its range; compression earns "
                        "nothing",
                        f"max(normal_stress({symbols[most]}, n), (normal_stress({symbols[most]}, "
                        f"n) - normal_stress({symbols[least]}, n))/2)",
                        "MPa",
                        _SOURCE,
                        main=True,
                    ),
                ),
            ),
            limit_section(part),
            Section("Demand", tuple(_demand(level, use, point))),
        ),
        value="sigma",
        limit="S_e",
        notes=(patterns_of(level),),
    )


def _demand(level: Stressed, use: FatigueUse, point: int) -> list[Item]:
    sine = "(2*t_r - 1)"
    return [
        *at_point(level, use, point),
        Given("t_r", "limit in reversed torsion over that in bending: 1/√3", DUCTILE, "",
              "von Mises"),
        Step("k", "weight of the normal stress", f"{sine}/sqrt(1 - {sine}^2)", "", _SOURCE),
        Step("f", "limit of the parameter", "S_p*t_r*sqrt(1 + k^2)", "MPa", _SOURCE),
        Step("u", "stress over strength by Findley", "(tau_a + k*sigma_n)/f", "", _SOURCE,
             main=True),
        Step("sigma", "amplitude of equal safety", "u*S_e", "MPa",
             main=True),
    ]  # fmt: skip


def _normals(stress: FloatArray, plane: CriticalPlane) -> FloatArray:
    """Normal stress (n,) on the plane over the path (6, n), MPa."""
    x, y, z = plane.normal
    return np.asarray(np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * z * x]) @ stress)


def _carriers(stress: FloatArray, plane: CriticalPlane) -> list[int]:
    """Positions of the path that carry the smallest circle round its shear stress: 2 or 3."""
    shear = resolved_shear(plane.normal[None], stress)
    return list(dict.fromkeys(int(k) for k in smallest_circles(shear)[2][0]))


def _shear(symbols: list[str], stress: FloatArray, plane: CriticalPlane) -> list[Item]:
    """The shear amplitude: half of a diameter, or the radius through three positions."""
    said = "shear amplitude: radius of the smallest circle round the path of the shear stress"

    def apart(one: str, other: str) -> str:
        return f"shear_stress({one} - {other}, n)"

    pairs = list(combinations(range(len(symbols)), 2))
    shear = resolved_shear(plane.normal[None], stress)[0]
    lengths = [float(np.linalg.norm(shear[:, one] - shear[:, other])) for one, other in pairs]
    longest = int(np.argmax(lengths))
    around = lengths[longest] ** 2 < sum(length**2 for length in lengths) - lengths[longest] ** 2
    if len(symbols) < 3 or not around:
        if len(symbols) < 2:
            formula = "0"
        else:
            one, other = (symbols[k] for k in pairs[longest])
            formula = f"{apart(one, other)}/2"
        return [Step("tau_a", said, formula, "MPa", _SOURCE, main=True)]
    sides = [
        Step(
            f"c_{number}",
            f"shear stress from {symbols[one]} to {symbols[other]}",
            apart(symbols[one], symbols[other]),
            "MPa",
        )
        for number, (one, other) in enumerate(pairs, 1)
    ]
    return [*sides, Step("tau_a", said, "circumradius(c_1, c_2, c_3)", "MPa", _SOURCE, main=True)]


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
