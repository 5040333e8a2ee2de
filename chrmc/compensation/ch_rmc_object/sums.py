"""Sums of points on a grid of directions: tables of phases along either axis, and their product."""

from collections.abc import Callable
from math import ceil, log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import chebyshev, interpolation

Floats = NDArray[np.float64]


def cycles_of(
    length: Callable[[Floats], Floats], at: Floats, other: Floats, wavelength: float
) -> Floats:
    """(N, len(at)) path over the wavelength at many places from few, exact to 1e-10.

    The path is analytic in α up to γ = 0, so that its Chebyshev series falls fast.
    """
    low, high = float(at[0]), float(at[-1])
    reach = (high - low) / 2
    edge = sqrt(1 - float(other) ** 2)
    if reach > 0:
        ratio = (edge - max(abs(low), abs(high))) / reach + 1
        few = 4 + ceil(log(1e12) / log(ratio + sqrt(ratio * ratio - 1)))
        if few < 0.7 * len(at):
            coarse = (low + high) / 2 + reach * chebyshev(few)
            matrix = interpolation(few, (at - (low + high) / 2) / reach).T
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
    """Σ_t weights_t·Σ_j scale_tj·down_j·across_j, (n_β, n_α), one real product a term."""
    right = across.reshape(-1, across.shape[2])
    rows = down.shape[2]
    left = np.empty((2, down.shape[1], 2, rows), dtype=right.dtype)
    total: NDArray[np.complexfloating] | None = None
    for share, weight in zip(scale, weights, strict=True):
        column = share[:, None]
        np.multiply(down[0], column, out=left[0, :, 0])
        np.multiply(down[1], column, out=left[0, :, 1])
        left[1, :, 1] = left[0, :, 0]
        np.multiply(left[0, :, 1], right.dtype.type(-1), out=left[1, :, 0])
        flat = left.reshape(-1, 2 * rows).T @ right
        one = np.empty((rows, right.shape[1]), dtype=weights.dtype)
        one.real, one.imag = flat[:rows], flat[rows:]
        one *= weight
        total = one if total is None else total + one
    assert total is not None
    return total
