"""One flip: a frame drawn, shown, timed, judged, checked and logged."""

import time
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from display.gl import Painter, Trigger
from display.log import Flip, FlipLog
from display.playlist import Picture
from display.timing import Pace, Refresh, Summary, judge, measure_refresh, sleep_until

VERIFY = ("", "frames", "screen")
_SETTLE = 0.5  # seconds that a compositor may take until the desktop shows what was flipped


class Surface(Protocol):
    """What frames are drawn on: `display.window.Window`, `display.gl.Offscreen`, or your own.

    size : (width, height) pixels; context : moderngl; vsync : flips wait for a refresh
    reported_refresh : Hz, 0 where unknown; notes : what the user should be told
    place : where the window is ("ok", "moved", …), "" where that means nothing; cover : by what
        it is covered
    window_manager : its name, or ""; monitor : a `display.monitors.Monitor`, or None
    """

    size: Any
    context: Any
    vsync: bool
    reported_refresh: float
    name: str
    notes: list[str]
    place: str
    cover: str
    window_manager: str
    monitor: Any

    def bind(self) -> None: ...
    def unbind(self) -> None: ...
    def poll(self) -> None: ...
    def finish(self) -> None: ...
    def flip(self) -> None: ...
    def pressed(self) -> list[str]: ...
    def read(self) -> NDArray[np.uint8]: ...
    def grab(self) -> NDArray[np.uint8]: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...


class Flipper:
    """Shows pictures on a surface that is bound in the calling thread, and keeps the account.

    surface : opened and closed by others
    shape : (rows, columns) of the pictures
    channel, trigger : as `Painter`
    log : where flips are recorded
    verify : "frames" reads every new frame back and compares it, "screen" what the desktop shows
    on_flip : called with every `Flip` as soon as it is done; what it takes delays the next one
    """

    def __init__(
        self,
        surface: Surface,
        shape: tuple[int, int],
        channel: str = "all",
        trigger: Trigger | None = None,
        log: FlipLog | None = None,
        verify: str = "",
        on_flip: Callable[[Flip], object] | None = None,
    ) -> None:
        if verify not in VERIFY:
            raise ValueError(f"verify: frames or screen, not {verify!r}")
        if verify and tuple(surface.size) != (shape[1], shape[0]):
            raise ValueError("--verify compares pixels, so the SLM must fit the window at 1:1")
        self.surface, self.shape, self.verify = surface, shape, verify
        self.log = log or FlipLog(None)
        self.painter = Painter(surface.context, shape, channel, trigger)
        self.refresh: Refresh | None = None
        self.picture: Picture | None = None
        self._on_flip = on_flip
        self._square = False
        self._last = self._due = 0.0
        self._intervals: list[float] = []
        self.flips = self.frames = self.waited = 0
        self._late = self._dropped = self._missed = self._misplaced = self._mismatches = 0

    def measure(
        self, tell: Callable[[str], None], poll: Callable[[], None] = lambda: None
    ) -> Refresh:
        """The surface's refresh, found once by flipping a dark frame for up to 2 s."""
        if self.refresh is not None:
            return self.refresh
        surface = self.surface
        if not surface.vsync:
            self.refresh = Refresh(None, 0)
            return self.refresh
        tell("measuring how often this screen refreshes: dark for up to 2 s")
        self.painter.upload(np.zeros(self.shape, dtype=np.uint8))

        def flip() -> None:
            poll()
            self.painter.draw(surface.size)
            surface.flip()

        self.refresh = found = measure_refresh(flip, surface.reported_refresh)
        self.painter.check()
        if found.period is not None:
            tell(
                f"refresh measured: {1 / found.period:.2f} Hz, after {found.flips} flips "
                f"({surface.reported_refresh:g} Hz reported)"
            )
        return found

    def describe(self, pace: Pace) -> None:
        """Write what holds for all flips beside the log."""
        surface, monitor = self.surface, self.surface.monitor
        period = self.refresh.period if self.refresh else None
        self.log.describe(
            surface=surface.name,
            monitor=None if monitor is None else asdict(monitor) | {"modes": len(monitor.modes)},
            window_manager=surface.window_manager,
            notes=surface.notes,
            reported_refresh_hz=surface.reported_refresh,
            measured_refresh_hz=None if period is None else 1 / period,
            frames_per_second=pace.rate,
            flips_per_frame=pace.every,
        )

    def upload(self, picture: Picture) -> None:
        """Make this the picture of the flips to come."""
        self.painter.upload(picture.levels)
        self.picture = picture
        self._square = not self._square
        self.frames += 1

    def flip(self, shown: str, pace: Pace, asked: float | None = None) -> Flip:
        """Show the picture uploaded last.

        shown : for the log
        pace : how long a flip should take, and whether the screen itself waits
        asked : when it was asked for, where it is that, not the flip before, from which lateness
            counts; None in a steady run
        """
        picture, surface = self.picture, self.surface
        assert picture is not None
        self.painter.draw(surface.size, self._square)
        new = shown == "new"
        if self.verify == "frames" and new:
            self._compare(surface.read)
        if not pace.waits and pace.period is not None and asked is None:
            surface.finish()
            sleep_until(self._due)
        surface.flip()
        self.painter.check()
        now = time.perf_counter()
        # A flip that came late moves those after it: none is hurried to catch up.
        period = pace.period or 0.0
        self._due = max(self._due + period, now + 0.5 * period)
        self.flips += 1
        interval = now - self._last if self.flips > 1 else None
        self._last = now
        status, missed = "first", 0
        if interval is not None:
            self._intervals.append(interval)
            status, missed = judge(interval if asked is None else now - asked, pace.period)
        self._late += status == "late"
        self._dropped += status == "dropped"
        self._missed += missed
        place = surface.place
        self._misplaced += place not in ("", "ok", "unknown")
        flip = Flip(
            self.flips, picture.number, picture.file, picture.sha256,
            now, interval, shown, status, missed, place,
        )  # fmt: skip
        self.log.write(flip)
        if self._on_flip is not None:
            self._on_flip(flip)
        if self.verify == "screen" and new:
            self._compare(surface.grab, _SETTLE)
        return flip

    def seen(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes of what the desktop shows.

        A compositor puts it together after the flip: what was flipped is waited for, half a second
        at most, then what is there is given.
        """
        if self.picture is None:
            return self.surface.grab()
        return self._settled(self.surface.grab, _SETTLE)[0]

    def _settled(
        self, read: Callable[[], NDArray[np.uint8]], patience: float
    ) -> tuple[NDArray[np.uint8], bool]:
        """What is read, and whether it became what should be there."""
        assert self.picture is not None
        wanted = self.painter.expected(self.picture.levels, self._square)
        end = time.perf_counter() + patience
        while True:
            got = read()
            if (same := np.array_equal(got, wanted)) or time.perf_counter() >= end:
                return got, same
            time.sleep(0.01)

    def _compare(self, read: Callable[[], NDArray[np.uint8]], patience: float = 0.0) -> None:
        """Count a difference between what is read and what should be there."""
        self._mismatches += not self._settled(read, patience)[1]

    def summary(self, period: float | None, faults: tuple[str, ...] = ()) -> Summary:
        """The account so far."""
        return Summary(
            self.flips,
            self.frames,
            self._late,
            self._dropped,
            self._missed,
            self.waited,
            tuple(self._intervals),
            period,
            faults,
            self._mismatches if self.verify else None,
            self._misplaced,
        )

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self.painter.release()
