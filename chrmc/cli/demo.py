"""`chrmc demo`: the whole path on one scene, with pictures and a verdict."""

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import form_option, method_options, wavelengths_option


@click.command("demo")
@click.argument("scene", default="car-house")
@click.option("--scene", "chosen", default=None, help="The same as SCENE.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("demo"),
    show_default=True,
    help="Folder for the video and the pictures.",
)
@click.option(
    "--monitor", default=None, help="Also play full screen on this monitor. [headless only]"
)
@method_options
@form_option
@wavelengths_option
@click.option("--force", is_flag=True, help="Replace another video in the folder.")
def command(
    scene: str,
    chosen: str | None,
    out: Path,
    monitor: str | None,
    form: str,
    wavelength: float | tuple[float, ...] | None,
    force: bool,
    **methods: Any,
) -> int:
    """Make, play, reconstruct and check the holograms of SCENE [car-house], all frames.

    Ends with OUT/montage.png, focus curves, a table and the verdict; exit status 0 when every
    object is in focus where the scene says, 1 when not. Several wavelengths make it in colours:
    lasers in sequence, each judged, pictures of all together.
    """
    from chrmc.cli.check import command as check
    from chrmc.cli.montage import draw_montage, shown_frames
    from chrmc.cli.play import command as play
    from chrmc.files import replacing
    from chrmc.generation.colour import make_in_light
    from chrmc.scene.load import load_scene
    from chrmc.scene.origin import origin_of
    from chrmc.slm import LC_R_1080
    from chrmc.store.colour import open_video
    from chrmc.store.summary import summary

    folder = out / "video"
    finest = min(wavelength) if isinstance(wavelength, tuple) else wavelength
    given = load_scene(chosen or scene, form=form, wavelength=finest)
    choices = methods | {"source": origin_of((chosen or scene,), form, {}, given)}

    heading("1. Holograms")
    made = make_in_light(
        given, LC_R_1080, wavelength, choices, folder, force=force, tell=click.echo
    )
    video = open_video(folder)
    several = len(video.channels) > 1
    table: list[str] = []
    for channel in video.channels:
        table += [f"{channel.folder}:", *summary(channel)] if several else summary(channel)
    click.echo(f"{folder}: {made} made, {sum(map(len, video.channels)) - made} kept")
    for line in table:
        click.echo(line)

    heading("2. Playback")
    log = ["--log", str(out / "flips.csv")]
    where = ["--headless", "--verify"] if monitor is None else ["--monitor", monitor]
    try:
        play.main([str(folder), *where, *log], standalone_mode=False)
    except (ValueError, OSError) as error:
        if monitor is not None:
            raise
        click.echo(f"not played: {error}")

    heading("3. Reconstruction and focus")
    numbers = shown_frames(video.numbers)
    draw_montage(video, numbers, out / "montage.png")
    click.echo(f"pictures in {out / 'montage.png'}, focus curves in {out / 'focus.png'}")
    asked = ["--frames", ",".join(str(n) for n in numbers), "--plot", str(out / "focus.png")]
    verdict = StringIO()
    with redirect_stdout(verdict):
        status = check.main([str(folder), *asked], standalone_mode=False)
    click.echo(verdict.getvalue(), nl=False)
    with replacing(out / "summary.txt") as partial:
        partial.write_text("\n".join([*table, "", verdict.getvalue()]), encoding="utf-8")
    return int(status or 0)


def heading(text: str) -> None:
    """A line that parts the demo's steps."""
    click.echo(("" if text.startswith("1") else "\n") + text)
