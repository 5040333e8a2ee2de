"""The viewer's controls: they read and set the model, and say what happened."""

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from reconstruct.viewer.model import ViewerModel
from reconstruct.viewer.shade import MODES, TINTS

ImVec2 = imgui.ImVec2
FILL = -1.0
"""Item width: what is left of the line."""
FILTER_EDGE = 12e-3
"""Largest aperture that the slider offers, metres."""


@dataclass
class ControlState:
    """What belongs to the controls and not to the model."""

    playing: bool = False
    rate: float = 8.0
    message: str = ""
    message_until: float = 0.0
    folder: Path = field(default_factory=Path.cwd)
    figures: dict[str, float] = field(default_factory=dict)
    spent: dict[str, float] = field(default_factory=dict)

    def say(self, message: str) -> None:
        """Show a message for a few seconds."""
        self.message, self.message_until = message, time.monotonic() + 4.0


def heading(text: str, font: Any) -> None:
    """A section's title."""
    imgui.dummy(ImVec2(0, 3))
    if font is not None:
        imgui.push_font(font, 0.0)
    imgui.text(text)
    if font is not None:
        imgui.pop_font()
    imgui.separator()


def label(text: str) -> None:
    """A name before an item, on a column of its own."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(text)
    imgui.same_line(84 * imgui.get_font_size() / 15)
    imgui.set_next_item_width(FILL)


def frames(model: ViewerModel, state: ControlState, font: Any) -> None:
    """Scrubber, play, follow."""
    heading("Frame", font)
    last = len(model.numbers) - 1
    if imgui.button("Pause" if state.playing else "Play", ImVec2(70, 0)):
        state.playing = not state.playing
    tip("Space")
    imgui.same_line()
    if imgui.button("<"):
        model.step(-1)
    tip("Left arrow")
    imgui.same_line()
    if imgui.button(">"):
        model.step(1)
    tip("Right arrow")
    imgui.same_line()
    imgui.set_next_item_width(FILL)
    changed, index = imgui.slider_int(
        "##frame", model.index, 0, max(last, 1), f"{model.number} of {model.numbers[-1]}"
    )
    if changed:
        model.index = index
    names = ["no object", *dict.fromkeys(t.name for t in model.things())]
    label("follow")
    current = model.follow or names[0]
    if imgui.begin_combo("##follow", current):
        for name in names:
            if imgui.selectable(name, name == current)[0]:
                model.follow = None if name == names[0] else name
                model.index = model.index  # takes its depth at once
        imgui.end_combo()


def depth(model: ViewerModel, state: ControlState, font: Any) -> None:
    """Depth slider, steps, objects, focus curve."""
    heading("Depth", font)
    low, high = model.depth_range
    imgui.set_next_item_width(FILL)
    changed, value = imgui.slider_float(
        "##depth", model.depth * 1e3, low * 1e3, high * 1e3, "%.2f mm"
    )
    if changed:
        model.depth = value * 1e-3
        model.follow = None
    for step in (-1.0, -0.1, 0.1, 1.0):
        if imgui.button(f"{step:+.1f}", ImVec2(58, 0)):
            model.depth += step * 1e-3
            model.follow = None
        imgui.same_line()
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("mm")
    for thing in model.things():
        if imgui.button(f"{thing.name}  {thing.depth * 1e3:.2f}"):
            model.depth = thing.depth
        tip("Where the scene says it is")
        imgui.same_line()
    imgui.new_line()
    focus_curve(model)


def focus_curve(model: ViewerModel) -> None:
    """Sharpness over depth where the picture was clicked last."""
    focus = model.last_focus
    width, height = imgui.get_content_region_avail().x, 84 * imgui.get_font_size() / 15
    place = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(width, height))
    drawn = imgui.get_window_draw_list()
    corner = ImVec2(place.x + width, place.y + height)
    drawn.add_rect_filled(place, corner, imgui.get_color_u32(imgui.Col_.frame_bg), 5)
    dim = imgui.get_color_u32(imgui.Col_.text_disabled)
    if focus is None:
        words = "click on the reconstruction to focus there"
        drawn.add_text(ImVec2(place.x + 10, place.y + height / 2 - 8), dim, words)
        return
    low, high = model.depth_range
    curve = focus.curve / max(float(focus.curve.max()), 1e-30)

    def at(z: float, level: float) -> Any:
        x = place.x + 8 + (z - low) / (high - low) * (width - 16)
        return ImVec2(x, place.y + height - 8 - level * (height - 34))

    line = imgui.get_color_u32(imgui.Col_.plot_lines)
    points = [at(float(z), float(v)) for z, v in zip(focus.depths, curve, strict=True)]
    drawn.add_polyline(points, line, 1.6, 0)
    here = at(model.depth, 0).x
    drawn.add_line(ImVec2(here, place.y + 24), ImVec2(here, place.y + height - 4), dim)
    words = "nothing comes into focus there"
    if focus.focused:
        extent = (focus.rear - focus.front) * 1e3
        words = f"in focus at {focus.depth * 1e3:.2f} mm, {extent:.2f} mm deep"
    drawn.add_text(ImVec2(place.x + 10, place.y + 6), imgui.get_color_u32(imgui.Col_.text), words)


def fourier_filter(model: ViewerModel, font: Any) -> None:
    """Half plane, zero order, aperture."""
    heading("Fourier filter", font)
    chosen = model.filter
    automatic = model.system.coding.carrier > 0
    half = automatic if chosen.half_plane is None else chosen.half_plane
    changed, half = imgui.checkbox("single sideband, f_y > 0 only", half)
    if changed:
        model.change_filter(half_plane=half)
    block = chosen.dc_block
    changed, on = imgui.checkbox("block zero order", block is not None)
    if changed:
        model.change_filter(dc_block=10e-6 if on else None)
    if block is not None:
        imgui.same_line()
        imgui.set_next_item_width(FILL)
        changed, value = imgui.slider_float(
            "##dc", block * 1e6, 0.0, 500.0, "%.0f µm", int(imgui.SliderFlags_.logarithmic)
        )
        if changed:
            model.change_filter(dc_block=value * 1e-6)
    shapes = ("none", "round", "square")
    opening = chosen.aperture
    current = 0 if opening is None else 1 if np.ndim(opening) == 0 else 2
    label("aperture")
    changed, picked = imgui.combo("##aperture", current, list(shapes))
    size = 6e-3 if opening is None else float(np.max(np.asarray(opening)))
    if changed:
        model.change_filter(aperture=(None, size, (size, size))[picked])
    if opening is not None:
        label("opening")
        changed, value = imgui.slider_float(
            "##opening", size * 1e3, 0.2, FILTER_EDGE * 1e3, "%.2f mm"
        )
        if changed:
            side = value * 1e-3
            model.change_filter(aperture=side if current == 1 else (side, side))


def look(model: ViewerModel, font: Any) -> None:
    """Mode, tint, gamma, exposure."""
    heading("Picture", font)
    shown = model.look
    for mode in MODES:
        if imgui.radio_button(mode, shown.mode == mode):
            shown.mode = mode
        imgui.same_line()
    imgui.new_line()
    label("colours")
    _, tint = imgui.combo("##tint", TINTS.index(shown.tint), list(TINTS))
    shown.tint = TINTS[tint]
    label("exposure")
    _, shown.stops = imgui.slider_float("##stops", shown.stops, -5, 7, "%+.1f stops")
    if shown.mode != "log":
        label("gamma")
        _, shown.gamma = imgui.slider_float("##gamma", shown.gamma, 0.5, 4, "%.2f")


def figures(state: ControlState, font: Any) -> None:
    """What was measured."""
    heading("Measured", font)
    words = {
        "sharpness": ("sharpness", "{:.1f}"),
        "contrast": ("contrast", "{:.3f}"),
        "speckle": ("speckle contrast", "{:.2f}"),
        "efficiency": ("light in the image", "{:.2%}"),
        "blocked": ("light on the filter", "{:.1%}"),
    }
    rows = [(n, f.format(state.figures[k])) for k, (n, f) in words.items() if k in state.figures]
    rows += [(n, f"{1e3 * s:.0f} ms") for n, s in state.spent.items()]
    if imgui.begin_table("figures", 2):
        for name, value in rows:
            imgui.table_next_column()
            imgui.text_disabled(name)
            imgui.table_next_column()
            imgui.text(value)
        imgui.end_table()


def saving(model: ViewerModel, state: ControlState) -> None:
    """Save buttons."""
    imgui.dummy(ImVec2(0, 2))
    half = (imgui.get_content_region_avail().x - 8) / 2
    for suffix, words in ((".png", "Save picture"), (".exr", "Save intensities")):
        if imgui.button(words, ImVec2(half, 0)):
            save(model, state, suffix)
        if suffix == ".png":
            tip("S")
            imgui.same_line()


def save(model: ViewerModel, state: ControlState, suffix: str) -> None:
    """Write the picture into the working folder and say so."""
    path = state.folder / (model.suggested_name() + suffix)
    try:
        model.save(path)
        state.say(f"saved {path}")
    except OSError as error:
        state.say(str(error))


def tip(words: str) -> None:
    """Shown when the mouse rests on the last item."""
    if imgui.is_item_hovered(int(imgui.HoveredFlags_.delay_normal)):
        imgui.set_tooltip(words)
