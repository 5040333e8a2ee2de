"""The focal stack in which a target is looked for."""

from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import Patch
from chrmc.optics.resolution import depth_of_focus, resolution
from reconstruct.four_f_system import FourF
from reconstruct.stack import FocalStack, focal_stack, patch_around
from reconstruct.target import Target

MOST_DEPTHS = 160


def search_range(target: Target, system: FourF) -> NDArray[np.float64]:
    """Depths to look at: the object's box and four depths of focus on each side, half a depth of
    focus apart.

    Uncentred on purpose by a few per cent: an estimate that leans on the middle shows.
    """
    low, high = float(target.low[2]), float(target.high[2])
    coarse, fine = search_scale(target, system)
    before, behind = max(3.6 * coarse, (high - low) / 2), max(4.4 * coarse, (high - low) / 2)
    first = max(low - before, low / 2)
    count = int(np.clip(np.ceil((high + behind - first) / (fine / 2)), 20, MOST_DEPTHS)) + 1
    return np.linspace(first, high + behind, count)


def search_scale(target: Target, system: FourF) -> tuple[float, float]:
    """The larger and the smaller depth of focus of both axes at a target, metres."""
    depth = float(target.position[2])
    pair = depth_of_focus(system.slm, system.wavelength, depth, system.band)
    return max(pair), min(pair)


def target_stack(
    field_: NDArray[np.complex64], system: FourF, target: Target, pixel_pitch: float
) -> tuple[FocalStack, int, int]:
    """Focal stack of a target's region, and in samples the side of the focus's tiles (two scene
    pixels, three resolutions at least; of a speck a cell) and of the cells of its map of light.

    Samples are the SLM's pixels, or half the resolution where that is coarser.
    """
    p = system.slm.pixel_pitch
    fine = resolution(system.slm, system.wavelength, float(target.position[2]), system.band)
    depths = search_range(target, system)
    light = target.light
    cell = light.cell if light is not None else p * ceil(max(2 * pixel_pitch, 3 * max(fine)) / p)
    parts = max(4, round(cell / max(p, min(fine) / 2)))
    pitch = cell / parts
    tile = max(4, round(max(2 * pixel_pitch, 3 * float(np.mean(fine))) / pitch))
    if light is not None and not light.shaped:
        tile = parts  # a speck stands in the middle of a cell, and may at a tile's border
    if light is None:
        patch = patch_around(target.low, target.high, pitch, margin=tile * pitch, even=tile)
    else:
        rows, columns = light.light.shape
        patch = Patch(light.centre, (rows * parts, columns * parts), pitch)
    stack = focal_stack(field_, system.slm, system.wavelength, depths, patch, system.band)
    return stack, tile, parts
