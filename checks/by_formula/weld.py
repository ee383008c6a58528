"""Welds across a part by nominal stress: fatigue at the toe and at the root, and the throat.

Section forces at the weld give normal stress at the outline and shear where it is largest, in the
part's walls (toe) and in the throat, laid round the outline (root). EN 1993-1-9:2005 judges their
ranges over the duty; EN 1993-1-8, 4.5.3.3, the throat's largest force per length
(docs/theory/welds.md).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import exp, expm1, sqrt

import numpy as np

from checks.design.data import Weld
from checks.handbook.bar_forces import balanced_bar
from checks.handbook.weld_details import ROOT, ROOT_CATEGORY, SHEAR_CATEGORY, STANDARD
from checks.part.derived import Band, Heading, Kind, Series, load_case
from checks.part.loaded_part import LoadedPart
from checks.part.plate_loads import FlatSection, PlateLoads
from checks.result.derivation import Derivation, Given, Item, Section, Step, value_of
from checks.result.formulas import Value, evaluate_each
from checks.result.verdict import Check
from checks.strength.ranges_over_duty import (
    CURVE,
    MINER,
    MINER_SOURCE,
    REACHED,
    damage_items,
    miner_left,
    miner_sum,
    over_duty,
    positions_of,
    reached,
)
from fatigue.life import (
    AT_CUT_OFF,
    AT_KNEE,
    REFERENCE,
    SHEAR_CUT_OFF,
    Cycles,
    duty_cycles,
    endless_weld_safety,
    weld_safety,
)
from geometry.bars import rectangle_torsion
from geometry.mesh import FloatArray
from geometry.parts.plate import Plate

_PAGE = "[welds](../theory/welds.md)"
FATIGUE = Kind(
    name="weld",
    quantity="fatigue of the {}",
    demand="category over the safety that ranges of nominal stress in walls or throat leave",
    limit="category, EN 1993-1-9; the safety is at least `partial_factor`",
    require="fatigue",
    source=_PAGE,
)
THROAT = Kind(
    name="weld",
    quantity="throat at {}",
    demand="largest force on the throat per length of weld",
    limit="shear strength of the throat, EN 1993-1-8, 4.5.3.3",
    require="static",
    source=_PAGE,
)
KINDS = (FATIGUE, THROAT)
OVER_CYCLES = True  # ranges, which no position shows by itself

_THEORY = "docs/theory/welds.md"
_ROUND = 16  # points round a round outline
_DIGITS = 15  # of sines: that of pi is 0
_CELLS = 256  # of the part's mass along it
_INSIDE = 1e-9  # of the length: a weld at an end stands beside the force there
_BETA, _GAMMA = 1.0, 1.25  # EN 1993-1-8: largest correlation factor of table 4.1, and gamma_M2
_STRONGEST = 540.0  # MPa, tensile strength of S460, the strongest steel of that table
_YIELDS = 1.5  # EN 1993-1-9, (8.1): largest range over the yield stress
_NOMINAL = Band(words="a formula has no mesh; strengths of welds are of nominal stress")
_Proof = tuple[list[Item], tuple[tuple[str, str], ...]]  # items, and pairs that agree then
_STRESS = "N/A - M_z*y/I_z + M_y*z/I_y"
_SHEAR = "V*q_V + T*q_T"
_FORCES = {
    "N": ("axial force", "N"),
    "V": ("shear force", "N"),
    "T": ("torque", "N mm"),
    "M_y": ("moment out of the plane", "N mm"),
    "M_z": ("moment in the plane", "N mm"),
    "B": ("bimoment", "N mm2"),
}


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Toe, root and throat of every weld that the part states."""
    for weld in loaded.part.welds:
        forces = _forces(loaded, weld)
        if not any(force.any() for force in forces.values()):
            continue
        if any(name in loaded.loads.cycles for name in loaded.duty.cycles):
            places = [("toe", weld.category, weld.where, _walls(weld))]
            if weld.throat is not None:
                root = f"{STANDARD}, {ROOT}: 36* and 80"
                places.append(("root", ROOT_CATEGORY, root, _throat(weld)))
            for name, category, where, section in places:
                found = _Ranges(loaded, weld, name, category, where, section, forces).check()
                if found is not None:
                    yield found
        if weld.throat is not None:
            yield _static(loaded, weld, forces)


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Subjects that nominal stress does not know."""
    if loaded.part.welds:
        yield (
            "welds by nominal stress: quality and inspection as the table of the detail asks, no "
            "misalignment, no bending of the walls across themselves or of what they are welded "
            "to, which is as strong as the part"
        )


def _forces(loaded: LoadedPart, weld: Weld) -> dict[str, FloatArray]:
    """Section forces (n,) at a weld, N and N mm, of the part's loads and its own inertia."""
    shape, loads = loaded.part.geometry, loaded.loads
    if isinstance(shape, Plate):
        return _plate_forces(loaded, shape, weld)
    bar = shape.profile
    assert bar is not None, "a shape with walls tells its profile"
    cuts = np.linspace(bar.cuts[0], bar.cuts[-1], _CELLS + 1)
    middles = (cuts[1:] + cuts[:-1]) / 2
    area = np.broadcast_to(bar.at(middles[:, None]).area, (_CELLS, 1))[:, 0]
    mass = loaded.part.material.density * area * np.diff(cuts)
    places = {one.name: float(one.centre[0]) for one in shape.placed_interfaces}
    points = [(places[name], wrench) for name, wrench in loads.wrenches.items()]
    balanced = balanced_bar(points, middles, mass, loads.accelerations)
    low, high = weld.walls.stretch
    slack = _INSIDE * (high - low)
    found = balanced.at(np.array([min(max(weld.at, low + slack), high - slack)]))
    forces = {
        "N": found.axial[0], "V": found.shear[0], "T": found.torque[0],
        "M_y": found.moment_y[0], "M_z": found.moment_z[0],
    }  # fmt: skip
    if weld.walls.outline == "I":
        forces["B"] = _bimoment(loaded, weld, (bar.cuts[0], bar.cuts[-1]), points)
    return forces


