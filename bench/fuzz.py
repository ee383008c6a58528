"""Mutated designs, seeded: every one must end with an exit code of the contract, in time, as JSON.

python -m bench.fuzz [--mutants 10000] [--seconds 3600] [--seed 1] [--workers 4]
python -m bench.fuzz --replay

Writes bench/fuzz.json after every few hundred: how many ended how, and every finding with the text
that leads to it. A run that was stopped, or whose time was up, goes on from there when it is called
again with the same seed and the same code. One in a hundred climbs as far as it needs (auto), one
in ten writes its page, the others are formulas. `--replay` runs the recorded findings again: those
that end well now move to `mended`, with how. Its limit is processor time, as a machine that is busy
with other work makes every mutant slow: one that computes for longer is a finding, and one that
hangs is ended after ten times as much.
"""

import argparse
import json
import os
import random
import re
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Any

from ballesta.batches.job import OUT_OF_TIME
from ballesta.batches.pool import Limits, Pool
from ballesta.batches.processes import Admission
from checks.store.fingerprints import code_digest

ROOT = Path(__file__).parent.parent
SECONDS, MEMORY = 120.0, 4 * 2**30  # processor time and bytes that a mutant may take
_HANGS = 10.0  # times as long by the clock: nothing that computes is starved so much
_CHUNK = 200  # mutants between two records
_DESIGNS = ("toggle_press", "slider_crank", "quick_return", "spring_hammer", "toggle_press_30x30",
            "toggle_press_friction")  # fmt: skip
_FACTORS = ("0", "-1", "1e-12", "1e-3", "0.5", "0.9", "0.999999", "1.000001", "1.1", "2", "10",
            "1e3", "1e6", "1e12", "1e30", "1e300")  # fmt: skip
_UNITS = (
    "mm",
    "m",
    "inch",
    "N",
    "kN",
    "MPa",
    "deg",
    "rad",
    "kg",
    "s",
    "rad/s",
    "m/s",
    "%",
    "",
    "x",
)
_NASTY = ("inf", "nan", "-0.0", '""', "[]", "{}", "true", "9" * 400, '"' + "x" * 5000 + '"', '"1"',
          '"1e308 m"', '"\\u0000"', "[[1]]", "1979-05-27")  # fmt: skip
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
_UNIT = re.compile(r'(?<=\d )[A-Za-z/%0-9]+(?=")')


def mutant(seed: int, number: int) -> tuple[str, str]:
    """Name of the design and text of one mutant, the same whenever it is asked for."""
    chance = random.Random(f"{seed}/{number}")
    name = chance.choice(_DESIGNS)
    text = _shipped(name)
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        text = chance.choices(
            (_scaled, _other_unit, _nasty, _without, _twice, _swapped, _damaged, _cut),
            (12, 3, 3, 3, 2, 2, 1, 1),
        )[0](chance, text)
    return name, text


def _shipped(name: str) -> str:
    """The text of a design at 73 positions a cycle: more take time, and go the same ways."""
    text = (ROOT / "designs" / f"{name}.toml").read_text(encoding="utf-8")
    return re.sub(r"positions = \d+", "positions = 73", text)


def _scaled(chance: random.Random, text: str) -> str:
    found = list(_NUMBER.finditer(text))
    if not found:
        return text
    one = chance.choice(found)
    value = float(one[0]) * float(chance.choice(_FACTORS))
    return f"{text[: one.start()]}{value!r}{text[one.end() :]}"


def _other_unit(chance: random.Random, text: str) -> str:
    found = list(_UNIT.finditer(text))
    if not found:
        return text
    one = chance.choice(found)
    return f"{text[: one.start()]}{chance.choice(_UNITS)}{text[one.end() :]}"


def _nasty(chance: random.Random, text: str) -> str:
    found = list(re.finditer(r"(?<== )\S.*$", text, re.MULTILINE))
    if not found:
        return text
    one = chance.choice(found)
    return f"{text[: one.start()]}{chance.choice(_NASTY)}{text[one.end() :]}"


def _without(chance: random.Random, text: str) -> str:
    lines = text.splitlines()
    del lines[chance.randrange(len(lines))]
    return "\n".join(lines) + "\n"


def _twice(chance: random.Random, text: str) -> str:
    lines = text.splitlines()
    lines.insert(chance.randrange(len(lines)), chance.choice(lines))
    return "\n".join(lines) + "\n"


def _swapped(chance: random.Random, text: str) -> str:
    lines = text.splitlines()
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return "\n".join(lines) + "\n"


def _damaged(chance: random.Random, text: str) -> str:
    data = bytearray(text.encode())
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return data.decode("latin-1")


def _cut(chance: random.Random, text: str) -> str:
    return text[: chance.randrange(1, len(text))]


def run_one(job: Mapping[str, Any]) -> dict[str, Any]:
    """Check one mutant in this process: its exit code, and whatever was warned of."""
    from ballesta.pipeline import check_file
    from checks.design.effort import Effort
    from checks.design.errors import DesignError, NumericsError
    from reports.files import plain
    from reports.page import write_report
    from reports.pictures import Pictures
    from reports.terminal import verdict_text

    file, before = Path(job["file"]), _processor_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result = check_file(file, effort=Effort(job["fidelity"]))
            json.dumps(plain(result.to_dict()), allow_nan=False)
            verdict_text(result, None)
            if job["page"]:
                write_report(result, Pictures(), file.with_suffix(".html"))
            code = result.exit_code
        except DesignError as error:
            code = 2 if len(str(error)) < 300_000 else -1
        except NumericsError:
            code = 3
    return {
        "code": code,
        "warned": sorted({str(one.message)[:200] for one in caught}),
        "seconds": _processor_time() - before,
    }


