"""`chrmc scene`: a scene as a folder of OpenEXR frames, or as a scene.toml to edit."""

from collections.abc import Iterable
from pathlib import Path

import click

from chrmc.cli.arguments import figure_option, frames_option, slm_option, wavelength_option
from chrmc.cli.scene_options import scene_from, scene_options, things_argument
from chrmc.slm import SLM


@click.command("scene")
@things_argument
@click.option(
    "--out", type=click.Path(path_type=Path), required=True, help="Folder, or .toml, to write."
)
@figure_option("preview.png")
@frames_option
@slm_option
@wavelength_option
@scene_options
@click.option("--force", is_flag=True, help="Replace what is there.")
def command(
    sources: tuple[str, ...],
    out: Path,
    figure: Path,
    frames: tuple[int, int] | None,
    slm: SLM,
    wavelength: float | None,
    force: bool,
    density: float | None,
    points: int | None,
    fit: bool,
) -> None:
    """Write SCENE as a folder of OpenEXR frames, or as a scene.toml.

    SCENE is what `chrmc generate` takes: a built-in scene, a folder, or files.

    With --out FILE.toml files become one commented text with every object's size, place, turn and
    motion as understood, to edit and to use in their place.

    Else the folder gets frame_0001.exr and so on (channels Y: intensity, Z: depth in metres, id:
    which object), scene.json (pixel pitch, depth planes, wavelength, objects; all lengths in
    metres) and the figure, preview.png, to look at. Every command that takes a scene takes the
    folder, also one that another tool wrote: EXR frames plus a scene.json that says at least
    {"pixel_pitch": metres per pixel}. Frames that are there already are kept, so that an
    interrupted run continues.
    """
    from chrmc.progress import progress
    from chrmc.scene.folder import write_scene
    from chrmc.scene.preview import write_preview
    from chrmc.scene.read_folder import read_scene

    options = {"density": density, "points": points, "fit": fit}
    if out.suffix.lower() == ".toml":
        _write_toml(sources, out, slm, wavelength, options, force)
        return
    source = Path(sources[0])
    if source.is_dir() and out.exists() and source.resolve() == out.resolve():
        raise ValueError(f"{out} is the scene itself: choose another folder for --out")

    def watch(numbers: Iterable[int]) -> Iterable[int]:
        return progress(numbers, f"writing {out.name}")

    scene = scene_from(sources, "rgbd", slm, wavelength, options)
    paths = write_scene(scene, out, frames=frames, force=force, watch=watch)
    written = read_scene(out)
    write_preview(written, out / figure)
    print(
        f"{out}: {len(paths)} frames of {written.shape[1]} × {written.shape[0]} pixels, "
        f"{', '.join(written.object_names)}; look at {out / figure}"
    )


def _write_toml(
    sources: tuple[str, ...],
    out: Path,
    slm: SLM,
    wavelength: float | None,
    options: dict[str, float | int | bool | None],
    force: bool,
) -> None:
    from chrmc.scene.sources.files import build_sources, is_source
    from chrmc.scene.sources.world_toml import write_toml

    if out.exists() and not force:
        raise ValueError(f"{out} is there already: choose another name, or replace it with --force")
    other = next((t for t in sources if not is_source(t)), None)
    if other is not None:
        raise ValueError(f"{other} is no file that a scene.toml could name")
    built = build_sources(sources, slm=slm, wavelength=wavelength, **options)  # type: ignore[arg-type]
    for note in built.notes:
        click.echo(note)
    write_toml(built.world, out)
    click.echo(f"{out}: {len(built.world.entries)} objects; edit it, then chrmc generate {out}")
