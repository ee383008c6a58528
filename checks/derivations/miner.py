"""A finite life: counted cycles, Miner's sum, and the safety that it leaves."""

from math import isclose, isfinite

import numpy as np

from checks.derivations.marin import BOOK, limit_section
from checks.derivations.superposed import patterns_of, superposed
from checks.design.data import Part
from checks.part.derived import load_case
from checks.part.part_loads import PartLoads
from checks.result.derivation import Column, Derivation, Given, Item, Section, Step, Sum
from checks.strength.fatigue_assessment import LifeUse
from checks.strength.finite_life import DutyLife, life_curve
from checks.stress.stress_result import Stressed

_THEORY = "docs/theory/life.md"


def miner(part: Part, loads: PartLoads, level: Stressed, use: LifeUse) -> Derivation:
    """Of the endurance limit over the safety that a finite life leaves."""
    life = use.life(level)
    largest = tuple(
        superposed(level, loads, life.point, position, symbol)
        for position, symbol in zip(life.pair, ("s_1", "s_2"), strict=True)
    )
    at = float(level.limits[life.point])
    endless = not isfinite(life.safety) or (use.task.endless and _endless(life, at, use.ultimate))
    return Derivation(
        cases=tuple(
            load_case(part, loads, position, symbol)
            for position, symbol in zip(life.pair, ("s_1", "s_2"), strict=True)
        ),
        sections=(
            Section("Stress at the point, at both ends of the cycle that harms most", largest),
            limit_section(part),
            Section(
                "Safety",
                tuple(_without_end(life, at, use.ultimate) if endless else _miner(use, life, at)),
            ),
            Section(
                "Demand",
                (
                    Step(
                        "sigma",
                        "the endurance limit over the safety that the life leaves",
                        "S_e/n" if not endless else "S_e*u",
                        "MPa",
                        _THEORY,
                        main=True,
                    ),
                ),
            ),
        ),
        value="sigma",
        limit="S_e",
        equal=() if endless else (("D", "D_a"),),
        notes=(
            patterns_of(level),
            f"{len(life.cycles.cycle_counts)} different cycles were counted by rainflow along the "
            f"longest chord of the path {life.run!r}"
            + (f", raised by {life.raised:.4g} for Findley's plane" if life.raised > 1 else "")
            + f" ({_THEORY})",
        ),
    )


def _endless(life: DutyLife, limit: float, strength: float) -> bool:
    """True if the largest cycle gives the safety, against the endurance limit."""
    used = life.cycles.stress_amplitude / limit + life.cycles.mean_stress / strength
    return isclose(float(used.max()) * life.safety, 1.0, rel_tol=1e-9)


def _without_end(life: DutyLife, limit: float, strength: float) -> list[Item]:
    amplitude, mean = life.cycles.stress_amplitude, life.cycles.mean_stress
    worst = int(np.argmax(amplitude / limit + mean / strength))
    return [
        Given("sigma_a", "amplitude of the largest cycle", float(amplitude[worst]), "MPa",
              "rainflow"),
        Given("sigma_m", "mean of the largest cycle", float(mean[worst]), "MPa", "rainflow"),
        Given("S_p", "endurance limit at the point", limit, "MPa", "S_e over its fretting factor"),
        Step("u", "stress over the endurance limit", "sigma_a/S_p + sigma_m/S_u", "",
             f"{BOOK}, eq. 6-46", main=True),
    ]  # fmt: skip


def _miner(use: LifeUse, life: DutyLife, limit: float) -> list[Item]:
    curve = life_curve(use.task.material, np.array([limit]), axial=use.task.axial)
    cycles = life.cycles
    order = np.argsort(-cycles.stress_amplitude, kind="stable")

    def column(symbol: str, meaning: str, unit: str, values: object) -> Column:
        return Column(symbol, meaning, unit, tuple(float(v) for v in np.asarray(values)[order]))

    return [
        Given("S_p", "endurance limit at the point", limit, "MPa", "S_e over its fretting factor"),
        Given("N_D", "cycles of the knee", float(np.max(curve.knee_cycles)), "", _THEORY),
        Given("k_1", "slope above the knee", float(np.max(curve.slope)), "", _THEORY),
        Given("k_2", "slope below it, Haibach", float(np.max(curve.slope_below)), "", _THEORY),
        Given("D_a", "allowed damage", use.task.allowed_damage, "", "the design, duty"),
        Given("n", "factor on all loads, sought until the damage is the allowed one", life.safety,
              "", _THEORY, main=True),
        Sum(
            "D",
            "Miner's sum of the life under n times the loads",
            "m/N_D*(n*a/(1 - n*b/S_u)/S_p)^choose(n*a/(1 - n*b/S_u), S_p, k_1, k_2)",
            tuple(str(number) for number in range(1, len(order) + 1)),
            (
                column("a", "amplitude", "MPa", cycles.stress_amplitude),
                column("b", "mean", "MPa", cycles.mean_stress),
                column("m", "how often in the life", "", cycles.cycle_counts),
            ),
            "",
            f"Palmgren-Miner, {_THEORY}",
            main=True,
        ),
    ]  # fmt: skip
