"""Which points share a reference wave, and in how many sub-clusters their baseband is summed."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.bandwidth import Extent
from chrmc.cgh.curved.nodes import Axis, Line
from chrmc.cgh.curved.wave import Reference
from chrmc.optics.footprint import SOFT_SHARE
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

# Costs in multiply-adds of a matrix product, as measured: a cluster's fixed work.
_CLUSTER = 2.5e8
_CARRY = 3e8
# Of sums: a wave's term at a node, a table entry; of sub-clusters their fixed work, a value at a
# node of theirs for each term, or of the cluster's, and a step of the products between these.
_WAVE, _ENTRY, _LEAF, _NODE, _CARRIED = 2.1, 800.0, 1e8, 410.0, 2.6
_LEVELLED = 2e-4  # tolerance from which a whole cluster's small terms are summed at few nodes
_DENSE, _LEAST = 0.64, 20.0  # nodes of a sub-cluster for its κ, and beside these
_FEWEST = 100  # points of one, at least
_LATERAL, _DEEP = 2.0 ** np.arange(7), 2.0 ** np.arange(4)  # how many there may be

Grid = tuple[int, int, int]
"""Sub-clusters along x, y and z."""
Shares = Sequence[Floats | float]
"""The same, or arrays of them, to be broadcast."""


@dataclass(frozen=True)
class Plane:
    """What clusters are planned for: targets on the hologram and the wave.

    x, y : of the targets
    reach : footprint half-width per depth in x and y
    points : in all, which share what may be summed one by one where no series fits
    """

    x: Line
    y: Line
    wavelength: float
    reach: tuple[float, float]
    points: int = 1

    @property
    def lines(self) -> tuple[Line, Line]:
        """x and y."""
        return self.x, self.y


def bounding_box(positions: Floats) -> Floats:
    """(3, 2) lowest and highest x, y, z."""
    # A coordinate at a time: NumPy's reduction along the long axis of (N, 3) is far slower.
    return np.array([(column.min(), column.max()) for column in positions.T])


_FAR = 0.6  # rms distance on the hologram, of the largest: halves what is not separable


def reference_of(box: Floats, plane: Plane) -> Reference:
    """Centre of a box; in depth the one that halves the range of 1/z, as curvatures go."""
    x, y = box[:2].mean(axis=1)
    z = 2 / (1 / box[2, 0] + 1 / box[2, 1])
    return reference_at((float(x), float(y), float(z)), box, plane)


def reference_at(centre: tuple[float, float, float], box: Floats, plane: Plane) -> Reference:
    """The reference wave from a given centre, for points in a box."""
    usual = []
    for far, near in zip(farthest(box, plane), nearest(box, plane), strict=True):
        usual.append(max(_FAR * far, sqrt((far * far + far * near + near * near) / 3)))
    return Reference(*centre, usual[0], usual[1])


def farthest(box: Floats, plane: Plane) -> tuple[float, float]:
    """Largest distance along x and y of a target from a point whose footprint holds it."""
    far = []
    for axis, line in enumerate(plane.lines):
        both = max(abs(line.last - box[axis, 0]), abs(line.first - box[axis, 1]))
        far.append(min(float(both), float(box[2, 1]) * plane.reach[axis]))
    return far[0], far[1]


def nearest(box: Floats, plane: Plane) -> tuple[float, float]:
    """Smallest distance along x and y of a target from a point, of a box beside the targets."""
    x, y = (
        max(line.first - float(high), float(low) - line.last, 0.0)
        for line, (low, high) in zip(plane.lines, box[:2], strict=True)
    )
    return x, y


def extents(box: Floats, reference: Reference, plane: Plane) -> tuple[Extent, Extent]:
    """The box along x and along y."""
    (far_x, far_y), (near_x, near_y) = farthest(box, plane), nearest(box, plane)
    (x_low, x_high), (y_low, y_high), (z_low, z_high) = box.tolist()
    return (
        Extent(x_low, x_high, z_low, z_high, reference.x, reference.z_x, far_y, near_y),
        Extent(y_low, y_high, z_low, z_high, reference.y, reference.z_y, far_x, near_x),
    )


def lit(box: Floats, plane: Plane) -> tuple[float, float]:
    """Metres of the targets' range along x and y in some point's footprint."""
    lengths = []
    for axis, line in enumerate(plane.lines):
        far = float(box[2, 1]) * plane.reach[axis]
        length = min(line.last, float(box[axis, 1]) + far)
        length -= max(line.first, float(box[axis, 0]) - far)
        lengths.append(max(length, (line.last - line.first) / line.count))
    return lengths[0], lengths[1]


def _kappas(
    box: Floats, plane: Plane, grid: Shares = (1, 1, 1)
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """π·(bandwidth)·(length) of the baseband along x and y, in the paraxial estimate; and which
    shares of the targets that the box lights these lengths are.

    grid : sub-clusters along x, y and z, numbers or arrays to be broadcast; one of them is meant

    A point at half the cluster's width differs by (width/2)/z in direction, one at its front or
    back by half the range of 1/z times the distance to the farthest target.
    """
    z_low, z_high = (float(z) for z in box[2])
    deep = (1 / z_low - 1 / z_high) / grid[2]
    kappas, shares = [], []
    sizes = [float(size) for size in np.ptp(box[:2], axis=1)]
    for axis, (far, length) in enumerate(zip(farthest(box, plane), lit(box, plane), strict=True)):
        size = sizes[axis] / grid[axis]
        held = size + 2 * z_high * plane.reach[axis]
        share = np.minimum(held, length) / length if length > 0 else np.ones(())  # of one column
        sine = np.minimum(size / 2 / z_low + far * deep / 2, 2.0)
        kappas.append(np.asarray(pi * sine / plane.wavelength * length * share))
        shares.append(np.asarray(share))
    return (kappas[0], kappas[1]), (shares[0], shares[1])


def speckles(cloud: PointCloud, plane: Plane) -> float:
    """How many the light of points has on the targets, about; a single point's is one."""
    (along_x, along_y), _ = _kappas(bounding_box(cloud.positions), plane)
    return float((1 + 2 / pi * along_x) * (1 + 2 / pi * along_y))


