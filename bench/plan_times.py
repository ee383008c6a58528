"""Times that `ballesta plan` tells against those of `ballesta check --fidelity solid`, as ratios.

python -m bench.plan_times [DESIGN...]   both in one run, side by side in time; no file is written
"""

import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from ballesta.commands.plan import plan_text
from ballesta.run import check_to_folder
from checks.design.effort import Effort
from fem.threads import one_thread

DESIGNS = ("designs/slider_crank.toml", "designs/quick_return.toml", "designs/toggle_press.toml")


def main(designs: list[str]) -> None:
    """Print the time that was told, that it took, and the ratio of each design."""
    for design in designs or DESIGNS:
        found = re.search(r"in all about (\d+) (s|min)", plan_text(design))
        assert found is not None
        told = int(found[1]) * (60 if found[2] == "min" else 1)
        start = perf_counter()
        with one_thread(), TemporaryDirectory() as folder:
            check_to_folder(Path(design), Path(folder), effort=Effort("solid"))
        took = perf_counter() - start
        print(f"{design}: told {told} s, took {took:.0f} s, ratio {told / took:.2f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
