"""Variations of a design: `--sweep 'parts.bar.wall = 4..8 mm : 9'`, a grid of them or a sample.

Values are written with their unit, so that the design's own door reads and refuses them.

A variation's neighbour is the same design with its dimensions on a grid about the file's. Lengths
of parts, forces and numbers of materials that a variation sets are taken to the nearest point of a
grid whose steps are 20 %, about what the file states: none is more than 9.6 % off. All else of the
variation stays. So a variation's neighbour depends on itself and on the file alone, not on which
variations came before, and many share one.
"""

import csv
import gc
import math
import re
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from ballesta.design.files import split_key
from ballesta.design.read import read_design
from ballesta.machine.runs import doubts_of, run_machine
from checks.design.data import Design
from checks.design.errors import DesignError, DesignErrors, NumericsError, nearest
from checks.design.model import PART_MODELS, DesignFile
from checks.ladder.carried import Neighbour, neighbour_of
from checks.part.loaded_part import LoadedPart
from checks.store.store import Store
from checks.stress.kept_models import Models
from fem.solvers import SolverError
from geometry.mesh import MeshError
from loads import LinkageError

SEED = 0
_TRIED = 64  # values of a range that the design is asked about before anything is computed
_COMBINED = 16  # variations in which a value may be right that alone is not
MOST = 100_000  # values of one sweep, and variations of one design
EXAMPLE = "write it such as parts.bar.wall = 4..8 mm : 9, or material = S275, S355"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_ALONE = re.compile(rf"({_NUMBER})\s*(.*)")
_RANGE = re.compile(
    rf"\s*(?P<low>{_NUMBER})(?P<low_unit>[^,:]*?)\.\.\s*(?P<high>[^,:]*?)\s*(?::(?P<how>[^,:]*))?"
)

Values = tuple[str, ...]
STEP = 1.2
_KEPT = 32  # neighbours of a process; each has a mesh of some MB
_PACKAGES = ("ballesta", "checks", "fatigue", "fem", "geometry", "loads")
_ON_GRID = [
    (re.compile(keys), re.compile(rf"(\d+(?:\.\d+)?)\s*({units})"))
    for keys, units in (
        (r"parts\.\w+\..+", "mm|cm|m"),
        (r"(?:cycles|forces)\..+", "N|kN"),
        (r"materials\.\w+\.\w+", "MPa|GPa|kg/m3"),
    )
]
_found: OrderedDict[tuple[str, ...], Neighbour | str] = OrderedDict()


@dataclass(frozen=True)
class Interval:
    """All values between two, in a unit as it is written."""

    low: float
    high: float
    unit: str

    def at(self, share: float) -> str:
        """Return the value at a share of the way from low to high, to six digits of the range."""
        value = self.low + share * (self.high - self.low)
        digits = 5 - math.floor(math.log10(self.high - self.low))
        return written(min(max(round(value, digits), self.low), self.high), self.unit)


@dataclass(frozen=True)
class Sweep:
    """A sweep: keys, and the values that they take together.

    text      as the user wrote it
    keys      dotted keys of the design
    choices   a value for each key, per choice; empty for an interval
    interval  that every key takes the same value of; None where there are choices
    """

    text: str
    keys: tuple[str, ...]
    choices: tuple[Values, ...] = ()
    interval: Interval | None = None

    def overrides(self, values: Values) -> Values:
        """Return what sets the keys to a choice's values."""
        return tuple(f"{key}={value}" for key, value in zip(self.keys, values, strict=True))

    def at(self, share: float) -> Values:
        """Return the overrides at a share of the way, 0 <= share < 1, through the values."""
        if self.interval is not None:
            return self.overrides((self.interval.at(share),) * len(self.keys))
        return self.overrides(self.choices[int(share * len(self.choices))])


def written(value: float, unit: str) -> str:
    """Write a number with its unit as a design file does.

    >>> written(0.1 + 0.2, "mm"), written(3.0, "")
    ('0.3 mm', '3')
    """
    return f"{value:.12g} {unit}".strip()


