"""`chrmc scene`: a scene as a folder of OpenEXR frames."""

from collections.abc import Iterable
from pathlib import Path

import click

from chrmc.cli.arguments import frames_option


@click.command("scene")
@click.argument("scene")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@frames_option
@click.option("--force", is_flag=True, help="Replace another scene in the folder.")
def command(scene: str, out: Path, frames: tuple[int, int] | None, force: bool) -> None:
    """Write SCENE as a folder of OpenEXR frames.

    SCENE is car-house, car-house-deep, or a folder of such frames of your own.

    The folder gets frame_0001.exr and so on (channels Y: intensity, Z: depth in metres, id: which
    object), scene.json (pixel pitch, depth planes, wavelength, objects; all lengths in metres)
    and preview.png to look at. Every command that takes a scene takes the folder, also one that
    another tool wrote: EXR frames plus a scene.json that says at least
    {"pixel_pitch": metres per pixel}. Frames that are there already are kept, so that an
    interrupted run continues.
    """
    from chrmc.progress import progress
    from chrmc.scene.folder import write_scene
    from chrmc.scene.load import load_scene
    from chrmc.scene.preview import write_preview
    from chrmc.scene.read_folder import read_scene

    source = Path(scene)
    if source.is_dir() and out.exists() and source.resolve() == out.resolve():
        raise ValueError(f"{out} is the scene itself: choose another folder for --out")

    def watch(numbers: Iterable[int]) -> Iterable[int]:
        return progress(numbers, f"writing {out.name}")

    paths = write_scene(
        load_scene(scene, form="rgbd"), out, frames=frames, force=force, watch=watch
    )
    written = read_scene(out)
    write_preview(written, out / "preview.png")
    print(
        f"{out}: {len(paths)} frames of {written.shape[1]} × {written.shape[0]} pixels, "
        f"{', '.join(written.object_names)}; look at {out / 'preview.png'}"
    )
