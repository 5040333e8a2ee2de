"""A scene whose frames are kept, so that only holograms are timed."""

from typing import Any

from chrmc.scene.scene import Scene, SceneFrame


class KeptFrames:
    """A scene each of whose frames is made once.

    frames : numbers of those that are made at once
    """

    def __init__(self, scene: Scene, frames: range = range(0)) -> None:
        self._scene = scene
        self._frames: dict[int, SceneFrame] = {}
        for number in frames:
            self.frame(number)

    def frame(self, number: int) -> SceneFrame:
        """Frame `number`, from 1."""
        if number not in self._frames:
            self._frames[number] = self._scene.frame(number)
        return self._frames[number]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)
