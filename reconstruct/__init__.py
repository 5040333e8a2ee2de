"""reconstruct: what a hologram's grey levels show, through the 4-f system, and whether it is right.

Grey levels → 4-f → image → verdict.
"""

from typing import Any

from reconstruct.bench import Bench, Filter, Illumination
from reconstruct.colour import colour_picture
from reconstruct.four_f_system import FourF, decode_field, four_f, four_f_field

__all__ = [
    "Bench",
    "Filter",
    "FourF",
    "Illumination",
    "check",
    "colour_picture",
    "decode_field",
    "four_f",
    "four_f_field",
]


def __getattr__(name: str) -> Any:
    if name == "check":  # with SciPy and the pictures' readers, so only when it is asked for
        from reconstruct.checking import check

        return check
    raise AttributeError(f"module 'reconstruct' has no attribute {name!r}")
