"""A scene of intensity-and-depth frames: positions quantised, identity of points unknown."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.rgbd import (
    DepthPlanes,
    RGBDFrame,
    clouds_to_frame,
    frame_to_cloud,
    pixel_phases,
)
from chrmc.scene.scene import (
    ObjectFrame,
    Pose,
    Scene,
    SceneFrame,
    check_frame_number,
    described,
)

PHASE_SEED = 1
"""Of the pixels' random phases, unless a scene says otherwise."""


@dataclass(frozen=True, eq=False, repr=False)
class RGBDScene:
    """Frames that a function delivers, from memory or from a folder.

    name : for manifests
    read : frame number to RGBDFrame
    frame_count : frames are numbered 1 … frame_count
    shape : (H, W) of every frame
    pixel_pitch : metres
    objects : object id to name, in the order of SceneFrame.objects
    planes : the depth planes, or None for depths taken as they are
    wavelength : metres, or None for whatever the user picks
    poses : object name to one pose per frame or a single one, for objects whose motion is known
    phase_seed : of the pixels' random phases

    `scene.frame(n)` is the same whenever it is asked.
    """

    name: str
    read: Callable[[int], RGBDFrame]
    frame_count: int
    shape: tuple[int, int]
    pixel_pitch: float
    objects: Mapping[int, str]
    planes: DepthPlanes | None = None
    wavelength: float | None = None
    poses: Mapping[str, Sequence[Pose]] = field(default_factory=dict)
    phase_seed: int = PHASE_SEED
    form: str = "rgbd"

    def __repr__(self) -> str:
        return described(self)

    @property
    def object_names(self) -> tuple[str, ...]:
        """In the order of `objects`."""
        return tuple(self.objects.values())

    @cached_property
    def phases(self) -> NDArray[np.float64]:
        """(H, W) phases of the pixels, the same in every frame."""
        return pixel_phases(self.shape, self.phase_seed)

    def rgbd(self, number: int) -> RGBDFrame:
        """Frame `number` as images, from 1."""
        check_frame_number(number, self)
        return self.read(number)

    def frame(self, number: int) -> SceneFrame:
        """Frame `number` as points, from 1; objects without lit pixels have empty clouds."""
        images = self.rgbd(number)
        return SceneFrame(
            number,
            tuple(
                ObjectFrame(
                    name,
                    frame_to_cloud(images, self.pixel_pitch, self.phases, identity),
                    pose=self.pose(name, number),
                )
                for identity, name in self.objects.items()
            ),
        )

    def pose(self, name: str, number: int) -> Pose | None:
        """Body to world of one object in one frame; None where the motion is not known."""
        poses = self.poses.get(name)
        if not poses:
            return None
        return poses[0] if len(poses) == 1 else poses[number - 1]


def rasterised(
    scene: Scene, shape: tuple[int, int] = (240, 320), planes: DepthPlanes | None = None
) -> RGBDScene:
    """The RGB-D form of any scene: its visible points put into pixels, see `clouds_to_frame`.

    Points farther apart than a pixel leave dark pixels between them; the built-in scenes have an
    RGB-D form of their own, ray-cast from their solids.
    """

    def read(number: int) -> RGBDFrame:
        clouds = {k: part.cloud for k, part in enumerate(scene.frame(number).objects, 1)}
        return clouds_to_frame(clouds, shape, scene.pixel_pitch, planes)

    return RGBDScene(
        name=scene.name,
        read=read,
        frame_count=scene.frame_count,
        shape=shape,
        pixel_pitch=scene.pixel_pitch,
        objects=dict(enumerate(scene.object_names, 1)),
        planes=planes,
        wavelength=scene.wavelength,
    )
