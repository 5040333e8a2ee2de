"""reconstruct: what a hologram's grey levels show, through the 4-f system, and whether it is right.

Grey levels → 4-f → image → verdict.
"""

from importlib import import_module
from typing import Any

from reconstruct.bench import Bench, Filter, Illumination
from reconstruct.colour import colour_image, colour_levels, colour_picture
from reconstruct.four_f_system import FourF, decode_field, four_f, four_f_field

_ON_DEMAND = {
    "Camera": "camera",
    "FrameVerdict": "verdict",
    "ObjectVerdict": "verdict",
    "ViewerModel": "viewer.model",
    "all_in_focus": "stack",
    "check": "checking",
    "find_focus": "focus",
    "focal_stack": "stack",
    "system_of": "sequence",
    "write_image": "images",
}
"""Names whose modules are read when they are asked for."""

__all__ = [
    "Bench",
    "Camera",
    "Filter",
    "FourF",
    "FrameVerdict",
    "Illumination",
    "ObjectVerdict",
    "ViewerModel",
    "all_in_focus",
    "check",
    "colour_image",
    "colour_levels",
    "colour_picture",
    "decode_field",
    "find_focus",
    "focal_stack",
    "four_f",
    "four_f_field",
    "system_of",
    "write_image",
]


def __getattr__(name: str) -> Any:
    if name in _ON_DEMAND:
        return getattr(import_module(f"reconstruct.{_ON_DEMAND[name]}"), name)
    raise AttributeError(f"module 'reconstruct' has no attribute {name!r}")
