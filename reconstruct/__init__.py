"""reconstruct: what a hologram's grey levels show, through the 4-f system, and whether it is right.

Grey levels → 4-f → image → verdict.
"""

from chrmc.lazy import lazily
from reconstruct.bench import Bench, Filter, Illumination
from reconstruct.colour import colour_image, colour_levels, colour_picture
from reconstruct.four_f_system import FourF, decode_field, four_f, four_f_field

_LAZY = {
    "Camera": "reconstruct.camera",
    "FrameVerdict": "reconstruct.verdict",
    "ObjectVerdict": "reconstruct.verdict",
    "ViewerModel": "reconstruct.viewer.model",
    "all_in_focus": "reconstruct.stack",
    "check": "reconstruct.checking",
    "find_focus": "reconstruct.focus",
    "focal_stack": "reconstruct.stack",
    "system_of": "reconstruct.sequence",
    "write_image": "reconstruct.images",
}

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

__getattr__ = lazily(__name__, _LAZY)
