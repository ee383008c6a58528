"""The program: long commands by a child, whose main function is `run`, the others here."""

import gc
import sys

from ballesta.supervisor import is_long, supervise
from geometry.progress import Parent, begin

_ALLOCATIONS = 200_000  # between looks for cycles: libraries make about as many that stay


def main() -> None:
    """Run the command line of this process; a long command starts without its imports."""
    if is_long(sys.argv[1:]):
        sys.exit(supervise(sys.argv[1:]))
    from ballesta.cli import main as command_line

    sys.exit(command_line())


def run(parent: Parent) -> None:
    """Run the command line for a supervisor."""
    gc.set_threshold(_ALLOCATIONS)
    from ballesta.cli import main
    from ballesta.supervisor import claim_standard_output, finish_standard_output

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


if __name__ == "__main__":
    main()
