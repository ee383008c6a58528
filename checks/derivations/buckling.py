"""Elastic buckling by eigenvalues, of a solid and of the linkage: what no formula gives."""

from math import inf

from checks.columns.column_limits import planes_of
from checks.columns.linkage_search import LinkageMode
from checks.columns.stability import axial_compression, judged_columns
from checks.design.data import Design
from checks.part.derived import load_case, position_of
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import (
    BARS,
    BarSymbols,
    Derivation,
    Given,
    HandComparison,
    Item,
    LoadCase,
    Section,
    Step,
)
from checks.result.formulas import number_text
from checks.result.verdict import Check
from checks.stress.stress_result import ElasticLoad
from fem.buckling import BucklingMode

_ONE = Given("one", "the load itself", 1.0, "", "at 1 it buckles", main=True)


def elastic_share(loaded: LoadedPart, load: ElasticLoad) -> Derivation:
    """Of the share of the elastic buckling load by a rung below the solid."""
    return Derivation(
        cases=(load_case(loaded.part, loaded.loads, load.position),),
        sections=(
            Section(f"Demand: {load.words}", tuple(load.explain())),
            Section("Limit", (_ONE,)),
        ),
        value="share",
        limit="one",
        unproved=load.unproved,
        compared=tuple(_euler_alone(loaded, load.position, load.share)),
    )


def solid_share(loaded: LoadedPart, check: Check, mode: BucklingMode, unknowns: int) -> Derivation:
    """Of the share of the elastic buckling load of a solid."""
    loads = loaded.loads
    position = position_of(loads, check)
    own = [
        Given(symbol, meaning, size, "", "docs/theory/buckling.md")
        for symbol, meaning, size in (
            ("e_num", "error bar of the eigenvalue", check.numerical - check.sampling),
            ("b_lo", "model band below: stiff forks", check.below - check.loads_below),
        )
        if 0.0 < size < inf
    ]
    said = {item.symbol for item in own}
    return Derivation(
        cases=(load_case(loaded.part, loads, position),),
        sections=(
            Section("Demand", tuple(_factor(mode.factor, f"{mode.plane} mode", "buckling.md"))),
            Section("Limit", (_ONE,)),
            *([Section(BARS, tuple(own))] if own else []),
        ),
        value="share",
        limit="one",
        unproved=f"the factor is the lowest eigenvalue of {unknowns} unknowns, K x = −λ K_G x with "
        "the stress of this position in K_G: no formula gives it or its own error bars",
        compared=tuple(_euler_alone(loaded, position, check.value)),
        bars=BarSymbols(
            numerical="e_num" if "e_num" in said else "",
            below="b_lo" if "b_lo" in said else "",
            words="estimated error of its lowest modes, how far the factor moves from mesh to "
            "mesh, and what a count of all lower ones leaves; below, the fixity of forks: "
            "docs/theory/buckling.md",
        ),
    )  # fmt: skip


def linkage_share(design: Design, mode: LinkageMode, check: Check) -> Derivation:
    """Of the share of the load under which the linkage buckles as a frame."""
    items = _factor(mode.factor, f"{mode.plane} mode of the linkage", "linkage_frames.md")
    compared: tuple[HandComparison, ...] = ()
    notes: tuple[str, ...] = ()
    if mode.body is not None and mode.effective_length is not None:
        items.append(
            Given("N", f"compression of {mode.body}, whose strain is the largest share of the mode",
                  mode.compression, "N", "the loads")
        )  # fmt: skip
        compared, notes = _alone(design, mode, check.value)
    bars, widths = _bars(mode)
    return Derivation(
        cases=(LoadCase("", mode.cycle, mode.position, mode.index, ()),),
        sections=(
            Section("Demand", tuple(items)),
            Section("Limit", (_ONE,)),
            Section(BARS, tuple(widths)),
        ),
        value="share",
        limit="one",
        unproved="the factor is the lowest eigenvalue of a frame of all bars and rigid bodies "
        "together: no formula gives it",
        compared=compared,
        bars=bars,
        notes=notes,
    )


def _bars(mode: LinkageMode) -> tuple[BarSymbols, list[Item]]:
    """From 8 to 16 pieces of each bar; below, forks that share all tilts."""
    page = "docs/theory/linkage_frames.md"
    below = "share" if mode.forks is None else "0*share"
    items: list[Item] = [
        Given("e", "change of the factor from 8 to 16 pieces of each bar", mode.error, "", page),
        Step("e_num", "numerical error bar", "share*e/lam"),
    ]
    if mode.forks is None and mode.stiff_factor is not None:
        said = "lowest factor with forks that share all tilts"
        items.append(Given("lam_2", said, mode.stiff_factor, "", page))
        below = "max(0, share - 1/lam_2)"
    items.append(
        Step(
            "b_lo",
            "model band below: stiff forks"
            if mode.forks is None
            else f"model band below: forks stated as {mode.forks}",
            below,
        )
    )
    return BarSymbols("e_num", below="b_lo"), items


def _factor(factor: float, what: str, page: str) -> list[Item]:
    return [
        Given("lam", f"lowest factor on all loads, {what}", factor, "",
              f"eigenvalue: docs/theory/{page}", main=True),
        Step("share", "share that the loads are of those that buckle it", "1/lam", main=True),
    ]  # fmt: skip


def _alone(
    design: Design, mode: LinkageMode, share: float
) -> tuple[tuple[HandComparison, ...], tuple[str, ...]]:
    """The share of Euler's force of the bar that is bent most, hinged between its own pins.

    Where its shape has no such length, a note says so in its place.
    """
    assert mode.effective_length is not None
    shape = next(p.geometry for p in design.parts.values() if p.body == mode.body)
    if shape.link(0.3) is None:
        told = f"no comparison with Euler's force: {mode.body} is no bar between two pins"
        return (), (told,)
    length = shape.length
    compared = HandComparison(
        f"share of Euler's force of {mode.body} alone, hinged at its pins",
        share * (length / mode.effective_length) ** 2,
        share,
        "",
        f"N·L²/(π²·E·I) with N = {number_text(mode.compression)} N and L = "
        f"{number_text(length)} mm; as part of the linkage it is as long as "
        f"{number_text(mode.effective_length)} mm",
    )
    return (compared,), ()


def _euler_alone(loaded: LoadedPart, position: int, share: float) -> list[HandComparison]:
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
            HandComparison(
                f"share of Euler's force as a hinged column, {plane.name}",
                force / critical,
                share,
                "",
                f"F/F_cr = {number_text(force)} N / {number_text(critical)} N, F_cr = π²·E·I/L² "
                f"with L = {number_text(case.length)} mm of {case.section.name}",
            )
        )
    return found
