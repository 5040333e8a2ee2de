"""At what depth a region is in focus, found without knowing it.

A rotated body is deeper than the depth of focus, and the sharpness of the whole region peaks
wherever its points happen to crowd, up to 0.5 mm from their mean. So the region is cut into tiles
of two scene pixels; each tile finds its own depth, the peak of ΣI²/(ΣI)² refined by a parabola;
the mean of the tiles' depths, weighted by the light that each holds in focus, is the intensity-
weighted mean depth of what is seen there: within 0.1 mm for bodies 1.4 mm deep, and for bodies
12 mm apart.

A surface denser than the resolution, or of smooth phase, is speckle or self-images at every
depth, and its tiles find nothing. What it has is an outline and a texture: so there the curve of
the whole region counts, the Tenengrad of the picture smoothed over a grain or two of speckle, and
the depth is the middle of its peak, within 0.25 mm.

Noise has no focus: its tiles scatter evenly over the range searched, with low peaks, and its curve
is flat, and that is how it is told.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch
from reconstruct.focus_metrics import metric_named, tenengrad
from reconstruct.stack import FocalStack

TILE_PROMINENCE = 2.0
"""Sharpness of a tile at its peak over its median, weighted mean of all: bodies far apart in depth
have 2.4 to 3, dense surfaces 1.5 to 1.9, noise and defocused light up to 1.4."""
SCATTER_LIMIT = 0.7
"""Tiles scattered wider than this share of an even scatter over the range show no focus: objects
of the test scenes reach 0.5, noise and defocused light 0.87 to 1.05."""
PROMINENCE = 7.0
"""What a region's smoothed curve must rise over its median, relative to it, times √(number of
grains in the region), to count as a focus: noise reaches 6.4, surfaces of 1 mm have 8 to 100."""
DARK = 0.005
"""Tiles with less than this share of the brightest tile's light do not count."""


@dataclass(frozen=True, eq=False)
class Focus:
    """Where a region is in focus.

    depth : metres; NaN where nothing is sharp
    front, rear : depths that the nearest and farthest tenth of the focused light lie beyond, metres
    scatter : weighted standard deviation of the tiles' depths, metres
    position : (x, y) centroid of the intensity at `depth`, metres
    depths, curve : (D,) and (D,) the region's focus curve, mean sharpness of the tiles
    tile_depth, tile_light : (m, n) each tile's depth (NaN where it has no peak) and focused light
    focused : whether something comes into focus, which noise does not
    method : "tiles" where they agree on a depth; "region" where only the whole region has one,
        and front and rear are unknown; by the scene's map of light "cells", or "rim" where
        all is speckle
    """

    depth: float
    front: float
    rear: float
    scatter: float
    position: tuple[float, float]
    depths: NDArray[np.float64]
    curve: NDArray[np.float64]
    tile_depth: NDArray[np.float64]
    tile_light: NDArray[np.float64]
    focused: bool
    method: str = "tiles"

    @property
    def error(self) -> float:
        """Standard error of a depth that is the mean of tiles', metres; 0 for others."""
        count = int(np.count_nonzero(np.isfinite(self.tile_depth) & (self.tile_light > 0)))
        told = self.method == "tiles" and self.focused and count
        return self.scatter / sqrt(count) if told else 0.0


def refine_peak(depths: NDArray[np.float64], curve: NDArray[np.float64]) -> float:
    """Depth of the largest value, refined by the parabola through its neighbours.

    NaN when the largest value is the first or last, where no peak is seen.
    """
    i = int(np.argmax(curve))
    if i == 0 or i == len(curve) - 1:
        return float("nan")
    a, b, c = (float(v) for v in curve[i - 1 : i + 2])
    bend = a - 2 * b + c
    offset = 0.5 * (a - c) / bend if bend < 0 else 0.0
    return float(depths[i] + offset * (depths[i + 1] - depths[i]))


def focus_curve(stack: FocalStack, metric: str = "variance") -> NDArray[np.float64]:
    """(D,) a published metric over the whole region at each depth."""
    measure = metric_named(metric)
    return np.array([measure(plane) for plane in stack.intensity])


