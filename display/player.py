"""Playing: frames from a ring onto a surface, at the surface's pace, every flip on record."""

import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from display.gl import Painter, Trigger
from display.log import Flip, FlipLog
from display.playlist import Picture
from display.prefetch import Fault
from display.timing import Pace, Refresh, Summary, judge, measure_refresh, pace_for, sleep_until
from display.transport import Transport

ON_BAD_FRAME = ("skip", "stop")


class Surface(Protocol):
    """What frames are drawn on: `display.window.Window`, `display.gl.Offscreen`, or your own.

    size : (width, height) pixels; context : moderngl; vsync : flips wait for a refresh
    reported_refresh : Hz, 0 where unknown; notes : what the user should be told
    place : where the window is ("ok", "moved", …), "" where that means nothing
    window_manager : its name, or ""; monitor : a `display.monitors.Monitor`, or None
    """

    size: Any
    context: Any
    vsync: bool
    reported_refresh: float
    name: str
    notes: list[str]
    place: str
    window_manager: str
    monitor: Any

    def bind(self) -> None: ...
    def unbind(self) -> None: ...
    def poll(self) -> None: ...
    def finish(self) -> None: ...
    def flip(self) -> None: ...
    def pressed(self) -> list[str]: ...
    def read(self) -> NDArray[np.uint8]: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...


class Reel(Protocol):
    """Where frames come from: `display.prefetch.Ring` for files, `display.live.LiveReel`."""

    loop: bool

    def take(self, timeout: float | None = 0.0) -> tuple[int, Picture | Fault] | None: ...
    def seek(self, index: int) -> None: ...


@dataclass(frozen=True)
class Options:
    """How to play.

    fps, every : frames per second, or flips per frame; default one frame per flip
    fallback_rate : Hz kept by the clock on a screen whose flips do not wait
    paced : False plays frames as fast as they come (headless without a rate)
    loop : begin again after the last frame
    hold : stay on the last frame until a key ends it
    seconds : stop after so long, or None
    channel : colour channel that the panel shows, "all" for grey
    trigger : corner square for a photodiode, or None
    verify : read every new frame back and compare it with its file
    on_bad_frame : "skip" or "stop"
    """

    fps: float | None = None
    every: int | None = None
    fallback_rate: float = 60.0
    paced: bool = True
    loop: bool = False
    hold: bool = False
    seconds: float | None = None
    channel: str = "all"
    trigger: Trigger | None = None
    verify: bool = False
    on_bad_frame: str = "skip"

    def __post_init__(self) -> None:
        if self.on_bad_frame not in ON_BAD_FRAME:
            raise ValueError(f"on a bad frame: skip or stop, not {self.on_bad_frame!r}")
        if self.seconds is not None and not self.seconds > 0:
            raise ValueError(f"--seconds must be positive, not {self.seconds:g}")
        pace_for(Refresh(None, 0), self.fps, self.every)  # refuses what can never be