def refusal(text: str, problem: str) -> DesignError:
    """Return the error of a sweep as it was written."""
    return DesignError(Path("--sweep"), text.strip(), problem)


def parse_sweep(text: str) -> Sweep:
    """Parse a sweep; raises DesignError.

    >>> parse_sweep("leaves = 2..4 : 3").choices
    (('2',), ('3',), ('4',))
    """
    left, equals, right = text.partition("=")
    keys = tuple(key.strip() for key in left.split("&"))
    if not equals or not right.strip() or any(split_key(key) is None for key in keys):
        raise refusal(text, EXAMPLE)
    if len(set(keys)) < len(keys):
        raise refusal(text, "names a key twice")
    found = _RANGE.fullmatch(right)
    if found is None:
        return Sweep(text, keys, _listed(text, right, len(keys)))
    interval = _interval(text, found)
    if found["how"] is None:
        return Sweep(text, keys, interval=interval)
    values = _spaced(text, interval, found["how"].strip())
    return Sweep(text, keys, tuple((value,) * len(keys) for value in values))


def _interval(text: str, found: re.Match[str]) -> Interval:
    high = _ALONE.fullmatch(found["high"])
    if high is None:
        raise refusal(
            text, f"the upper end of the range must be a number, got {found['high']!r}; {EXAMPLE}"
        )
    unit, low_unit = high[2].strip(), found["low_unit"].strip()
    if low_unit not in ("", unit):
        raise refusal(
            text, f"both ends of a range have one unit, got {low_unit!r} and {unit or 'none'!r}"
        )
    ends = float(found["low"]), float(high[1])
    if not all(map(math.isfinite, ends)):
        raise refusal(text, "the ends of a range must be finite")
    if ends[0] == ends[1]:
        raise refusal(text, "the range is empty; --set sets one value")
    if ends[0] > ends[1]:
        turned = f"{written(ends[1], '')}..{written(ends[0], unit)}"
        raise refusal(text, f"a range goes from the smaller to the larger: {turned}")
    return Interval(*ends, unit)


def _spaced(text: str, interval: Interval, how: str) -> list[str]:
    """Return the values of a range as `: 9` or `: step 0.5 mm` spaces them, both ends included."""
    word, _, size = how.partition(" ")
    width = interval.high - interval.low
    if word == "step":
        step = _ALONE.fullmatch(size.strip())
        if step is None or step[2].strip() not in ("", interval.unit) or not float(step[1]) > 0:
            wanted = f"such as {written(width / 8, interval.unit)}"
            raise refusal(text, f"the step must be above 0 in the range's unit, {wanted}")
        count = width / float(step[1])
        if count > MOST or abs(count - round(count)) > 1e-9 * count or round(count) < 1:
            end = written(interval.low + max(1, math.floor(count)) * float(step[1]), interval.unit)
            raise refusal(
                text,
                f"steps of {written(float(step[1]), interval.unit)} do not end at "
                f"{written(interval.high, interval.unit)}; nearest is {end}"
                if count <= MOST
                else f"takes more than {MOST} steps",
            )
        n = round(count)
    else:
        if not how.isdecimal() or not 2 <= int(how) <= MOST:
            raise refusal(
                text,
                f"after the colon stands how many values, 2 to {MOST}, or a step such as "
                f"step {written(width / 8, interval.unit)}; got {how!r}",
            )
        n = int(how) - 1
    values = [interval.low + width * k / n for k in range(n)] + [interval.high]
    return [written(value, interval.unit) for value in values]


