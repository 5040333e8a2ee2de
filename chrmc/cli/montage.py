"""`chrmc montage`: holograms, and what they show at each object's depth; it ends a demo too."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from chrmc.cli.check import chosen_frames, drawn_video
from chrmc.store.colour import ColourVideo
from chrmc.store.video import Video

MARGIN = 0.5e-3
"""Room around the objects, metres."""


FRAMES = (1, 21, 51, 80)
"""The frames that the paper shows, and the first."""


def shown_frames(there: Sequence[int]) -> list[int]:
    """Those of `FRAMES` that a video has; else its first and last."""
    return [n for n in FRAMES if n in there] or sorted({there[0], there[-1]})


@click.command("montage")
@drawn_video("Such as 1,15:18. [1,21,51,80 where there, else first and last]")
def command(video: Path, out: Path, frames: list[tuple[int, int]] | None) -> int:
    """Draw frames of the video in DIR: each hologram, and what it shows at each object's depth. A
    video in colours is drawn in them."""
    from chrmc.store.colour import open_video

    stored = open_video(video)
    every = chosen_frames([], stored)
    numbers = shown_frames(every) if frames is None else chosen_frames(frames, stored)
    draw_montage(stored, numbers, out)
    click.echo(f"{out}: frames {', '.join(str(n) for n in numbers)}")
    return 0


def draw_montage(video: Video | ColourVideo, numbers: Sequence[int], path: Path) -> None:
    """Picture (PNG, PDF, SVG) of the given frames: the hologram, then a reconstruction at each
    object's depth with the object itself enlarged; in colour of a video in colours."""
    from chrmc.figures import new_figure, save
    from reconstruct.colour import balanced, colour_systems

    names = [o["name"] for o in video.entry(numbers[0])["objects"]]
    coloured = isinstance(video, ColourVideo)
    systems = colour_systems(video)
    view = _view(video, numbers)
    wide = (view[1] - view[0]) / (view[3] - view[2])
    height = 2.4
    ratio = video.slm.width / video.slm.height
    widths = [ratio] + [wide] * len(names)
    figure, axes = new_figure(
        (sum(widths) * height + 0.6, (height + 0.28) * len(numbers) + 0.1),
        len(numbers),
        len(widths),
        width_ratios=widths,
        squeeze=False,
    )
    for row, number in zip(axes, numbers, strict=True):
        frame = video.read(number)
        entry = video.entry(number)
        _show_hologram(row[0], frame, number, video)
        layers = frame if coloured else frame[..., None]
        fields = [system.field(layers[..., k]) for k, system in enumerate(systems)]
        for cell, name in zip(row[1:], names, strict=True):
            obj = next(o for o in entry["objects"] if o["name"] == name)
            _style(cell)
            if obj["depth"] is None:
                cell.set_title(f"{name}: nothing visible", fontsize=9)
                continue
            images = [
                np.abs(system.at(field, obj["depth"]))
                for system, field in zip(systems, fields, strict=True)
            ]
            amplitude = np.sqrt(balanced(video, [image**2 for image in images]))
            _show_depth(cell, amplitude, video, view, obj, entry["objects"])
    save(figure, path)


def _view(video: Video | ColourVideo, numbers: Sequence[int]) -> tuple[float, float, float, float]:
    """(x0, x1, y0, y1) metres around all objects of the frames, clipped to the panel."""
    boxes = [o["box"] for n in numbers for o in video.entry(n)["objects"] if o.get("box")]
    half_x = video.slm.width * video.slm.pixel_pitch / 2
    half_y = video.slm.height * video.slm.pixel_pitch / 2
    if not boxes:
        return -half_x, half_x, -half_y, half_y
    low = np.min([b[0] for b in boxes], axis=0) - MARGIN
    high = np.max([b[1] for b in boxes], axis=0) + MARGIN
    return (
        max(low[0], -half_x),
        min(high[0], half_x),
        max(low[1], -half_y),
        min(high[1], half_y),
    )


