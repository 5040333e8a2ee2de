"""A cluster's points to its low-rank factor, by way of sub-clusters where there are many."""

from math import hypot
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.assembly import Factor, add_field, phasor, reference_cycles
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.nodes import Axis, make_axis
from chrmc.cgh.curved.parallel import spread
from chrmc.cgh.curved.series import Series, make_series
from chrmc.cgh.curved.tables import (
    MOST_AT_ONCE,
    Begun,
    begin_baseband,
    exact_baseband,
    finished,
    separable_baseband,
)
from chrmc.cgh.curved.wave import Reference, by_curvature
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]
Reals = NDArray[np.floating]
Summed = tuple[Reals, Reals, Series | float]

PANEL_X, PANEL_Y = 40.0, 18.0
"""κ of a panel: short ones make the second product small, long ones the baseband."""
_LEAF_PANEL = 80.0
_LEAF_SHARE = 0.7  # of the tolerance, for sub-clusters
_NODE_SHARE, _SERIES_SHARE = 0.5, 0.7  # of the tolerance, for interpolation and the series

_MOST_TERMS, _FEW = 120, 16  # terms of a series; points that are not split for it
MOST_WORK = 2e10
"""Points times nodes up to which waves are summed one by one."""
_SINGLE = 5e-6  # smallest tolerance whose tables and sums may be single precision


def cluster_axes(
    cloud: PointCloud,
    reference: Reference,
    targets: tuple[Floats, Floats],
    pitch: float | None,
    plane: Plane,
    tolerance: float,
) -> tuple[Axis, Axis]:
    """Nodes and panels along x and y for one cluster."""
    x, y, z = cloud.positions.T
    along_x, along_y = clusters.extents(clusters.bounding_box(cloud.positions), reference, plane)
    share = tolerance * _NODE_SHARE
    kappa = (PANEL_X, PANEL_Y) if pitch is not None else (_LEAF_PANEL, _LEAF_PANEL)
    return (
        make_axis(
            targets[0], pitch, x, z, along_x, plane.wavelength, plane.reach[0], share, kappa[0]
        ),
        make_axis(
            targets[1], pitch, y, z, along_y, plane.wavelength, plane.reach[1], share, kappa[1]
        ),
    )


def make_factor(
    cloud: PointCloud,
    targets: tuple[Floats, Floats],
    pitch: float | None,
    plane: Plane,
    tolerance: float,
    leaf: bool = False,
) -> tuple[Factor, Series | float]:
    """The low-rank factor of one cluster, with the series in use.

    Where sub-clusters have a series each, their largest relative rms remainder stands for them.
    """
    return finished(begin_factor(cloud, targets, pitch, plane, tolerance, leaf))


def begin_factor(
    cloud: PointCloud,
    targets: tuple[Floats, Floats],
    pitch: float | None,
    plane: Plane,
    tolerance: float,
    leaf: bool = False,
) -> Begun[tuple[Factor, Series | float]]:
    """`make_factor` in pieces, so that those of several clusters may run side by side."""
    box = clusters.bounding_box(cloud.positions)
    reference = clusters.reference_of(box, plane)
    axis_x, axis_y = cluster_axes(cloud, reference, targets, pitch, plane, tolerance)
    if not axis_x.panels or not axis_y.panels:
        empty = np.zeros((len(axis_y.nodes), len(axis_x.nodes)), dtype=np.float32)
        return [], lambda: (Factor(axis_x, axis_y, reference, empty, empty), 0.0)
    pieces, sums = begin_sum(cloud, axis_x, axis_y, reference, plane, tolerance, leaf)

    def result() -> tuple[Factor, Series | float]:
        real, imag, series = sums()
        single = real.astype(np.float32, copy=False), imag.astype(np.float32, copy=False)
        return Factor(axis_x, axis_y, reference, *single), series

    return pieces, result


def sum_points(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    series: Series | None = None,
) -> Summed:
    """Real and imaginary baseband (n_y, n_x) of a cloud at given nodes, and the series in use.

    series : one made for these points and nodes, if there is
    """
    return finished(begin_sum(cloud, axis_x, axis_y, reference, plane, tolerance, series=series))


