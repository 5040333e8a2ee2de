"""Solids to intensity-and-depth frames: one ray per pixel centre."""

from collections.abc import Iterable

import numpy as np

from chrmc.scene.rgbd import DepthPlanes, RGBDFrame, pixel_centres
from chrmc.scene.scene import Pose
from chrmc.scene.shapes import Solid
from chrmc.scene.visibility import first_hits


def render(
    cast: Iterable[tuple[int, Solid, Pose]],
    shape: tuple[int, int],
    pixel_pitch: float,
    planes: DepthPlanes | None = None,
) -> RGBDFrame:
    """What the hologram sees of solids, orthographic along +z.

    cast : (object id, solid, body to world); shape : (H, W); planes : snap depths to them
    Parts outside the raster are cut off; ValueError outside the planes.
    """
    x, y = pixel_centres(shape, pixel_pitch)
    intensity = np.zeros(shape, np.float32)
    depth = np.full(shape, np.inf)
    object_id = np.zeros(shape, np.int32)
    for identity, solid, pose in cast:
        world = pose.apply(solid.triangles.reshape(-1, 3)).reshape(-1, 3, 3)
        low, high = world.min(axis=(0, 1)), world.max(axis=(0, 1))
        # Only the pixels of its bounding box can meet it.
        columns = slice(np.searchsorted(x, low[0]), np.searchsorted(x, high[0], side="right"))
        rows = slice(np.searchsorted(y, low[1]), np.searchsorted(y, high[1], side="right"))
        across, down = np.meshgrid(x[columns], y[rows])
        z, triangle = first_hits(across.ravel(), down.ravel(), world)
        nearer = np.flatnonzero(z < depth[rows, columns].ravel())
        hit = np.stack([across.ravel(), down.ravel(), z], axis=1)[nearer]
        body = (hit - pose.translation) @ pose.rotation
        grey = solid.paint(body, triangle[nearer])
        for target, values in ((intensity, grey), (depth, z[nearer]), (object_id, identity)):
            box = target[rows, columns]
            box[np.unravel_index(nearer, box.shape)] = values
    lit = np.isfinite(depth)
    depth[~lit] = 0
    if planes is not None:
        depth[lit] = planes.snap(depth[lit])
    return RGBDFrame(intensity, depth, object_id)
