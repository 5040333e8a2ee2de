"""Interrupts in the middle of what must not be broken off."""

import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from chrmc.cli.signals import ended_by_signal
from chrmc.interrupts import interrupts_wait

# A signal while moderngl's C code is in Python: it takes no exception there.
_IN_THE_SHADERS = """
import signal, sys
from chrmc.gl_context import headless_context, make_program
from display.gl import _FRAGMENT, _VERTEX

def end(number, frame):
    raise KeyboardInterrupt

def look(frame, event, _):
    if event == "call" and frame.f_code.co_name == "make_attribute":
        sys.setprofile(None)
        print("in the middle")
        signal.raise_signal(signal.SIGTERM)

signal.signal(signal.SIGTERM, end)
context = headless_context()
sys.setprofile(look)
try:
    make_program(context, _VERTEX, _FRAGMENT)
except KeyboardInterrupt:
    print("ended")
"""

# A signal while the program is still being loaded.
_WHILE_LOADING = """
import signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            signal.raise_signal(signal.{number})

# As from a terminal: what a script starts with & ignores interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Finder())
sys.argv = ["chrmc", "bench", "speed"]
from chrmc.__main__ import main
main()
"""


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("module", ["click", "numpy.linalg"])
def test_a_signal_while_the_program_is_loaded_ends_it_politely(module: str, number: str) -> None:
    code = _WHILE_LOADING.format(module=module, number=number)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 130, done.stderr
    assert done.stderr.strip() == "chrmc: interrupted; what was finished is kept"


def test_a_module_that_is_loaded_for_ever_is_broken_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("chrmc.cli.signals.LOADING", 0.1)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "endless.py").write_text(
        "import signal\nsignal.raise_signal(signal.SIGTERM)\nwhile True:\n    pass\n"
    )
    with pytest.raises(KeyboardInterrupt), ended_by_signal():
        import_module("endless")


def test_a_signal_while_shaders_are_made_ends_the_program_politely() -> None:
    done = subprocess.run([sys.executable, "-c", _IN_THE_SHADERS], capture_output=True, text=True)
    assert (done.returncode, done.stdout.split("\n")) == (0, ["in the middle", "ended", ""])


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_interrupts_come_once_at_the_end(name: str) -> None:
    number = getattr(signal, name)
    came: list[str] = []
    before = signal.signal(number, lambda *_: came.append("signal"))
    try:
        with interrupts_wait():
            signal.raise_signal(number)
            signal.raise_signal(number)
            came.append("done")
        assert came == ["done", "signal"]
        with pytest.raises(OSError, match="own"), interrupts_wait():
            raise OSError("own")
        signal.raise_signal(number)
        assert came == ["done", "signal", "signal"]
    finally:
        signal.signal(number, before)


def test_what_the_caller_ignores_stays_ignored() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with interrupts_wait():
            signal.raise_signal(signal.SIGTERM)
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("second", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_second_signal_breaks_off_nothing_that_is_put_away(second: str) -> None:
    away = False
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), ended_by_signal():
            try:
                signal.raise_signal(signal.SIGTERM)
            finally:
                signal.raise_signal(getattr(signal, second))
                away = True
        assert away
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
