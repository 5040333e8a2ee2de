"""The monitors of this machine, and the choice of the one that is the SLM."""

import atexit
import contextlib
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from chrmc.slm import SLM
from display.edid import drm_labels, windows_label


@dataclass(frozen=True)
class Monitor:
    """A connected monitor.

    index : its place in the list
    name : of the output it hangs on, as the system calls it
    x, y : desktop position of its top left corner
    width, height : pixels of its current mode
    refresh : Hz of that mode; 0 where the system does not say
    scale : (x, y) content scale of the desktop (1 = no DPI scaling)
    primary : whether the desktop calls it the main one
    modes : (width, height, refresh) of all modes it offers
    label : what its maker calls it (EDID), "" where nothing says so
    """

    index: int
    name: str
    x: int
    y: int
    width: int
    height: int
    refresh: float
    scale: tuple[float, float] = (1.0, 1.0)
    primary: bool = False
    modes: tuple[tuple[int, int, int], ...] = ()
    label: str = ""

    def fits(self, slm: SLM) -> bool:
        """Whether its current mode has the SLM's pixels."""
        return (self.width, self.height) == (slm.width, slm.height)

    @property
    def title(self) -> str:
        """Label where known, else the output."""
        return self.label or self.name

    def __str__(self) -> str:
        label = f"{self.label!r} on " if self.label else ""
        place = f"{self.width} × {self.height} at ({self.x}, {self.y})"
        return f"[{self.index}] {label}{self.name!r} {place}"


def glfw_ready() -> Any:
    """The glfw module, initialised; OSError in one line where there is no display."""
    import glfw

    # Errors are asked for with get_error, where they can be turned into one line.
    glfw.ERROR_REPORTING = "ignore"
    if sys.platform.startswith("linux") and os.environ.get("DISPLAY"):
        _clean_up_x11()
    if not glfw.init():
        raise OSError(f"{_no_display()} ({last_error(glfw)}): {_REMEDY}")
    if glfw.get_platform() == glfw.PLATFORM_NULL:
        raise OSError(f"{_no_display()} (GLFW's null platform): {_REMEDY}")
    _at_exit(glfw.terminate)
    return glfw


@cache
def _at_exit(end: Callable[[], None]) -> None:
    atexit.register(end)  # once, so that what is registered later runs before it


def _clean_up_x11() -> None:
    from display.x11 import desktop

    with contextlib.suppress(OSError):  # GLFW will say why there is no display
        desktop().forget_dead_manager()


_REMEDY = "start it in a graphical session, or use --headless"


def _no_display() -> str:
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        return "no display to show anything on: DISPLAY is not set"
    return "no display to show anything on"


def last_error(glfw: Any) -> str:
    """GLFW's latest complaint, in words."""
    code, text = glfw.get_error()
    words = text.decode(errors="replace") if isinstance(text, bytes) else str(text or "")
    return words.strip() or f"GLFW error {code}"


def list_monitors() -> list[Monitor]:
    """All monitors, in the system's order; OSError where there is no display or no monitor."""
    glfw = glfw_ready()
    glfw.poll_events()
    handles = glfw.get_monitors()
    primary = glfw.get_primary_monitor()
    labels = _labels(glfw, handles)
    found = [
        describe(glfw, index, handle, same(handle, primary), labels[index])
        for index, handle in enumerate(handles)
    ]
    if not found:
        raise OSError("the display has no monitor: connect one, or use --headless")
    return found


def _labels(glfw: Any, handles: Sequence[Any]) -> list[str]:
    """Labels of monitors, from wherever the platform keeps them."""
    platform = glfw.get_platform()
    names = [_text(glfw.get_monitor_name(handle)) for handle in handles]
    if platform == glfw.PLATFORM_WIN32:
        return [windows_label(_text(glfw.get_win32_adapter(handle))) for handle in handles]
    if platform == glfw.PLATFORM_COCOA:
        return [""] * len(names)  # there GLFW's name is the label
    by_output = drm_labels()
    if platform == glfw.PLATFORM_X11:
        from display.x11 import desktop

        by_output |= desktop().labels()
    return [by_output.get(name, "") for name in names]


