"""What opens over the window: the keys, and the question what to open."""

from imgui_bundle import imgui

from reconstruct.viewer.keys import KEYS, MOUSE
from reconstruct.viewer.session import Session
from reconstruct.viewer.widgets import button, em

ImVec2 = imgui.ImVec2


def help_overlay(session: Session, width: float, height: float) -> None:
    """All keys, over everything."""
    if not session.help:
        return
    imgui.set_next_window_pos(ImVec2(width / 2, height / 2), 0, ImVec2(0.5, 0.5))
    imgui.set_next_window_bg_alpha(0.96)
    flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.always_auto_resize
    imgui.begin("keys", None, int(flags | imgui.WindowFlags_.no_saved_settings))
    imgui.set_window_focus()
    lines = [(k.name, k.words) for k in KEYS] + list(MOUSE)
    half = (len(lines) + 1) // 2
    if imgui.begin_table("all keys", 4, int(imgui.TableFlags_.sizing_fixed_fit)):
        for left in range(half):
            for at in (left, left + half):
                imgui.table_next_column()
                if at < len(lines):
                    imgui.text(lines[at][0])
                imgui.table_next_column()
                if at < len(lines):
                    imgui.text_disabled(lines[at][1] + "    ")
        imgui.end_table()
    if button("Close", 6):
        session.help = False
    imgui.end()


def ask_to_open(session: Session, width: float) -> None:
    """A path to type, and what was opened lately."""
    if not session.asking:
        return
    imgui.set_next_window_pos(ImVec2(width / 2, 5 * em()), 0, ImVec2(0.5, 0.0))
    imgui.set_next_window_size(ImVec2(min(46 * em(), width - 4 * em()), 0))
    flags = imgui.WindowFlags_.no_collapse | imgui.WindowFlags_.always_auto_resize
    flags |= imgui.WindowFlags_.no_saved_settings
    _, still = imgui.begin("Open a video's folder or a picture", True, int(flags))
    if not still:
        session.asking = False
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(-1.0)
    flags_ = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
    given, session.path = imgui.input_text("##path", session.path, int(flags_))
    chosen = session.path if given or button("Open##path", 6) else ""
    imgui.same_line()
    imgui.text_disabled("or drop it on the window")
    for path in session.recent():
        if imgui.selectable(str(path), False)[0]:
            chosen = str(path)
    if session.told:
        imgui.text_wrapped(session.told)
    imgui.end()
    if chosen and session.open(chosen):
        session.asking = False