def _listed(text: str, right: str, n_keys: int) -> tuple[Values, ...]:
    """Return the choices of a list; quotes hold an item together that has commas."""
    if ".." in right and '"' not in right:
        raise refusal(text, f"a range stands alone and has two numbers; {EXAMPLE}")
    try:
        (items,) = csv.reader([right.strip()], skipinitialspace=True, strict=True)
    except (csv.Error, ValueError):
        raise refusal(text, "quotes must hold whole items") from None
    choices = []
    for item in items:
        values = tuple(value.strip() for value in item.split("&"))
        if not all(values):
            raise refusal(text, "an item of the list is empty")
        if len(values) not in (1, n_keys):
            raise refusal(
                text,
                f"{item.strip()!r} has {len(values)} values for {n_keys} "
                f"key{'s' if n_keys > 1 else ''}",
            )
        choices.append(values * n_keys if len(values) == 1 else values)
    choices = [*zip(*(_with_units(column) for column in zip(*choices, strict=True)), strict=True)]
    if len(choices) == 1:
        raise refusal(text, "is one value; --set sets one, a sweep has two or more")
    for index, choice in enumerate(choices):
        if choice in choices[:index]:
            raise refusal(text, f"{' & '.join(dict.fromkeys(choice))} stands twice")
    return tuple(choices)


def _with_units(items: Sequence[str]) -> list[str]:
    """Give the unit of the last number to those that have none: 4, 5, 6 mm."""
    numbers = [_ALONE.fullmatch(item) for item in items]
    if any(number is None for number in numbers):
        return list(items)
    last = numbers[-1]
    assert last is not None
    return [
        f"{item} {last[2]}" if number and not number[2] and last[2] else item
        for item, number in zip(items, numbers, strict=True)
    ]


def variations(
    sweeps: Sequence[str], sample: int | None = None, seed: int = SEED
) -> list[tuple[str, ...]]:
    """Return the overrides ("key=value") of every variation, without asking any design.

    sweeps  each such as "parts.bar.wall = 4..8 mm : 9" or "material = S275, S355"
    sample  how many points of a scrambled Sobol sequence are taken; None for all of the grid
    seed    of the scrambling

    Raises DesignError for a sweep that is not understood. Of the grid, the last sweep runs fastest.
    """
    return _combined([parse_sweep(text) for text in sweeps], sample, seed)


def design_variations(
    file: str | Path,
    sweeps: Sequence[str],
    sample: int | None = None,
    seed: int = SEED,
    overrides: Sequence[str] = (),
) -> list[tuple[str, ...]]:
    """Return `variations` of one design, each of which sets keys that the design has.

    overrides  set on all variations, and not by any sweep

    Raises DesignError for a sweep that is not understood, a key that the design does not have and
    a value that the key does not take. What only a combination of values makes wrong is left to the
    check of that variation.
    """
    design = read_design(file, overrides)
    parsed = [spread(parse_sweep(text), design) for text in sweeps]
    taken = {override.partition("=")[0].strip(): "--set" for override in overrides}
    for sweep in parsed:
        for key in sweep.keys:
            if taken.get(key) == "--set":
                raise refusal(sweep.text, f"{key} is set by --set, too")
    found = _combined(parsed, sample, seed)
    for sweep in parsed:
        _ask(Path(file), sweep, found, overrides)
    return found


def spread(sweep: Sweep, design: Design) -> Sweep:
    """Return the sweep with every key that is one word meant for the parts, once for each of them.

    A word that is no key of the design file itself, such as material, means that key of every part
    whose shape has it. Raises DesignError for a word that is neither.
    """
    keys: list[str] = []
    columns: list[int] = []
    for column, key in enumerate(sweep.keys):
        meant = [key] if len(split_key(key) or ()) > 1 or _of_file(key) else _of_parts(key, design)
        if not meant:
            known = {*DesignFile.model_fields, *_all_part_keys(design)}
            guess = nearest(key, sorted(known))
            hint = f"did you mean {guess}?" if guess else "such as material of all parts"
            raise DesignError(design.file, key, f"unknown key, {hint} (from --sweep)")
        keys += meant
        columns += [column] * len(meant)
    if len(set(keys)) < len(keys):
        raise refusal(sweep.text, "names a key twice")
    choices = tuple(tuple(choice[column] for column in columns) for choice in sweep.choices)
    return replace(sweep, keys=tuple(keys), choices=choices)


