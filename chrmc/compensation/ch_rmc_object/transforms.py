"""Many points at once on a tile of directions, by non-uniform Fourier transforms (finufft).

From the middle of a tile a point's path is nearly linear in α and β: its slopes there are the place
that a transform takes it from. What curves is a short series in direction and point, one transform
a term.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.interface import (
    bounding_box,
    in_parallel,
    phasors,
    transformed,
)
from chrmc.compensation.ch_rmc_object.chart import Floats, Place, path, slopes
from chrmc.compensation.ch_rmc_object.layers import layer_series, middle_range
from chrmc.scene.points import PointCloud

TRANSFORMED = 8000
"""Points of one part from which transforms are quicker than tables."""
_SINGLE = 5e-5  # smallest error that single precision serves: places are rounded to 1e-7 of a turn
_AT_ONCE = 50_000  # points of a transform
MOST_TERMS = 60
"""Of a series, beyond which tables are quicker."""


def transformed_tile(
    points: PointCloud,
    directions: tuple[Floats, Floats],
    layers: Floats,
    wavelength: float,
    tolerance: float,
) -> tuple[list[NDArray[np.complexfloating]], float] | None:
    """Of each layer (n_β, n_α) Σ_j a_j·(r/r_j)·exp(ik(r_j − r) + iφ_j), and the relative error.

    points : about the part's centre, in the chart's axes
    directions : α and β
    layers : 1/r, see `layer_waves`

    None where the series is long.
    """
    alpha, beta = directions
    at_a, at_b = (t[len(t) // 2] for t in directions)  # where transforms count from
    r = middle_range(layers)
    box = bounding_box(points.positions)
    ends = (float(alpha[0]), float(alpha[-1])), (float(beta[0]), float(beta[-1]))

    def rest(a: Floats, b: Floats, place: Place) -> Floats:
        along_a, along_b = slopes(at_a, at_b, place, r)
        linear = along_a * (a - at_a) + along_b * (b - at_b)
        return path(a, b, place, r) - path(at_a, at_b, place, r) - linear

    expanded = layer_series(ends, box, layers, rest, wavelength, tolerance)
    if expanded is None or any(series.terms > MOST_TERMS for series in expanded[0]):
        return None
    every, dropped = expanded
    real: type[np.floating] = np.float32 if tolerance >= _SINGLE else np.float64
    kind = np.result_type(real, np.complex64)
    steps = [(float(t[-1]) - float(t[0])) / max(len(t) - 1, 1) for t in directions]

    def some(part: slice) -> NDArray[np.complexfloating]:
        own = points.positions[part]
        place: Place = (own[:, 0], own[:, 1], own[:, 2])
        cycles = path(at_a, at_b, place, r) / wavelength + points.phase[part] / (2 * pi)
        cycles -= np.rint(cycles)
        angles = [
            (2 * pi * step / wavelength * slope).astype(real)
            for step, slope in zip(steps, slopes(at_a, at_b, place, r), strict=True)
        ]
        wave = phasors(2 * pi * cycles, points.amplitude[part]).astype(kind)
        strength = [series.at_points(own).astype(real) * wave for series in every]
        return transformed(angles, np.concatenate(strength), (len(alpha), len(beta)), tolerance)

    runs = [slice(n, n + _AT_ONCE) for n in range(0, len(points), _AT_ONCE)]
    first, *others = in_parallel(some, runs)
    for one in others:
        first += one
    out = []
    terms = iter(first)
    for series in every:
        weights = series.on_nodes(alpha, beta, real)
        total = np.zeros((len(beta), len(alpha)), dtype=kind)
        for term in range(series.terms):
            cos, sin = weights.of(term)
            total += next(terms).T * (cos + 1j * sin)
        out.append(total)
    return out, float(np.hypot(dropped, tolerance))
