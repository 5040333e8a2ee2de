"""`chrmc serve`: a panel for other programs and machines."""

import threading
from typing import Any

import click

from chrmc.cli.arguments import slm_option
from chrmc.cli.signals import ended_by_signal
from chrmc.cli.surface import place_options, screen_on, tell
from chrmc.encoding import CODINGS
from chrmc.slm import SLM


@click.command("serve")
@place_options
@slm_option
@click.option("--port", type=int, default=47808, show_default=True, help="0 takes a free one.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Elsewhere needs --token.")
@click.option(
    "--token", default="", envvar="CHRMC_TOKEN", help="What clients must present. [$CHRMC_TOKEN]"
)
@click.option(
    "--encoding", type=click.Choice(list(CODINGS)), default=None, help="[the panel's usual one]"
)
@click.option("--scale", type=float, default=None, help="Of complex fields. [the first one's]")
@click.option("--log", type=click.Path(dir_okay=False), default=None, help="A line per flip.")
def command(
    slm: SLM,
    port: int,
    host: str,
    token: str,
    encoding: str | None,
    scale: float | None,
    log: str | None,
    **place: Any,
) -> None:
    """Show what another program sends: `display.Remote`, MATLAB, LabVIEW (docs/remote.md).

    One client at a time. It listens on this machine alone unless --host and --token say otherwise;
    what is sent is not encrypted, so keep it in a laboratory's own network. Esc or Ctrl-C ends it.
    """
    from display.serve import Server

    with (
        ended_by_signal(),
        screen_on(place, slm, "chrmc serve", encoding=encoding, scale=scale, log=log) as screen,
    ):
        server = Server(screen, host, port, token, tell)
        where, number = server.address
        click.echo(f"{screen.name} on {where}:{number}; Esc or Ctrl-C ends")
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        try:
            while thread.is_alive():
                thread.join(0.1)
                if "escape" in screen.pressed():
                    break
        finally:
            server.stop()
            thread.join(2.0)
