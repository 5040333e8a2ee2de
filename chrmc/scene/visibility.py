"""What the hologram sees: exact hidden-point removal along +z, orthographic."""

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.shapes import Projection, triangle_normals

CLEARANCE = 1e-9
"""Metres by which a surface must stand in front of a point to hide it."""


def visible_points(
    positions: NDArray[np.float64],
    normals: NDArray[np.float64],
    triangles: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """(N,) whether a surface point shows itself to the hologram.

    positions, normals : (N, 3) in the world, on the surface, normals outward
    triangles : (T, 3, 3) closed meshes in the world, outward

    A point is visible when its surface faces the hologram and its ray towards −z meets no
    triangle. Only triangles that face the hologram are asked: whatever enters a closed mesh from
    the hologram's side enters through one of those.
    """
    seen = normals[:, 2] < -1e-9
    facing = triangle_normals(triangles)[:, 2] < 0
    asked = np.flatnonzero(seen)
    inside, depth = Projection(triangles[facing]).lines(positions[asked])
    hidden = (inside & (depth < positions[asked, 2, None] - CLEARANCE)).any(axis=1)
    seen[asked[hidden]] = False
    return seen


def first_hits(
    x: NDArray[np.float64], y: NDArray[np.float64], triangles: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Depth of the first surface on each line parallel to z, and its triangle.

    x, y : (N,) metres
    Returns (N,) z in metres, inf where nothing is met, and (N,) triangle indices.
    """
    facing = np.flatnonzero(triangle_normals(triangles)[:, 2] < 0)
    projection = Projection(triangles[facing])
    inside, depth = projection.lines(np.stack([x, y, np.zeros(len(x))], axis=1))
    if inside.shape[1] == 0:
        return np.full(len(x), np.inf), np.zeros(len(x), dtype=np.intp)
    depth = np.where(inside, depth, np.inf)
    nearest = depth.argmin(axis=1)
    return depth[np.arange(len(x)), nearest], facing[projection.index[nearest]]
