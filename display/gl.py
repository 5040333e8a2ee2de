"""Drawing one 8-bit frame, pixel for pixel, on whatever OpenGL framebuffer is bound.

The window and the headless surface share this code. Exactness rests on four things: the texture
is unsigned-normalised 8 bit, texels are fetched by integer index, dithering and blending are off,
and GL_FRAMEBUFFER_SRGB is never enabled.
"""

from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from chrmc.gl_context import headless_context, make_program

CHANNELS = {
    "all": (1.0, 1.0, 1.0),
    "red": (1.0, 0.0, 0.0),
    "green": (0.0, 1.0, 0.0),
    "blue": (0.0, 0.0, 1.0),
}
CORNERS = ("top-left", "top-right", "bottom-left", "bottom-right")

_VERTEX = """
#version 330
void main() {  // one triangle that covers the viewport
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
"""
_FRAGMENT = """
#version 330
uniform sampler2D frame;
uniform ivec2 viewport;   // pixels drawn to
uniform ivec2 corner;     // of the viewport, from the framebuffer's lower left
uniform vec3 channels;
uniform ivec4 square;     // x0, y0, x1, y1 of the trigger in frame pixels, y down
uniform float square_level;
out vec4 colour;

vec3 average(vec2 middle, vec2 ratio) {
    // Raised cosine, three of the preview's pixels wide: what is finer than 1.5 of them is taken
    // down to 3 per cent, where a plain mean over one pixel leaves 20.
    vec2 reach = 1.5 * ratio;
    ivec2 first = ivec2(max(ceil(middle - reach - 0.5), 0.0));
    ivec2 last = min(ivec2(floor(middle + reach - 0.5)), textureSize(frame, 0) - 1);
    vec3 sum = vec3(0.0);
    float weight = 0.0;
    for (int y = first.y; y <= last.y; y++)
        for (int x = first.x; x <= last.x; x++) {
            vec2 away = (vec2(x, y) + 0.5 - middle) / reach;
            vec2 part = 1.0 + cos(3.14159265 * away);
            sum += part.x * part.y * texelFetch(frame, ivec2(x, y), 0).rgb;
            weight += part.x * part.y;
        }
    return sum / weight;
}

void main() {
    ivec2 size = textureSize(frame, 0);
    ivec2 to = ivec2(gl_FragCoord.xy) - corner;
    to.y = viewport.y - 1 - to.y;         // rows run down, OpenGL's run up
    ivec2 at = (to * size) / viewport;    // integers: the identity at 1:1
    vec3 level;
    if (viewport.x < size.x || viewport.y < size.y) {
        // Smaller than the frame: single samples of fringes would show fringes that are not there.
        vec2 ratio = vec2(size) / vec2(viewport);
        level = average((vec2(to) + 0.5) * ratio, ratio);
    } else
        level = texelFetch(frame, at, 0).rgb;
    if (at.x >= square.x && at.y >= square.y && at.x < square.z && at.y < square.w)
        level = vec3(square_level);
    colour = vec4(level * channels, 1.0);
}
"""
_DITHER = 0x0BD0


@dataclass(frozen=True)
class Trigger:
    """A square in a corner that toggles with every new frame, for a photodiode.

    corner : one of CORNERS; size : side in pixels
    """

    corner: str = "bottom-right"
    size: int = 40

    def __post_init__(self) -> None:
        if self.corner not in CORNERS:
            raise ValueError(
                f"no corner called {self.corner!r}: choose one of {', '.join(CORNERS)}"
            )
        if self.size < 1:
            raise ValueError(f"a trigger square needs at least 1 pixel, not {self.size}")

    def box(self, shape: tuple[int, int]) -> tuple[int, int, int, int]:
        """x0, y0, x1, y1 in frame pixels on a (rows, columns) frame."""
        rows, columns = shape
        side = min(self.size, rows, columns)
        x0 = 0 if self.corner.endswith("left") else columns - side
        y0 = 0 if self.corner.startswith("top") else rows - side
        return x0, y0, x0 + side, y0 + side


