"""Variations of a design: `--sweep 'parts.bar.wall = 4..8 mm : 9'`, a grid of them or a sample.

Values are written with their unit, so that the design's own door reads and refuses them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

from ballesta.design.files import split_key
from ballesta.design.read import read_design
from ballesta.sweeps.sweep_text import MOST, Sweep, parse_sweep, refusal, written
from checks.design.data import Design
from checks.design.errors import DesignError, DesignErrors, nearest
from checks.design.model import PART_MODELS, DesignFile

SEED = 0
_TRIED = 64  # values of a range that the design is asked about before anything is computed
_COMBINED = 16  # variations in which a value may be right that alone is not


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
