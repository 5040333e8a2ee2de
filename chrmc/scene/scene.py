"""What stands in front of the SLM: named objects, a rigid pose per frame, visible points."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid motion: world = rotation @ body + translation.

    rotation : (3, 3) proper orthogonal
    translation : (3,) metres, the body origin's place in the world
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def apply(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) body positions carried into the world."""
        return positions @ self.rotation.T + self.translation

    def same_as(self, other: "Pose") -> bool:
        """Exactly the same motion."""
        return np.array_equal(self.rotation, other.rotation) and np.array_equal(
            self.translation, other.translation
        )


@dataclass(frozen=True, eq=False)
class ObjectFrame:
    """One object in one frame.

    name : of the object
    cloud : its visible points, in the world
    body : all its points in body coordinates, or None where identity is unknown (RGB-D)
    ids : (n,) index into `body` of each visible point, ascending; None with body None
    pose : body to world, or None where unknown
    """

    name: str
    cloud: PointCloud
    body: PointCloud | None = None
    ids: NDArray[np.intp] | None = None
    pose: Pose | None = None

    @cached_property
    def position(self) -> NDArray[np.float64]:
        """(3,) intensity-weighted mean of the visible points, metres; NaN when there are none."""
        return self.cloud.centroid

    @property
    def depth(self) -> float:
        """z of `position`: the depth at which the object is said to be, metres."""
        return float(self.position[2])


@dataclass(frozen=True, eq=False)
class SceneFrame:
    """All objects of one frame; `number` counts from 1."""

    number: int
    objects: tuple[ObjectFrame, ...]

    @cached_property
    def cloud(self) -> PointCloud:
        """All visible points, object after object."""
        return PointCloud.concatenate(o.cloud for o in self.objects)


class Scene(Protocol):
    """Anything that has these is a scene; write your own class with them.

    name : for manifests
    form : "points" (body-fixed, identity known) or "rgbd" (quantised, identity unknown)
    frame_count : frames are numbered 1 … frame_count
    object_names : in the order of SceneFrame.objects
    wavelength : metres, or None for whatever the user picks
    pixel_pitch : metres between neighbouring scene pixels (one is the lateral tolerance of checks)
    """

    @property
    def name(self) -> str: ...
    @property
    def form(self) -> str: ...
    @property
    def frame_count(self) -> int: ...
    @property
    def object_names(self) -> Sequence[str]: ...
    @property
    def wavelength(self) -> float | None: ...
    @property
    def pixel_pitch(self) -> float: ...
    def frame(self, number: int) -> SceneFrame: ...


def check_frame_number(number: int, scene: Scene) -> None:
    """ValueError unless 1 ≤ number ≤ frame_count."""
    if not 1 <= number <= scene.frame_count:
        raise ValueError(
            f"scene {scene.name} has frames 1 to {scene.frame_count}; there is no frame {number}"
        )


def frame_range(scene: Scene, frames: tuple[int, int] | None) -> range:
    """The inclusive pair (first, last), default all, as a range; ValueError outside the scene."""
    if frames is None:
        return range(1, scene.frame_count + 1)
    first, last = frames
    check_frame_number(first, scene)
    check_frame_number(last, scene)
    if last < first:
        raise ValueError(f"frames {first}:{last} run backwards; write {last}:{first}")
    return range(first, last + 1)
