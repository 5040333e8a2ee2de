"""`chrmc bench table1`: Table 1 of the paper, made again."""

from typing import Any

import click

from chrmc.cli.bench_tables import COLUMNS_HELP, run, table_options


@click.command("table1", epilog=COLUMNS_HELP)
@table_options
def command(**arguments: Any) -> int:
    """ANCOP and ACT of every CGH method, plain and with CH-RMC, beside the paper's Table 1."""
    from chrmc.bench.tables import table1_pairs

    return run("table1", table1_pairs(), **arguments)
