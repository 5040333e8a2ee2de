"""The baseband of a cluster at its nodes: separable tables times a short separable series.

The separable part of a spherical wave (see `wave`) is two small tables and one matrix product.
The rest depends weakly on where in the cluster the point is; each term of its series is one
matrix product more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.parallel import Steps, finished, side_by_side
from chrmc.cgh.curved.series import Series
from chrmc.cgh.curved.wave import Wave, axis_cycles, by_curvature, phase_table, phasors
from chrmc.footprint import SOFT_SHARE
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = NDArray[np.floating]

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
    for run in axis.runs:
        if run.tapered:
            share = (axis.nodes[run.nodes] - x[:, None]).astype(parts[0].dtype)
            np.abs(share, out=share)
            share *= (1 / (SOFT_SHARE * reach * z)).astype(share.dtype)[:, None]
            share -= share.dtype.type(1 / SOFT_SHARE - 1)
            np.clip(share, 0, 1, out=share)
            share *= share.dtype.type(pi / 2)
            np.cos(share, out=share)
            share *= share
            for part in parts:
                part[:, run.nodes] *= share


def products(
    across: tuple[Reals, Reals], down: tuple[Reals, Reals], scale: Reals
) -> tuple[Reals, Reals]:
    """Σ_j scale_lj·down_j·across_j as real and imaginary parts, (L, n_y, n_x) each.

    across, down : cos and sin tables (N, n_x) and (N, n_y)
    scale : (L, N) real
    """
    return finished(product_steps(across, down, scale))


def product_steps(
    across: tuple[Reals, Reals],
    down: tuple[Reals, Reals],
    scale: Reals,
    beside: Sequence[Callable[[], None]] = (),
) -> Steps[tuple[Reals, Reals]]:
    """`products` in steps: each complex product is three real ones, in two halves.

    sgemm runs several times faster than cgemm here.

    beside : pieces of many small operations, which hold Python's lock and leave the other cores
        to the products; one at a time, or they wait for each other
    """
    terms, n = scale.shape
    ny, nx = down[0].shape[1], across[0].shape[1]
    left = np.empty((3, n, terms, ny), dtype=scale.dtype)
    right = across[0], across[1], np.empty((n, nx), dtype=scale.dtype)
    flat = left.reshape(3, n, terms * ny)
    out = np.empty((3, terms * ny, nx), dtype=scale.dtype)
    both = down[0] + down[1]

    def fill(part: int, table: Reals) -> Callable[[], None]:
        def multiply() -> None:
            for term in range(terms):
                np.multiply(table, scale[term][:, None], out=left[part, :, term])

        return multiply

    def add() -> None:
        np.add(across[0], across[1], out=right[2])

    yield [*(fill(part, table) for part, table in enumerate((*down, both))), add]

    def piece(part: int, rows: slice) -> Callable[[], None]:
        def multiply() -> None:
            np.matmul(flat[part][:, rows].T, right[part], out=out[part, rows])

        return multiply

    half = terms * ny // 2
    halves = (slice(half, None), slice(0, half)) if half > 16 else (slice(None),)
    pieces = [piece(part, rows) for rows in halves for part in range(3)]
    for number, small in enumerate(beside):
        pieces.insert(2 * number + 1, small)
    yield pieces
    real, other, imag = out
    imag -= real
    imag -= other
    real -= other
    return real.reshape(terms, ny, nx), imag.reshape(terms, ny, nx)


def weigh(series: tuple[Reals, Reals], sums: tuple[Reals, Reals]) -> tuple[Reals, Reals]:
    """Σ_l F_l·sum_l, complex, from and to real and imaginary parts."""
    real = np.einsum("lyx,lyx->yx", series[0], sums[0])
    real -= np.einsum("lyx,lyx->yx", series[1], sums[1])
    imag = np.einsum("lyx,lyx->yx", series[0], sums[1])
    imag += np.einsum("lyx,lyx->yx", series[1], sums[0])
    return real, imag


@dataclass(frozen=True, eq=False)
class Level:
    """Terms of a series that are summed at the same nodes."""

    axis_x: Axis
    axis_y: Axis
    terms: slice


Pieces = list[Callable[[], None]]


@dataclass(eq=False)
class Tables:
    """cos and sin of points' separable phases along x, (N, n_x), and along y, (N, n_y)."""

    across: tuple[Reals, Reals] | None = None
    down: tuple[Reals, Reals] | None = None


def table_pieces(
    cloud: PointCloud,
    axes: tuple[Axis, Axis],
    wave: Wave,
    precision: type[np.floating],
    out: Tables,
) -> Pieces:
    """What fills `out` for a cloud at some nodes."""
    reference, wavelength = wave.reference, wave.wavelength
    x, y, z = cloud.positions.T

    def across() -> None:
        z_x = reference.along_x(z)
        cycles = phase_table(axes[0], x, z_x, reference.x, reference.z_x, wavelength)
        out.across = fold(cycles, precision)
        _apply_taper(out.across, axes[0], x, z, wave.reach[0])

    def down() -> None:
        z_y = reference.along_y(z)
        cycles = phase_table(axes[1], y, z_y, reference.y, reference.z_y, wavelength)
        cycles += (reference.start(z, wavelength) + cloud.phase / (2 * pi))[:, None]
        out.down = fold(cycles, precision)
        _apply_taper(out.down, axes[1], y, z, wave.reach[1])

    return [across, down]


