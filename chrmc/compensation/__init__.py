"""Video methods: what one frame can reuse of those before.

A video method is a function

    frames(scene, slm, wavelength, cgh, numbers, coding, **options) -> Iterator[VideoFrame]

with `numbers` a range of scene frames, `coding` the passband and carrier in use, and `cgh` a CGH
method's name or function. A method is one file here and one line below.
"""

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

from chrmc.cgh import Method, with_cache
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.options import check_options
from chrmc.scene.scene import Scene, frame_range
from chrmc.slm import SLM, WAVELENGTH

VideoMethod = Callable[..., Iterator[VideoFrame]]

# name: the module of this package whose `frames` it is
COMPENSATIONS = {
    "none": "chrmc.compensation.none",
    "tr-nlut": "chrmc.compensation.nlut.tr_nlut",
    "mc-nlut": "chrmc.compensation.nlut.mc_nlut",
    "mpeg-nlut": "chrmc.compensation.nlut.mpeg_nlut",
    "3dmc-nlut": "chrmc.compensation.nlut.three_d_mc_nlut",
    "ch-rmc": "chrmc.compensation.ch_rmc",
}


def compensation_named(compensation: "str | VideoMethod") -> VideoMethod:
    """The function of a video method's name; a callable is returned as it is."""
    if callable(compensation):
        return compensation
    if compensation not in COMPENSATIONS:
        raise ValueError(
            f"unknown compensation {compensation!r}: choose one of {', '.join(COMPENSATIONS)}"
        )
    function: VideoMethod = import_module(COMPENSATIONS[compensation]).frames
    return function


def video(
    scene: Scene,
    slm: SLM,
    wavelength: float = WAVELENGTH,
    *,
    cgh: "str | Method" = "rt",
    compensation: "str | VideoMethod" = "none",
    frames: tuple[int, int] | None = None,
    coding: Coding | str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames of a hologram video, one after the other.

    scene : from `load_scene`, or any object with the `Scene` attributes
    cgh : CGH method; compensation : video method
    frames : (first, last), inclusive, from 1; default all
    coding : an encoding ("ssb" limits the field to its half band) or its name; default the
        full band without a carrier
    options : what the video method and the CGH method take

    Yields VideoFrame with .number, .cloud, .field (complex64 (H, W), made when asked for) and
    .record.
    """
    numbers = frame_range(scene, frames)
    if not isinstance(coding, Coding):
        coding = coding_for("real" if coding is None else coding, slm)
    method = compensation_named(compensation)
    check_options(f"compensation {compensation}", method, options)
    options = with_cache(cgh, options)
    return method(scene, slm, wavelength, cgh, numbers, coding, **options)
