"""What `chrmc reconstruct` makes: one picture, all frames, a focal stack, a movie.

A video in one colour is one of a single laser: pictures are (H, W, lasers) throughout.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from chrmc.cli.lengths import parse_depths
from chrmc.cli.optics_options import BENCH_NAMES, bench_from, camera_from
from chrmc.files import into
from chrmc.progress import progress
from chrmc.scene.light import scenes_in_light
from chrmc.scene.scene import Scene
from chrmc.store.colour import ColourVideo, channel_name
from chrmc.store.video import Video
from reconstruct.animation import check_animation, write_animation
from reconstruct.colour import (
    colour_exposure,
    colour_image,
    colour_levels,
    colour_stack,
    colour_systems,
    luminance,
    write_picture,
)
from reconstruct.four_f_system import FourF
from reconstruct.images import check_suffix, write_counts, write_image
from reconstruct.looks import looks
from reconstruct.sequence import at_depth, following, region_of, shrink


@dataclass(frozen=True)
class Request:
    """What is asked of which video.

    systems : 4-f system of each laser
    scenes : the scene in each laser's light where looks are drawn, else empty
    depth_of : frame number → depth; None where --depth and --follow are not given
    options : the command's
    """

    video: Video | ColourVideo
    systems: list[FourF]
    scenes: list[Scene]
    depth_of: Callable[[int], float] | None
    options: dict[str, Any]

    def depth(self, number: int) -> float:
        """Where a frame is looked at; UsageError where nothing says so."""
        if self.depth_of is None:
            raise click.UsageError("say at which --depth, or which object to --follow")
        return self.depth_of(number)

    def levels(self, number: int) -> Iterator[list[NDArray[np.uint8]]]:
        """Grey levels of each laser, for one look after the other."""
        channels = self.video.channels
        if not self.scenes:
            yield [channel.read(number) for channel in channels]
            return
        count = self.options["looks"]
        drawn = [looks(c, s, number, count) for c, s in zip(channels, self.scenes, strict=True)]
        yield from progress((list(k) for k in zip(*drawn, strict=True)), "looks", count, "look")

    def image(self, number: int, depth: float | None) -> NDArray[np.float32]:
        """(H, W, lasers) intensities at a depth, every object at its own for None; mean of the
        looks."""
        total: Any = 0
        for levels in self.levels(number):
            total = total + colour_image(self.video, number, depth, self.systems, levels)
        return np.asarray(total / (self.options["looks"] or 1), dtype=np.float32)

    def small(self, image: NDArray[np.floating], white: float) -> NDArray[np.uint8]:
        """A picture of an animation."""
        width = self.options["width"]
        lasers = [shrink(image[..., k], width) for k in range(image.shape[-1])]
        return colour_levels(np.stack(lasers, -1), self.video, white, self.options["gamma"])

    def write(
        self, path: Path, image: NDArray[np.floating], number: int, depth: Any, white: Any
    ) -> None:
        """One picture, with its frame and depth."""
        note = {"frame": number, "depth": depth}
        write_picture(path, image, self.video, note, white, self.options["gamma"])


def request(video: Video | ColourVideo, options: dict[str, Any]) -> Request:
    """What the command's options ask of a video."""
    if options["depth"] is not None and options["follow"] is not None:
        raise click.UsageError("say at which --depth, or which object to --follow, not both")
    depth_of = None
    if options["follow"] is not None:
        depth_of = following(video.channels[0], options["follow"])
    elif options["depth"] is not None:
        depth_of = at_depth(options["depth"])
    bench = bench_from(**{name: options[name] for name in BENCH_NAMES})
    scenes: list[Scene] = []
    if options["looks"] is not None:
        from reconstruct.checking import scene_of

        scene = scene_of(video, options["scene"])
        one = len(video.channels) == 1
        scenes = [scene] if one else list(scenes_in_light(scene, video.wavelengths))
    return Request(video, colour_systems(video, bench), scenes, depth_of, options)


