"""The viewer's window: GLFW for window and hands, moderngl for pictures, Dear ImGui for controls.

Needs the optional packages of `chrmc[viewer]`. Nothing is computed here: the session's model is
asked, and what its workers have finished is drawn.
"""

import contextlib
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import glfw
import numpy as np
from imgui_bundle import imgui

from chrmc.gl_context import window_context, window_hints
from reconstruct.images import write_colour
from reconstruct.viewer import theme
from reconstruct.viewer.lasers import Source
from reconstruct.viewer.layout import Layout
from reconstruct.viewer.recent import recent_file
from reconstruct.viewer.session import Session

SIZE = (1500, 900)
LEAST = (900, 560)
_TYPED = {
    "LEFT": "left_arrow",
    "RIGHT": "right_arrow",
    "UP": "up_arrow",
    "DOWN": "down_arrow",
    "SPACE": "space",
    "ENTER": "enter",
    "KP_ENTER": "keypad_enter",
    "ESCAPE": "escape",
    "BACKSPACE": "backspace",
    "DELETE": "delete",
    "TAB": "tab",
    "HOME": "home",
    "END": "end",
    "A": "a",
    "C": "c",
    "V": "v",
    "X": "x",
    "Z": "z",
}
"""Keys that Dear ImGui wants for what is typed."""
_NAMES = {
    glfw.KEY_SPACE: "Space",
    glfw.KEY_LEFT: "Left",
    glfw.KEY_RIGHT: "Right",
    glfw.KEY_UP: "Up",
    glfw.KEY_DOWN: "Down",
    glfw.KEY_HOME: "Home",
    glfw.KEY_END: "End",
    glfw.KEY_PAGE_UP: "PageUp",
    glfw.KEY_PAGE_DOWN: "PageDown",
    glfw.KEY_TAB: "Tab",
    glfw.KEY_ESCAPE: "Escape",
    glfw.KEY_F1: "H",
    **{getattr(glfw, f"KEY_{n}"): str(n) for n in (1, 2, 3)},  # whatever they print unshifted
}


def key_name(key: int, scancode: int, modifiers: int) -> str:
    """A key as `keys.KEYS` writes it, by what is printed on it; empty for others."""
    name = _NAMES.get(key) or (glfw.get_key_name(key, scancode) or "").upper()
    return f"Ctrl+{name}" if name and modifiers & glfw.MOD_CONTROL else name


