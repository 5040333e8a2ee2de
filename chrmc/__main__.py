"""`chrmc`, or `python -m chrmc`: signals are awaited before anything large is loaded."""

import contextlib
import sys

from chrmc.cli.signals import ended_by_signal, interrupted, no_more_signals


def main() -> None:
    """Run the command line to its exit status."""
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(ended_by_signal())
            from chrmc.cli.main import main as run

            run()
        except KeyboardInterrupt:
            sys.exit(interrupted())
        finally:
            stack.pop_all()  # the program is over: the signals' old meaning does not come back
            no_more_signals()


if __name__ == "__main__":
    main()