def one(asked: Request, out: Path) -> int:
    """One frame at one depth."""
    check_suffix(out)
    if asked.options["rendered"] is not None:
        check_suffix(asked.options["rendered"])
    video, options, number = asked.video, asked.options, asked.options["number"]
    video.entry(number)
    depth = asked.depth(number)
    image = asked.image(number, depth)
    written = str(out)
    if options["camera"] is not None:
        written = _photograph(asked, image, out)
    else:
        asked.write(out, image, number, depth, options["full_scale"])
    lasers = ", ".join(f"{w * 1e9:g}" for w in video.wavelengths)
    told = f", lasers of {lasers} nm" if len(video.channels) > 1 else ""
    click.echo(f"{written}: frame {number} at {depth * 1e3:.3f} mm{told}")
    if options["rendered"] is not None:
        from reconstruct.looks import rendered_like

        white = options["full_scale"] or colour_exposure(image)
        clouds = [scene.frame(number).cloud for scene in asked.scenes]
        view = rendered_like(image, clouds, asked.systems, depth)
        asked.write(options["rendered"], view, number, depth, white)
        click.echo(f"{options['rendered']}: the rendered view")
    if asked.scenes:
        for line in _likeness(asked, image, number, depth):
            click.echo(line)
    if options["energy"]:
        for line in _energy(asked, number):
            click.echo(line)
    return 0


def _likeness(
    asked: Request, image: NDArray[np.floating], number: int, depth: float
) -> Iterator[str]:
    """How near the objects in focus come to their rendered views."""
    frames, count = [s.frame(number) for s in asked.scenes], asked.options["looks"]
    if len(frames) == 1:
        from reconstruct.looks import compare_with_view

        for found in compare_with_view(image[..., 0], frames[0], asked.systems[0], depth):
            yield (
                f"  {found.name}: PSNR {found.psnr:.1f} dB, SSIM {found.ssim:.3f} against the "
                f"rendered view, {count} looks"
            )
        return
    from reconstruct.colour_likeness import compare_colours

    for seen in compare_colours(image, frames, asked.systems, depth):
        yield (
            f"  {seen.name}: colour difference (CIEDE2000) from the rendered view, {count} looks: "
            f"{seen.pixels:.1f} per pixel, {seen.cells:.1f} in squares of 8 pixels, "
            f"{seen.whole:.1f} on the whole"
        )


def _energy(asked: Request, number: int) -> Iterator[str]:
    """Where each laser's light went."""
    several = len(asked.systems) > 1
    for channel, system in zip(asked.video.channels, asked.systems, strict=True):
        account = system.energy(channel.read(number))
        if several:
            yield f"  {channel.wavelength * 1e9:g} nm:"
        for name in ("absorbed", "blocked_filter", "blocked_lenses", "image"):
            share = getattr(account, name) / account.incident
            yield f"  {name.replace('_', ' by '):<20}{share:>9.3%} of the light"


def _photograph(asked: Request, image: NDArray[np.floating], out: Path) -> str:
    """What a camera counts of each laser, at one full scale; the names of the files."""
    from chrmc.optics.propagation import Patch

    video, several = asked.video, len(asked.systems) > 1
    scale = asked.options["full_scale"] or (colour_exposure(image) or 1.0 if several else None)
    camera = camera_from(asked.options["camera"], scale)
    patch = Patch((0.0, 0.0), video.slm.shape, video.slm.pixel_pitch)
    paths = []
    for k, system in enumerate(asked.systems):
        name = f"{out.stem}_{channel_name(system.wavelength)}" if several else out.stem
        paths.append(out.with_stem(name))
        magnification = system.bench.magnification
        note = {
            "pixel_pitch": camera.pixel_pitch,
            "magnification": magnification,
            "wavelength": system.wavelength,
        }
        write_counts(paths[-1], camera.photograph(image[..., k], patch, magnification), note)
    return ", ".join(str(path) for path in paths)


def every(asked: Request, out: Path) -> int:
    """A picture per frame, and a preview that moves."""
    options = asked.options
    preview = options["preview"]
    if preview is not None:
        check_animation(preview)
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file; --all writes a folder")
    numbers = _numbers(asked)
    asked.depth(numbers[0])
    moving = []
    for number, image, white in into(out, _frames(asked, numbers, "reconstruct")):
        name = f"reconstruction_{number:04d}.{options['kind']}"
        asked.write(out / name, image, number, asked.depth(number), white)
        if preview is not None:
            moving.append(asked.small(image, white))
    if preview is not None:
        _animate(preview, moving, options["rate"], "frames")
    click.echo(f"{out}: {len(numbers)} frames")
    return 0