def _bimoment(
    loaded: LoadedPart,
    weld: Weld,
    ends: tuple[float, float],
    points: Sequence[tuple[float, FloatArray]],
) -> FloatArray:
    """Bimoment (n,), N mm2, of a bar whose ends warp freely under couples M at places of it.

    With k^2 = G J/(E I_w) each M adds M sinh(k l) sinh(k r)/(k sinh(k L)) to it: of weld and M,
    one is l from the left end, the other r from the right end.
    """
    walls, steel = weld.walls, loaded.part.material
    length = ends[1] - ends[0]
    k = sqrt(walls.torsion / (2 * (1 + steel.poisson_ratio) * walls.warping))
    total = np.zeros(len(loaded.loads.accelerations))
    for x, wrench in points:
        low, high = min(x, weld.at) - ends[0], ends[1] - max(x, weld.at)
        lasting = exp(k * (low + high - length)) * expm1(-2 * k * low) * expm1(-2 * k * high)
        total += wrench[:, 3] * lasting / (-2 * k * expm1(-2 * k * length))
    return total


def _plate_forces(loaded: LoadedPart, shape: Plate, weld: Weld) -> dict[str, FloatArray]:
    """Section forces (n,) across an arm of a plate, about the middle of its section."""
    assert weld.walls.across is not None, "a plate tells its section"
    cut = shape.outline.cut(*weld.walls.across)
    assert cut is not None, "its section is inside"
    plate, section = PlateLoads(loaded.part, shape, loaded.loads), FlatSection(cut, shape.thickness)
    ahead = plate.is_ahead(section)
    axial, shear, moment = plate.across(section, ahead) @ plate.acting
    wrenches = np.sum([loaded.loads.wrenches[name] for name in ahead], axis=0)
    couples = (wrenches[:, 3] + 1j * wrenches[:, 4]) * np.conj(cut.along)
    return {"N": axial, "V": shear, "T": couples.real, "M_y": couples.imag, "M_z": moment}


