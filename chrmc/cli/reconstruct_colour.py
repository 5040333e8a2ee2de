"""`chrmc reconstruct` of a video in colours: all its lasers in one picture."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

from chrmc.cli.optics_options import BENCH_NAMES, bench_from, camera_from

ONE_COLOUR = ("depths",)
"""Options that take a video of one colour."""


def reconstruct_colours(
    video: Any, out: Path | None, options: dict[str, Any], depth_of: Callable[[int], float] | None
) -> int:
    """One frame, all frames, or a movie.

    depth_of : frame number → depth; None shows every object at its own
    """
    for name in ONE_COLOUR:
        if options[name] is not None:
            folders = ", ".join(str(channel.folder) for channel in video.channels)
            raise ValueError(f"--{name} takes a video of one colour: {folders}")
    from reconstruct.colour import colour_systems

    systems = colour_systems(video, bench_from(**{name: options[name] for name in BENCH_NAMES}))
    lit = _lit(video, options)
    if options["movie"] is not None:
        return _movie(video, systems, lit, options, depth_of)
    assert out is not None and depth_of is not None
    if options["everything"]:
        return _all(video, systems, lit, out, options, depth_of)
    return _one(video, systems, lit, out, options, depth_of)


def _lit(video: Any, options: dict[str, Any]) -> Any:
    """The scene in each laser's light, where looks need it."""
    if options["looks"] is None:
        return None
    from chrmc.scene.light import scenes_in_light
    from reconstruct.checking import scene_of

    return scenes_in_light(scene_of(video, options["scene"]), video.wavelengths)


def _image(
    video: Any, systems: Any, lit: Any, number: int, depth: float | None, options: dict[str, Any]
) -> Any:
    """Balanced intensities, the mean of the looks asked for."""
    from chrmc.progress import progress
    from reconstruct.colour import colour_image
    from reconstruct.looks import looks

    if lit is None:
        return colour_image(video, number, depth, systems)
    count = options["looks"]
    drawn = (
        looks(channel, scene, number, count)
        for channel, scene in zip(video.channels, lit, strict=True)
    )
    total: Any = 0
    for levels in progress(zip(*drawn, strict=True), "looks", count):
        total = total + colour_image(video, number, depth, systems, levels)
    return total / count


def _one(
    video: Any,
    systems: Any,
    lit: Any,
    out: Path,
    options: dict[str, Any],
    depth_of: Callable[[int], float],
) -> int:
    from reconstruct.images import check_suffix

    check_suffix(out)
    number = options["number"]
    depth = depth_of(number)
    image = _image(video, systems, lit, number, depth, options)
    lasers = ", ".join(f"{w * 1e9:g}" for w in video.wavelengths)
    if options["camera"] is not None:
        written = _photograph(video, systems, image, out, options)
    else:
        _write(video, out, image, number, depth, options["full_scale"])
        written = str(out)
    click.echo(f"{written}: frame {number} at {depth * 1e3:.3f} mm, lasers of {lasers} nm")
    if lit is not None:
        from reconstruct.colour_likeness import compare_colours

        frames = [scene.frame(number) for scene in lit]
        for found in compare_colours(image, frames, systems, depth):
            click.echo(
                f"  {found.name}: colour difference (CIEDE2000) from the rendered view, "
                f"{options['looks']} looks: {found.pixels:.1f} per pixel, {found.cells:.1f} in "
                f"squares of 8 pixels, {found.whole:.1f} on the whole"
            )
    if options["energy"]:
        for channel, system in zip(video.channels, systems, strict=True):
            account = system.energy(channel.read(number))
            share = account.image / account.incident
            click.echo(f"  {channel.wavelength * 1e9:g} nm: {share:.3%} of the light in the image")
    return 0


