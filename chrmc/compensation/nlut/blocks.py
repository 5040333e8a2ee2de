"""Motion vectors: where the block of an image went, to the pixel and to the depth plane."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud

MEASURES = ("sad", "mse")


@dataclass(frozen=True, eq=False)
class Image:
    """Intensity and depth of a cloud on the scene's pixel grid, of several points the nearest.

    origin : (row, column) of the first pixel, on a grid through the axis
    intensity : (H, W), 0 is dark
    plane : (H, W) depth in planes, rounded; meaningless where dark
    """

    origin: tuple[int, int]
    intensity: NDArray[np.float64]
    plane: NDArray[np.int64]


def grid_index(
    cloud: PointCloud, pixel_pitch: float, offset: tuple[float, float]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(N,) rows and columns of the points on the grid with a pixel centre at `offset` (x, y)."""
    column, row = np.rint((cloud.positions[:, :2] - np.array(offset)) / pixel_pitch).T
    return row.astype(np.int64), column.astype(np.int64)


def grid_offset(cloud: PointCloud, pixel_pitch: float) -> tuple[float, float]:
    """(x, y) of the grid's pixel centre next to the axis, the same for every cloud of a scene.

    RGB-D points all lie on the grid, so any of them tells.
    """
    if len(cloud) == 0:
        return 0.0, 0.0
    place = cloud.positions[0, :2] / pixel_pitch
    # The margin keeps rounding from choosing between two neighbours.
    x, y = (place - np.floor(place + 1e-6)) * pixel_pitch
    return float(x), float(y)


def image_of(
    cloud: PointCloud, pixel_pitch: float, plane_spacing: float, offset: tuple[float, float]
) -> Image:
    """The smallest image that holds a cloud."""
    if len(cloud) == 0:
        return Image((0, 0), np.zeros((0, 0)), np.zeros((0, 0), dtype=np.int64))
    row, column = grid_index(cloud, pixel_pitch, offset)
    origin = int(row.min()), int(column.min())
    shape = int(row.max()) - origin[0] + 1, int(column.max()) - origin[1] + 1
    intensity, plane = np.zeros(shape), np.zeros(shape, dtype=np.int64)
    order = np.argsort(-cloud.positions[:, 2], kind="stable")
    at = (row[order] - origin[0], column[order] - origin[1])
    intensity[at] = cloud.intensity[order]
    plane[at] = np.rint(cloud.positions[order, 2] / plane_spacing).astype(np.int64)
    return Image(origin, intensity, plane)


def crop(
    image: Image, row: int, column: int, shape: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Intensity and plane of a rectangle given on the grid, dark outside the image."""
    intensity, plane = np.zeros(shape), np.zeros(shape, dtype=np.int64)
    height, width = image.intensity.shape
    r0, c0 = row - image.origin[0], column - image.origin[1]
    inside_r = slice(max(r0, 0), min(r0 + shape[0], height))
    inside_c = slice(max(c0, 0), min(c0 + shape[1], width))
    if inside_r.start < inside_r.stop and inside_c.start < inside_c.stop:
        to = (
            slice(inside_r.start - r0, inside_r.stop - r0),
            slice(inside_c.start - c0, inside_c.stop - c0),
        )
        intensity[to] = image.intensity[inside_r, inside_c]
        plane[to] = image.plane[inside_r, inside_c]
    return intensity, plane


def lateral_vector(
    reference: NDArray[np.float64],
    at: tuple[int, int],
    image: Image,
    search: int,
    measure: str = "sad",
) -> tuple[int, int]:
    """(rows, columns) that a block moved by: full search, the shortest of equally good vectors.

    reference : the block's intensity; at : (row, column) of its first pixel on the grid
    search : the longest vector per axis, pixels
    measure : "sad" sum of absolute differences, or "mse" of squared ones
    """
    if measure not in MEASURES:
        raise ValueError(f"measure must be one of {', '.join(MEASURES)}, not {measure!r}")
    height, width = reference.shape
    around, _ = crop(
        image, at[0] - search, at[1] - search, (height + 2 * search, width + 2 * search)
    )
    difference = sliding_window_view(around, reference.shape) - reference
    cost = (np.abs(difference) if measure == "sad" else difference**2).sum(axis=(2, 3))
    step = np.arange(-search, search + 1)
    length = step[:, None] ** 2 + step**2
    # Rounding must not decide between vectors of the same cost.
    best = cost <= cost.min() + 1e-9 * (1 + cost.min())
    row, column = np.unravel_index(np.argmin(np.where(best, length, np.iinfo(int).max)), cost.shape)
    return int(row) - search, int(column) - search


def depth_vector(
    reference: NDArray[np.float64],
    reference_plane: NDArray[np.int64],
    intensity: NDArray[np.float64],
    plane: NDArray[np.int64],
    search: int,
) -> int:
    """Planes that a block moved by: the shift under which most pixels of its depth slices meet.

    reference, reference_plane : the block's intensity and plane; intensity, plane : of the place
    it moved to; search : the longest vector, planes
    """
    both = (reference > 0) & (intensity > 0)
    steps = (plane - reference_plane)[both]
    steps = steps[np.abs(steps) <= search]
    if steps.size == 0:
        return 0
    values, counts = np.unique(steps, return_counts=True)
    return int(min(values[counts == counts.max()], key=abs))
