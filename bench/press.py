"""Check one design into a temporary folder; print time and memory by stage as a line of JSON."""

import json
import resource
import sys
import tempfile
from pathlib import Path
from time import perf_counter


def gibibytes() -> float:
    """Largest memory so far, GiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def main() -> None:
    """Measure the check of the design named on the command line."""
    start = perf_counter()
    from ballesta.pipeline import check_file
    from checks.ladder.part_ladder import Effort
    from reports.files import write_json, write_vtu
    from reports.page import write_report
    from reports.pictures import drawing, prepare_drawing

    stages = {"import": perf_counter() - start}
    memories = {"import": gibibytes()}
    prepare_drawing()
    result = check_file(
        sys.argv[1],
        effort=Effort("solid"),
        say=lambda step: memories.__setitem__(step.split(";")[0], gibibytes()),
    )
    stages |= result.timings
    memories["all parts"] = gibibytes()
    begun = perf_counter()
    with tempfile.TemporaryDirectory() as folder, drawing(result) as pictures:
        for part in result.parts:
            write_vtu(part, Path(folder) / f"{part.name}.vtu")
        write_report(result, pictures, Path(folder) / "report.html")
        write_json(result, Path(folder) / "result.json")
    stages["report and files"] = perf_counter() - begun
    print(
        json.dumps(
            {
                "seconds": perf_counter() - start,
                "memory": gibibytes(),
                "stages": stages,
                "memories": memories,
            }
        )
    )


if __name__ == "__main__":
    main()
