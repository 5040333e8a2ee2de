"""Frames made while they are played: a generator thread that feeds a bounded ring."""

import queue
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from display.playlist import Picture
from display.prefetch import Fault


@dataclass(frozen=True)
class LiveReport:
    """What the generator did.

    frames : made
    busy : seconds it was making them
    blocked : seconds it waited because the ring was full
    """

    frames: int
    busy: float
    blocked: float

    @property
    def rate(self) -> float:
        """Frames per second that it could make if nothing held it up."""
        return self.frames / self.busy if self.busy > 0 else 0.0


class LiveReel:
    """A reel whose frames a generator thread makes as they are needed.

    make : begins the sequence from its first frame; the thread calls it, again after the end when
        looping
    ahead : most finished frames that wait for the screen

    NumPy and SciPy do their work without Python's lock, so the thread and the player share the
    cores. Jumps are not possible: `seek` is ignored. What the generator raises ends play, with its
    message. Use as a context manager.
    """

    def __init__(
        self, make: Callable[[], Iterator[Picture]], loop: bool = False, ahead: int = 3
    ) -> None:
        self.loop = loop
        self.numbers = [1]
        self._make = make
        self._ready: queue.Queue[Picture | None] = queue.Queue(ahead)
        self._stopped = threading.Event()
        self._error: Exception | None = None
        self._frames, self._busy, self._blocked = 0, 0.0, 0.0
        self._over = False
        self._thread = threading.Thread(target=self._work, name="generator", daemon=True)

    def __enter__(self) -> "LiveReel":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()

    def seek(self, index: int) -> None:
        """Live frames come in their own order."""

    def take(self, timeout: float | None = 0.0) -> tuple[int, Picture | Fault] | None:
        """The next frame, as `display.prefetch.Ring.take`; raises what the generator raised."""
        if self._over:
            return None
        item = self._ready.get(block=timeout != 0.0, timeout=timeout)
        if item is None:
            self._over = True
            if self._error is not None:
                raise self._error
            return None
        return 0, item

    def report(self) -> LiveReport:
        """The generator's account so far."""
        return LiveReport(self._frames, self._busy, self._blocked)

    def _work(self) -> None:
        try:
            while not self._stopped.is_set():
                if not self._once() or not self.loop:
                    break
        except Exception as error:  # handed to the player, which raises it
            self._error = error
        self._put(None)

    def _once(self) -> bool:
        """One pass through the sequence; False when it is empty or play has stopped."""
        count = 0
        start = time.perf_counter()
        for picture in self._make():
            done = time.perf_counter()
            self._busy += done - start
            self._frames += 1
            count += 1
            if not self._put(picture):
                return False
            start = time.perf_counter()
            self._blocked += start - done
        return count > 0

    def _put(self, item: Picture | None) -> bool:
        while not self._stopped.is_set():
            try:
                self._ready.put(item, timeout=0.05)
                return True
            except queue.Full:
                continue
        return False
