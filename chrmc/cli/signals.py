"""Signals that end a command politely: it leaves what it finished whole, as after Ctrl-C."""

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType

from chrmc.interrupts import INTERRUPTS

PATIENCE = 5.0
"""Seconds after an interrupt in which another one changes nothing."""


def no_more_signals() -> None:
    """Ignore Ctrl-C and its like from here on: the program is ending."""
    if threading.current_thread() is threading.main_thread():
        for number in INTERRUPTS:
            signal.signal(number, signal.SIG_IGN)


@contextlib.contextmanager
def ended_by_signal(even_under_nohup: bool = False) -> Iterator[None]:
    """Let a polite kill (SIGTERM) or a lost terminal (SIGHUP) end what is inside as Ctrl-C does.

    even_under_nohup : SIGHUP counts although the caller was told to outlive its terminal
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return

    came = -PATIENCE

    def end(_number: int, _frame: FrameType | None) -> None:
        nonlocal came
        now = time.monotonic()
        # A second one would break off what puts things away after the first.
        if now - came > PATIENCE:
            came = now
            raise KeyboardInterrupt

    polite = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        polite.append(signal.SIGINT)
    if hasattr(signal, "SIGHUP") and (
        even_under_nohup or signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN
    ):
        polite.append(signal.SIGHUP)
    before = [signal.signal(number, end) for number in polite]
    try:
        yield
    finally:
        for number, handler in zip(polite, before, strict=True):
            signal.signal(number, handler)
