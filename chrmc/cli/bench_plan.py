"""`chrmc bench plan`: expected against measured, and whether what was taken is the best."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from chrmc.bench.planned import Row

_HEAD = (
    f"{'scene':17} {'asked':>9} {'taken':36} {'expected':>8} {'measured':>8}    {'ratio':>5} "
    f"{'÷best':>5} {'expected':>8} {'error':>8}"
)


@click.command("plan")
@click.option("--only", multiple=True, help="Only scenes whose names begin so; may be repeated.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("plan.json"),
    show_default=True,
    help="Where rows are kept.",
)
@click.option("--force", is_flag=True, help="Measure anew what the file holds.")
def command(only: tuple[str, ...], out: Path, force: bool) -> None:
    """Make ten kinds of scenes at three tolerances and with a budget by the way that `chrmc plan`
    takes, and by the next best ones, on one core; two of them by the published video methods, too.
    Then the shares of good choices, of times expected within a factor of two, of tolerances and
    budgets met.

    Rows are kept one by one: a stopped run is continued by the same command. Some ten minutes.
    Times are processor times, so a busy machine matters little.
    """
    from chrmc import __version__
    from chrmc.bench.kept import KeptRows
    from chrmc.bench.planned import CASES, Row, one_core, rows
    from chrmc.bench.speed import machine

    cases = [case for case in CASES if not only or case.name.startswith(only)]
    if not cases:
        raise ValueError(
            f"no scene begins with {' or '.join(only)}: {', '.join(case.name for case in CASES)}"
        )
    found: list[Row] = []
    with one_core():
        kept = KeptRows(out, [machine(), f"chrmc {__version__}"], Row, force)
        click.echo(_HEAD)
        for case in cases:
            for row in rows(case, kept):
                found.append(row)
                click.echo(_line(row))
    for line in _shares(found):
        click.echo(line)


def _line(row: "Row") -> str:
    asked = row.what
    if asked == "tolerance":
        asked = f"{row.asked:.0e}"
    elif asked == "budget":
        asked = f"{1e3 * row.asked:.3g} ms"
    said = (
        f"{row.scene:17} {asked:>9} {row.taken:36} {1e3 * row.expected:8.1f} "
        f"{1e3 * row.measured:8.1f} ms {row.expected / row.measured:5.2f} "
        f"{row.measured / row.best:5.2f} {row.error_expected:8.1e} {row.error:8.1e}"
    )
    if row.what not in ("tolerance", "budget"):
        return said
    met = "met" if row.met else "NOT MET"
    if row.what == "budget":
        met += f", {1e3 * row.middle:.3g} ms in the middle"
    return f"{said} {met}, planned in {1e3 * row.planning:.0f} ms"


def _shares(found: "list[Row]") -> list[str]:
    """What all rows come to."""
    asked = [row for row in found if row.what == "tolerance"]
    timed = [row for row in found if row.what == "budget"]
    others = [row for row in found if row not in asked and row not in timed]
    own = asked + timed
    out = [
        f"chosen ÷ best measured at most 1.5: {sum(r.good for r in asked)} of {len(asked)}",
        f"time within a factor of two: {sum(r.close for r in asked)} of {len(asked)}",
        f"tolerances met: {sum(r.met for r in asked)} of {len(asked)}",
        f"budgets met by the median frame: {sum(r.met for r in timed)} of {len(timed)}",
        "planned in at most 0.2 s and the first frame's time: "
        f"{sum(r.brief for r in own)} of {len(own)}",
    ]
    if others:
        close = sum(r.close for r in others)
        out.append(f"published videos' time within a factor of two: {close} of {len(others)}")
    return out
