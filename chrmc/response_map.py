"""How a grey response varies over a panel: a polynomial in x and y at each level.

intensity(grey; x, y) = intensity(grey) + Σ tilt[grey, term]·term(x, y), x and y from −1 to 1 over
the panel's columns and rows; every term has the mean 0. It is applied in tiles, each with the
response of its middle.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

TERMS = ("x", "y", "x^2", "xy", "y^2")
"""Columns of a table; x^2 and y^2 stand for x² − 1/3 and y² − 1/3."""
TILES = (24, 40)
"""Down and across."""
STEPS = 1 << 14
"""Of the backward tables: finer than a grey step by 64."""


def basis(y: NDArray[np.float64], x: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    """(terms, rows, columns) values of the terms of degree 1 or 2."""
    x, y = np.broadcast_arrays(x[None, :], y[:, None])
    linear = [x, y]
    return np.stack(linear if degree == 1 else [*linear, x * x - 1 / 3, x * y, y * y - 1 / 3])


def tiles(shape: tuple[int, int]) -> Iterator[tuple[int, int, tuple[slice, slice]]]:
    """Row and column of each tile, and its pixels on a panel of (rows, columns)."""
    edges = [
        np.linspace(0, n, min(count, n) + 1).astype(int)
        for n, count in zip(shape, TILES, strict=True)
    ]
    for i in range(len(edges[0]) - 1):
        for j in range(len(edges[1]) - 1):
            rows = slice(int(edges[0][i]), int(edges[0][i + 1]))
            yield i, j, (rows, slice(int(edges[1][j]), int(edges[1][j + 1])))


def tile_levels(
    levels: NDArray[np.complex128], tilt: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """(tiles down, tiles across, 256) amplitude of each level in each tile's middle.

    What noise of the map turned back is made monotone again.
    """
    from scipy.optimize import isotonic_regression

    middles = [(np.arange(n) + 0.5) / n * 2 - 1 for n in TILES]
    terms = basis(middles[0], middles[1], 1 if tilt.shape[1] == 2 else 2)
    power = np.abs(levels) ** 2 + np.tensordot(terms, tilt, axes=(0, 1))
    rising = bool(abs(levels[-1]) >= abs(levels[0]))
    turn = np.exp(1j * np.angle(levels))
    for row in power:
        for tile in row:
            tile[:] = isotonic_regression(tile, increasing=rising).x
    return np.sqrt(np.maximum(power, 0)) * turn


def tile_tables(amplitudes: NDArray[np.complex128]) -> NDArray[np.uint8]:
    """(tiles down, tiles across, 16385) nearest grey for wanted amplitudes 0 … 1.

    0 and 1 are the darkest and the brightest that every tile can show.
    """
    modulus = np.abs(amplitudes)
    low, high = float(modulus.min(axis=2).max()), float(modulus.max(axis=2).min())
    if not high > low:
        raise ValueError(
            f"no amplitude can be shown everywhere: the darkest level reaches {low:.3g} somewhere, "
            f"the brightest only {high:.3g} elsewhere"
        )
    wanted = np.linspace(low, high, STEPS + 1)
    tables = np.empty((*modulus.shape[:2], STEPS + 1), dtype=np.uint8)
    for i, row in enumerate(modulus):
        for j, tile in enumerate(row):
            order = np.argsort(tile, kind="stable")
            middles = (tile[order][1:] + tile[order][:-1]) / 2
            tables[i, j] = order[np.searchsorted(middles, wanted, side="right")]
    return tables
