"""The viewer's window: GLFW for window and hands, moderngl for pictures, Dear ImGui for controls.

Needs the optional packages of `chrmc[viewer]`. Nothing is computed here: the model is asked, a
coarse picture while something moves and the full one when it rests.
"""

import contextlib
import time
from typing import Any

import glfw
import moderngl
from imgui_bundle import imgui

from chrmc.store import Video
from reconstruct.viewer import controls, theme
from reconstruct.viewer.canvas import Canvas
from reconstruct.viewer.controls import ControlState
from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.panes import Pane, colour
from reconstruct.viewer.shade import Look
from reconstruct.viewer.view import View

SIZE = (1500, 900)
SIDE = 330.0
"""Width of the controls."""
REST = 0.15
"""Seconds without a change after which the full picture is made."""
_LOOKS = {"Hologram": Look(), "Fourier plane": Look(mode="log")}
_KEYS = {
    "LEFT": "left_arrow",
    "RIGHT": "right_arrow",
    "UP": "up_arrow",
    "DOWN": "down_arrow",
    "SPACE": "space",
    "ENTER": "enter",
    "ESCAPE": "escape",
    "BACKSPACE": "backspace",
    "DELETE": "delete",
    "TAB": "tab",
    "HOME": "home",
    "END": "end",
    "A": "a",
    "C": "c",
    "F": "f",
    "S": "s",
    "V": "v",
    "X": "x",
}


