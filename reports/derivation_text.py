"""A derivation on the terminal: in about ten lines, or with everything."""

from shutil import get_terminal_size

from rich.cells import cell_len

from checks.result.derivation import Derivation, HandComparison, Section, Superposition
from checks.result.formulas import COMPONENTS, number_text, shown_symbol
from checks.result.verdict import Check
from checks.result.words import brief, clean, need_text, safety_text, value_and_whole_bar, where
from reports.derivation_words import (
    Line,
    Paragraph,
    SumTable,
    bar_texts,
    case_texts,
    legend,
    paragraphs,
    shares_of,
    status_texts,
)
from reports.terminal import labelled

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
    width = max(60, width or get_terminal_size((100, 24)).columns)
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