def _text(name: bytes | str) -> str:
    return name.decode(errors="replace") if isinstance(name, bytes) else str(name)


def describe(glfw: Any, index: int, handle: Any, primary: bool = False, label: str = "") -> Monitor:
    """The `Monitor` behind a GLFW handle."""
    mode = glfw.get_video_mode(handle)
    x, y = glfw.get_monitor_pos(handle)
    name = glfw.get_monitor_name(handle)
    width, height = mode.size
    return Monitor(
        index,
        _text(name),
        x,
        y,
        width,
        height,
        float(mode.refresh_rate),
        tuple(glfw.get_monitor_content_scale(handle)),
        primary,
        tuple((*m.size, m.refresh_rate) for m in glfw.get_video_modes(handle)),
        label,
    )


def same(one: Any, other: Any) -> bool:
    """Whether two GLFW handles are one monitor."""
    import ctypes

    return bool(
        ctypes.cast(one, ctypes.c_void_p).value == ctypes.cast(other, ctypes.c_void_p).value
    )


def choose(
    monitors: Sequence[Monitor], wanted: str | None, slm: SLM, any_size: bool = False
) -> Monitor:
    """The monitor meant by its label, its output's name, a part of either (any case) or an index.

    wanted : None takes the one monitor that fits the SLM, a secondary one before the primary
    any_size : do not insist on the SLM's resolution (for previews)

    Raises ValueError with a list of the monitors when none or several are meant, or when the
    chosen one has other pixels than the SLM.
    """
    listing = "; ".join(str(m) for m in monitors)
    if wanted is None:
        chosen = _by_size(monitors, slm, any_size, listing)
    else:
        chosen = _by_name(monitors, wanted, listing)
    if not (any_size or chosen.fits(slm)):
        raise ValueError(
            f"monitor {chosen.title!r} shows {chosen.width} × {chosen.height}, but {slm.name} "
            f"needs {slm.width} × {slm.height}: {_mode_remedy(chosen, slm)}, or preview with "
            "--windowed"
        )
    return chosen


def _by_size(monitors: Sequence[Monitor], slm: SLM, any_size: bool, listing: str) -> Monitor:
    fitting = [m for m in monitors if m.fits(slm)]
    if len(fitting) > 1:
        fitting = [m for m in fitting if not m.primary] or fitting
    if len(fitting) == 1:
        return fitting[0]
    if any_size:
        return next((m for m in monitors if m.primary), monitors[0])
    if fitting:
        raise ValueError(
            f"{len(fitting)} monitors have {slm.width} × {slm.height} pixels: say which with "
            f"--monitor; connected: {listing}"
        )
    raise ValueError(
        f"no monitor shows the {slm.width} × {slm.height} pixels of {slm.name} (connected: "
        f"{listing}): set the SLM's mode in the system's display settings, or use --windowed or "
        "--headless"
    )


def _by_name(monitors: Sequence[Monitor], wanted: str, listing: str) -> Monitor:
    text = wanted.strip()
    exact = [m for m in monitors if text and text in (m.name, m.label)]
    if len(exact) == 1:
        return exact[0]
    if text.isdecimal() and not exact:
        for monitor in monitors:
            if monitor.index == int(text):
                return monitor
    part = exact or [m for m in monitors if text and text.lower() in f"{m.name}\n{m.label}".lower()]
    if len(part) == 1:
        return part[0]
    what = f"{len(part)} monitors match" if part else "no monitor matches"
    remedy = "; use an index" if part else ""
    raise ValueError(f"{what} {wanted!r}; connected: {listing}{remedy}")


def _mode_remedy(monitor: Monitor, slm: SLM) -> str:
    if any((w, h) == (slm.width, slm.height) for w, h, _ in monitor.modes):
        return "it offers that mode, so choose it in the system's display settings"
    return "choose another --monitor"
