"""The program: long commands by a child, the others here."""

import sys

from ballesta.supervisor import is_long, supervise


def main() -> None:
    """Run the command line of this process; a long command starts without its imports."""
    if is_long(sys.argv[1:]):
        sys.exit(supervise(sys.argv[1:]))
    from ballesta.cli import main as command_line

    sys.exit(command_line())


if __name__ == "__main__":
    main()
