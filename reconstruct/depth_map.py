"""The depth map of a focal stack as a picture."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def draw_depth_map(
    image: NDArray[np.floating], depth_map: NDArray[np.floating], pixel_pitch: float, path: Path
) -> None:
    """Write a figure in which colour is depth and brightness is light.

    image : (H, W) all-in-focus intensity; depth_map : (H, W) metres
    """
    from scipy.ndimage import gaussian_filter

    from chrmc.figures import new_figure, save

    half_y, half_x = (n * pixel_pitch * 500 for n in image.shape)
    light = gaussian_filter(image, 3.0)
    light = np.clip(5 * light / (float(light.max()) or 1.0), 0, 1)
    figure, axis = new_figure((9.0, 9.0 * half_y / half_x + 0.4))
    shown = axis.imshow(
        depth_map * 1e3,
        cmap="viridis",
        alpha=light,
        extent=(-half_x, half_x, half_y, -half_y),
    )
    axis.set_facecolor("white")
    rows, columns = (np.flatnonzero(light.max(axis=k) > 0.1) for k in (1, 0))
    if len(rows) and len(columns):
        y, x = ((np.array(k)[[0, -1]] * pixel_pitch * 1e3) for k in (rows, columns))
        axis.set_xlim(max(x[0] - half_x - 0.5, -half_x), min(x[1] - half_x + 0.5, half_x))
        axis.set_ylim(min(y[1] - half_y + 0.5, half_y), max(y[0] - half_y - 0.5, -half_y))
    axis.set(xlabel="x (mm)", ylabel="y (mm)", title="depth of what is sharp, all in focus")
    figure.colorbar(shown, ax=axis, label="depth (mm)").solids.set_alpha(1)
    save(figure, path)
