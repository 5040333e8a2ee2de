"""`chrmc calibrate`: how fast this machine is, for plans."""

import click


@click.command("calibrate")
def command() -> None:
    """Measure this machine's rates for `chrmc plan` and `auto`, in some ten seconds, and keep them.

    A first plan measures them briefly by itself. They belong to this machine, its BLAS and the
    number of threads; where one of these changes they are measured anew.
    """
    from chrmc.planning.rates import KINDS, keep, measured, rates_file

    rates = measured()
    click.echo(f"{'per second':>12}  {'one core':>9}  each of {rates.threads}")
    for kind in KINDS:
        click.echo(f"{kind:>12}  {rates.alone[kind]:9.3g}  {rates.together[kind]:9.3g}")
    keep(rates)
    click.echo(f"kept in {rates_file()}")