class Player:
    """Plays one reel on one surface.

    surface : opened by the caller, who also closes it
    reel : frames in order
    numbers : frame numbers in the reel's order
    shape : (rows, columns) of the frames
    log : where flips are recorded
    tell : is given lines that the user should read (pace, warnings, skipped frames)
    """

    def __init__(
        self,
        surface: Surface,
        reel: Reel,
        numbers: Sequence[int],
        shape: tuple[int, int],
        options: Options = Options(),
        log: FlipLog | None = None,
        tell: Callable[[str], None] = lambda line: None,
    ) -> None:
        self.surface, self.reel, self.options, self.tell = surface, reel, options, tell
        self.shape = shape
        self.transport = Transport(list(numbers), loop=options.loop)
        self.pace = Pace(None, 1, False)
        self._log = log or FlipLog(None)
        self._intervals: list[float] = []
        self._flips = self._frames = self._late = self._dropped = self._missed = self._waited = 0
        self._misplaced = 0
        self._wanted = False  # a key asks for a frame that has not been shown yet
        self._faults: list[str] = []
        self._mismatches = 0
        self._shown: Picture | None = None
        self._square = False
        self._last = 0.0
        self._due = 0.0

    def run(self, poll: bool = True) -> Summary:
        """Play to the end, or until a key ends it.

        poll : take in events here; False where the main thread does (`play_together`)

        Raises OSError when a frame stops play, or when the monitor or the context is lost; what
        was logged until then is in the log.
        """
        self._poll = self.surface.poll if poll else lambda: None
        self.surface.bind()
        painter = Painter(
            self.surface.context, self.shape, self.options.channel, self.options.trigger
        )
        try:
            self._find_pace(painter)
            self._play(painter)
        except OSError as error:
            where = f"; log saved in {self._log.path}" if self._log.path else ""
            raise OSError(f"{error}; stopped at flip {self._flips}{where}") from error
        finally:
            painter.release()
        return self.summary()

    def summary(self) -> Summary:
        """The run so far."""
        return Summary(
            self._flips,
            self._frames,
            self._late,
            self._dropped,
            self._missed,
            self._waited,
            tuple(self._intervals),
            self.pace.period,
            tuple(self._faults),
            self._mismatches if self.options.verify else None,
            self._misplaced,
        )

    def _find_pace(self, painter: Painter) -> None:
        options, surface = self.options, self.surface
        refresh = Refresh(None, 0)
        if surface.vsync:
            painter.upload(np.zeros(self.shape, dtype=np.uint8))
            self.tell("measuring how often this screen refreshes: dark for up to 2 s")

            def flip() -> None:
                self._poll()
                painter.draw(surface.size)
                surface.flip()

            refresh = measure_refresh(flip, surface.reported_refresh)
            painter.check()
            if refresh.period is not None:
                self.tell(
                    f"refresh measured: {1 / refresh.period:.2f} Hz, after {refresh.flips} flips "
                    f"({surface.reported_refresh:g} Hz reported)"
                )
        fallback = options.fallback_rate if options.paced else None
        self.pace = pace_for(refresh, options.fps, options.every, fallback)
        measured = None if refresh.period is None else 1 / refresh.period
        monitor = surface.monitor
        self._log.describe(
            surface=surface.name,
            monitor=None if monitor is None else asdict(monitor) | {"modes": len(monitor.modes)},
            window_manager=surface.window_manager,
            notes=surface.notes,
            reported_refresh_hz=surface.reported_refresh,
            measured_refresh_hz=measured,
            frames_per_second=self.pace.rate,
            flips_per_frame=self.pace.every,
        )
        if self.pace.warning:
            self.tell("warning: " + self.pace.warning)
        if surface.vsync and not self.pace.waits and self.pace.rate:
            self.tell(
                "warning: flips do not wait for a steady refresh on this screen: keeping "
                f"{self.pace.rate:.4g} frames per second by the clock"
            )

    def _play(self, painter: Painter) -> None:
        options, transport = self.options, self.transport
        start = time.perf_counter()
        left = 0  # flips that the shown frame still has
        ended = False
        while True:
            self._poll()
            self._wanted |= self._asked()
            if transport.quit or self.surface.closed:
                return
            if options.seconds is not None and time.perf_counter() - start >= options.seconds:
                return
            shown = "paused" if transport.paused else "held"
            if self._wanted or (left <= 0 and not transport.paused and not ended):
                answer = self._advance(painter)
                if answer == "end":
                    if not options.hold or self._shown is None:
                        return
                    ended, self._wanted = True, False
                elif answer == "bad":
                    continue
                elif answer == "new":
                    shown, left, ended = "new", self.pace.every, False
                    self._wanted = False
                else:
                    shown = "waiting"
                    self._waited += 1
            self._flip(painter, shown)
            left -= 1

    def _asked(self) -> bool:
        """Take in the keys; whether one asks for another frame."""
        wanted = False
        for key in self.surface.pressed():
            place = self.transport.press(key)
            if place is not None:
                self.transport.at = place
                self.reel.seek(place)
                wanted = True
        self.reel.loop = self.transport.loop
        return wanted

    def _advance(self, painter: Painter) -> str:
        """Get the next frame: "new" (uploaded), "bad", "end", or "waiting" (not there in time)."""
        must = self._shown is None or self.pace.period is None
        while True:
            try:
                item = self.reel.take(0.02 if must else 0.0)
                break
            except queue.Empty:
                if not must:
                    return "waiting"
                self._poll()
                self._wanted |= self._asked()
                if self.surface.closed or self.transport.quit:
                    self.transport.quit = True
                    return "end"
        if item is None:
            if self._shown is None:
                raise OSError("; ".join(self._faults) or "there is no frame to show")
            return "end"
        index, got = item
        if isinstance(got, Fault):
            if self.options.on_bad_frame == "stop":
                raise OSError(str(got.error)) from got.error
            line = str(got.error)
            if line not in self._faults:
                self._faults.append(line)
                self.tell(f"warning: skipped {line}")
            elif len(self._faults) >= self.transport.count:
                raise OSError(f"no frame can be shown: {self._faults[0]}")
            return "bad"
        self.transport.at = index
        painter.upload(got.levels)
        self._shown = got
        self._square = not self._square
        self._frames += 1
        return "new"

    def _flip(self, painter: Painter, shown: str) -> None:
        picture = self._shown
        assert picture is not None
        painter.draw(self.surface.size, self._square)
        if self.options.verify and shown == "new":
            wanted = painter.expected(picture.levels, self._square)
            self._mismatches += not np.array_equal(self.surface.read(), wanted)
        if not self.pace.waits and self.pace.period is not None:
            self.surface.finish()
            sleep_until(self._due)
        self.surface.flip()
        painter.check()
        now = time.perf_counter()
        # A flip that came late moves those after it: none is hurried to catch up.
        period = self.pace.period or 0.0
        self._due = max(self._due + period, now + 0.5 * period)
        self._flips += 1
        interval = now - self._last if self._flips > 1 else None
        self._last = now
        status, missed = "first", 0
        if interval is not None:
            self._intervals.append(interval)
            status, missed = judge(interval, self.pace.period)
        self._late += status == "late"
        self._dropped += status == "dropped"
        self._missed += missed
        place = self.surface.place
        self._misplaced += place not in ("", "ok", "unknown")
        self._log.write(
            Flip(
                self._flips,
                picture.number,
                picture.file,
                picture.sha256,
                now,
                interval,
                shown,
                status,
                missed,
                place,
            )
        )


def play_together(players: Sequence[Player]) -> list[Summary]:
    """Play several players at once, each on its own surface and in its own thread.

    Call it in the main thread, where events are taken in. Raises the first player's error after
    all have ended; closing or quitting one leaves the others playing.
    """
    results: list[Summary | BaseException | None] = [None] * len(players)

    def work(place: int, player: Player) -> None:
        try:
            results[place] = player.run(poll=False)
        except BaseException as error:
            results[place] = error
        finally:
            player.surface.unbind()

    for player in players:
        player.surface.unbind()
    threads = [
        threading.Thread(target=work, args=item, name=f"player {item[0]}", daemon=True)
        for item in enumerate(players)
    ]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        for player in players:
            player.surface.poll()
        time.sleep(0.004)
    summaries = []
    for result in results:
        if isinstance(result, BaseException):
            raise result
        assert result is not None
        summaries.append(result)
    return summaries
