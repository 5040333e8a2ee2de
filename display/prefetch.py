"""A thread that reads frames ahead into a bounded ring, so that no flip waits for the disk."""

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass

from display.playlist import Picture


@dataclass(frozen=True)
class Fault:
    """A frame that could not be had: its place in the list and why."""

    index: int
    error: Exception


class Ring:
    """Frames read ahead, in order.

    read : place in the list → Picture; OSError and ValueError become `Fault`s
    count : length of the list
    loop : start again after the last one
    ahead : most frames held
    numbers : of the frames, in the list's order; 1, 2, … unless set
    lasers : names of those that the list shows one after the other, in turn

    Use as a context manager; the thread ends with the block.
    """

    def __init__(
        self, read: Callable[[int], Picture], count: int, loop: bool = False, ahead: int = 8
    ) -> None:
        if ahead < 1:
            raise ValueError(f"a ring needs room for at least one frame, not {ahead}")
        self._read, self._count, self._ahead = read, count, ahead
        self.loop = loop
        self.lasers: list[str] = []
        self.numbers = list(range(1, count + 1))
        self._held: list[tuple[int, Picture | Fault]] = []
        self._next = 0
        self._generation = 0
        self._stopped = False
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="prefetch", daemon=True)

    def __enter__(self) -> "Ring":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        with self._change:
            self._stopped = True
            self._change.notify_all()
        self._thread.join()

    def seek(self, index: int) -> None:
        """Forget what is held and go on from a place in the list (clipped to it)."""
        with self._change:
            self._generation += 1
            self._held.clear()
            self._next = min(max(index, 0), self._count - 1)
            self._change.notify_all()

    def take(self, timeout: float | None = 0.0) -> tuple[int, Picture | Fault] | None:
        """The next (place, frame).

        timeout : seconds to wait for it, None for as long as it takes

        Raises queue.Empty when it is not there in time. None means the list is over.
        """
        with self._change:
            self._change.wait_for(lambda: bool(self._held) or self._over, timeout)
            if self._held:
                item = self._held.pop(0)
                self._change.notify_all()
                return item
            if self._over:
                return None
            raise queue.Empty

    @property
    def _over(self) -> bool:
        return self._next >= self._count and not self.loop and not self._held

    def _work(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._stopped or self._room)
                if self._stopped:
                    return
                generation = self._generation
                index = self._next % self._count
            item: Picture | Fault
            try:
                item = self._read(index)
            except (OSError, ValueError) as error:
                item = Fault(index, error)
            with self._change:
                if generation == self._generation:  # else a seek has overtaken this one
                    self._held.append((index, item))
                    self._next = index + 1
                    self._change.notify_all()

    @property
    def _room(self) -> bool:
        return len(self._held) < self._ahead and (self._next < self._count or self.loop)
