"""One picture of a scene: a few frames, their light and their depth."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chrmc.figures import new_figure, save
from chrmc.scene.rgbd_scene import RGBDScene


def preview_frames(frame_count: int, columns: int = 4) -> list[int]:
    """Frame numbers spread over a scene, first and last included."""
    return sorted({round(n) for n in np.linspace(1, frame_count, min(columns, frame_count))})


def write_preview(scene: RGBDScene, path: Path, numbers: Sequence[int] | None = None) -> None:
    """The intensity of some frames above their depth in millimetres; .png, .pdf or .svg."""
    shown = list(numbers) if numbers else preview_frames(scene.frame_count)
    frames = [scene.rgbd(n) for n in shown]
    height, width = scene.shape
    pitch = scene.pixel_pitch * 1e3
    lit = np.concatenate([f.depth[f.lit] for f in frames]) * 1e3
    near, far = (lit.min(), lit.max()) if len(lit) else (0.0, 1.0)
    white = max((float(f.intensity.max()) for f in frames), default=0) or 1.0
    rows, columns = np.nonzero(np.logical_or.reduce([f.lit for f in frames]))
    # Only where anything is lit, with a margin of a tenth.
    left, right = _margin(columns, width, pitch)
    top, bottom = _margin(rows, height, pitch)
    figure, axes = new_figure(
        (3.6 * len(shown) + 1, 3.6 * 2 * (bottom - top) / (right - left) + 1.6),
        2, len(shown), squeeze=False, sharex=True, sharey=True,
    )  # fmt: skip
    extent = (-width * pitch / 2, width * pitch / 2, height * pitch / 2, -height * pitch / 2)
    for column, (number, frame) in enumerate(zip(shown, frames, strict=True)):
        depth = np.where(frame.lit, frame.depth * 1e3, np.nan)
        light, far_near = axes[:, column]
        light.imshow(frame.intensity, cmap="gray", vmin=0, vmax=white, extent=extent)
        drawn = far_near.imshow(depth, cmap="viridis", vmin=near, vmax=far, extent=extent)
        far_near.set_facecolor("black")
        light.set_title(f"{scene.name}, frame {number}", fontsize=9)
        far_near.set_xlabel("x / mm", fontsize=8)
    for axis in axes.ravel():
        axis.set(xlim=(left, right), ylim=(bottom, top))
        axis.tick_params(labelsize=7)
    for axis in axes[:, 0]:
        axis.set_ylabel("y / mm (down)", fontsize=8)
    figure.colorbar(drawn, ax=axes, label="depth z / mm", shrink=0.8)
    save(figure, path, dpi=110)


def _margin(lit: NDArray[np.intp], count: int, pitch: float) -> tuple[float, float]:
    """Bounds of lit pixel indices in millimetres, with a margin; the whole raster when none is."""
    first, last = (float(lit.min()), float(lit.max())) if len(lit) else (0.0, count - 1.0)
    margin = 0.1 * (last - first) + 4
    first, last = max(first - margin, -0.5), min(last + margin, count - 0.5)
    return (first - (count - 1) / 2) * pitch, (last - (count - 1) / 2) * pitch
