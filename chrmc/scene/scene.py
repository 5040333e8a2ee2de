"""What stands in front of the SLM: named objects, a rigid pose per frame, visible points."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.ranges import short
from chrmc.scene.points import PointCloud, numbers

ORTHOGONAL = 1e-6
"""How far a pose's matrix may be from a rotation."""


@dataclass(frozen=True, eq=False, repr=False)
class Pose:
    """A rigid motion: world = rotation @ body + translation.

    rotation : (3, 3) proper orthogonal within 1e-6; lists are taken
    translation : (3,) metres, the body origin's place in the world

    Raises ValueError for a matrix that is no rotation (scaled, sheared, mirrored).
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def __post_init__(self) -> None:
        rotation = numbers("rotation", self.rotation, (3, 3))
        object.__setattr__(self, "rotation", rotation)
        object.__setattr__(self, "translation", numbers("translation", self.translation, (3,)))
        if np.abs(rotation).max() > 2:  # and might overflow below
            raise ValueError(f"rotation has an entry of {np.abs(rotation).max():.3g}: it is none")
        off = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
        if off > ORTHOGONAL:
            raise ValueError(
                f"rotation is no rotation: its columns are off length 1 and right angles by "
                f"{off:.3g} (at most {ORTHOGONAL:g}); scale the points, not the pose"
            )
        if np.linalg.det(rotation) < 0:
            raise ValueError("rotation mirrors (its determinant is −1): mirror the points instead")

    @classmethod
    def from_quaternion(
        cls, quaternion: ArrayLike, translation: ArrayLike = (0.0, 0.0, 0.0)
    ) -> "Pose":
        """From a quaternion in the order (x, y, z, w), the scalar last, as SciPy and glTF have it.

        Any length but 0 is taken and brought to 1.
        """
        x, y, z, w = (float(v) for v in numbers("quaternion", quaternion, (4,)))
        length = (x * x + y * y + z * z + w * w) ** 0.5
        if not length > 1e-12:
            raise ValueError("quaternion (0, 0, 0, 0) is no rotation; (0, 0, 0, 1) is none at all")
        turn = np.array([x, y, z]) / length
        return cls(_turned(turn, w / length), translation)  # type: ignore[arg-type]

    @classmethod
    def from_rotvec(cls, rotvec: ArrayLike, translation: ArrayLike = (0.0, 0.0, 0.0)) -> "Pose":
        """From a rotation vector: along the axis, as long as the right-handed angle in radians."""
        vector = numbers("rotvec", rotvec, (3,))
        angle = float(np.linalg.norm(vector))
        # sin(angle/2)/angle without the division by 0
        turn = vector * (0.5 * float(np.sinc(angle / (2 * np.pi))))
        return cls(_turned(turn, float(np.cos(angle / 2))), translation)  # type: ignore[arg-type]

    def __repr__(self) -> str:
        cosine = np.clip((np.trace(self.rotation) - 1) / 2, -1, 1)
        at = ", ".join(f"{v:.4g}" for v in 1e3 * self.translation)
        return f"Pose(turned {np.degrees(np.arccos(cosine)):.3g}°, at ({at}) mm)"

    def apply(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) body positions carried into the world."""
        # Column by column: so thin a matrix product takes ten times as long.
        x, y, z = positions.T
        out = np.empty((len(positions), 3))
        for i, (a, b, c) in enumerate(self.rotation.tolist()):
            column = a * x
            column += b * y
            column += c * z
            column += self.translation[i]
            out[:, i] = column
        return out

    def same_as(self, other: "Pose") -> bool:
        """Exactly the same motion."""
        return np.array_equal(self.rotation, other.rotation) and np.array_equal(
            self.translation, other.translation
        )


def _turned(turn: NDArray[np.float64], scalar: float) -> NDArray[np.float64]:
    """(3, 3) of a unit quaternion of vector part `turn`: v + 2·turn × (turn × v + scalar·v)."""
    x, y, z = turn
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2 * (cross @ cross + scalar * cross)


@dataclass(frozen=True, eq=False, repr=False)
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

    def __repr__(self) -> str:
        identity = "unknown identity" if self.body is None else f"of {len(self.body)}"
        return f"ObjectFrame({self.name!r}, {len(self.cloud)} points {identity})"

    @property
    def depth(self) -> float:
        """z of `position`: the depth at which the object is said to be, metres."""
        return float(self.position[2])


@dataclass(frozen=True, eq=False, repr=False)
class SceneFrame:
    """All objects of one frame; `number` counts from 1."""

    number: int
    objects: tuple[ObjectFrame, ...]

    @cached_property
    def cloud(self) -> PointCloud:
        """All visible points, object after object."""
        if len(self.objects) == 1:
            return self.objects[0].cloud
        return PointCloud.concatenate(o.cloud for o in self.objects)

    def __repr__(self) -> str:
        return f"SceneFrame({self.number}, {', '.join(map(repr, self.objects))})"


def described(scene: "Scene") -> str:
    """A scene in one short line, for its repr."""
    return (
        f"{type(scene).__name__}({scene.name!r}, {scene.frame_count} frames of "
        f"{', '.join(scene.object_names)})"
    )


class DepthStep(Protocol):
    """Planes that a scene's depths lie on, `step` metres apart."""

    @property
    def step(self) -> float: ...


class Scene(Protocol):
    """Anything that has these is a scene; write your own class with them.

    name : for manifests
    form : "points" (body-fixed, identity known) or "rgbd" (quantised, identity unknown)
    frame_count : frames are numbered 1 … frame_count
    object_names : in the order of SceneFrame.objects
    wavelength : metres, or None for whatever the user picks
    pixel_pitch : metres between neighbouring scene pixels (one is the lateral tolerance of checks)
    planes : the planes that depths lie on, with their `step` in metres, or None
    pose : where an object stands in a frame, or None where nobody knows; motion compensation asks
        it for the frames to come, without asking for their points
    frame : all objects of a frame; the same points in the same order whenever it is asked

    A class derived from this one has `form` ("points"), `wavelength`, `planes` and `pose` (None)
    already.
    """

    @property
    def name(self) -> str: ...
    @property
    def form(self) -> str:
        return "points"

    @property
    def frame_count(self) -> int: ...
    @property
    def object_names(self) -> Sequence[str]: ...
    @property
    def wavelength(self) -> float | None:
        return None

    @property
    def pixel_pitch(self) -> float: ...
    @property
    def planes(self) -> DepthStep | None:
        return None

    def pose(self, name: str, number: int) -> Pose | None:
        return None

    def frame(self, number: int) -> SceneFrame: ...


@dataclass(frozen=True, eq=False)
class _Completed:
    """A scene that was written without `planes` or `pose`: none, and what its frames say."""

    scene: Any
    planes: DepthStep | None = None

    def pose(self, name: str, number: int) -> Pose | None:
        return next((o.pose for o in self.scene.frame(number).objects if o.name == name), None)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scene, name)


def as_scene(scene: Any) -> Scene:
    """The scene, with `planes` and `pose` where it has none; ValueError for what is no scene."""
    needed = ("name", "form", "frame_count", "object_names", "wavelength", "pixel_pitch", "frame")
    missing = [attribute for attribute in needed if not hasattr(scene, attribute)]
    if missing:
        raise ValueError(
            f"{short(scene)} is no scene: it has no {', '.join(missing)}; see chrmc.Scene"
        )
    if hasattr(scene, "planes") and hasattr(scene, "pose"):
        whole: Scene = scene
        return whole
    completed: Any = _Completed(scene)
    return completed


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
