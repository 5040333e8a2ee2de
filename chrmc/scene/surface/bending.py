"""A scene in which something is not rigid."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose, SceneFrame, check_frame_number, described
from chrmc.scene.surface.seen import Sampled

if TYPE_CHECKING:
    from chrmc.scene.surface.cast import Cast


@dataclass(frozen=True, eq=False, repr=False)
class BendingScene:
    """A scene with a surface that bends, whose points keep their place on it but are no rigid
    body, or with a recording, whose points are others in every frame.

    Names as in `chrmc.scene.scene.Scene`; objects that are rigid have a body and a pose.
    """

    cast: "Cast"
    points: Mapping[str, Sampled]
    mask: Callable[[str, int], NDArray[np.bool_]]
    form: str = "points"
    planes: None = None

    def __repr__(self) -> str:
        return described(self)

    @property
    def name(self) -> str:
        return self.cast.name

    @property
    def frame_count(self) -> int:
        return self.cast.frame_count

    @property
    def object_names(self) -> tuple[str, ...]:
        return tuple(self.points)

    @property
    def pixel_pitch(self) -> float:
        return self.cast.pixel_pitch

    @property
    def wavelength(self) -> float | None:
        return self.cast.wavelength

    @property
    def notes(self) -> tuple[str, ...]:
        return self.cast.notes

    def pose(self, name: str, number: int) -> Pose | None:
        """Body to world; None of what is not rigid."""
        return self.cast.pose(name, number) if self.points[name].rigid else None

    def frame(self, number: int) -> SceneFrame:
        """Frame `number`, from 1."""
        check_frame_number(number, self)
        return SceneFrame(number, tuple(self._object(name, number) for name in self.points))

    def _object(self, name: str, number: int) -> ObjectFrame:
        points = self.points[name]
        ids = np.flatnonzero(self.mask(name, number))
        shown = points.in_frame(number).select(ids)
        place = self.cast.pose(name, number).apply(shown.positions)
        cloud = PointCloud(place, shown.amplitude, shown.phase, shown.colour)
        pose = self.pose(name, number)
        if pose is None:
            return ObjectFrame(name, cloud)
        return ObjectFrame(name, cloud, points.cloud, ids, pose)