@dataclass(frozen=True, eq=False)
class Cells:
    """A focal stack in square tiles.

    depths : (D,) metres
    light, square : (D, m, n) ΣI and ΣI² of each tile, as equal points would show
    """

    depths: NDArray[np.float64]
    light: NDArray[np.float64]
    square: NDArray[np.float64]

    @cached_property
    def sharpness(self) -> NDArray[np.float64]:
        """(D, m, n) ΣI²/(ΣI)²; 0 for darkness."""
        floor = float(self.light.mean()) * 1e-9 + 1e-150
        found: NDArray[np.float64] = self.square / (self.light + floor) ** 2
        return found

    @cached_property
    def best(self) -> NDArray[np.intp]:
        """(m, n) index of the depth at which each tile is sharpest."""
        return self.sharpness.argmax(axis=0)

    @cached_property
    def depth(self) -> NDArray[np.float64]:
        """(m, n) that depth, refined; NaN where a tile has no peak."""
        shape = self.best.shape
        found = [refine_peak(self.depths, self.sharpness[:, i, j]) for i, j in np.ndindex(*shape)]
        return np.array(found).reshape(shape)

    @cached_property
    def focused_light(self) -> NDArray[np.float64]:
        """(m, n) light of each tile where it is sharpest."""
        return np.take_along_axis(self.light, self.best[None], axis=0)[0]


def cells_of(stack: FocalStack, tile: int, brightness: NDArray[np.float64] | None = None) -> Cells:
    """Tiles of `tile` × `tile` samples; what is left over is dropped.

    brightness : (2, h, w) how bright equal points look at the first and the last depth
    """
    count, height, width = stack.intensity.shape
    tile = max(1, min(tile, height, width))
    m, n = height // tile, width // tile
    light, square = np.empty((2, count, m, n))
    for plane, first, second in zip(stack.intensity, light, square, strict=True):
        blocks = plane[: m * tile, : n * tile].astype(np.float64).reshape(m, tile, n, tile)
        first[:] = blocks.sum(axis=(1, 3))
        second[:] = (blocks * blocks).sum(axis=(1, 3))
    if brightness is not None:
        near, far = (
            b[: m * tile, : n * tile].reshape(m, tile, n, tile).mean(axis=(1, 3))
            for b in brightness
        )
        for i, way in enumerate(np.linspace(0, 1, count)):
            even = near + way * (far - near)
            light[i] /= even
            square[i] /= even**2
    return Cells(stack.depths, light, square)


def find_focus(
    stack: FocalStack,
    tile: int,
    brightness: NDArray[np.float64] | None = None,
    grain: float = 1.5,
) -> Focus:
    """The focus of a region.

    stack : intensities at five depths or more
    tile : side of a tile in samples, about two scene pixels
    brightness : (2, h, w) how bright equal points look at the first and the last depth
        (`reconstruct.stack.brightness`), taken out of weights and centroid; default equally
    grain : size of a speckle, samples
    """
    found = _focus_of_tiles(stack, tile, brightness)
    if found.focused or not found.tile_light.any():
        return found
    sigma = 1.4 * grain
    curve = smoothed_curve(stack, sigma)
    depth = peak_middle(stack.depths, curve)
    rise = float(curve.max()) / max(float(np.median(curve)), 1e-300) - 1
    grains = stack.patch.shape[0] * stack.patch.shape[1] / (2 * sigma) ** 2
    if not np.isfinite(depth) or rise * sqrt(grains) < PROMINENCE:
        return found
    index = int(np.argmin(np.abs(stack.depths - depth)))
    plane = stack.intensity[index] / brightness_at(stack, brightness, index)
    nan = float("nan")
    return replace(
        found,
        depth=depth,
        front=nan,
        rear=nan,
        scatter=nan,
        position=centroid(plane, stack.patch),
        curve=curve,
        focused=True,
        method="region",
    )


def smoothed_curve(stack: FocalStack, sigma: float) -> NDArray[np.float64]:
    """(D,) Tenengrad of each plane after a Gaussian of `sigma` samples took the speckle out."""
    from scipy.ndimage import gaussian_filter

    return np.array([tenengrad(gaussian_filter(plane, sigma)) for plane in stack.intensity])


def peak_middle(depths: NDArray[np.float64], curve: NDArray[np.float64]) -> float:
    """Centroid of a curve's main peak above half its height over the median; NaN where the peak
    reaches an end of the range."""
    top = int(np.argmax(curve))
    half = (float(curve[top]) + float(np.median(curve))) / 2
    below = np.flatnonzero(curve <= half)
    left, right = below[below < top], below[below > top]
    if not len(left) or not len(right):
        return float("nan")
    part = slice(int(left[-1]) + 1, int(right[0]))
    return float(np.average(depths[part], weights=curve[part] - half))