# of a thin line h high and w wide with corners of radius r, per thickness: first moment of a
# quarter, second moment; and the area inside
_FIRST = "({w} - 2*{r})*{h}/4 + {r}*(({h}/2 - {r})*pi/2 + {r}) + ({h}/2 - {r})^2/2"
_SECOND = (
    "({h} - 2*{r})^3/6 + ({w} - 2*{r})*{h}^2/2"
    " + {r}*(pi/2*{h}^2 - (2*pi - 4)*{r}*{h} + (3*pi - 8)*{r}^2)"
)
_WITHIN = "{h}*{w} - (4 - pi)*{r}^2"
_MIDDLE, _OUTSIDE = {"h": "h", "w": "w", "r": "r"}, {"h": "d", "w": "b", "r": "c"}
_WALLS = {  # by outline: shear stress of 1 N and of 1 N mm of torque, where it is largest
    "round": ("2/A", "d/(4*I_z)"),
    "rectangular": (
        f"({_FIRST})/(({_SECOND})*t)".format(**_MIDDLE),
        f"1/(2*({_WITHIN})*t)".format(**_MIDDLE),
    ),
    "flat": ("3/(2*A)", "1/W_t"),
    "I": ("q_w", "t/J"),
}
_THROATS = {  # by outline: A, I_z, I_y, and as above
    "round": ("pi*d*a", "pi*d^3*a/8", "I_z", "2/A", "2/(pi*d^2*a)"),
    "rectangular": (
        "(2*d + 2*b - (8 - 2*pi)*c)*a",
        f"({_SECOND})*a".format(**_OUTSIDE),
        f"({_SECOND})*a".format(h="b", w="d", r="c"),
        f"({_FIRST})/I_z".format(**_OUTSIDE),
        f"1/(2*({_WITHIN})*a)".format(**_OUTSIDE),
    ),
    "flat": ("2*d*a", "d^3*a/6", "d*t^2*a/2", "3/(2*A)", "1/(d*t*a)"),
}
_STEPS = (
    ("A", "area", "mm2"),
    ("I_z", "second moment in the plane", "mm4"),
    ("I_y", "second moment out of the plane", "mm4"),
    ("q_V", "largest shear stress of 1 N", "1/mm2"),
    ("q_T", "largest shear stress of 1 N mm of torque", "1/mm3"),
)


def _sizes(weld: Weld) -> list[Item]:
    walls, shape, depth = weld.walls, "the part's shape", weld.walls.section.depth_out_of_plane
    sizes: list[Item] = [
        Given("d", "outer size", walls.size, "mm", shape),
        Given("t", "thickness of the wall or bar", walls.wall, "mm", shape),
    ]
    if walls.outline == "rectangular":
        sizes += [
            Given("b", "outer size out of the plane", depth, "mm", shape),
            Given("c", "outer radius of the corners", walls.corner, "mm", shape),
        ]
    return sizes


def _walls(weld: Weld) -> list[Item]:
    """The section of the walls, and its shear per force and per torque."""
    walls, section, shape = weld.walls, weld.walls.section, "the part's shape"
    values = (section.area, section.inertia_in_plane, section.inertia_out_of_plane)
    items: list[Item] = [
        Given(symbol, meaning, value, unit, shape)
        for (symbol, meaning, unit), value in zip(_STEPS, values, strict=False)
    ]
    if walls.outline == "flat":
        modulus = float(rectangle_torsion(walls.size, walls.wall)[1])
        items.append(Given("W_t", "torsion modulus", modulus, "mm3", "Saint-Venant's series"))
    elif walls.outline == "rectangular":
        items += [
            Step("h", "size of the walls' middle line", "d - t", "mm", _THEORY),
            Step("w", "the same out of the plane", "b - t", "mm", _THEORY),
            Step("r", "radius of its corners", "(c + max(c - t, 0))/2", "mm", _THEORY),
        ]
    elif walls.outline == "I":
        items += [
            Given("q_w", "S/(I_z s) of half the section and the web", walls.shear, "1/mm2", shape),
            Given("J", "torsion constant", walls.torsion, "mm4", shape),
            Given("I_w", "warping constant", walls.warping, "mm6", shape),
        ]
    shears = zip(_STEPS[3:], _WALLS[walls.outline], strict=True)
    return [*_sizes(weld), *items, *(_step(*one) for one in shears)]


