"""The few shapes that the viewer's controls are made of; all sizes follow the font's."""

from typing import Any

from imgui_bundle import imgui

ImVec2 = imgui.ImVec2
FILL = -1.0
"""Item width: what is left of the line."""
_LABEL, _VALUE = 5.2, 5.5


def em() -> float:
    """The font's size, which everything is measured in."""
    return float(imgui.get_font_size())


def heading(text: str, font: Any) -> None:
    """A section's title."""
    imgui.dummy(ImVec2(0, 0.1 * em()))
    if font is not None:
        imgui.push_font(font, 0.0)
    imgui.text(text)
    if font is not None:
        imgui.pop_font()
    imgui.separator()


def label(text: str) -> None:
    """A name before an item, on a column of its own; the item takes the rest of the line."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(text)
    imgui.same_line(_LABEL * em())
    imgui.set_next_item_width(FILL)


def slider(
    name: str,
    value: float,
    low: float,
    high: float,
    form: str,
    logarithmic: bool = False,
    labelled: bool = True,
) -> tuple[bool, float]:
    """A slider, and beside it its value, which may be typed too; (changed, value)."""
    if labelled:
        label(name)
    box = _VALUE * em()
    gap = imgui.get_style().item_spacing.x
    imgui.set_next_item_width(max(imgui.get_content_region_avail().x - box - gap, 2 * em()))
    flags = imgui.SliderFlags_.no_input
    if logarithmic:
        flags |= imgui.SliderFlags_.logarithmic
    moved, at = imgui.slider_float(f"##{name}", value, low, high, "", int(flags))
    imgui.same_line()
    imgui.set_next_item_width(FILL)
    enter = int(imgui.InputTextFlags_.enter_returns_true)
    typed, given = imgui.input_float(f"##{name} typed", value, 0, 0, form, enter)
    return (True, given) if typed else (moved, at)


def button(text: str, width: float = 0.0) -> bool:
    """A button at least `width` ems wide, and wide enough for its words."""
    words = imgui.calc_text_size(text.split("##")[0]).x + 2 * imgui.get_style().frame_padding.x
    return bool(imgui.button(text, ImVec2(max(width * em(), words), 0)))


def fits(text: str) -> bool:
    """Whether a button with these words has room on the line, after one more gap."""
    style = imgui.get_style()
    needed = imgui.calc_text_size(text).x + 2 * style.frame_padding.x + style.item_spacing.x
    edge = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
    return bool(imgui.get_item_rect_max().x + needed <= edge)


def tip(words: str) -> None:
    """Shown when the mouse rests on the last item."""
    if imgui.is_item_hovered(int(imgui.HoveredFlags_.delay_normal)):
        imgui.set_tooltip(words)


def rows(name: str, values: list[tuple[str, str]]) -> None:
    """Names and values in two columns."""
    if not imgui.begin_table(name, 2):
        return
    for what, value in values:
        imgui.table_next_column()
        imgui.text_disabled(what)
        imgui.table_next_column()
        imgui.text(value)
    imgui.end_table()
