"""OpenGL contexts and programs, made in one way for all that draws, on a window or off screen."""

import sys
from typing import TYPE_CHECKING, Any

from chrmc.interrupts import interrupts_wait

if TYPE_CHECKING:
    import moderngl


def window_hints(glfw: Any) -> None:
    """Ask GLFW for windows with an OpenGL 3.3 context."""
    for hint, value in (
        (glfw.CONTEXT_VERSION_MAJOR, 3),
        (glfw.CONTEXT_VERSION_MINOR, 3),
        (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
        (glfw.OPENGL_FORWARD_COMPAT, True),
    ):
        glfw.window_hint(hint, value)


def window_context() -> "moderngl.Context":
    """The OpenGL 3.3 context of the window that is current in this thread."""
    import moderngl

    return moderngl.create_context(require=330)


def headless_context() -> "moderngl.Context":
    """An OpenGL 3.3 context without any window; OSError that names what to install."""
    import moderngl

    try:
        backend: dict[str, Any] = {"backend": "egl"} if sys.platform.startswith("linux") else {}
        return moderngl.create_context(standalone=True, require=330, **backend)
    except Exception as error:  # moderngl raises plain Exception
        raise OSError(
            f"no headless OpenGL through EGL ({str(error).strip() or type(error).__name__}): on "
            "Debian or Ubuntu install the packages libegl1, libgl1 and libgl1-mesa-dri"
        ) from error


def make_program(context: "moderngl.Context", vertex: str, fragment: str) -> "moderngl.Program":
    """The shaders as a program of this context."""
    with interrupts_wait():  # moderngl's C code calls Python for every uniform
        return context.program(vertex_shader=vertex, fragment_shader=fragment)
