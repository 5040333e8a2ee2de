"""What a hologram will take, counted from the plan that it would be made by.

Clusters, nodes, sub-clusters and terms are those of the real sum; of many clusters, or
sub-clusters, a few are planned and stand for the others.
"""

from dataclasses import replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import OperationCounts, product
from chrmc.cgh.curved import baseband, clusters
from chrmc.cgh.curved.axes import NODE_SHARE, Axes, axes_behind, cluster_axes
from chrmc.cgh.curved.clusters import Plane
from chrmc.cgh.curved.condense import condensing_of
from chrmc.cgh.curved.direct import SMALL
from chrmc.cgh.curved.levels import levels_for
from chrmc.cgh.curved.nodes import Axis
from chrmc.cgh.curved.nonuniform import readable, transforms_pay
from chrmc.cgh.curved.tables import MOST_AT_ONCE
from chrmc.cgh.curved.verify import waves_looked_at
from chrmc.cgh.curved.wave import Reference
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

_TRIED = 3  # clusters that are planned
_MANY = 20_000  # points from which some stand for all
_SOME = 4000  # points whose places give a cluster's nodes

# As measured, beside what is counted: steps of Python of a hologram, a cluster, a sub-cluster, a
# term of a series, a block of pixels; bytes for each node and term; table entries and waves in
# phasors.
_HOLOGRAM, _CLUSTER, _LEAF, _TERM = 5000.0, 6500.0, 8000.0, 150.0
_NODE, _BLOCK = 700.0, 80.0
_ENTRY, _WAVE = 4.2, 8.0
_FETCHED = 1.25  # of a product's time, its matrices being out of the cache
_AGAIN = 1.2  # of tight tolerances, which take a second attempt now and then
_TRANSFORMED, _TRANSFORMS = 200.0, 5e4  # phasors of a point that is transformed, steps beside
_FILTERS = 3e7  # phasors of the filters without which there are no transforms
_EDGE, _MIDDLE = 40, 1.5  # nodes of an edge that filters are tried for, and how much worse they are


def some_of(cloud: PointCloud) -> tuple[PointCloud, float]:
    """Points that stand for all of a cloud, and how many each stands for."""
    some = cloud.select(slice(None, None, ceil(len(cloud) / _MANY))) if len(cloud) else cloud
    return some, len(cloud) / max(1, len(some))


def cost_of(
    cloud: PointCloud,
    plane: Plane,
    tolerance: float,
    parts: list[PointCloud] | None = None,
    each: float = 1.0,
) -> OperationCounts:
    """Of a cloud's signal on all pixels.

    parts : its clusters, where they are known
    each : points that one of them stands for
    """
    pixels = plane.x.count * plane.y.count
    if len(cloud) * pixels <= SMALL:
        return OperationCounts(phasors=_WAVE * len(cloud) * pixels, calls=200.0)
    if parts is None:
        some, each = some_of(cloud)
        parts = clusters.split(some, plane, each)
    ordered = sorted(parts, key=len)
    tried = [ordered[i] for i in sorted(set(np.linspace(0, len(parts) - 1, _TRIED).astype(int)))]
    total = OperationCounts(
        phasors=_WAVE * waves_looked_at(len(cloud), tolerance),
        bytes=8.0 * pixels,
        calls=_HOLOGRAM,
        memory=12.0 * pixels + 80.0 * len(cloud),
    )
    again = 1.0 if tolerance > baseband.TIGHT else _AGAIN
    for part in tried:
        one = _of_cluster(part, plane, baseband.first_aim(tolerance), each)
        total += one.times(again * len(parts) / len(tried))
    return total


