"""A scene of body-fixed points: the built-in scenes are such, and so can yours be."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from chrmc.ranges import PITCH_RANGE, WAVELENGTH_RANGE
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose, SceneFrame, check_frame_number, described

Visibility = Sequence[NDArray[np.bool_]] | Callable[[int], NDArray[np.bool_]]
"""Per frame a mask over the body's points; or a function of the frame number that returns it."""


@dataclass(frozen=True, eq=False, repr=False)
class PointScene:
    """Rigid bodies of points, one pose per frame.

    name : for manifests
    bodies : object name to its points in body coordinates
    poses : object name to one pose per frame, or to a single one for an object that stands still
    visible : object name to its `Visibility`; objects without one show all points in all frames
    pixel_pitch : metres, lateral tolerance of checks
    wavelength : metres, or None for whatever the user picks
    notes : what was done to get here, for the user to read, a sentence each

    `scene.frame(n)` has the same points in the same order whenever it is asked.
    """

    name: str
    bodies: Mapping[str, PointCloud]
    poses: Mapping[str, Sequence[Pose]]
    visible: Mapping[str, Visibility] | None = None
    pixel_pitch: float = 40.5e-6
    wavelength: float | None = None
    form: str = "points"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.bodies:
            raise ValueError(f"scene {self.name} has no objects; give at least one body")
        if set(self.bodies) != set(self.poses):
            odd = sorted(set(self.bodies) ^ set(self.poses))
            raise ValueError(f"scene {self.name}: {odd} have a body or poses, but not both")
        object.__setattr__(self, "pixel_pitch", PITCH_RANGE.of(self.pixel_pitch))
        if self.wavelength is not None:
            object.__setattr__(self, "wavelength", WAVELENGTH_RANGE.of(self.wavelength))
        lengths = {name: len(poses) for name, poses in self.poses.items()}
        for name, length in lengths.items():
            if length not in (1, self.frame_count):
                raise ValueError(
                    f"scene {self.name}: {name} has {length} poses, but there are "
                    f"{self.frame_count} frames; give one pose per frame, or one for a still object"
                )
        for name, visible in (self.visible or {}).items():
            if name not in self.bodies:
                raise ValueError(f"scene {self.name}: visibility of unknown object {name!r}")
            if not callable(visible) and len(visible) not in (1, self.frame_count):
                raise ValueError(
                    f"scene {self.name}: {name} has {len(visible)} visibility masks for "
                    f"{self.frame_count} frames"
                )

    def __repr__(self) -> str:
        return described(self)

    @property
    def planes(self) -> None:
        """Depths are exact."""
        return None

    @property
    def frame_count(self) -> int:
        """Frames are numbered 1 … frame_count."""
        return max(len(poses) for poses in self.poses.values())

    @property
    def object_names(self) -> tuple[str, ...]:
        """In the order of `bodies`."""
        return tuple(self.bodies)

    def pose(self, name: str, number: int) -> Pose:
        """Body to world of one object in one frame."""
        poses = self.poses[name]
        return poses[0] if len(poses) == 1 else poses[number - 1]

    def frame(self, number: int) -> SceneFrame:
        """Frame `number`, from 1."""
        check_frame_number(number, self)
        return SceneFrame(number, tuple(self._object(name, number) for name in self.bodies))

    def _object(self, name: str, number: int) -> ObjectFrame:
        body = self.bodies[name]
        pose = self.pose(name, number)
        visible = (self.visible or {}).get(name)
        if visible is None:
            ids = np.arange(len(body))
        else:
            if callable(visible):
                mask = visible(number)
            else:
                mask = visible[0] if len(visible) == 1 else visible[number - 1]
            mask = np.asarray(mask)
            if mask.dtype != bool or mask.shape != (len(body),):
                raise ValueError(
                    f"scene {self.name}, frame {number}: visibility of {name} must be a bool mask "
                    f"over its {len(body)} points, not {mask.dtype} {mask.shape}"
                )
            ids = np.flatnonzero(mask)
        shown = body.select(ids)
        cloud = replace(shown, positions=pose.apply(shown.positions))
        return ObjectFrame(name, cloud, body, ids, pose)
