"""Work beside the window: one thread, the newest job wins, results are taken when there is time."""

import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

Steps = Callable[[], Iterator[Any]]
"""A job: a function that starts a generator. What it yields is a result, or None where it can be
left; between two steps a newer job takes its place."""


@dataclass(frozen=True)
class Failed:
    """What a job ended with instead of a result."""

    error: Exception

    @property
    def message(self) -> str:
        """One line."""
        return " ".join(str(self.error).split()) or type(self.error).__name__


@dataclass(frozen=True)
class Said:
    """A message of a job for the user."""

    text: str


@dataclass(frozen=True)
class Progress:
    """How far a long job is: share from 0 to 1."""

    what: str
    share: float


class Worker:
    """A thread that does the newest job it was asked for.

    wake : called, in the thread, whenever there is a result to take

    A step that was begun is finished and its result handed over even when a newer job waits:
    who drags sees a picture as often as pictures can be made.
    """

    def __init__(self, name: str, wake: Callable[[], None] = lambda: None) -> None:
        self._wake = wake
        self._changed = threading.Condition()
        self._pending: Steps | None = None
        self._working = False
        self._left = False
        self._closed = False
        self._results: deque[Any] = deque()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def ask(self, job: Steps) -> None:
        """Do this, instead of what is being done or waits."""
        with self._changed:
            self._pending, self._left = job, False
            self._changed.notify_all()

    def leave(self) -> None:
        """Do nothing more of the present job."""
        with self._changed:
            self._pending, self._left = None, True

    @property
    def busy(self) -> bool:
        """Whether a job is under way or waits."""
        with self._changed:
            return self._pending is not None or (self._working and not self._left)

    def take(self) -> list[Any]:
        """Results since the last call, oldest first; `Failed` for a job that raised."""
        found = []
        while self._results:
            found.append(self._results.popleft())
        return found

    def close(self, seconds: float = 5.0) -> None:
        """End the thread after its present step."""
        with self._changed:
            self._closed, self._left, self._pending = True, True, None
            self._changed.notify_all()
        self._thread.join(seconds)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._working = False
                self._changed.wait_for(lambda: self._pending is not None or self._closed)
                if self._closed:
                    return
                job, self._pending = self._pending, None
                self._working, self._left = True, False
            assert job is not None
            self._do(job)

    def _do(self, job: Steps) -> None:
        try:
            steps = job()
            for result in steps:
                if result is not None:
                    self._hand_over(result)
                with self._changed:
                    if self._left or self._pending is not None:
                        break
        except Exception as error:  # whatever a job ends with is told, and the thread lives on
            self._hand_over(Failed(error))
        else:
            close = getattr(steps, "close", None)
            if close is not None:
                close()
        with self._changed:
            self._working = False
        self._wake()

    def _hand_over(self, result: Any) -> None:
        self._results.append(result)
        self._wake()
