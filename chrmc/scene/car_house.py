"""The built-in scenes: a car drives past a house.

An isotropic 1:20 model of the CH-RMC paper's scenario, so that a rotation stays a rotation: 80
frames at a scene pitch of 40.5 µm (5 pixels of 8.1 µm). The car rides three arcs of radii 15.68,
36.74 and 17.53 mm, 0.303° a frame, 20 + 30 + 29 steps, turning away from the hologram. `car-house`
starts with the heading −12° (towards the hologram), `car-house-deep` with −30°.
"""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from chrmc.scene import models
from chrmc.scene.path import arc_path, poses_along, rotation_y
from chrmc.scene.point_scene import PointScene
from chrmc.scene.points import PointCloud
from chrmc.scene.render import render
from chrmc.scene.rgbd import PLANES, DepthPlanes, RGBDFrame
from chrmc.scene.rgbd_scene import RGBDScene
from chrmc.scene.scene import Pose
from chrmc.scene.shapes import Solid, surface_raster
from chrmc.scene.visibility import visible_points
from chrmc.slm import WAVELENGTH

FRAMES = 80
SHAPE = (240, 320)
"""(H, W) of the RGB-D form."""
PITCH = 40.5e-6
"""Scene pixel, metres."""
STEP = np.radians(0.303)
"""Turn of the car from frame to frame, radians."""
ARCS = ((15.68e-3, 20), (36.74e-3, 30), (17.53e-3, 29))
"""(radius in metres, steps) of the three arcs."""
HEADINGS = {"car-house": np.radians(-12.0), "car-house-deep": np.radians(-30.0)}
"""Built-in scenes and the car's heading at frame 1."""
SEED = 20180917
"""Of the points' phases."""
# Coarser across nose and tail, which show themselves foreshortened.
CAR_SPACING = (44e-6, 44e-6, 60e-6)
HOUSE_TURN = np.radians(30.0)
# Stretched by the house's turn: seen from the hologram one point covers one scene pixel.
HOUSE_SPACING = (PITCH / np.cos(HOUSE_TURN), PITCH, PITCH / np.sin(HOUSE_TURN))


@dataclass(frozen=True, eq=False)
class Actor:
    """A solid with one pose per frame, or one for all.

    spacing : of its surface points, see `surface_raster`
    """

    solid: Solid
    poses: tuple[Pose, ...]
    spacing: tuple[float, float, float]
    seed: int = 0
    _masks: dict[int, NDArray[np.bool_]] = field(default_factory=dict)

    def pose(self, number: int) -> Pose:
        """Body to world in frame `number`."""
        return self.poses[0] if len(self.poses) == 1 else self.poses[number - 1]

    @cached_property
    def _raster(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        return surface_raster(self.solid, self.spacing)

    @cached_property
    def points(self) -> PointCloud:
        """All its surface points in body coordinates: amplitude √grey, random phases."""
        positions, triangle = self._raster
        grey = self.solid.paint(positions, triangle)
        phase = np.random.default_rng(self.seed).uniform(0, 2 * np.pi, len(positions))
        return PointCloud(positions, np.sqrt(grey), phase)

    def visible(self, number: int) -> NDArray[np.bool_]:
        """(N,) which of `points` the hologram sees in frame `number`; kept once computed."""
        key = 1 if len(self.poses) == 1 else number
        if key not in self._masks:
            pose = self.pose(number)
            positions, triangle = self._raster
            self._masks[key] = visible_points(
                pose.apply(positions),
                self.solid.normals[triangle] @ pose.rotation.T,
                pose.apply(self.solid.triangles.reshape(-1, 3)).reshape(-1, 3, 3),
            )
        return self._masks[key]


def actors(name: str) -> dict[str, Actor]:
    """The car and the house of a built-in scene."""
    positions, headings, _ = arc_path(HEADINGS[name], float(STEP), ARCS)
    positions[:, 0] -= (positions[:, 0].min() + positions[:, 0].max()) / 2
    positions[:, 1] += 252e-3 - positions[20, 1]
    still = Pose(rotation_y(float(HOUSE_TURN)), np.array([0.0, -0.9e-3, 264e-3]))
    return {
        "car": Actor(models.car(), poses_along(positions, headings, 1.2e-3), CAR_SPACING, SEED),
        "house": Actor(models.house(), (still,), HOUSE_SPACING, SEED + 1),
    }


def car_house(name: str = "car-house") -> PointScene:
    """`car-house` or `car-house-deep` as body-fixed points."""
    cast = actors(name)
    return PointScene(
        name=name,
        bodies={key: actor.points for key, actor in cast.items()},
        poses={key: actor.poses for key, actor in cast.items()},
        visible={key: actor.visible for key, actor in cast.items()},
        pixel_pitch=PITCH,
        wavelength=WAVELENGTH,
    )


def car_house_rgbd(name: str = "car-house", plane_spacing: float | None = None) -> RGBDScene:
    """`car-house` or `car-house-deep` as 320 × 240 images with 256 depth planes.

    plane_spacing : metres; other planes over the same range
    """
    cast = actors(name)
    planes = PLANES
    if plane_spacing is not None:
        count = ceil((PLANES.last - PLANES.first) / plane_spacing) + 1
        planes = DepthPlanes(PLANES.first, plane_spacing, count)

    def read(number: int) -> RGBDFrame:
        seen = [
            (identity, actor.solid, actor.pose(number))
            for identity, actor in enumerate(cast.values(), 1)
        ]
        return render(seen, SHAPE, PITCH, planes)

    return RGBDScene(
        name=name,
        read=read,
        frame_count=FRAMES,
        shape=SHAPE,
        pixel_pitch=PITCH,
        objects=dict(enumerate(cast, 1)),
        planes=planes,
        wavelength=WAVELENGTH,
        poses={key: actor.poses for key, actor in cast.items()},
        phase_seed=SEED,
    )
