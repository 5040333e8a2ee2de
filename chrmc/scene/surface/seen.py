"""Which points of a cast are seen: in front of everything, and turned to the hologram."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from chrmc.kept import KeptFrames
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.scene.surface.recorded import Recorded
from chrmc.scene.surface.surface import Surface
from chrmc.scene.surface.zbuffer import SLACK, ZBuffer

if TYPE_CHECKING:
    from chrmc.scene.surface.cast import Cast

PIXELS_PER_SPACING = 3.0
"""Pixels of the z-buffer between neighbouring points."""
MOST_PIXELS = 2048
"""Per side of the z-buffer."""
KEPT_FRAMES = 4
"""Frames whose visibility is remembered."""


def inclination(
    pose: Pose, positions: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N,) cosine between a surface's normal and the line to the middle of the hologram."""
    middle = -pose.translation @ pose.rotation
    along = normals @ middle - np.einsum("nx,nx->n", normals, positions)
    squared = (positions**2).sum(axis=1) - 2 * (positions @ middle) + middle @ middle
    return along / np.sqrt(squared)


def buffer_of(surfaces: Mapping[str, Surface]) -> tuple[ZBuffer, NDArray[np.intp]]:
    """A z-buffer for all faces, one body after the other, and (bodies + 1,) where each begins."""
    first_vertex = np.cumsum([0, *(len(s.vertices) for s in surfaces.values())])
    first_face = np.cumsum([0, *(len(s.faces) for s in surfaces.values())])
    faces = [s.faces + n for s, n in zip(surfaces.values(), first_vertex, strict=False)]
    return ZBuffer(np.concatenate(faces)), first_face


def corners_of(cast: "Cast", surfaces: Mapping[str, Surface], number: int) -> NDArray[np.float64]:
    """(V, 3) vertices of surfaces in the world, one body after the other."""
    return np.concatenate(
        [cast.pose(n, number).apply(s.in_frame(number - 1).vertices) for n, s in surfaces.items()]
    )


@dataclass(frozen=True, eq=False)
class Sampled:
    """Points of a body, and where on its surface they are; of a cloud only the points."""

    cloud: PointCloud
    surface: Surface | None = None
    face: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    weights: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    @cached_property
    def normals(self) -> NDArray[np.float64] | None:
        """(N, 3) of the rigid surface."""
        return None if self.surface is None else self.surface.face_normals[self.face]

    @property
    def rigid(self) -> bool:
        """Whether its points are the same, at the same places of the body, in all frames."""
        if self.surface is None:
            return not isinstance(self.cloud, Recorded)
        return self.surface.shape is None

    def in_frame(self, number: int) -> PointCloud:
        """The points in frame `number`, in body coordinates."""
        if isinstance(self.cloud, Recorded):
            return self.cloud.in_frame(number - 1)
        if self.surface is None or self.surface.shape is None:
            return self.cloud
        bent = self.surface.in_frame(number - 1)
        return replace(self.cloud, positions=bent.at(self.face, self.weights))

    def inclination(self, pose: Pose, number: int) -> NDArray[np.float64] | None:
        """(N,) cosines, or None for points that face nowhere."""
        if self.surface is None or self.normals is None:
            return None
        if self.surface.shape is None:
            cosine = inclination(pose, self.cloud.positions, self.normals)
        else:
            bent = self.surface.in_frame(number - 1)
            normals = bent.face_normals[self.face]
            cosine = inclination(pose, bent.at(self.face, self.weights), normals)
        return cosine if self.surface.closed else np.abs(cosine)


