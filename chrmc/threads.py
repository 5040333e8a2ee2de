"""How many threads this process may use."""

import os

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
