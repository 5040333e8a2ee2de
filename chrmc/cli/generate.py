"""`chrmc generate`: scene to stored hologram video."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import by_panel, recipe_options
from chrmc.cli.scene_options import SCENE_NAMES, scene_from, scene_options, things_argument
from chrmc.slm import SLM


@click.command("generate")
@things_argument
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@recipe_options
@scene_options
@click.option(
    "--export-points",
    type=click.Path(path_type=Path),
    default=None,
    help="Also write the scene's points of all frames to an .npz.",
)
@click.option(
    "--check-pixels",
    type=click.IntRange(0),
    default=None,
    help="Pixels per frame on which the error is measured; 0 for none. [as many as fit]",
)
@click.option(
    "--check-share",
    type=click.FloatRange(0, 1),
    default=0.05,
    show_default=True,
    help="Of the time, for measuring errors: as many pixels and frames as that allows.",
)
@click.option("--png", is_flag=True, help="Write PNG, smaller and slower than TIFF.")
@click.option(
    "--group",
    type=int,
    default=None,
    help="Frames that share a key frame. [1 without compensation, else 96]",
)
@click.option(
    "--looks",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    help="Draws of the random phases, shown one after the other in each frame of the scene.",
)
@click.option("--workers", type=int, default=None, help="Processes that share the work.")
@click.option(
    "--scheduler", default=None, help="A running Dask cluster that does it, tcp://HOST:PORT."
)
@click.option(
    "--force", is_flag=True, help="Replace another video in the folder, once the new one stands."
)
def command(
    sources: tuple[str, ...],
    out: Path,
    frames: tuple[int, int] | None,
    slm: SLM,
    wavelength: float | tuple[float, ...] | None,
    form: str,
    export_points: Path | None,
    png: bool,
    force: bool,
    workers: int | None,
    scheduler: str | None,
    **rest: Any,
) -> int:
    """Make a hologram video of SCENE: a built-in scene, a folder of RGB-D frames,
    FILE.py:NAME, or files.

    Files are meshes (.glb .gltf .obj .ply .stl), point clouds (.ply .xyz .csv .npz), pictures
    (a.png@0.22 b.png@0.28: at depths in metres), text:WORDS, a scene.toml, or a folder of a depth
    camera's pictures.

    A stopped run is continued by the same command.
    """
    from chrmc.generation.colour import make_in_light
    from chrmc.scene.origin import origin_of
    from chrmc.store.colour import open_video
    from chrmc.store.summary import summary

    rest = by_panel(rest)
    sized = {name: rest.pop(name) for name in SCENE_NAMES}
    # The shortest wavelength resolves most and reaches least.
    finest = min(wavelength) if isinstance(wavelength, tuple) else wavelength
    scene = scene_from(sources, form, slm, finest, sized)
    if export_points is not None:
        from chrmc.scene.sources.export import write_export

        count = write_export(scene, export_points)
        click.echo(f"{export_points}: {count} points of {scene.frame_count} frames")
    source = origin_of(sources, form, sized, scene)
    made = make_in_light(
        scene,
        slm,
        wavelength,
        rest | {"source": source},
        out,
        frames,
        ".png" if png else ".tif",
        force=force,
        workers=workers,
        scheduler=scheduler,
        tell=click.echo,
    )
    video = open_video(out)
    there = sum(map(len, video.channels))
    click.echo(f"{out}: {made} frames made, {there - made} kept")
    for one in video.channels:
        if len(video.channels) > 1:
            click.echo(f"{one.folder}:")
        for line in summary(one):
            click.echo(line)
    return 0
