"""The grid of directions and ranges that a view needs, for an object of some size."""

from dataclasses import dataclass
from math import ceil, factorial, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import Taps, chebyshev, taps_for
from chrmc.compensation.ch_rmc_object.chart import Span, View

Floats = NDArray[np.float64]

SHARE = 0.2
"""Of the tolerance: for each of α, β and the sums behind the grid."""
MOST_SWING = 2.2
"""Radians that a point's phase may change by to either side of the middle range: at 2.4 the first
layer, which all others are added to, passes through 0."""
_RANGE_SHARE = 0.3  # for the layers of range
_LONGEST = 0.02  # step of a grid, so that what it has beyond the view is still a direction


@dataclass(frozen=True, eq=False)
class Grid:
    """Even places in α and β, and layers of range.

    first, step, count : of α and β
    bandwidth : cycles per unit of α and of β, the latter along a leaning column
    layers : (L,) 1/r, Chebyshev nodes of `span`
    tile : places of a tile along α and β
    """

    first: tuple[float, float]
    step: tuple[float, float]
    count: tuple[int, int]
    bandwidth: tuple[float, float]
    layers: Floats
    span: Span
    tile: tuple[int, int]
    taps: Taps
    tilt: float


def make_grid(
    half: Floats, view: View, width: tuple[float, float], wavelength: float, tolerance: float
) -> Grid:
    """The grid for an object whose points lie within `half` (3,) of its centre.

    width : of one frame's view in α and β
    """
    taps = taps_for(SHARE * tolerance)
    spans = view.alpha, view.beta
    far = [max(abs(low), abs(high)) for low, high in spans]
    gamma = sqrt(max(1 - far[0] ** 2 - far[1] ** 2, 0.05))
    # ∂(Δ·d)/∂α = Δ_1 + Δ_3·α/γ; the path's second order adds Δ²/r to a share of it.
    across, down = (1.02 * (half[i] + half[2] * far[i] / gamma) / wavelength for i in range(2))
    down += across * view.tilt
    steps = min(taps.step(across), _LONGEST), min(taps.step(down), _LONGEST)
    # A leaning column needs more of α where β has ended.
    high = taps.count // 2 + 4
    pads = taps.count // 2 + 2 + ceil(view.tilt * high * steps[1] / steps[0]), high
    count = [
        ceil((high - low) / step) + 2 * pad + 1
        for (low, high), step, pad in zip(spans, steps, pads, strict=True)
    ]
    # The rms over a box of points of what is largest at its corners.
    delta2 = sqrt((half[0] ** 4 + half[1] ** 4) / 5 + 2 * (half[0] * half[1]) ** 2 / 9)
    swing = pi * delta2 * (view.s[1] - view.s[0]) / 2 / wavelength
    layers = layer_count(swing, _RANGE_SHARE * tolerance)
    middle, either = (view.s[0] + view.s[1]) / 2, (view.s[1] - view.s[0]) / 2
    tile = (
        min(count[0], ceil(width[0] / 2 / steps[0]) + 1),
        # A little more than a view is not worth two tiles.
        count[1] if count[1] * steps[1] < 2 * width[1] else ceil(width[1] / 2 / steps[1]) + 1,
    )
    return Grid(
        (spans[0][0] - pads[0] * steps[0], spans[1][0] - pads[1] * steps[1]), steps,
        (count[0], count[1]), (across, down), middle + either * chebyshev(layers), view.s, tile,
        taps, view.tilt,
    )  # fmt: skip


def most_swing(half: Floats, span: Span, wavelength: float) -> float:
    """Radians of the outermost points' phases over a span of 1/r, to either side."""
    return float(pi * (half[0] ** 2 + half[1] ** 2) * (span[1] - span[0]) / 2 / wavelength)


def layer_count(swing: float, tolerance: float) -> int:
    """Layers for a phase of ±swing radians over the range: √2·J_L(swing) ≤ tolerance, about."""
    count = 1
    while sqrt(2) * (swing / 2) ** count / factorial(count) > tolerance and count < 40:
        count += 1
    return count
