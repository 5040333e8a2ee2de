"""`chrmc bench paper`: the paper's numbers recomputed, one line each."""

import click


@click.command("paper")
def command() -> None:
    """Recompute the numbers of the CH-RMC paper: consistent or not, one line each."""
    from chrmc.bench.paper import claims

    found = claims()
    for claim in found:
        click.echo(str(claim))
    agree = sum(claim.consistent for claim in found)
    click.echo(f"{agree} of {len(found)} printed values are consistent")
