"""Pictures of a cast along z: intensity, depth and object, the paper's own form."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.rgbd import DepthPlanes, RGBDFrame, pixel_centres
from chrmc.scene.surface.seen import corners_of
from chrmc.scene.surface.shading import brightness
from chrmc.scene.surface.zbuffer import ZBuffer

if TYPE_CHECKING:
    from chrmc.scene.surface.cast import Cast


def draw_picture(
    cast: "Cast",
    number: int,
    shape: tuple[int, int],
    planes: DepthPlanes | None,
    buffer: ZBuffer,
    owner: NDArray[np.intp],
) -> RGBDFrame:
    """One frame along z: faces from the z-buffer, places and greys computed anew in doubles."""
    surfaces = cast.drawn
    corners = corners_of(cast, surfaces, number)
    x, y = pixel_centres(shape, cast.pixel_pitch)
    half = np.array([shape[1], shape[0]]) * cast.pixel_pitch / 2
    near, far = corners[:, 2].min() - 1e-6, corners[:, 2].max() + 1e-6
    place = np.hstack([corners[:, :2] / half, 2 * (corners[:, 2:] - near) / (far - near) - 1])
    _, face = buffer.draw(place, shape)
    intensity, depth = np.zeros(shape, np.float32), np.zeros(shape)
    object_id = np.zeros(shape, np.int32)
    colours = None
    for k, (name, surface) in enumerate(surfaces.items()):
        rows, columns = np.nonzero((face >= owner[k]) & (face < owner[k + 1]))
        mine = (face[rows, columns] - owner[k]).astype(np.intp)
        vertices = surface.in_frame(number - 1).vertices
        world = cast.pose(name, number).apply(vertices)[surface.faces[mine]]
        weights = _weights(world, x[columns], y[rows])
        rotation = cast.pose(name, 1).rotation
        light, colour = brightness(surface, mine, weights, cast.lamp, rotation)
        intensity[rows, columns] = light
        if colour is not None:
            colours = np.ones((*shape, 3), np.float32) if colours is None else colours
            colours[rows, columns] = colour
        depth[rows, columns] = np.einsum("nk,nk->n", weights, world[:, :, 2])
        object_id[rows, columns] = k + 1
    lit = intensity > 0
    if planes is not None:
        depth[lit] = planes.snap(depth[lit])
    return RGBDFrame(intensity, np.where(lit, depth, 0), object_id, colours)


def _weights(
    corners: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 3) barycentric weights of lines along z through (N, 3, 3) triangles, kept inside."""
    a, b, c = (corners[:, k, :2] for k in range(3))
    at = np.stack([x, y], axis=1)

    def double(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    whole = double(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = double(at - a, c - a) / whole, double(b - a, at - a) / whole
    weights = np.nan_to_num(np.stack([1 - v - w, v, w], axis=1), nan=1 / 3, posinf=1, neginf=0)
    weights = np.clip(weights, 0, 1)
    return weights / weights.sum(axis=1, keepdims=True)
