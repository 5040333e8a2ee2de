"""`chrmc panels`: the panels that --slm takes by name."""

import click

from chrmc.panels import ENCODINGS, PANELS, all_panels, user_folder


@click.command("panels")
def command() -> None:
    """List the panels that --slm takes by name, each with the source of its figures.

    Your own are files NAME.toml in the folder that is named below; --slm takes the path of such a
    file, too.
    """
    found = all_panels()
    width = max(len(name) for name in found)
    for name, panel in found.items():
        if isinstance(panel, str):
            click.echo(f"{name:<{width}}  cannot be read: {panel}")
            continue
        slm = panel.slm
        fill = f", fill factor {slm.fill_factor:g}" if slm.fill_factor < 1 else ""
        click.echo(
            f"{name:<{width}}  {slm.name}: {slm.kind}, {slm.width} × {slm.height} pixels of "
            f"{slm.pixel_pitch * 1e6:g} µm, {slm.bits} bit, {slm.refresh:g} Hz{fill}"
        )
        click.echo(f"{'':<{width}}  source: {panel.source}" + (" (yours)" * (name not in PANELS)))
        if panel.unconfirmed:
            click.echo(f"{'':<{width}}  unconfirmed: {', '.join(panel.unconfirmed)}")
        told = f", response {panel.response}" if panel.response is not None else ""
        encodings = ", ".join(ENCODINGS[slm.kind or "amplitude"])
        click.echo(f"{'':<{width}}  encodings: {encodings}{told}")
    click.echo(
        "unconfirmed is what no source named, a usual value; compare all with your panel's data "
        "sheet"
    )
    click.echo(f"your own: {user_folder()}/NAME.toml")
