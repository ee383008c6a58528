"""A derivation in words, as the page shows it, and on the terminal: in short or with everything."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import floor, inf, isfinite, log10

import numpy as np
from rich.cells import cell_len

from checks.result.derivation import (
    Derivation,
    HandComparison,
    Item,
    LoadCase,
    Section,
    Step,
    Sum,
    Superposition,
)
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
from checks.result.words import brief, clean, need_text, safety_text, value_and_whole_bar, where
from reports.terminal import labelled, line_width

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


_LEADING = 2  # unit loads that are named of a superposition
_SHORT = 60  # characters of a formula with numbers put in, in the short telling
_SOURCE = 44  # characters of a source there
_SMALL = 5e-4  # of the largest component: smaller ones are not told there
_PAGES = "docs/"  # sources that are told with everything only
_SAME = " "  # the label of a line that goes on under the label before
_HANGING = 2  # columns by which lines hang that have no label
_AS_IT_IS = "  "  # of a line of a table
_INDENT = 9  # columns of a label
_NAME = 36  # columns of a row's name
_LONGEST = 3000  # characters of a text


def derivation_text(
    check: Check, title: str, *, everything: bool = False, width: int | None = None
) -> str:
    """Derivation of a check's number as plain lines of at most `width` columns.

    title  of the check, as the verdict has it
    width  None: the terminal's width (COLUMNS counts), and 100 when piped
    """
    width = line_width(width)
    lines = labelled("", headline(check, title), width - _HANGING)
    derivation = check.derivation
    if derivation is None:
        told = "this check has no derivation"
        return "\n".join([*lines, *labelled("", told, width - _HANGING)]) + "\n"
    body = _everything(derivation, width) if everything else _main(derivation)
    for label, text in (
        *_loads(derivation, everything=everything),
        *body,
        *_ends(check, everything=everything),
    ):
        if label == _AS_IT_IS and cell_len(text) <= width - _INDENT:
            lines.append(" " * _INDENT + text)
        else:
            lines += labelled(label, brief(text, _LONGEST), width - (0 if label else _HANGING))
    return "\n".join(lines) + "\n"


def headline(check: Check, title: str) -> str:
    """Value, limit, need and status of a check in a sentence."""
    value = " ".join(filter(None, value_and_whole_bar(check)))
    unit = f" {check.unit}".rstrip()
    return (
        f"{brief(check.part, 40)} {brief(title, 60)}: {brief(check.quantity, 120)} {value}{unit} "
        f"of {number_text(check.limit)}{unit}, safety "
        f"{safety_text(check.safety, check.required)} ({need_text(check.required)} required): "
        f"{check.status}; {brief(check.method, 40)}; {brief(where(check), 300)}"
    )


def _loads(derivation: Derivation, *, everything: bool) -> list[tuple[str, str]]:
    cases = derivation.cases if everything else derivation.cases[:2]
    found: list[tuple[str, str]] = []
    for case in cases:
        name = f"{shown_symbol(case.symbol)}: " if case.symbol else ""
        acting = "; ".join(case_texts(case, whole=everything))
        place = f"{name}{brief(case.cycle, 30)}, {brief(case.position, 60)}"
        label = _SAME if found else "loads"
        found.append((label, f"{place}: {acting}" if acting else place))
    left = len(derivation.cases) - len(cases)
    if left:
        found.append((_SAME, f"and {left} more position{'s' if left > 1 else ''}"))
    return found


def _main(derivation: Derivation) -> list[tuple[str, str]]:
    """Essentials of a number: the stresses, then the main formulas of each section in a line."""
    stresses = [item for item in derivation.items if isinstance(item, Superposition)]
    found = [
        ("stress" if item is stresses[0] else _SAME, _leading(item, parts=item is stresses[0]))
        for item in stresses[:2]
    ]
    for section, paragraph in zip(_filled(derivation), paragraphs(derivation), strict=True):
        told = [
            _in_short(line)
            for item, line in zip(section.items, paragraph.lines, strict=True)
            if line.main and not isinstance(item, Superposition)
        ]
        if told:
            found.append((_label(section.title), "; ".join(told)))
    return found


def _filled(derivation: Derivation) -> list[Section]:
    return [section for section in derivation.sections if section.items]


_LABELS = (
    ("limit", "limit"), ("demand", "demand"), ("stress", "stress"), ("amplitude", "cycle"),
    ("on the", "plane"), ("safety", "safety"),
)  # fmt: skip


def _label(title: str) -> str:
    folded = title.casefold()
    return next((label for start, label in _LABELS if folded.startswith(start)), "")


def _leading(item: Superposition, *, parts: bool) -> str:
    """The stress; with `parts` also the unit loads that make the most of it."""
    largest = max(map(abs, item.stress), default=0.0)
    sizes = ", ".join(
        f"{name} {number_text(one)}"
        for name, one in zip(COMPONENTS, item.stress, strict=True)
        if abs(one) > _SMALL * largest
    )
    told = f"{shown_symbol(item.symbol)} = [{sizes or '0'}] MPa"
    if not parts:
        return told
    pairs = sorted(zip(shares_of(item), item.loads, strict=True), key=lambda pair: -abs(pair[0]))
    made = [f"{brief(load.name, 40)} {number_text(share)}" for share, load in pairs[:_LEADING]]
    if len(pairs) > _LEADING:
        rest = sum(share for share, _ in pairs[_LEADING:])
        made.append(f"{len(pairs) - _LEADING} others {number_text(rest)}")
    return f"{told}, its σ_vM = {' + '.join(made)}".replace("+ −", "− ") if made else told


def _in_short(line: Line) -> str:
    """Meaning of an item, its formula and its value; numbers put in where they are few."""
    unit = f" {line.unit}".rstrip()
    said = line.meaning.partition(":")[0]
    known = line.source and _PAGES not in line.source
    source = f" [{brief(line.source, _SOURCE)}]" if known else ""
    if not line.formula:
        return f"{said}: {line.symbol} = {line.value}{unit}{source}"
    numbers = f" = {line.numbers}" if line.numbers and len(line.numbers) <= _SHORT else ""
    return f"{said}: {line.symbol} = {line.formula}{numbers} = {line.value}{unit}{source}"


def _told(line: Line) -> str:
    unit = f" {line.unit}".rstrip()
    source = f" [{line.source}]" if line.source else ""
    if not line.formula:
        return f"{line.symbol} = {line.value}{unit}: {line.meaning}{source}"
    numbers = f" = {line.numbers}" if line.numbers else ""
    return f"{line.symbol} = {line.formula}{numbers} = {line.value}{unit}: {line.meaning}{source}"


def _everything(derivation: Derivation, width: int) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for paragraph in paragraphs(derivation):
        found.append(("", f"{paragraph.title}:"))
        found += _tables(paragraph, width - _INDENT)
        found += [(_SAME, _told(line)) for line in paragraph.lines]
    found += [("where", text) for text in legend(derivation)]
    return [*found, *(("note", note) for note in derivation.notes)]


def _tables(paragraph: Paragraph, width: int) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for table in paragraph.tables:
        found.append((_SAME, table.caption))
        found += [(_AS_IT_IS, line) for line in _aligned(table, width)]
    return found


def _aligned(table: SumTable, width: int) -> list[str]:
    """A table in columns; where it would be too wide, a sentence per row."""
    heads = tuple(head.partition(":")[0] for head in table.heads)
    rows = [tuple(clean(cell) for cell in row) for row in (heads, *table.rows, table.total)]
    names = [brief(row[0], _NAME) for row in rows]
    columns = list(zip(*(row[1:] for row in rows), strict=True))
    wide = [max(cell_len(cell) for cell in column) for column in columns]
    first = max(cell_len(name) for name in names)
    if first + sum(wide) + 2 * len(wide) <= width:
        return [
            name
            + " " * (first - cell_len(name))
            + "".join(
                "  " + " " * (w - cell_len(cell)) + cell
                for w, cell in zip(wide, row[1:], strict=True)
            )
            for name, row in zip(names, rows, strict=True)
        ]
    return [
        f"{name}: "
        + ", ".join(f"{head} {cell}" for head, cell in zip(heads[1:], row[1:], strict=True) if cell)
        for name, row in zip(names[1:], rows[1:], strict=True)
    ]


def _by_hand(one: HandComparison, everything: bool) -> str:
    unit = f" {one.unit}".rstrip()
    formula = f", {one.formula}" if everything else ""
    hand, model = number_text(one.hand), number_text(one.model)
    return f"{one.quantity}: {hand}{unit} by hand{formula}, {model}{unit} by the model"


def _ends(check: Check, *, everything: bool) -> list[tuple[str, str]]:
    """Bars, hand checks, numbers without a formula, and the rule of the status."""
    derivation = check.derivation
    assert derivation is not None
    found = [("bars", "; ".join(bar_texts(check, formulas=everything)))]
    if derivation.compared:
        found.append(
            ("by hand", "; ".join(_by_hand(one, everything) for one in derivation.compared))
        )
    if derivation.unproved:
        found.append(("solver", derivation.unproved))
    *ends, rule = status_texts(check)
    return [*found, ("verdict", f"{rule}: {'; '.join(ends)}")]
