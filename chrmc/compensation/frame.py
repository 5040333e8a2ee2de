"""One frame of a hologram video, as every video method yields it."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chrmc.record import FrameRecord
from chrmc.scene.points import PointCloud
from chrmc.scene.scene import SceneFrame

FieldMaker = Callable[[], NDArray[np.complex64]]
SignalMaker = Callable[[], NDArray[np.float32]]


class VideoFrame:
    """A frame whose field is made when it is first asked for.

    scene_frame : the objects and visible points it shows
    record : its ledger; stage times are complete once `field` or `signal` was made
    shown : the points that the field stands for; the scene frame's own unless a method carries
        points whose identity is unknown, whose phases then differ from a fresh frame's
    """

    def __init__(
        self,
        scene_frame: SceneFrame,
        record: FrameRecord,
        make_field: FieldMaker,
        make_signal: SignalMaker | None = None,
        shown: PointCloud | None = None,
    ) -> None:
        self.scene_frame = scene_frame
        self.record = record
        self._make_field = make_field
        self._make_signal = make_signal
        self._shown = shown
        record.objects = [
            {
                "name": o.name,
                "position": None if len(o.cloud) == 0 else [float(v) for v in o.position],
                "depth": None if len(o.cloud) == 0 else o.depth,
            }
            for o in scene_frame.objects
        ]

    @property
    def number(self) -> int:
        """Counts from 1, the scene's frame number."""
        return self.scene_frame.number

    @property
    def cloud(self) -> PointCloud:
        """All visible points."""
        return self.scene_frame.cloud

    @property
    def shown(self) -> PointCloud:
        """The points that the field stands for: what its error is measured against."""
        return self.cloud if self._shown is None else self._shown

    @cached_property
    def field(self) -> NDArray[np.complex64]:
        """(H, W) complex field on the hologram plane."""
        return self._make_field()

    @cached_property
    def signal(self) -> NDArray[np.float32] | None:
        """(H, W) Re(field·carrier) straight from a method that needs no complex field, or None."""
        return None if self._make_signal is None else self._make_signal()