def _of_file(key: str) -> bool:
    return key in DesignFile.model_fields


def _of_parts(key: str, design: Design) -> list[str]:
    return [
        f"parts.{name}.{key}"
        for name, part in design.parts.items()
        if part.shape in PART_MODELS and key in PART_MODELS[part.shape].model_fields
    ]


def _all_part_keys(design: Design) -> Iterator[str]:
    for part in design.parts.values():
        if part.shape in PART_MODELS:
            yield from PART_MODELS[part.shape].model_fields


def _combined(parsed: Sequence[Sweep], sample: int | None, seed: int) -> list[tuple[str, ...]]:
    _refuse_shared_keys(parsed)
    if sample is not None:
        return _sampled(parsed, sample, seed)
    for sweep in parsed:
        if sweep.interval is not None:
            raise refusal(
                sweep.text,
                f"say how many values: {sweep.text.strip()} : 9, or step "
                f"{written((sweep.interval.high - sweep.interval.low) / 8, sweep.interval.unit)}, "
                "or take a sample of all with --sample",
            )
    count = math.prod(len(sweep.choices) for sweep in parsed)
    if count > MOST:
        raise refusal(
            "; ".join(sweep.text.strip() for sweep in parsed),
            f"makes {count} variations, more than {MOST}; take a sample with --sample",
        )
    grid = product(*(map(sweep.overrides, sweep.choices) for sweep in parsed))
    return [tuple(override for group in groups for override in group) for groups in grid]


def _refuse_shared_keys(parsed: Sequence[Sweep]) -> None:
    seen: dict[str, str] = {}
    for sweep in parsed:
        for key in sweep.keys:
            if key in seen:
                raise refusal(sweep.text, f"{key} is varied by {seen[key].strip()!r}, too")
            seen[key] = sweep.text


def _sampled(parsed: Sequence[Sweep], sample: int, seed: int) -> list[tuple[str, ...]]:
    """The first points of a scrambled Sobol sequence (scipy.stats.qmc), each variation once."""
    from scipy.stats import qmc

    command_line = Path("command line")
    if not 2 <= sample <= MOST:
        raise DesignError(command_line, "--sample", f"must be 2 to {MOST}, got {sample}")
    if seed < 0:
        raise DesignError(command_line, "--seed", f"must be at least 0, got {seed}")
    if not parsed:
        raise DesignError(command_line, "--sample", "needs a --sweep to take a sample of")
    engine = qmc.Sobol(len(parsed), scramble=True, rng=seed)
    points = engine.random_base2(math.ceil(math.log2(sample)))[:sample]
    found = (
        tuple(override for sweep, share in zip(parsed, point, strict=True)
              for override in sweep.at(float(share)))
        for point in points
    )  # fmt: skip
    return list(dict.fromkeys(found))


