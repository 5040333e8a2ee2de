"""Pictures on the graphics card: uploaded once, drawn with any zoom, pan and look."""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from reconstruct.viewer.shade import DECADES, MODES, TINTS, Look
from reconstruct.viewer.view import View

_VERTEX = """
#version 330
void main() {  // one triangle that covers the viewport
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
"""
_FRAGMENT = """
// mode: 0 intensity, 1 log, 2 phase, 3 grey level as it is; tint: as TINTS;
// shifted: zero frequency in the corner, shown in the middle; masked: show what is blocked
uniform sampler2D data;    // complex amplitude, or a grey level in red
uniform sampler2D mask;    // what passes, 1, and what is blocked, 0
uniform float white, gamma, zoom;
uniform vec2 centre, screen;
out vec4 colour;

vec3 tinted(float v) {
    if (tint == 1) return vec3(v * v * v * 0.85, v, v * v * v * 0.6);
    if (tint == 2) return vec3(clamp(2.2 * v, 0, 1), pow(v, 1.6), clamp(1.8 * v - 0.9, 0, 1));
    return vec3(v);
}
ivec2 texel(vec2 p, ivec2 size) {
    ivec2 at = ivec2(floor(p));
    if (shifted == 1) at = (at + size - size / 2) % size;
    return at;
}
void main() {
    ivec2 size = textureSize(data, 0);
    vec2 p = centre + (gl_FragCoord.xy - screen / 2.0) / zoom;
    if (any(lessThan(p, vec2(0))) || any(greaterThanEqual(p, vec2(size)))) {
        colour = vec4(0.055, 0.062, 0.075, 1.0);
        return;
    }
    // Zoomed out, a screen pixel shows the mean over what it covers.
    int n = clamp(int(ceil(1.0 / zoom)), 1, 5);
    float light = 0.0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            vec2 q = p + ((vec2(i, j) + 0.5) / float(n) - 0.5) / zoom * float(n > 1);
            vec2 v = texelFetch(data, texel(clamp(q, vec2(0), vec2(size) - 0.5), size), 0).rg;
            light += mode == 3 ? v.r : dot(v, v);
        }
    light /= float(n * n);
    vec2 here = texelFetch(data, texel(p, size), 0).rg;
    vec3 shown;
    if (mode == 3) {
        shown = vec3(light);
    } else if (mode == 1) {
        shown = tinted(clamp(1.0 + log(max(light / white, 1e-30)) / log(10.0) / DECADES, 0, 1));
    } else {
        float level = clamp(pow(light / white, 1.0 / gamma), 0, 1);
        shown = tinted(level);
        if (mode == 2) {
            float turn = dot(here, here) > 0.0 ? atan(here.y, here.x) / 6.283185307179586 : 0.0;
            vec3 hue = turn - vec3(0.0, 1.0, -1.0) / 3.0;
            shown = clamp(2.0 - abs(6.0 * (hue - round(hue))), 0.0, 1.0) * sqrt(level);
        }
    }
    if (masked == 1) {
        float passed = texelFetch(mask, texel(p, size), 0).r;
        shown = mix(vec3(0.30, 0.04, 0.06) + 0.35 * shown, shown, passed);
    }
    colour = vec4(shown, 1.0);
}
"""


class Canvas:
    """One picture and the framebuffer it is drawn to, redrawn only when something changed.

    context : the window's moderngl context, current in this thread
    kind : "complex" (h, w) complex64, or "grey" (h, w) uint8
    """

    def __init__(self, context: moderngl.Context, kind: str, shifted: bool = False) -> None:
        self.context = context
        self.kind = kind
        self.shifted = shifted
        self._programs: dict[tuple[int, ...], tuple[Any, Any]] = {}
        self._data: moderngl.Texture | None = None
        self._mask = context.texture((1, 1), 1, b"\xff", alignment=1)
        self._masked = False
        self._target: Any = None
        self._size = (0, 0)
        self._key: Any = None
        self._drawn: Any = None
        self._version = 0

    def upload(self, values: NDArray[Any], key: Any) -> bool:
        """Make (h, w) values the picture, unless `key` says they are already."""
        if key == self._key:
            return False
        self._key = key
        self._version += 1
        height, width = values.shape
        parts, dtype = (1, "f1") if self.kind == "grey" else (2, "f4")
        if self._data is None or self._data.size != (width, height):
            if self._data is not None:
                self._data.release()
            self._data = self.context.texture((width, height), parts, dtype=dtype, alignment=1)
            self._data.filter = (moderngl.NEAREST, moderngl.NEAREST)
        wanted = np.uint8 if self.kind == "grey" else np.complex64
        self._data.write(np.ascontiguousarray(values, dtype=wanted))
        return True

    def upload_mask(self, passed: NDArray[np.float32]) -> None:
        """What passes (1) and what is blocked (0), on the picture's samples."""
        height, width = passed.shape
        if self._mask.size != (width, height):
            self._mask.release()
            self._mask = self.context.texture((width, height), 1, alignment=1)
            self._mask.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._mask.write(np.rint(255 * np.clip(passed, 0, 1)).astype(np.uint8))
        self._masked = True
        self._version += 1

    def _compiled(self, look: Look) -> tuple[Any, Any]:
        """The program for a look: choices are constants, which a software renderer is glad of."""
        key = (
            3 if self.kind == "grey" else MODES.index(look.mode),
            TINTS.index(look.tint),
            int(self.shifted),
            int(self._masked),
        )
        if key not in self._programs:
            names = ("mode", "tint", "shifted", "masked")
            head = [f"const int {n} = {v};" for n, v in zip(names, key, strict=True)]
            source = "\n".join(["#version 330", f"#define DECADES {DECADES}", *head, _FRAGMENT])
            program = self.context.program(vertex_shader=_VERTEX, fragment_shader=source)
            self._programs[key] = (program, self.context.vertex_array(program, []))
        return self._programs[key]

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
                "white": max(white * 2.0**-look.stops, 1e-30),
                "gamma": look.gamma,
                "zoom": view.scale * size[0] / view.screen_width,
                "centre": (view.x, view.y),
                "screen": size,
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
            triangle.render(moderngl.TRIANGLES, vertices=3)
        texture: moderngl.Texture = self._target.color_attachments[0]
        return texture.glo

    def read(self) -> NDArray[np.uint8]:
        """(height, width, 3) of what was drawn last."""
        raw = self._target.read(components=3, alignment=1)
        return np.frombuffer(raw, dtype=np.uint8).reshape(self._size[1], self._size[0], 3)
