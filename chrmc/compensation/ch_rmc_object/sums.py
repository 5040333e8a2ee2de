"""Sums of points on a grid of directions: tables of phases along either axis, and their product."""

from collections.abc import Callable
from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from chrmc.cgh.curved.interface import chebyshev, interpolation

Floats = NDArray[np.float64]

_AT_ONCE = 2048  # points whose tables are held at once
_FEW = 64  # that are not worth two cores


def cycles_of(
    length: Callable[[Floats], Floats], at: Floats, other: Floats, wavelength: float
) -> Floats:
    """(N, len(at)) path over the wavelength at many places from few, exact to 1e-10.

    The path is analytic in α up to γ = 0, so that its Chebyshev series falls fast.
    """
    low, high = float(at[0]), float(at[-1])
    half = (high - low) / 2
    edge = sqrt(1 - float(other) ** 2)
    if half > 0:
        ratio = (edge - max(abs(low), abs(high))) / half + 1
        few = 4 + ceil(log(1e12) / log(ratio + sqrt(ratio * ratio - 1)))
        if few < 0.7 * len(at):
            coarse = (low + high) / 2 + half * chebyshev(few)
            matrix = interpolation(few, (at - (low + high) / 2) / half).T
            return (length(coarse) / wavelength) @ matrix
    return length(at) / wavelength


def phase_table(cycles: Floats, real: type[np.floating]) -> NDArray[np.floating]:
    """cos and sin of 2π·cycles, reduced in float64."""
    cycles -= np.rint(cycles)
    turn = cycles.astype(real)
    turn *= real(2 * pi)
    out = np.empty((2, *turn.shape), dtype=real)
    np.cos(turn, out=out[0])
    np.sin(turn, out=out[1])
    return out


def product_of(
    across: NDArray[np.floating],
    down: NDArray[np.floating],
    scale: NDArray[np.floating],
    weights: NDArray[np.complexfloating],
) -> NDArray[np.complexfloating]:
    """(n_β, n_α) Σ_t weights_t·Σ_j scale_tj·down_j·across_j, one real product a term.

    across, down : (2, N, n_α) and (2, N, n_β) cos and sin
    scale : (T, N)
    weights : (T, n_β, n_α)
    """
    _, count, rows = down.shape
    right = across.reshape(2 * count, -1)
    left = np.empty((2, count, 2, rows), dtype=right.dtype)
    total = np.zeros((rows, right.shape[1]), dtype=weights.dtype)
    for strength, weight in zip(scale, weights, strict=True):
        column = strength[:, None]
        np.multiply(down[0], column, out=left[0, :, 0])
        np.multiply(down[1], column, out=left[0, :, 1])
        left[1, :, 1] = left[0, :, 0]
        np.multiply(left[0, :, 1], right.dtype.type(-1), out=left[1, :, 0])
        flat = left.reshape(2 * count, 2 * rows).T @ right
        one = np.empty_like(total)
        one.real, one.imag = flat[:rows], flat[rows:]
        one *= weight
        total += one
    return total


def chunks_of(count: int) -> list[slice]:
    """Points in runs of about equal length: two at least, for as many cores."""
    number = max(ceil(count / _AT_ONCE), min(2, ceil(count / _FEW)))
    return [slice(count * n // number, count * (n + 1) // number) for n in range(number)]


def weighed(
    values: NDArray[np.complexfloating], start: NDArray[np.intp], weight: NDArray[np.float32]
) -> NDArray[np.complexfloating]:
    """(…, K) Σ_n weight_n·values[start + n] of values (M, K), for starts of any shape."""
    real = values.real.dtype
    taps, count = weight.shape[-1], start.size
    kind = np.int32 if len(values) < 2**31 else np.int64
    index = (start.reshape(-1, 1) + np.arange(taps)).astype(kind, copy=False)
    ends = np.arange(0, count * taps + 1, taps, dtype=kind)
    matrix = csr_array(
        (weight.reshape(-1).astype(real, copy=False), index.reshape(-1), ends),
        shape=(count, len(values)),
    )
    # Real weights on real and imaginary parts as columns: half of a complex product.
    out = matrix @ values.view(real)
    return np.ascontiguousarray(out).view(values.dtype).reshape(*start.shape, -1)
