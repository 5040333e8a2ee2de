"""`chrmc bench`: the measurements that users repeat on their own machine and scene."""

import click

from chrmc.cli.lazy import LazyGroup

# name: (module, one line for --help)
SUBCOMMANDS: dict[str, tuple[str, str]] = {
    "table1": ("chrmc.cli.bench_table1", "Every CGH method with and without CH-RMC: Table 1."),
    "table2": ("chrmc.cli.bench_table2", "The NLUT videos and CH-RMC: Table 2 of the paper."),
    "rmc": ("chrmc.cli.bench_rmc", "Error and PSNR of the published CH-RMC along a video."),
    "paper": ("chrmc.cli.bench_paper", "The paper's numbers recomputed: consistent or not."),
    "tradeoff": ("chrmc.cli.bench_tradeoff", "Time against error of every method and setting."),
    "extremes": ("chrmc.cli.bench_extremes", "Promises tried at the ends of every range."),
    "speed": ("chrmc.cli.bench_speed", "The low-rank methods timed on this machine."),
    "plan": ("chrmc.cli.bench_plan", "What `chrmc plan` expects against what is measured."),
    "encodings": ("chrmc.cli.bench_encodings", "Efficiency and error of every encoding."),
    "propagation": ("chrmc.cli.bench_propagation", "Propagation against independent ones."),
}


@click.group("bench", cls=LazyGroup, table=SUBCOMMANDS)
def command() -> None:
    """Measure speed, error and the paper's numbers on this machine."""
