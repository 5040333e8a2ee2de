"""Where frames are shown: the options that say so, and the screen that they mean."""

from typing import Any

import click

from chrmc.cli.arguments import stacked
from chrmc.slm import SLM

place_options = stacked(
    click.option(
        "--monitor",
        default=None,
        help="Name, part of a name, or index, as `chrmc monitors` lists them. "
        "[the one that fits the SLM]",
    ),
    click.option("--headless", is_flag=True, help="Draw without a screen, through EGL."),
    click.option("--windowed", is_flag=True, help="Preview in a window on the desktop."),
)


def screen_on(place: dict[str, Any], slm: SLM, title: str, **more: Any) -> Any:
    """The screen that `place_options` mean, opened; `more` as `display.Screen` takes it."""
    from display.screen import Screen

    where = {name: place[name] for name in ("monitor", "headless", "windowed")}
    return Screen(**where, slm=slm, tell=tell, title=title, **more)


def tell(line: str) -> None:
    """A line for the user: a warning to stderr, others to stdout."""
    click.echo(line, err=line.startswith("warning"))