def _throat(weld: Weld) -> list[Item]:
    """The section of the throat, laid round the outline; of a flat bar along both faces."""
    throat = Given("a", "throat", weld.throat or 0.0, "mm", "the design", main=True)
    steps = zip(_STEPS, _THROATS[weld.walls.outline], strict=True)
    return [throat, *_sizes(weld), *(_step(*one) for one in steps)]


def _step(told: tuple[str, str, str], formula: str) -> Step:
    symbol, meaning, unit = told
    return Step(symbol, meaning, formula, unit, _THEORY)


def _outline(weld: Weld) -> list[tuple[float, float]]:
    """Points (y, z) of the outline, mm, among which the normal stress is largest."""
    walls = weld.walls
    half = walls.size / 2
    if walls.outline == "round":
        angles = 2 * np.pi * np.arange(_ROUND) / _ROUND
        sines, cosines = np.sin(angles).round(_DIGITS), np.cos(angles).round(_DIGITS)
        return [(float(half * s), float(half * c)) for s, c in zip(sines, cosines, strict=True)]
    depth = walls.section.depth_out_of_plane / 2
    return [(y, z) for y in (half, -half) for z in (depth, -depth)]


@dataclass(frozen=True, eq=False)
class _Ranges:
    """Fatigue at the toe or the root of a weld.

    section  items of its section
    forces   (n,) at the weld
    """

    loaded: LoadedPart
    weld: Weld
    name: str
    category: float
    where: str
    section: Sequence[Item]
    forces: Mapping[str, FloatArray]

    def check(self) -> Check | None:
        """The check; None where no stress changes."""
        loaded, duty, categories = self.loaded, self.loaded.duty, (self.category, SHEAR_CATEGORY)
        slices = loaded.loads.cycles
        runs = {name: positions_of(slices[name]) for name in duty.cycles if name in slices}
        every = np.concatenate(list(runs.values()))
        outline = _outline(self.weld)
        normal = np.stack([self._over(self._stress, y=y, z=z) for y, z in outline])
        sides = [self._over(_SHEAR, T=sign * self.forces["T"]) for sign in (1.0, -1.0)]
        shear = max(sides, key=lambda one: float(np.ptp(one[every])))
        swing, turned = np.ptp(normal[:, every], axis=1), float(np.ptp(shear[every]))
        if not max(float(swing.max()), turned) > 0.0:
            return None
        endless = endless_weld_safety(swing, turned, categories, begun=duty.damage_so_far > 0)
        lasting, own, beside = np.zeros(len(outline)), None, None
        if duty.life == "finite":
            counts = [duty.cycles[name] for name in runs]
            own = duty_cycles([normal[:, run] for run in runs.values()], counts)
            beside = duty_cycles([shear[run] for run in runs.values()], counts)
            left = miner_left(loaded, "a weld")
            lasting = weld_safety(own, beside, categories, allowed_damage=left)
        with np.errstate(divide="ignore"):
            most = _YIELDS * loaded.part.material.yield_stress / np.maximum(swing, sqrt(3) * turned)
        safety = np.minimum(np.maximum(endless, lasting), most)
        worst = int(safety.argmin())
        along = normal[worst] if swing[worst] > 0.0 else shear
        ends = (int(every[along[every].argmin()]), int(every[along[every].argmax()]))
        if safety[worst] >= most[worst]:
            proof = self._within_yield()
        elif own is None or beside is None or endless[worst] >= lasting[worst]:
            proof = self._without_end()
        else:
            proof = self._miner(own.of_point(worst), beside, float(safety[worst]))
        derivation = self._derivation(ends, outline[worst], turned, float(safety[worst]), proof)
        return over_duty(loaded, self._heading(), ends, derivation, self.weld.partial_factor)

    def _over(self, formula: str, **more: Value) -> FloatArray:
        """A formula (n,) at all positions."""
        found = np.asarray(evaluate_each(formula, self._scope | more), dtype=np.float64)
        return np.broadcast_to(found, self.forces["N"].shape)

    @cached_property
    def _scope(self) -> dict[str, Value]:
        scope: dict[str, Value] = {}
        for item in self.section:
            scope[item.symbol] = value_of(item, scope)
        return scope | dict(self.forces)

    @property
    def _stress(self) -> str:
        return _STRESS + " + B*y*z/I_w" * ("B" in self.forces)

    def _heading(self) -> Heading:
        walls = self.weld.walls
        across = f" x {walls.section.depth_out_of_plane:g}"
        if walls.outline in ("round", "flat"):
            across = ""
        told = f"{walls.outline} {walls.size:g}{across} x {walls.wall:g} mm"
        return Heading(
            kind=FATIGUE,
            of=f"{self.name} at {self.weld.place}",
            place=f"weld at {self.weld.told}, {told}",
            basis=f"{self.where}; partial factor {self.weld.partial_factor:g} as the least safety",
        )

    def _derivation(
        self,
        ends: tuple[int, int],
        fibre: tuple[float, float],
        turned: float,
        safety: float,
        proof: _Proof,
    ) -> Derivation:
        loads, part = self.loaded.loads, self.loaded.part
        stress: list[Item] = [
            Given("y", "point of the outline, in the plane", fibre[0], "mm"),
            Given("z", "the same, out of the plane", fibre[1], "mm"),
        ]
        for number, position in enumerate(ends, start=1):
            stress += [
                Given(f"{symbol}_{number}", meaning, float(self.forces[symbol][position]), unit,
                      "the loads")
                for symbol, (meaning, unit) in _FORCES.items()
                if symbol in self.forces and symbol not in ("V", "T")
            ]  # fmt: skip
            stress.append(Step(f"s_{number}", "normal stress", _numbered(self._stress, number),
                               "MPa", _THEORY))  # fmt: skip
        stress += [
            Step("S", "largest range of normal stress", "abs(s_2 - s_1)", "MPa", main=True),
            Given("T_r", "largest range of the shear stress V q_V +- T q_T", turned, "MPa",
                  "the loads"),
        ]  # fmt: skip
        limit: list[Item] = [
            Given("S_C", "category", self.category, "MPa", self.where, main=True),
            Given("T_C", "category of shear", SHEAR_CATEGORY, "MPa", f"{STANDARD}, {ROOT}"),
        ]
        value: list[Item] = [
            Given("n", "factor on all loads, sought until this is reached", safety, "", _THEORY,
                  main=True),
            *proof[0],
            Step("sigma", "category over the safety", "S_C/n", "MPa", _THEORY, main=True),
        ]  # fmt: skip
        sections = {
            "Section": self.section,
            "Stress at both ends of the largest range": stress,
            "Limit": limit,
            "Demand": value,
        }
        return Derivation(
            cases=tuple(
                load_case(part, loads, position, f"s_{number}")
                for number, position in enumerate(ends, start=1)
            ),
            sections=tuple(Section(title, tuple(items)) for title, items in sections.items()),
            value="sigma",
            limit="S_C",
            bars=_NOMINAL.bars,
            equal=proof[1],
        )

    def _within_yield(self) -> _Proof:
        steel = self.loaded.part.material
        items: list[Item] = [
            Given("S_y", f"yield stress of {steel.name}", steel.yield_stress, "MPa", steel.source),
            Step("n_y", "the largest range that the code allows over the range",
                 f"{_YIELDS:g}*S_y/max(S, sqrt(3)*T_r)", "", f"{STANDARD}, (8.1)", main=True),
        ]  # fmt: skip
        return items, (("n", "n_y"),)

    def _without_end(self) -> _Proof:
        share = AT_CUT_OFF if self.loaded.duty.damage_so_far > 0 else AT_KNEE
        items: list[Item] = [
            Step("S_D", "range of a life without end", f"{share:.15g}*S_C", "MPa", CURVE),
            Step("T_L", "the same of shear", f"{SHEAR_CUT_OFF:.15g}*T_C", "MPa", CURVE),
            Step("D", "normal and shear stress together", "(n*S/S_D)^3 + (n*T_r/T_L)^5", "",
                 f"{STANDARD}, (8.3)", main=True),
            Given("D_a", "limit of it", 1.0, "", f"{STANDARD}, (8.3)"),
        ]  # fmt: skip
        return items, REACHED

    def _miner(self, own: Cycles, beside: Cycles, safety: float) -> _Proof:
        items: list[Item] = [
            *damage_items("D_s", "normal stress", own),
            Step("T_L", "cut-off of shear", f"{SHEAR_CUT_OFF:.15g}*T_C", "MPa", CURVE),
            miner_sum("D_t", "shear stress", beside,
                      f"choose(n*r, T_L, m/{REFERENCE:.0f}*(n*r/T_C)^5, 0)"),
            Step("D", "both together", "D_s + D_t", "", f"{STANDARD}, (8.3) with (A.3)", main=True),
            Given("D_a", f"Miner's sum that is left of {MINER:g}",
                  miner_left(self.loaded, "a weld"), "", MINER_SOURCE),
        ]  # fmt: skip
        scope: dict[str, Value] = {"S_C": self.category, "n": safety, "T_C": SHEAR_CATEGORY}
        for item in items:
            scope[item.symbol] = value_of(item, scope)
        return items, reached(float(scope["D"]), float(scope["D_a"]))