def movie(asked: Request) -> int:
    """Frames one after the other, cropped to what the video shows."""
    path = check_animation(asked.options["movie"])
    region = region_of(asked.video.channels[0])
    moving = [
        asked.small(image[region], white)
        for _, image, white in _frames(asked, _numbers(asked), "movie")
    ]
    _animate(path, moving, asked.options["rate"], "frames")
    return 0


def stack(asked: Request, out: Path) -> int:
    """One frame at many depths, the all-in-focus picture and its depth map."""
    from chrmc.optics.propagation import Patch
    from reconstruct.depth_map import draw_depth_map
    from reconstruct.stack import FocalStack, all_in_focus, at_depths

    video, options, number = asked.video, asked.options, asked.options["number"]
    if options["preview"] is not None:
        check_animation(options["preview"])
    ends, count = parse_depths(options["depths"])
    video.entry(number)
    depths = np.linspace(ends[0], ends[1], count)
    _warn_of_steps(asked, depths)
    planes = np.zeros((len(depths), *video.slm.shape, len(asked.systems)), dtype=np.float32)
    for levels in asked.levels(number):
        seen = colour_stack(video, depths.tolist(), asked.systems, levels)
        for i, plane in enumerate(progress(seen, "focal stack", len(depths), "depth")):
            planes[i] += plane
    planes /= options["looks"] or 1
    white = options["full_scale"] or float(np.median([colour_exposure(p) for p in planes]))
    suffix = options["kind"]
    for depth, plane in into(out, zip(depths, planes, strict=True)):
        name = f"depth_{depth * 1e3:08.3f}mm.{suffix}"
        asked.write(out / name, plane, number, float(depth), white)
    patch = Patch((0.0, 0.0), video.slm.shape, video.slm.pixel_pitch)
    # Lasers are sharp at the same depth; what the eye sees best decides.
    light, depth_map = all_in_focus(FocalStack(depths, luminance(planes, video.wavelengths), patch))
    image = at_depths(depths, planes, depth_map)
    asked.write(out / f"all_in_focus.{suffix}", image, number, ends, options["full_scale"])
    pitch = video.slm.pixel_pitch
    note = {"frame": number, "depth": ends, "pixel_pitch": pitch, "unit": "metre"}
    write_image(out / "depth_map.exr", depth_map, note)
    draw_depth_map(light, depth_map, pitch, out / "depth_map.png")
    click.echo(f"{out}: frame {number} at {len(depths)} depths, all in focus, depth map")
    if options["preview"] is not None:
        moving = [asked.small(plane, white) for plane in planes]
        _animate(options["preview"], moving, options["rate"], "depths")
    return 0


def _warn_of_steps(asked: Request, depths: NDArray[np.float64]) -> None:
    """Say where the depths are too far apart for the laser of the least depth of focus."""
    from chrmc.optics.resolution import depth_of_focus

    slm, near, step = asked.video.slm, float(depths[0]), float(depths[1] - depths[0])
    sharp_for = min(
        min(depth_of_focus(slm, system.wavelength, near, system.band)) for system in asked.systems
    )
    if step > sharp_for:
        enough = int(np.ceil((depths[-1] - near) / sharp_for)) + 1
        click.echo(
            f"warning: steps of {step * 1e3:.2f} mm are coarser than the depth of focus, "
            f"{sharp_for * 1e3:.2f} mm: what lies between two depths stays blurred; {enough} "
            "depths see everything",
            err=True,
        )


def _numbers(asked: Request) -> list[int]:
    """The frames asked for, all by default."""
    numbers = list(asked.video.numbers)
    if asked.options["frames"] is not None:
        first, last = asked.options["frames"]
        asked.video.entry(first), asked.video.entry(last)
        numbers = [n for n in numbers if first <= n <= last]
    if not numbers:
        raise ValueError(f"{asked.video.folder} has no such frames")
    return numbers


def _frames(
    asked: Request, numbers: list[int], label: str
) -> Iterator[tuple[int, NDArray[np.float32], float]]:
    """Number, picture, and the white of the first that is lit: one per frame would flicker."""
    white = asked.options["full_scale"]
    for number in progress(numbers, label):
        depth = None if asked.depth_of is None else asked.depth_of(number)
        image = asked.image(number, depth)
        white = white or colour_exposure(image) or None
        yield number, image, white or 1.0


def _animate(path: Path, moving: list[NDArray[np.uint8]], rate: float, what: str) -> None:
    write_animation(path, moving, rate)
    click.echo(f"{path}: {len(moving)} {what} at {rate:g} a second")
