"""A scene whose frames are made once."""

from dataclasses import dataclass, field

from chrmc.scene.derived import DerivedScene
from chrmc.scene.scene import Scene, SceneFrame, as_scene


@dataclass(frozen=True, eq=False, repr=False)
class KeptScene(DerivedScene):
    """A scene whose frames are made once, so that no method's time holds their making."""

    _frames: dict[int, SceneFrame] = field(default_factory=dict, init=False)

    def frame(self, number: int) -> SceneFrame:
        """Frame `number`, from 1."""
        if number not in self._frames:
            self._frames[number] = self.scene.frame(number)
        return self._frames[number]


def kept_scene(scene: Scene, frames: range = range(0)) -> KeptScene:
    """The scene, some of its frames made at once."""
    kept = KeptScene(as_scene(scene))
    for number in frames:
        kept.frame(number)
    return kept