class ViewerWindow:
    """One window on one video; `run` returns when it is closed."""

    def __init__(self, video: Video, visible: bool = True) -> None:
        self.model = ViewerModel(video)
        self.state = ControlState()
        self._handle = self._open(f"{video.folder} - chrmc", visible)
        self.context = moderngl.create_context()
        imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        self._font = theme.apply(self._content_scale())
        imgui.backends.opengl3_init("#version 330")
        self._connect()
        slm = video.slm
        self.panes = {
            name: Pane(name, Canvas(self.context, kind, shifted), View(slm.width, slm.height))
            for name, kind, shifted in (
                ("Reconstruction", "complex", False),
                ("Hologram", "grey", False),
                ("Fourier plane", "complex", True),
            )
        }
        self._aim: tuple[int, int] | None = None
        self._watched: Any = None
        self._changed_at = 0.0
        self._masked: Any = None
        self._measured: Any = None
        self._next_flip = 0.0
        self._lively = 3

    def _open(self, title: str, visible: bool) -> Any:
        glfw.ERROR_REPORTING = "ignore"
        if not glfw.init() or glfw.get_platform() == glfw.PLATFORM_NULL:
            raise OSError("no display for the viewer: start it in a graphical session")
        glfw.default_window_hints()
        for hint, value in (
            (glfw.CONTEXT_VERSION_MAJOR, 3),
            (glfw.CONTEXT_VERSION_MINOR, 3),
            (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
            (glfw.OPENGL_FORWARD_COMPAT, True),
            (glfw.VISIBLE, visible),
            (glfw.SCALE_TO_MONITOR, True),
        ):
            glfw.window_hint(hint, value)
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
        glfw.set_window_size_limits(window, 900, 600, glfw.DONT_CARE, glfw.DONT_CARE)
        return window

    def _content_scale(self) -> float:
        # macOS counts in points already; elsewhere GUI units are pixels.
        width, _ = glfw.get_window_size(self._handle)
        pixels, _ = glfw.get_framebuffer_size(self._handle)
        return float(glfw.get_window_content_scale(self._handle)[0]) if pixels == width else 1.0

    def _connect(self) -> None:
        """GLFW's events go to Dear ImGui."""
        io, window = imgui.get_io(), self._handle
        keys = {getattr(glfw, f"KEY_{k}"): getattr(imgui.Key, v) for k, v in _KEYS.items()}
        modifiers = {
            glfw.KEY_LEFT_CONTROL: imgui.Key.mod_ctrl,
            glfw.KEY_RIGHT_CONTROL: imgui.Key.mod_ctrl,
            glfw.KEY_LEFT_SHIFT: imgui.Key.mod_shift,
            glfw.KEY_RIGHT_SHIFT: imgui.Key.mod_shift,
        }

        def on_key(_: Any, key: int, __: int, action: int, ___: int) -> None:
            if action != glfw.REPEAT:
                if key in modifiers:
                    io.add_key_event(modifiers[key], action == glfw.PRESS)
                if key in keys:
                    io.add_key_event(keys[key], action == glfw.PRESS)
            if action != glfw.RELEASE:
                self._key(key)
            self._lively = 3

        def on_button(_: Any, button: int, action: int, __: int) -> None:
            if button < 3:
                io.add_mouse_button_event(button, action == glfw.PRESS)
            self._lively = 3

        def on_move(_: Any, x: float, y: float) -> None:
            io.add_mouse_pos_event(x, y)
            self._lively = max(self._lively, 2)

        def on_wheel(_: Any, x: float, y: float) -> None:
            io.add_mouse_wheel_event(x, y)
            self._lively = 3

        def on_character(_: Any, code: int) -> None:
            io.add_input_character(code)
            self._lively = 3

        def on_change(*_: Any) -> None:
            self._lively = 3

        glfw.set_key_callback(window, on_key)
        glfw.set_mouse_button_callback(window, on_button)
        glfw.set_cursor_pos_callback(window, on_move)
        glfw.set_scroll_callback(window, on_wheel)
        glfw.set_char_callback(window, on_character)
        glfw.set_framebuffer_size_callback(window, on_change)
        glfw.set_window_refresh_callback(window, on_change)
        glfw.set_window_focus_callback(window, lambda _, on: io.add_focus_event(bool(on)))

    def _key(self, key: int) -> None:
        """Keys that work wherever the mouse is, unless a number is being typed."""
        if imgui.get_io().want_text_input:
            return
        model = self.model
        if key == glfw.KEY_SPACE:
            self.state.playing = not self.state.playing
        elif key in (glfw.KEY_LEFT, glfw.KEY_RIGHT):
            model.step(1 if key == glfw.KEY_RIGHT else -1)
        elif key in (glfw.KEY_UP, glfw.KEY_DOWN):
            model.follow = None
            model.depth += 1e-4 if key == glfw.KEY_UP else -1e-4
        elif key in (glfw.KEY_HOME, glfw.KEY_END):
            model.index = 0 if key == glfw.KEY_HOME else len(model.numbers) - 1
        elif key == glfw.KEY_F:
            for pane in self.panes.values():
                pane.view.fit()
        elif key == glfw.KEY_S:
            controls.save(model, self.state, ".png")
        elif key in (glfw.KEY_1, glfw.KEY_2, glfw.KEY_3):
            model.look.mode = ("intensity", "log", "phase")[key - glfw.KEY_1]
        elif key in (glfw.KEY_ESCAPE, glfw.KEY_Q):
            glfw.set_window_should_close(self._handle, True)

    # --- the loop ---

    def run(self) -> None:
        """Until the window is closed."""
        try:
            while not glfw.window_should_close(self._handle):
                self.wait()
                self.draw()
        finally:
            self.close()

    def wait(self) -> None:
        """Sleep until there is something to do."""
        now = time.monotonic()
        if self.state.playing:
            if now < self._next_flip:
                glfw.wait_events_timeout(self._next_flip - now)
            else:
                glfw.poll_events()
            if self.state.playing and time.monotonic() >= self._next_flip:
                self._next_flip = max(self._next_flip, time.monotonic() - 0.2)
                self._next_flip += 1 / self.state.rate
                self.model.step(1)
            self._lively = 2
        elif self._lively > 0:
            glfw.poll_events()
        elif self._unsettled:
            glfw.wait_events_timeout(max(self._changed_at + REST - now, 0.001))
        else:
            glfw.wait_events_timeout(1.0)
        self._lively -= 1

    @property
    def _unsettled(self) -> bool:
        return self._measured != self._watched

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
        io.delta_time = max(now - getattr(self, "_drawn_at", now - 1 / 60), 1e-4)
        self._drawn_at = now
        imgui.backends.opengl3_new_frame()
        imgui.new_frame()
        self._layout(width, height, density)
        imgui.render()
        self.context.screen.use()
        self.context.viewport = (0, 0, pixels, rows)
        self.context.clear(*theme.BACKGROUND)
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        glfw.swap_buffers(self._handle)

    def _layout(self, width: float, height: float, density: float) -> None:
        scale = imgui.get_font_size() / 15
        side = SIDE * scale
        imgui.set_next_window_pos(imgui.ImVec2(0, 0))
        imgui.set_next_window_size(imgui.ImVec2(side, height))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_move
        bars = flags & ~imgui.WindowFlags_.no_scrollbar
        imgui.begin("controls", None, int(bars | imgui.WindowFlags_.no_nav))
        model, state, font = self.model, self.state, self._font
        controls.frames(model, state, font)
        controls.depth(model, state, font)
        controls.fourier_filter(model, font)
        controls.look(model, font)
        controls.figures(state, font)
        controls.saving(model, state)
        imgui.end()
        self._refresh()
        imgui.set_next_window_pos(imgui.ImVec2(side, 0))
        imgui.set_next_window_size(imgui.ImVec2(width - side, height))
        still = imgui.WindowFlags_.no_scroll_with_mouse | imgui.WindowFlags_.no_nav
        imgui.begin("pictures", None, int(flags | still))
        free = imgui.get_content_region_avail()
        gap = 8 * scale
        line = imgui.get_text_line_height() + gap
        tall = free.y - line - gap
        high = tall * 0.64
        self._reconstruction((free.x, high), density)
        imgui.dummy(imgui.ImVec2(0, max(gap - 2 * imgui.get_style().item_spacing.y, 0)))
        half = (free.x - gap) / 2
        for name in ("Hologram", "Fourier plane"):
            pane = self.panes[name]
            white = self._fourier_white if name == "Fourier plane" else 1.0
            pane.finish(pane.show((half, tall - high), _LOOKS[name], white, density))
            if name == "Hologram":
                imgui.same_line(0, gap)
        imgui.text_disabled(self._status())
        imgui.end()

    def _refresh(self) -> None:
        """Bring the canvases up to the model: coarse while it moves, full when it rests."""
        model, state = self.model, self.state
        watched = (model.field_key, model.depth)
        if watched != self._watched:
            self._watched = watched
            self._changed_at = time.monotonic()
            rested = False
        else:
            rested = time.monotonic() - self._changed_at >= REST
        start = time.perf_counter()
        picture = model.picture(coarse=not rested)
        canvas = self.panes["Reconstruction"].canvas
        key = (watched, picture.coarse)
        if canvas.upload(picture.field, key):
            state.spent["coarse picture" if picture.coarse else "full picture"] = (
                time.perf_counter() - start
            )
        self._white = picture.white
        self.panes["Hologram"].canvas.upload(model.hologram(), model.frame_key)
        fourier = self.panes["Fourier plane"].canvas
        spectrum = model.fourier_plane()
        if fourier.upload(spectrum, model.frame_key):
            # The bias is decades above the rest: white is found beside the axes.
            self._fourier_white = 30 * float((abs(spectrum[3::7, 5::7]) ** 2).mean() + 1e-30)
        if self._masked is not model.filter:
            self._masked = model.filter
            fourier.upload_mask(model.system.transmission())
        if rested and self._measured != watched:
            self._measured = watched
            state.figures = model.figures()
            self._lively = max(self._lively, 2)

    _white = 1.0
    _fourier_white = 1.0

    def _reconstruction(self, size: tuple[float, float], density: float) -> None:
        model = self.model
        pane = self.panes["Reconstruction"]
        drawn = pane.show(size, model.look, self._white, density, f"at {model.depth * 1e3:.2f} mm")
        self._scale_bar(pane, drawn)
        if self._aim is not None:
            self._mark(pane, drawn, self._aim)
        pane.finish(drawn)
        if pane.clicked is not None:
            self._aim = pane.clicked
            start = time.perf_counter()
            found = model.autofocus(*pane.clicked)
            if found.focused:
                model.follow = None
            self.state.spent["autofocus"] = time.perf_counter() - start
            self.state.say(
                f"focused at {found.depth * 1e3:.2f} mm"
                if found.focused
                else "nothing comes into focus there"
            )
            self._lively = 3

    def _mark(self, pane: Pane, drawn: Any, pixel: tuple[int, int]) -> None:
        """Corners around the region that was focused on."""
        from reconstruct.viewer.model import REGION

        half = REGION / self.model.video.slm.pixel_pitch
        low = pane.screen_point(pixel[0] - half, pixel[1] - half)
        high = pane.screen_point(pixel[0] + half, pixel[1] + half)
        arm = min(10.0, (high.x - low.x) / 3)
        line = colour(0.36, 0.80, 0.52)
        for x, dx in ((low.x, arm), (high.x, -arm)):
            for y, dy in ((low.y, arm), (high.y, -arm)):
                drawn.add_line(imgui.ImVec2(x, y), imgui.ImVec2(x + dx, y), line, 1.5)
                drawn.add_line(imgui.ImVec2(x, y), imgui.ImVec2(x, y + dy), line, 1.5)

    def _scale_bar(self, pane: Pane, drawn: Any) -> None:
        """A length that is round and about a fifth of the picture."""
        per_metre = pane.view.scale / self.model.video.slm.pixel_pitch
        room = pane.view.screen_width / 5 / per_metre
        length = max(
            (m * 10.0**e for e in range(-7, 1) for m in (1, 2, 5) if m * 10.0**e <= room),
            default=room,
        )
        x = pane.origin[0] + 16
        y = pane.origin[1] + pane.view.screen_height - 18
        white = colour(0.9, 0.93, 0.91)
        low, high = imgui.ImVec2(x, y), imgui.ImVec2(x + length * per_metre, y + 3)
        drawn.add_rect_filled(low, high, white)
        words = f"{length * 1e3:g} mm" if length >= 1e-3 else f"{length * 1e6:g} µm"
        drawn.add_text(imgui.ImVec2(x, y - imgui.get_font_size() - 4), white, words)

    def _status(self) -> str:
        """What is under the cursor, or what hands can do."""
        model = self.model
        if time.monotonic() < self.state.message_until:
            return self.state.message
        for name, pane in self.panes.items():
            if pane.hover is None:
                continue
            row, column = pane.hover
            zoom = f"{pane.view.scale:.2g}:1"
            if name == "Fourier plane":
                shape = model.video.slm.shape
                y, x = model.system.fourier_coordinates()
                at = [(i - n // 2) % n for i, n in zip((row, column), shape, strict=True)]
                return f"{name}  {x[at[1]] * 1e3:+.3f}, {y[at[0]] * 1e3:+.3f} mm   {zoom}"
            x_, y_ = model.position_of(row, column)
            place = f"{name}  row {row}, column {column}   x {x_ * 1e3:+.3f}, y {y_ * 1e3:+.3f} mm"
            if name == "Hologram":
                return f"{place}   grey {model.hologram()[row, column]}   {zoom}"
            value = abs(model.picture(coarse=True).field[row, column]) ** 2
            return f"{place}   intensity {value:.4g}   {zoom}"
        return "click: focus there   wheel: zoom   drag: move   F: fit   arrows: frame, depth"

    def close(self) -> None:
        """Give everything back."""
        with contextlib.suppress(Exception):
            imgui.backends.opengl3_shutdown()
        imgui.destroy_context()
        glfw.destroy_window(self._handle)
        glfw.terminate()


def view(video: Video) -> None:
    """Open the viewer on a video and return when it is closed."""
    ViewerWindow(video).run()
