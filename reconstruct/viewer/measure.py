"""Rulers, profiles and statistics of what a reconstruction shows."""

from dataclasses import dataclass
from math import atan2, degrees, hypot

import numpy as np
from numpy.typing import NDArray

from reconstruct.metrics import speckle_contrast

Place = tuple[float, float]
"""(row, column) in the panel's pixels; pixel (i, j) has its middle at (i, j)."""


@dataclass(frozen=True)
class Line:
    """From a place to a place."""

    start: Place
    end: Place

    def length(self, pitch: float) -> float:
        """Metres."""
        return pitch * hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    @property
    def angle(self) -> float:
        """Degrees from +x towards −y, as one sees it."""
        return degrees(atan2(self.start[0] - self.end[0], self.end[1] - self.start[1]))


@dataclass(frozen=True)
class Region:
    """A rectangle between two corners, both included."""

    corner: Place
    opposite: Place

    def scaled(self, panel: tuple[int, int], shape: tuple[int, int]) -> "Region":
        """The same on a picture of the panel with other samples."""
        ends = [
            tuple(v * n / m for v, m, n in zip(place, panel, shape, strict=True))
            for place in (self.corner, self.opposite)
        ]
        return Region((ends[0][0], ends[0][1]), (ends[1][0], ends[1][1]))

    def slices(self, shape: tuple[int, int]) -> tuple[slice, slice]:
        """Rows and columns of a picture of the panel with these samples, at least one each."""
        found = []
        for a, b, n in zip(self.corner, self.opposite, shape, strict=True):
            low, high = sorted((round(a), round(b)))
            first = min(max(low, 0), n - 1)
            found.append(slice(first, max(min(high, n - 1), first) + 1))
        return found[0], found[1]


@dataclass(frozen=True)
class Statistics:
    """Of the intensities in a region.

    speckle : standard deviation over mean; light : share of the whole picture's
    """

    least: float
    most: float
    mean: float
    deviation: float
    speckle: float
    light: float


def profile(
    image: NDArray[np.floating], line: Line, panel: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shares 0 … 1 of the way along a line, and the values there, interpolated linearly.

    image : (h, w) over the panel; panel : (rows, columns) that the line's places count
    """
    from scipy.ndimage import map_coordinates

    count = max(2, round(hypot(line.end[0] - line.start[0], line.end[1] - line.start[1])) + 1)
    share = np.linspace(0, 1, count)
    places = []
    for axis in (0, 1):
        at = line.start[axis] + share * (line.end[axis] - line.start[axis])
        places.append(at * image.shape[axis] / panel[axis])
    values = map_coordinates(image, places, order=1, mode="nearest", output=np.float64)
    return share, np.asarray(values)


def statistics(image: NDArray[np.floating], region: Region) -> Statistics:
    """Statistics of a part of an (h, w) picture that has the panel's samples."""
    part = image[region.slices((image.shape[0], image.shape[1]))]
    total = float(np.sum(image, dtype=np.float64))
    light = float(np.sum(part, dtype=np.float64))
    return Statistics(
        float(part.min()),
        float(part.max()),
        float(np.mean(part, dtype=np.float64)),
        float(np.std(part, dtype=np.float64)),
        speckle_contrast(part),
        light / total if total > 0 else 0.0,
    )