def _of_cluster(cloud: PointCloud, plane: Plane, tolerance: float, each: float) -> OperationCounts:
    """From points to pixels."""
    count = round(each * len(cloud))
    box = clusters.bounding_box(cloud.positions)
    reference = clusters.reference_of(box, plane)
    some = cloud.select(slice(None, None, max(1, len(cloud) // _SOME)))
    axes = cluster_axes(some, reference, plane, tolerance)
    total = OperationCounts(calls=_CLUSTER)
    if not axes[0].blocks or not axes[1].blocks:
        return total
    total += pixels_from(axes)
    if way := condensing_of(box, count, axes, plane, tolerance):
        total += OperationCounts(products=way.each * count, memory=80.0 * way.count)
        count, each = way.count, each * way.count / count
    nodes = len(axes[0].nodes), len(axes[1].nodes)
    if transforms_pay(count, box, axes, reference, plane, tolerance):
        total += OperationCounts(phasors=_FILTERS)
        if readable_by_a_part(some, axes, reference, plane, tolerance):
            return total + OperationCounts(
                phasors=_TRANSFORMED * count, calls=_TRANSFORMS, memory=140.0 * count
            )
    grid = clusters.leaf_grid(box, count, nodes, plane, tolerance)
    if grid == (1, 1, 1):
        return total + _of_sums(cloud, axes, reference, plane, tolerance, count)
    share = baseband.LEAF_SHARE * tolerance
    leaf, number = _a_leaf(cloud, some, box, grid)
    centre = clusters.reference_of(clusters.bounding_box(leaf.positions), plane)
    behind = axes_behind(axes, leaf, centre, plane, NODE_SHARE * share)
    one = _of_sums(leaf, behind, centre, plane, share, max(1, round(each * len(leaf))))
    few = len(behind[0].nodes), len(behind[1].nodes)
    one += OperationCounts(
        products=product(2 * few[1], 2 * few[0], nodes[0])
        + product(nodes[1], 2 * few[1], nodes[0]),
        bytes=24.0 * nodes[0] * nodes[1],
        calls=_LEAF,
    )
    held = len(cloud) / (number * max(1, len(leaf)))
    # Points of a leaf like this one make most of its work.
    return total + one.times(number * min(max(held, 0.5), 2.0))


def readable_by_a_part(
    cloud: PointCloud, axes: Axes, reference: Reference, plane: Plane, tolerance: float
) -> bool:
    """Whether filters will do for all edges, as a part of one along each axis tells."""
    (x, share_x), (y, share_y) = (_some_edge(axis) for axis in axes)
    share = min(_MIDDLE * max(share_x, share_y), 1.0) ** 0.5
    return readable(cloud, (x, y), reference, plane, share * tolerance) is not None


def _some_edge(axis: Axis) -> tuple[Axis, float]:
    """The axis with a few nodes in the middle of one soft edge, and their share of all.

    They stand for all: finding filters would be most of the work of counting.
    """
    edges = [run for run in axis.runs if run.tapered]
    if not edges:
        return axis, 1.0
    longest = max(edges, key=lambda run: len(run.weight))
    skipped = max(0, len(longest.weight) - _EDGE) // 2
    kept = slice(skipped, len(longest.weight) - skipped)
    start = longest.nodes.start
    few = replace(
        longest,
        nodes=slice(start + kept.start, start + kept.stop),
        line=longest.line.part(kept.start, kept.stop),
        weight=longest.weight[kept],
    )
    runs = tuple(few if run is longest else run for run in axis.runs
                 if not run.tapered or run is longest)  # fmt: skip
    share = float(few.weight.sum()) / sum(float(run.weight.sum()) for run in edges)
    return replace(axis, runs=runs), share


def _a_leaf(
    cloud: PointCloud, some: PointCloud, box: Floats, grid: clusters.Grid
) -> tuple[PointCloud, int]:
    """A sub-cluster of middle size, and how many there are."""
    parts = sorted(clusters.leaves(some, box, grid), key=len)
    middle = clusters.cells(parts[len(parts) // 2].positions[:1], box, grid)
    inside = clusters.cells(cloud.positions, box, grid) == middle
    return (cloud.select(inside) if inside.any() else parts[-1]), len(parts)


def _of_sums(
    cloud: PointCloud, axes: Axes, reference: Reference, plane: Plane, tolerance: float, count: int
) -> OperationCounts:
    """Of `count` points like these at nodes, by one series."""
    series = baseband.series_for(cloud, axes, reference, plane, tolerance, count)
    if series is None:
        return OperationCounts(phasors=_WAVE * count * len(axes[0].nodes) * len(axes[1].nodes))
    total = OperationCounts()
    for level in levels_for(cloud, axes, reference, plane, tolerance, series, count)[0]:
        terms = len(range(*level.terms.indices(series.terms)))
        nx, ny = len(level.axis_x.nodes), len(level.axis_y.nodes)
        wide = 1.0 if level.precision is np.float32 else 2.0
        held = min(count, MOST_AT_ONCE)
        times = wide * terms * count / held
        total += OperationCounts(
            products=3 * _FETCHED * times * product(ny, held, nx),
            phasors=wide * _ENTRY * count * (nx + ny),
            bytes=times * (_NODE * nx * ny + 24 * held * ny),
            calls=_TERM * terms * ceil(count / held),
            memory=wide * (12 * held * (nx + ny) + 8 * terms * nx * ny),
        )
    return total


def pixels_from(axes: Axes) -> OperationCounts:
    """From the baseband at the nodes to pixels."""
    ny = len(axes[1].nodes)
    products = bytes_ = 0.0
    for block in axes[0].blocks:
        products += product(2 * ny, 2 * block.node_count, block.target_count)
        bytes_ += 40.0 * block.node_count * block.target_count
    width = axes[0].targets.stop - axes[0].targets.start
    for block in axes[1].blocks:
        products += product(block.target_count, 2 * block.node_count, width)
    return OperationCounts(
        products=_FETCHED * products,
        bytes=bytes_ + 16.0 * ny * width,
        calls=_BLOCK * (len(axes[0].blocks) + len(axes[1].blocks)),
        memory=8.0 * ny * width,
    )
