"""Which face is nearest at each pixel, and how far: triangles drawn off screen by OpenGL.

The context lives in a thread of its own, so that a scene can be asked from any thread and never
takes another window's context away.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.gl_context import headless_context, make_program

_VERTEX = """
#version 330
in vec3 place;
void main() { gl_Position = vec4(place, 1.0); }
"""
_FRAGMENT = """
#version 330
out int face;
void main() { face = gl_PrimitiveID; }
"""
SLACK = 2e-6
"""Of the normalised depth: rounding of single-precision corners."""


class ZBuffer:
    """Draws one set of triangles, again for each frame.

    faces : (F, 3) vertex indices
    """

    def __init__(self, faces: NDArray[np.intp]) -> None:
        self._faces = np.ascontiguousarray(faces, dtype=np.uint32)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="z-buffer")
        self._parts: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return ZBuffer, (self._faces,)  # another process has a thread and a context of its own

    def draw(
        self, place: NDArray[np.float64], shape: tuple[int, int]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Nearest depth and face of each pixel.

        place : (V, 3) x, y and depth, each −1 … 1 over the picture (y down, depth away)
        shape : (H, W)

        Returns (H, W) depths in −1 … 1 (1 where nothing is) and (H, W) faces (−1 there). A depth
        is pushed back by what the face's slope changes over one pixel, so that a point of the
        face nowhere lies behind it.
        """
        return self._thread.submit(self._draw, place, shape).result()

    def _draw(
        self, place: NDArray[np.float64], shape: tuple[int, int]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        import moderngl

        height, width = shape
        if not self._parts:
            self._parts["context"] = context = headless_context()
            self._parts["program"] = make_program(context, _VERTEX, _FRAGMENT)
            self._parts["index"] = context.buffer(self._faces)
        context, program = self._parts["context"], self._parts["program"]
        largest = context.info["GL_MAX_TEXTURE_SIZE"]
        if max(shape) > largest:
            raise ValueError(f"a picture of {width} × {height} exceeds OpenGL's {largest} pixels")
        if shape not in self._parts:
            self._parts[shape] = context.framebuffer(
                context.texture((width, height), 1, dtype="i4"),
                context.depth_texture((width, height)),
            )
        target = self._parts[shape]
        corners = context.buffer(np.ascontiguousarray(place, dtype=np.float32))
        triangles = context.vertex_array(program, [(corners, "3f", "place")], self._parts["index"])
        target.use()
        context.enable_only(moderngl.DEPTH_TEST)
        context.polygon_offset = (1.0, 1.0)
        target.clear(depth=1.0)
        triangles.render()
        # OpenGL's rows run up; place's y grows with them, so row 0 is the least y.
        face = np.frombuffer(target.color_attachments[0].read(), np.int32).reshape(shape)
        depth = np.frombuffer(target.depth_attachment.read(), np.float32).reshape(shape)
        triangles.release()
        corners.release()
        return 2 * depth - 1, np.where(depth < 1, face, -1).astype(np.int32)
