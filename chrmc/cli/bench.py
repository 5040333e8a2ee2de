"""`chrmc bench`: the measurements that users repeat on their own machine and scene."""

import click

from chrmc.cli.lazy import LazyGroup

# name: (module, one line for --help)
SUBCOMMANDS: dict[str, tuple[str, str]] = {
    "paper": ("chrmc.cli.bench_paper", "The paper's numbers recomputed: consistent or not."),
    "encodings": ("chrmc.cli.bench_encodings", "Efficiency and error of every encoding."),
}


@click.group("bench", cls=LazyGroup, table=SUBCOMMANDS)
def command() -> None:
    """Measure speed, error and the paper's numbers on this machine."""
