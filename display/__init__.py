"""From a complex field to the panel: grey levels, monitors, frames shown and logged.

Importing this opens no window and loads no graphics library.
"""

from chrmc.grey_levels import encode, encode_signal, signal_of, video_scale

__all__ = ["encode", "encode_signal", "signal_of", "video_scale"]
