"""Solid bodies from closed triangle meshes, and a raster of points on their surfaces."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Paint = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""(N, 3) body positions and (N, 3) outward unit normals to (N,) greys in 0 … 1."""


@dataclass(frozen=True, eq=False)
class Part:
    """One closed mesh with its paint.

    triangles : (T, 3, 3) metres, corners in body coordinates, outward by the right-hand rule
    """

    triangles: NDArray[np.float64]
    paint: Paint


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid body made of parts that may touch or overlap."""

    parts: tuple[Part, ...]

    @cached_property
    def triangles(self) -> NDArray[np.float64]:
        """(T, 3, 3) of all parts, in order."""
        return np.concatenate([part.triangles for part in self.parts])

    @cached_property
    def part_index(self) -> NDArray[np.intp]:
        """(T,) the part that each triangle belongs to."""
        return np.repeat(np.arange(len(self.parts)), [len(p.triangles) for p in self.parts])

    @cached_property
    def normals(self) -> NDArray[np.float64]:
        """(T, 3) outward unit normals."""
        return triangle_normals(self.triangles)

    def paint(
        self, positions: NDArray[np.float64], triangle: NDArray[np.intp]
    ) -> NDArray[np.float64]:
        """(N,) grey of body positions that lie on the given triangles."""
        grey = np.zeros(len(positions))
        owner = self.part_index[triangle]
        for index, part in enumerate(self.parts):
            mine = owner == index
            if mine.any():
                grey[mine] = part.paint(positions[mine], self.normals[triangle[mine]])
        return grey


def plain(grey: float) -> Paint:
    """The same grey everywhere."""
    return lambda positions, normals: np.full(len(positions), grey)


def triangle_normals(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3) unit normals of (T, 3, 3) triangles."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def loft(rings: ArrayLike) -> NDArray[np.float64]:
    """Closed mesh over a stack of convex rings.

    rings : (L, K, 3) metres, L ≥ 2 rings of K corners each, corner k above corner k
    Returns (T, 3, 3), outward. Triangles of no area are left out.
    """
    ring = np.asarray(rings, dtype=np.float64)
    turned = np.roll(ring, -1, axis=1)
    a, b, c, d = ring[:-1], turned[:-1], turned[1:], ring[1:]
    sides = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    bottom = [(ring[0, 0], ring[0, k + 1], ring[0, k]) for k in range(1, ring.shape[1] - 1)]
    top = [(ring[-1, 0], ring[-1, k], ring[-1, k + 1]) for k in range(1, ring.shape[1] - 1)]
    mesh = np.concatenate([sides, np.array(bottom), np.array(top)])
    area = np.linalg.norm(np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]), axis=1)
    mesh = mesh[area > 1e-9 * area.max()]
    volume = np.einsum("ij,ij->", np.cross(mesh[:, 0], mesh[:, 1]), mesh[:, 2])
    return mesh if volume > 0 else mesh[:, ::-1]


def box(low: Sequence[float], high: Sequence[float]) -> NDArray[np.float64]:
    """Mesh of an axis-aligned box between two opposite corners (x, y, z), metres."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    plan = [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]
    return loft([[(x, y, z) for x, z in plan] for y in (y0, y1)])


