"""`chrmc bench table2`: Table 2 of the paper, made again."""

from typing import Any

import click

from chrmc.cli.bench_tables import COLUMNS_HELP, run, table_options


@click.command("table2", epilog=COLUMNS_HELP)
@table_options
def command(**arguments: Any) -> int:
    """TR-, MC-, MPEG-, 3DMC-NLUT and CH-RMC over NLUT, beside the paper's Table 2."""
    from chrmc.bench.tables import table2_pairs

    return run("table2", table2_pairs(), **arguments)
