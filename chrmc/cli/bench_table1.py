"""`chrmc bench table1`: Table 1 of the paper, made again."""

from typing import Any

import click

from chrmc.cli.bench_tables import run, table_options


@click.command("table1")
@table_options
def command(**arguments: Any) -> int:
    """ANCOP and ACT of every CGH method, plain and with CH-RMC, beside the paper's Table 1.

    points: computed per frame; corrected: of them on frames that are not computed whole; moving:
    without objects that stand still; tolerant: under the tolerant matching rule. pt·px: points ×
    pixels they were computed on. ACT: seconds per frame, from points to complex field. err shown:
    relative field error against the points that the method says it shows; err scene: against the
    scene's. PSNR: of the worst reconstruction, against the exact field of either. Eq. 14: the
    image of the points shown against the scene's, dB.
    """
    from chrmc.bench.tables import table1_pairs

    return run("table1", table1_pairs(), **arguments)
