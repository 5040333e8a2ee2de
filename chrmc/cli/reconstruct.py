"""`chrmc reconstruct`: what a hologram, or a whole video of them, shows at a depth."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.arguments import frames_option
from chrmc.cli.lengths import DEPTH, Length, parse_depths
from chrmc.cli.optics_options import BENCH_NAMES, POSITIVE, bench_from, bench_options, camera_from
from chrmc.files import into


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
    help="PITCH or PITCH:BITS: what a camera of that pixel pitch, as 3.45um, counts, as a PNG.",
)
@click.option("--energy", is_flag=True, help="Print where the light went.")
@bench_options
def command(video: Path, out: Path | None, **options: Any) -> int:
    """Reconstruct frames of the video in DIR at a depth, through the numeric 4-f system.

    Pictures have the SLM's pixels and orientation: a point at (x, y, DEPTH) appears at (x, y).

    \b
    chrmc reconstruct DIR --frame 21 --depth 252mm --out car.png
    chrmc reconstruct DIR --all --follow car --out FOLDER --preview car.gif
    chrmc reconstruct DIR --frame 21 --depths 245mm:270mm:51 --out FOLDER
    chrmc reconstruct DIR --frame 21 --follow car --looks 20 --out car.png
    chrmc reconstruct DIR --movie all.mp4
    """
    from chrmc.store.colour import ColourVideo, open_video

    movie, everything = options["movie"] is not None, options["everything"]
    if movie and (everything or options["depths"] or options["number"] is not None):
        raise click.UsageError("--movie goes without --all, --depths and --frame")
    if not movie and out is None:
        raise click.UsageError("say where to write, with --out")
    if everything and options["depths"]:
        raise click.UsageError("--all and --depths exclude each other")
    if not movie and not everything and options["number"] is None:
        raise click.UsageError("say which --frame, or --all")
    stored = open_video(video)
    if isinstance(stored, ColourVideo):
        from chrmc.cli.reconstruct_colour import reconstruct_colours

        said = options["depth"] is not None or options["follow"] is not None
        free = not said and (movie or options["depths"])
        depth_of = None if free else _depth_of(stored.channels[0], options)
        return reconstruct_colours(stored, out, options, depth_of)
    if movie:
        return _movie(stored, options)
    make = _all if everything else _stack if options["depths"] else _one
    return make(stored, out, options)


def _depth_of(stored: Any, options: dict[str, Any]) -> Any:
    """A function from frame number to depth."""
    from reconstruct.sequence import at_depth, following

    if (options["depth"] is None) == (options["follow"] is None):
        raise click.UsageError("say at which --depth, or which object to --follow")
    if options["follow"] is not None:
        return following(stored, options["follow"])
    return at_depth(options["depth"])


def _system(stored: Any, options: dict[str, Any]) -> Any:
    from reconstruct.sequence import system_of

    return system_of(stored, bench_from(**{name: options[name] for name in BENCH_NAMES}))


def _note(stored: Any, number: int, depth: float) -> dict[str, Any]:
    """Metadata of a picture."""
    return {
        "frame": number,
        "depth": depth,
        "wavelength": stored.wavelength,
        "pixel_pitch": stored.slm.pixel_pitch,
        "encoding": stored.encoding,
        "scene": stored.scene.get("name"),
    }


def _one(stored: Any, out: Any, options: dict[str, Any]) -> int:
    """One frame at one depth."""
    from reconstruct.images import check_suffix, write_image

    check_suffix(out)
    number = options["number"]
    stored.entry(number)
    depth = _depth_of(stored, options)(number)
    system = _system(stored, options)
    image, scene = _image(stored, system, number, depth, options)
    if options["camera"] is not None:
        _photograph(stored, system, image, out, options)
    else:
        note = _note(stored, number, depth)
        write_image(out, image, note, options["full_scale"], options["gamma"])
    click.echo(f"{out}: frame {number} at {depth * 1e3:.3f} mm")
    if scene is not None:
        from reconstruct.looks import compare_with_view

        for found in compare_with_view(image, scene.frame(number), system, depth):
            click.echo(
                f"  {found.name}: PSNR {found.psnr:.1f} dB, SSIM {found.ssim:.3f} against the "
                f"rendered view, {options['looks']} looks"
            )
    if options["energy"]:
        account = system.energy(stored.read(number))
        for name in ("absorbed", "blocked_filter", "blocked_lenses", "image"):
            share = getattr(account, name) / account.incident
            click.echo(f"  {name.replace('_', ' by '):<20}{share:>9.3%} of the light")
    return 0


def _image(
    stored: Any, system: Any, number: int, depth: float, options: dict[str, Any]
) -> tuple[Any, Any]:
    """Intensity at a depth, the mean of the looks asked for, and the scene that they needed."""
    if options["looks"] is None:
        return system.image(stored.read(number), depth), None
    from chrmc.progress import progress
    from reconstruct.looks import looks

    scene = _scene(stored, options)
    made = looks(stored, scene, number, options["looks"])
    shown = [system.image(f, depth) for f in progress(made, "looks", options["looks"])]
    return sum(shown) / len(shown), scene


def _movie(stored: Any, options: dict[str, Any]) -> int:
    """Frames one after the other, cropped to what the video shows."""
    import numpy as np

    from chrmc.progress import progress
    from reconstruct.animation import check_animation, write_animation
    from reconstruct.images import exposure, to_grey
    from reconstruct.looks import looks
    from reconstruct.sequence import composite, region_of, shrink

    check_animation(options["movie"])
    numbers_ = _numbers(stored, options)
    system, region = _system(stored, options), region_of(stored)
    fixed = options["depth"] is not None or options["follow"] is not None
    depth_of = _depth_of(stored, options) if fixed else None
    scene = None if options["looks"] is None else _scene(stored, options)
    white, moving = options["full_scale"], []
    for number in progress(numbers_, "movie"):
        levels = [stored.read(number)]
        if scene is not None:
            levels = list(looks(stored, scene, number, options["looks"]))
        shown = [
            system.image(level, depth_of(number))
            if depth_of is not None
            else composite(stored, number, system, levels=level).image
            for level in levels
        ]
        image = np.mean(shown, axis=0)
        white = white or exposure(image) or None
        small = shrink(image[region], options["width"])
        moving.append(to_grey(small, white or 1.0, options["gamma"]))
    write_animation(options["movie"], moving, options["rate"])
    click.echo(f"{options['movie']}: {len(moving)} frames at {options['rate']:g} a second")
    return 0


def _scene(stored: Any, options: dict[str, Any]) -> Any:
    """What the video was made of."""
    from reconstruct.checking import scene_of

    return scene_of(stored, options["scene"])


def _numbers(stored: Any, options: dict[str, Any]) -> list[int]:
    """The frames asked for, all by default."""
    numbers_ = list(stored.numbers)
    if options["frames"] is not None:
        first, last = options["frames"]
        stored.entry(first), stored.entry(last)
        numbers_ = [n for n in numbers_ if first <= n <= last]
    if not numbers_:
        raise ValueError(f"{stored.folder} has no such frames")
    return numbers_


def _photograph(stored: Any, system: Any, image: Any, out: Path, options: dict[str, Any]) -> None:
    """What a camera counts, written unchanged."""
    from chrmc.optics.propagation import Patch
    from reconstruct.images import write_counts

    camera = camera_from(options["camera"], options["full_scale"])
    patch = Patch((0.0, 0.0), stored.slm.shape, stored.slm.pixel_pitch)
    counts = camera.photograph(image, patch, system.bench.magnification)
    note = {"pixel_pitch": camera.pixel_pitch, "magnification": system.bench.magnification}
    write_counts(out, counts, note)


def _stack(stored: Any, out: Any, options: dict[str, Any]) -> int:
    """One frame at many depths, the all-in-focus picture and its depth map."""
    import numpy as np

    from chrmc.optics.propagation import Patch
    from chrmc.optics.resolution import depth_of_focus
    from chrmc.progress import progress
    from reconstruct.animation import check_animation, write_animation
    from reconstruct.depth_map import draw_depth_map
    from reconstruct.images import exposure, to_grey, write_image
    from reconstruct.sequence import shrink
    from reconstruct.stack import FocalStack, all_in_focus

    preview = options["preview"]
    if preview is not None:
        check_animation(preview)
    ends, count = parse_depths(options["depths"])
    number = options["number"]
    depths = np.linspace(ends[0], ends[1], count)
    system = _system(stored, options)
    sharp_for = min(depth_of_focus(stored.slm, stored.wavelength, ends[0], system.band))
    if depths[1] - depths[0] > sharp_for:
        enough = int(np.ceil((ends[1] - ends[0]) / sharp_for)) + 1
        click.echo(
            f"warning: steps of {(depths[1] - depths[0]) * 1e3:.2f} mm are coarser than the depth "
            f"of focus, {sharp_for * 1e3:.2f} mm: what lies between two depths stays blurred; "
            f"{enough} depths see everything",
            err=True,
        )
    field = system.field(stored.read(number))
    planes = np.empty((len(depths), *stored.slm.shape), dtype=np.float32)
    for i, depth in enumerate(progress(depths, "focal stack", unit="depth")):
        planes[i] = np.abs(system.at(field, float(depth))) ** 2
    white = options["full_scale"] or float(np.median([exposure(p) for p in planes]))
    suffix = options["kind"]
    for depth, plane in into(out, zip(depths, planes, strict=True)):
        name = f"depth_{depth * 1e3:08.3f}mm.{suffix}"
        write_image(out / name, plane, _note(stored, number, float(depth)), white, options["gamma"])
    patch = Patch((0.0, 0.0), stored.slm.shape, stored.slm.pixel_pitch)
    image, depth_map = all_in_focus(FocalStack(depths, planes, patch))
    note = _note(stored, number, float("nan")) | {"depth": ends}
    sharp = out / f"all_in_focus.{suffix}"
    write_image(sharp, image, note, options["full_scale"], options["gamma"])
    write_image(out / "depth_map.exr", depth_map, note | {"unit": "metre"})
    draw_depth_map(image, depth_map, stored.slm.pixel_pitch, out / "depth_map.png")
    click.echo(f"{out}: frame {number} at {len(depths)} depths, all in focus, depth map")
    if preview is not None:
        small = [to_grey(shrink(p, options["width"]), white, options["gamma"]) for p in planes]
        write_animation(preview, small, options["rate"])
        click.echo(f"{preview}: {len(small)} depths at {options['rate']:g} a second")
    return 0


def _all(stored: Any, out: Any, options: dict[str, Any]) -> int:
    """A picture per frame, and a preview that moves."""
    from chrmc.progress import progress
    from reconstruct.animation import check_animation, write_animation
    from reconstruct.images import exposure, to_grey, write_image
    from reconstruct.sequence import reconstruct_all, shrink

    preview = options["preview"]
    if preview is not None:
        check_animation(preview)
    numbers_ = _numbers(stored, options)
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file; --all writes a folder")
    depth_of = _depth_of(stored, options)
    shown = reconstruct_all(stored, depth_of, numbers_, _system(stored, options))
    # One white for all, from the first frame: a white per frame would flicker.
    white, moving = options["full_scale"], []
    for frame in into(out, progress(shown, "reconstruct", len(numbers_))):
        if not white:
            white = exposure(frame.image) or None
        name = f"reconstruction_{frame.number:04d}.{options['kind']}"
        note = _note(stored, frame.number, frame.depth)
        write_image(out / name, frame.image, note, white or 1.0, options["gamma"])
        if preview is not None:
            small = shrink(frame.image, options["width"])
            moving.append(to_grey(small, white or 1.0, options["gamma"]))
    if preview is not None:
        write_animation(preview, moving, options["rate"])
        click.echo(f"{preview}: {len(moving)} frames at {options['rate']:g} a second")
    click.echo(f"{out}: {len(numbers_)} frames")
    return 0
