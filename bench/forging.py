"""A motor's steady run and a blow of the hammer, in processor time; a line of JSON.

The same cycle of 720 positions with its motor and at a prescribed speed, in turns, and one touch
of the workpiece by the modes of the elastic linkage. Run by bench/run.py from the repository.
"""

import json
import statistics
from dataclasses import replace
from pathlib import Path
from time import process_time

import loads
from ballesta.design.read import read_design
from ballesta.machine.quasi_static import with_sections
from ballesta.machine.solved_cycles import solve_cycles

HAMMER = Path(__file__).parent.parent / "designs" / "spring_hammer.toml"
CYCLE, RUNS = "at_5_work_10", 5
MOTOR = (
    'drive={ motor={ power="1.5 kW", speed="1430 rpm", free_speed="1500 rpm", breakdown=2.6, '
    'ratio=30 }, flywheel="20 kg m2" }'
)


def main() -> None:
    """Measure and print."""
    plain = read_design(HAMMER, (f"cycles.{CYCLE}.positions=720",))
    driven = read_design(HAMMER, (f"cycles.{CYCLE}.positions=720", MOTOR))
    plain, driven = (
        replace(design, cycles={CYCLE: design.cycles[CYCLE]}) for design in (plain, driven)
    )
    known = solve_cycles(plain, {})[CYCLE]
    elastic, _, _ = with_sections(plain, known)
    row, struck = int(known.contacts["workpiece"].begins[0]), loads.Struck(yields=30e3)
    works = {
        "prescribed": lambda: solve_cycles(plain, {}),
        "steady": lambda: solve_cycles(driven, {}),
        "blow": lambda: loads.blow_loads(known, elastic, "workpiece", row, struck, 0.02),
    }
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(RUNS):
        for name, work in works.items():
            start = process_time()
            work()
            times[name].append(process_time() - start)
    ratios = [a / b for a, b in zip(times["steady"], times["prescribed"], strict=True)]
    found = {name: statistics.median(values) for name, values in times.items()}
    print(json.dumps({**found, "steady over prescribed": statistics.median(ratios)}))


if __name__ == "__main__":
    main()
