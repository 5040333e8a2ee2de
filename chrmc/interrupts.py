"""Signals that wait until what must not be broken off is done."""

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType

INTERRUPTS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Ctrl-C, a polite kill and a lost terminal, those that the system has."""


@contextlib.contextmanager
def interrupts_wait() -> Iterator[None]:
    """Let an interrupt (Ctrl-C, SIGTERM, SIGHUP) come only when what is inside is done.

    For C code that calls Python and does not expect that to raise: it would end the process.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    came: list[int] = []

    def keep(number: int, _frame: FrameType | None) -> None:
        came.append(number)

    before = {
        number: handler for number in INTERRUPTS if callable(handler := signal.getsignal(number))
    }
    for number in before:
        signal.signal(number, keep)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for first in came[:1]:
            signal.raise_signal(first)
