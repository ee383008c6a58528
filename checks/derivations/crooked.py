"""The crooked column that is bent besides, as docs/theory/columns.md has it."""

from collections.abc import Sequence
from math import isfinite, pi

from checks.columns.column_limits import Plane, planes_of
from checks.columns.column_moments import CrookedColumn, crooked_column
from checks.columns.stability import worst_compression
from checks.part.derived import load_case, numbers, yield_stress
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Bars, Column, Derivation, Given, Item, Section, Step, Sum

_THEORY = "docs/theory/columns.md"
_BENT = "Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 1.11"
_ALMOST = 1 - 1e-9  # of a critical force: a root that is sought ends there


def crooked(loaded: LoadedPart) -> dict[str, Derivation]:
    """Of the crooked columns in both planes, by the quantity of their checks."""
    part, loads = loaded.part, loaded.loads
    if worst_compression(part, loads) is None:
        return {}
    planes = planes_of(loaded.design, part)
    mass = loaded.stated.mass
    found = {}
    for plane, other in (planes, planes[::-1]):
        column, sections, positions = crooked_column(part, loads, plane, other, mass)
        factor, row, place = column.load_factor(part.material.yield_stress)
        at = f"{sections[place].name} at {plane.own * column.places[place]:.4g} mm"
        force = float(column.force[row])
        least = float(column.critical.min())
        bound = factor * force >= _ALMOST * least
        items = [yield_stress(part), *_pressed(column, row, place, at)]
        items += (
            _by_buckling(least) if bound else _by_yield(column, factor, row, place, plane, other)
        )
        found[f"crooked bar {plane.name}"] = Derivation(
            cases=(load_case(part, loads, int(positions[row])),),
            sections=(
                Section("Limit, and how far all loads may grow", tuple(items)),
                Section(
                    "Demand",
                    (Step("sigma", "the yield stress over the factor", "S_y/n", "MPa", main=True),),
                ),
            ),
            value="sigma",
            limit="S_y",
            equal=() if bound else (("S_n", "S_y"),),
            bars=Bars(words="a formula has no mesh"),
        )
    return found


def _pressed(column: CrookedColumn, row: int, place: int, at: str) -> list[Item]:
    return [
        Given("F", "compression", float(column.force[row]), "N", "the loads", main=True),
        Given("A", f"area of {at}", float(column.areas[place]), "mm2", "the part's shape"),
        Given("x", "place over the length", float(column.places[place])),
    ]


def _by_buckling(critical: float) -> list[Item]:
    """It buckles before its edge yields."""
    return [
        Given("F_cr", "lowest buckling force of both planes", critical, "N", _THEORY),
        Step("n", "factor on all loads: it buckles before its edge yields", "F_cr/F", main=True),
    ]


def _by_yield(
    column: CrookedColumn, factor: float, row: int, place: int, plane: Plane, other: Plane
) -> list[Item]:
    items: list[Item] = [
        Given("n", "factor on all loads, sought until the edge yields", factor, "", "root search",
              main=True)
    ]  # fmt: skip
    terms = ["n*F/A"]
    for number, side in enumerate((plane, other), 1):
        items += _moments(column, number, row, place, side)
        terms.append(f"M_{number}/W_{number}")
    said = "edge stress under n times the loads, which must be the yield stress"
    return [*items, Step("S_n", said, " + ".join(terms), "MPa", _BENT, main=True)]


def _moments(column: CrookedColumn, number: int, row: int, place: int, plane: Plane) -> list[Item]:
    """Moment of one plane under n times the loads, grown by the compression."""
    side = number - 1
    critical, series = float(column.critical[side]), numbers(column.series[side][row])
    items: list[Item] = [
        Given(f"W_{number}", f"section modulus, {plane.name}",
              float(column.moduli[side][place]), "mm3", "the part's shape"),
        Given(f"B_{number}", f"moment of the undeformed part, {plane.name}",
              float(column.moments[side][row, place]), "N mm",
              f"couples, offsets, inertia: {_THEORY}"),
    ]  # fmt: skip
    formula = f"abs(n*B_{number})"
    if isfinite(critical):
        items += [
            Given(f"F_{number}", f"lowest buckling force, {plane.name}", critical, "N", _THEORY),
            Step(f"r_{number}", "share of it under n times the loads", f"n*F/F_{number}"),
            _grown(f"G_{number}", number, series, "N mm", "n*b"),
        ]
        formula += f" + abs(G_{number})"
        if number == 1:
            items.append(
                Given("e_0", "crookedness at the place", float(column.bow[place]), "mm", _THEORY)
            )
            formula += " + n*F*e_0/(1 - r_1)"
        if number == 1 and column.beside:
            even = [4 / (pi * k) * (k % 2) for k in range(1, len(series) + 1)]
            items += [
                Given("e_1", "eccentricity", column.beside, "mm", "the design"),
                _grown("G_e", 1, even, "", "b"),
            ]
            formula += " + n*F*e_1*(1 + G_e)"
    return [*items, Step(f"M_{number}", f"moment there, {plane.name}", formula, "N mm", _BENT)]


def _grown(symbol: str, side: int, sizes: Sequence[float], unit: str, size: str) -> Sum:
    """Growth by the compression of a moment given by its sine series."""
    orders = range(1, len(sizes) + 1)
    return Sum(
        symbol,
        "what the compression adds to the series of the moment",
        f"{size}*r_{side}/(k^2 - r_{side})*sin(k*pi*x)",
        tuple(f"{order} half wave{'s' if order > 1 else ''}" for order in orders),
        (
            Column("k", "half waves", "", tuple(float(order) for order in orders)),
            Column("b", "size of the wave", unit, tuple(sizes)),
        ),
        unit,
        _BENT,
    )