def level_steps(
    cloud: PointCloud,
    levels: Sequence[Level],
    wave: Wave,
    series: Series,
    precision: type[np.floating],
    first: Tables | None = None,
    beside: Callable[[], None] | None = None,
) -> Steps[list[tuple[Reals, Reals]]]:
    """Real and imaginary parts (n_y, n_x) of Σ_j w·a/r·exp(i(kr + φ)) over the reference wave.

    For each level the part that its terms make, at its nodes.

    precision : of the tables and sums; float32 adds about 5e-7 of noise
    first : the first level's tables, if they are there already
    beside : other work to be done while products are formed
    """
    out: list[tuple[Reals, Reals]] = []
    for start in range(0, len(cloud), MOST_AT_ONCE):
        part = cloud.select(slice(start, start + MOST_AT_ONCE))
        made = yield from _some_points(part, levels, wave, series, precision, first, beside)
        first = beside = None
        if not out:
            out = made
        else:
            for total, more in zip(out, made, strict=True):
                for old, new in zip(total, more, strict=True):
                    old += new
    return out


def _some_points(
    cloud: PointCloud,
    levels: Sequence[Level],
    wave: Wave,
    series: Series,
    precision: type[np.floating],
    first: Tables | None,
    beside: Callable[[], None] | None,
) -> Steps[list[tuple[Reals, Reals]]]:
    scale = series.at_points(by_curvature(cloud.positions))
    scale *= cloud.amplitude * wave.reference.modulus(cloud.positions[:, 2])
    scales = scale.astype(precision)
    tables = [first or Tables(), *(Tables() for _ in levels[1:])]
    missing = [
        piece
        for level, made in zip(levels, tables, strict=True)
        if made.across is None
        for piece in table_pieces(cloud, (level.axis_x, level.axis_y), wave, precision, made)
    ]
    if missing:
        yield missing
    weights: list[tuple[Reals, Reals]] = [(scale, scale)] * len(levels)
    out = weights.copy()

    def weight(number: int) -> Callable[[], None]:
        level = levels[number]

        def make() -> None:
            weights[number] = series.on_grid(
                level.axis_x.nodes, level.axis_y.nodes, precision, level.terms
            )

        return make

    works = []
    for number, (level, made) in enumerate(zip(levels, tables, strict=True)):
        assert made.across is not None and made.down is not None
        small = [weight(number), *([beside] if beside is not None and number == 0 else [])]
        works.append(product_steps(made.across, made.down, scales[level.terms], small))
    sums = yield from side_by_side(works)

    def weighed(number: int) -> Callable[[], None]:
        def make() -> None:
            out[number] = weigh(weights[number], sums[number])

        return make

    yield [weighed(number) for number in range(len(levels))]
    return out


def exact_baseband(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    wave: Wave,
) -> tuple[Singles, Singles]:
    """The same point by point, for geometry that no short series fits."""
    reference, wavelength = wave.reference, wave.wavelength
    nx, ny = len(axis_x.nodes), len(axis_y.nodes)
    total = np.zeros((ny, nx), dtype=np.complex128)
    block = max(1, (1 << 20) // max(1, nx * ny))
    for start in range(0, len(cloud), block):
        part = slice(start, start + block)
        x, y, z = cloud.positions[part].T
        dx, dy = axis_x.nodes - x[:, None], axis_y.nodes - y[:, None]
        rest = reference.residual(dx[:, None, :], dy[:, :, None], z[:, None, None], wavelength)
        cycles_x = axis_cycles(
            axis_x.nodes, x, reference.along_x(z), reference.x, reference.z_x, wavelength
        )
        cycles_y = axis_cycles(
            axis_y.nodes, y, reference.along_y(z), reference.y, reference.z_y, wavelength
        )
        cycles_y += (reference.start(z, wavelength) + cloud.phase[part] / (2 * pi))[:, None]
        phasor_x = phasors(2 * pi * (cycles_x - np.rint(cycles_x)))
        phasor_y = phasors(2 * pi * (cycles_y - np.rint(cycles_y)))
        phasor_x *= axis_x.weights(x, z, wave.reach[0])
        phasor_y *= axis_y.weights(y, z, wave.reach[1])
        phasor_y *= (cloud.amplitude[part] * reference.modulus(z))[:, None]
        total += np.einsum("jyx,jy,jx->yx", rest, phasor_y, phasor_x, optimize=True)
    return total.real.astype(np.float32), total.imag.astype(np.float32)
