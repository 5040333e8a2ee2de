"""Chebyshev nodes on an interval, and the matrices that interpolate from them.

A wave whose local frequency stays below f over a length D needs n = κ + a·κ^(1/3) of them,
κ = π·f·D; a grows by 0.93 with each decimal digit.
"""

from functools import lru_cache
from math import ceil, log10, pi

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@lru_cache(maxsize=256)
def chebyshev(count: int) -> Floats:
    """(count,) Chebyshev nodes of the first kind on [−1, 1], ascending. Read-only."""
    nodes = -np.cos(pi * (np.arange(count) + 0.5) / count)
    nodes.flags.writeable = False
    return nodes


def interpolation(count: int, targets: Floats) -> Floats:
    """(len(targets), count) matrix from values at `chebyshev(count)` to targets in [−1, 1].

    Second (true) barycentric form: Berrut and Trefethen, SIAM Review 46, 501 (2004).
    """
    index = np.arange(count)
    weights = (-1.0) ** index * np.sin(pi * (index + 0.5) / count)
    gap = np.asarray(targets, dtype=np.float64)[:, None] - chebyshev(count)
    exact = np.abs(gap) < 1e-15
    terms = weights / np.where(exact, 1.0, gap)
    on_node = exact.any(axis=1)
    terms[on_node] = exact[on_node]
    return terms / terms.sum(axis=1, keepdims=True)


def node_count(kappa: float, tolerance: float) -> int:
    """Nodes for exp(iκu), |κ| ≤ kappa, on [−1, 1] at an rms error of `tolerance`."""
    digits = max(1.0, -log10(tolerance))
    return max(1, ceil(kappa + (0.93 * digits - 0.35) * max(kappa, 3.0) ** (1 / 3)))