class ViewerWindow:
    """One window on one video, or on two; `run` returns when it is closed."""

    def __init__(self, videos: Source | Sequence[Source], visible: bool = True) -> None:
        self._lively = 3
        recent: Path | None = None
        with contextlib.suppress(ImportError):
            recent = recent_file()
        self.session = Session(videos, glfw.post_empty_event, recent_file=recent)
        try:
            self._handle = self._open(self.session.title, visible)
        except OSError:
            self.session.model.close()
            raise
        self.context = window_context()
        imgui.create_context()
        imgui.get_io().set_ini_filename("")
        self.layout = Layout(self.context, theme.apply(self._content_scale()))
        imgui.backends.opengl3_init("#version 330")
        self._connect()
        self._drawn_at = time.monotonic()

    def _open(self, title: str, visible: bool) -> Any:
        glfw.ERROR_REPORTING = "ignore"
        if not glfw.init() or glfw.get_platform() == glfw.PLATFORM_NULL:
            raise OSError("no display for the viewer: start it in a graphical session")
        glfw.default_window_hints()
        window_hints(glfw)
        glfw.window_hint(glfw.VISIBLE, visible)
        glfw.window_hint(glfw.SCALE_TO_MONITOR, True)
        width, height = SIZE
        monitor = glfw.get_primary_monitor()
        if monitor:
            _, _, free_width, free_height = glfw.get_monitor_workarea(monitor)
            width, height = min(width, free_width), min(height, free_height)
        window = glfw.create_window(width, height, title, None, None)
        if not window:
            raise OSError("no OpenGL 3.3 window can be opened on this display")
        glfw.make_context_current(window)
        glfw.swap_interval(1)
        glfw.set_window_size_limits(window, *LEAST, glfw.DONT_CARE, glfw.DONT_CARE)
        return window

    def _content_scale(self) -> float:
        # macOS counts in points already; elsewhere GUI units are pixels.
        width, _ = glfw.get_window_size(self._handle)
        pixels, _ = glfw.get_framebuffer_size(self._handle)
        return float(glfw.get_window_content_scale(self._handle)[0]) if pixels == width else 1.0

    def _connect(self) -> None:
        """GLFW's events go to Dear ImGui, keys to the session."""
        io, window = imgui.get_io(), self._handle
        typed = {getattr(glfw, f"KEY_{k}"): getattr(imgui.Key, v) for k, v in _TYPED.items()}
        modifiers = {
            glfw.KEY_LEFT_CONTROL: imgui.Key.mod_ctrl,
            glfw.KEY_RIGHT_CONTROL: imgui.Key.mod_ctrl,
            glfw.KEY_LEFT_SHIFT: imgui.Key.mod_shift,
            glfw.KEY_RIGHT_SHIFT: imgui.Key.mod_shift,
        }

        def on_key(_: Any, key: int, scancode: int, action: int, held: int) -> None:
            self._lively = 3
            if action != glfw.REPEAT:
                if key in modifiers:
                    io.add_key_event(modifiers[key], action == glfw.PRESS)
                if key in typed:
                    io.add_key_event(typed[key], action == glfw.PRESS)
            if action != glfw.RELEASE:
                self._press(key_name(key, scancode, held))

        def on_button(_: Any, button: int, action: int, __: int) -> None:
            self._lively = 3
            if button < 3:
                io.add_mouse_button_event(button, action == glfw.PRESS)

        def on_move(_: Any, x: float, y: float) -> None:
            self._lively = max(self._lively, 2)
            io.add_mouse_pos_event(x, y)

        def on_wheel(_: Any, x: float, y: float) -> None:
            self._lively = 3
            io.add_mouse_wheel_event(x, y)

        def on_character(_: Any, code: int) -> None:
            self._lively = 3
            io.add_input_character(code)

        def on_drop(_: Any, paths: Any, *__: Any) -> None:
            self._lively = 3
            if paths:
                self.session.open(paths[0])

        def on_change(*_: Any) -> None:
            self._lively = 3

        glfw.set_key_callback(window, on_key)
        glfw.set_mouse_button_callback(window, on_button)
        glfw.set_cursor_pos_callback(window, on_move)
        glfw.set_scroll_callback(window, on_wheel)
        glfw.set_char_callback(window, on_character)
        glfw.set_drop_callback(window, on_drop)
        glfw.set_framebuffer_size_callback(window, on_change)
        glfw.set_window_refresh_callback(window, on_change)
        glfw.set_window_focus_callback(window, lambda _, on: io.add_focus_event(bool(on)))

    def _press(self, name: str) -> None:
        """Keys work wherever the mouse is, unless something is typed or a list is open."""
        listed = imgui.is_popup_open(
            "", int(imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level)
        )
        if name == "Escape" and listed:
            self._close_lists = True
        elif imgui.get_io().want_text_input and name != "Ctrl+O":
            if name == "Escape" and self.session.asking:
                self.session.asking = False
        elif not listed:
            self.session.press(name)

    _close_lists = False

    # --- the loop ---

    def run(self) -> None:
        """Until the window is closed."""
        try:
            self.draw()  # the panes' sizes are known before anything is asked for
            while not glfw.window_should_close(self._handle):
                self.wait()
                self.draw()
        finally:
            self.close()

    def screenshot(self, path: Path, seconds: float = 120.0) -> None:
        """Write a picture of the window, once all that it shows is sharp, and close it."""
        end = time.monotonic() + seconds
        try:
            self.draw()
            while self._lively > 0 or not self.session.model.resting:
                if time.monotonic() > end:
                    raise OSError(f"{path}: the picture is not ready after {seconds:g} s")
                self.wait()
                self.draw()
            pixels, rows = glfw.get_framebuffer_size(self._handle)
            raw = self.context.screen.read((0, 0, pixels, rows), components=3, alignment=1)
        finally:
            self.close()
        picture = np.frombuffer(raw, dtype=np.uint8).reshape(rows, pixels, 3)
        write_colour(path, picture[::-1])

    def wait(self) -> None:
        """Sleep until there is something to draw: hands, a worker's result, a frame to flip."""
        model = self.session.model
        if self._lively > 0:
            glfw.poll_events()
        elif model.busy:
            glfw.wait_events_timeout(1 / 8)  # its sign turns
        elif model.playing:
            glfw.wait_events_timeout(max(model.seconds_to_flip, 0.001))
        elif model.seconds_to_rest:
            glfw.wait_events_timeout(model.seconds_to_rest)
        else:
            glfw.wait_events_timeout(0.5)
        self._lively -= 1
        if self.session.update():
            self._lively = max(self._lively, 2)
        if self.session.model is not model:
            glfw.set_window_title(self._handle, self.session.title)
        if self.session.leaving:
            glfw.set_window_should_close(self._handle, True)

    def draw(self) -> None:
        """One frame of the GUI."""
        width, height = glfw.get_window_size(self._handle)
        pixels, rows = glfw.get_framebuffer_size(self._handle)
        if not width or not pixels:  # minimised
            return
        density = pixels / width
        io = imgui.get_io()
        io.display_size = imgui.ImVec2(width, height)
        io.display_framebuffer_scale = imgui.ImVec2(density, rows / height)
        now = time.monotonic()
        io.delta_time = max(now - self._drawn_at, 1e-4)
        self._drawn_at = now
        imgui.backends.opengl3_new_frame()
        imgui.new_frame()
        if self._close_lists:
            self._close_lists = False
            imgui.internal.close_popup_to_level(0, True)
        self.layout.draw(self.session, width, height, density)
        imgui.render()
        self.context.screen.use()
        self.context.viewport = (0, 0, pixels, rows)
        self.context.clear(*theme.BACKGROUND)
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        glfw.swap_buffers(self._handle)

    def close(self) -> None:
        """Give everything back."""
        self.session.model.close()
        with contextlib.suppress(Exception):
            imgui.backends.opengl3_shutdown()
        imgui.destroy_context()
        glfw.destroy_window(self._handle)
        glfw.terminate()


def view(videos: Source | Sequence[Source]) -> None:
    """Open the viewer on a video, or on two to compare, and return when it is closed."""
    ViewerWindow(videos).run()
