"""Bushes of a pin: mean pressure, and pressure times speed, against what the bush may take."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import loads
from checks.design.data import Part
from checks.design.model import StackEntry
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.load_doubts import doubted
from checks.strength.sampling import NEAR, finer, sampled, with_sampling
from geometry.mesh import FloatArray
from geometry.parts import Pin

# A pair of lugs shares the load evenly only if nothing is out of square; ASSUMED band.
SHARE_BAND = 0.05

Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


def bush_checks(loaded: LoadedPart) -> list[Check]:
    """Pressure of every bush in a pin's stack; p v of those that state what they bear of it.

    p = F / (d L) on the projected area, v = |relative angular speed of pin and lug| d / 2. The
    speed is known over computed cycles; measured runs have none.
    """
    part = loaded.part
    if not isinstance(part.geometry, Pin):
        return []
    checks = []
    for entry in part.stack:
        if entry.bush is None:
            continue
        checks += _pressed(loaded, entry)
        if entry.bush.pv is not None:
            checks += _sliding(loaded, entry)
    return checks


def bushes_not_checked(loaded: LoadedPart) -> list[str]:
    """What of the bushes could not be checked, in words."""
    runs = [name for name, cycle in loaded.runs.items() if not isinstance(cycle, loads.CycleLoads)]
    if not runs:
        return []
    return [
        f"NOT CHECKED: {sliding_quantity(entry)} in {', '.join(runs)}: measured loads "
        "tell no relative speeds"
        for entry in loaded.part.stack
        if entry.bush is not None and entry.bush.pv is not None
    ]


def _pressed(loaded: LoadedPart, entry: StackEntry) -> list[Check]:
    return sampled(lambda some: [_pressure_check(loaded.under(some), entry)], loaded.loads)


def _pressure_check(loaded: LoadedPart, entry: StackEntry) -> Check:
    part, part_loads = loaded.part, loaded.loads
    assert entry.bush is not None
    pressure = _pressure(part, part_loads, entry)
    (worst,) = first_largest(pressure)
    value = float(pressure[worst])
    diameter, length = bush_diameter(part, entry), entry.bush.length
    force = value * diameter * length
    paired = bush_count(entry) == 2
    return Check(
        part=part.name,
        kind="bush",
        quantity=pressed_quantity(entry),
        value=value,
        unit="MPa",
        numerical=0.0,
        model=SHARE_BAND * value if paired else 0.0,
        limit=entry.bush.allowable,
        required=loaded.required.bush,
        cycle=part_loads.cycle_names[worst],
        position=part_loads.labels[worst],
        place=f"mean pressure on {diameter:g} x {length:g} mm",
        method="formula",
        basis="allowable pressure as stated in the design",
        model_below=0.0,
        note=f"p = {force:.0f} N / ({diameter:g} x {length:g} mm2)"
        + ("; 50 to 52.5 % of the load in one bush of the pair" if paired else ""),
    )


def _sliding(loaded: LoadedPart, entry: StackEntry) -> list[Check]:
    """The peak of p v with its load bars: at the ends of a doubt the speeds differ, too."""
    pairs = [zip(d.ends, d.runs, strict=True) for d in loaded.loads.doubts]
    runs = {id(end): run for pair in pairs for end, run in pair}

    def made(some: PartLoads) -> list[Check]:
        return _pv_check(replace(loaded, loads=some, runs=runs.get(id(some), loaded.runs)), entry)

    return doubted(made, loaded.loads, made(loaded.loads))


def _pv_check(loaded: LoadedPart, entry: StackEntry) -> list[Check]:
    """Check the peak of p v over all computed cycles; the mean of each cycle is told."""
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
        turned[columns] = turning(cycle, part, entry)
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


def turning(cycle: loads.CycleLoads, part: Part, entry: StackEntry) -> FloatArray:
    """Angular speed (n,) of a lug against the pin, which turns with a body, rad/s."""
    assert part.fixed_to is not None
    own = cycle.velocities[:, cycle.body_index(part.fixed_to), 2]
    if entry.body is not None:
        return np.asarray(cycle.velocities[:, cycle.body_index(entry.body), 2] - own)
    assert entry.force is not None
    coordinate = cycle.linkage.force(entry.force).coordinate
    if not isinstance(coordinate, loads.Distance):
        return np.asarray(-own)  # a force whose direction does not turn
    ends = (
        (coordinate.body_b, coordinate.point_b),
        (coordinate.body_a, coordinate.point_a),
    )
    reach = cycle.point(*ends[0]) - cycle.point(*ends[1])
    rate = _velocity(cycle, *ends[0]) - _velocity(cycle, *ends[1])
    across = reach[:, 0] * rate[:, 1] - reach[:, 1] * rate[:, 0]
    return np.asarray(across / (reach**2).sum(axis=1) - own)


def _velocity(cycle: loads.CycleLoads, body: str, point: str) -> FloatArray:
    """Velocity (n, 2) of a point of a body, mm/s."""
    row = cycle.body_index(body)
    arm = cycle.point(body, point) - cycle.poses[:, row, :2]
    spin = cycle.velocities[:, row, 2:]
    return np.asarray(cycle.velocities[:, row, :2] + spin * np.stack([-arm[:, 1], arm[:, 0]], 1))


def _pressure(part: Part, part_loads: PartLoads, entry: StackEntry) -> FloatArray:
    """Mean pressure (n,) of one bush, MPa."""
    assert entry.bush is not None
    area = bush_diameter(part, entry) * entry.bush.length * bush_count(entry)
    return part_loads.resultant(bush_name(entry)) / area


def bush_count(entry: StackEntry) -> int:
    """How many equal bushes share the load of an entry of a stack."""
    return 2 if entry.at and not entry.single else 1


def bush_diameter(part: Part, entry: StackEntry) -> float:
    """Diameter of the pin in a bush, mm."""
    assert isinstance(part.geometry, Pin)
    return entry.diameter or part.geometry.diameter


def bush_name(entry: StackEntry) -> str:
    """What turns in a bush: a body, or a force."""
    name = entry.body or entry.force
    assert name is not None
    return name


def pressed_quantity(entry: StackEntry) -> str:
    """What the check of a bush's pressure is called."""
    return f"bush of {bush_name(entry)}"


def sliding_quantity(entry: StackEntry) -> str:
    """What the check of a bush's pressure times speed is called."""
    return f"p v of the bush of {bush_name(entry)}"
