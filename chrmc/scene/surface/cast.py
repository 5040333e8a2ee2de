"""Bodies with surfaces in front of the hologram, as body-fixed points or as pictures.

A point stands for an opaque diffuse surface: amplitude √(reflectance · shading · area per point),
random phase, both fixed to the body. It is seen when nothing lies before it on its line to the
middle of the hologram, and when the cosine of its surface's inclination to that line exceeds a
threshold of its own, drawn once: so a surface shows as many points per visible area from whatever
side, and is as bright as a diffuse one (Lambert's law).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.rgbd import DepthPlanes, RGBDFrame, pixel_centres
from chrmc.scene.rgbd_scene import RGBDScene, rasterised
from chrmc.scene.scene import Pose
from chrmc.scene.surface.sampling import sample
from chrmc.scene.surface.shading import Lamp, brightness
from chrmc.scene.surface.surface import Surface
from chrmc.scene.surface.zbuffer import SLACK, ZBuffer

SEED = 20180917
"""Of places, phases and thresholds, unless told otherwise."""
PIXELS_PER_SPACING = 3.0
"""Pixels of the z-buffer between neighbouring points."""
MOST_PIXELS = 2048
"""Per side of the z-buffer."""
KEPT_FRAMES = 4
"""Frames whose visibility is remembered."""
MILLIMETRE = 1e-3


@dataclass(frozen=True, eq=False)
class Cast:
    """Named bodies and their motion.

    bodies : name to a `Surface`, or to a PointCloud that surfaces hide but that hides nothing
    poses : name to one pose per frame, or a single one
    spacing : metres between points of the surfaces, √(area per point)
    lamp : None for unlit surfaces; its light is fixed to each body as in frame 1
    shown : (N, 3) world positions to which of them the SLM can show at all; None for all
    notes : what was done to get here, for `PointScene.notes`
    """

    name: str
    bodies: Mapping[str, Surface | PointCloud]
    poses: Mapping[str, Sequence[Pose]]
    spacing: float
    lamp: Lamp | None = None
    shown: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None
    seed: int = SEED
    pixel_pitch: float = 40.5e-6
    wavelength: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def frame_count(self) -> int:
        """Frames are numbered 1 … frame_count."""
        return max(len(poses) for poses in self.poses.values())

    def pose(self, name: str, number: int) -> Pose:
        """Body to world of one body in one frame."""
        poses = self.poses[name]
        return poses[0] if len(poses) == 1 else poses[number - 1]

    @property
    def surfaces(self) -> dict[str, Surface]:
        """The bodies that hide something."""
        return {n: b for n, b in self.bodies.items() if isinstance(b, Surface) and b.opaque}

    @property
    def drawn(self) -> dict[str, Surface]:
        """The bodies that a picture shows."""
        return {name: b for name, b in self.bodies.items() if isinstance(b, Surface)}

    def points(self) -> PointScene:
        """The scene as points; ValueError where none is left to show."""
        clouds: dict[str, PointCloud] = {}
        normals: dict[str, NDArray[np.float64] | None] = {}
        for k, (name, body) in enumerate(self.bodies.items()):
            if isinstance(body, Surface):
                clouds[name], normals[name] = self._sampled(name, body, self.seed + k)
            else:
                clouds[name], normals[name] = body, None
        visible = None
        if self.surfaces or self.shown is not None:
            seen = _Seen(self, clouds, normals)
            visible = {name: partial(seen.mask, name) for name in clouds}
        return PointScene(
            name=self.name,
            bodies=clouds,
            poses=self.poses,
            visible=visible,
            pixel_pitch=self.pixel_pitch,
            wavelength=self.wavelength,
            notes=self.notes,
        )

    def _sampled(
        self, name: str, surface: Surface, seed: int
    ) -> tuple[PointCloud, NDArray[np.float64]]:
        face, weights = sample(surface, self.spacing, seed, self._ever_facing(name, surface))
        light = brightness(surface, face, weights, self.lamp, self.pose(name, 1).rotation)
        phase = np.random.default_rng([seed, 1]).uniform(0, 2 * np.pi, len(face))
        amplitude = np.sqrt(light) * self.spacing / MILLIMETRE
        cloud = PointCloud(surface.at(face, weights), amplitude, phase)
        lit = amplitude > 0
        return cloud.select(lit), surface.face_normals[face[lit]]

    def _ever_facing(self, name: str, surface: Surface) -> NDArray[np.bool_] | None:
        """(F,) faces that turn to the hologram in some frame; None for all of an open surface."""
        if not surface.closed:
            return None
        corner = surface.vertices[surface.faces[:, 0]]
        facing = np.zeros(len(surface.faces), dtype=bool)
        for pose in self.poses[name]:
            facing |= _inclination(pose, corner, surface.face_normals) > 0
        return facing

    def pictures(self, shape: tuple[int, int], planes: DepthPlanes | None = None) -> RGBDScene:
        """The scene as intensity, depth and object pictures, seen along z."""
        surfaces = self.drawn
        if not surfaces:
            return rasterised(self.points(), shape, planes)
        buffer, owner = _buffer(surfaces)

        @lru_cache(maxsize=KEPT_FRAMES)
        def read(number: int) -> RGBDFrame:
            return _picture(self, number, shape, planes, buffer, owner)

        return RGBDScene(
            name=self.name,
            read=read,
            frame_count=self.frame_count,
            shape=shape,
            pixel_pitch=self.pixel_pitch,
            objects=dict(enumerate(surfaces, 1)),
            planes=planes,
            wavelength=self.wavelength,
            poses={name: tuple(self.poses[name]) for name in surfaces},
            phase_seed=self.seed,
        )


def _inclination(
    pose: Pose, positions: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N,) cosine between a surface's normal and the line to the middle of the hologram."""
    middle = -pose.translation @ pose.rotation
    along = normals @ middle - np.einsum("nx,nx->n", normals, positions)
    squared = (positions**2).sum(axis=1) - 2 * (positions @ middle) + middle @ middle
    return along / np.sqrt(squared)


