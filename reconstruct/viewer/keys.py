"""Every key of the viewer: one table for the window, the help overlay and the command's help."""

from typing import NamedTuple


class Key(NamedTuple):
    """A key as it is written, what it does in words, and the `Session`'s method for it."""

    name: str
    words: str
    action: str


KEYS = (
    Key("Space", "play or pause", "play"),
    Key("Left", "frame before", "frame_before"),
    Key("Right", "frame after", "frame_after"),
    Key("Home", "first frame", "first_frame"),
    Key("End", "last frame", "last_frame"),
    Key("Up", "depth + 0.1 mm", "deeper"),
    Key("Down", "depth − 0.1 mm", "nearer"),
    Key("PageUp", "depth + 1 mm", "much_deeper"),
    Key("PageDown", "depth − 1 mm", "much_nearer"),
    Key("O", "depth of the next object", "next_object"),
    Key("C", "focus curves of all objects", "find_curves"),
    Key("1", "show intensity", "show_intensity"),
    Key("2", "show log of intensity", "show_log"),
    Key("3", "show phase", "show_phase"),
    Key("M", "next colours", "next_colours"),
    Key("F", "fit pictures into the window", "fit"),
    Key("L", "ruler and profile: drag a line", "use_line"),
    Key("R", "statistics: drag a region", "use_region"),
    Key("Tab", "hologram and Fourier plane of A or B", "other_video"),
    Key("W", "compare: side by side, wipe, difference", "next_mode"),
    Key("S", "save the picture (PNG)", "save_picture"),
    Key("E", "save intensities (EXR)", "save_intensities"),
    Key("G", "save a figure (PDF)", "save_figure"),
    Key("Ctrl+O", "open a video or picture", "ask_to_open"),
    Key("Ctrl+Z", "back to the view before", "undo"),
    Key("Ctrl+Y", "forward again", "redo"),
    Key("H", "this help", "toggle_help"),
    Key("Escape", "close lists and help, drop marks, stop work", "escape"),
    Key("Q", "leave", "leave"),
)
MOUSE = (
    ("click", "focus there"),
    ("wheel", "zoom"),
    ("drag", "move; with the right button whatever the tool"),
    ("double right click", "fit"),
    ("drop", "open a folder or picture"),
)


def action_of(name: str) -> str | None:
    """The method for a key as it is written, such as "Ctrl+Z"."""
    for key in KEYS:
        if key.name == name:
            return key.action
    return None
