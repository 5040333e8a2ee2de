"""The baseband of a cluster at its nodes: separable tables times a short separable series.

The separable part of a spherical wave (see `wave`) is two small tables and one matrix product.
The rest depends weakly on where in the cluster the point is; each term of its series is one
matrix product more.
"""

from collections.abc import Callable
from math import pi
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.parallel import spread
from chrmc.cgh.curved.series import Series
from chrmc.cgh.curved.wave import Reference, axis_cycles, by_curvature, phase_table, phasors
from chrmc.footprint import SOFT_SHARE, taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating]

T = TypeVar("T")
MOST_AT_ONCE = 4096
"""Points whose tables are held at once."""


def fold(cycles: Floats, precision: type[np.floating]) -> tuple[Reals, Reals]:
    """cos and sin of 2π·cycles in `precision`, reduced in float64; `cycles` is overwritten."""
    cycles -= np.rint(cycles)
    turn = cycles.astype(precision)
    turn *= precision(2 * pi)
    return np.cos(turn), np.sin(turn)


def _apply_taper(
    parts: tuple[Reals, Reals], axis: Axis, x: Floats, z: Floats, reach: float
) -> None:
    """The soft footprint of `chrmc.footprint.taper`, in the tables' own precision."""
    for panel in axis.panels:
        if panel.tapered:
            share = (axis.nodes[panel.nodes] - x[:, None]).astype(parts[0].dtype)
            np.abs(share, out=share)
            share *= (1 / (SOFT_SHARE * reach * z)).astype(share.dtype)[:, None]
            share -= share.dtype.type(1 / SOFT_SHARE - 1)
            np.clip(share, 0, 1, out=share)
            share *= share.dtype.type(pi / 2)
            np.cos(share, out=share)
            share *= share
            for part in parts:
                part[:, panel.nodes] *= share


Begun = tuple[list[Callable[[], None]], Callable[[], T]]
"""Pieces of work that may run side by side, and what to call for the result after them."""


def products(
    across: tuple[Reals, Reals], down: tuple[Reals, Reals], scale: Reals
) -> tuple[Reals, Reals]:
    """Σ_j scale_lj·down_j·across_j as real and imaginary parts, (L, n_y, n_x) each.

    across, down : cos and sin tables (N, n_x) and (N, n_y)
    scale : (L, N) real
    """
    return finished(begin_products(across, down, scale))


def finished(begun: Begun[T]) -> T:
    """Run the pieces, then take the result."""
    pieces, result = begun
    spread(lambda piece: piece(), pieces)
    return result()


def begin_products(
    across: tuple[Reals, Reals], down: tuple[Reals, Reals], scale: Reals
) -> Begun[tuple[Reals, Reals]]:
    """`products` in pieces: each complex product is three real ones, in two halves.

    sgemm runs several times faster than cgemm here.
    """
    terms, n = scale.shape
    ny, nx = down[0].shape[1], across[0].shape[1]
    left = np.empty((3, n, terms, ny), dtype=scale.dtype)
    for term in range(terms):
        for part in range(2):
            np.multiply(down[part], scale[term][:, None], out=left[part, :, term])
    np.add(left[0], left[1], out=left[2])
    flat = left.reshape(3, n, terms * ny)
    right = (across[0], across[1], across[0] + across[1])
    out = np.empty((3, terms * ny, nx), dtype=scale.dtype)

    def piece(part: int, rows: slice) -> Callable[[], None]:
        def multiply() -> None:
            np.matmul(flat[part][:, rows].T, right[part], out=out[part, rows])

        return multiply

    def result() -> tuple[Reals, Reals]:
        real, other, imag = out
        imag -= real
        imag -= other
        real -= other
        return real.reshape(terms, ny, nx), imag.reshape(terms, ny, nx)

    half = terms * ny // 2
    halves = (slice(0, half), slice(half, None))
    return [piece(part, rows) for rows in halves for part in range(3)], result


def weigh(series: tuple[Reals, Reals], sums: tuple[Reals, Reals]) -> tuple[Reals, Reals]:
    """Σ_l F_l·sum_l, complex, from and to real and imaginary parts."""
    real = np.einsum("lyx,lyx->yx", series[0], sums[0])
    real -= np.einsum("lyx,lyx->yx", series[1], sums[1])
    imag = np.einsum("lyx,lyx->yx", series[0], sums[1])
    imag += np.einsum("lyx,lyx->yx", series[1], sums[0])
    return real, imag


