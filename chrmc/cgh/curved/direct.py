"""Point by point in double precision: for little work, and where nothing else is exact enough."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.parallel import spread
from chrmc.optics.footprint import taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

SMALL = 400_000
"""Points times pixels up to which the direct sum is taken: about as fast, and exact."""

BEARABLE = 200_000_000
"""The same up to which it stands in, seconds slow, where a low-rank form is not exact enough."""

BEARABLE_BY_RAYS = 1_000_000_000
"""The same for `chrmc.cgh.rt`, whose waves are float32 where that leaves RAY_ERROR."""
RAY_ERROR = 1e-5

_BLOCK = 1 << 15  # waves formed at once: they fit the second cache


def direct_field(
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
) -> NDArray[np.complex128]:
    """(len(y), len(x)) exact field at pixel centres x, y."""
    rows = max(1, min(-(-len(y) // 8), (1 << 19) // len(x)))
    starts = range(0, len(y), rows)

    def some(start: int) -> NDArray[np.complex128]:
        part = y[start : start + rows]
        at = np.broadcast_arrays(x, part[:, None])
        return field_at(cloud, at[0].ravel(), at[1].ravel(), wavelength, reach).reshape(at[0].shape)

    return np.concatenate(spread(some, starts))


def field_at(
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
) -> NDArray[np.complex128]:
    """(K,) exact field at places x, y (K,)."""
    out = np.zeros(len(x), dtype=np.complex128)
    own = cloud.positions[:, 2] / wavelength
    own = own - np.rint(own) + cloud.phase / (2 * pi)
    pixels = min(len(x), 2048)
    step = max(1, _BLOCK // max(1, pixels))
    for first in range(0, len(x), pixels):
        some = slice(first, first + pixels)
        for start in range(0, len(cloud), step):
            part = slice(start, start + step)
            px, py, pz = (column[:, None] for column in cloud.positions[part].T)
            dx, dy = x[some] - px, y[some] - py
            weight = taper(dx, pz * reach[0])
            weight *= taper(dy, pz * reach[1])
            weight *= cloud.amplitude[part, None]
            dx *= dx
            dy *= dy
            dx += dy
            r = np.sqrt(dx + pz * pz)
            weight /= r
            r += pz
            r *= wavelength
            dx /= r
            dx -= np.rint(dx)
            dx += own[part, None]
            dx *= 2 * pi
            out[some].real += np.einsum("jk,jk->k", weight, np.cos(dx))
            out[some].imag += np.einsum("jk,jk->k", weight, np.sin(dx))
    return out
