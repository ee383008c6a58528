"""Bars of a solid that begins with the coarse mesh, against meshes asked for 1 %.

    python -m bench.first_mesh [STEP]

Every STEPth (3) variation of the bars and links of bench/rung_variations.py: largest stress and
fatigue to the loosest accuracy that is held to be loose. Prints a line for each, and how many lie
inside; some minutes.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace

from bench.rung_variations import SCENES, Machines, Variation
from checks.ladder.levels import COARSE, LOOSE, Asked, solve_levels
from checks.part.loaded_part import FIRST, LoadedPart
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.error_bars import bars_of
from checks.stress.judged import Judged, StaticPeak
from checks.stress.solid_mesh_level import Models

_KINDS = frozenset(("static", "fatigue"))
_REFERENCE = 0.01  # accuracy
_PARTS = ("bar_upper", "crank")


def peaks(of: Variation, first: float, accuracy: float) -> list[tuple[float, float]]:
    """Value and numerical bar of what is judged, MPa: on two meshes, or as many as it takes."""
    design, part, loads = replace(of.design, accuracy=accuracy), of.part, of.loads
    loaded = LoadedPart(design, part, loads)
    use = fatigue_use(loaded)
    judged: list[Judged] = [StaticPeak(loads)] if use is None else [StaticPeak(loads), use]
    levels, _, _ = solve_levels(
        loaded,
        Models(),
        judged,
        endurance_of(part).value,
        lambda _: None,
        Asked(_KINDS, modes=False, first=first),
        lambda _: "enough" if first < FIRST else "",
    )
    return [
        (what.value(levels[-1]), bars_of(what, part, levels, accuracy).numerical.value)
        for what in judged
    ]


def measured(step: int) -> Iterator[tuple[str, float, float, float]]:
    """Yield name, error, bar and bar of the reference, the last three over the reference."""
    machines = Machines()
    for scene in SCENES:
        for of in machines.variations(scene) if scene.part in _PARTS else ():
            if of.number % step == 0:
                pairs = zip(peaks(of, COARSE, LOOSE), peaks(of, FIRST, _REFERENCE), strict=True)
                for (value, bar), (better, left) in pairs:
                    yield of.name, value / better - 1, bar / better, left / better


def main() -> None:
    """Measure and print."""
    inside = count = 0
    for name, error, bar, left in measured(int(sys.argv[1]) if len(sys.argv) > 1 else 3):
        count += 1
        inside += abs(error) <= bar + left
        print(f"{name}: {100 * error:+.2f} %, bar {100 * bar:.2f} %, reference's {100 * left:.2f}")
    print(f"{inside} of {count} inside")


if __name__ == "__main__":
    main()
