"""The FKM guideline's chain at the worst point, as docs/theory/strength.md has it."""

from checks.derivations.superposed import patterns_of, superposed
from checks.design.data import Part
from checks.part.derived import amplitude_and_mean, load_case
from checks.part.part_loads import PartLoads
from checks.result.derivation import Derivation, Given, Item, Section, Step
from checks.strength.fatigue_assessment import FkmUse
from checks.strength.fkm_strength import FkmJudgement
from checks.stress.stress_result import Stressed

_BOOK = "FKM guideline, 6th ed., chapter 4"


def fkm(part: Part, loads: PartLoads, level: Stressed, use: FkmUse) -> Derivation:
    """Of the utilisation times the reference strength."""
    found = use.found(level)
    pair = tuple(zip(found.pair, ("s_1", "s_2"), strict=True))
    return Derivation(
        cases=tuple(load_case(part, loads, position, symbol) for position, symbol in pair),
        sections=(
            Section(
                "Stress at the point, at both ends of its longest chord",
                tuple(superposed(level, loads, found.point, k, symbol) for k, symbol in pair),
            ),
            amplitude_and_mean(", not below 0", _BOOK),
            Section("Limit: component strength without support", tuple(_limit(use))),
            Section("Demand", tuple(_demand(found))),
        ),
        value="sigma",
        limit="sigma_ref",
        notes=(patterns_of(level),),
    )


def _limit(use: FkmUse) -> list[Item]:
    own, plain = use.strength, use.strength.plain
    group = own.material.numbers
    strength: list[Item] = [
        Given("f_W", f"fully reversed over ultimate strength, {own.material.group}",
              group.strength_ratio, "", _BOOK),
        Step("sigma_W", "fully reversed strength of the material", "f_W*R_m", "MPa", _BOOK),
    ]  # fmt: skip
    if own.material.reversed_strength is not None:
        strength = [Given("sigma_W", "fully reversed strength, as stated", plain.strength, "MPa")]
    return [
        Given("R_m", "ultimate strength", own.material.ultimate_strength, "MPa", "the material"),
        *strength,
        Given("a_R", "weight of the roughness", group.roughness, "", _BOOK),
        Given("R_N", "least strength of the group", group.least_strength, "MPa", _BOOK),
        Given("R_z", "roughness", own.roughness, "µm", "the design, roughness or surface"),
        Step("K_R", "roughness factor",
             "1 - a_R*log10(max(R_z, 1))*max(0, log10(2*R_m/R_N))", "", _BOOK),
        Given("K_n", "notch factor of the surface, K_f~", plain.notch_factor, "", _BOOK),
        Step("q", "what the roughness takes", "1 + (1/K_R - 1)/K_n", "", _BOOK),
        Given("K_BK", "endured for ever over endured at 1e6 cycles", own.endurance_share, "",
              _BOOK),
        Step("sigma_ref", "even, fully reversed amplitude endured for ever", "sigma_W/q*K_BK",
             "MPa", _BOOK, main=True),
    ]  # fmt: skip


def _demand(found: FkmJudgement) -> list[Item]:
    return [
        Given("G", "related stress gradient below the point", found.gradient, "1/mm",
              "the solid's displacements", main=True),
        Given("n_s", "Stieler's support number of it", float(found.limit.support), "", _BOOK),
        Step("sigma_WK", "strength of the part there, fully reversed", "sigma_W*n_s/q", "MPa",
             _BOOK, main=True),
        Given("M", "mean stress sensitivity", found.limit.sensitivity, "", _BOOK),
        Step("r", "mean over amplitude", "sigma_m/sigma_a", "", _BOOK),
        Step("K_AK", "mean stress factor, constant R",
             "(1 + M/3)/((1 + M*min(r, 1))*(1 + M/3*max(1, min(r, 3))))", "", _BOOK, main=True),
        Step("u", "utilisation a_BK", "sigma_a/(K_AK*sigma_WK*K_BK)", "", _BOOK, main=True),
        Step("sigma", "the utilisation as an even, reversed stress", "u*sigma_ref", "MPa", _BOOK,
             main=True),
    ]  # fmt: skip
