"""A derivation in words: what stands on a page and on the terminal, as plain text."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import floor, inf, isfinite, log10

import numpy as np

from checks.result.derivation import Derivation, Item, LoadCase, Step, Sum, Superposition
from checks.result.formulas import (
    COMPONENTS,
    FUNCTIONS,
    FormulaError,
    Value,
    evaluate,
    functions_of,
    number_text,
    shown_symbol,
    substituted,
    symbolic,
    vector_text,
)
from checks.result.verdict import Check, Status
from checks.result.words import brief, need_text

_DIGITS = 5  # of the largest number of a superposition
_ROWS = 400  # of a table of a derivation
_CLOSE = "…"


@dataclass(frozen=True)
class Line:
    """One item as text.

    formula  with symbols; empty for what was given
    numbers  the same with numbers put in
    """

    symbol: str
    meaning: str
    formula: str
    numbers: str
    value: str
    unit: str
    source: str
    main: bool


@dataclass(frozen=True)
class SumTable:
    """A superposition or a sum as a table: the last row is the total."""

    caption: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    total: tuple[str, ...]


@dataclass(frozen=True)
class Paragraph:
    """A section as text: lines that follow each other, and tables."""

    title: str
    lines: tuple[Line, ...]
    tables: tuple[SumTable, ...]


def paragraphs(derivation: Derivation) -> list[Paragraph]:
    """All sections as text; an item without a value says "no value"."""
    found = []
    for section in derivation.sections:
        lines, tables = [], []
        for item in section.items:
            if isinstance(item, Superposition | Sum):
                tables.append(_table(item, derivation))
            lines.append(_line(item, derivation))
        if section.items:
            found.append(Paragraph(section.title, tuple(lines), tuple(tables)))
    return found


def _values(derivation: Derivation) -> dict[str, Value]:
    try:
        return dict(derivation.values)
    except FormulaError:
        return {}


def _line(item: Item, derivation: Derivation) -> Line:
    scope = _values(derivation)
    value = scope.get(item.symbol)
    formula = numbers = ""
    if isinstance(item, Step):
        formula, numbers = symbolic(item.formula), substituted(item.formula, scope)
    if isinstance(item, Sum):
        formula = f"Σ {symbolic(item.formula)}"
    if isinstance(item, Superposition):
        formula = "Σ c_j·s_j over the unit loads j"
    if numbers == formula:
        numbers = ""
    return Line(
        shown_symbol(item.symbol),
        item.meaning,
        formula,
        numbers,
        _text(value),
        item.unit,
        _source(item),
        item.main,
    )


def _text(value: Value | None) -> str:
    if value is None:
        return "no value"
    return number_text(value) if isinstance(value, float) else vector_text(value)


def _source(item: Item) -> str:
    where = item.position if isinstance(item, Superposition) else ""
    return "; ".join(text for text in (where, item.source) if text)


def _table(item: Superposition | Sum, derivation: Derivation) -> SumTable:
    if isinstance(item, Superposition):
        return _superposed(item)
    scope = _values(derivation)
    heads = (
        "row",
        *(f"{shown_symbol(c.symbol)}: {c.meaning} {c.unit}".strip() for c in item.columns),
    )
    rows = []
    for row, (name, own) in enumerate(zip(item.names, item.scopes(scope), strict=True)):
        if row == _ROWS:
            rows.append((f"{len(item.names) - _ROWS} more rows", *([_CLOSE] * len(heads))))
            break
        sizes = (number_text(column.values[row]) for column in item.columns)
        rows.append((name, *sizes, _text(_of_row(item, own))))
    total = (f"sum: {shown_symbol(item.symbol)}", *([""] * len(item.columns)))
    return SumTable(
        f"{item.meaning}: {shown_symbol(item.symbol)} = Σ {symbolic(item.formula)}",
        (*heads, f"{symbolic(item.formula)} {item.unit}".strip()),
        tuple(rows),
        (*total, _text(scope.get(item.symbol))),
    )


def _of_row(item: Sum, scope: dict[str, Value]) -> Value | None:
    try:
        return evaluate(item.formula, scope)
    except FormulaError:
        return None


def _superposed(item: Superposition) -> SumTable:
    heads = ("unit load", "its size c", *(f"c·s_{name}" for name in COMPONENTS), "of σ_vM")
    shares = shares_of(item)
    digits = _decimals(item)

    def rounded(value: float) -> str:
        return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")

    rows = [
        (
            load.name,
            f"{number_text(load.value)} {load.unit}",
            *(rounded(one) for one in load.contribution),
            rounded(share),
        )
        for load, share in zip(item.loads, shares, strict=True)
    ]
    total = (
        f"sum: {shown_symbol(item.symbol)}",
        "",
        *(rounded(one) for one in item.stress),
        rounded(float(sum(shares))),
    )
    return SumTable(
        f"{item.meaning}, {item.position}: what each unit load adds, MPa ({item.source})",
        heads,
        tuple(rows),
        total,
    )


def _decimals(item: Superposition) -> int:
    """Decimals with which the largest number of a superposition has five digits: one to four."""
    sizes = [abs(one) for load in item.loads for one in load.contribution]
    largest = max([*sizes, *map(abs, item.stress)], default=0.0)
    if not 0 < largest < inf:
        return 1
    return int(min(max(_DIGITS - 1 - floor(log10(largest)), 1), 4))


def shares_of(item: Superposition) -> list[float]:
    """Shares of the unit loads in the von Mises stress, MPa: their sum is that stress.

    A contribution counts in the direction of the whole stress, as the gradient of von Mises has it.
    """
    scale = max(map(abs, item.stress))
    if not 0 < scale < inf:
        return [0.0] * len(item.loads)
    xx, yy, zz, xy, yz, zx = (one / scale for one in item.stress)
    third = (xx + yy + zz) / 3
    own = np.array([xx - third, yy - third, zz - third])
    size = float(np.sqrt(1.5 * (own @ own) + 3 * (xy**2 + yz**2 + zx**2)))
    if not size > 0:
        return [0.0] * len(item.loads)
    along = np.concatenate([1.5 * own, 3 * np.array([xy, yz, zx])]) / size
    return [float(along @ np.array(load.contribution)) for load in item.loads]


def case_texts(case: LoadCase, *, whole: bool = True) -> Iterator[str]:
    """Loads at each interface, in words; not `whole`: the sizes of forces and couples only."""
    for acts in case.acting:
        x, y, _, *couples = acts.wrench
        where = f" ({brief(acts.on, 30)})" if acts.on and acts.on != acts.interface else ""
        text = f"{brief(acts.interface, 30)}{where} {number_text(acts.force)} N"
        if whole:
            text += f" = [{number_text(x)}, {number_text(y)}]"
        turns = [
            f"M_{axis} {number_text(couple)} N mm"
            for axis, couple in zip("xyz", couples, strict=True)
            if couple and abs(couple) > 1e-9 * acts.force
        ]
        yield ", ".join([text, *turns])


def legend(derivation: Derivation) -> list[str]:
    """Meanings of the functions in the formulas, each once."""
    names: dict[str, None] = {}
    for item in derivation.items:
        if isinstance(item, Step | Sum):
            names |= dict.fromkeys(functions_of(item.formula))
    return [FUNCTIONS[name].meaning for name in names if FUNCTIONS[name].meaning]


def bar_texts(check: Check, *, formulas: bool = True) -> list[str]:
    """Source of each error bar; without `formulas` in words alone."""
    derivation = check.derivation
    assert derivation is not None
    unit = f" {check.unit}".rstrip()
    found = []
    for name, size, symbols in (
        ("numerical ±", check.numerical, derivation.bars.numerical),
        ("model +", check.model, derivation.bars.above),
        ("model −", check.below, derivation.bars.below),
    ):
        text = "infinite" if not isfinite(size) else f"{number_text(size)}{unit}"
        parts = [_bar_formula(derivation, symbol) for symbol in symbols.split()]
        if formulas and size and isfinite(size) and parts:
            text += f" = {' + '.join(parts)}"
        elif size and isfinite(size) and len(parts) > 1:
            shares = _shares(derivation, symbols.split())
            text += f" ({shares})" if shares else ""
        if size:
            found.append(f"{name}{text}")
    return [*(found or ["none"]), *([derivation.bars.words] if derivation.bars.words else [])]


def _shares(derivation: Derivation, symbols: Sequence[str]) -> str:
    """Terms of a bar that has several, the largest first; "" where a term has no value."""
    values, items = _values(derivation), {item.symbol: item for item in derivation.items}
    told = []
    for symbol in symbols:
        value = values.get(symbol)
        if not isinstance(value, float) or symbol not in items:
            return ""
        told.append((value, items[symbol].meaning))
    return ", ".join(f"{meaning} {number_text(value)}" for value, meaning in sorted(told)[::-1])


def _bar_formula(derivation: Derivation, symbol: str) -> str:
    item = next((item for item in derivation.items if item.symbol == symbol), None)
    if isinstance(item, Step):
        return substituted(item.formula, _values(derivation))
    return shown_symbol(symbol) if item is None else item.meaning


def status_texts(check: Check) -> list[str]:
    """Rule that gives the status, with numbers put in."""
    unit = f" {check.unit}".rstrip()
    need, limit = need_text(check.required), f"{number_text(check.limit)}{unit}"

    def against(sign: str, bars: Sequence[float], end: float) -> str:
        shown = [number_text(bar) if isfinite(bar) else "∞" for bar in bars if bar]
        sizes = f"{number_text(check.value)}{''.join(f' {sign} {bar}' for bar in shown)}"
        total = number_text(end * check.required) if isfinite(end) else f"{'−' * (end < 0)}∞"
        sizes = f"({sizes})" if shown else sizes
        return f"{sizes}·{need} = {total}{unit} {'≤' if holds else '>'} {limit}"

    holds = check.upper * check.required <= check.limit
    texts = [against("+", (check.numerical, check.model), check.upper)]
    if check.status is not Status.PASS:
        holds = check.lower * check.required <= check.limit
        texts.append(against("−", (check.numerical, check.below), check.lower))
    rule = {
        Status.PASS: "pass, as the upper end of the error bars holds the limit",
        Status.FAIL: "FAIL, as even the lower end of the error bars exceeds the limit",
        Status.UNDECIDED: "UNDECIDED, as the limit lies within the error bars",
    }[check.status]
    return [*texts, rule]
