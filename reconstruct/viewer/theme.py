"""Fonts, colours and spacing of the viewer."""

from pathlib import Path
from typing import Any

import imgui_bundle
from imgui_bundle import imgui

BACKGROUND = (0.075, 0.082, 0.095)
_GREEN, _GREEN_HOT, _GREEN_DIM = (0.27, 0.66, 0.42), (0.36, 0.80, 0.52), (0.16, 0.36, 0.24)
_COLOURS = {
    "window_bg": BACKGROUND,
    "child_bg": BACKGROUND,
    "popup_bg": (0.10, 0.11, 0.13),
    "text": (0.88, 0.90, 0.92),
    "text_disabled": (0.50, 0.54, 0.58),
    "frame_bg": (0.14, 0.155, 0.18),
    "frame_bg_hovered": (0.18, 0.20, 0.23),
    "frame_bg_active": (0.20, 0.22, 0.26),
    "slider_grab": _GREEN,
    "slider_grab_active": _GREEN_HOT,
    "check_mark": _GREEN_HOT,
    "button": (0.17, 0.19, 0.22),
    "button_hovered": _GREEN_DIM,
    "button_active": _GREEN,
    "header": _GREEN_DIM,
    "header_hovered": (0.20, 0.44, 0.30),
    "header_active": _GREEN,
    "title_bg": (0.13, 0.145, 0.165),
    "title_bg_active": _GREEN_DIM,
    "tab": (0.13, 0.145, 0.165),
    "tab_hovered": _GREEN_DIM,
    "tab_selected": (0.20, 0.44, 0.30),
    "tab_selected_overline": _GREEN_HOT,
    "separator": (0.20, 0.22, 0.26),
    "border": (0.20, 0.22, 0.26),
    "scrollbar_bg": BACKGROUND,
    "scrollbar_grab": (0.22, 0.24, 0.28),
    "plot_lines": _GREEN_HOT,
}


def apply(scale: float) -> Any:
    """Set fonts and style for a content scale (1 = no DPI scaling); returns the heading font."""
    folder = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto"
    fonts = imgui.get_io().fonts
    plain, bold = folder / "Roboto-Regular.ttf", folder / "Roboto-Bold.ttf"
    heading = None
    if plain.exists() and bold.exists():
        fonts.add_font_from_file_ttf(str(plain), 15.0 * scale)
        heading = fonts.add_font_from_file_ttf(str(bold), 15.0 * scale)
    imgui.style_colors_dark()
    style = imgui.get_style()
    for name, (red, green, blue) in _COLOURS.items():
        style.set_color_(getattr(imgui.Col_, name), imgui.ImVec4(red, green, blue, 1.0))
    style.window_padding = imgui.ImVec2(12, 10)
    style.frame_padding = imgui.ImVec2(8, 5)
    style.item_spacing = imgui.ImVec2(8, 7)
    style.frame_rounding = style.grab_rounding = style.popup_rounding = 5
    style.window_rounding = style.window_border_size = 0
    style.grab_min_size = 10
    style.scale_all_sizes(scale)
    return heading
