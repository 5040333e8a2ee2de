"""Whether factors may be shown: by what is expected of them, and by a look at some pixels."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from chrmc.cgh.curved.interface import (
    SURE,
    Budget,
    Factor,
    Plane,
    light_kept,
    measured_error,
    promise_kept,
)
from chrmc.scene.points import PointCloud

AIM = 0.7
"""Of the tolerance: one key frame has to do for many frames, the worst included."""
_UNSEEN = 0.8
"""Share of the tolerance up to which what is expected of objects together needs no look."""
LOOKED, SOMETIMES = 5000, 8
"""Points up to which every frame is looked at on some pixels; beyond that, every so many."""


@dataclass(frozen=True)
class Promise:
    """A tolerance of the field on some pixels."""

    plane: Plane
    tolerance: float

    def kept(self, factor: Factor, cloud: PointCloud, budget: Budget, count: int | None) -> bool:
        """Whether an object may be shown so.

        count : frames before this one; None for a key frame, which is always looked at
        """
        if not promise_kept([factor], budget, self.tolerance, len(cloud)):
            return False
        look = count is None or count % SOMETIMES == 0 or len(cloud) <= LOOKED
        return not look or self._missed([factor], cloud, budget) <= SURE

    def together(self, factors: Sequence[Factor], cloud: PointCloud, total: Budget) -> float:
        """The relative error expected of objects together: more than of each where they cancel.

        cloud : all their points; total : of all objects
        """
        kept = light_kept(factors, self.plane)
        # Where light adds up, so do the errors that each object was allowed.
        if total.relative <= _UNSEEN * self.tolerance * sqrt(kept):
            return total.relative / sqrt(kept) if kept > 0 else 0.0
        return self.tolerance * self._missed(factors, cloud, total)

    def _missed(self, factors: Sequence[Factor], cloud: PointCloud, budget: Budget) -> float:
        """The error on some pixels, over the tolerance."""
        error = measured_error(factors, cloud, self.plane, self.tolerance, budget.relative)
        return error / self.tolerance
