"""What the NLUT videos take, from the corrections of a few frames whose fields are not made."""

from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from chrmc.cgh.counts import OperationCounts
from chrmc.cgh.method import method_named
from chrmc.compensation.counted import VideoCost
from chrmc.compensation.nlut import mc_nlut, mpeg_nlut, tr_nlut
from chrmc.encoding import Coding
from chrmc.scene.scene import ObjectFrame, Scene, SceneFrame
from chrmc.slm import SLM
from chrmc.window import Window

CGH = "nlut"
_VIDEOS = {"tr-nlut": tr_nlut.frames, "mc-nlut": mc_nlut.frames, "mpeg-nlut": mpeg_nlut.frames}
_FRAMES = 4  # that are looked at: a group of mpeg-nlut
_MANY = 3000  # points of which some stand for all
_PASSES = 32.0  # bytes of a pixel, where a field is carried from frame to frame


def cost(
    name: str, scene: Scene, numbers: range, slm: SLM, wavelength: float, coding: Coding
) -> VideoCost | None:
    """Of a video by its name; None where nothing is to be seen.

    What is shifted keeps the error that it was computed with, and what is taken out was put in
    with the same: nothing is added to the CGH method's own error.
    """
    first = scene.frame(numbers[0])
    step = max(1, len(first.cloud) // _MANY)
    some: Any = scene if step == 1 else _Some(scene, step)
    made = _VIDEOS[name](some, slm, wavelength, CGH, numbers[:_FRAMES], coding)
    records = [frame.record for frame in islice(made, _FRAMES)]
    method, pixels = method_named(CGH), slm.width * slm.height
    if method.cost is None or not len(first.cloud):
        return None
    key = method.cost(first.cloud, slm, wavelength, Window.full(slm), coding.passband)
    work = [record.point_pixels for record in records]
    share = float(np.mean(work[1:])) / work[0] if work[1:] and work[0] else 1.0
    later = key.times(share) + OperationCounts(bytes=_PASSES * pixels, memory=16.0 * pixels)
    return VideoCost(CGH, key, later, _FRAMES if name == "mpeg-nlut" else len(numbers))


@dataclass(frozen=True)
class _Some:
    """A scene of every so many points: those of some identities, or on some of its pixels."""

    scene: Scene
    step: int

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scene, name)

    def frame(self, number: int) -> SceneFrame:
        return SceneFrame(number, tuple(map(self._part, self.scene.frame(number).objects)))

    def _part(self, obj: ObjectFrame) -> ObjectFrame:
        if obj.ids is not None:
            kept = obj.ids % self.step == 0
            return ObjectFrame(obj.name, obj.cloud.select(kept), obj.body, obj.ids[kept], obj.pose)
        column, row = np.rint(obj.cloud.positions[:, :2].T / self.scene.pixel_pitch).astype(int)
        return ObjectFrame(obj.name, obj.cloud.select((31 * row + column) % self.step == 0))
