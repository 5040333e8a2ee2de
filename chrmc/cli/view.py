"""`chrmc view`: look around in a hologram video."""

from pathlib import Path

import click

from chrmc.cli.lengths import DEPTH, Length


@click.command("view")
@click.argument("video", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--frame", "number", type=int, default=None, help="Frame to start with. [the first]")
@click.option(
    "--depth", type=Length(DEPTH), default=None, help="Such as 252mm. [of the first object]"
)
@click.option("--follow", default=None, help="Object to keep in focus from frame to frame.")
def command(video: Path, number: int | None, depth: float | None, follow: str | None) -> int:
    """Look around in the video in DIR: any frame, any depth, through any Fourier filter.

    Click on the reconstruction to focus there; wheel and drag zoom and move; space plays; left
    and right change the frame, up and down the depth; 1, 2, 3 show intensity, log and phase;
    S saves the picture; F shows everything; Q leaves. Needs: pip install "chrmc[viewer]".
    """
    from chrmc.store import open_video

    stored = open_video(video)
    try:
        from reconstruct.viewer.window import ViewerWindow
    except ImportError as error:
        raise OSError(
            f"the viewer needs the package {error.name}: pip install 'chrmc[viewer]'"
        ) from None
    if number is not None:
        stored.entry(number)
    names = {o["name"] for f in stored.frames for o in f.get("objects", [])}
    if follow is not None and follow not in names:
        there = ", ".join(sorted(names)) or "none"
        raise ValueError(f"no object {follow!r}; the video has {there}")
    window = ViewerWindow(stored)
    window.model.follow = follow
    window.model.number = number if number is not None else window.model.number
    if depth is not None:
        window.model.depth = depth
    window.run()
    return 0
