"""Bodies with surfaces in front of the hologram, as body-fixed points or as pictures.

A point stands for an opaque diffuse surface: amplitude √(reflectance · shading · area per point),
random phase, both fixed to the body. It is seen when nothing lies before it on its line to the
middle of the hologram, and when the cosine of its surface's inclination to that line exceeds a
threshold of its own, drawn once: so a surface shows as many points per visible area from whatever
side, and is as bright as a diffuse one (Lambert's law).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from chrmc.kept import KeptFrames
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.rgbd import DepthPlanes, RGBDFrame
from chrmc.scene.rgbd_scene import RGBDScene, rasterised
from chrmc.scene.scene import (
    Pose,
    Scene,
)
from chrmc.scene.surface.bending import BendingScene
from chrmc.scene.surface.pictures import draw_picture
from chrmc.scene.surface.sampling import sample
from chrmc.scene.surface.seen import KEPT_FRAMES, Sampled, Seen, buffer_of, inclination
from chrmc.scene.surface.shading import Lamp, brightness
from chrmc.scene.surface.surface import Surface

SEED = 20180917
"""Of places, phases and thresholds, unless told otherwise."""
MOST_POSES = 128
"""Poses of which it is asked what faces the hologram; of more, as many and with a margin."""
MILLIMETRE = 1e-3


@dataclass(frozen=True, eq=False)
class Cast:
    """Named bodies and their motion.

    bodies : name to a `Surface`, or to a PointCloud that surfaces hide but that hides nothing; its
        points may be `Recorded`
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

    def points(self) -> Scene:
        """The scene as points: a `PointScene`, or a `BendingScene` where something is not rigid."""
        points = {
            name: self._sampled(name, body, self.seed + k)
            if isinstance(body, Surface)
            else Sampled(body)
            for k, (name, body) in enumerate(self.bodies.items())
        }
        clouds = {name: each.cloud for name, each in points.items()}
        visible = None
        if self.surfaces or self.shown is not None:
            seen = Seen(self, points)
            visible = {name: partial(seen.mask, name) for name in clouds}
            if not all(each.rigid for each in points.values()):
                return BendingScene(self, points, seen.mask)
        return PointScene(
            name=self.name,
            bodies=clouds,
            poses=self.poses,
            visible=visible,
            pixel_pitch=self.pixel_pitch,
            wavelength=self.wavelength,
            notes=self.notes,
        )

    def _sampled(self, name: str, surface: Surface, seed: int) -> Sampled:
        face, weights = sample(surface, self.spacing, seed, self._ever_facing(name, surface))
        rotation = self.pose(name, 1).rotation
        light, colour = brightness(surface, face, weights, self.lamp, rotation)
        phase = np.random.default_rng([seed, 1]).uniform(0, 2 * np.pi, len(face))
        amplitude = np.sqrt(light) * self.spacing / MILLIMETRE
        cloud = PointCloud(surface.at(face, weights), amplitude, phase, colour)
        lit = amplitude > 0
        return Sampled(cloud.select(lit), surface, face[lit], weights[lit])

    def _ever_facing(self, name: str, surface: Surface) -> NDArray[np.bool_] | None:
        """(F,) faces that turn to the hologram in some frame; None for all of an open surface."""
        if not surface.closed or surface.shape is not None:
            return None
        corner = surface.vertices[surface.faces[:, 0]]
        facing = np.zeros(len(surface.faces), dtype=bool)
        poses = self.poses[name]
        step = -(-len(poses) // MOST_POSES)
        for pose in poses[::step]:
            facing |= inclination(pose, corner, surface.face_normals) > (0 if step == 1 else -0.2)
            if facing.all():
                break
        return facing

    def pictures(self, shape: tuple[int, int], planes: DepthPlanes | None = None) -> RGBDScene:
        """The scene as intensity, depth and object pictures, seen along z."""
        surfaces = self.drawn
        if len(surfaces) < len(self.bodies):
            return rasterised(self.points(), shape, planes)
        buffer, owner = buffer_of(surfaces)

        def read(number: int) -> RGBDFrame:
            return draw_picture(self, number, shape, planes, buffer, owner)

        return RGBDScene(
            name=self.name,
            read=KeptFrames(read, KEPT_FRAMES),
            frame_count=self.frame_count,
            shape=shape,
            pixel_pitch=self.pixel_pitch,
            objects=dict(enumerate(surfaces, 1)),
            planes=planes,
            wavelength=self.wavelength,
            poses={name: tuple(self.poses[name]) for name in surfaces},
            phase_seed=self.seed,
        )
