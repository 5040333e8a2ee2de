"""Point by point in double precision: for little work, and where nothing else is exact enough."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.parallel import spread
from chrmc.cgh.curved.wave import phasor
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
    cycles = cloud.positions[:, 2] / wavelength
    cycles += cloud.phase / (2 * pi) - np.rint(cycles)
    points = min(len(cloud), 2048)
    step = max(1, _BLOCK // max(1, points))
    for start in range(0, len(cloud), points):
        part = slice(start, start + points)
        px, py, pz = np.ascontiguousarray(cloud.positions[part].T)
        half_x, half_y = pz * reach[0], pz * reach[1]
        for first in range(0, len(x), step):
            some = slice(first, first + step)
            dx, dy = x[some, None] - px, y[some, None] - py
            weight = taper(dx, half_x)
            weight *= taper(dy, half_y)
            weight *= cloud.amplitude[part]
            dx *= dx
            dy *= dy
            dx += dy
            r = np.sqrt(np.add(dx, pz * pz, out=dy), out=dy)
            weight /= r
            r += pz
            r *= wavelength
            dx /= r
            dx += cycles[part]
            cos, sin = phasor(dx)
            out[some].real += np.einsum("kj,kj->k", weight, cos)
            out[some].imag += np.einsum("kj,kj->k", weight, sin)
    return out
