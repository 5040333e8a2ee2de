"""The one thread that GLFW is called from: it opens windows, watches and closes them.

A window needs its events taken in all the time, also while a notebook waits for its user or a
script for a camera. On macOS windows belong to the main thread, so there calls run where they are
made, and events are taken in at each `poll`.
"""

import atexit
import queue
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache
from typing import Any, TypeVar

T = TypeVar("T")
_EVERY = 0.005  # seconds between looks at the windows
_LONGEST = 30.0  # seconds that opening one may take: GLFW must not be ended in the middle of it


class Home:
    """Runs calls one after the other in a thread of its own, and in between what is watched."""

    def __init__(self) -> None:
        self._calls: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]] | None]
        self._calls = queue.SimpleQueue()
        self._watched: list[Callable[[], None]] = []
        self._thread: threading.Thread | None = None
        if sys.platform != "darwin":
            self._thread = threading.Thread(target=self._work, name="windows", daemon=True)
            self._thread.start()

    def call(self, function: Callable[[], T]) -> T:
        """What the function returns or raises, run at home."""
        thread = self._thread
        if thread is None or thread is threading.current_thread() or not thread.is_alive():
            return function()  # at the end of the program the thread may be gone before a window
        answer: Future[T] = Future()
        self._calls.put((function, answer))
        return answer.result()

    def watch(self, look: Callable[[], None]) -> None:
        """Call this again and again from now on."""
        self.call(lambda: self._watched.append(look))

    def forget(self, look: Callable[[], None]) -> None:
        """Stop calling this."""
        self.call(lambda: self._watched.remove(look))

    def poll(self) -> None:
        """Look at the windows where no thread does."""
        if self._thread is None:
            for look in self._watched:
                look()

    def stop(self) -> None:
        """End the thread."""
        if self._thread is not None:
            self._calls.put(None)
            self._thread.join(_LONGEST)

    def _work(self) -> None:
        while True:
            try:
                task = self._calls.get(timeout=_EVERY if self._watched else None)
            except queue.Empty:
                for look in list(self._watched):
                    look()
                continue
            if task is None:
                return
            function, answer = task
            try:
                answer.set_result(function())
            except BaseException as error:
                answer.set_exception(error)


@cache
def home() -> Home:
    """This process's one; OSError in one line where there is no display."""
    from display.monitors import glfw_ready

    loop = Home()
    try:
        loop.call(glfw_ready)
    except BaseException:
        loop.stop()
        raise
    atexit.register(loop.stop)  # before glfw_ready's own, so that nothing calls GLFW after it
    return loop
