"""An OpenGL context without a window: made in one way for everything that draws off screen."""

import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import moderngl


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
