"""A crooked column that is bent besides: its edge against yield, over all positions.

All loads may grow by a factor until the edge yields; it is sought at every section and position
(`checks.columns.column_moments`, docs/theory/columns.md). The value is the yield stress over the
factor, so that the safety is the factor.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import isfinite, pi
from typing import Any

from checks.columns.column_limits import Plane, planes_of
from checks.columns.column_moments import CrookedColumn, crooked_columns, crookedness
from checks.columns.stability import worst_compression
from checks.design.data import Part
from checks.part.derived import Heading, Kind, load_case, numbers, yield_stress
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import BarSymbols, Column, Derivation, Given, Item, Section, Step, Sum
from checks.result.verdict import Check

CROOKED = Kind(
    name="buckling",
    quantity="crooked bar {}",
    demand="stress at the edge, with moments grown by the compression",
    limit="yield stress",
    require="static",
    source="[columns](../theory/columns.md)",
)
KINDS = (CROOKED,)

_THEORY = "docs/theory/columns.md"
_BENT = "Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 1.11"
_ALMOST = 1 - 1e-9  # of a critical force: a root that is sought ends there
# Other settings that the page's what-if goes between: of the length, and of the yield stress.
_BESIDE = (0.0, 1 / 2000, 1 / 1000, 1 / 500, 1 / 250, 1 / 100, 1 / 50)
_YIELDS = (0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0)


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """The edge of the part, crooked in each plane, under the loads that make it yield."""
    part, loads = loaded.part, loaded.loads
    if worst_compression(part, loads) is None:
        return
    planes = planes_of(loaded.design, part)
    for column in crooked_columns(part, loads, planes, loaded.stated.mass):
        factor, row, place = column.load_factor(part.material.yield_stress)
        position = int(column.positions[row])
        yield loaded.derived(
            _heading(loaded, column, factor, row, place),
            position,
            _derivation(loaded, position, column, factor, row, place),
        )


def charts(loaded: LoadedPart) -> dict[str, Any]:
    """Data of "crooked": safeties at other eccentricities and yield stresses.

    own             mm, the part's eccentricity
    eccentricities  plane -> [mm, safety], rising
    yields          plane -> [MPa, safety], rising

    Empty for a part that is never compressed.
    """
    part, loads = loaded.part, loaded.loads
    if worst_compression(part, loads) is None:
        return {}
    own, yields = part.column.eccentricity, part.material.yield_stress
    planes = planes_of(loaded.design, part)
    beside = sorted({own, *(float(f"{share * planes[0].own:.1g}") for share in _BESIDE)})
    columns = crooked_columns(part, loads, planes, loaded.stated.mass)
    return {
        "crooked": {
            "own": own,
            "eccentricities": {
                column.plane.name: [
                    [one, float(replace(column, beside=one).load_factor(yields)[0])]
                    for one in beside
                ]
                for column in columns
            },
            "yields": {
                column.plane.name: [
                    [share * yields, float(column.load_factor(share * yields)[0])]
                    for share in _YIELDS
                ]
                for column in columns
            },
        }
    }


def _heading(
    loaded: LoadedPart, column: CrookedColumn, factor: float, row: int, place: int
) -> Heading:
    force, critical = float(column.force[row]), float(column.critical[0])
    said = "beyond what the column carries: no state of rest under the load itself"
    if force < column.critical.min():
        stress = column.stress(1.0, slice(row, row + 1))[0, place]
        said = f"{stress:.4g} MPa under the load itself"
    beside = f", {column.beside:.3g} mm beside the middle" if column.beside else ""
    return Heading(
        kind=CROOKED,
        of=column.plane.name,
        place=_place(column, place),
        basis=f"F/A + M/W with moments grown by 1/(1 - F/F_cr), F_cr = {critical:.4g} N; value is "
        f"the yield stress over the factor {factor:.4g} on all loads at which the edge yields",
        note=f"{said}; axial {force / column.areas[place]:.4g} MPa, F/F_cr "
        f"{force / critical:.3g}, crooked by {crookedness(loaded.part, column.plane):.3g} mm "
        f"({_source(loaded.part)}){beside}",
        plane=column.plane.name,
        span=column.plane.length,
    )


def _place(column: CrookedColumn, place: int) -> str:
    return f"{column.sections[place].name} at {column.plane.own * column.places[place]:.4g} mm"


def _source(part: Part) -> str:
    if part.column.crookedness is not None:
        return "stated"
    if part.column.curve is not None:
        return f"Eurocode 3, curve {part.column.curve}"
    return "L/1000, assumed"


def _derivation(
    loaded: LoadedPart, position: int, column: CrookedColumn, factor: float, row: int, place: int
) -> Derivation:
    least = float(column.critical.min())
    bound = factor * float(column.force[row]) >= _ALMOST * least
    items = [yield_stress(loaded.part), *_pressed(column, row, place)]
    items += _by_buckling(least) if bound else _by_yield(column, factor, row, place)
    demand = Step("sigma", "the yield stress over the factor", "S_y/n", "MPa", main=True)
    return Derivation(
        cases=(load_case(loaded.part, loaded.loads, position),),
        sections=(
            Section("Limit, and how far all loads may grow", tuple(items)),
            Section("Demand", (demand,)),
        ),
        value="sigma",
        limit="S_y",
        equal=() if bound else (("S_n", "S_y"),),
        bars=BarSymbols(words="a formula has no mesh"),
    )


def _pressed(column: CrookedColumn, row: int, place: int) -> list[Item]:
    return [
        Given("F", "compression", float(column.force[row]), "N", "the loads", main=True),
        Given(
            "A",
            f"area of {_place(column, place)}",
            float(column.areas[place]),
            "mm2",
            "the part's shape",
        ),
        Given("x", "place over the length", float(column.places[place])),
    ]


def _by_buckling(critical: float) -> list[Item]:
    """It buckles before its edge yields."""
    return [
        Given("F_cr", "lowest buckling force of both planes", critical, "N", _THEORY),
        Step("n", "factor on all loads: it buckles before its edge yields", "F_cr/F", main=True),
    ]


def _by_yield(column: CrookedColumn, factor: float, row: int, place: int) -> list[Item]:
    items: list[Item] = [
        Given("n", "factor on all loads, sought until the edge yields", factor, "", "root search",
              main=True)
    ]  # fmt: skip
    terms = ["n*F/A"]
    for number, side in enumerate((column.plane, column.other), 1):
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
