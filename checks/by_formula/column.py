"""A part as a column in each plane, at the largest compression of all its cycles.

The limit that decides is the least of yield, Johnson and Euler, or the Eurocode 3 curve that the
part's column states. The required safety for buckling applies either way: no partial factor is
mixed into it (docs/theory/columns.md).
"""

from collections.abc import Iterator
from typing import Any

from checks.columns.column_limits import ColumnCase, Plane, planes_of
from checks.columns.stability import (
    JudgedColumns,
    axial_compression,
    judged_columns,
    worst_compression,
)
from checks.design.data import Part
from checks.handbook.column_curves import IMPERFECTION
from checks.part.derived import Heading, Kind, load_case, yield_stress, young
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import BARS, BarSymbols, Derivation, Given, Item, Section, Step
from checks.result.verdict import Check

COLUMN = Kind(
    name="buckling",
    quantity="column {}",
    demand="axial stress",
    limit="least of yield, Johnson and Euler, or a stated curve of Eurocode 3",
    require="buckling",
    source="Shigley, 4-12, 4-13; [columns](../theory/columns.md)",
)
KINDS = (COLUMN,)

_THEORY = "docs/theory/columns.md"
_EULER = "Euler; Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.1"
_JOHNSON = "Shigley, 10th ed., section 4-13"
_EUROCODE = "EN 1993-1-1:2005, 6.3.1.2"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Axial stress of the section with the least safety, in each plane."""
    worst = worst_compression(loaded.part, loaded.loads)
    if worst is None:
        return
    force = float(axial_compression(loaded.part, loaded.loads)[worst])
    for plane in planes_of(loaded.design, loaded.part):
        judged = judged_columns(loaded.part, plane, force)
        yield loaded.derived(
            _heading(loaded, plane, judged), worst, _derivation(loaded, worst, force, plane, judged)
        )


def not_checked(loaded: LoadedPart) -> Iterator[str]:
    """Why a part that has sections is not judged as a column."""
    if loaded.part.geometry.sections:
        largest = float(axial_compression(loaded.part, loaded.loads).max())
        if not largest > 0:
            how = "pulled at every position" if largest < 0 else "never compressed"
            yield f"it is {how}: there is no column to be checked"


def facts(loaded: LoadedPart) -> dict[str, float | str]:
    """The largest compression of a part over all cycles.

    Empty for a part that is never compressed or has no sections.
    """
    part, loads = loaded.part, loaded.loads
    worst = worst_compression(part, loads)
    if worst is None:
        return {}
    force = float(axial_compression(part, loads)[worst])
    where = f"{loads.cycle_names[worst]}, {loads.labels[worst]}"
    return {"largest compression [N]": force, "largest compression at": where}


def charts(loaded: LoadedPart) -> dict[str, Any]:
    """Data of the chart "column": the least safe one in each plane, at the largest compression.

    youngs_modulus, yield  MPa
    required     safety against buckling
    curve        Eurocode 3's, if the part states one
    cycle, position  of the largest compression
    force        cycle -> (n,) N, axial compression; below 0 it is tension
    planes       one entry each: section, its area (mm2), slenderness, the least slenderness that
                 stiffer ends could give, effective length (mm), axial stress (MPa), limit (MPa)
                 and its law

    Empty for a part that has no sections or is never compressed.
    """
    part, loads = loaded.part, loaded.loads
    worst = worst_compression(part, loads)
    if worst is None:
        return {}
    force = axial_compression(part, loads)
    column = {
        "youngs_modulus": part.material.youngs_modulus,
        "yield": part.material.yield_stress,
        "required": COLUMN.safety(loaded.required),
        "curve": part.column.curve,
        "cycle": loads.cycle_names[worst],
        "position": loads.labels[worst],
        "force": {name: force[columns].tolist() for name, columns in loads.cycles.items()},
        "planes": [
            _plane_data(part, plane, float(force[worst]))
            for plane in planes_of(loaded.design, part)
        ],
    }
    return {"column": column}


def _heading(loaded: LoadedPart, plane: Plane, judged: JudgedColumns) -> Heading:
    case, *_ = judged.deciding
    length = f"{case.length:.4g} mm"
    if not case.whole:
        length += " of its own"
    elif case.stepped:
        length += " as the stepped column"
    return Heading(
        kind=COLUMN,
        of=plane.name,
        place=case.section.name,
        basis=f"{case.law}; slenderness {case.strength.slenderness:.1f} "
        f"over {length}; Euler {case.strength.euler:.4g} MPa; value is axial stress",
        note=judged.told,
        plane=plane.name,
        span=plane.length if case.whole else 0.0,
    )


def _derivation(
    loaded: LoadedPart, worst: int, force: float, plane: Plane, judged: JudgedColumns
) -> Derivation:
    part = loaded.part
    case, _, safety = judged.deciding
    bars, items = BarSymbols(words="a formula has no mesh"), list[Item]()
    if judged.between:
        bars = BarSymbols(below="b_lo", words="the forks are between hinged and clamped")
        items = [
            Given("n_2", "safety with the stiffest ends", judged.stiffest, "", _THEORY),
            Step("b_lo", "model band below", "sigma*(1 - S/sigma/n_2)", "MPa"),
        ]
    return Derivation(
        cases=(load_case(part, loaded.loads, worst),),
        sections=(
            Section("Demand", tuple(_demand(case, force))),
            Section("Limit", tuple(_limit(part, plane, case))),
            Section(BARS, tuple(items)),
        ),
        value="sigma",
        limit="S",
        bars=bars,
        notes=(f"safety {safety:.4g}: what decides is the least of all sections' limits",),
    )


def _demand(case: ColumnCase, force: float) -> list[Item]:
    return [
        Given("F", "largest compression over all cycles", force, "N", "the loads", main=True),
        Given("A", f"area of the section {case.section.name}", case.section.area, "mm2",
              "the part's shape"),
        Step("sigma", "axial stress", "F/A", "MPa", main=True),
    ]  # fmt: skip


def _limit(part: Part, plane: Plane, case: ColumnCase) -> list[Item]:
    curve = part.column.curve
    governs = case.law
    if curve is not None:
        formula, source, last = "S_y*chi", _EUROCODE, _curve(curve)
    elif governs == "Euler":
        formula, source, last = "sigma_E", _EULER, []
    else:
        formula, source, last = "S_y*(1 - S_y*lam^2/(4*pi^2*E))", _JOHNSON, []
    return [
        yield_stress(part),
        young(part),
        Given("I", f"second moment of area, {plane.name}", plane.inertia(case.section), "mm4",
              "the part's shape"),
        *_length(case),
        Step("lam", "slenderness", "L/sqrt(I/A)", "", main=True),
        Step("sigma_E", "Euler's stress", "pi^2*E/lam^2", "MPa", _EULER, main=True),
        *last,
        Step("S", f"axial stress that the column carries, by {governs}", formula, "MPa", source,
             main=True),
    ]  # fmt: skip


def _length(case: ColumnCase) -> list[Item]:
    """The effective length: stated, or of the even column with the same lowest force."""
    if not case.whole:
        return [Given("L", "free length of this section by itself", case.length, "mm",
                      "the part's shape")]  # fmt: skip
    shape = "stepped, as its sections are" if case.stepped else "even"
    force = case.strength.euler * case.section.area
    return [
        Given("F_cr", f"lowest elastic buckling force of the whole column, {shape}", force, "N",
              f"root of its characteristic equation, its ends as stated: {_THEORY}"),
        Step("L", "effective length: of a hinged, even column with that force",
             "pi*sqrt(E*I/F_cr)", "mm"),
    ]  # fmt: skip


def _curve(curve: str) -> list[Item]:
    return [
        Given("alpha", f"imperfection of curve {curve}", IMPERFECTION[curve], "", _EUROCODE),
        Step("lam_1", "slenderness over that of yield", "sqrt(S_y/sigma_E)", "", _EUROCODE),
        Step("eta", "crookedness and residual stress", "alpha*max(0, lam_1 - 0.2)", "", _EUROCODE),
        Step("phi", "half sum", "(1 + eta + lam_1^2)/2", "", _EUROCODE),
        Step("chi", "share of yield", "min(1, 1/(phi + sqrt(phi^2 - lam_1^2)))", "", _EUROCODE),
    ]


def _plane_data(part: Part, plane: Plane, force: float) -> dict[str, Any]:
    judged = judged_columns(part, plane, force)
    case, stress, _ = judged.deciding
    return {
        "plane": plane.name,
        "section": case.section.name,
        "area": case.section.area,
        "slenderness": case.strength.slenderness,
        "stiffest": min(judged.held.strength.slenderness, case.strength.slenderness),
        "length": case.length,
        "stress": stress,
        "limit": case.limit,
        "law": case.law,
    }
