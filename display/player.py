"""Playing: frames from a reel, at the surface's pace and as keys steer."""

import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

from display.flipper import Flipper, Surface
from display.gl import Trigger
from display.log import Flip, FlipLog
from display.playlist import Picture
from display.prefetch import Fault
from display.start import Start
from display.timing import Pace, Refresh, Summary, pace_for
from display.transport import Transport

ON_BAD_FRAME = ("skip", "stop")


class Reel(Protocol):
    """Where frames come from: `display.prefetch.Ring` for files, `display.live.LiveReel`."""

    loop: bool

    def take(self, timeout: float | None = 0.0) -> tuple[int, Picture | Fault] | None: ...
    def seek(self, index: int) -> None: ...


@dataclass(frozen=True)
class Options:
    """How to play.

    fps, every : frames per second, or flips per frame; default one frame per flip
    durations : seconds that each frame of the list stays, instead of fps and every
    fallback_rate : Hz kept by the clock on a screen whose flips do not wait
    paced : False plays frames as fast as they come (headless without a rate)
    loop : begin again after the last frame
    hold : stay on the last frame until a key ends it
    seconds : stop after so long, or None
    start_on : "key", or a time of day (`display.start.parse_time`); None begins at once
    countdown : seconds counted aloud before the first frame
    channel : colour channel that the panel shows, "all" for grey
    trigger : corner square for a photodiode, or None
    verify : True or "frames" reads every new frame back and compares it with its file, "screen"
        compares what the desktop shows (X11)
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
    verify: bool | str = False
    on_bad_frame: str = "skip"
    durations: Sequence[float] | None = None
    start_on: str | float | datetime | None = None
    countdown: float = 0.0

    def __post_init__(self) -> None:
        if self.on_bad_frame not in ON_BAD_FRAME:
            raise ValueError(f"on a bad frame: skip or stop, not {self.on_bad_frame!r}")
        if self.seconds is not None and not self.seconds > 0:
            raise ValueError(f"--seconds must be positive, not {self.seconds:g}")
        if self.durations is not None:
            if self.fps is not None or self.every is not None:
                raise ValueError("durations give each frame's time: leave fps and every out")
            if len(self.durations) == 0 or not all(0 < d < 1e6 for d in self.durations):
                raise ValueError("durations must be positive seconds, one for each frame")
        pace_for(Refresh(None, 0), self.fps, self.every)  # refuses what can never be
        self.start  # noqa: B018 - refuses what is no start

    @property
    def start(self) -> Start:
        """When the first frame comes."""
        return Start(self.start_on, self.countdown)

    @property
    def verified(self) -> str:
        """As the flipper takes it."""
        if isinstance(self.verify, str):
            return self.verify
        return "frames" if self.verify else ""


class Player:
    """Plays one reel on one surface.

    surface : opened by the caller, who also closes it
    reel : frames in order
    numbers : frame numbers in the reel's order
    shape : (rows, columns) of the frames
    log : where flips are recorded
    tell : is given lines that the user should read (pace, warnings, skipped frames)
    flipper : shows the frames, where a `display.Screen` has one already; channel, trigger, verify
        and log are then its own
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
        flipper: Flipper | None = None,
    ) -> None:
        self.surface, self.reel, self.options, self.tell = surface, reel, options, tell
        self.shape = shape
        self.transport = Transport(list(numbers), loop=options.loop)
        self.pace = Pace(None, 1, False)
        self._log = log or FlipLog(None)
        self._flipper = flipper
        self._faults: list[str] = []
        self._shown, self._place = False, ""
        self._wanted = False  # a key asks for a frame that has not been shown yet
        self._poll: Callable[[], None] = surface.poll

    def run(self, poll: bool = True) -> Summary:
        """Play to the end, or until a key ends it.

        poll : take in events here; False where another thread does (`play_together`)

        Raises OSError when a frame stops play, or when the monitor or the context is lost; what
        was logged until then is in the log.
        """
        self._poll = self.surface.poll if poll else lambda: None
        self.surface.bind()
        options = self.options
        self._flipper = Flipper(
            self.surface, self.shape, options.channel, options.trigger, self._log, options.verified
        )
        try:
            for _ in self.flips(self._poll):
                pass
        finally:
            self._flipper.release()
        return self.summary()

    def flips(self, poll: Callable[[], None]) -> Iterator[Flip]:
        """Every flip, once it is done; the surface is bound whenever this runs."""
        self._poll = poll
        assert self._flipper is not None
        try:
            self._find_pace(self._flipper)
            if self.options.start.wait(self._keys, self._quit, poll, self.tell):
                yield from self._play(self._flipper)
        except OSError as error:
            where = f"; log saved in {self._log.path}" if self._log.path else ""
            raise OSError(f"{error}; stopped at flip {self._flipper.flips}{where}") from error

    def summary(self) -> Summary:
        """The run so far."""
        if self._flipper is None:
            return Summary(0, 0, 0, 0, 0, 0, (), None)
        return self._flipper.summary(self.pace.period, tuple(self._faults))

    def _find_pace(self, flipper: Flipper) -> None:
        options, surface = self.options, self.surface
        refresh = flipper.measure(self.tell, self._poll)
        paced = options.paced or options.durations is not None
        fallback = options.fallback_rate if paced else None
        self.pace = pace_for(refresh, options.fps, options.every, fallback)
        flipper.describe(self.pace)
        if self.pace.warning:
            self.tell("warning: " + self.pace.warning)
        if surface.vsync and not self.pace.waits and self.pace.rate:
            self.tell(
                "warning: flips do not wait for a steady refresh on this screen: keeping "
                f"{self.pace.rate:.4g} frames per second by the clock"
            )

    def _keys(self) -> list[str]:
        return self.surface.pressed()

    def _quit(self) -> bool:
        return self.surface.closed

    def _play(self, flipper: Flipper) -> Iterator[Flip]:
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
                answer = self._advance(flipper)
                if answer == "end":
                    if not options.hold or not self._shown:
                        return
                    ended, self._wanted = True, False
                elif answer == "bad":
                    continue
                elif answer == "new":
                    shown, left, ended = "new", self._flips_for(transport.at), False
                    self._wanted = False
                else:
                    shown = "waiting"
                    flipper.waited += 1
            flip = flipper.flip(shown, self.pace)
            self._tell_place(flip)
            yield flip
            left -= 1

    def _tell_place(self, flip: Flip) -> None:
        """A line whenever the window leaves its place or is covered."""
        if flip.place != self._place and flip.place in ("moved", "covered", "hidden"):
            by = f" by {self.surface.cover!r}" if flip.place == "covered" else ""
            self.tell(f"warning: from flip {flip.flip} on the panel's window is {flip.place}{by}")
        self._place = flip.place

    def _flips_for(self, place: int) -> int:
        """Flips that the frame at a place in the list gets."""
        durations = self.options.durations
        if durations is None:
            return self.pace.every
        if place >= len(durations):
            raise ValueError(
                f"frame {place + 1} has no duration: there are {len(durations)}, one is needed "
                "for each"
            )
        period = self.pace.period or 1 / self.options.fallback_rate
        return max(1, round(durations[place] / period))

    def _asked(self) -> bool:
        """Take in the keys; whether one asks for another frame."""
        wanted = False
        for key in self._keys():
            place = self.transport.press(key)
            if place is not None:
                self.transport.at = place
                self.reel.seek(place)
                wanted = True
        self.reel.loop = self.transport.loop
        return wanted

    def _advance(self, flipper: Flipper) -> str:
        """Get the next frame: "new" (uploaded), "bad", "end", or "waiting" (not there in time)."""
        must = not self._shown or self.pace.period is None
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
            if not self._shown:
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
        flipper.upload(got)
        self._shown = True
        return "new"


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
    summaries: list[Any] = []
    for result in results:
        if isinstance(result, BaseException):
            raise result
        assert result is not None
        summaries.append(result)
    return summaries
