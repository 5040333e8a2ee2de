"""`chrmc reconstruct`: what a hologram shows at a depth."""

from pathlib import Path

import click


@click.command("reconstruct")
@click.argument("video", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--frame", "number", type=int, required=True, help="Frame number, from 1.")
@click.option("--depth", type=float, required=True, help="Metres from the hologram.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    help="PNG for the eye, or EXR with float32 intensities.",
)
@click.option(
    "--gamma",
    type=click.FloatRange(0, min_open=True),
    default=2.2,
    show_default=True,
    help="Of the display a PNG is for; 1 makes grey proportional to intensity.",
)
@click.option(
    "--full-scale", type=float, default=None, help="Intensity shown as white. [2·ΣI²/ΣI]"
)
def command(
    video: Path,
    number: int,
    depth: float,
    out: Path,
    gamma: float,
    full_scale: float | None,
) -> int:
    """Reconstruct a frame of the video in DIR at a depth, through the numeric 4-f system.

    The picture has the SLM's pixels and orientation: a point at (x, y, DEPTH) appears at (x, y).
    """
    from chrmc.response import GreyResponse
    from chrmc.store import open_video
    from reconstruct.four_f import four_f
    from reconstruct.images import check_suffix, write_image

    check_suffix(out)
    stored = open_video(video)
    image = four_f(
        stored.read(number),
        stored.slm,
        stored.wavelength,
        depth,
        stored.encoding,
        response=GreyResponse.from_dict(stored.response),
        scale=stored.scale,
    )
    metadata = {
        "frame": number,
        "depth": depth,
        "wavelength": stored.wavelength,
        "pixel_pitch": stored.slm.pixel_pitch,
        "encoding": stored.encoding,
        "scene": stored.scene.get("name"),
    }
    write_image(out, image, metadata, full_scale, gamma)
    click.echo(f"{out}: frame {number} at {depth * 1e3:.3f} mm")
    return 0
