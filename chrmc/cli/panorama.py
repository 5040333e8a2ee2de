"""`chrmc panorama`: the whole video in one picture, as in Fig. 14 of the paper."""

from pathlib import Path
from typing import Any

import click

from chrmc.cli.check import FrameList, chosen_frames, drawn_video

PANELS = (21, 51, 80)
"""Frames that the paper's Fig. 14 shows one by one."""


@click.command("panorama")
@drawn_video("In the panorama, such as 1,15:80 or all. [as many as do not overlap]")
@click.option(
    "--panels",
    type=FrameList(),
    default=None,
    help="Frames below it, one by one. [21,51,80 where there, else first, middle, last]",
)
def command(
    video: Path,
    out: Path,
    frames: list[tuple[int, int]] | None,
    panels: list[tuple[int, int]] | None,
) -> int:
    """Draw the video in DIR as one picture: moving objects at several moments, every object
    reconstructed at its own depth; below, single frames. A video in colours is drawn in them."""
    from chrmc.progress import progress
    from chrmc.store.colour import open_video
    from reconstruct.colour import balanced, colour_image, colour_systems
    from reconstruct.sequence import panorama, region_of, spread_frames

    stored = open_video(video)
    lasers = stored.channels
    every = chosen_frames([], stored)
    numbers = (
        spread_frames(lasers[0], stored.numbers)
        if frames is None
        else chosen_frames(frames, stored)
    )
    if panels is None:
        single = [n for n in PANELS if n in every]
        single = single or sorted({every[0], every[len(every) // 2], every[-1]})
    else:
        single = chosen_frames(panels, stored)
    systems = colour_systems(stored)
    wide = balanced(stored, [panorama(one, numbers).image for one in lasers])
    shown = {n: colour_image(stored, n, None, systems) for n in progress(single, "panorama")}
    draw(stored, wide, shown, numbers, region_of(lasers[0]), out)
    click.echo(f"{out}: frames {', '.join(str(n) for n in numbers)} in one, {len(shown)} below")
    return 0


def draw(
    stored: Any, wide: Any, shown: dict[int, Any], numbers: list[int], region: Any, out: Path
) -> None:
    """Write the picture.

    wide, shown : (H, W, lasers) intensities; shown by frame numbers
    """
    import numpy as np
    from matplotlib.figure import Figure

    from chrmc.figures import save, scale_bar
    from reconstruct.colour import colour_levels
    from reconstruct.sequence import common_scale, targets_of

    every = np.stack(list(shown.values()), axis=-1)
    white = max(common_scale(list(np.moveaxis(laser, -1, 0))) for laser in np.moveaxis(every, 2, 0))
    slm = stored.slm
    edges = [
        (s - (n - 1) / 2 - 0.5) * slm.pixel_pitch * 1e3
        for part, n in zip(region, slm.shape, strict=True)
        for s in (part.start, part.stop)
    ]
    extent = (edges[2], edges[3], edges[1], edges[0])
    ratio = (edges[1] - edges[0]) / (edges[3] - edges[2])
    width = 12.0
    count = max(len(shown), 1)
    height = width * ratio + width / count * ratio + 0.9
    figure = Figure(figsize=(width, height), layout="constrained")
    grid = figure.add_gridspec(2, count, height_ratios=[count, 1])
    pictures = [(figure.add_subplot(grid[0, :]), wide, f"frames {_listed(numbers)}", white)]
    for i, (number, image) in enumerate(shown.items()):
        depths = ", ".join(
            f"{t.name} {t.position[2] * 1e3:.1f} mm" for t in targets_of(stored, number)
        )
        # Smaller, so that single points fade: exposed longer.
        title = f"frame {number}: {depths}"
        pictures.append((figure.add_subplot(grid[1, i]), image, title, white / 4))
    for axis, image, title, top in pictures:
        levels = colour_levels(image[region], stored, top or 1.0)
        axis.imshow(levels, cmap="gray", vmin=0, vmax=255, extent=extent)
        axis.set_title(title, fontsize=9, loc="left")
        axis.set_xticks([])
        axis.set_yticks([])
        scale_bar(axis, extent)
    save(figure, out)


def _listed(numbers: list[int]) -> str:
    from chrmc.store.video import ranges

    return ranges(numbers).replace(":", " to ")
