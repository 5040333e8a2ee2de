"""Pictures on the graphics card: uploaded once, drawn with any zoom, pan and look."""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from chrmc.gl_context import make_program
from reconstruct.viewer.shade import DECADES, DIVERGING, ENTRIES, MODES, Look, colour_table
from reconstruct.viewer.view import Rectangle, View

KINDS = ("complex", "power", "signed", "grey")
"""(h, w) complex64; float32 intensity; float32 difference of intensities; uint8 grey levels."""

_VERTEX = """
#version 330
void main() {  // one triangle that covers the viewport
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
"""
_FRAGMENT = """
// kind: as KINDS; mode: 0 intensity, 1 log, 2 phase; masked: show what is blocked
// glowing: show the lasers' colours
uniform sampler2D data;    // complex amplitude, or a value in red
uniform sampler2D mask;    // what passes, 1, and what is blocked, 0
uniform sampler2D table;   // colours from dark to bright
uniform sampler2D glow;    // colours of several lasers, linear
uniform float white, gamma, zoom;
uniform vec2 centre, screen;
uniform vec4 covers;       // the data's rectangle in the picture: left, top, width, height
out vec4 colour;

vec3 tinted(float v) {
    return texture(table, vec2((v * float(ENTRIES - 1) + 0.5) / float(ENTRIES), 0.5)).rgb;
}
void main() {
    ivec2 size = textureSize(data, 0);
    vec2 step = vec2(size) / covers.zw;  // samples per pixel of the picture
    vec2 p = (centre + (gl_FragCoord.xy - screen / 2.0) / zoom - covers.xy) * step;
    if (any(lessThan(p, vec2(0))) || any(greaterThanEqual(p, vec2(size)))) {
        colour = vec4(0.055, 0.062, 0.075, 1.0);
        return;
    }
    // Zoomed out, a screen pixel shows the mean over what it covers.
    vec2 wide = step / zoom;
    ivec2 n = clamp(ivec2(ceil(wide - 0.01)), ivec2(1), ivec2(8));
    vec2 spread = wide * vec2(greaterThan(n, ivec2(1)));
    float light = 0.0;
    vec3 glows = vec3(0.0);
    for (int j = 0; j < n.y; ++j)
        for (int i = 0; i < n.x; ++i) {
            vec2 q = p + ((vec2(i, j) + 0.5) / vec2(n) - 0.5) * spread;
            ivec2 at = ivec2(clamp(q, vec2(0), vec2(size) - 0.5));
            vec2 v = texelFetch(data, at, 0).rg;
            if (glowing == 1) glows += texelFetch(glow, at, 0).rgb;
            light += kind == 0 ? dot(v, v) : v.r;
        }
    light /= float(n.x * n.y);
    vec3 shown;
    if (glowing == 1) {
        shown = clamp(pow(glows / float(n.x * n.y) / white, vec3(1.0 / gamma)), 0.0, 1.0);
    } else if (kind == 3) {
        shown = vec3(light);
    } else if (kind == 2) {
        shown = tinted(clamp(0.5 + 0.5 * light / white, 0, 1));
    } else if (mode == 1) {
        shown = tinted(clamp(1.0 + log(max(light / white, 1e-30)) / log(10.0) / DECADES, 0, 1));
    } else {
        float level = clamp(pow(light / white, 1.0 / gamma), 0, 1);
        if (mode == 2 && kind == 0) {
            vec2 here = texelFetch(data, ivec2(p), 0).rg;
            float turn = dot(here, here) > 0.0 ? atan(here.y, here.x) / 6.283185307179586 : 0.0;
            vec3 hue = turn - vec3(0.0, 1.0, -1.0) / 3.0;
            shown = clamp(2.0 - abs(6.0 * (hue - round(hue))), 0.0, 1.0) * sqrt(level);
        } else {
            shown = tinted(level);
        }
    }
    if (masked == 1) {
        float passed = texture(mask, p / vec2(size)).r;
        shown = mix(vec3(0.30, 0.04, 0.06) + 0.35 * shown, shown, passed);
    }
    colour = vec4(shown, 1.0);
}
"""