class Projection:
    """Triangles seen along one axis, ready for many lines parallel to that axis.

    triangles : (T, 3, 3); axis : 0, 1 or 2
    Edge-on triangles meet no line. Barycentric coordinates and depth are affine in the two other
    coordinates, so all of them come from one matrix product each.
    """

    def __init__(self, triangles: NDArray[np.float64], axis: int = 2) -> None:
        u, v = (k for k in range(3) if k != axis)
        p, q, r = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        double = (q[:, u] - p[:, u]) * (r[:, v] - p[:, v]) - (r[:, u] - p[:, u]) * (
            q[:, v] - p[:, v]
        )
        extent = np.ptp(triangles[:, :, [u, v]], axis=1).max(axis=1) if len(triangles) else double
        self.index = np.flatnonzero(np.abs(double) > 1e-9 * extent**2)
        p, q, r, double = p[self.index], q[self.index], r[self.index], double[self.index]

        def weight(b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
            """Barycentric coordinate that is 0 on the line b–c: coefficients of u, v and 1."""
            return (
                np.stack(
                    [b[:, v] - c[:, v], c[:, u] - b[:, u], b[:, u] * c[:, v] - c[:, u] * b[:, v]]
                )
                / double
            )

        self._weights = (weight(q, r), weight(r, p), weight(p, q))
        self._depth = sum(
            w * corner[:, axis] for w, corner in zip(self._weights, (p, q, r), strict=True)
        )
        self._axes = (u, v)

    def lines(
        self, positions: NDArray[np.float64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """(N, T') which triangles each line through `positions` meets, and where on the axis."""
        u, v = self._axes
        line = np.stack([positions[:, u], positions[:, v], np.ones(len(positions))], axis=1)
        inside = np.ones((len(positions), len(self.index)), dtype=bool)
        for weight in self._weights:
            inside &= line @ weight >= -1e-12
        return inside, line @ self._depth


def surface_raster(
    solid: Solid, spacing: tuple[float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Body-fixed raster of points over all outer surfaces.

    Each surface is sampled along the axis that its normal is closest to, on rows whose points are
    staggered by the golden ratio: a column of points that appears all at once would make
    visibility jump, and a square lattice would diffract as a grating.

    spacing : metres between neighbouring samples along x, y and z
    Returns (N, 3) positions and (N,) triangle indices; points inside another part are left out.
    """
    golden = (np.sqrt(5) - 1) / 2
    low, high = solid.triangles.min(axis=(0, 1)), solid.triangles.max(axis=(0, 1))
    dominant = np.argmax(np.abs(solid.normals) + np.array([0, 1e-12, 2e-12]), axis=1)
    found_positions, found_triangles = [], []
    for axis, (u, v) in enumerate([(2, 1), (0, 2), (0, 1)]):
        mine = np.flatnonzero(dominant == axis)
        rows = np.arange(low[v] + spacing[v] / 2, high[v], spacing[v])
        columns = np.arange(low[u] - spacing[u], high[u] + spacing[u], spacing[u])
        offset = spacing[u] * ((np.arange(len(rows)) * golden) % 1)
        line = np.zeros((len(rows) * len(columns), 3))
        line[:, u] = (columns + offset[:, None]).ravel()
        line[:, v] = np.repeat(rows, len(columns))
        projection = Projection(solid.triangles[mine], axis)
        inside, place = projection.lines(line)
        ray, hit = np.nonzero(inside)
        points = line[ray]
        points[:, axis] = place[ray, hit]
        # A line through an edge meets both triangles at one place: keep one of them.
        order = np.lexsort((points[:, axis], ray))
        ray, points, hit = ray[order], points[order], hit[order]
        twin = np.zeros(len(ray), dtype=bool)
        twin[1:] = (np.diff(ray) == 0) & (np.diff(points[:, axis]) < 1e-9)
        found_positions.append(points[~twin])
        found_triangles.append(mine[projection.index[hit[~twin]]])
    positions = np.concatenate(found_positions)
    triangle = np.concatenate(found_triangles)
    keep = ~_inside_other_part(solid, positions, solid.part_index[triangle])
    return positions[keep], triangle[keep]


def _inside_other_part(
    solid: Solid, positions: NDArray[np.float64], owner: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """(N,) whether a point is buried: a ray from it crosses another part an odd number of times."""
    buried = np.zeros(len(positions), dtype=bool)
    for index, part in enumerate(solid.parts):
        inside, place = Projection(part.triangles).lines(positions)
        crossed = (inside & (place < positions[:, 2, None] - 1e-9)).sum(axis=1)
        buried |= (crossed % 2 == 1) & (owner != index)
    return buried