def _free_corner(
    view: tuple[float, float, float, float],
    size: tuple[float, float],
    objects: Sequence[dict[str, Any]],
) -> tuple[float, float]:
    """Lower left corner, in axis shares, of an inset of `size` that hides the objects least."""
    corners = [(x, y) for x in (0.005, 0.995 - size[0]) for y in (0.015, 0.985 - size[1])]

    def hidden(corner: tuple[float, float]) -> float:
        total = 0.0
        for obj in objects:
            if not obj.get("box"):
                continue
            low, high = np.asarray(obj["box"])[:, :2] + np.array([[-MARGIN], [MARGIN]])
            # y grows downwards in the scene and upwards in axis shares.
            x = (np.array([low[0], high[0]]) - view[0]) / (view[1] - view[0])
            y = (view[3] - np.array([high[1], low[1]])) / (view[3] - view[2])
            width = min(x[1], corner[0] + size[0]) - max(x[0], corner[0])
            height = min(y[1], corner[1] + size[1]) - max(y[0], corner[1])
            total += max(width, 0) * max(height, 0)
        return total

    return min(corners, key=hidden)


def _style(axis: Any) -> None:
    axis.set_xticks([])
    axis.set_yticks([])
    axis.set_facecolor("black")


def _show_hologram(
    axis: Any, frame: NDArray[np.uint8], number: int, video: Video | ColourVideo
) -> None:
    _style(axis)
    if frame.ndim == 3 and frame.shape[2] != 3:
        frame = frame[..., 0]
    axis.imshow(frame, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axis.set_title(
        f"frame {number}: {video.slm.width} × {video.slm.height} hologram",
        fontsize=9,
        loc="left",
    )
    # Fringes are finer than a montage can show: a part of them pixel by pixel.
    inset = axis.inset_axes((0.0, 0.0, 0.38, 0.38))
    _style(inset)
    rows, columns = (n // 2 for n in frame.shape[:2])
    size = max(min(rows, columns) // 8, 1)
    part = frame[rows - size : rows + size, columns - size : columns + size]
    inset.imshow(part, cmap="gray", interpolation="nearest")
    for spine in inset.spines.values():
        spine.set_color("white")


def _show_depth(
    axis: Any,
    amplitude: NDArray[np.floating],
    video: Video | ColourVideo,
    view: tuple[float, float, float, float],
    obj: dict[str, Any],
    others: Sequence[dict[str, Any]],
) -> None:
    """Amplitude (a square root of intensity, nearer to how an eye sees) over the view."""
    from chrmc.figures import scale_bar

    slm = video.slm
    half_x, half_y = slm.width * slm.pixel_pitch / 2, slm.height * slm.pixel_pitch / 2
    low, high = np.asarray(obj["box"][0]), np.asarray(obj["box"][1])
    inside = amplitude[
        max(int((low[1] + half_y) / slm.pixel_pitch), 0) : int((high[1] + half_y) / slm.pixel_pitch)
        + 1,
        max(int((low[0] + half_x) / slm.pixel_pitch), 0) : int((high[0] + half_x) / slm.pixel_pitch)
        + 1,
    ]
    white = float(np.percentile(inside, 98)) if inside.size else float(amplitude.max())
    extent = (-half_x * 1e3, half_x * 1e3, half_y * 1e3, -half_y * 1e3)
    show = {"cmap": "gray", "vmin": 0, "vmax": max(white, 1e-30), "extent": extent}
    picture: Any = amplitude[..., 0]
    if len(video.channels) > 1:
        from reconstruct.colour import colour_levels

        picture = colour_levels(amplitude**2, video, max(white, 1e-30) ** 2)
    axis.imshow(picture, interpolation="antialiased", **show)
    axis.set_xlim(view[0] * 1e3, view[1] * 1e3)
    axis.set_ylim(view[3] * 1e3, view[2] * 1e3)
    scale_bar(axis, (view[0] * 1e3, view[1] * 1e3, view[3] * 1e3, view[2] * 1e3))
    axis.set_title(
        f"focused on the {obj['name']}, {obj['depth'] * 1e3:.2f} mm",
        fontsize=9,
        loc="left",
    )
    centre = (low + high)[:2] / 2
    size = (0.26, 0.56)
    aspect = size[0] * (view[1] - view[0]) / (size[1] * (view[3] - view[2]))
    span = max((high - low)[0] / aspect, (high - low)[1]) * 0.58
    if 2 * span > size[1] * (view[3] - view[2]):
        return  # it fills the view: an inset would show it smaller
    inset = axis.inset_axes((*_free_corner(view, size, others), *size))
    _style(inset)
    inset.imshow(picture, interpolation="nearest", **show)
    inset.set_xlim((centre[0] - span * aspect) * 1e3, (centre[0] + span * aspect) * 1e3)
    inset.set_ylim((centre[1] + span) * 1e3, (centre[1] - span) * 1e3)