def separable_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
    series: Series,
    precision: type[np.floating] = np.float32,
) -> tuple[Reals, Reals]:
    """Real and imaginary parts (n_y, n_x) of Σ_j w·a/r·exp(i(kr + φ)) over the reference wave.

    precision : of the tables and sums; float32 adds about 5e-7 of noise
    """
    begun = begin_baseband(
        cloud.select(slice(0, MOST_AT_ONCE)), axis_x, axis_y, reference, wavelength, reach, series,
        precision,
    )  # fmt: skip
    real, imag = finished(begun)
    for start in range(MOST_AT_ONCE, len(cloud), MOST_AT_ONCE):
        part = cloud.select(slice(start, start + MOST_AT_ONCE))
        more = finished(
            begin_baseband(part, axis_x, axis_y, reference, wavelength, reach, series, precision)
        )
        real += more[0]
        imag += more[1]
    return real, imag


def begin_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
    series: Series,
    precision: type[np.floating] = np.float32,
) -> Begun[tuple[Reals, Reals]]:
    """`separable_baseband` of not too many points, in pieces."""
    across, down, scale = _tables(
        cloud, axis_x, axis_y, reference, wavelength, reach, series, precision
    )
    pieces, sums = begin_products(across, down, scale)

    def result() -> tuple[Reals, Reals]:
        return weigh(series.on_grid(axis_x.nodes, axis_y.nodes, precision), sums())

    return pieces, result


def _tables(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
    series: Series,
    precision: type[np.floating],
) -> tuple[tuple[Reals, Reals], tuple[Reals, Reals], Reals]:
    """cos and sin along x, along y, and the points' shares (L, N) in the series' terms."""
    x, y, z = cloud.positions.T
    cycles = phase_table(
        axis_x.nodes, x, reference.along_x(z), reference.x, reference.z_x, wavelength
    )
    across = fold(cycles, precision)
    cycles = phase_table(
        axis_y.nodes, y, reference.along_y(z), reference.y, reference.z_y, wavelength
    )
    cycles += (reference.start(z, wavelength) + cloud.phase / (2 * pi))[:, None]
    down = fold(cycles, precision)
    _apply_taper(across, axis_x, x, z, reach[0])
    _apply_taper(down, axis_y, y, z, reach[1])
    scale = series.at_points(by_curvature(cloud.positions))
    scale *= cloud.amplitude * reference.modulus(z)
    return across, down, scale.astype(precision)


def exact_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    wavelength: float,
    reach: tuple[float, float],
) -> tuple[Singles, Singles]:
    """The same as `separable_baseband` point by point, for geometry that no short series fits."""
    nx, ny = len(axis_x.nodes), len(axis_y.nodes)
    total = np.zeros((ny, nx), dtype=np.complex128)
    block = max(1, (1 << 20) // max(1, nx * ny))
    for start in range(0, len(cloud), block):
        part = slice(start, start + block)
        x, y, z = cloud.positions[part].T
        dx, dy = axis_x.nodes - x[:, None], axis_y.nodes - y[:, None]
        wave = reference.residual(dx[:, None, :], dy[:, :, None], z[:, None, None], wavelength)
        cycles_x = axis_cycles(
            axis_x.nodes, x, reference.along_x(z), reference.x, reference.z_x, wavelength
        )
        cycles_y = axis_cycles(
            axis_y.nodes, y, reference.along_y(z), reference.y, reference.z_y, wavelength
        )
        cycles_y += (reference.start(z, wavelength) + cloud.phase[part] / (2 * pi))[:, None]
        phasor_x = phasors(2 * pi * (cycles_x - np.rint(cycles_x)))
        phasor_y = phasors(2 * pi * (cycles_y - np.rint(cycles_y)))
        phasor_x *= taper(dx, (z * reach[0])[:, None])
        phasor_y *= taper(dy, (z * reach[1])[:, None])
        phasor_y *= (cloud.amplitude[part] * reference.modulus(z))[:, None]
        total += np.einsum("jyx,jy,jx->yx", wave, phasor_y, phasor_x, optimize=True)
    return total.real.astype(np.float32), total.imag.astype(np.float32)
