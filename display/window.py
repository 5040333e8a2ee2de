"""A window on a monitor, full screen or as a preview, that frames are flipped to."""

import contextlib
import ctypes
import queue
import subprocess
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.gl_context import window_context, window_hints
from chrmc.slm import SLM
from display.monitors import Monitor, choose, glfw_ready, last_error, list_monitors, same
from display.placement import box_of, in_place, open_on
from display.x11 import desktop

_KEYS = ("escape", "space", "left", "right", "home", "end", "page_up", "page_down", "enter", "l")
_DIGITS = tuple("0123456789")
_LOOK_EVERY = 0.05  # seconds between looks at the window's place
_ASK_EVERY = 0.25  # seconds between questions to the monitor
_BACK, _PACK_ALIGNMENT, _RGB, _UNSIGNED_BYTE = 0x0405, 0x0D05, 0x1907, 0x1401


class Window:
    """A GLFW window with an OpenGL 3.3 context.

    slm : whose pixels are shown
    monitor : name, part of a name or index; None takes the one that fits the SLM
    windowed : a preview on the desktop, scaled down where the SLM does not fit
    vsync : wait for the monitor's refresh at every flip

    Full screen: on that monitor, cursor hidden, not minimised when the focus goes, the desktop's
    gamma ramp replaced by the identity until `close`. `notes` says in words what was set and what
    this platform would not do. `place` says whether the window was where it belongs when last
    looked at (20 times a second): "ok", "moved", "covered", "hidden", "unknown" (Wayland does not
    say), or "" for a preview. GLFW holds screen savers off on X11 and Windows while a full-screen
    window is open; on macOS `caffeinate` does.

    Create and close it in the main thread; `flip` may run in another after `bind` there.
    """

    def __init__(
        self,
        slm: SLM,
        monitor: str | None = None,
        windowed: bool = False,
        vsync: bool = True,
        title: str = "chrmc",
    ) -> None:
        self._glfw = glfw = glfw_ready()
        self.monitor: Monitor = choose(list_monitors(), monitor, slm, any_size=windowed)
        self.vsync = vsync
        self.reported_refresh = self.monitor.refresh
        self.name = self.monitor.title
        self.notes: list[str] = []
        self._handle = glfw.get_monitors()[self.monitor.index]
        self._pressed: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._names = {getattr(glfw, f"KEY_{n.upper()}"): n for n in (*_KEYS, "q", *_DIGITS)} | {
            getattr(glfw, f"KEY_KP_{n.upper()}"): n for n in ("enter", *_DIGITS)
        }
        self._trouble = ""
        self._ramp: Any = None
        self._awake: subprocess.Popen[bytes] | None = None
        self._desktop = desktop() if glfw.get_platform() == glfw.PLATFORM_X11 else None
        self.window_manager = self._desktop.window_manager() if self._desktop else ""
        self._box = None if windowed else box_of(self.monitor)
        self.place, self.cover = "", ""
        self._looked = self._asked = 0.0
        self._window: Any = None
        try:
            self._window = self._open(slm, windowed, title)
            self._prepare(slm, windowed)
        except BaseException:
            self.close()
            raise

    def _open(self, slm: SLM, windowed: bool, title: str) -> Any:
        glfw, screen = self._glfw, self.monitor
        glfw.default_window_hints()
        window_hints(glfw)
        for hint, value in (
            (glfw.CONTEXT_ROBUSTNESS, glfw.LOSE_CONTEXT_ON_RESET),
            (glfw.RED_BITS, 8),
            (glfw.GREEN_BITS, 8),
            (glfw.BLUE_BITS, 8),
            (glfw.SRGB_CAPABLE, False),
            (glfw.SAMPLES, 0),
            (glfw.SCALE_TO_MONITOR, False),
            (glfw.AUTO_ICONIFY, False),
            (glfw.CENTER_CURSOR, False),
        ):
            glfw.window_hint(hint, value)
        for name in (glfw.X11_CLASS_NAME, glfw.X11_INSTANCE_NAME):  # GLFW wants both or neither
            glfw.window_hint_string(name, "chrmc")
        if windowed:
            _, _, width, height = glfw.get_monitor_workarea(self._handle)
            share = min(1.0, width / slm.width, height / slm.height)
            size = (max(1, int(slm.width * share)), max(1, int(slm.height * share)))
            if share < 1:
                self.notes.append(f"preview at {share:.0%} of the size: not pixel for pixel")
            window = glfw.create_window(*size, title, None, None)
        else:
            window, note = open_on(glfw, screen, self._handle, title, self._desktop)
            if note:
                self.notes.append("warning: " + note)
            if self._desktop is not None and self._desktop.compositing():
                self.notes.append(
                    f"{self.window_manager} composes the desktop: it may show frames later than "
                    "their flips; for exact times turn its compositing off"
                )
        if not window:
            raise OSError(
                f"no OpenGL window on monitor {screen.title!r} ({last_error(glfw)}): a driver with "
                "OpenGL 3.3 is needed (on Debian or Ubuntu libgl1-mesa-dri), or use --headless"
            )
        return window

    def _prepare(self, slm: SLM, windowed: bool) -> None:
        glfw, window = self._glfw, self._window
        glfw.make_context_current(window)
        glfw.swap_interval(1 if self.vsync else 0)
        self.context = window_context()
        self.size = tuple(glfw.get_framebuffer_size(window))
        if not windowed:
            glfw.set_input_mode(window, glfw.CURSOR, glfw.CURSOR_HIDDEN)
            self._check_size(slm)
            self._reset_gamma()
            self._stay_awake()
            self._look_around()
        glfw.set_key_callback(window, self._on_key)
        glfw.set_framebuffer_size_callback(window, self._on_size)
        # Through ctypes, which lets other threads run while a flip is waited for; and moderngl
        # does not read a window's back buffer.
        self._finish = self._gl("glFinish")
        self._read_buffer = self._gl("glReadBuffer", ctypes.c_uint)
        self._pixel_store = self._gl("glPixelStorei", ctypes.c_uint, ctypes.c_int)
        self._read_pixels = self._gl(
            "glReadPixels", *[ctypes.c_int] * 4, ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p
        )

    def _gl(self, name: str, *types: Any) -> Any:
        """An OpenGL function of this context."""
        address = self._glfw.get_proc_address(name)
        if not address:
            raise OSError(f"this OpenGL driver has no {name}")
        return ctypes.CFUNCTYPE(None, *types)(address)

    def _check_size(self, slm: SLM) -> None:
        if self.size != (slm.width, slm.height):
            scale = (
                ""
                if self.monitor.scale == (1.0, 1.0)
                else (f" (the desktop scales by {self.monitor.scale[0]:g})")
            )
            raise ValueError(
                f"monitor {self.monitor.title!r} gives a framebuffer of {self.size[0]} × "
                f"{self.size[1]} for {slm.width} × {slm.height} pixels{scale}: set its scaling to "
                "100 %"
            )

    def _reset_gamma(self) -> None:
        glfw = self._glfw
        ramp: Any = None
        with contextlib.suppress(ValueError):  # a null pointer: the platform has none to give
            ramp = glfw.get_gamma_ramp(self._handle)
        entries = len(ramp.red) if ramp else 0
        if entries < 2:
            self.notes.append("this platform does not let the desktop's gamma ramp be reset")
            return
        straight = (np.arange(entries) / (entries - 1)).tolist()
        if all(
            abs(value - want) < 0.002
            for channel in ramp
            for value, want in zip(channel, straight, strict=True)
        ):
            self.notes.append("desktop gamma ramp is the identity already")
            return
        self._ramp = ramp
        glfw.get_error()
        glfw.set_gamma_ramp(self._handle, (straight, straight, straight))
        code, _ = glfw.get_error()
        if code:
            self._ramp = None
            self.notes.append("this platform does not let the desktop's gamma ramp be reset")
        else:
            self.notes.append("desktop gamma ramp reset to the identity while playing")

    def _stay_awake(self) -> None:
        if sys.platform == "darwin":
            with contextlib.suppress(OSError):
                self._awake = subprocess.Popen(["caffeinate", "-d"])
        elif self._glfw.get_platform() == self._glfw.PLATFORM_WAYLAND:
            self.notes.append("Wayland: hold the screen saver off in the desktop's settings")

    def _on_key(self, _window: Any, key: int, _scan: int, action: int, _mods: int) -> None:
        if action != self._glfw.RELEASE and key in self._names:
            self._pressed.put(self._names[key])

    def _on_size(self, _window: Any, width: int, height: int) -> None:
        self.size = (width, height)

    def bind(self) -> None:
        """Make this window the target of what follows in the calling thread."""
        self._glfw.make_context_current(self._window)
        self._glfw.swap_interval(1 if self.vsync else 0)

    def unbind(self) -> None:
        """Let another thread `bind` it."""
        self._glfw.make_context_current(None)

    def finish(self) -> None:
        """Wait until the frame is drawn, not yet shown."""
        self._finish()

    def flip(self) -> None:
        """Show what was drawn, and return once it is shown.

        Raises OSError when the monitor was taken away or changed its mode.
        """
        if self._trouble:
            raise OSError(self._trouble)
        self._glfw.swap_buffers(self._window)
        self._finish()

    def poll(self) -> None:
        """Take in key presses, what became of the monitor, and where the window is.

        In the thread that opened it only.
        """
        self._glfw.poll_events()
        now = time.monotonic()
        if now - self._asked >= _ASK_EVERY and not self._trouble:
            self._asked = now
            self._ask_monitor()
        if self._box is not None and now - self._looked >= _LOOK_EVERY and not self._trouble:
            self._looked = now
            self._look()

    def _ask_monitor(self) -> None:
        glfw, monitor = self._glfw, self.monitor
        if not any(same(m, self._handle) for m in glfw.get_monitors()):
            self._trouble = f"monitor {monitor.title!r} was disconnected"
        elif self._box is not None:
            size = tuple(glfw.get_video_mode(self._handle).size)
            place = tuple(glfw.get_monitor_pos(self._handle))
            if (*place, *size) != self._box:
                self._trouble = (
                    f"monitor {monitor.title!r} changed from {monitor.width} × {monitor.height} at "
                    f"({monitor.x}, {monitor.y}) to {size[0]} × {size[1]} at {place} while playing"
                )

    def _look(self) -> None:
        """Whether the window still is where it was put, with nothing over it."""
        glfw = self._glfw
        self.place = "ok" if in_place(glfw, self._window, self.monitor) else "moved"
        if self._desktop is None:
            if self.place == "ok" and glfw.get_platform() == glfw.PLATFORM_WAYLAND:
                self.place = "unknown"
            if glfw.get_window_attrib(self._window, glfw.ICONIFIED):
                self.place = "hidden"
            return
        if self.place == "ok" and self._box is not None:
            over = self._desktop.covered_by(glfw.get_x11_window(self._window), self._box)
            self.place = "hidden" if over is None else "covered" if over else "ok"
            self.cover = over or ""

    def _look_around(self) -> None:
        """Look until nothing lies over the window, or for a second; a note where something does."""
        end = time.monotonic() + 1.0
        self._look()
        while self.place not in ("ok", "unknown") and time.monotonic() < end:
            self._glfw.poll_events()
            time.sleep(0.02)
            self._look()
        if self.place not in ("ok", "unknown"):
            by = f" by {self.cover!r}" if self.cover else ""
            self.notes.append(f"warning: the panel is {self.place}{by}: what it shows is not whole")

    def grab(self) -> NDArray[np.uint8]:
        """(height, width, 3) bytes that the monitor's part of the desktop shows; X11 only."""
        if self._desktop is None or self._box is None:
            raise OSError("only X11 lets a program read what a full-screen window's monitor shows")
        return self._desktop.grab(self._box)

    def pressed(self) -> list[str]:
        """Keys pressed since the last call, such as "space" or "7"."""
        pressed = []
        while not self._pressed.empty():
            pressed.append(self._pressed.get())
        return pressed

    @property
    def closed(self) -> bool:
        """Whether the user closed the window."""
        return bool(self._glfw.window_should_close(self._window))

    def read(self) -> NDArray[np.uint8]:
        """(height, width, 3) bytes drawn and not yet flipped."""
        width, height = self.size
        picture = np.empty((height, width, 3), dtype=np.uint8)
        self._read_buffer(_BACK)
        self._pixel_store(_PACK_ALIGNMENT, 1)
        self._read_pixels(0, 0, width, height, _RGB, _UNSIGNED_BYTE, picture.ctypes.data)
        return picture[::-1]

    def close(self) -> None:
        """Put the gamma ramp back and close the window."""
        if self._ramp is not None and not self._trouble:
            self._glfw.set_gamma_ramp(self._handle, self._ramp)
            self._ramp = None
        if self._awake is not None:
            self._awake.terminate()
            self._awake.wait()
            self._awake = None
        if self._window:
            self._glfw.destroy_window(self._window)
            self._window = None
