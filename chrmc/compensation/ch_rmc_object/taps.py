"""Local Lagrange interpolation on an equally spaced grid that oversamples what it holds."""

from math import factorial, pi, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def weights(position: Floats, taps: int) -> tuple[NDArray[np.intp], list[Floats]]:
    """First grid index, and the weight of each of `taps` neighbours, at positions in grid steps.

    position : any shape; the neighbours surround it, taps/2 on either side
    """
    first = np.floor(position).astype(np.intp) - (taps // 2 - 1)
    gap = [position - first - k for k in range(taps)]
    # Products of all gaps but one, from running products on both sides.
    ahead: list[Floats | float] = [1.0]
    for k in range(taps - 1):
        ahead.append(ahead[-1] * gap[k])
    out: list[Floats] = []
    behind: Floats | float = 1.0
    for k in range(taps - 1, -1, -1):
        scale = (-1.0) ** (taps - 1 - k) / (factorial(k) * factorial(taps - 1 - k))
        out.append(np.asarray(ahead[k] * behind * scale, dtype=np.float64))
        behind = behind * gap[k]
    return first, out[::-1]


def rms_error(step_phase: Floats | float, taps: int) -> Floats:
    """Relative rms error for exp(iωt) where ω·step = `step_phase`: the leading term.

    |∏(t − k)|·θ^taps/taps!, root mean square over t in the middle cell.
    """
    t = taps / 2 - 1 + (np.arange(16) + 0.5) / 16
    product = np.prod(t[:, None] - np.arange(taps), axis=1)
    size = sqrt(float(np.mean(product**2))) / factorial(taps)
    return size * np.abs(np.asarray(step_phase, dtype=np.float64)) ** taps


def taps_for(tolerance: float) -> int:
    """An even number of taps that balances the grid's size against the work of a look-up."""
    return 8 if tolerance >= 1e-4 else 12


def step_for(bandwidth: float, taps: int, tolerance: float) -> float:
    """Grid step at which all frequencies up to `bandwidth` (per unit) meet `tolerance`, rms."""
    theta = (tolerance / float(rms_error(1.0, taps))) ** (1 / taps)
    return min(theta, pi / 2) / (2 * pi * max(bandwidth, 1e-9))
