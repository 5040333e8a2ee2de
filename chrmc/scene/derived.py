"""A scene made of another one: what it does not change is the other's."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field

from chrmc.scene.points import PointCloud
from chrmc.scene.scene import DepthStep, Pose, Scene, SceneFrame, described


@dataclass(frozen=True, eq=False, repr=False)
class DerivedScene:
    """All of another scene; a derived class says what it shows instead."""

    scene: Scene
    _bodies: dict[Hashable, tuple[PointCloud, PointCloud]] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        return described(self)

    @property
    def name(self) -> str:
        """The scene's."""
        return self.scene.name

    @property
    def form(self) -> str:
        """The scene's."""
        return self.scene.form

    @property
    def frame_count(self) -> int:
        """The scene's."""
        return self.scene.frame_count

    @property
    def object_names(self) -> Sequence[str]:
        """The scene's."""
        return self.scene.object_names

    @property
    def wavelength(self) -> float | None:
        """The scene's, metres."""
        return self.scene.wavelength

    @property
    def pixel_pitch(self) -> float:
        """The scene's, metres."""
        return self.scene.pixel_pitch

    @property
    def planes(self) -> DepthStep | None:
        """The scene's."""
        return self.scene.planes

    def pose(self, name: str, number: int) -> Pose | None:
        """The scene's."""
        return self.scene.pose(name, number)

    def frame(self, number: int) -> SceneFrame:
        """The scene's."""
        return self.scene.frame(number)

    def _same_body(
        self, key: Hashable, body: PointCloud, change: Callable[[PointCloud], PointCloud]
    ) -> PointCloud:
        """One and the same changed body in all frames, as methods that reuse its light expect."""
        known = self._bodies.get(key)
        if known is None or known[0] is not body:
            known = self._bodies[key] = (body, change(body))
        return known[1]
