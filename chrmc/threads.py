"""How many threads this process may use, and BLAS at one of them."""

import os
import threading
from typing import Any

from threadpoolctl import ThreadpoolController

THREADS = "CHRMC_THREADS"
"""Environment variable that sets the number, for processes that share a machine."""


def workers() -> int:
    """Threads that FFTs and thread pools here use: one for each core this process may run on."""
    asked = os.environ.get(THREADS, "")
    if asked.isdigit() and int(asked):
        return int(asked)
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Windows or macOS
        return os.cpu_count() or 1


class _OneBlasThread:
    """BLAS at one thread while anybody asks for it; what it used before comes back after.

    Threads may ask at the same time and end in any order: `threadpoolctl.threadpool_limits` would
    give the rest of them, and what comes after, the number that the first to ask had found.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._askers = 0
        self._limit: Any = None
        self._controller: ThreadpoolController | None = None

    def __enter__(self) -> None:
        with self._lock:
            if self._askers == 0:
                self._controller = self._controller or ThreadpoolController()
                self._take_over()
                self._limit = self._controller.limit(limits=1, user_api="blas")
            self._askers += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._askers -= 1
            if self._askers == 0:
                self._take_over()
                self._limit.restore_original_limits()
                self._take_over()

    def _take_over(self) -> None:
        """threadpoolctl 3.8 and newer silently ignore all threads but the first to set a limit;
        here whoever comes first sets it, and the last gives it back."""
        assert self._controller is not None
        for library in self._controller.lib_controllers:
            if hasattr(library, "clear_controlling_thread"):
                library.clear_controlling_thread(force=True)


ONE_BLAS_THREAD = _OneBlasThread()
"""One for the process: BLAS's threads are the process's, whoever asks."""
