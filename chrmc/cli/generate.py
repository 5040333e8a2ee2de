"""`chrmc generate`: scene to stored hologram video."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import recipe_options
from chrmc.slm import SLM


@click.command("generate")
@click.argument("scene")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@recipe_options
@click.option(
    "--check-pixels",
    type=click.IntRange(0),
    default=256,
    show_default=True,
    help="Pixels per frame on which the error is measured; 0 for none.",
)
@click.option("--png", is_flag=True, help="Write PNG, smaller and slower than TIFF.")
@click.option(
    "--group",
    type=int,
    default=None,
    help="Frames that share a key frame. [1 without compensation, else 96]",
)
@click.option(
    "--force", is_flag=True, help="Replace another video in the folder, once the new one stands."
)
def command(
    scene: str,
    out: Path,
    frames: tuple[int, int] | None,
    slm: SLM,
    wavelength: float | None,
    form: str,
    png: bool,
    force: bool,
    **rest: Any,
) -> int:
    """Make a hologram video of SCENE: a built-in name, a folder of RGB-D frames, or FILE.py:NAME.

    A stopped run is continued by the same command.
    """
    from chrmc.generation import make_video, summary
    from chrmc.python_file import is_python_name
    from chrmc.recipe import recipe_for
    from chrmc.scene.load import load_scene
    from chrmc.store import open_video

    source = scene if is_python_name(scene) else None
    recipe = recipe_for(load_scene(scene, form=form), slm, wavelength, source=source, **rest)
    made = make_video(recipe, out, frames, ".png" if png else ".tif", force=force)
    video = open_video(out)
    click.echo(f"{out}: {made} frames made, {len(video.frames) - made} kept")
    for line in summary(video.frames):
        click.echo(line)
    return 0