def _ask(
    file: Path, sweep: Sweep, found: Sequence[tuple[str, ...]], overrides: Sequence[str]
) -> None:
    """Raise what the design has against a value, alone and in the variations that have it."""
    if sweep.interval is not None:
        # the middle is no round number: an input that takes whole numbers only refuses it
        values = [sweep.at(share) for share in (0.0, 0.381966, 1.0)]
    else:
        every = max(1, len(sweep.choices) // _TRIED)
        values = [sweep.overrides(choice) for choice in sweep.choices]
        values = [*values[:-1:every], values[-1]]
    for value in values:
        error = _against(file, sweep, (*overrides, *value))
        if error is None:
            continue
        having = [other for other in found if set(value) <= set(other)][:_COMBINED]
        if all(_against(file, sweep, (*overrides, *other)) for other in having if other != value):
            problem = error.problem.replace(" (from --set)", "")
            raise DesignError(error.file, error.key, f"{problem} (from --sweep)")


def _against(file: Path, sweep: Sweep, overrides: Sequence[str]) -> DesignError | None:
    """Return what a design has against its overrides at the keys of a sweep."""
    try:
        read_design(file, overrides)
    except DesignError as error:
        errors = error.errors if isinstance(error, DesignErrors) else (error,)
        return next((each for each in errors if each.key in sweep.keys), None)
    return None


def on_grid(overrides: Sequence[str], stated: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """The overrides ("key=value") with all that has a grid at its nearest points.

    stated  (key, value) of the file without them

    >>> on_grid(["parts.bar.wall=7.2 mm", "material=S355"], [("parts.bar.wall", "6 mm")])
    ('parts.bar.wall=7.2 mm', 'material=S355')
    >>> on_grid(["parts.bar.wall=6.5 mm"], [("parts.bar.wall", "6 mm")])
    ('parts.bar.wall=6 mm',)
    """
    known = dict(stated)
    return tuple(_near(text, known) for text in overrides)


def _sizes(design: Design) -> list[tuple[str, str]]:
    """Keys and values that a design states, and sizes that the files of its parts have."""
    drawn = [
        (f"parts.{name}.{key}", f"{size:.6g} mm")
        for name, part in design.parts.items()
        for key, size in part.geometry.drawn_sizes.items()
    ]
    return [*design.inputs, *drawn]


def _stated(key: str, known: Mapping[str, str]) -> str:
    """The value of a key, or of that key of the part that its part is like; "" without one."""
    while key not in known:
        table, _, name = key.rpartition(".")
        if f"{table}.like" not in known:
            return ""
        key = f"parts.{known[f'{table}.like']}.{name}"
    return known[key]


def _near(override: str, known: Mapping[str, str]) -> str:
    key, _, value = (text.strip() for text in override.partition("="))
    stated = _stated(key, known)
    for keys, values in _ON_GRID:
        here, there = values.fullmatch(value), values.fullmatch(stated.strip())
        if keys.fullmatch(key) and here and there and here[2] == there[2] and float(there[1]):
            ratio = float(here[1]) / float(there[1])
            steps = round(math.log(ratio) / math.log(STEP)) if ratio else 0
            return f"{key}={float(there[1]) * STEP**steps:.6g} {here[2]}" if ratio else override
    return override


class Neighbours:
    """The neighbours of the parts of one variation of a design."""

    def __init__(self, file: Path, overrides: Sequence[str], store: Store | None = None) -> None:
        """Take the overrides that make the variation.

        store  where the neighbours of earlier runs are
        """
        self._file, self._store, self._overrides = file, store, tuple(overrides)

    def of(self, part: str) -> Neighbour | str:
        """The neighbour of a part; in words, why it has none."""
        try:
            overrides = on_grid(self._overrides, _sizes(read_design(self._file)))
            design = read_design(self._file, overrides)
        except DesignError as error:
            return f"its neighbour is refused: {error}"
        key = (str(self._file), design.sha256, *overrides, part)
        if key not in _found:
            while len(_found) >= _KEPT:
                _found.popitem(last=False)
            if self._store is None:
                _found[key] = self._solved(design, part)
            else:
                inputs = (key[1:], [text for _, text in design.sources])
                _found[key] = self._store.remember(
                    "neighbour", _PACKAGES, inputs, lambda: self._solved(design, part)
                )
        _found.move_to_end(key)
        return _found[key]

    def _solved(self, design: Design, part: str) -> Neighbour | str:
        gc.collect()  # an earlier solid's factors refer to themselves in circles: 0.4 GB of a bar
        models = Models()
        try:
            if part not in design.parts:
                return "its neighbour has no such part"
            machine = run_machine(design, models)
            design, doubts = machine.design, doubts_of(machine.design, machine).all
            loaded = LoadedPart.of(design, design.parts[part], machine.all, models, doubts)
            return neighbour_of(loaded, models)
        except (DesignError, NumericsError, MeshError, SolverError, LinkageError) as error:
            return f"its neighbour cannot be solved: {error}"
