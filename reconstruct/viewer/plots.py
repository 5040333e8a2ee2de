"""Curves among the controls: sharpness over depth, a profile along a line, a region's figures."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from reconstruct.viewer.figure import length_words
from reconstruct.viewer.measure import profile
from reconstruct.viewer.panes import colour
from reconstruct.viewer.session import Session
from reconstruct.viewer.widgets import button, em, rows, tip

ImVec2 = imgui.ImVec2
SERIES = ((0.90, 0.62, 0.0), (0.34, 0.71, 0.91), (0.80, 0.47, 0.65), (0.94, 0.89, 0.26))
"""Colours of objects' curves that are told apart with any eyes (Okabe and Ito's)."""


def _ground(height: float) -> tuple[Any, Any, float, float]:
    """Draw list, upper left corner, width and height of a plot at the cursor."""
    width = imgui.get_content_region_avail().x
    place = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(width, height))
    drawn = imgui.get_window_draw_list()
    corner = ImVec2(place.x + width, place.y + height)
    drawn.add_rect_filled(place, corner, imgui.get_color_u32(imgui.Col_.frame_bg), 5)
    return drawn, place, width, height


def focus_curves(session: Session) -> None:
    """Sharpness over depth: where the picture was clicked last, and of the frame's objects."""
    model = session.model
    drawn, place, width, height = _ground(6.2 * em())
    dim = imgui.get_color_u32(imgui.Col_.text_disabled)
    low, high = model.depth_range
    line = 1.15 * em()

    def across(z: float) -> float:
        return float(place.x + 8 + (z - low) / (high - low) * (width - 16))

    def draw(depths: NDArray[np.float64], values: NDArray[np.float64], shade: int) -> None:
        curve = values / max(float(values.max()), 1e-30)
        room = height - 2.2 * line - 8
        points = [
            ImVec2(across(float(z)), place.y + height - 6 - float(v) * room)
            for z, v in zip(depths, curve, strict=True)
        ]
        drawn.add_polyline(points, shade, thickness=1.6, flags=0)

    x = place.x + 8
    for i, (name, curve) in enumerate(model.curves.items()):
        shade = colour(*SERIES[i % len(SERIES)])
        draw(curve.focus.depths, curve.focus.curve, shade)
        words = f"{name} {curve.focus.depth * 1e3:.2f}" if curve.focus.focused else f"{name} none"
        drawn.add_text(ImVec2(x, place.y + 4 + line), shade, words)
        x += imgui.calc_text_size(words).x + em()
    found = model.found
    if found is not None:
        draw(found.focus.depths, found.focus.curve, imgui.get_color_u32(imgui.Col_.plot_lines))
        words = "nothing comes into focus there"
        if found.focus.focused:
            words = f"in focus at {found.focus.depth * 1e3:.2f} mm"
            extent = (found.focus.rear - found.focus.front) * 1e3
            words += f", {extent:.2f} mm deep" if np.isfinite(extent) else ""
        drawn.add_text(ImVec2(place.x + 8, place.y + 4), dim, words)
    elif not model.curves:
        words = "click on the reconstruction to focus"
        drawn.add_text(ImVec2(place.x + 8, place.y + 4), dim, words)
    here = across(min(max(model.depth, low), high))
    drawn.add_line(ImVec2(here, place.y + 2 * line), ImVec2(here, place.y + height - 4), dim)


def marks(session: Session) -> None:
    """The tools, the profile along the line, the region's statistics."""
    model = session.model
    for name, words in (("focus", "focus"), ("line", "line (L)"), ("region", "region (R)")):
        if imgui.radio_button(words, session.tool == name):
            session.tool = name
        imgui.same_line()
    if model.line is not None or model.region is not None:
        if button("drop"):
            model.line = model.region = None
        tip("Escape")
    else:
        imgui.new_line()
    picture = model.picture(model.active)
    if picture is None:
        return
    pitch = model.video.slm.pixel_pitch
    if model.line is not None:
        line = model.line
        length = line.length(pitch)
        words = f"{length_words(float(f'{length:.4g}'))}, {length / pitch:.1f} pixels"
        imgui.text(f"{words}, {line.angle:.1f}°")
        shown = [p for p in map(model.picture, range(len(model.videos))) if p is not None]
        along = [profile(p.light, line, model.video.slm.shape) for p in shown]
        _profile(along[0][0], [values for _, values in along])
    elif model.region is None:
        imgui.text_disabled("drag on a reconstruction to measure it")
    found = session.statistics()
    if found is not None:
        rows(
            "statistics",
            [
                ("min … max", f"{found.least:.3g} … {found.most:.4g}"),
                ("mean ± deviation", f"{found.mean:.4g} ± {found.deviation:.3g}"),
                ("speckle contrast", f"{found.speckle:.3f}"),
                ("share of the light", f"{found.light:.2%}"),
            ],
        )


def _profile(share: NDArray[np.float64], series: Sequence[NDArray[np.float64]]) -> None:
    drawn, place, width, height = _ground(4.6 * em())
    top = max(float(v.max()) for v in series) or 1.0
    room = height - 12
    for i, values in enumerate(series):
        # Peaks are kept where there are more values than screen pixels.
        step = max(1, len(values) // max(int(width), 1))
        points = [
            ImVec2(
                place.x + 6 + float(share[k]) * (width - 12),
                place.y + height - 5 - float(values[k : k + step].max()) / top * room,
            )
            for k in range(0, len(values), step)
        ]
        drawn.add_polyline(points, colour(*SERIES[i]), thickness=1.5, flags=0)
    dim = imgui.get_color_u32(imgui.Col_.text_disabled)
    drawn.add_text(ImVec2(place.x + 6, place.y + 2), dim, f"{top:.3g}")
