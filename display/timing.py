"""How often a screen flips, at which flips a frame changes, and whether a flip came in time."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil
from statistics import median

LATE = 1.2
"""A flip this many periods after the one before it was late."""
AGREEING = 10
"""So many flips in a row must agree before their interval is believed."""
_SPREAD = 0.05  # of the median: what counts as agreeing
MOST_FLIPS = 1_000_000
"""That a frame may stay: hours."""
_NO_VSYNC = 1 / 400  # seconds: no panel refreshes faster, so nothing waited for the screen


@dataclass(frozen=True)
class Refresh:
    """A measured refresh.

    period : seconds, or None where flips do not wait for a screen
    flips : flips that it took to find out
    spread : (longest − shortest)/median of the agreeing ones
    """

    period: float | None
    flips: int
    spread: float = 0.0


def measure_refresh(
    flip: Callable[[], object],
    reported: float = 0.0,
    clock: Callable[[], float] = time.perf_counter,
    sleep: Callable[[float], object] = time.sleep,
    seconds: float = 2.0,
) -> Refresh:
    """Flip until AGREEING intervals in a row lie within 5 % of their median.

    A steady interval may also be the drawing's own pace. So a few flips are then held up by 0.3
    periods: a screen that waits for its refresh shows no difference.

    flip : shows something and returns when it is shown
    reported : what the system says, Hz, 0 for nothing
    seconds : after so long it is given up: the screen has no steady refresh

    A steady interval far below the reported or any panel's period means flips do not wait, too.
    """
    intervals: list[float] = []
    end = clock() + seconds
    flip()
    before = clock()
    count = 0
    while before < end:
        flip()
        count += 1
        now = clock()
        intervals.append(now - before)
        before = now
        last = intervals[-AGREEING:]
        if len(last) < AGREEING:
            continue
        middle = median(last)
        if middle < max(_NO_VSYNC, 0.5 / reported if reported > 0 else 0.0):
            return Refresh(None, count)
        spread = (max(last) - min(last)) / middle
        if spread < 2 * _SPREAD:
            held: list[float] = []
            while len(held) < AGREEING // 2 and before < end:
                sleep(0.3 * middle)
                flip()
                now = clock()
                held.append(now - before)
                before = now
            if len(held) < 3:
                break
            waits = median(held) < 1.15 * middle
            return Refresh(middle if waits else None, count + len(held), spread)
    return Refresh(None, count)


@dataclass(frozen=True)
class Pace:
    """When frames change.

    period : seconds between flips; None means as fast as they come
    every : flips per frame
    waits : the screen itself waits for its refresh; otherwise the player must sleep
    warning : what the user should know, or ""
    """

    period: float | None
    every: int = 1
    waits: bool = True
    warning: str = ""

    @property
    def rate(self) -> float | None:
        """Frames per second."""
        return None if self.period is None else 1 / (self.period * self.every)


def check_rate(fps: float | None, name: str) -> None:
    """ValueError for frames per second that no screen and no patience has; None is any."""
    if fps is not None and not 1e-4 <= fps <= 10_000:
        raise ValueError(f"{name} must be a positive rate, 1e-4 to 10,000, not {fps:g}")


def pace_for(
    refresh: Refresh,
    fps: float | None = None,
    every: int | None = None,
    fallback: float | None = None,
) -> Pace:
    """The pace that comes nearest to what is wanted on a measured screen.

    fps : frames per second; one that does not divide the refresh gets the nearest that does
    every : flips per frame, instead of fps
    fallback : Hz to keep by the clock where the screen does not wait; None for unpaced
    """
    if fps is not None and every is not None:
        raise ValueError("--fps and --every both give the rate: use one of them")
    check_rate(fps, "--fps")
    if every is not None and not 1 <= every <= MOST_FLIPS:
        raise ValueError(f"--every must be 1 to {MOST_FLIPS} flips, not {every}")
    if refresh.period is None:
        if fps is not None:
            return Pace(1 / fps, 1, False)
        if fallback is None:
            return Pace(None, every or 1, False)
        return Pace(1 / fallback, every or 1, False)
    if fps is None:
        return Pace(refresh.period, every or 1)
    rate = 1 / refresh.period
    flips = max(1, round(rate / fps))
    warning = ""
    if abs(rate / flips / fps - 1) > 0.01:
        dividers = ", ".join(f"{rate / n:.3g}" for n in range(1, 7))
        warning = (
            f"{fps:g} frames per second do not divide the refresh of {rate:.2f} Hz: playing at "
            f"{rate / flips:.4g}, one frame every {flips} flips (it divides into {dividers} …)"
        )
    return Pace(refresh.period, flips, True, warning)


def judge(interval: float, period: float | None) -> tuple[str, int]:
    """(status, flips missed) of an interval: "ok", "late" past 1.2 periods, "dropped" past 1.5.

    Without a period nothing can be late: "free".
    """
    if period is None:
        return "free", 0
    if interval <= LATE * period:
        return "ok", 0
    missed = max(0, round(interval / period) - 1)
    return ("dropped", missed) if missed else ("late", 0)


def sleep_until(moment: float) -> None:
    """Wait for a time of `time.perf_counter`; the last millisecond awake, for accuracy."""
    while (left := moment - time.perf_counter()) > 0:
        time.sleep(left - 0.001 if left > 0.0015 else 0)


@dataclass(frozen=True)
class Summary:
    """What a run of flips amounted to.

    flips, frames : flips made, new frames among them
    late, dropped, missed : flips late, flips that came after missed ones, periods missed in all
    waited : flips at which a new frame was due but not there yet
    intervals : seconds between flips
    period : seconds that a flip should take, or None
    faults : frames that could not be shown, in words
    mismatches : flips whose pixels were read back and differed; None when not asked for
    misplaced : flips while the window was not whole on its monitor (moved, covered, hidden)
    """

    flips: int
    frames: int
    late: int
    dropped: int
    missed: int
    waited: int
    intervals: Sequence[float]
    period: float | None
    faults: Sequence[str] = ()
    mismatches: int | None = None
    misplaced: int = 0

    def lines(self) -> list[str]:
        """The summary in words."""
        text = [f"{self.frames} frame{'' if self.frames == 1 else 's'} in {self.flips} flips"]
        total = sum(self.intervals)
        if self.intervals and total > 0:
            ordered = sorted(self.intervals)
            p99 = ordered[ceil(0.99 * len(ordered)) - 1]
            text.append(
                f"{len(ordered) / total:.2f} flips per second; interval median "
                f"{1e3 * median(ordered):.2f} ms, 99 % within {1e3 * p99:.2f} ms, longest "
                f"{1e3 * ordered[-1]:.2f} ms"
            )
        if self.period is not None:
            text.append(
                f"{self.late} late, {self.dropped} after dropped refreshes ({self.missed} missed)"
                f", {self.waited} waited for a frame"
            )
        if self.mismatches is not None:
            text.append(
                "every frame read back equals its file to the pixel"
                if self.mismatches == 0
                else f"{self.mismatches} frames read back DIFFER from their files"
            )
        if self.misplaced:
            text.append(
                f"{self.misplaced} flips while the panel did NOT show the whole window (moved, "
                "covered or hidden)"
            )
        text.extend(f"not shown: {fault}" for fault in self.faults)
        return text
