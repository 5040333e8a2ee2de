"""Points at one place are one point: the sum of their waves at the source, exact for any method."""

from dataclasses import replace

import numpy as np

from chrmc.scene.points import PointCloud

_MIX = np.array([0.7548776662466927, 0.5698402909980532, 0.4142135623730951])
"""No grid of places gives one sum of coordinates twice: sorting one number finds equal places."""
_LEFT = 1e-8
"""Least power that waves of one place leave of theirs: what all but cancels is left to the methods,
which refuse where too few digits are left."""


def merged(cloud: PointCloud) -> PointCloud:
    """The cloud with one point for all that stand at exactly the same place.

    Its wave is the sum of theirs, a·exp(iφ) = Σ a_j·exp(iφ_j), in float64; it stands where the
    first of them stood in order. The same cloud where no two share a place.
    """
    key = cloud.positions @ _MIX
    ordered = np.sort(key)
    if not (ordered[1:] == ordered[:-1]).any():
        return cloud
    order = np.argsort(key)
    places = cloud.positions[order]
    apart = np.append(True, (places[1:] != places[:-1]).any(axis=1))
    group = np.empty(len(cloud), dtype=np.intp)
    group[order] = np.cumsum(apart) - 1
    first = np.full(group.max() + 1, len(cloud))
    first[group[::-1]] = np.arange(len(cloud))[::-1]
    waves = cloud.amplitude * np.exp(1j * cloud.phase)
    summed = np.bincount(group, waves.real) + 1j * np.bincount(group, waves.imag)
    among = np.bincount(group, np.abs(cloud.amplitude))
    if np.vdot(summed, summed).real < _LEFT * (among @ among):
        return cloud
    inwards = np.argsort(first)
    kept, summed = cloud.select(first[inwards]), summed[inwards]
    return replace(kept, amplitude=np.abs(summed), phase=np.angle(summed))
