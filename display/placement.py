"""Getting a window onto a monitor, undecorated and pixel for pixel, and seeing that it stays.

A request is not a result. Window managers differ: Mutter and Metacity place and decorate a window
that is hinted as not resizable, Openbox and Fluxbox do not know _NET_WM_FULLSCREEN_MONITORS and
fill the monitor that the window is on. All take a small undecorated window that begins on the
right monitor and then asks for full screen; where it came to lie is then read back.
"""

import time
from typing import Any

from display.monitors import Monitor
from display.x11 import Box, Desktop

_SMALL = 64  # pixels: fits any monitor, whatever panels and docks take of it
_PATIENCE = 4.0  # seconds for a window manager to do what it was asked
_STEADY = 0.1  # seconds that the right place must hold before it is believed


def centre(monitor: Monitor) -> tuple[int, int]:
    """Where the small window's corner goes, so that it lies on one monitor alone."""
    return monitor.x + (monitor.width - _SMALL) // 2, monitor.y + (monitor.height - _SMALL) // 2


def open_on(
    glfw: Any, monitor: Monitor, handle: Any, title: str, desktop: Desktop | None
) -> tuple[Any, str]:
    """A full-screen window on a monitor, None when refused, and what the user should know.

    The caller has set the hints of the OpenGL context. `desktop` is the X server, None elsewhere.
    Where the manager does not do it, X11 still can: a window that it does not manage
    (override-redirect). Raises OSError that says where the window is instead.
    """
    glfw.window_hint(glfw.DECORATED, False)
    glfw.window_hint(glfw.RESIZABLE, True)
    glfw.window_hint(glfw.FLOATING, True)
    x, y = centre(monitor)
    glfw.window_hint(glfw.POSITION_X, x)
    glfw.window_hint(glfw.POSITION_Y, y)
    window = glfw.create_window(_SMALL, _SMALL, title, None, None)
    if not window:
        return None, ""
    rate = round(monitor.refresh) or glfw.DONT_CARE
    glfw.set_window_monitor(window, handle, 0, 0, monitor.width, monitor.height, rate)
    if _settles(glfw, window, monitor):
        if desktop is not None:
            desktop.keep_above(glfw.get_x11_window(window))
        return window, ""
    found = describe_place(glfw, window)
    glfw.destroy_window(window)
    manager = f"window manager {desktop.window_manager()}" if desktop else "the system"
    if desktop is not None:
        window = _open_unmanaged(glfw, monitor, title, desktop)
        if not window or _settles(glfw, window, monitor):
            return window, (
                f"{manager} put the window {found}: shown past it (override-redirect) instead; "
                "the screen saver is not held off"
            )
        glfw.destroy_window(window)
    raise OSError(
        f"{manager} puts the window {found}, not on monitor {monitor.name!r} at ({monitor.x}, "
        f"{monitor.y}), {monitor.width} × {monitor.height}: let it not manage windows of class "
        "chrmc, or run the panel's desktop without a window manager"
    )


def _open_unmanaged(glfw: Any, monitor: Monitor, title: str, desktop: Desktop) -> Any:
    glfw.window_hint(glfw.VISIBLE, False)
    glfw.window_hint(glfw.POSITION_X, monitor.x)
    glfw.window_hint(glfw.POSITION_Y, monitor.y)
    window = glfw.create_window(monitor.width, monitor.height, title, None, None)
    glfw.window_hint(glfw.VISIBLE, True)
    if window:
        desktop.free_of_manager(glfw.get_x11_window(window))
        glfw.show_window(window)
        glfw.set_window_pos(window, monitor.x, monitor.y)
        glfw.set_window_size(window, monitor.width, monitor.height)
        glfw.poll_events()
        desktop.focus(glfw.get_x11_window(window))
    return window


def box_of(monitor: Monitor) -> Box:
    """The monitor's part of the desktop."""
    return monitor.x, monitor.y, monitor.width, monitor.height


def in_place(glfw: Any, window: Any, monitor: Monitor) -> bool:
    """Whether a window's drawn area is the monitor, as far as the platform says.

    Wayland says nothing of places, so there only the size counts.
    """
    if tuple(glfw.get_window_size(window)) != (monitor.width, monitor.height):
        return False
    if glfw.get_platform() == glfw.PLATFORM_WAYLAND:
        return True
    return tuple(glfw.get_window_pos(window)) == (monitor.x, monitor.y)


def describe_place(glfw: Any, window: Any) -> str:
    """Where a window is, in words."""
    width, height = glfw.get_window_size(window)
    x, y = glfw.get_window_pos(window)
    frame = ", in a frame" if any(glfw.get_window_frame_size(window)) else ""
    return f"at ({x}, {y}), {width} × {height}{frame}"


def _settles(glfw: Any, window: Any, monitor: Monitor) -> bool:
    """Wait until the window is in place and stays there for a moment."""
    start = time.monotonic()
    since: float | None = None
    while (now := time.monotonic()) - start < _PATIENCE:
        glfw.poll_events()
        if in_place(glfw, window, monitor):
            since = now if since is None else since
            if now - since >= _STEADY:
                return True
        else:
            since = None
        time.sleep(0.01)
    return False
