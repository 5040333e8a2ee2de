"""Which terms of a series are summed at which nodes.

The terms after the first are small, so they need not be summed at nodes that hold the whole
tolerance: fewer do, from which they are carried to the others.
"""

from collections.abc import Callable
from dataclasses import replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.along import waves_along
from chrmc.cgh.curved.axes import Axes, axes_behind
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.predict import axis_powers, sample_points, spots_of
from chrmc.cgh.curved.series import Series
from chrmc.cgh.curved.tables import Level
from chrmc.cgh.curved.wave import Reference, Wave, by_curvature
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

SINGLE = 5e-6
"""Smallest tolerance whose tables and sums may be single precision."""
_COARSE_SHARE = 0.3  # of the tolerance, for the interpolation of the small terms
_CLOSER = 0.2  # what is aimed at anew, where terms are steeper than the waves
_SMALL = 0.08  # a level's terms against those of the level before


def precision_for(tolerance: float) -> type[np.floating]:
    """Of tables and sums."""
    return np.float32 if tolerance >= SINGLE else np.float64


def levels_for(
    cloud: PointCloud,
    axes: Axes,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    series: Series,
    count: int | None = None,
) -> tuple[list[Level], float]:
    """Which terms are summed at which nodes, and the error of carrying the small ones.

    count : points that the cloud stands for, its own by default
    """
    count = len(cloud) if count is None else count
    levels: list[Level] = []
    held, first, square = axes, 0, 0.0
    aim = tolerance
    for cut in range(1, series.terms):
        # A level begins where all terms left are small against those of the level before.
        left = float(np.linalg.norm(series.sizes[cut:]))
        if left > _SMALL * float(np.linalg.norm(series.sizes[first:])):
            continue
        size = len(held[0].nodes), len(held[1].nodes)
        more = series.terms - cut
        if not clusters.coarse_pays(count, size, size[0] * size[1] * 2 // 3, more):
            continue
        wanted = min(_COARSE_SHARE * tolerance / left, 0.1)
        coarse, missed = held, 0.0
        for closer in (wanted, _CLOSER * wanted):
            behind = axes_behind(axes, cloud, reference, plane, closer)
            pixels = len(behind[0].nodes) * len(behind[1].nodes)
            if not clusters.coarse_pays(count, size, pixels, more):
                break
            if not series.holds_at(behind[0].nodes, behind[1].nodes):
                break
            missed = carried(cloud, axes, behind, Wave(reference, plane.wavelength, plane.reach),
                             series, slice(cut, None))  # fmt: skip
            if missed <= _COARSE_SHARE * tolerance:
                coarse = behind
                break
        if coarse is not held:
            square += missed**2
        elif precision_for(wanted) == precision_for(aim):
            continue
        # Or they are summed at the same nodes in single precision.
        levels.append(Level(*held, slice(first, cut), precision_for(aim)))
        held, first, aim = coarse, cut, wanted
    levels.append(Level(*held, slice(first, None), precision_for(aim)))
    return levels, sqrt(square)


def carried(
    cloud: PointCloud, axes: Axes, behind: Axes, wave: Wave, series: Series, terms: slice
) -> float:
    """Relative rms error of some terms at nodes that are read from fewer, tried on a few points.

    A term may be steeper than the wave that it is a part of.
    """
    reference = wave.reference
    strength = (cloud.amplitude * reference.modulus(cloud.positions[:, 2])) ** 2
    chosen, weight = sample_points(strength, cloud.positions)
    points = cloud.positions[chosen].T
    of_points = series.at_points(by_curvature(cloud.positions[chosen]))[terms]
    square = 0.0
    for axis in range(2):
        across = 1 - axis
        spots = spots_of(axes[across], points[across], wave.reach[across] * points[2])
        whole = waves_along(wave, axis, points)
        small = replace(whole, rest=_along(axis, spots, series, terms, of_points))
        light, _ = axis_powers(behind[axis], axes[axis].nodes, whole)
        _, miss = axis_powers(behind[axis], axes[axis].nodes, small)
        square += float(weight @ miss) / float(weight @ light)
    return sqrt(square)


def _along(
    axis: int, spots: Floats, series: Series, terms: slice, of_points: Floats
) -> Callable[[Floats, Floats, Floats], NDArray[np.complex128]]:
    """Some terms along an axis, as `Along` takes them.

    spots : (N,) where each point is looked at on the other axis
    of_points : (L, N) P_l
    """

    def rest(t: Floats, x: Floats, z: Floats) -> NDArray[np.complex128]:
        places = (t, spots) if axis == 0 else (spots, t)
        on_nodes = series.on_nodes(*places, np.float64, terms)
        out = np.zeros((len(spots), len(t)), dtype=np.complex128)
        for number, own in enumerate(of_points):
            real, imag = on_nodes.of(number)
            term = real + 1j * imag
            out += own[:, None] * (term if axis == 0 else term.T)
        return out

    return rest
