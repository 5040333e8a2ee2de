"""From a complex field to the panel: grey levels, monitors, frames shown and logged.

Importing this opens no window and loads no graphics library.
"""

from typing import TYPE_CHECKING

from chrmc.grey_levels import encode, encode_signal, signal_of, video_scale
from chrmc.lazy import lazily

if TYPE_CHECKING:
    from display.calibrate import calibrate_response
    from display.gl import Trigger
    from display.log import Flip
    from display.marks import SerialMark, UDPMark
    from display.monitors import Monitor, list_monitors
    from display.planes import pack_planes
    from display.player import play_together
    from display.playing import play
    from display.remote import Remote
    from display.screen import Screen
    from display.serve import Server

_LAZY = {
    "Screen": "display.screen",
    "Flip": "display.log",
    "Remote": "display.remote",
    "Trigger": "display.gl",
    "UDPMark": "display.marks",
    "SerialMark": "display.marks",
    "Monitor": "display.monitors",
    "list_monitors": "display.monitors",
    "play": "display.playing",
    "calibrate_response": "display.calibrate",
    "Server": "display.serve",
    "pack_planes": "display.planes",
    "play_together": "display.player",
}

__all__ = [
    "Flip",
    "Monitor",
    "Remote",
    "Screen",
    "SerialMark",
    "Server",
    "Trigger",
    "UDPMark",
    "calibrate_response",
    "encode",
    "encode_signal",
    "list_monitors",
    "pack_planes",
    "play",
    "play_together",
    "signal_of",
    "video_scale",
]

__getattr__ = lazily(__name__, _LAZY)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