class Canvas:
    """One picture and the framebuffer it is drawn to, redrawn only when something changed.

    context : the window's moderngl context, current in this thread
    kind : one of KINDS
    """

    def __init__(self, context: moderngl.Context, kind: str) -> None:
        self.context = context
        self.kind = kind
        self._programs: dict[tuple[int, ...], tuple[Any, Any]] = {}
        self._tables: dict[str, Any] = {}
        self._data: moderngl.Texture | None = None
        self._glow: moderngl.Texture | None = None
        self._covers: Rectangle = (0.0, 0.0, 1.0, 1.0)
        self._mask = context.texture((1, 1), 1, b"\xff", alignment=1)
        self._masked = False
        self._target: Any = None
        self._size = (0, 0)
        self._key: Any = None
        self._drawn: Any = None
        self._version = 0

    def upload(
        self,
        values: NDArray[Any],
        key: Any,
        covers: Rectangle | None = None,
        glow: NDArray[np.float32] | None = None,
    ) -> bool:
        """Make (h, w) values the picture, unless `key` says they are already.

        covers : (left, top, width, height) of the picture's pixels that the values stand for,
            default one each
        glow : (h, w, 3) linear colours, shown in place of grey intensities
        """
        if key == self._key and self._data is not None:
            return False
        self._key = key
        self._version += 1
        height, width = values.shape
        self._covers = (0.0, 0.0, float(width), float(height)) if covers is None else covers
        parts = 2 if self.kind == "complex" else 1
        dtype, wanted = ("f1", np.uint8) if self.kind == "grey" else ("f4", np.float32)
        if self._data is None or self._data.size != (width, height):
            if self._data is not None:
                self._data.release()
            self._data = self.context.texture((width, height), parts, dtype=dtype, alignment=1)
            self._data.filter = (moderngl.NEAREST, moderngl.NEAREST)
        numbers = np.complex64 if parts == 2 else wanted
        self._data.write(np.ascontiguousarray(values, dtype=numbers))
        if self._glow is not None:
            self._glow.release()
            self._glow = None
        if glow is not None:
            self._glow = self.context.texture((width, height), 3, dtype="f4", alignment=1)
            self._glow.filter = (moderngl.NEAREST, moderngl.NEAREST)
            self._glow.write(np.ascontiguousarray(glow, dtype=np.float32))
        return True

    def upload_mask(self, passed: NDArray[np.float32]) -> None:
        """What passes (1) and what is blocked (0), on samples that cover what the picture does."""
        height, width = passed.shape
        if self._mask.size != (width, height):
            self._mask.release()
            self._mask = self.context.texture((width, height), 1, alignment=1)
            self._mask.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._mask.write(np.rint(255 * np.clip(passed, 0, 1)).astype(np.uint8))
        self._masked = True
        self._version += 1

    @property
    def filled(self) -> bool:
        """Whether there is anything to draw."""
        return self._data is not None

    def _compiled(self, look: Look) -> tuple[Any, Any]:
        """The program for a look: choices are constants, which a software renderer is glad of."""
        glowing = self._glow is not None and look.glows
        key = (KINDS.index(self.kind), MODES.index(look.mode), int(self._masked), int(glowing))
        if key not in self._programs:
            names = ("kind", "mode", "masked", "glowing")
            head = [f"const int {n} = {v};" for n, v in zip(names, key, strict=True)]
            head += [f"#define DECADES {DECADES}", f"#define ENTRIES {ENTRIES}"]
            source = "\n".join(["#version 330", *head, _FRAGMENT])
            program = make_program(self.context, _VERTEX, source)
            self._programs[key] = (program, self.context.vertex_array(program, []))
        return self._programs[key]

    def _table(self, look: Look) -> Any:
        name = DIVERGING if self.kind == "signed" else look.colours
        if name not in self._tables:
            texture = self.context.texture(
                (ENTRIES, 1), 3, colour_table(name).tobytes(), dtype="f4"
            )
            texture.repeat_x = texture.repeat_y = False
            self._tables[name] = texture
        return self._tables[name]

    def draw(self, size: tuple[int, int], view: View, look: Look, white: float) -> int:
        """Draw to a texture of `size` (width, height) screen pixels, row 0 on top; its GL name."""
        size = (max(size[0], 1), max(size[1], 1))
        if self._target is None or self._size != size:
            if self._target is not None:
                for attachment in self._target.color_attachments:
                    attachment.release()
                self._target.release()
            self._target = self.context.framebuffer([self.context.texture(size, 4)])
            self._size = size
            self._drawn = None
        state = (self._version, view.x, view.y, view.scale, repr(look), white)
        if state != self._drawn and self._data is not None:
            self._drawn = state
            program, triangle = self._compiled(look)
            values = {
                "data": 0,
                "mask": 1,
                "table": 2,
                "glow": 3,
                "white": max(white * 2.0**-look.stops, 1e-30),
                "gamma": look.gamma,
                "zoom": view.scale * size[0] / view.screen_width,
                "centre": (view.x, view.y),
                "screen": size,
                "covers": self._covers,
            }
            for name, value in values.items():
                if name in program:  # those that a mode has no use for are compiled away
                    program[name] = value
            self._target.use()
            self.context.viewport = (0, 0, *size)
            self.context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
            self.context.scissor = None
            self._data.use(0)
            self._mask.use(1)
            self._table(look).use(2)
            if self._glow is not None:
                self._glow.use(3)
            triangle.render(moderngl.TRIANGLES, vertices=3)
        texture: moderngl.Texture = self._target.color_attachments[0]
        return texture.glo

    def read(self) -> NDArray[np.uint8]:
        """(height, width, 3) of what was drawn last."""
        raw = self._target.read(components=3, alignment=1)
        return np.frombuffer(raw, dtype=np.uint8).reshape(self._size[1], self._size[0], 3)
