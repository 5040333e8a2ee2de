"""How many threads this process may use."""

import os


def workers() -> int:
    """Threads that FFTs and thread pools here use: one for each core this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Windows or macOS
        return os.cpu_count() or 1
