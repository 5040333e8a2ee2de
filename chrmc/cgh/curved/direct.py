"""Point by point in double precision: for little work, and where nothing else is exact enough."""

from collections.abc import Callable
from itertools import product
from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.wave import phasor
from chrmc.optics.footprint import taper
from chrmc.parallel import in_parallel
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Weigh = Callable[[slice], Floats]
"""Some points → (points, places) weights along an axis."""

SMALL = 1_000_000
"""Points times pixels up to which the direct sum is taken: about as fast, and exact."""

QUICK = 20_000_000
"""The same up to which it stands in at once where a low-rank form is not exact enough."""

BEARABLE = 200_000_000
"""The same up to which it stands in, seconds slow, where nothing else will do."""

_BLOCK = 1 << 15  # waves formed at once: they fit the second cache
_PIECES = 8  # of an axis, at least, for several cores
_TABLES = 1 << 22  # weights held at once


def direct_field(
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
) -> NDArray[np.complex128]:
    """(len(y), len(x)) exact field at pixel centres x, y."""
    px, py, pz = cloud.positions.T

    def across(some: slice) -> Floats:
        return taper(x - px[some, None], (pz[some] * reach[0])[:, None])

    def down(some: slice) -> Floats:
        return taper(y - py[some, None], (pz[some] * reach[1])[:, None])

    return weighted_waves(cloud, x, y, wavelength, across, down)


def weighted_waves(
    cloud: PointCloud, x: Floats, y: Floats, wavelength: float, across: Weigh, down: Weigh
) -> NDArray[np.complex128]:
    """(len(y), len(x)) Σ across·down·a/r·exp(i(kr + φ)) at places x, y in the hologram plane.

    across, down : weights along x and along y
    """
    if len(x) < len(y):  # the longer axis inside
        turned = PointCloud(cloud.positions[:, [1, 0, 2]], cloud.amplitude, cloud.phase)
        return weighted_waves(turned, y, x, wavelength, down, across).T
    # Lengths in wavelengths: paths are cycles.
    px, py, pz = (cloud.positions / wavelength).T
    u, v = x / wavelength, y / wavelength
    # Of phases no turns are taken out, whose rounding would be alike in many waves.
    phase = np.arctan2(np.sin(cloud.phase), np.cos(cloud.phase))
    own = pz - np.rint(pz) + phase / (2 * pi)
    strength = cloud.amplitude / wavelength
    columns = len(u) if len(v) >= _PIECES else -(-len(u) // _PIECES)
    rows = max(1, min(-(-len(v) // _PIECES), _BLOCK // columns))
    step = max(1, _BLOCK // (columns * rows))
    held = max(1, _TABLES // (len(u) + len(v)) // step) * step
    out = np.zeros((len(v), len(u)), dtype=np.complex128)

    def add(corner: tuple[int, int]) -> None:
        part, wide = slice(corner[0], corner[0] + rows), slice(corner[1], corner[1] + columns)
        for first in range(0, len(of_x), step):
            some = slice(first, first + step)
            here = slice(begin + first, begin + first + step)
            x2 = (u[wide] - px[here, None]) ** 2
            y2 = (v[part] - py[here, None]) ** 2
            z = pz[here, None]
            turn = y2[:, :, None] + x2[:, None, :]
            r = (y2 + z * z)[:, :, None] + x2[:, None, :]
            np.sqrt(r, out=r)
            turn /= r + z[:, :, None]  # r − z, without cancellation
            # Whole turns out first, or the sum would lose the phase's digits.
            turn -= np.rint(turn)
            turn += own[here, None, None]
            turn *= 2 * pi
            np.divide(of_x[some, None, wide], r, out=r)
            r *= of_y[some, part, None]
            wave = np.cos(turn)  # to the last digit: waves may all but cancel
            wave *= r
            out[part, wide].real += wave.sum(axis=0)
            np.sin(turn, out=wave)
            wave *= r
            out[part, wide].imag += wave.sum(axis=0)

    for begin in range(0, len(cloud), held):
        together = slice(begin, begin + held)
        of_x, of_y = across(together), down(together) * strength[together, None]
        in_parallel(add, list(product(range(0, len(v), rows), range(0, len(u), columns))))
    return out


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
