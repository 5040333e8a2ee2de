"""Point by point in double precision: for work so small that a low-rank form gains nothing."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.footprint import taper
from chrmc.scene.points import PointCloud

SMALL = 400_000
"""Points times pixels up to which the direct sum is taken: about as fast, and exact."""

BEARABLE = 200_000_000
"""The same up to which it stands in, seconds slow, where a low-rank form is not exact enough."""


def direct_field(
    cloud: PointCloud,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    wavelength: float,
    reach: tuple[float, float],
) -> NDArray[np.complex128]:
    """(len(y), len(x)) exact field at pixel centres x, y."""
    out = np.zeros((len(y), len(x)), dtype=np.complex128)
    block = max(1, (1 << 19) // out.size)
    for start in range(0, len(cloud), block):
        part = slice(start, start + block)
        px, py, pz = cloud.positions[part].T
        dx, dy = x - px[:, None], y - py[:, None]
        weight_x = taper(dx, (pz * reach[0])[:, None])
        weight_y = taper(dy, (pz * reach[1])[:, None])
        a, b, z = dx[:, None, :] ** 2, dy[:, :, None] ** 2, pz[:, None, None]
        r = np.sqrt(a + b + z * z)
        own = pz / wavelength
        start_cycles = own - np.rint(own) + cloud.phase[part] / (2 * pi)
        cycles = (a + b) / ((r + z) * wavelength) + start_cycles[:, None, None]
        wave = np.exp(2j * pi * (cycles - np.rint(cycles))) / r
        weight_y *= cloud.amplitude[part, None]
        out += np.einsum("jyx,jy,jx->yx", wave, weight_y, weight_x)
    return out
