"""How sure a peak is that cells tell together: by leaving out a sixteenth of the picture at a time.

Neighbouring cells share speckle and defocused light, so they are left out together. A curve with
two peaks of nearly one height jumps from one to the other, and its standard error says so.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np
from numpy.typing import NDArray

_BLOCKS = 4  # of a picture's side


def standard_error(
    per_cell: NDArray[np.float64],
    lit: NDArray[np.bool_],
    peak: Callable[[NDArray[np.float64]], float],
) -> float:
    """Jackknife standard error of a peak of the sum of all cells' curves.

    per_cell : (D, m, n) what each cell adds at each place; lit : (m, n) cells that count
    peak : of a (D,) curve, NaN for none

    Infinite where one block holds all the light, or where a curve has no peak without one.
    """
    row, column = (_BLOCKS * np.arange(n) // n for n in lit.shape)
    block = row[:, None] * _BLOCKS + column
    curve = per_cell.sum(axis=(1, 2))
    others = np.array(
        [peak(curve - per_cell[:, block == k].sum(axis=1)) for k in np.unique(block[lit])]
    )
    n = len(others)
    if n < 2 or not np.isfinite(others).all():
        return float("inf")
    return sqrt((n - 1) / n * float(((others - others.mean()) ** 2).sum()))
