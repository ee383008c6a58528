"""A long command's side of its supervisor: the main function of the child that runs it."""

import gc
import sys

from geometry.child import Parent
from geometry.progress import begin

_ALLOCATIONS = 200_000  # between looks for cycles: libraries make about as many that stay


def run(parent: Parent) -> None:
    """Run the command line for a supervisor."""
    gc.set_threshold(_ALLOCATIONS)
    from ballesta.cli import main
    from ballesta.streams import claim_standard_output, finish_standard_output

    order = parent.receive()
    if order is None:  # only to be ready: imports are what takes the time
        import reports.terminal  # noqa: F401

        order = parent.receive()
    claim_standard_output()
    begin(parent, order)
    sys.argv = ["ballesta", *order.argv]
    code = main(order.argv)
    finish_standard_output()
    gc.freeze()  # all ends with the process: looking for cycles among it takes longer than loads do
    sys.exit(code)
