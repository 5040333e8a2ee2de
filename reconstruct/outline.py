"""Where a dense surface is in focus: outlines and texture, each cell at the scene's own depth.

A surface denser than the resolution is speckle at every depth, and only its outlines and texture,
the speckle smoothed away, tell where it is sharp. Of a body deeper than the depth of focus they are
sharp at many depths, and the picture as a whole is sharpest where most of them happen to be. So
each cell is looked at where the scene's map has it, plus one offset for all: the offset at which
the slopes of the smoothed picture are largest is the depth error.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.light_map import LightMap
from reconstruct.focus import peak_middle
from reconstruct.jackknife import standard_error
from reconstruct.likeness import at_depths
from reconstruct.stack import FocalStack

GRAINS = 3.0
"""Of speckle, that the picture is smoothed over: less leaves speckle, more blurs the outlines."""


def outline_error(
    stack: FocalStack, expected: LightMap, parts: int, grain: float
) -> tuple[float, float]:
    """Metres by which outlines and texture are sharpest behind the scene's depths, NaN for no peak;
    and the standard error of that.

    stack : of the map's patch, `parts` samples to each side of a cell
    grain : size of a speckle, samples
    """
    slopes = np.array([_slopes(plane, parts, GRAINS * grain) for plane in stack.intensity])
    offsets = stack.depths - stack.depths[len(stack.depths) // 2]
    lit = expected.light > 0
    per_cell = np.array(
        [at_depths(slopes, stack.depths, expected.depth + o) * lit for o in offsets]
    )
    return (
        peak_middle(offsets, per_cell.sum(axis=(1, 2))),
        standard_error(per_cell, lit, lambda curve: peak_middle(offsets, curve)),
    )


def _slopes(plane: NDArray[np.floating], parts: int, sigma: float) -> NDArray[np.float64]:
    """(m, n) sums over cells of the squared slopes of a smoothed picture."""
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(plane.astype(np.float64), sigma)
    down, across = np.gradient(smooth, axis=0), np.gradient(smooth, axis=1)
    m, n = plane.shape[0] // parts, plane.shape[1] // parts
    found = (down**2 + across**2)[: m * parts, : n * parts]
    summed: NDArray[np.float64] = found.reshape(m, parts, n, parts).sum(axis=(1, 3))
    return summed