def _buffer(surfaces: Mapping[str, Surface]) -> tuple[ZBuffer, NDArray[np.intp]]:
    """A z-buffer for all faces, one body after the other, and (bodies + 1,) where each begins."""
    first_vertex = np.cumsum([0, *(len(s.vertices) for s in surfaces.values())])
    first_face = np.cumsum([0, *(len(s.faces) for s in surfaces.values())])
    faces = [s.faces + n for s, n in zip(surfaces.values(), first_vertex, strict=False)]
    return ZBuffer(np.concatenate(faces)), first_face


class _Seen:
    """Visibility of all bodies' points, found once per frame for all of them."""

    def __init__(
        self,
        cast: Cast,
        clouds: Mapping[str, PointCloud],
        normals: Mapping[str, NDArray[np.float64] | None],
    ) -> None:
        self._cast, self._clouds, self._normals = cast, clouds, normals
        self._surfaces = cast.surfaces
        self._closed = {n: b.closed for n, b in cast.bodies.items() if isinstance(b, Surface)}
        self._buffer = _buffer(self._surfaces)[0] if self._surfaces else None
        rng = np.random.default_rng([cast.seed, 2])
        self._threshold = {name: rng.uniform(size=len(c)) for name, c in clouds.items()}
        self._pixel = _pixel(cast, self._surfaces) if self._surfaces else 1.0
        self._masks = lru_cache(maxsize=KEPT_FRAMES)(self._find)

    def mask(self, name: str, number: int) -> NDArray[np.bool_]:
        """(N,) which points of a body show in frame `number`."""
        return self._masks(number)[name]

    def _find(self, number: int) -> dict[str, NDArray[np.bool_]]:
        poses = {name: self._cast.pose(name, number) for name in self._clouds}
        view, depth = None, np.zeros((1, 1), np.float32)
        if self._buffer is not None:
            corners = np.concatenate(
                [poses[name].apply(s.vertices) for name, s in self._surfaces.items()]
            )
            if corners[:, 2].min() <= 0:
                raise ValueError(
                    f"frame {number}: a surface reaches to or behind the hologram (smallest z "
                    f"{corners[:, 2].min() * 1e3:.4g} mm): move it to z > 0"
                )
            view = _View.on(corners, self._pixel)
            depth, _ = self._buffer.draw(view.place(corners), view.shape)
        return {name: self._seen(name, poses[name], view, depth) for name in self._clouds}

    def _seen(
        self, name: str, pose: Pose, view: "_View | None", depth: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        body, normals = self._clouds[name].positions, self._normals[name]
        if normals is None:
            seen = np.ones(len(body), dtype=bool)
        else:
            cosine = _inclination(pose, body, normals)
            if not self._closed[name]:
                cosine = np.abs(cosine)
            seen = cosine > self._threshold[name]
        asked = np.flatnonzero(seen)
        world = pose.apply(body[asked])
        if view is not None:
            seen[asked] = view.in_front(world, depth)
        if self._cast.shown is not None:
            seen[asked] &= self._cast.shown(world)
        return seen


@dataclass(frozen=True, eq=False)
class _View:
    """The window that the z-buffer shows, in (x/z, y/z, 1/z): flat faces stay flat there.

    low, high : (3,) its bounds
    shape : (H, W) pixels
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    shape: tuple[int, int]

    @classmethod
    def on(cls, world: NDArray[np.float64], pixel: float) -> "_View":
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


def _pixel(cast: Cast, surfaces: Mapping[str, Surface]) -> float:
    """Side of the z-buffer's pixels in x/z: finer than the spacing where no frame is too large."""
    largest = farthest = 0.0
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


def _picture(
    cast: Cast,
    number: int,
    shape: tuple[int, int],
    planes: DepthPlanes | None,
    buffer: ZBuffer,
    owner: NDArray[np.intp],
) -> RGBDFrame:
    """One frame along z: faces from the z-buffer, places and greys computed anew in doubles."""
    surfaces = cast.drawn
    corners = np.concatenate(
        [cast.pose(name, number).apply(s.vertices) for name, s in surfaces.items()]
    )
    x, y = pixel_centres(shape, cast.pixel_pitch)
    half = np.array([shape[1], shape[0]]) * cast.pixel_pitch / 2
    near, far = corners[:, 2].min() - 1e-6, corners[:, 2].max() + 1e-6
    place = np.hstack([corners[:, :2] / half, 2 * (corners[:, 2:] - near) / (far - near) - 1])
    _, face = buffer.draw(place, shape)
    intensity, depth = np.zeros(shape, np.float32), np.zeros(shape)
    object_id = np.zeros(shape, np.int32)
    for k, (name, surface) in enumerate(surfaces.items()):
        rows, columns = np.nonzero((face >= owner[k]) & (face < owner[k + 1]))
        mine = (face[rows, columns] - owner[k]).astype(np.intp)
        world = cast.pose(name, number).apply(surface.vertices)[surface.faces[mine]]
        weights = _weights(world, x[columns], y[rows])
        rotation = cast.pose(name, 1).rotation
        light = brightness(surface, mine, weights, cast.lamp, rotation)
        intensity[rows, columns] = light
        depth[rows, columns] = np.einsum("nk,nk->n", weights, world[:, :, 2])
        object_id[rows, columns] = k + 1
    lit = intensity > 0
    if planes is not None:
        depth[lit] = planes.snap(depth[lit])
    return RGBDFrame(intensity, np.where(lit, depth, 0), object_id)


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
