"""By what factor a relief must be stretched for a picture's cells to tell most, and how surely."""

from collections.abc import Callable
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from reconstruct.jackknife import standard_error

STRETCHES = np.linspace(-2.0, 4.0, 61)
"""Factors of the relief that are tried."""
WRONG = 0.0, -1.0, 2.0
"""Stretches that the right one is weighed against: flat, inverted, twice as deep."""
_REACH = 10  # stretches to each side of the peak that a parabola is laid through


def stretch_of(
    at: Callable[[float], NDArray[np.float64]], light: NDArray[np.float64]
) -> tuple[float, float]:
    """The stretch at which the cells tell most, and its standard error.

    The larger of two: by the scatter of the cells' slopes there and the bend of their mean
    (sandwich formula), which takes cells for independent and the peak for a parabola; and by
    leaving out a sixteenth of the picture at a time (jackknife), which does not.
    """
    per_cell = np.array([at(g) for g in STRETCHES])
    curve = per_cell.sum(axis=(1, 2))
    factor, bend, part = _top(curve)
    if not bend < 0:
        return factor, float("inf")
    g = STRETCHES[part] - STRETCHES[int(curve.argmax())]
    slopes = np.polyfit(g, per_cell[part].reshape(len(g), -1), 2)[1]
    scatter = sqrt(float(((slopes - slopes.mean()) ** 2).sum())) / abs(2 * bend)
    jackknife = standard_error(per_cell, light > 0, lambda c: _top(c)[0])
    return factor, max(scatter, jackknife)


def gain_of_wrong(at: Callable[[float], NDArray[np.float64]], light: NDArray[np.float64]) -> float:
    """Standard errors by which the cells tell more at a wrong stretch than at 1."""
    right, gain = at(1.0), 0.0
    for wrong in WRONG:
        more = np.array([at(wrong) - right, light])
        error = standard_error(more, light > 0, lambda c: c[0] / c[1])
        gain = max(gain, float(more[0].sum() / light.sum()) / error if error > 0 else 0.0)
    return gain


def _top(curve: NDArray[np.float64]) -> tuple[float, float, slice]:
    """The stretch of a curve's peak, the bend there (not negative for none), and the part of the
    curve that was fitted."""
    top = int(curve.argmax())
    # A wide parabola through the peak: narrow ones follow single cells.
    part = slice(max(top - _REACH, 0), top + _REACH + 1)
    if top in (0, len(curve) - 1):
        return float(STRETCHES[top]), 0.0, part
    bend, slope, _ = np.polyfit(STRETCHES[part] - STRETCHES[top], curve[part], 2)
    if bend >= 0:
        return float(STRETCHES[top]), float(bend), part
    factor = STRETCHES[top] - slope / (2 * bend)
    return float(np.clip(factor, STRETCHES[0], STRETCHES[-1])), float(bend), part
