"""Points as a camera sees them: others in every frame."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.kept import KeptFrames
from chrmc.scene.points import PointCloud

FINEST = 0.25
"""Resolution cells per point, unless told otherwise: pixels are a grid, no blue noise."""
KEPT_FRAMES = 2
"""Frames whose points are remembered."""
MILLIMETRE = 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class Recorded(PointCloud):
    """A body whose points have no identity; as a cloud it is that of frame 0.

    read : frame 0, 1, … and a step to the points of every step-th row and column
    spacing : between neighbouring pixels, in the unit of the positions
    """

    read: Callable[[int, int], PointCloud] = field(kw_only=True)
    spacing: float = field(kw_only=True)
    step: int = field(default=1, kw_only=True)

    @classmethod
    def of(
        cls, read: Callable[[int, int], PointCloud], spacing: float, step: int = 1
    ) -> "Recorded":
        """The body that a function reads."""
        first = read(0, step)
        return cls(first.positions, first.amplitude, first.phase, first.colour,
                   read=read, spacing=spacing, step=step)  # fmt: skip

    @cached_property
    def in_frame(self) -> Callable[[int], PointCloud]:
        """Frame 0, 1, … to its points."""
        return KeptFrames(lambda frame: self.read(frame, self.step), KEPT_FRAMES)

    @property
    def core(self) -> NDArray[np.float64]:
        """(N, 3) positions of frame 0 without the outliers of a sensor: each at most as far out
        as 98 of 100 are."""
        low, high = np.percentile(self.positions, [1, 99], axis=0)
        return np.clip(self.positions, low, high)

    def moved(self, scale: float, centre: NDArray[np.float64]) -> "Recorded":
        """About another origin and in another size: scale·(position − centre)."""

        def read(frame: int, step: int) -> PointCloud:
            cloud = self.read(frame, step)
            place = scale * (cloud.positions - centre)
            return PointCloud(place, cloud.amplitude, cloud.phase, cloud.colour)

        return Recorded.of(read, scale * self.spacing, self.step)

    def filmed(
        self, frame_of: Callable[[int], int], finest: float, points: int | None
    ) -> "Recorded":
        """In the frames of a scene, as bright as a surface there: amplitudes √light · side of a
        point's area in millimetres. Positions are metres.

        finest : metres below which points lie too close for the SLM; points : about how many are
            wanted in frame 0, instead
        """
        step = max(1, int(finest / self.spacing))
        if points is not None:
            step = max(1, ceil(sqrt(len(self) / points)))
        side = self.spacing * step / MILLIMETRE

        def read(frame: int, step: int) -> PointCloud:
            cloud = self.read(frame_of(frame), step)
            return PointCloud(cloud.positions, side * cloud.amplitude, cloud.phase, cloud.colour)

        return Recorded.of(read, self.spacing, step)