def _numbered(formula: str, number: int) -> str:
    """A formula with the symbols of the forces at one of two positions."""
    return re.sub(rf"\b({'|'.join(_FORCES)})\b", rf"\1_{number}", formula)


def _static(loaded: LoadedPart, weld: Weld, forces: Mapping[str, FloatArray]) -> Check:
    """Largest force per length on the throat against its strength, by the simplified method."""
    walls, material = weld.walls, loaded.part.material
    depth = walls.section.depth_out_of_plane
    demand: list[Series | Item] = [
        *(
            Series(symbol, meaning, forces[symbol], unit, main=symbol in ("N", "M_z"))
            for symbol, (meaning, unit) in _FORCES.items()
            if symbol in forces
        ),
        *_throat(weld),
        Given("c_z", "half its size in the plane", walls.size / 2, "mm", "the part's shape"),
        Given("c_y", "half its size out of the plane", depth / 2, "mm", "the part's shape"),
        Step("s", "normal stress in the throat", "abs(N)/A + abs(M_z)*c_z/I_z + abs(M_y)*c_y/I_y",
             "MPa", _THEORY, main=True),
        Step("tau", "shear stress along it", "abs(V)*q_V + abs(T)*q_T", "MPa", _THEORY, main=True),
        Step("F_w", "force per length", "a*sqrt(s^2 + tau^2)", "N/mm", "EN 1993-1-8, 4.5.3.3",
             main=True),
    ]  # fmt: skip
    limit: list[Item] = [
        Given("S_u", f"tensile strength of {material.name}", material.ultimate_stress, "MPa",
              material.source, main=True),
        Given("S_460", "that of S460, the strongest steel of the table", _STRONGEST, "MPa",
              _THEORY),
        Given("beta_w", "correlation factor, the largest of all steels", _BETA, "",
              "EN 1993-1-8, table 4.1"),
        Given("gamma_M2", "partial factor", _GAMMA, "", "EN 1993-1-8, 2.2"),
        Step("F_R", "strength per length", "a*min(S_u, S_460)/(sqrt(3)*beta_w*gamma_M2)", "N/mm",
             "EN 1993-1-8, (4.3) and (4.4)", main=True),
    ]  # fmt: skip
    heading = Heading(
        kind=THROAT,
        of=weld.place,
        place=f"weld at {weld.told}, throat {weld.throat:g} mm",
        basis="EN 1993-1-8, 4.5.3.3, whatever the direction of the force",
        unit="N/mm",
    )
    return loaded.worst(heading, demand, limit, _NOMINAL)