def _processor_time() -> float:
    """Processor time of this process and of those it has started and ended, in s."""
    return sum(os.times()[:4])


@dataclass
class Found:
    """Outcomes of some mutants: how many ended how, which, and those that must not be."""

    counts: Counter[str] = field(default_factory=Counter)
    ended: dict[int, str] = field(default_factory=dict)
    findings: list[dict[str, Any]] = field(default_factory=list)


def fuzz(numbers: Sequence[int], seed: int, workers: int) -> Found:
    """Run mutants side by side."""
    found = Found()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        jobs = dict(_jobs(numbers, seed, place))
        admission = Admission(workers * MEMORY, MEMORY)
        limits = Limits(_HANGS * SECONDS, MEMORY, MEMORY)
        with Pool("bench.fuzz:run_one", workers, limits, admission, place / "work", ROOT) as pool:
            for ended in pool.results(list(jobs.items())):
                for one in ended:
                    outcome = one.outcome or {}
                    late = outcome.get("seconds", 0.0) > SECONDS
                    told = f"exit code {outcome['code']}" if outcome else one.status
                    told = OUT_OF_TIME if late else told
                    found.counts[told] += 1
                    found.ended[one.index] = told
                    well = outcome.get("code") in (0, 1, 2, 3) and not outcome["warned"]
                    if well and not late:
                        continue
                    name, text = mutant(seed, one.index)
                    found.findings.append({
                        "mutant": one.index, "design": name,
                        "fidelity": jobs[one.index]["fidelity"],
                        "ended": told, "error": one.error, "warned": outcome.get("warned", []),
                        "changed": _changed(name, text),
                    })  # fmt: skip
    return found


def _jobs(numbers: Sequence[int], seed: int, place: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    for number in numbers:
        file = place / f"mutant_{number}.toml"
        name, text = mutant(seed, number)
        file.write_text(text, encoding="utf-8")
        if not (place / f"{name}.toml").exists():  # for those that are like another file
            for design in (ROOT / "designs").glob("*.toml"):
                (place / design.name).write_text(_shipped(design.stem), "utf-8")
        chance = random.Random(f"{seed}/{number}/how")
        fidelity = "auto" if chance.random() < 0.01 else "formula"
        yield number, {"file": str(file), "fidelity": fidelity, "page": chance.random() < 0.1}


def _changed(name: str, text: str) -> list[str]:
    kept = set(_shipped(name).splitlines())
    return [line[:300] for line in text.splitlines() if line not in kept][:10]


def replayed(record: Mapping[str, Any], workers: int) -> dict[str, Any]:
    """Return a record whose findings were run again: what ends well now is in `mended`.

    Raises ValueError for a finding that the designs of today no longer lead to.
    """
    seed, old = record["seed"], {one["mutant"]: one for one in record["findings"]}
    for number, one in old.items():
        if _changed(*mutant(seed, number)) != one["changed"]:
            raise ValueError(f"mutant {number} of seed {seed} is another one now: run all again")
    found = fuzz(list(old), seed, workers)
    left = {one["mutant"] for one in found.findings}
    mended = [
        {**old[number], "ends now": found.ended[number]} for number in old if number not in left
    ]
    return {
        **record,
        "findings": found.findings,
        "mended": [*record.get("mended", []), *mended],
    }


def main() -> int:
    """Run the mutants that are asked for and record what came of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mutants", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--out", type=Path, default=ROOT / "bench" / "fuzz.json")
    parser.add_argument("--replay", action="store_true", help="the recorded findings alone")
    wanted = parser.parse_args()
    if wanted.replay:
        record = replayed(json.loads(wanted.out.read_text(encoding="utf-8")), wanted.workers)
        return _recorded(record, wanted.out)
    return _recorded(recorded(wanted.out, wanted.seed, wanted.mutants, wanted.workers,
                              wanted.seconds), wanted.out)  # fmt: skip


def recorded(out: Path, seed: int, mutants: int, workers: int, seconds: float) -> dict[str, Any]:
    """Run mutants from where the record in a file stops, and write it after each chunk of them.

    No chunk is begun that would end later than in so many seconds, if it took as long as the last.
    """
    begun, took = monotonic(), 0.0
    record = _begun(out, seed) | {"asked": mutants}
    before = record["seconds"]
    while record["ran"] < mutants and monotonic() - begun + took <= seconds:
        start = monotonic()
        numbers = range(record["ran"], min(record["ran"] + _CHUNK, mutants))
        found = fuzz(numbers, seed, workers)
        took = monotonic() - start
        record |= {
            "ran": record["ran"] + len(numbers),
            "seconds": round(before + monotonic() - begun),
            "ended": dict(sorted((Counter(record["ended"]) + found.counts).items())),
            "findings": [*record["findings"], *found.findings],
        }
        _write(record, out)
    return record


def _begun(out: Path, seed: int) -> dict[str, Any]:
    """Return the record in a file if it is of this seed and this code, or else an empty one."""
    fresh = {"seed": seed, "asked": 0, "ran": 0, "seconds": 0, "code": code_digest()}
    old = json.loads(out.read_text(encoding="utf-8")) if out.exists() else {}
    same = old.get("seed") == seed and old.get("code") == fresh["code"]
    return old if same else {**fresh, "ended": {}, "findings": []}


def _write(record: Mapping[str, Any], out: Path) -> None:
    out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _recorded(record: Mapping[str, Any], out: Path) -> int:
    """Write a record and tell its counts; the exit code, 1 with findings."""
    _write(record, out)
    counted = {key: len(record[key]) for key in ("findings", "mended") if key in record}
    print(json.dumps({**record, **counted}))
    return 1 if record["findings"] else 0


if __name__ == "__main__":
    sys.exit(main())
