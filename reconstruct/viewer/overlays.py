"""What is drawn over pictures: scale bar, colour bar, focus mark, ruler, region, faults."""

import time
from math import cos, pi, sin
from typing import Any

import numpy as np
from imgui_bundle import imgui

from reconstruct.viewer.figure import length_words, round_length
from reconstruct.viewer.focusing import REGION
from reconstruct.viewer.measure import Line, Region
from reconstruct.viewer.panes import Pane, colour
from reconstruct.viewer.shade import DIVERGING, Look, coloured, hues, light_of

ImVec2 = imgui.ImVec2
_STEPS = 32


def scale_bar(pane: Pane, drawn: Any, pitch: float) -> None:
    """A length that is round and about a fifth of the picture, on a dark ground."""
    em = imgui.get_font_size()
    per_metre = pane.view.scale / pitch
    length = round_length(pane.view.screen_width / 5 / per_metre)
    words = length_words(length)
    extent = imgui.calc_text_size(words)
    wide = length * per_metre
    x = pane.origin[0] + 1.2 * em
    y = pane.origin[1] + pane.view.screen_height - 1.2 * em
    low = ImVec2(x - 0.6 * em, y - extent.y - 0.7 * em)
    high = ImVec2(x + max(wide, extent.x) + 0.6 * em, y + 0.7 * em)
    drawn.add_rect_filled(low, high, colour(0.05, 0.06, 0.07, 0.78), 0.3 * em)
    white = colour(0.95, 0.97, 0.96)
    drawn.add_rect_filled(ImVec2(x, y), ImVec2(x + wide, y + 0.22 * em), white)
    drawn.add_text(ImVec2(x, y - extent.y - 0.25 * em), white, words)


def colour_bar(
    pane: Pane, drawn: Any, look: Look, white: float, ends: tuple[float, float] | None, signed: bool
) -> None:
    """What colours mean: intensities from dark to bright, or phases; `ends` : least and most."""
    em = imgui.get_font_size()
    wide, tall = 0.9 * em, min(11 * em, pane.view.screen_height - 7 * em)
    if tall < 4 * em:
        return
    phase = look.mode == "phase" and not signed
    x = pane.origin[0] + pane.view.screen_width - wide - 1.2 * em
    y = pane.origin[1] + pane.view.screen_height - tall - 2.2 * em
    drawn.add_rect_filled(
        ImVec2(x - 5.4 * em, y - 1.1 * em),
        ImVec2(x + wide + 0.6 * em, y + tall + 1.6 * em),
        colour(0.05, 0.06, 0.07, 0.78),
        0.3 * em,
    )
    level = (np.arange(_STEPS) + 0.5) / _STEPS
    if phase:
        table = hues(2 * np.pi * (level - 0.5))
    else:
        table = coloured(level, DIVERGING if signed else look.colours)
    for i, part in enumerate(table):
        low = y + tall * (1 - (i + 1) / _STEPS)
        shown = colour(*(float(v) for v in part))
        drawn.add_rect_filled(ImVec2(x, low), ImVec2(x + wide, low + tall / _STEPS + 0.5), shown)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        if phase:
            words = ("−π", "−π/2", "0", "π/2", "π")[round(4 * share)]
        elif signed:
            words = f"{(2 * share - 1) * white * 2.0**-look.stops:+.3g}"
        else:
            words = f"{light_of(share, white, look):.3g}"
        extent = imgui.calc_text_size(words)
        at = y + tall * (1 - share)
        drawn.add_text(
            ImVec2(x - extent.x - 0.5 * em, at - extent.y / 2), colour(0.88, 0.92, 0.9), words
        )
    if ends is not None:
        words = f"{ends[0]:.3g} … {ends[1]:.3g}" if not phase else "amplitude: light"
        extent = imgui.calc_text_size(words)
        place = ImVec2(x + wide - extent.x, y + tall + 0.5 * em)
        drawn.add_text(place, colour(0.6, 0.65, 0.63), words)


