"""Bushes of a pin: pressure times sliding speed against what they may take."""

from dataclasses import replace

import numpy as np

import loads
from checks.design.data import Part
from checks.design.model import StackEntry
from checks.joints.bushes import SHARE_BAND
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.load_doubts import doubted
from checks.strength.sampling import NEAR, finer, with_sampling
from geometry.mesh import FloatArray
from geometry.parts import Pin


def sliding_checks(loaded: LoadedPart) -> list[Check]:
    """Peak of p v of the bushes of a pin that state what they bear of it."""
    return [
        check
        for entry in loaded.part.stack
        if entry.bush is not None and entry.bush.pv is not None
        for check in _sliding(loaded, entry)
    ]


def bushes_not_checked(loaded: LoadedPart) -> list[str]:
    """Bushes that could not be checked, in words."""
    runs = [name for name, cycle in loaded.runs.items() if not isinstance(cycle, loads.CycleLoads)]
    if not runs:
        return []
    return [
        f"NOT CHECKED: {sliding_quantity(entry)} in {', '.join(runs)}: measured loads "
        "tell no relative speeds"
        for entry in loaded.part.stack
        if entry.bush is not None and entry.bush.pv is not None
    ]


def _sliding(loaded: LoadedPart, entry: StackEntry) -> list[Check]:
    """The peak of p v with its load bars: at the ends of a doubt the speeds differ, too."""
    pairs = [zip(d.ends, d.runs, strict=True) for d in loaded.loads.doubts]
    runs = {id(end): run for pair in pairs for end, run in pair}

    def made(some: PartLoads) -> list[Check]:
        return _pv_check(replace(loaded, loads=some, runs=runs.get(id(some), loaded.runs)), entry)

    return doubted(made, loaded.loads, made(loaded.loads))


def _pv_check(loaded: LoadedPart, entry: StackEntry) -> list[Check]:
    """Check the peak of p v over all computed cycles; the note has the mean of each."""
    part, part_loads = loaded.part, loaded.loads
    assert entry.bush is not None
    assert entry.bush.pv is not None
    pressure, diameter = _pressure(part, part_loads, entry), bush_diameter(part, entry)
    found = []
    turned = np.zeros(len(pressure))  # rad/s
    for name, cycle in loaded.runs.items():
        if not isinstance(cycle, loads.CycleLoads) or name not in part_loads.cycles:
            continue
        columns = part_loads.cycles[name]
        turned[columns] = part_loads.spins[entry.name][columns]
        speeds = np.abs(turned[columns]) * diameter / 2
        product = pressure[columns] * speeds
        spans = np.diff(cycle.times)
        mean = float(np.sum((product[:-1] + product[1:]) / 2 * spans) / spans.sum())
        (at,) = first_largest(product)
        found.append((float(product[at]), columns.start + at, name, mean, float(speeds[at])))
    if not found:
        return []
    value, worst, _, _, speed = max(found)
    means = ", ".join(f"{name} {mean / 1e3:.3g}" for _, _, name, mean, _ in found)
    paired = bush_count(entry) == 2
    products = pressure * np.abs(turned) * diameter / 2
    places, most = finer(part_loads, products >= NEAR * value), 0.0
    if places is not None:
        places = places.only(places.share != 0.0)
        speeds = np.abs(places.of(turned)) * diameter / 2
        most = float((_pressure(part, places.between, entry) * speeds).max())
    check = Check(
        part=part.name,
        kind="bush",
        quantity=sliding_quantity(entry),
        value=value / 1e3,
        unit="MPa m/s",
        numerical=0.0,
        model=SHARE_BAND * value / 1e3 if paired else 0.0,
        limit=entry.bush.pv / 1e3,
        required=loaded.required.bush,
        cycle=part_loads.cycle_names[worst],
        position=part_loads.labels[worst],
        place=f"sliding on {diameter:g} mm",
        method="formula",
        basis="allowable p v as stated in the design",
        model_below=0.0,
        note=f"peak: p = {pressure[worst]:.3g} MPa, v = {speed / 1e3:.3g} m/s; "
        f"mean over each cycle, MPa m/s: {means}",
    )
    return [with_sampling(check, max(0.0, most - value) / 1e3)]


def _pressure(part: Part, part_loads: PartLoads, entry: StackEntry) -> FloatArray:
    """Mean pressure (n,) of one bush, MPa."""
    assert entry.bush is not None
    area = bush_diameter(part, entry) * entry.bush.length * bush_count(entry)
    return part_loads.resultant(entry.name) / area


def bush_count(entry: StackEntry) -> int:
    """How many equal bushes share the load of an entry of a stack."""
    return 2 if entry.at and not entry.single else 1


def bush_diameter(part: Part, entry: StackEntry) -> float:
    """Diameter of the pin in a bush, mm."""
    assert isinstance(part.geometry, Pin)
    return entry.diameter or part.geometry.diameter


def sliding_quantity(entry: StackEntry) -> str:
    """Quantity of the check of a bush's pressure times speed."""
    return f"p v of the bush of {entry.name}"
