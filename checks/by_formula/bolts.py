"""Screws that hold a cap, flange or block at an interface: opening, yield, fatigue of the thread.

The force that opens the joint is shared by the screws; of each one's share P its screw takes C P
on top of its preload, until the joint opens. The least preload must keep the joint closed, the
largest one must leave the screws below yield, and ranges of C P are judged by EN 1993-1-9:2005
(docs/theory/bolts.md).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from checks.design.errors import DesignError
from checks.design.model import BoltsEntry
from checks.handbook.screws import COARSE_PITCH, yield_stress_of
from checks.handbook.weld_details import SHEAR_CATEGORY, STANDARD
from checks.part.derived import Band, Heading, Kind, Series, demand_over, load_case
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Derivation, Given, Item, Section, Step, value_of
from checks.result.formulas import Value
from checks.result.verdict import Check
from checks.result.words import UNKNOWN_BAR
from checks.strength.ranges_over_duty import (
    CURVE,
    MINER_SOURCE,
    damage_items,
    miner_left,
    over_duty,
    positions_of,
    reached,
)
from fatigue.life import (
    AT_CUT_OFF,
    AT_KNEE,
    Cycles,
    duty_cycles,
    endless_weld_safety,
    weld_safety,
)
from geometry.mesh import FloatArray

_PAGE = "[screws](../theory/bolts.md)"
OPENING = Kind(
    name="bolts",
    quantity="opening of the joint at {}",
    demand="largest force on the joint per screw",
    limit="force that opens it under the least preload",
    require="static",
    source=_PAGE,
)
YIELD = Kind(
    name="bolts",
    quantity="yield of the screws at {}",
    demand="largest force on the joint per screw",
    limit="force that makes the screw yield under the largest preload",
    require="static",
    source=_PAGE,
)
FATIGUE = Kind(
    name="bolts",
    quantity="fatigue of the screws at {}",
    demand="category over the safety that ranges of stress in the stress area leave",
    limit="category 50, EN 1993-1-9; the safety is at least `partial_factor`",
    require="fatigue",
    source=_PAGE,
)
KINDS = (OPENING, YIELD, FATIGUE)
OVER_CYCLES = True  # ranges, which no position shows by itself

_THEORY = "docs/theory/bolts.md"
_ARM = 1e-3  # mm, of the part's largest force: a smaller couple is none
_OF_FRICTION = 0.1  # of a pin's force times its diameter: couple of its friction at the most
_CATEGORY = 50.0  # MPa, table 8.1, detail 14: threads rolled or cut, in tension
_DETAIL = f"{STANDARD}, table 8.1, detail 14"
_BAND = Band(words="a formula has no mesh; scatter of the preload is in the limits")
_PROFILE = "ISO 68-1"
_VDI = "VDI 2230"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Opening, yield and fatigue of all screws that the part states."""
    for index, stated in enumerate(loaded.part.bolts):
        joint = _Joint(loaded, stated, f"parts.{loaded.name}.bolts[{index}]")
        found = [joint.opening(), joint.yielding()]
        if any(name in loaded.loads.cycles for name in loaded.duty.cycles):
            fatigue = joint.fatigue()
            if fatigue is not None:
                found.append(fatigue)
        yield from (_open_by_couple(loaded, stated, check) for check in found)


def _least_couple(loaded: LoadedPart) -> float:
    return _ARM * loaded.loads.largest_force


def _couples(loaded: LoadedPart, at: str) -> FloatArray:
    """Couples (n,) at an interface over all positions, N mm."""
    return np.asarray(np.linalg.norm(loaded.loads.wrenches[at][:, 3:], axis=1))


def _open_by_couple(loaded: LoadedPart, stated: BoltsEntry, check: Check) -> Check:
    """The check without an end of its bar where screws bear a couple of which nothing is stated.

    Friction of a pin in a bore's cap turns by less than a tenth of its force times diameter.
    """
    (face,) = (f for f in loaded.part.geometry.placed_interfaces if f.name == stated.at)
    couples, forces = _couples(loaded, stated.at), loaded.loads.resultant(stated.at)
    friction = np.maximum(_OF_FRICTION * 2 * face.radius * forces, _least_couple(loaded))
    beyond = couples[couples > friction]
    if stated.prying > 1.0 or not len(beyond):
        return check
    couple = beyond.max()
    why = f"a couple of up to {couple * 1e-3:.3g} N m goes through them, and no prying is stated"
    note = "; ".join(text for text in (check.note, f"{UNKNOWN_BAR}{why}") if text)
    return replace(check, model=inf, note=note).explained_by(check.derivation)


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Subjects that the screws' checks do not know."""
    if loaded.part.bolts:
        yield (
            "screws as pulled along themselves: no bending or prying beyond the stated `prying`, "
            "no force across them or sliding of the joint, thread long enough, pressure under "
            "heads, inertia of the cap, heat and loosening left out"
        )
    for stated in loaded.part.bolts:
        couple = _couples(loaded, stated.at).max()
        if couple > _least_couple(loaded):
            yield (
                f"NOT CHECKED: a couple of up to {couple * 1e-3:.3g} N m at {stated.at}, which its "
                "screws bear by their distances, but for what the stated `prying` has of it"
            )