def focus_mark(pane: Pane, drawn: Any, pixel: tuple[int, int], pitch: float) -> None:
    """Corners around the region that was focused on."""
    half = REGION / pitch
    low = pane.screen_point(pixel[0] - half, pixel[1] - half)
    high = pane.screen_point(pixel[0] + half, pixel[1] + half)
    arm = min(10.0, (high.x - low.x) / 3)
    for shade, width in ((colour(0, 0, 0, 0.7), 3.5), (colour(0.36, 0.80, 0.52), 1.5)):
        for x, dx in ((low.x, arm), (high.x, -arm)):
            for y, dy in ((low.y, arm), (high.y, -arm)):
                drawn.add_line(ImVec2(x, y), ImVec2(x + dx, y), shade, width)
                drawn.add_line(ImVec2(x, y), ImVec2(x, y + dy), shade, width)


def ruler(pane: Pane, drawn: Any, line: Line, pitch: float) -> None:
    """A measured line and its length."""
    a, b = pane.screen_point(*line.start), pane.screen_point(*line.end)
    drawn.add_line(a, b, colour(0, 0, 0, 0.7), 4.0)
    drawn.add_line(a, b, colour(1.0, 0.82, 0.3), 1.8)
    for end in (a, b):
        drawn.add_circle_filled(end, 3.5, colour(1.0, 0.82, 0.3))
    x, y = b.x - pane.origin[0] + 8, b.y - pane.origin[1] + 8
    pane.label(drawn, (x, y), f"{length_words(float(f'{line.length(pitch):.4g}'))}")


def rectangle(pane: Pane, drawn: Any, region: Region) -> None:
    """A measured region."""
    low = [min(a, b) - 0.5 for a, b in zip(region.corner, region.opposite, strict=True)]
    high = [max(a, b) + 0.5 for a, b in zip(region.corner, region.opposite, strict=True)]
    a, b = pane.screen_point(*low), pane.screen_point(*high)
    drawn.add_rect(a, b, colour(0, 0, 0, 0.7), thickness=4.0)
    drawn.add_rect(a, b, colour(0.35, 0.75, 1.0), thickness=1.8)


def fault(pane: Pane, drawn: Any, words: str) -> None:
    """What is wrong with a frame, in the middle of where it would be."""
    em = imgui.get_font_size()
    wide = max(min(pane.view.screen_width - 4 * em, 44 * em), 8 * em)
    extent = imgui.calc_text_size(words, False, wide)
    x = pane.origin[0] + (pane.view.screen_width - extent.x) / 2
    y = pane.origin[1] + (pane.view.screen_height - extent.y) / 2
    low = ImVec2(x - em, y - 0.7 * em)
    high = ImVec2(x + extent.x + em, y + extent.y + 0.7 * em)
    drawn.add_rect_filled(low, high, colour(0.32, 0.07, 0.08, 0.95), 0.4 * em)
    size = imgui.get_font_size()
    drawn.add_text(imgui.get_font(), size, ImVec2(x, y), colour(1, 0.92, 0.9), words, wide)


def busy(pane: Pane, drawn: Any, words: str, share: float | None) -> None:
    """A sign that something is under way, in the upper right corner: a wheel, or a bar."""
    em = imgui.get_font_size()
    pane.label(drawn, (2.4 * em, 8), words, right=True)
    right, y = pane.origin[0] + pane.view.screen_width, pane.origin[1] + 8 + em / 2 + 4
    centre = ImVec2(right - 1.3 * em, y)
    turn = 2 * pi * (time.monotonic() % 1.0)
    for i in range(8):
        angle = turn + 2 * pi * i / 8
        at = ImVec2(centre.x + 0.5 * em * cos(angle), centre.y + 0.5 * em * sin(angle))
        drawn.add_circle_filled(at, 0.11 * em, colour(0.36, 0.80, 0.52, (i + 1) / 8))
    if share is not None:
        low = ImVec2(right - 12 * em, y + 1.1 * em)
        high = ImVec2(right - 0.8 * em, y + 1.4 * em)
        drawn.add_rect_filled(low, high, colour(0.14, 0.155, 0.18), 2)
        middle = low.x + (high.x - low.x) * min(max(share, 0.0), 1.0)
        drawn.add_rect_filled(low, ImVec2(middle, high.y), colour(0.36, 0.80, 0.52), 2)