class Painter:
    """Draws frames of one shape in the current OpenGL context.

    context : moderngl context
    shape : (rows, columns) of the frames
    channel : "all" for grey, or the one colour channel that the panel shows
    trigger : corner square, or None
    """

    def __init__(
        self,
        context: moderngl.Context,
        shape: tuple[int, int],
        channel: str = "all",
        trigger: Trigger | None = None,
    ) -> None:
        if channel not in CHANNELS:
            raise ValueError(f"no channel {channel!r}: choose one of {', '.join(CHANNELS)}")
        largest = context.info["GL_MAX_TEXTURE_SIZE"]
        if max(shape) > largest:
            raise ValueError(f"{shape[1]} × {shape[0]} exceeds this GPU's {largest} pixels")
        self.context = context
        self.shape = shape
        self.channel = channel
        self.trigger = trigger
        context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        context.disable_direct(_DITHER)
        self._program = make_program(context, _VERTEX, _FRAGMENT)
        self._triangle = context.vertex_array(self._program, [])
        self._textures: dict[int, moderngl.Texture] = {}
        self._texture = self._texture_of(1)
        self._program["channels"] = CHANNELS[channel]
        self._program["square"] = trigger.box(shape) if trigger else (0, 0, 0, 0)

    def _texture_of(self, components: int) -> moderngl.Texture:
        """Room on the GPU for grey or colour frames, made when first needed."""
        if components not in self._textures:
            rows, columns = self.shape
            texture = self.context.texture((columns, rows), components, dtype="f1", alignment=1)
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
            if components == 1:
                texture.swizzle = "RRR1"
            self._textures[components] = texture
        return self._textures[components]

    def upload(self, levels: NDArray[np.uint8]) -> None:
        """Make a frame, (rows, columns) or (rows, columns, 3) uint8, the one that `draw` draws."""
        whole = levels.shape in (self.shape, (*self.shape, 3))
        if not whole or levels.dtype != np.uint8:
            raise ValueError(
                f"frame is {levels.dtype} {levels.shape}; this panel takes uint8 {self.shape}"
            )
        self._texture = self._texture_of(1 if levels.ndim == 2 else 3)
        self._texture.write(np.ascontiguousarray(levels))

    def draw(self, size: tuple[int, int], square_on: bool = False) -> None:
        """Draw onto the bound framebuffer of `size` (width, height).

        Pixel for pixel where the sizes agree. Else as large as fits at the frame's own aspect, on
        black: enlarged by repeating pixels, made smaller by averaging neighbourhoods.
        """
        part = fitted(size, self.shape)
        corner = (size[0] - part[0]) // 2, (size[1] - part[1]) // 2
        if part != size:
            self.context.clear()
        self.context.viewport = (*corner, *part)
        self._program["viewport"] = part
        self._program["corner"] = corner
        self._program["square_level"] = float(square_on)
        self._texture.use(0)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def expected(self, levels: NDArray[np.uint8], square_on: bool = False) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes that a 1:1 framebuffer must hold after `draw`."""
        picture = levels.copy() if levels.ndim == 3 else levels[:, :, None].repeat(3, axis=2)
        if self.trigger:
            x0, y0, x1, y1 = self.trigger.box(self.shape)
            picture[y0:y1, x0:x1] = 255 if square_on else 0
        mask = np.array(CHANNELS[self.channel], dtype=np.uint8)
        return picture * mask

    def check(self) -> None:
        """OSError when OpenGL reports any error, a lost context among them."""
        error = self.context.error
        if error != "GL_NO_ERROR":
            raise OSError(f"OpenGL reports {error}: the graphics context is lost or broken")

    def release(self) -> None:
        """Free what this holds on the GPU."""
        held: list[Any] = [self._triangle, *self._textures.values(), self._program]
        for obj in held:
            obj.release()


def fitted(size: tuple[int, int], shape: tuple[int, int]) -> tuple[int, int]:
    """(width, height) of the largest picture of `shape`'s aspect in a window of `size`."""
    rows, columns = shape
    share = min(size[0] / columns, size[1] / rows)
    return max(1, round(columns * share)), max(1, round(rows * share))


def read_back(framebuffer: Any, size: tuple[int, int]) -> NDArray[np.uint8]:
    """(height, width, 3) bytes of a framebuffer, first row on top."""
    raw = framebuffer.read(viewport=(0, 0, *size), components=3, alignment=1)
    return np.frombuffer(raw, dtype=np.uint8).reshape(size[1], size[0], 3)[::-1]


class Offscreen:
    """A headless surface: frames are drawn into an offscreen framebuffer.

    It has no refresh of its own (`vsync` is False), so flips come as fast as frames do unless the
    player is given a rate.
    """

    vsync = False
    reported_refresh = 0.0
    name = "headless (EGL)"
    place = cover = ""
    window_manager = ""
    monitor = None

    def __init__(self, shape: tuple[int, int]) -> None:
        self.size = (shape[1], shape[0])
        self.context = headless_context()
        self._buffer = self.context.simple_framebuffer(self.size, components=4, dtype="f1")
        self._buffer.use()
        self.notes = [f"headless through {self.context.info['GL_RENDERER']}"]

    def bind(self) -> None:
        """Make this the target of what follows in the calling thread."""
        self.context.__enter__()
        self._buffer.use()

    def unbind(self) -> None:
        """Let another thread `bind` it."""
        self.context.__exit__(None, None, None)

    def poll(self) -> None:
        """No events."""

    def finish(self) -> None:
        """Wait until the frame is drawn."""
        self.context.finish()

    def flip(self) -> None:
        """What a screen's flip does: return once the frame is there."""
        self.context.finish()

    def pressed(self) -> list[str]:
        """No keyboard."""
        return []

    @property
    def closed(self) -> bool:
        """Never closed by anyone else."""
        return False

    def read(self) -> NDArray[np.uint8]:
        """(rows, columns, 3) bytes drawn."""
        return read_back(self._buffer, self.size)

    def grab(self) -> NDArray[np.uint8]:
        """What is drawn is what would be shown."""
        return self.read()

    def close(self) -> None:
        """Free the context."""
        self._buffer.release()
        self.context.release()