def _cost(box: Floats, count: int, plane: Plane) -> float:
    """Multiply-adds, about, of one cluster from points to pixels."""
    (kx, ky), _ = _kappas(box, plane)
    w, h = plane.x.count, plane.y.count
    nx, ny = min(1.25 * float(kx) + 8, w), min(1.35 * float(ky) + 8, h)
    to_columns = 4 * ny * min(nx, 50) * w
    to_pixels = 2 * min(ny, 26) * h * w
    # Many points are summed in sub-clusters, however large the cluster is.
    if count > 3000:
        nx, ny = min(nx, 30.0), min(ny, 20.0)
    sums = count * (16 * nx * ny + 500 * (nx + ny))
    return to_columns + to_pixels + sums + _CLUSTER


def split(cloud: PointCloud, plane: Plane, each: float = 1.0) -> list[PointCloud]:
    """Clusters with a reference wave each: cut at gaps, or in half, as long as that costs less.

    each : points that every one stands for
    """
    box = bounding_box(cloud.positions)

    def cost(box: Floats, number: int) -> float:
        return _cost(box, round(each * number), plane)

    whole = cost(box, len(cloud))
    if len(cloud) < 2 or whole < 2.5 * _CLUSTER:
        return [cloud]
    best, chosen = whole * 0.9, None
    for axis in range(3):
        values = cloud.positions[:, axis]
        for cut in _cuts(values, box[axis]):
            if cut is None:
                # In half: worth a look at the points only if halves of the box would pay.
                cut = float(box[axis].mean())
                half = box.copy()
                half[axis, 1] = cut
                if 2 * cost(half, (len(cloud) + 1) // 2) >= best:
                    continue
            low = values < cut
            size = int(np.count_nonzero(low))
            if size in (0, len(cloud)):
                continue
            both = cost(bounding_box(cloud.positions[low]), size)
            both += cost(bounding_box(cloud.positions[~low]), len(cloud) - size)
            if both < best:
                best, chosen = both, low
    if chosen is None:
        return [cloud]
    return split(cloud.select(chosen), plane, each) + split(cloud.select(~chosen), plane, each)


def _cuts(values: Floats, span: Floats) -> list[float | None]:
    """The middle of a wide gap, and None for the middle of the range."""
    width = float(span[1] - span[0])
    if width <= 0:
        return []
    ordered = np.sort(values if len(values) <= 20_000 else values[:: len(values) // 10_000])
    gaps = np.diff(ordered)
    at = int(np.argmax(gaps)) if len(gaps) else 0
    if len(gaps) and gaps[at] > 0.1 * width:
        return [float(ordered[at] + gaps[at] / 2), None]
    return [None]


def leaf_grid(
    box: Floats, count: int, nodes: tuple[int, int], plane: Plane, tolerance: float
) -> Grid:
    """Into how many sub-clusters along x, y and z the points are best sorted.

    nodes : (n_x, n_y) of the cluster
    Sub-clusters need few nodes each, and their basebands are carried to the cluster's nodes by
    two small matrix products.
    """
    return _best_leaves(box, count, nodes, plane, tolerance)[1]


def cost_of_sums(
    box: Floats,
    count: int,
    nodes: tuple[int, int],
    plane: Plane,
    tolerance: float,
    least: tuple[float, float] = (_LEAST, _LEAST),
) -> float:
    """Multiply-adds, about, of summing points to a cluster's nodes in the best way.

    least : nodes of a sub-cluster beside those that its bandwidth asks for
    """
    return _best_leaves(box, count, nodes, plane, tolerance, least)[0]


def cost_at(
    axes: tuple[Axis, Axis], box: Floats, count: int, plane: Plane, tolerance: float
) -> float:
    """The same at given nodes, with what sub-clusters' nodes take for margins and soft edges."""
    least = []
    for axis, (low, high), reach in zip(axes, box[:2].tolist(), plane.reach, strict=True):
        tapered = sum(len(run.weight) for run in axis.runs if run.tapered)
        width = SOFT_SHARE * float(box[2, 0]) * reach
        edges = tapered * width / (width + high - low) if tapered else 0.0
        least.append((2 - 2 * log10(tolerance)) * len(axis.runs) + edges)
    nodes = len(axes[0].nodes), len(axes[1].nodes)
    return cost_of_sums(box, count, nodes, plane, tolerance, (least[0], least[1]))


def _best_leaves(
    box: Floats,
    count: int,
    nodes: tuple[int, int],
    plane: Plane,
    tolerance: float,
    least: tuple[float, float] = (_LEAST, _LEAST),
) -> tuple[float, Grid]:
    grid = np.meshgrid(_LATERAL, _LATERAL, _DEEP, indexing="ij", sparse=True)
    leaves = grid[0] * grid[1] * grid[2]
    kappas, shares = _kappas(box, plane, grid)
    terms = _terms(box, plane, grid, tolerance)
    terms[0, 0, 0] = _terms(box, plane, (1, 1, 1), max(tolerance, _LEVELLED))
    nx, ny = (
        np.where(leaves > 1, np.minimum(_DENSE * kappa + more, most), most)
        for kappa, more, most in zip(kappas, least, nodes, strict=True)
    )
    to_x, to_y = shares[0] * nodes[0], shares[1] * nodes[1]
    carry = _CARRIED * to_y * nx * (ny + to_x) + _NODE * (to_x * to_y + terms * nx * ny) + _LEAF
    cost = _WAVE * terms * count * nx * ny + _ENTRY * count * (nx + ny)
    cost += np.where(leaves > 1, leaves * carry, 0.0)
    cost[leaves * _FEWEST > max(count, _FEWEST)] = np.inf
    best = np.unravel_index(np.argmin(cost), cost.shape)
    chosen = int(_LATERAL[best[0]]), int(_LATERAL[best[1]]), int(_DEEP[best[2]])
    return float(cost[best]), chosen


def _terms(box: Floats, plane: Plane, grid: Shares, tolerance: float) -> Floats:
    """Terms, about, of the series of one of a grid of sub-clusters.

    From how far the phase of what is not separable, k·(dx·dy)²/(4z³), changes over its points.
    """
    z = 2 / (1 / box[2, 0] + 1 / box[2, 1])
    far_x, far_y = farthest(box, plane)
    half_x, half_y = np.ptp(box[:2], axis=1) / 2
    swing = far_x * far_y * (far_y * half_x / grid[0] + far_x * half_y / grid[1]) / (2 * z**3)
    swing = swing + 3 / 8 * (far_x * far_y / z) ** 2 * (1 / box[2, 0] - 1 / box[2, 1]) / grid[2]
    digits = -log10(tolerance / 2)
    return np.asarray(1 + digits**2 * np.cbrt(2 * pi / plane.wavelength * swing))


def cells(positions: Floats, box: Floats, grid: Grid) -> NDArray[np.intp]:
    """(N,) the number of each point's box, of a grid of equal ones over x, y and z."""
    cell = np.zeros(len(positions), dtype=np.intp)
    for axis, n in enumerate(grid):
        low, high = box[axis]
        if n > 1 and high > low:
            # In depth by equal steps of 1/z, as curvatures go.
            place = positions[:, axis]
            if axis == 2:
                low, high, place = 1 / low, 1 / high, 1 / place
            u = (place - low) / (high - low)
            cell = cell * n + np.clip((u * n).astype(np.intp), 0, n - 1)
    return cell


def leaves(cloud: PointCloud, box: Floats, grid: Grid) -> list[PointCloud]:
    """The points sorted into the boxes of `cells`; empty ones left out."""
    cell = cells(cloud.positions, box, grid)
    order = np.argsort(cell, kind="stable")
    bounds = np.flatnonzero(np.diff(cell[order])) + 1
    return [cloud.select(part) for part in np.split(order, bounds)]


def coarse_pays(count: int, nodes: tuple[int, int], coarse: int, terms: int) -> bool:
    """Whether terms of so many points are better summed at `coarse` nodes in all and carried.

    nodes : (n_x, n_y) at which they would be summed otherwise
    """
    fine = nodes[0] * nodes[1]
    saved = 6 * count * terms * (fine - coarse)
    return saved > _CARRY + _ENTRY / 5 * count * 2 * coarse**0.5 + 8 * coarse**0.5 * fine
