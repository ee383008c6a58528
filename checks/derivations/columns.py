"""Columns by the handbook, as docs/theory/columns.md has them."""

from checks.columns.column_limits import UNKNOWN_CURVE, ColumnCase, Plane, planes_of
from checks.columns.stability import (
    axial_compression,
    column_quantity,
    judged_columns,
    worst_compression,
)
from checks.design.data import Part
from checks.handbook.column_curves import IMPERFECTION, ROBERTSON
from checks.part.derived import load_case, yield_stress, young
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import BARS, Bars, Comparison, Derivation, Given, Item, Section, Step
from checks.result.formulas import number_text

_THEORY = "docs/theory/columns.md"
_EULER = "Euler; Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.1"
_JOHNSON = "Shigley, 10th ed., section 4-13"
_PERRY = "Ayrton and Perry 1886, Robertson 1925"
_EUROCODE = "EN 1993-1-1:2005, 6.3.1.2"


def columns(loaded: LoadedPart) -> dict[str, Derivation]:
    """Of the columns in both planes, by the quantity of their checks."""
    part, loads = loaded.part, loaded.loads
    worst = worst_compression(part, loads)
    if worst is None:
        return {}
    force = float(axial_compression(part, loads)[worst])
    found = {}
    for plane in planes_of(loaded.design, part):
        judged = judged_columns(part, plane, force)
        case, _, safety = judged.deciding
        bars, items = Bars(words="a formula has no mesh"), list[Item]()
        if judged.between:
            bars = Bars(below="b_lo", words="the forks are between hinged and clamped")
            items = [
                Given("n_2", "safety with the stiffest ends", judged.stiffest, "", _THEORY),
                Step("b_lo", "model band below", "sigma*(1 - S/sigma/n_2)", "MPa"),
            ]
        found[column_quantity(plane)] = Derivation(
            cases=(load_case(part, loads, worst),),
            sections=(
                Section("Demand", tuple(_demand(case, force))),
                Section("Limit", tuple(_limit(part, plane, case))),
                Section("Other limits of the same column", tuple(_others(part, plane, case))),
                Section(BARS, tuple(items)),
            ),
            value="sigma",
            limit="S",
            bars=bars,
            notes=(f"safety {safety:.4g}: what decides is the least of all sections' limits",),
        )
    return found


def _demand(case: ColumnCase, force: float) -> list[Item]:
    return [
        Given("F", "largest compression over all cycles", force, "N", "the loads", main=True),
        Given("A", f"area of the section {case.section.name}", case.section.area, "mm2",
              "the part's shape"),
        Step("sigma", "axial stress", "F/A", "MPa", main=True),
    ]  # fmt: skip


def _limit(part: Part, plane: Plane, case: ColumnCase) -> list[Item]:
    curve = part.column.curve
    governs = case.law(curve)
    if curve is not None:
        formula, source, last = "S_y*chi", _EUROCODE, _curve(curve)
    elif governs == "Euler":
        formula, source, last = "sigma_E", _EULER, []
    else:
        formula, source, last = _johnson(), _JOHNSON, []
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


def _johnson() -> str:
    return "S_y*(1 - S_y*lam^2/(4*pi^2*E))"


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


def _others(part: Part, plane: Plane, case: ColumnCase) -> list[Item]:
    """Limits that do not decide, beside the one that does."""
    found: list[Item] = []
    curve, strength = part.column.curve, case.strength
    if strength.johnson is not None and (curve is not None or strength.governs == "Euler"):
        found.append(Step("S_J", "by Johnson", _johnson(), "MPa", _JOHNSON))
    if part.column.crookedness is not None and case.whole:
        built_up, depth = plane.built_up(case.section)
        found += [
            Given("e_0", "crookedness", part.column.crookedness, "mm", "the design"),
            Given("W", "section modulus of the whole column", built_up / depth, "mm3"),
            Step("eta_P", "stress of the crookedness over the axial", "e_0*A/W", "", _PERRY),
        ]
    else:
        said = "crookedness of common steel bars"
        found.append(Step("eta_P", said, f"{ROBERTSON:g}*lam", "", _PERRY))
    found += [
        Step("h", "half sum", "(S_y + (1 + eta_P)*sigma_E)/2", "MPa", _PERRY),
        Step("S_P", "by Perry and Robertson", "S_y*sigma_E/(h + sqrt(h^2 - S_y*sigma_E))", "MPa",
             _PERRY),
    ]  # fmt: skip
    if curve is None:
        found += [
            *_curve(UNKNOWN_CURVE),
            Step("S_c", f"by Eurocode 3, curve {UNKNOWN_CURVE}", "S_y*chi", "MPa", _EUROCODE),
        ]
    return found


def euler_alone(loaded: LoadedPart, position: int, share: float) -> list[Comparison]:
    """The share that the compression is of Euler's force of the part as a column, by hand."""
    part = loaded.part
    if not part.geometry.sections:
        return []
    force = float(axial_compression(part, loaded.loads)[position])
    if not force > 0:
        return []
    found = []
    for plane in planes_of(loaded.design, part):
        case = judged_columns(part, plane, force).deciding[0]
        critical = case.strength.euler * case.section.area
        found.append(
            Comparison(
                f"share of Euler's force as a hinged column, {plane.name}",
                force / critical,
                share,
                "",
                f"F/F_cr = {number_text(force)} N / {number_text(critical)} N, F_cr = π²·E·I/L² "
                f"with L = {number_text(case.length)} mm of {case.section.name}",
            )
        )
    return found
