"""`chrmc monitors`: what is connected, and which of it is the SLM."""

import click

from chrmc.cli.arguments import slm_option
from chrmc.slm import SLM


@click.command("monitors")
@slm_option
def command(slm: SLM) -> None:
    """List every monitor: index, name, position, mode, refresh, content scale.

    A star marks those with the SLM's pixels.
    """
    from display.monitors import list_monitors

    monitors = list_monitors()
    width = max(4, *(len(m.name) for m in monitors))
    click.echo(f"     {'name':<{width}}  {'position':>13}  {'mode':>12}  {'refresh':>9}  scale")
    for m in monitors:
        star = "*" if m.fits(slm) else " "
        refresh = f"{m.refresh:g} Hz" if m.refresh else "unknown"
        scale = f"{m.scale[0]:g}" if m.scale[0] == m.scale[1] else f"{m.scale[0]:g}, {m.scale[1]:g}"
        click.echo(
            f"{star} {m.index:<2} {m.name:<{width}}  {f'({m.x}, {m.y})':>13}  "
            f"{f'{m.width} × {m.height}':>12}  {refresh:>9}  {scale}"
            + ("  primary" if m.primary else "")
        )
    fitting = sum(m.fits(slm) for m in monitors)
    if fitting:
        click.echo(f"* fits {slm.name}, {slm.width} × {slm.height}")
    else:
        click.echo(f"none has the {slm.width} × {slm.height} pixels of {slm.name}")
