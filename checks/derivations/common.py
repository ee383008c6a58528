"""What derivations share: load cases, the limit that is given, a chord, a check's place."""

from collections.abc import Iterable

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from checks.result.derivation import Acting, Given, LoadCase, Section, Step
from checks.result.verdict import Check


def load_case(part: Part, loads: PartLoads, position: int, symbol: str = "") -> LoadCase:
    """What acts on a part at one of all positions of all cycles."""
    cycle = loads.cycle_names[position]
    return LoadCase(
        symbol=symbol,
        cycle=cycle,
        position=loads.labels[position],
        index=int(position) - loads.cycles[cycle].start,
        acting=tuple(
            Acting(name, part.interfaces.get(name, ""), numbers(wrench[position]))
            for name, wrench in loads.wrenches.items()
        ),
        accelerations=numbers(loads.accelerations[position]),
    )


def position_of(loads: PartLoads, check: Check) -> int:
    """Which of all positions a check's cycle and position are; of equal ones the first."""
    for k, (cycle, label) in enumerate(zip(loads.cycle_names, loads.labels, strict=True)):
        if cycle == check.cycle and label == check.position:
            return k
    raise ValueError(f"{check.part} {check.kind}: no position is {check.cycle}, {check.position}")


def numbers(values: Iterable[float]) -> tuple[float, ...]:
    """Plain numbers of an array."""
    return tuple(float(value) for value in values)


def amplitude_and_mean(compressed: str, source: str) -> Section:
    """Amplitude and mean of the longest chord, from s_1 to s_2.

    compressed  what is said of a mean in compression, which counts as 0
    """
    mean = f"mean: largest principal stress of the middle{compressed}"
    return Section(
        "Amplitude and mean",
        (
            Step(
                "sigma_a",
                "amplitude: half the chord, von Mises",
                "von_mises((s_1 - s_2)/2)",
                "MPa",
                source,
                main=True,
            ),
            Step(
                "sigma_m",
                mean,
                "max(0, largest_principal((s_1 + s_2)/2))",
                "MPa",
                source,
                main=True,
            ),
        ),
    )


def yield_stress(part: Part) -> Given:
    """The yield stress of a part's material."""
    return Given(
        "S_y",
        f"yield stress of {part.material.name}, guaranteed minimum",
        part.material.yield_stress,
        "MPa",
        part.material.source,
        main=True,
    )


def shear_yield() -> Step:
    """The yield stress in shear by von Mises."""
    return Step("tau_y", "yield stress in shear", "S_y/sqrt(3)", "MPa", "von Mises", main=True)


def young(part: Part) -> Given:
    """Young's modulus of a part's material."""
    return Given(
        "E",
        f"Young's modulus of {part.material.name}",
        part.material.youngs_modulus,
        "MPa",
        part.material.source,
    )
