"""`chrmc monitors`: what is connected, and which of it is the SLM."""

import click

from chrmc.cli.arguments import slm_option
from chrmc.slm import SLM


@click.command("monitors")
@slm_option
@click.option("--identify", is_flag=True, help="Show each monitor its number, until a key.")
@click.option("--seconds", type=float, default=10.0, show_default=True, help="identify: at most.")
def command(slm: SLM, identify: bool, seconds: float) -> None:
    """List every monitor: index, label, output, place, mode, refresh, content scale.

    The label is the name that its maker gave it; --monitor takes a part of it. A star marks those
    with the SLM's pixels.
    """
    from display.monitors import list_monitors

    monitors = list_monitors()
    label = max(5, *(len(m.label) for m in monitors))
    width = max(6, *(len(m.name) for m in monitors))
    click.echo(
        f"     {'label':<{label}}  {'output':<{width}}  {'place':>13}  {'mode':>12}  "
        f"{'refresh':>9}  scale"
    )
    for m in monitors:
        star = "*" if m.fits(slm) else " "
        refresh = f"{m.refresh:g} Hz" if m.refresh else "unknown"
        scale = f"{m.scale[0]:g}" if m.scale[0] == m.scale[1] else f"{m.scale[0]:g}, {m.scale[1]:g}"
        click.echo(
            f"{star} {m.index:<2} {m.label or '–':<{label}}  {m.name:<{width}}  "
            f"{f'({m.x}, {m.y})':>13}  {f'{m.width} × {m.height}':>12}  {refresh:>9}  {scale}"
            + ("  primary" if m.primary else "")
        )
    fitting = sum(m.fits(slm) for m in monitors)
    if fitting:
        click.echo(f"* fits {slm.name}, {slm.width} × {slm.height}")
    else:
        click.echo(f"none has the {slm.width} × {slm.height} pixels of {slm.name}")
    if identify:
        from display.identify import show_numbers

        show_numbers(monitors, seconds)
