"""`chrmc bench plan`: expected against measured, and whether what was taken is the best."""

import click


@click.command("plan")
@click.option("--only", multiple=True, help="Only scenes whose names begin so; may be repeated.")
def command(only: tuple[str, ...]) -> None:
    """Make ten kinds of scenes at three tolerances and with a budget by the way that `chrmc plan`
    takes, and by the next best ones, on one core; the shares of good choices, of times expected
    within a factor of two, of tolerances and budgets met.

    Ten minutes. Times are processor times, so a busy machine matters little.
    """
    from chrmc.bench.planned import CASES, Row, one_core, rows

    def line(row: Row) -> str:
        asked = f"{1e3 * row.asked:.3g} ms" if row.budget else f"{row.asked:.0e}"
        return (
            f"{row.scene:17} {asked:>8} {row.taken:32} {1e3 * row.expected:8.1f} "
            f"{1e3 * row.measured:8.1f} ms {row.expected / row.measured:5.2f} "
            f"{row.measured / row.best:5.2f} {row.error_expected:8.1e} {row.error:8.1e} "
            f"{'met' if row.met else 'NOT MET'}, planned in {1e3 * row.planning:.0f} ms"
        )

    click.echo(
        f"{'scene':17} {'asked':>8} {'taken':32} {'expected':>8} {'measured':>8}    {'ratio':>5} "
        f"{'÷best':>5} {'expected':>8} {'error':>8}"
    )
    found: list[Row] = []
    with one_core():
        for case in CASES:
            if not only or case.name.startswith(only):
                for row in rows(case):
                    found.append(row)
                    click.echo(line(row))
    asked, timed = [r for r in found if not r.budget], [r for r in found if r.budget]
    n = len(asked)
    click.echo(f"chosen ÷ best measured at most 1.5: {sum(r.good for r in asked)} of {n}")
    click.echo(f"time within a factor of two: {sum(r.close for r in asked)} of {n}")
    click.echo(f"tolerances met: {sum(r.met for r in asked)} of {n}")
    click.echo(f"budgets met: {sum(r.met for r in timed)} of {len(timed)}")
    brief = sum(r.planning <= min(0.2, max(r.measured, 0.02)) for r in found)
    click.echo(f"planned in at most 0.2 s and one frame's time: {brief} of {len(found)}")
