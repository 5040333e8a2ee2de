"""Which point of one RGB-D frame is which point of the next, where ids and poses tell it.

A pixel knows its object, and the object's pose carries every point seen so far to where it is now.
A lit pixel that such a point falls into or beside, at its depth and brightness, is that point seen
again; any other lit pixel is a new point of the body. So a folder of pictures becomes body-fixed
points, exact from their first sight on, and motion compensation has something to compensate.
"""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from chrmc.progress import progress
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.rgbd import frame_to_cloud
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene import Pose

BRIGHTNESS = 0.05
"""Share of a pixel's amplitude by which a point seen again may differ."""


@dataclass
class _Body:
    """An object's points so far, in body coordinates, and which of them each frame shows.

    shown : a mask for each frame, over the points that were known by then, see `_packed`
    """

    positions: list[NDArray[np.float64]] = field(default_factory=list)
    amplitude: list[NDArray[np.float64]] = field(default_factory=list)
    colour: list[NDArray[np.float64]] = field(default_factory=list)
    shown: list[bytes] = field(default_factory=list)

    def cloud(self, phases: np.random.Generator) -> PointCloud:
        if not self.positions:
            return PointCloud.concatenate([])
        positions = np.concatenate(self.positions)
        phase = phases.uniform(0, 2 * np.pi, len(positions))
        colour = np.concatenate(self.colour)
        white = not np.ptp(colour, axis=1).any()
        return PointCloud(
            positions, np.concatenate(self.amplitude), phase, None if white else colour
        )

    def see(self, cloud: PointCloud, pose: Pose, pitch: float, depth: float) -> None:
        """Book a frame: its points known again, the others added."""
        known = np.concatenate(self.positions) if self.positions else np.zeros((0, 3))
        bright = np.concatenate(self.amplitude) if self.amplitude else np.zeros(0)
        pixel, point = _seen_again(pose.apply(known), bright, cloud, pitch, depth)
        fresh = np.ones(len(cloud), dtype=bool)
        fresh[pixel] = False
        added = (cloud.positions[fresh] - pose.translation) @ pose.rotation
        self.positions.append(added)
        self.amplitude.append(cloud.amplitude[fresh])
        colour = np.ones((len(cloud), 3)) if cloud.colour is None else cloud.colour
        self.colour.append(colour[fresh])
        mask = np.zeros(len(known) + len(added), dtype=bool)
        mask[point] = mask[len(known) :] = True
        self.shown.append(_packed(mask))


def _seen_again(
    places: NDArray[np.float64],
    bright: NDArray[np.float64],
    cloud: PointCloud,
    pitch: float,
    depth: float,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices into the frame's pixels and into the known points that are one and the same.

    places : (M, 3) known points, carried into the frame; cloud : its lit pixels
    pitch, depth : metres that they may differ, across and along z: each place is wrong by half a
        pixel, so two sights of one point may lie a whole one apart
    """
    points: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    pixels: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    if not len(places) or not len(cloud):
        return pixels[0], points[0]
    corner = cloud.positions[:, :2].min(axis=0)
    cells = np.rint((cloud.positions[:, :2] - corner) / pitch).astype(np.int64)
    size = cells.max(axis=0) + 1
    table = np.full((int(size[0]), int(size[1])), -1, dtype=np.intp)
    table[cells[:, 0], cells[:, 1]] = np.arange(len(cloud))
    here = np.rint((places[:, :2] - corner) / pitch)
    for step in product((0, -1, 1), repeat=2):
        at = here + step
        inside = np.flatnonzero(np.all((at >= 0) & (at < size), axis=1))
        cell = at[inside].astype(np.int64)
        pixel = table[cell[:, 0], cell[:, 1]]
        points.append(inside[pixel >= 0])
        pixels.append(pixel[pixel >= 0])
    point, pixel = np.concatenate(points), np.concatenate(pixels)
    apart = np.abs(places[point] - cloud.positions[pixel]) / (pitch, pitch, depth)
    light = cloud.amplitude[pixel]
    alike = (apart.max(axis=1) <= 1) & (np.abs(bright[point] - light) <= BRIGHTNESS * light)
    return _nearest_first(pixel[alike], point[alike], np.sum(apart[alike] ** 2, axis=1))


def _nearest_first(
    pixel: NDArray[np.intp], point: NDArray[np.intp], cost: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs in which each pixel and each point is once, those of least cost before others."""
    order = np.lexsort((point, pixel, cost))
    pixel, point = pixel[order], point[order]
    taken: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
    while len(pixel):
        # The best pair of its pixel and of its point: nothing better can take either.
        best = np.zeros(len(pixel), dtype=bool)
        best[np.unique(pixel, return_index=True)[1]] = True
        also = np.zeros(len(pixel), dtype=bool)
        also[np.unique(point, return_index=True)[1]] = True
        best &= also
        taken.append((pixel[best], point[best]))
        left = ~(np.isin(pixel, pixel[best]) | np.isin(point, point[best]))
        pixel, point = pixel[left], point[left]
    return (
        np.concatenate([pixel, *(pair[0] for pair in taken)]),
        np.concatenate([point, *(pair[1] for pair in taken)]),
    )


def tracked(scene: RGBDScene) -> PointScene | None:
    """The scene as body-fixed points; None where an object's pose is not known in every frame.

    Positions are those of a point's first sight, carried on by the poses: within a pixel and a
    depth plane (a pixel where there are no planes) of the pictures.
    """
    if not scene.objects or any(not scene.poses.get(name) for name in scene.object_names):
        return None
    depth = scene.pixel_pitch if scene.planes is None else scene.planes.step
    bodies = {name: _Body() for name in scene.object_names}
    for number in progress(range(1, scene.frame_count + 1), "points", unit="frame"):
        images = scene.rgbd(number)
        for identity, name in scene.objects.items():
            cloud = frame_to_cloud(images, scene.pixel_pitch, None, identity)
            poses = scene.poses[name]
            pose = poses[0] if len(poses) == 1 else poses[number - 1]
            bodies[name].see(cloud, pose, 1.001 * scene.pixel_pitch, 1.001 * depth)
    clouds = {
        name: body.cloud(np.random.default_rng([scene.phase_seed, k]))
        for k, (name, body) in enumerate(bodies.items())
    }

    return PointScene(
        name=scene.name,
        bodies=clouds,
        poses={name: _per_frame(scene.poses[name], scene.frame_count) for name in clouds},
        visible={name: _masks(bodies[name].shown, len(cloud)) for name, cloud in clouds.items()},
        pixel_pitch=scene.pixel_pitch,
        wavelength=scene.wavelength,
        notes=("points are followed from frame to frame by the ids and poses of the folder",),
    )


def _packed(mask: NDArray[np.bool_]) -> bytes:
    """A mask in about a bit a point, or less: neighbours on a body are often seen together."""
    return zlib.compress(np.packbits(mask).tobytes(), 1)


def _masks(shown: Sequence[bytes], count: int) -> Callable[[int], NDArray[np.bool_]]:
    """Which of `count` points a frame shows, as `PointScene` asks for it."""

    def mask(number: int) -> NDArray[np.bool_]:
        flags = np.zeros(count, dtype=np.uint8)
        bits = np.frombuffer(zlib.decompress(shown[number - 1]), dtype=np.uint8)
        known = np.unpackbits(bits, count=min(count, 8 * len(bits)))
        flags[: len(known)] = known
        return flags.view(bool)

    return mask


def _per_frame(poses: Sequence[Pose], count: int) -> list[Pose]:
    """One pose per frame: a scene of still objects has as many frames as its folder, too."""
    return list(poses) if len(poses) == count else list(poses) * count
