"""Derivations as the page shows them, and the filters of derivation.html.j2."""

import re
from dataclasses import dataclass

from markupsafe import Markup, escape

from checks.result.derivation import LoadCase
from checks.result.formulas import number_text, shown_symbol
from checks.result.verdict import Check
from checks.result.words import brief, clean
from reports.derivation_words import Paragraph, bar_texts, legend, paragraphs, status_texts

_SUBSCRIPT = re.compile(r"(?<![A-Za-z])([A-Za-zα-ωΑ-Ω]{1,2})_([A-Za-z0-9α-ω]+)")


@dataclass(frozen=True)
class DerivationView:
    """All of a derivation as text, as the page shows it.

    cases  (symbol, cycle, position, index, rows of what acts) of each position
    """

    headline: str
    cases: tuple[tuple[str, str, str, int, tuple[tuple[str, ...], ...]], ...]
    paragraphs: tuple[Paragraph, ...]
    legend: tuple[str, ...]
    bars: tuple[str, ...]
    compared: tuple[tuple[str, ...], ...]
    unproved: str
    notes: tuple[str, ...]
    rule: str
    ends: tuple[str, ...]


def view_of(check: Check) -> DerivationView | None:
    """A check's derivation as text; None for a check that has none."""
    derivation = check.derivation
    if derivation is None:
        return None
    *ends, rule = status_texts(check)
    unit = f" {check.unit}".rstrip()
    return DerivationView(
        f"{brief(check.quantity, 120)} = {number_text(check.value)}{unit} of "
        f"{number_text(check.limit)}{unit}",
        tuple(
            (shown_symbol(case.symbol), case.cycle, case.position, case.index, _acting(case))
            for case in derivation.cases
        ),
        tuple(paragraphs(derivation)),
        tuple(legend(derivation)),
        tuple(bar_texts(check)),
        tuple(
            (one.quantity, number_text(one.hand), number_text(one.model), one.unit, one.formula)
            for one in derivation.compared
        ),
        derivation.unproved,
        derivation.notes,
        rule,
        tuple(ends),
    )


def _acting(case: LoadCase) -> tuple[tuple[str, ...], ...]:
    """Interface, point, size and components of each force and couple."""
    return tuple(
        (
            acts.interface,
            acts.on,
            number_text(acts.force),
            *(number_text(acts.wrench[k]) for k in (0, 1, 3, 4, 5)),
        )
        for acts in case.acting
    )


def formula_markup(text: object) -> Markup:
    """Text with its subscripts set as such, everything else escaped.

    >>> str(formula_markup("σ_a/S_e < 1"))
    'σ<sub>a</sub>/S<sub>e</sub> &lt; 1'
    """
    return Markup(_SUBSCRIPT.sub(r"\1<sub>\2</sub>", str(escape(clean(text)))))


FILTERS = {"derivation": view_of, "formula": formula_markup}  # that derivation.html.j2 uses