def begin_sum(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    plane: Plane,
    tolerance: float,
    leaf: bool = False,
    series: Series | None = None,
) -> Begun[Summed]:
    """`sum_points` in pieces.

    leaf : sum all points at once, not by sub-clusters
    """
    box = clusters.bounding_box(cloud.positions)
    nodes = len(axis_x.nodes), len(axis_y.nodes)
    grid = (1, 1) if leaf else clusters.leaf_grid(box, len(cloud), nodes, plane)
    if grid != (1, 1):
        parts = clusters.leaves(cloud, box, grid)
        return [], lambda: _from_leaves(parts, axis_x, axis_y, reference, plane, tolerance)
    if series is None:
        series = series_for(cloud, axis_x, axis_y, reference, plane, tolerance)
    if series is None or series.terms > _MOST_TERMS:
        # The rest of the wave changes too much over the cluster: smaller ones, or none at all.
        parts = clusters.leaves(cloud, box, (2, 2, 2)) if len(cloud) > _FEW else []
        if len(parts) > 1:
            return [], lambda: _from_leaves(parts, axis_x, axis_y, reference, plane, tolerance)
        work = len(cloud) * len(axis_x.nodes) * len(axis_y.nodes)
        if work > MOST_WORK:
            raise ValueError(
                f"{len(cloud)} points at {1e3 * box[2, 0]:.3g} mm would take {work:.1e} waves one "
                f"by one, about {work * 4e-8 / 60:.0f} minutes: move them farther away"
            )
        return [], lambda: (
            *exact_baseband(cloud, axis_x, axis_y, reference, plane.wavelength, plane.reach),
            0.0,
        )
    precision = np.float32 if tolerance >= _SINGLE else np.float64
    fixed = axis_x, axis_y, reference, plane.wavelength, plane.reach, series, precision
    if len(cloud) > MOST_AT_ONCE:
        return [], lambda: (*separable_baseband(cloud, *fixed), series)
    pieces, sums = begin_baseband(cloud, *fixed)
    return pieces, lambda: (*sums(), series)


def series_for(
    cloud: PointCloud,
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> Series | None:
    """The series of the non-separable rest for a cloud's points and some nodes."""
    return make_series(
        (float(axis_x.nodes[0]), float(axis_x.nodes[-1])),
        (float(axis_y.nodes[0]), float(axis_y.nodes[-1])),
        clusters.bounding_box(by_curvature(cloud.positions)),
        reference.kernel(plane.wavelength),
        tolerance * _SERIES_SHARE,
    )


def _from_leaves(
    parts: list[PointCloud],
    axis_x: Axis,
    axis_y: Axis,
    reference: Reference,
    plane: Plane,
    tolerance: float,
) -> tuple[Reals, Reals, float]:
    """Baseband at a cluster's nodes, summed over sub-clusters' own few nodes.

    Also the relative rms error of the sub-clusters: their series' and their nodes'.
    """
    x, y = axis_x.nodes, axis_y.nodes
    total = np.zeros((len(y), len(x)), dtype=np.complex64)
    own_x = reference_cycles(x, reference.x, reference.z_x, plane.wavelength)
    own_y = reference_cycles(y, reference.y, reference.z_y, plane.wavelength)
    share = _LEAF_SHARE * tolerance
    lock = Lock()

    def carry(part: PointCloud) -> float:
        factor, left_out = make_factor(part, (x, y), None, plane, share, leaf=True)
        its = factor.reference
        turn_x = phasor(reference_cycles(x, its.x, its.z_x, plane.wavelength) - own_x)
        turn_y = phasor(reference_cycles(y, its.y, its.z_y, plane.wavelength) - own_y)
        with lock:
            add_field(total, factor, turn_x, turn_y, add=True)
        return left_out if isinstance(left_out, float) else left_out.dropped

    dropped = max(spread(carry, parts))
    between = _NODE_SHARE * share
    return total.real.copy(), total.imag.copy(), hypot(dropped, between)
