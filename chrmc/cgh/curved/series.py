"""A function of target and point as a short sum of products of the two.

G(x, y; point) ≈ Σ_l F_l(x, y)·P_l(point): expanded in products of Chebyshev polynomials of the
point's place, of which those terms stay that the tolerance needs, then turned so that fewer do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.chebyshev import chebyshev, interpolation, node_count
from chrmc.cgh.curved.wave import Kernel, phasors

Floats = NDArray[np.float64]
_LOBATTO = -np.cos(np.linspace(0, pi, 7))  # close at the ends, where slopes are steepest
_GROWTH = 7.0  # logarithm of how much larger polynomials may become outside: 1000 times
Reals = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class Series:
    """G ≈ Σ_l F_l(x, y)·P_l(point) over a box of points and a rectangle of the hologram.

    orders : (K, 3) degrees of the Chebyshev polynomials in x, y, z of the point
    mix : (L, K) P_l as sums of them
    box : (3, 2) lowest and highest x, y, z
    grid : half-open, the Chebyshev grid of `values`: (low, high, count) for x and for y
    values : (L, ny, nx) complex128 F_l on that grid
    sizes : (L,) rms of each term, relative to the whole
    dropped : relative rms of the terms left out
    """

    orders: NDArray[np.intp]
    mix: Floats
    box: Floats
    grid: tuple[tuple[float, float, int], tuple[float, float, int]]
    values: NDArray[np.complex128]
    sizes: Floats
    dropped: float

    def at_points(self, positions: Floats) -> Floats:
        """(L, N) P_l of each point."""
        out = np.ones((len(self.orders), len(positions)))
        for axis in range(3):
            low, high = self.box[axis]
            top = int(self.orders[:, axis].max())
            if top == 0:
                continue
            u = (2 * positions[:, axis] - low - high) / (high - low)
            polynomials = [np.ones_like(u), u]
            while len(polynomials) <= top:
                polynomials.append(2 * u * polynomials[-1] - polynomials[-2])
            for row, degree in enumerate(self.orders[:, axis]):
                if degree:
                    out[row] *= polynomials[degree]
        return self.mix @ out

    @property
    def terms(self) -> int:
        """How many products it has."""
        return len(self.mix)

    def missed(self, positions: Floats, kernel: Kernel, reach: tuple[float, float]) -> Floats:
        """(N,) mean of |G − Σ F·P|²/|G|² inside each point's footprint, between grid places.

        positions : (N, 3) x, y, 1/z
        """
        counts = [n for _, _, n in self.grid]
        # Between the grid's own places, where its interpolation shows too.
        u, v = (chebyshev(n + 2) for n in counts)
        (x_low, x_high, _), (y_low, y_high, _) = self.grid
        x = (x_low + x_high) / 2 + (x_high - x_low) / 2 * u
        y = ((y_low + y_high) / 2 + (y_high - y_low) / 2 * v)[:, None]
        px, py, pz = positions.T[:, :, None, None]
        exact = phasors(*kernel(x, y, px, py, pz))
        between = interpolation(counts[1], v) @ self.values @ interpolation(counts[0], u).T
        series = np.tensordot(self.at_points(positions), between, (0, 0))
        inside = (np.abs(x - px) * pz < reach[0]) & (np.abs(y - py) * pz < reach[1])
        inside |= ~inside.any(axis=(1, 2), keepdims=True)
        ratio: Floats = np.mean(np.abs(exact - series) ** 2, axis=(1, 2), where=inside)
        return ratio / np.mean(np.abs(exact) ** 2, axis=(1, 2), where=inside)

    def holds_at(self, x: Floats, y: Floats) -> bool:
        """Whether nodes lie inside its grid, or not so far outside that its polynomials run away
        there: they grow as cosh(n·arcosh u)."""
        return all(
            n * np.arccosh(max(1.0, np.abs(2 * t - low - high).max() / (high - low))) < _GROWTH
            for t, (low, high, n) in zip((x, y), self.grid, strict=True)
            if n > 1
        )

    def on_nodes(
        self,
        x: Floats,
        y: Floats,
        precision: type[np.floating],
        terms: slice = slice(None),
    ) -> "OnNodes":
        """F_l of some terms at nodes."""
        to_x, to_y = (
            interpolation(n, (2 * t - low - high) / (high - low) if n > 1 else np.zeros(len(t)))
            for t, (low, high, n) in zip((x, y), self.grid, strict=True)
        )
        values = self.values[terms]
        return OnNodes(
            values.real.astype(precision), values.imag.astype(precision),
            np.ascontiguousarray(to_x.T, dtype=precision), to_y.astype(precision),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class OnNodes:
    """F_l at nodes, worked out term by term.

    real, imag : (L, a, b) on the series' grid
    to_x : (b, n_x); to_y : (n_y, a) interpolation from the grid to the nodes
    """

    real: Reals
    imag: Reals
    to_x: Reals
    to_y: Reals

    def of(self, term: int, rows: slice = slice(None)) -> tuple[Reals, Reals]:
        """Real and imaginary part of one term at some rows of nodes, (rows, n_x) each."""
        rows_of = self.to_y[rows]
        return (
            rows_of @ (self.real[term] @ self.to_x),
            rows_of @ (self.imag[term] @ self.to_x),
        )


@dataclass(frozen=True)
class Remainder:
    """What sums at nodes miss.

    series : the one in use, whose terms left out can be tried on points; None without one
    relative : expected rms error beside that, of the light
    """

    series: Series | None = None
    relative: float = 0.0


@lru_cache(maxsize=64)
def _transform(count: int) -> Floats:
    """(count, count) values at Chebyshev nodes → Chebyshev coefficients."""
    polynomials = np.cos(np.arange(count)[:, None] * np.arccos(np.clip(chebyshev(count), -1, 1)))
    polynomials *= 2 / count
    polynomials[0] /= 2
    polynomials.flags.writeable = False
    return polynomials


MOST_SAMPLES = 3_000_000


def make_series(
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    box: Floats,
    kernel: Kernel,
    tolerance: float,
    most: float = MOST_SAMPLES,
    steepest: Kernel | None = None,
) -> Series | None:
    """The shortest `Series` with a relative rms remainder below `tolerance`; None when too long.

    x_range, y_range : the nodes' range
    box : (3, 2) the points' range
    kernel : the function to expand
    most : samples of it that may be taken
    steepest : a function that takes as many samples, where the slopes of this one tell nothing, as
        when it passes through 0
    """
    ranges = [x_range, y_range, *((float(low), float(high)) for low, high in box)]
    counts = _sample_counts(ranges, steepest or kernel, tolerance)
    if np.prod(counts, dtype=float) > min(most, MOST_SAMPLES):
        return None
    grids = [
        (low + high) / 2 + (high - low) / 2 * chebyshev(n)
        for (low, high), n in zip(ranges, counts, strict=True)
    ]
    # axes: hologram y, hologram x, point x, point y, point z
    tx, ty, px, py, pz = grids
    radians, modulus = kernel(
        tx[None, :, None, None, None], ty[:, None, None, None, None], px[:, None, None],
        py[:, None], pz,
    )  # fmt: skip
    samples = phasors(radians, modulus)
    weight = np.ones(())
    for axis, n in zip((2, 3, 4), counts[2:], strict=True):
        samples = np.moveaxis(np.tensordot(samples, _transform(n), (axis, 1)), -1, axis)
        mean_square = np.full(n, 0.5)
        mean_square[0] = 1.0
        weight = np.multiply.outer(weight, mean_square)
    power = np.mean(np.abs(samples) ** 2, axis=(0, 1)) * weight
    order = np.argsort(power, axis=None)[::-1]
    left = np.cumsum(power.ravel()[order][::-1])[::-1]
    total = left[0]
    # Half of the error, in power, to the polynomials left out, half to what turning them saves.
    keep = max(1, int(np.searchsorted(-left, -total * tolerance**2 / 2)))
    chosen = np.stack(np.unravel_index(order[:keep], power.shape), axis=1)
    values = np.stack([samples[:, :, a, b, c] for a, b, c in chosen])
    lost = left[keep] if keep < len(left) else 0.0
    values, mix, squares, more = _turn(
        values, np.sqrt(weight.ravel()[order[:keep]]), total * tolerance**2 / 2
    )
    return Series(
        chosen, mix, box, ((*x_range, counts[0]), (*y_range, counts[1])), values,
        np.sqrt(squares / total), sqrt(float(lost + more) / float(total)),
    )  # fmt: skip


def _turn(
    values: NDArray[np.complex128], size: Floats, allowed: float
) -> tuple[NDArray[np.complex128], Floats, Floats, float]:
    """Fewer terms by a real singular value decomposition of F_l, weighted with the P_l's rms.

    allowed : power that may be left out
    Returns new F_l, the mix of polynomials in each new P_l, each term's power, and the power left
    out.
    """
    flat = (values * size[:, None, None]).reshape(len(values), -1)
    real = np.concatenate([flat.real, flat.imag], axis=1) / np.sqrt(flat.shape[1])
    if len(real) <= real.shape[1]:
        squares, vectors = np.linalg.eigh(real @ real.T)
        squares, vectors = np.maximum(squares[::-1], 0), vectors[:, ::-1]
    else:  # thousands of polynomials on few samples, as of points metres apart
        vectors, roots, _ = np.linalg.svd(real, full_matrices=False)
        squares = roots**2
    left = np.append(np.cumsum(squares[::-1])[::-1], 0.0)
    keep = max(1, int(np.count_nonzero(left[:-1] > allowed)))
    mix = vectors[:, :keep].T / size
    turned = np.tensordot(vectors[:, :keep].T, values * size[:, None, None], 1)
    return turned, mix, squares[:keep], float(left[keep])


def _sample_counts(
    ranges: Sequence[tuple[float, float]], kernel: Kernel, tolerance: float
) -> list[int]:
    """Chebyshev samples along target x, y and point x, y, z, from the steepest slopes of phase and
    modulus."""
    tx, ty = ((low + high) / 2 + (high - low) / 2 * _LOBATTO for low, high in ranges[:2])
    px, py, pz = (
        (low + high) / 2 + (high - low) / 2 * (_LOBATTO[::3] if high > low else np.zeros(1))
        for low, high in ranges[2:]
    )
    shape = (len(tx), len(ty), len(px), len(py), len(pz))
    radians, modulus = kernel(
        tx[:, None, None, None, None], ty[:, None, None, None], px[:, None, None], py[:, None], pz
    )
    both = [np.broadcast_to(v, shape) for v in (radians, np.log(modulus))]
    counts = []
    for axis, samples in enumerate(shape):
        if samples == 1:
            counts.append(1)
            continue
        # The steepest slope of the phase, and of the modulus's logarithm, over [−1, 1].
        step = np.diff(_LOBATTO if axis < 2 else _LOBATTO[::3])
        slope = sum(
            float(np.max(np.abs(np.moveaxis(np.diff(v, axis=axis), axis, -1)) / step)) for v in both
        )
        counts.append(1 + node_count(1.15 * slope, tolerance / 10))
    for axis, (low, high) in enumerate(ranges[:2]):
        counts[axis] = max(counts[axis], 4) if high > low else 1
    return counts
