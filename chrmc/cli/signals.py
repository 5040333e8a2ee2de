"""Signals that end a command politely: it leaves what it finished whole, as after Ctrl-C."""

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType

from chrmc.interrupts import INTERRUPTS

PATIENCE = 5.0
"""Seconds after an interrupt in which another one changes nothing."""
LOADING = 30.0
"""Seconds that an interrupt waits at most for modules that are being loaded."""


class _End:
    """Raises KeyboardInterrupt for the first of several signals.

    Not in the middle of an import: C++ libraries that are being loaded would abort the process, and
    trimesh takes any exception for a package that is absent.
    """

    def __init__(self) -> None:
        self._put_off: float | None = None
        self._came = -PATIENCE

    def __call__(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._put_off is None:
            self._put_off = now
        if _loading(frame) and now - self._put_off < LOADING:
            again = threading.Timer(0.02, signal.raise_signal, [number])
            again.daemon = True
            again.start()
            return
        self._put_off = None
        # A second one would break off what puts things away after the first.
        if now - self._came > PATIENCE:
            self._came = now
            raise KeyboardInterrupt


def _loading(frame: FrameType | None) -> bool:
    """Whether a module is being imported."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def no_more_signals() -> None:
    """Ignore Ctrl-C and its like from here on: the program is ending."""
    if threading.current_thread() is threading.main_thread():
        for number in INTERRUPTS:
            signal.signal(number, signal.SIG_IGN)


def interrupted() -> int:
    """Say that the program was ended, and let nothing end what is being put away; its status."""
    no_more_signals()
    print("chrmc: interrupted; what was finished is kept", file=sys.stderr)
    return 130


@contextlib.contextmanager
def ended_by_signal(even_under_nohup: bool = False) -> Iterator[None]:
    """Let a polite kill (SIGTERM) or a lost terminal (SIGHUP) end what is inside as Ctrl-C does.

    even_under_nohup : SIGHUP counts although the caller was told to outlive its terminal
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's
        return
    outer = signal.getsignal(signal.SIGTERM)
    end = outer if isinstance(outer, _End) else _End()
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
