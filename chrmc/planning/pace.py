"""Keeping a rate by loosening the tolerance, within bounds, from frame to frame."""

from collections import deque
from dataclasses import dataclass, field

_CALM = 8  # frames well within the budget, from which a tighter tolerance is tried
_WELL, _FAR = 0.6, 2.0  # of the budget: well within it, and far beyond it
_STEP = 2.0


@dataclass
class Pace:
    """A tolerance that follows the time that frames take.

    budget : seconds per frame; tight, loose : tolerances between which it may choose
    tolerance : of the next frame; frames : (number, tolerance, seconds) of those made
    """

    budget: float
    tight: float
    loose: float
    tolerance: float
    frames: list[tuple[int, float, float]] = field(default_factory=list)
    _recent: deque[float] = field(default_factory=lambda: deque(maxlen=_CALM))
    _tried: float = 0.0  # the tightest that was too slow

    def took(self, number: int, seconds: float, fresh: bool = False) -> bool:
        """Note a frame's time; whether the tolerance of the next one is another.

        fresh : the first after a change, whose time is not that of later ones
        """
        self.frames.append((number, self.tolerance, seconds))
        if fresh:
            return False
        self._recent.append(seconds)
        before = self.tolerance
        if seconds > self.budget:
            self._tried = max(self._tried, before)
            self.tolerance *= _STEP**2 if seconds > _FAR * self.budget else _STEP
        elif len(self._recent) == _CALM and max(self._recent) < _WELL * self.budget:
            tighter = before / _STEP
            if tighter > self._tried:
                self.tolerance = tighter
            else:
                self._tried /= _STEP  # not at once again, but some time
                self._recent.clear()
        self.tolerance = min(max(self.tolerance, self.tight), self.loose)
        if self.tolerance != before:
            self._recent.clear()
        return self.tolerance != before

    def summary(self) -> str:
        """What the frames had."""
        had = [tolerance for _, tolerance, _ in self.frames]
        late = sum(seconds > self.budget for _, _, seconds in self.frames)
        return (
            f"budget: {1e3 * self.budget:.3g} ms a frame, {late} of {len(had)} frames over it; "
            f"tolerances {min(had):.2g} to {max(had):.2g}, {sorted(had)[len(had) // 2]:.2g} in the "
            "middle"
        )


def first_tolerance(
    seconds: dict[float, float], budget: float, tight: float, loose: float
) -> float:
    """The tightest tolerance that is expected to keep the budget; seconds : of each."""
    quick = [t for t, expected in seconds.items() if tight <= t <= loose and expected <= budget]
    return min(quick, default=loose)
