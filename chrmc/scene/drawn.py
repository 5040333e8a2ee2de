"""A scene shown several times over, each time with other phases, for panels that are fast enough.

Light of a diffuse surface is speckle; the eye averages the draws that follow one another while it
takes one picture.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from chrmc.ranges import Count
from chrmc.scene.derived import DerivedScene
from chrmc.scene.scene import ObjectFrame, Pose, Scene, SceneFrame

LOOKS = Count("looks", 1, 1000)
SEED = 20180102
"""Of the phases; with look, object and, where points are not known again, frame, it fixes all."""


@dataclass(frozen=True, eq=False, repr=False)
class DrawnScene(DerivedScene):
    """Every frame of a scene `looks` times, one after the other; a scene in its own right.

    The first look has the scene's own phases. In each other one every point has another, the same
    in all frames: it stays fixed to the body.
    """

    looks: int
    _last: dict[int, SceneFrame] = field(default_factory=dict, init=False)

    @property
    def frame_count(self) -> int:
        """Looks of all frames."""
        return self.looks * self.scene.frame_count

    def pose(self, name: str, number: int) -> Pose | None:
        """The scene's."""
        return self.scene.pose(name, self._shown(number)[0])

    def frame(self, number: int) -> SceneFrame:
        """Look (number − 1) modulo `looks` of a frame of the scene."""
        first, look = self._shown(number)
        shown = self._last.get(first)
        if shown is None:
            shown = self.scene.frame(first)
            self._last.clear()
            self._last[first] = shown
        if look == 0:
            return SceneFrame(number, shown.objects)
        return SceneFrame(number, tuple(self._object(o, first, look) for o in shown.objects))

    def _shown(self, number: int) -> tuple[int, int]:
        """The scene's frame, and the look."""
        return (number - 1) // self.looks + 1, (number - 1) % self.looks

    def _object(self, obj: ObjectFrame, number: int, look: int) -> ObjectFrame:
        place = list(self.scene.object_names).index(obj.name)
        if obj.body is None or obj.ids is None:
            phase = _phases(len(obj.cloud), look, place, number)
            return replace(obj, cloud=replace(obj.cloud, phase=phase))
        body = self._same_body(
            (obj.name, look),
            obj.body,
            lambda body: replace(body, phase=_phases(len(body), look, place)),
        )
        cloud = replace(obj.cloud, phase=body.phase[obj.ids])
        return replace(obj, cloud=cloud, body=body)


def _phases(count: int, *seeds: int) -> NDArray[np.float64]:
    return np.random.default_rng([SEED, *seeds]).uniform(0, 2 * np.pi, count)


def drawn(scene: Scene, looks: int) -> Scene:
    """The scene, with so many draws of its phases in each frame."""
    return scene if LOOKS.of(looks) == 1 else DrawnScene(scene, looks)


def drawn_frames(frames: tuple[int, int] | None, looks: int) -> tuple[int, int] | None:
    """The frames that all looks of some of the scene's frames are."""
    return None if frames is None else ((frames[0] - 1) * looks + 1, frames[1] * looks)
