"""What a file of any kind becomes first: named bodies in the file's own axes and unit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud
from chrmc.scene.scene import Pose
from chrmc.scene.surface.recorded import Recorded
from chrmc.scene.surface.surface import Surface

UP = {
    "y": np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "-y": np.eye(3),
    "z": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "-z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "x": np.array([[0, -1.0, 0], [-1, 0, 0], [0, 0, -1]]),
    "-x": np.array([[0, 1.0, 0], [1, 0, 0], [0, 0, -1]]),
}
"""Axis that points up in a file to the rotation into this project's axes (y down, z away). Seen
from the front, the side that looks along +z where y is up, and along −y where z is up."""


MOST_FRAMES = 100_000
"""Of a motion that a file describes."""


@dataclass(frozen=True, eq=False)
class Model:
    """A file's content.

    bodies : name to surface or points, in the file's unit; several only where they move apart
    poses : body to file axes, one per frame of the file's own motion, or one
    up : key of `UP`
    rate, frames : of the own motion, frames per second and how many
    flat : a picture, which fills what the SLM shows, where a body takes half of it
    notes : what was done to the content, a sentence each
    """

    bodies: Mapping[str, Surface | PointCloud]
    poses: Mapping[str, Sequence[Pose]] = field(default_factory=dict)
    up: str = "y"
    rate: float | None = None
    frames: int = 1
    flat: bool = False
    notes: tuple[str, ...] = ()

    def pose(self, name: str, frame: int) -> Pose:
        """Of one body in frame 0, 1, …; the last one goes on."""
        poses = self.poses.get(name) or (Pose(np.eye(3), np.zeros(3)),)
        return poses[min(frame, len(poses) - 1)]

    def corners(self, frames: Sequence[int] = (0,)) -> NDArray[np.float64]:
        """(N, 3) all vertices or points, in the file's axes, over some frames; a recording's
        outliers are drawn in."""
        return np.concatenate(
            [
                self.pose(name, frame).apply(
                    body.core if isinstance(body, Recorded) else body_positions(body)
                )
                for name, body in self.bodies.items()
                for frame in frames
            ]
        )


def body_positions(body: Surface | PointCloud) -> NDArray[np.float64]:
    """(N, 3) the places that a body is made of."""
    return body.vertices if isinstance(body, Surface) else body.positions


def only_line(error: BaseException) -> str:
    """A library's message as part of a line."""
    return " ".join(str(error).split())[:160] or type(error).__name__
