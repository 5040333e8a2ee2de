"""An SLM, or any monitor, as an object: show this now, say when it was on, go on."""

import atexit
import contextlib
import hashlib
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.grey_levels import encode, scale_for
from chrmc.panels import encoding_for
from chrmc.response import GreyResponse
from chrmc.slm import LC_R_1080, SLM
from display.colours import sequence_rate
from display.log import Flip, FlipLog
from display.opening import open_window
from display.playlist import Picture, check_levels, open_playlist
from display.prefetch import Ring
from display.reels import Pulled, ring_of
from display.timing import Pace, Summary, pace_for


class Screen:
    """A panel that shows arrays, pixel for pixel, and says when each was on.

    monitor : label, output, a part of either, or index; None takes the one that fits `slm`
    slm : the panel; default that of the named monitor's pixels, else LC_R_1080
    headless : draw without a screen; windowed : a preview on the desktop
    encoding, response, scale : how complex fields become grey levels (`display.encode`); default
        the usual encoding of the panel's kind, and those that it cannot show are refused. One scale
        holds for all of them: without one, the first field sets it, kept in `scale`
    channel : "all" for grey, or the one colour channel that the panel shows
    trigger : a `display.Trigger`, the corner square that toggles with every frame, or None
    on_flip : called with every `Flip` as soon as it is done, such as `display.UDPMark`
    log : file for one CSV line per flip; what holds for all is in a .json beside it
    verify : "frames" reads every new frame back and compares it, "screen" what the desktop shows
    tell : is given lines that the user should read

    Opening it measures the refresh: the panel is dark for up to 2 s. Any thread may call the
    methods; the window lives on between calls, and `close`, the end of a with block, or the end
    of the program closes it. On macOS: the main thread only.

    Raises ValueError for a monitor that is not there or has other pixels, OSError where the
    system does not give a whole, undecorated window on it.
    """

    def __init__(
        self,
        monitor: str | int | None = None,
        *,
        slm: SLM | None = None,
        headless: bool = False,
        windowed: bool = False,
        encoding: str | None = None,
        response: GreyResponse | None = None,
        scale: float | None = None,
        channel: str = "all",
        trigger: Any = None,
        on_flip: Callable[[Flip], object] | None = None,
        log: str | Path | None = None,
        verify: str = "",
        tell: Callable[[str], None] = lambda line: None,
        title: str = "chrmc",
    ) -> None:
        if headless and (windowed or monitor is not None):
            raise ValueError("a headless screen is on no monitor: leave windowed and monitor out")
        if scale is not None and not (np.isfinite(scale) and scale > 0):
            raise ValueError(f"scale must be positive, not {scale}")
        from display.flipper import Flipper

        self.response, self.scale, self.tell = response, scale, tell
        self.headless, self._trigger = headless, trigger
        self._turn, self._depth = threading.RLock(), 0
        self._poll: Callable[[], None] = lambda: None
        if slm is not None:
            encoding_for(slm, encoding)
        name = None if monitor is None else str(monitor)
        self.surface: Any
        if headless:
            from display.gl import Offscreen

            self.slm = slm or LC_R_1080
            self.surface = Offscreen(self.slm.shape)
            self.surface.unbind()
            end: Callable[[], None] = self.surface.close
        else:
            self.slm, self.surface, end, self._poll = open_window(name, slm, windowed, title)
        self.encoding = encoding_for(self.slm, encoding)
        if trigger is not None and self.slm.kind == "phase":
            tell("warning: a phase panel dims nothing: no photodiode sees the trigger square")
        self._end = weakref.finalize(self, end)
        # Before GLFW's own end, which was registered when the first window was opened.
        self._end.atexit = False
        atexit.register(self._end)
        self._log = FlipLog(log)
        for note in self.surface.notes:
            tell(note)
        try:
            with self._bound():
                self._flipper = Flipper(
                    self.surface, self.slm.shape, channel, trigger, self._log, verify, on_flip
                )
                self._refresh = self._flipper.measure(tell, self._poll)
                self._flipper.describe(pace_for(self._refresh))
        except BaseException:
            self.close()
            raise

    @property
    def name(self) -> str:
        """Of the monitor, by its label where it has one."""
        return str(self.surface.name)

    @property
    def refresh(self) -> float | None:
        """Measured refresh in Hz; None where flips do not wait for one."""
        return None if self._refresh.period is None else 1 / self._refresh.period

    @property
    def closed(self) -> bool:
        """Whether it was closed, here or by the user."""
        return not self._end.alive or bool(self.surface.closed)

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"{self._flipper.flips} flips"
        return f"<Screen {self.name!r}, {self.slm.width} × {self.slm.height}, {state}>"

    def levels(self, frame: Any) -> NDArray[np.uint8]:
        """The uint8 levels that a frame shows: itself, or a complex field encoded; (H, W), or
        (H, W, 3) where the channels differ."""
        frame = np.asarray(frame)
        if np.iscomplexobj(frame):
            if self.scale is None:
                self.scale = scale_for(frame, self.slm, self.encoding) or None
            return encode(frame, self.slm, self.encoding, self.scale or 1.0, response=self.response)
        if frame.dtype != np.uint8:
            raise ValueError(
                f"a frame is uint8 grey levels or a complex field, not {frame.dtype}: "
                "round it to 0…255 and cast it, or pass the field"
            )
        if frame.ndim != 2 and frame.shape[2:] != (3,):
            raise ValueError(
                f"a frame has (rows, columns), or (rows, columns, 3), not the shape {frame.shape}"
            )
        check_levels(frame, self.slm, "the frame")
        return frame

    def show(self, frame: Any, name: str = "") -> Flip:
        """Show one frame; returns when it is on.

        frame : (H, W) uint8 grey levels, (H, W, 3) for the three channels, or a complex field on
        the panel's pixels
        name : for the log

        `late` and `missed` of the answer count from this call: a frame uploaded and drawn within
        one period is on time.
        """
        self._check_open()
        asked = time.perf_counter()
        picture = self._picture(self._flipper.frames + 1, frame, name)
        pace = Pace(self._refresh.period, 1, self._refresh.period is not None)
        with self._bound():
            self._poll()
            self._flipper.upload(picture)
            return self._flipper.flip("new", pace, asked)

    def play(
        self,
        frames: Any,
        fps: float | None = None,
        *,
        every: int | None = None,
        durations: Sequence[float] | None = None,
        loop: bool = False,
        hold: bool = False,
        seconds: float | None = None,
        start_on: str | float | datetime | None = None,
        countdown: float = 0.0,
        on_bad_frame: str = "skip",
        ahead: int = 8,
        paced: bool = True,
        planes: int = 0,
        colours: str = "sequence",
        order: Sequence[float] | None = None,
    ) -> Iterator[Flip]:
        """Play frames; yields every flip once it is done.

        frames : any iterable of what `show` takes, a stored video (`chrmc.open_video`), the folder
            of one, or a reel
        fps, every, durations, loop, hold, seconds, start_on, countdown, on_bad_frame, paced : as
            `display.player.Options`
        ahead : frames of a stored video read ahead. Those of an iterable are asked for one by one,
            each when its time has come, so they may depend on what was measured before
        planes : so many binary frames go into one colour frame (`display.planes`), which is what
        fps and durations then count; 0 shows each by itself
        colours, order : of a video in colours (`display.colours`): its lasers in "sequence", or in
        the colour "channels"; wavelengths in metres. fps counts whole frames

        Keys steer as in `chrmc play`. What the caller does between two flips delays the second.
        """
        from display.player import Options, Player

        self._check_open()
        if start_on == "key" and self.headless:
            raise ValueError("a headless screen has no keys to start on: give a time")
        reel, numbers = self._reel(frames, loop, ahead, planes, colours, order)
        fps = sequence_rate(fps, len(getattr(reel, "lasers", ())), self.refresh or self.slm.refresh)
        options = Options(
            fps, every, self.slm.refresh, paced, loop, hold, seconds,
            on_bad_frame=on_bad_frame, durations=durations, start_on=start_on, countdown=countdown,
        )  # fmt: skip
        self._player = player = Player(
            self.surface, reel, numbers, self.slm.shape, options, self._log, self.tell,
            self._flipper,
        )  # fmt: skip
        # A ring that was made here is begun and ended here.
        own = reel if isinstance(reel, Ring) and reel is not frames else contextlib.nullcontext()
        return self._run(player, own)

    def _run(self, player: Any, own: Any) -> Iterator[Flip]:
        with own:
            flips = player.flips(self._poll)
            while True:
                self._check_open()
                with self._bound():
                    flip = next(flips, None)
                if flip is None:
                    return
                yield flip

    def pressed(self) -> list[str]:
        """Keys pressed in the window since the last call, such as "space" or "7"."""
        found: list[str] = self.surface.pressed()
        return found

    def summary(self) -> Summary:
        """What was shown so far amounts to."""
        player = getattr(self, "_player", None)
        if player is not None:
            found: Summary = player.summary()
            return found
        return self._flipper.summary(self._refresh.period)

    def read(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes that the panel's part of the desktop shows; headless, drawn.

        A compositor is waited for, half a second at most.
        """
        with self._bound():
            return self._flipper.seen()

    def close(self) -> None:
        """Close the window; nothing when it is closed already."""
        with self._turn:
            self._end()
            atexit.unregister(self._end)
            self._log.close()

    def __enter__(self) -> "Screen":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @contextlib.contextmanager
    def _bound(self) -> Iterator[None]:
        """Hold the turn, with the surface bound in this thread; may be nested."""
        with self._turn:
            if self._depth == 0:
                self.surface.bind()
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1
                if self._depth == 0 and self._end.alive:
                    self.surface.unbind()

    def _check_open(self) -> None:
        if not self._end.alive:
            raise ValueError("this screen is closed: open a new one")
        if self.surface.closed:
            raise OSError("the window was closed by the user")

    def _picture(self, number: int, frame: Any, name: str = "") -> Picture:
        levels = self.levels(frame)
        # Only the log asks for it, and it costs milliseconds.
        digest = ""
        if self._log.path is not None:
            digest = hashlib.sha256(np.ascontiguousarray(levels).data).hexdigest()
        return Picture(number, name or f"frame {number}", digest, levels)

    def _reel(
        self,
        frames: Any,
        loop: bool,
        ahead: int,
        planes: int,
        colours: str,
        order: Sequence[float] | None,
    ) -> tuple[Any, list[int]]:
        if hasattr(frames, "seek"):
            return frames, list(getattr(frames, "numbers", [1]))
        folder = getattr(frames, "folder", frames)
        if isinstance(folder, str | Path):
            listed = open_playlist(folder, self.slm, order=order)
            ring = ring_of(listed, loop, ahead, planes, colours, self._trigger)
            return ring, ring.numbers
        if isinstance(frames, np.ndarray) and frames.ndim not in (3, 4):
            raise ValueError(f"an array of frames has (frames, rows, columns), not {frames.shape}")
        if planes:
            from display.planes import packed_frames

            frames = packed_frames((self.levels(frame) for frame in frames), planes)
        pulled = Pulled(frames, self._picture, loop)
        return pulled, list(range(1, pulled.count + 1))