def _focus_of_tiles(stack: FocalStack, tile: int, brightness: NDArray[np.float64] | None) -> Focus:
    """The focus on which the tiles agree."""
    depths = stack.depths
    if len(depths) < 5:
        raise ValueError(f"a focus needs 5 depths or more, not {len(depths)}")
    cells = cells_of(stack, tile, brightness)
    light, sharpness = cells.light, cells.sharpness
    total = float(light.sum())
    nowhere = (float("nan"), float("nan"))
    if not total > 0:
        nan = float("nan")
        dark = np.zeros(light.shape[1:])
        return Focus(
            nan, nan, nan, nan, nowhere, depths, np.zeros(len(depths)), dark * nan, dark, False
        )
    mean_light = light.mean(axis=0)
    curve = np.einsum("dmn,mn->d", sharpness, mean_light) / mean_light.sum()
    tile_depth, tile_light, best = cells.depth, cells.focused_light, cells.best
    seen = np.isfinite(tile_depth) & (tile_light >= DARK * tile_light.max())
    if not seen.any():
        nan = float("nan")
        return Focus(nan, nan, nan, nan, nowhere, depths, curve, tile_depth, tile_light, False)
    z, weight = tile_depth[seen], tile_light[seen]
    mean, scatter = weighted_mean(z, weight)
    # A few tiles of background latch on to nothing: they go, once.
    near = np.abs(z - mean) <= 2.5 * scatter + stack.step
    mean, _ = weighted_mean(z[near], weight[near])
    front, rear = weighted_quantiles(z[near], weight[near], (0.1, 0.9))
    uniform = float(depths[-1] - depths[0]) / sqrt(12)
    compact = scatter < SCATTER_LIMIT * uniform
    index = int(np.argmin(np.abs(depths - mean)))
    plane = stack.intensity[index] / brightness_at(stack, brightness, index)
    if not compact:  # dim tiles at a depth where nothing is would only add defocused light
        plane = np.zeros_like(plane)
    peaks = sharpness.max(axis=0) / np.median(sharpness, axis=0)
    prominence = float(np.average(peaks[seen], weights=weight))
    return Focus(
        mean,
        front,
        rear,
        scatter,
        tiled_centroid(stack, plane, best, seen, brightness),
        depths,
        curve,
        tile_depth,
        tile_light,
        compact or prominence >= TILE_PROMINENCE,
    )


def brightness_at(
    stack: FocalStack,
    brightness: NDArray[np.float64] | None,
    index: int,
    part: tuple[slice, slice] = (slice(None), slice(None)),
) -> NDArray[np.float64]:
    """How bright equal points look at one depth of a stack, in a part of it."""
    if brightness is None:
        return np.ones(1)
    way = index / max(len(stack.depths) - 1, 1)
    near, far = brightness[(0, *part)], brightness[(1, *part)]
    mixed: NDArray[np.float64] = near + way * (far - near)
    return mixed


def tiled_centroid(
    stack: FocalStack,
    plane: NDArray[np.floating],
    best: NDArray[np.intp],
    seen: NDArray[np.bool_],
    brightness: NDArray[np.float64] | None,
) -> tuple[float, float]:
    """(x, y) centroid of a picture that shows each tile at its own depth.

    plane : what the other tiles show
    best : (m, n) index of each tile's depth; seen : (m, n) tiles that count
    Away from the axis, defocused light walks sideways: a deep object has no centroid at one depth.
    """
    m, n = best.shape
    side = min(stack.patch.shape[0] // m, stack.patch.shape[1] // n)
    picture = plane.astype(np.float64)
    for i, j in np.argwhere(seen):
        part = (slice(i * side, (i + 1) * side), slice(j * side, (j + 1) * side))
        index = int(best[i, j])
        picture[part] = stack.intensity[(index, *part)]
        picture[part] /= brightness_at(stack, brightness, index, part)
    return centroid(picture, stack.patch)


def weighted_mean(values: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[float, float]:
    """Weighted mean and standard deviation."""
    mean = float(np.average(values, weights=weights))
    return mean, sqrt(float(np.average((values - mean) ** 2, weights=weights)))


def weighted_quantiles(
    values: NDArray[np.float64], weights: NDArray[np.float64], shares: tuple[float, float]
) -> tuple[float, float]:
    """Values below which the given shares of the weight lie."""
    order = np.argsort(values)
    filled = np.cumsum(weights[order]) - weights[order] / 2
    low, high = np.interp(shares, filled / weights.sum(), values[order])
    return float(low), float(high)


def centroid(image: NDArray[np.floating], patch: Patch) -> tuple[float, float]:
    """(x, y) mean position of the light, metres; NaN for none."""
    y, x = patch.coordinates()
    rows = np.sum(image, axis=1, dtype=np.float64)
    columns = np.sum(image, axis=0, dtype=np.float64)
    total = float(rows.sum())
    if not total > 0:
        return float("nan"), float("nan")
    return float(columns @ x) / total, float(rows @ y) / total
