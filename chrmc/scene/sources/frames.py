"""A scene whose points have no identity: a cloud per object and frame, as a camera sees it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from chrmc.scene.points import PointCloud
from chrmc.scene.scene import ObjectFrame, Pose, SceneFrame, check_frame_number


@dataclass(frozen=True, eq=False)
class CloudScene:
    """Frames that a function delivers.

    read : frame number to a cloud per object, the same whenever it is asked
    Other names as in `chrmc.scene.scene.Scene`.
    """

    name: str
    read: Callable[[int], Mapping[str, PointCloud]]
    frame_count: int
    object_names: tuple[str, ...]
    pixel_pitch: float = 40.5e-6
    wavelength: float | None = None
    notes: tuple[str, ...] = ()
    form: str = "rgbd"
    planes: None = None

    def __repr__(self) -> str:
        return f"CloudScene({self.name!r}, {self.frame_count} frames)"

    def pose(self, name: str, number: int) -> Pose | None:
        """Nobody knows."""
        return None

    def frame(self, number: int) -> SceneFrame:
        """Frame `number`, from 1."""
        check_frame_number(number, self)
        clouds = self.read(number)
        return SceneFrame(
            number, tuple(ObjectFrame(name, clouds[name]) for name in self.object_names)
        )
