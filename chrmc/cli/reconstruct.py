"""`chrmc reconstruct`: what a hologram, or a whole video of them, shows at a depth."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import frames_option
from chrmc.cli.lengths import DEPTH, Length
from chrmc.cli.optics_options import POSITIVE, bench_options


@click.command("reconstruct")
@click.argument("video", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--frame", "number", type=int, default=None, help="Frame number, from 1.")
@click.option("--depth", type=Length(DEPTH), default=None, help="From the hologram, as 252mm.")
@click.option("--follow", default=None, help="Object whose depth is shown, instead of --depth.")
@click.option(
    "--depths",
    default=None,
    help="NEAR:FAR:COUNT, as 245mm:270mm:51: a focal stack, all in focus, and a depth map.",
)
@click.option("--all", "everything", is_flag=True, help="All frames (or --frames) into a folder.")
@frames_option
@click.option(
    "--movie",
    type=click.Path(path_type=Path),
    default=None,
    help="All frames (or --frames) as one .mp4 or .gif, every object in focus unless --depth or "
    "--follow says otherwise.",
)
@click.option(
    "--looks",
    type=click.IntRange(1),
    default=None,
    help="Average so many draws of the points' phases, so that speckle fades, and compare the "
    "picture with the rendered view.",
)
@click.option(
    "--rendered",
    type=click.Path(path_type=Path),
    default=None,
    help="With --looks and --frame: also write that view, a PNG or EXR, as bright as the picture.",
)
@click.option(
    "--scene", default=None, help="What the video was made of, for --looks. [as its manifest says]"
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=None,
    help="PNG for the eye or EXR with float32 intensities; a folder with --all or --depths.",
)
@click.option(
    "--format",
    "kind",
    type=click.Choice(["png", "exr"]),
    default="png",
    show_default=True,
    help="Of the pictures in a folder.",
)
@click.option(
    "--preview",
    type=click.Path(path_type=Path),
    default=None,
    help="With --all or --depths: also an animation (.gif, .png) or movie (.mp4; chrmc[movie]).",
)
@click.option("--rate", type=POSITIVE, default=40.0, show_default=True, help="Its frames a second.")
@click.option("--width", type=click.IntRange(16), default=960, show_default=True, help="Its width.")
@click.option(
    "--gamma",
    type=POSITIVE,
    default=2.2,
    show_default=True,
    help="Of the display a PNG is for; 1 makes grey proportional to intensity.",
)
@click.option(
    "--full-scale", type=click.FloatRange(1e-30, 1e30), default=None,
    help="Intensity shown as white. [2·ΣI²/ΣI]",
)  # fmt: skip
@click.option(
    "--camera",
    default=None,
    help="PITCH or PITCH:BITS: what a camera of that pixel pitch, as 3.45um, counts, as a PNG; of "
    "several lasers one each.",
)
@click.option("--energy", is_flag=True, help="Print where the light went.")
@bench_options
def command(video: Path, out: Path | None, **options: Any) -> int:
    """Reconstruct frames of the video in DIR at a depth, through the numeric 4-f system.

    Pictures have the SLM's pixels and orientation: a point at (x, y, DEPTH) appears at (x, y). A
    video in colours is shown in them, an EXR of it in linear sRGB.

    \b
    chrmc reconstruct DIR --frame 21 --depth 252mm --out car.png
    chrmc reconstruct DIR --all --follow car --out FOLDER --preview car.gif
    chrmc reconstruct DIR --frame 21 --depths 245mm:270mm:51 --out FOLDER
    chrmc reconstruct DIR --frame 21 --follow car --looks 20 --out car.png
    chrmc reconstruct DIR --movie all.mp4
    """
    from chrmc.cli import reconstruct_pictures as pictures
    from chrmc.store.colour import open_video

    movie, everything = options["movie"] is not None, options["everything"]
    if movie and (everything or options["depths"] or options["number"] is not None):
        raise click.UsageError("--movie goes without --all, --depths and --frame")
    if not movie and out is None:
        raise click.UsageError("say where to write, with --out")
    alone = not (movie or everything or options["depths"])
    if options["rendered"] is not None and not (alone and options["looks"]):
        raise click.UsageError("--rendered goes with --looks, of one --frame at one depth")
    if everything and options["depths"]:
        raise click.UsageError("--all and --depths exclude each other")
    if not movie and not everything and options["number"] is None:
        raise click.UsageError("say which --frame, or --all")
    asked = pictures.request(open_video(video), options)
    if movie:
        return pictures.movie(asked)
    make = pictures.every if everything else pictures.stack if options["depths"] else pictures.one
    assert out is not None
    return make(asked, out)