@dataclass(frozen=True, eq=False)
class _Joint:
    """The screws at one interface.

    key  of the design file that states them
    """

    loaded: LoadedPart
    stated: BoltsEntry
    key: str

    @cached_property
    def _force(self) -> Series:
        """Force (n,) on the part there in the direction that opens the joint."""
        wrench = self.loaded.loads.wrenches[self.stated.at]
        along = wrench[:, :2] @ np.asarray(self.stated.opens)
        return Series("F", f"force at {self.stated.at} that opens the joint", along, "N", main=True)

    @property
    def _share(self) -> list[Item]:
        stated = self.stated
        pulls = "max(F, 0)" if stated.pushed_beside else "F"
        return [
            Given("m", "number of screws", float(stated.count), "", "the design"),
            Given("f_p", "share of the most loaded one over the mean", stated.prying, "",
                  "the design"),
            Step("P", "force on the joint per screw", f"f_p*{pulls}/m", "N", _THEORY, main=True),
        ]  # fmt: skip

    @cached_property
    def _thread(self) -> list[Item]:
        stated = self.stated
        diameter = float(stated.size.removeprefix("M"))
        return [
            Given("d", f"diameter of {stated.size}", diameter, "mm", "the design"),
            Given("p", "coarse pitch", COARSE_PITCH[stated.size], "mm", "ISO 261"),
            Step("d_2", "pitch diameter", "d - 0.649519*p", "mm", _PROFILE),
            Step("d_3", "minor diameter", "d - 1.226869*p", "mm", _PROFILE),
            Step("d_s", "their mean", "(d_2 + d_3)/2", "mm", "ISO 898-1"),
            Step("A_s", "stress area", "pi/4*d_s^2", "mm2", "ISO 898-1", main=True),
        ]

    @cached_property
    def _preload(self) -> list[Item]:
        """Both ends of the preload; raises DesignError where there is none that can be."""
        stated, own = self.stated, "the design"
        items: list[Item] = [
            *self._thread,
            Given("mu_G", "friction in the thread", stated.thread_friction, "", own),
        ]
        if stated.torque is None:
            assert stated.largest_preload is not None, "one of the two is stated"
            items.append(Given("F_1", "largest preload", stated.largest_preload, "N", own, True))
        else:
            items += [
                Given("M_A", "tightening torque", stated.torque, "N mm", own, True),
                Given("mu_K", "least friction under the head", stated.head_friction or 0.0, "",
                      own),
                Given("D_K", "mean diameter of that face", stated.head_diameter or 0.0, "mm", own),
                Step("F_1", "largest preload", "M_A/(0.16*p + 0.58*d_2*mu_G + mu_K*D_K/2)", "N",
                     _VDI, main=True),
            ]  # fmt: skip
        twist = "3/2*d_2/d_s*(p/(pi*d_2) + 1.155*mu_G)" if stated.thread_friction else "0"
        items += [
            Given("a_A", "tightening factor", stated.tightening_factor, "", own),
            Given("F_Z", "loss by settling", stated.settling, "N", own),
            Step("F_0", "least preload", "F_1/a_A - F_Z", "N", _VDI, main=True),
            Given("C", "joint constant", stated.joint_constant, "", own),
            Given("R", f"yield stress of {stated.property_class}",
                  yield_stress_of(stated.property_class), "MPa", "ISO 898-1, nominal", True),
            Step("k", "shear by torsion over tension, of tightening", twist, "", _VDI),
            Step("F_y", "tension that yields beside that torsion",
                 "sqrt(max((R*A_s)^2 - 3*(k*F_1)^2, 0))", "N", "von Mises", main=True),
        ]  # fmt: skip
        scope: dict[str, Value] = {}
        for item in items:
            scope[item.symbol] = value_of(item, scope)
        largest, least, holds = (float(scope[name]) for name in ("F_1", "F_0", "F_y"))
        if largest >= holds:
            self._refuse(
                "largest_preload" if stated.torque is None else "torque",
                f"the largest preload of {largest:.0f} N makes {stated.size} "
                f"{stated.property_class} yield as it is tightened: beside its torsion it must be "
                f"below {holds:.0f} N",
            )
        if least <= 0.0:
            self._refuse(
                "settling",
                f"of the least preload of {largest / stated.tightening_factor:.0f} N settling by "
                f"{stated.settling:.0f} N leaves nothing",
            )
        return items

    def _refuse(self, field: str, problem: str) -> None:
        raise DesignError(self.loaded.design.file, f"{self.key}.{field}", problem)

    def _heading(self, kind: Kind, basis: str, unit: str = "N") -> Heading:
        stated = self.stated
        told = f"{stated.count} {stated.size} {stated.property_class}"
        way = "({:.4g}, {:.4g})".format(*stated.opens)
        place = f"{told} at {stated.at}, opened by force along {way}"
        of = self.loaded.part.interfaces[stated.at]
        return Heading(kind=kind, of=of, place=place, basis=basis, unit=unit)

    def opening(self) -> Check:
        """Force per screw against what opens the joint under the least preload."""
        most = Step("P_0", "force that opens it", "F_0/(1 - C)", "N", _THEORY, main=True)
        heading = self._heading(OPENING, "least preload; the safety is on the force")
        return self.loaded.worst(heading, self._demand, [*self._preload, most], _BAND)

    def yielding(self) -> Check:
        """Force per screw against what makes it yield under the largest preload."""
        formula = "min((F_y - F_1)/C, F_y)"
        most = Step("P_y", "force that makes it yield", formula, "N", _THEORY, main=True)
        heading = self._heading(YIELD, "largest preload; the safety is on the force")
        return self.loaded.worst(heading, self._demand, [*self._preload, most], _BAND)

    @property
    def _demand(self) -> list[Series | Item]:
        pulls = Step("P_p", "of it, the pull", "max(P, 0)", "N", main=True)
        return [self._force, *self._share, pulls]

    def fatigue(self) -> Check | None:
        """Ranges of the screw's stress over the duty; None where none changes."""
        loaded, duty, categories = self.loaded, self.loaded.duty, (_CATEGORY, SHEAR_CATEGORY)
        slices = loaded.loads.cycles
        runs = {name: positions_of(slices[name]) for name in duty.cycles if name in slices}
        every = np.concatenate(list(runs.values()))
        stress = demand_over([self._force, *self._share, *self._preload, *_stress()])
        swing = float(np.ptp(stress[every]))
        if not swing > 0.0:
            return None
        begun = duty.damage_so_far > 0
        safety = float(endless_weld_safety(np.array([swing]), 0.0, categories, begun=begun)[0])
        proof = _without_end(begun)
        if duty.life == "finite":
            left, counts = miner_left(loaded, "a screw"), [duty.cycles[name] for name in runs]
            own = duty_cycles([stress[None, run] for run in runs.values()], counts)
            still = duty_cycles([np.zeros_like(stress[run]) for run in runs.values()], counts)
            lasting = float(weld_safety(own, still, categories, allowed_damage=left)[0])
            if lasting > safety:
                safety, proof = lasting, _miner(own.of_point(0), left)
        ends = int(every[stress[every].argmin()]), int(every[stress[every].argmax()])
        factor = self.stated.partial_factor
        basis = f"{_DETAIL}; partial factor {factor:g} as the least safety"
        heading = self._heading(FATIGUE, basis, "MPa")
        return over_duty(loaded, heading, ends, self._derivation(ends, safety, proof), factor)

    def _derivation(self, ends: Sequence[int], safety: float, proof: Sequence[Item]) -> Derivation:
        loads, part = self.loaded.loads, self.loaded.part
        shares: FloatArray = demand_over([self._force, *self._share])
        swing: list[Item] = []
        for number, position in enumerate(ends, start=1):
            swing += [
                Given(f"P_{number}", "force on the joint per screw", float(shares[position]), "N",
                      "the loads", main=True),
                *_stress(f"_{number}"),
            ]  # fmt: skip
        swing.append(Step("S", "largest range of stress", "s_2 - s_1", "MPa", main=True))
        value: list[Item] = [
            Given("n", "factor on the ranges, sought until this is reached", safety, "", _THEORY,
                  main=True),
            *proof,
            Step("sigma", "category over the safety", "S_C/n", "MPa", _THEORY, main=True),
        ]  # fmt: skip
        sections: dict[str, Sequence[Item]] = {
            "Screw": self._preload,
            "Stress at both ends of the largest range": swing,
            "Limit": [Given("S_C", "category", _CATEGORY, "MPa", _DETAIL, main=True)],
            "Demand": value,
        }
        scope: dict[str, Value] = {}
        for item in (one for items in sections.values() for one in items):
            scope[item.symbol] = value_of(item, scope)
        return Derivation(
            cases=tuple(
                load_case(part, loads, position, f"s_{number}")
                for number, position in enumerate(ends, start=1)
            ),
            sections=tuple(Section(title, tuple(items)) for title, items in sections.items()),
            value="sigma",
            limit="S_C",
            bars=_BAND.bars,
            equal=reached(float(scope["D"]), float(scope["D_a"])),
        )


def _stress(end: str = "") -> list[Item]:
    """Tension and stress of a screw by its share, of the least preload, which opens first."""
    return [
        Step(f"F_S{end}", "tension of the screw", f"max(F_0 + C*P{end}, P{end})", "N", _THEORY),
        Step(f"s{end}", "stress in the stress area", f"F_S{end}/A_s", "MPa", _DETAIL),
    ]


def _without_end(begun: bool) -> list[Item]:
    share = AT_CUT_OFF if begun else AT_KNEE
    return [
        Step("S_D", "range of a life without end", f"{share:.15g}*S_C", "MPa", CURVE),
        Step("D", "range over it", "n*S/S_D", "", CURVE, main=True),
        Given("D_a", "limit of it", 1.0, "", CURVE),
    ]


def _miner(own: Cycles, left: float) -> list[Item]:
    return [
        *damage_items("D", "stress", own),
        Given("D_a", "Miner's sum that is left", left, "", MINER_SOURCE),
    ]
