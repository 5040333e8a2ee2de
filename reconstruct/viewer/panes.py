"""A picture in the viewer's window: draws canvases, passes wheel, drag and click on."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from imgui_bundle import imgui

from reconstruct.viewer.canvas import Canvas
from reconstruct.viewer.shade import Look
from reconstruct.viewer.view import View

ImVec2 = imgui.ImVec2
CLICK_SLACK = 4.0
"""Screen pixels that the mouse may stray between press and release of a click."""


def colour(red: float, green: float, blue: float, alpha: float = 1.0) -> int:
    """A colour as draw lists take it."""
    return int(imgui.get_color_u32(imgui.ImVec4(red, green, blue, alpha)))


@dataclass(frozen=True)
class Layer:
    """A canvas as a pane draws it; `until`: share of the width it is seen in, from `since`."""

    canvas: Canvas
    look: Look
    white: float
    since: float = 0.0
    until: float = 1.0


@dataclass
class Pane:
    """One picture's place on the screen.

    title : shown in its corner
    grabbing : dragging with the left button draws a mark instead of moving the picture
    hover : (row, column) under the cursor, or None
    clicked : (row, column) clicked in this frame of the GUI, or None
    drawn : (start, end) places of a mark that is being dragged, or None
    """

    title: str
    view: View
    grabbing: bool = False
    hover: tuple[int, int] | None = None
    clicked: tuple[int, int] | None = None
    drawn: tuple[tuple[float, float], tuple[float, float]] | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    _dragged: float = field(default=0.0, repr=False)
    _start: tuple[float, float] = field(default=(0.0, 0.0), repr=False)
    _last: tuple[float, float] = field(default=(0.0, 0.0), repr=False)

    def show(
        self, size: tuple[float, float], layers: Sequence[Layer], density: float, note: str = ""
    ) -> Any:
        """Draw at the cursor's place. `density` : framebuffer pixels per GUI unit.

        Returns the draw list, for overlays in screen coordinates (`screen_point`).
        """
        width, height = max(size[0], 8.0), max(size[1], 8.0)
        self.view.resize(width, height)
        place = imgui.get_cursor_screen_pos()
        self.origin = (place.x, place.y)
        flags = imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
        imgui.invisible_button(self.title, ImVec2(width, height), int(flags))
        self._hands()
        pixels = (round(width * density), round(height * density))
        drawn = imgui.get_window_draw_list()
        low, high = place, ImVec2(place.x + width, place.y + height)
        drawn.add_rect_filled(low, high, colour(0.055, 0.062, 0.075))
        for layer in layers:
            if not layer.canvas.filled:
                continue
            name = layer.canvas.draw(pixels, self.view, layer.look, layer.white)
            a = ImVec2(place.x + layer.since * width, place.y)
            b = ImVec2(place.x + layer.until * width, place.y + height)
            ends = ImVec2(layer.since, 0), ImVec2(layer.until, 1)
            drawn.add_image(imgui.ImTextureRef(name), a, b, *ends)
        drawn.push_clip_rect(low, high, True)
        words = self.title.split("##")[0]
        self.label(drawn, (8, 8), f"{words}   {note}" if note else words)
        return drawn

    def finish(self, drawn: Any) -> None:
        """End of overlays."""
        drawn.pop_clip_rect()
        frame = colour(0.24, 0.55, 0.36) if self.hover is not None else colour(0.2, 0.22, 0.26)
        low = ImVec2(*self.origin)
        high = ImVec2(low.x + self.view.screen_width, low.y + self.view.screen_height)
        drawn.add_rect(low, high, frame)

    def label(self, drawn: Any, at: tuple[float, float], text: str, right: bool = False) -> None:
        """Words on a dark ground, at a place of the pane; from the right edge when `right`."""
        extent = imgui.calc_text_size(text)
        x = self.origin[0] + at[0]
        if right:
            x = self.origin[0] + self.view.screen_width - at[0] - extent.x - 16
        low = ImVec2(x, self.origin[1] + at[1])
        high = ImVec2(low.x + extent.x + 16, low.y + extent.y + 8)
        drawn.add_rect_filled(low, high, colour(0.05, 0.06, 0.07, 0.78), 5)
        drawn.add_text(ImVec2(low.x + 8, low.y + 4), colour(0.88, 0.92, 0.9), text)

    def screen_point(self, row: float, column: float) -> Any:
        """Where the middle of a pixel is on the screen."""
        x, y = self.view.to_screen(column + 0.5, row + 0.5)
        return ImVec2(self.origin[0] + x, self.origin[1] + y)

    def _place(self, x: float, y: float) -> tuple[float, float]:
        """(row, column) at a point of the pane, pixel middles whole."""
        px, py = self.view.to_picture(x, y)
        return py - 0.5, px - 0.5

    def _hands(self) -> None:
        self.clicked = self.drawn = None
        io = imgui.get_io()
        x, y = io.mouse_pos.x - self.origin[0], io.mouse_pos.y - self.origin[1]
        hovered = imgui.is_item_hovered()
        self.hover = self.view.pixel_at(x, y) if hovered else None
        if hovered and io.mouse_wheel:
            self.view.zoom_at(x, y, 1.25**io.mouse_wheel)
        if hovered and imgui.is_mouse_double_clicked(1):
            self.view.fit()
        # On a slow machine a move, the press and the release arrive together: what counts is where
        # the mouse was when it was pressed.
        if imgui.is_item_activated():
            self._dragged = 0.0
            since = imgui.get_mouse_drag_delta(1 if io.mouse_clicked[1] else 0, 0.0)
            self._last = (x - since.x, y - since.y)
            self._start = self._place(*self._last)
        if imgui.is_item_active() or imgui.is_item_deactivated():
            dx, dy = x - self._last[0], y - self._last[1]
            self._last = (x, y)
            self._dragged += abs(dx) + abs(dy)
            left = io.mouse_down[0] or io.mouse_released[0]
            if self._dragged > CLICK_SLACK and self.grabbing and left:
                self.drawn = self._start, self._place(x, y)
            elif self._dragged > CLICK_SLACK:
                self.view.pan(dx, dy)
                imgui.set_mouse_cursor(imgui.MouseCursor_.resize_all)
            if imgui.is_item_deactivated() and self._dragged <= CLICK_SLACK and left:
                self.clicked = self.view.pixel_at(x, y)