def _photograph(video: Any, systems: Any, image: Any, out: Path, options: dict[str, Any]) -> str:
    """What a camera counts of each laser, at one full scale; the names of the files."""
    from chrmc.optics.propagation import Patch
    from chrmc.store.colour import channel_name
    from reconstruct.colour import colour_exposure
    from reconstruct.images import write_counts

    camera = camera_from(options["camera"], options["full_scale"] or colour_exposure(image) or 1.0)
    patch = Patch((0.0, 0.0), video.slm.shape, video.slm.pixel_pitch)
    paths = [out.with_stem(f"{out.stem}_{channel_name(w)}") for w in video.wavelengths]
    for k, (path, system) in enumerate(zip(paths, systems, strict=True)):
        magnification = system.bench.magnification
        counts = camera.photograph(image[..., k], patch, magnification)
        note = {
            "pixel_pitch": camera.pixel_pitch,
            "magnification": magnification,
            "wavelength": video.wavelengths[k],
        }
        write_counts(path, counts, note)
    return ", ".join(str(path) for path in paths)


def _all(
    video: Any,
    systems: Any,
    lit: Any,
    out: Path,
    options: dict[str, Any],
    depth_of: Callable[[int], float],
) -> int:
    from reconstruct.animation import check_animation, write_animation

    if options["preview"] is not None:
        check_animation(options["preview"])
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file; --all writes a folder")
    white, moving = options["full_scale"], []
    for number, image, white in _frames(video, systems, lit, options, depth_of):
        name = f"reconstruction_{number:04d}.{options['kind']}"
        _write(video, out / name, image, number, depth_of(number), white)
        if options["preview"] is not None:
            moving.append(_small(video, image, options["width"], white))
    if options["preview"] is not None:
        write_animation(options["preview"], moving, options["rate"])
        click.echo(f"{options['preview']}: {len(moving)} frames at {options['rate']:g} a second")
    click.echo(f"{out}: {len(video.numbers)} frames")
    return 0


def _movie(
    video: Any,
    systems: Any,
    lit: Any,
    options: dict[str, Any],
    depth_of: Callable[[int], float] | None,
) -> int:
    from reconstruct.animation import check_animation, write_animation
    from reconstruct.sequence import region_of

    check_animation(options["movie"])
    region = region_of(video.channels[0])
    moving = [
        _small(video, image[region], options["width"], white)
        for _, image, white in _frames(video, systems, lit, options, depth_of)
    ]
    write_animation(options["movie"], moving, options["rate"])
    click.echo(f"{options['movie']}: {len(moving)} frames at {options['rate']:g} a second")
    return 0


def _frames(
    video: Any,
    systems: Any,
    lit: Any,
    options: dict[str, Any],
    depth_of: Callable[[int], float] | None,
) -> Iterator[tuple[int, Any, float]]:
    """Number, balanced intensities, and the white of the first frame, which holds for all."""
    from chrmc.progress import progress
    from reconstruct.colour import colour_exposure

    asked = options["frames"]
    numbers = [n for n in video.numbers if asked is None or asked[0] <= n <= asked[1]]
    if not numbers:
        raise ValueError(f"{video.folder} has no such frames")
    white = options["full_scale"]
    for number in progress(numbers, "reconstruct"):
        depth = None if depth_of is None else depth_of(number)
        image = _image(video, systems, lit, number, depth, options)
        white = white or colour_exposure(image) or None
        yield number, image, white or 1.0


def _small(video: Any, image: Any, width: int, white: float) -> Any:
    import numpy as np

    from reconstruct.colour import colour_levels
    from reconstruct.sequence import shrink

    lasers = [shrink(image[..., k], width) for k in range(image.shape[-1])]
    return colour_levels(np.stack(lasers, axis=-1), video, white)


def _write(
    video: Any, path: Path, image: Any, number: int, depth: float, white: float | None
) -> None:
    """A PNG for the eye, or an EXR of linear sRGB."""
    from chrmc.colour import mixed
    from reconstruct.colour import colour_exposure, colour_levels
    from reconstruct.images import write_colour

    top = white or colour_exposure(image) or 1.0
    note = {
        "frame": number,
        "depth": depth,
        "wavelengths": list(video.wavelengths),
        "pixel_pitch": video.slm.pixel_pitch,
        "full_scale": top,
        "scene": video.scene.get("name"),
    }
    if path.suffix.lower() == ".exr":
        write_colour(path, mixed(image, video.wavelengths).astype("float32"), note)
    else:
        write_colour(path, colour_levels(image, video, top), note)
