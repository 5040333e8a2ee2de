"""`chrmc view`: look around in a hologram video."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import SLMType
from chrmc.cli.lengths import DEPTH, WAVELENGTH, Length
from chrmc.encoding import CODINGS


@click.command("view")
@click.argument(
    "sources", metavar="DIR [DIR]", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option("--frame", "number", type=int, default=None, help="Frame to start with. [the first]")
@click.option(
    "--depth", type=Length(DEPTH), default=None, help="Such as 252mm. [of the first object]"
)
@click.option("--follow", default=None, help="Object to keep in focus from frame to frame.")
@click.option("--slm", type=SLMType(), default=None, help="Of a picture. [lc-r-1080]")
@click.option("--wavelength", type=Length(WAVELENGTH), default=None, help="Of a picture. [532nm]")
@click.option("--encoding", type=click.Choice(CODINGS), default=None, help="Of a picture. [ssb]")
@click.option(
    "--screenshot",
    type=click.Path(path_type=Path),
    default=None,
    help="Write a PNG of the window when its pictures are sharp, and end.",
)
def command(
    sources: tuple[Path, ...],
    number: int | None,
    depth: float | None,
    follow: str | None,
    screenshot: Path | None,
    **picture: Any,
) -> int:
    """Look around in the video in DIR: any frame, any depth, through any Fourier filter.

    A video in colours is shown in them. With two, they are compared: linked frame, depth and zoom,
    side by side, by a wipe or as their difference. A picture of grey levels opens too, as --slm,
    --wavelength and --encoding say.

    \b
    chrmc view DIR --frame 21
    chrmc view DIR OTHER
    chrmc view frame.png --slm 1920x1080:8um --wavelength 633nm

    Click on the reconstruction to focus there; wheel and drag zoom and move; space plays; left
    and right change the frame, up and down the depth; 1, 2, 3 show intensity, log and phase;
    H shows all keys; Q leaves. Needs: pip install "chrmc[viewer]".
    """
    from reconstruct.viewer.sources import check_pair, open_source

    if len(sources) > 2:
        raise click.UsageError("at most two videos are compared")
    videos = [open_source(path, **picture) for path in sources]
    if len(videos) == 2:
        check_pair(*videos)
    try:
        from reconstruct.viewer.window import ViewerWindow
    except ImportError as error:
        raise OSError(
            f"the viewer needs the package {error.name}: pip install 'chrmc[viewer]'"
        ) from None
    from reconstruct.viewer.state import ViewerState

    ViewerState(videos).start(number, depth, follow)  # what is wrong is told before a window opens
    window = ViewerWindow(videos)
    window.session.model.start(number, depth, follow)
    if screenshot is None:
        window.run()
    else:
        window.screenshot(screenshot)
        click.echo(f"{screenshot}: the window")
    return 0
