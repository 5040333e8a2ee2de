"""Where a dense surface is in focus: where the least of its light lies beside the scene's cells.

A surface denser than the resolution is speckle at every depth, and what sharpness its cells and
outlines seem to have is chance. Out of focus its light spills beyond its rim. So each cell is
looked at where the scene's map has it, plus one offset for all: the offset at which the lit cells
have the largest share of the light is the depth error.

Light that comes to a place off the panel's axis walks sideways with depth, and a picture of half
the panel's size is a smaller one before its focus. So the cells move along the rays that come
from the middle of the part of the panel that shows them.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.light_map import LightMap
from chrmc.optics.footprint import shown_from
from reconstruct.focus import peak_middle
from reconstruct.four_f_system import FourF
from reconstruct.jackknife import standard_error
from reconstruct.likeness import at_depths
from reconstruct.stack import FocalStack


def spill_error(stack: FocalStack, expected: LightMap, system: FourF) -> tuple[float, float]:
    """Metres behind the scene's depths at which least light spills, NaN for no peak; and the
    standard error of that.

    stack : of the map's patch
    """
    offsets = stack.depths - stack.depths[len(stack.depths) // 2]
    light = _along_rays(stack, expected, system)
    every = np.array([at_depths(light, stack.depths, expected.depth + o) for o in offsets])
    both = np.concatenate([every * expected.lit, every])

    def peak(sums: NDArray[np.float64]) -> float:
        own, whole = sums.reshape(2, -1)
        return peak_middle(offsets, own / np.maximum(whole, 1e-300))

    everywhere = np.ones_like(expected.lit)
    return peak(both.sum(axis=(1, 2))), standard_error(both, everywhere, peak)


def _along_rays(stack: FocalStack, expected: LightMap, system: FourF) -> NDArray[np.float64]:
    """(D, m, n) light of the map's cells at each depth, each moved from where it stands at its own
    depth along the rays that show it."""
    from scipy.ndimage import map_coordinates

    slm, band, z = system.slm, system.band, float(expected.depth.mean())
    sides = []
    for middle, n, pixels, f_max in (
        (expected.centre[0], expected.light.shape[0], slm.height, band.fy_max),
        (expected.centre[1], expected.light.shape[1], slm.width, band.fx_max),
    ):
        border = middle + (np.arange(n + 1) - n / 2) * expected.cell
        half = pixels * slm.pixel_pitch / 2
        sides.append((border - shown_from(border, z, half, system.wavelength, f_max)) / z)
    parts = expected.cell / stack.patch.pitch
    corners = np.array(np.meshgrid(*(np.arange(len(s)) * parts for s in sides), indexing="ij"))
    slopes = np.array(np.meshgrid(*sides, indexing="ij")) / stack.patch.pitch
    out = np.empty((len(stack.depths), *expected.light.shape))
    for depth, plane, light in zip(stack.depths, stack.intensity, out, strict=True):
        sums = np.zeros((plane.shape[0] + 1, plane.shape[1] + 1))
        plane.cumsum(axis=0, dtype=np.float64).cumsum(axis=1, out=sums[1:, 1:])
        away = depth - expected.depth
        light[:] = 0
        for sign, part in _CORNERS:
            at = corners[part] + away * slopes[part]
            light += sign * map_coordinates(sums, at, order=1, mode="nearest")
    return out


_LOW, _HIGH = slice(None, -1), slice(1, None)
_CORNERS = [
    (sign_y * sign_x, (slice(None), rows, columns))
    for sign_y, rows in ((-1, _LOW), (1, _HIGH))
    for sign_x, columns in ((-1, _LOW), (1, _HIGH))
]
