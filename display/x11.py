"""What GLFW does not say on X11: labels, the window manager, what lies over a window, pixels."""

import contextlib
import os
import threading
from collections.abc import Callable
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from display.edid import label_of

P = ParamSpec("P")
T = TypeVar("T")
Box = tuple[int, int, int, int]
"""x, y, width, height on the desktop, pixels."""
_ABOVE_DOCKS = 10  # of _WIN_LAYER: normal windows are at 4, docks at 8, menus at 12


def _in_turn(method: Callable[P, T]) -> Callable[P, T]:
    """A method of `Desktop` that no other thread may run into."""

    @wraps(method)
    def run(*arguments: P.args, **named: P.kwargs) -> T:
        desktop: Any = arguments[0]
        with desktop.turn:
            return method(*arguments, **named)

    return run


class Desktop:
    """A connection to the X server of DISPLAY, beside GLFW's; OSError where there is none.

    Any thread may use it: requests take turns.
    """

    def __init__(self) -> None:
        from Xlib import X, display, error

        self._x, self._failure = X, error.XError
        try:
            self._display = display.Display()
        except (
            error.DisplayError,
            error.XauthError,
            error.ConnectionClosedError,
            OSError,
        ) as problem:
            raise OSError(f"no connection to the X server: {problem}") from problem
        self._root = self._display.screen().root
        self.turn = threading.RLock()

    @_in_turn
    def labels(self) -> dict[str, str]:
        """Labels by output name, from the outputs' EDID."""
        labels = {}
        atom = self._display.intern_atom("EDID")
        with contextlib.suppress(self._failure, AttributeError):  # an old server has no RandR
            resources = self._root.xrandr_get_screen_resources_current()
            for output in resources.outputs:
                info = self._display.xrandr_get_output_info(output, resources.config_timestamp)
                found = self._display.xrandr_get_output_property(
                    output, atom, self._x.AnyPropertyType, 0, 64
                )
                label = label_of(bytes(v & 255 for v in found.value))
                if label:
                    labels[info.name] = label
        return labels

    @_in_turn
    def forget_dead_manager(self) -> None:
        """Remove what a window manager that ended without notice left on the root window.

        GLFW 3.4 aborts the whole program when it follows that trace to a window that is gone.
        """
        name = "_NET_SUPPORTING_WM_CHECK"
        if self._window_of(self._root, name) is None:
            self._root.delete_property(self._display.intern_atom(name))
            self._display.sync()

    @_in_turn
    def window_manager(self) -> str:
        """Its name, or "none"."""
        owner = self._window_of(self._root, "_NET_SUPPORTING_WM_CHECK")
        if owner is None:
            return "none"
        return self._title(owner) or "unknown"

    @_in_turn
    def compositing(self) -> bool:
        """Whether a compositor stands between windows and the screen."""
        name = f"_NET_WM_CM_S{self._display.get_default_screen()}"
        owner = self._display.get_selection_owner(self._display.intern_atom(name))
        return bool(owner)

    @_in_turn
    def covered_by(self, window: int, box: Box) -> str | None:
        """Name of the lowest window that lies over a part of `box` above ours; "" for none.

        None where ours is not on the screen at all (minimised, another workspace).
        """
        try:
            ours = self._display.create_resource_object("window", window)
            if ours.get_attributes().map_state != self._x.IsViewable:
                return None
            while (parent := ours.query_tree().parent) != self._root:
                ours = parent
            stack = self._root.query_tree().children  # lowest first
            above = stack[stack.index(ours) + 1 :]
        except (self._failure, ValueError):
            return None
        for other in above:
            with contextlib.suppress(self._failure):  # it went away in between
                about = other.get_attributes()
                if about.map_state != self._x.IsViewable or about.win_class != self._x.InputOutput:
                    continue
                place = other.get_geometry()
                if overlap((place.x, place.y, place.width, place.height), box):
                    return self._title(other) or f"window {other.id:#x}"
        return ""

    @_in_turn
    def grab(self, box: Box) -> NDArray[np.uint8]:
        """(height, width, 3) bytes of a part of the desktop, as the server has them."""
        x, y, width, height = box
        try:
            image = self._root.get_image(x, y, width, height, self._x.ZPixmap, 0xFFFFFFFF)
        except self._failure as problem:
            raise OSError(f"the X server does not give the screen's pixels: {problem}") from problem
        if len(image.data) != 4 * width * height:
            raise OSError(f"the X server gives pixels of depth {image.depth}; 24 is needed")
        picture = np.frombuffer(image.data, dtype=np.uint8).reshape(height, width, 4)
        return picture[:, :, 2::-1]  # blue comes first on the machines that X runs on

    @_in_turn
    def free_of_manager(self, window: int) -> None:
        """Tell the window manager to keep its hands off a window that is not yet mapped."""
        ours = self._display.create_resource_object("window", window)
        ours.change_attributes(override_redirect=True)
        self._display.sync()

    @_in_turn
    def keep_above(self, window: int) -> None:
        """Ask for a place above docks and task bars.

        IceWM lifts a full-screen window above its task bar only while it has the focus, and takes
        this older hint (GNOME's _WIN_LAYER); others do not know it.
        """
        from Xlib.protocol import event

        ours = self._display.create_resource_object("window", window)
        layer = self._display.intern_atom("_WIN_LAYER")
        wish = event.ClientMessage(
            window=ours, client_type=layer, data=(32, [_ABOVE_DOCKS, 0, 0, 0, 0])
        )
        mask = self._x.SubstructureRedirectMask | self._x.SubstructureNotifyMask
        self._root.send_event(wish, event_mask=mask)
        self._display.sync()

    @_in_turn
    def focus(self, window: int) -> None:
        """Give a window the keyboard, which no manager does for one it does not manage."""
        ours = self._display.create_resource_object("window", window)
        ours.set_input_focus(self._x.RevertToPointerRoot, self._x.CurrentTime)
        ours.configure(stack_mode=self._x.Above)
        self._display.sync()

    def _window_of(self, window: Any, name: str) -> Any:
        """The living window that a property names, or None."""
        with contextlib.suppress(self._failure):
            found = window.get_full_property(
                self._display.intern_atom(name), self._x.AnyPropertyType
            )
            if found is not None and len(found.value):
                other = self._display.create_resource_object("window", found.value[0])
                other.get_attributes()
                return other
        return None

    def _title(self, window: Any) -> str:
        """What a window, or the one in its frame, calls itself; "" for nothing."""
        with contextlib.suppress(self._failure):
            utf8 = self._display.intern_atom("_NET_WM_NAME")
            for candidate in (window, *window.query_tree().children):
                found = candidate.get_full_property(utf8, self._x.AnyPropertyType)
                if found is not None and found.value:
                    value = found.value
                    return (
                        value.decode(errors="replace") if isinstance(value, bytes) else str(value)
                    )
                name = candidate.get_wm_name()
                if name:
                    return name if isinstance(name, str) else name.decode(errors="replace")
        return ""


def desktop() -> Desktop:
    """This process's connection, kept to its end.

    A bare X server starts afresh when its last client leaves: a connection that comes and goes
    would pull it away from under GLFW.
    """
    return _connection(os.environ.get("DISPLAY", ""))


@cache
def _connection(_name: str) -> Desktop:
    return Desktop()


def overlap(one: Box, other: Box) -> bool:
    """Whether two boxes share a pixel."""
    return all(
        one[axis] < other[axis] + other[axis + 2] and other[axis] < one[axis] + one[axis + 2]
        for axis in (0, 1)
    )