@dataclass(frozen=True, eq=False)
class View:
    """The window that the z-buffer shows, in (x/z, y/z, 1/z): flat faces stay flat there.

    low, high : (3,) its bounds
    shape : (H, W) pixels
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    shape: tuple[int, int]

    @classmethod
    def on(cls, world: NDArray[np.float64], pixel: float) -> "View":
        """The window that holds (V, 3) positions, its pixels on a grid that all frames share.

        What stands still is drawn alike in every frame then, and shows the same points.
        """
        seen = _perspective(world)
        low, high = seen.min(axis=0), seen.max(axis=0)
        margin = 1e-6 * np.abs(high - low) + np.array([1e-9, 1e-9, 1e-9 * abs(high[2])])
        low, high = low - margin, high + margin
        first = np.floor(low[:2] / pixel)
        # In steps, so that frames of nearly equal size share one picture on the GPU.
        count = 64 * np.ceil((high[:2] / pixel - first) / 64)
        low[:2], high[:2] = first * pixel, (first + count) * pixel
        width, height = (int(n) for n in count)
        return cls(low, high, (height, width))

    def place(self, world: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions as x, y and depth from −1 to 1; the nearest depth is −1."""
        place = 2 * (_perspective(world) - self.low) / (self.high - self.low) - 1
        place[:, 2] *= -1
        return place

    def in_front(self, world: NDArray[np.float64], depth: NDArray[np.float32]) -> NDArray[np.bool_]:
        """(N,) whether positions lie nowhere behind the drawn depths."""
        place = self.place(world)
        inside = (np.abs(place[:, :2]) < 1).all(axis=1)
        height, width = self.shape
        column, row = (
            np.clip(((place[:, k] + 1) / 2 * n).astype(np.intp), 0, n - 1)
            for k, n in ((0, width), (1, height))
        )
        return ~inside | (place[:, 2] <= depth[row, column] + SLACK)


def pixel_of(cast: "Cast", surfaces: Mapping[str, Surface]) -> float:
    """Side of the z-buffer's pixels in x/z: finer than the spacing where no frame is too large."""
    largest, farthest = 0.0, 1e-6  # what reaches behind the hologram is refused when it is seen
    hulls = {
        name: np.array([s.vertices.min(axis=0), s.vertices.max(axis=0)])
        for name, s in surfaces.items()
    }
    corners = {
        name: hull[np.indices((2, 2, 2)).reshape(3, -1).T, np.arange(3)]
        for name, hull in hulls.items()
    }
    for number in range(1, cast.frame_count + 1):
        world = np.concatenate([cast.pose(n, number).apply(c) for n, c in corners.items()])
        farthest = max(farthest, float(world[:, 2].max()))
        side = np.ptp(world[:, :2] / np.maximum(world[:, 2:], 1e-6), axis=0).max()
        largest = max(largest, float(side))
    return max(cast.spacing / PIXELS_PER_SPACING / farthest, largest / (MOST_PIXELS - 128))


def _perspective(world: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) positions as (x/z, y/z, 1/z)."""
    inverse = 1 / world[:, 2:]
    return np.hstack([world[:, :2] * inverse, inverse])


class Seen:
    """Visibility of all bodies' points, found once per frame for all of them."""

    def __init__(self, cast: "Cast", points: Mapping[str, Sampled]) -> None:
        self._cast, self._points = cast, points
        self._surfaces = cast.surfaces
        self._buffer = buffer_of(self._surfaces)[0] if self._surfaces else None
        rng = np.random.default_rng([cast.seed, 2])
        self._threshold = {name: rng.uniform(size=len(p.cloud)) for name, p in points.items()}
        self._pixel = pixel_of(cast, self._surfaces) if self._surfaces else 1.0
        self._masks = KeptFrames(self._find, KEPT_FRAMES)

    def mask(self, name: str, number: int) -> NDArray[np.bool_]:
        """(N,) which points of a body show in frame `number`."""
        found: NDArray[np.bool_] = self._masks(number)[name]
        return found

    def _find(self, number: int) -> dict[str, NDArray[np.bool_]]:
        poses = {name: self._cast.pose(name, number) for name in self._points}
        view, depth = None, np.zeros((1, 1), np.float32)
        if self._buffer is not None:
            corners = corners_of(self._cast, self._surfaces, number)
            if corners[:, 2].min() <= 0:
                raise ValueError(
                    f"frame {number}: a surface reaches to or behind the hologram (smallest z "
                    f"{corners[:, 2].min() * 1e3:.4g} mm): move it to z > 0"
                )
            view = View.on(corners, self._pixel)
            depth, _ = self._buffer.draw(view.place(corners), view.shape)
        return {name: self._seen(name, number, poses[name], view, depth) for name in self._points}

    def _seen(
        self,
        name: str,
        number: int,
        pose: Pose,
        view: View | None,
        depth: NDArray[np.float32],
    ) -> NDArray[np.bool_]:
        points = self._points[name]
        positions = points.in_frame(number).positions
        cosine = points.inclination(pose, number)
        if cosine is None:
            seen = np.ones(len(positions), dtype=bool)
        else:
            seen = cosine > self._threshold[name]
        asked = np.flatnonzero(seen)
        world = pose.apply(positions[asked])
        if view is not None:
            seen[asked] = view.in_front(world, depth)
        if self._cast.shown is not None:
            seen[asked] &= self._cast.shown(world)
        return seen
