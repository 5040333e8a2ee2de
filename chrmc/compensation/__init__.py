"""Video methods: what one frame can reuse of those before.

A video method is a function

    frames(scene, slm, wavelength, cgh, numbers, coding, **options) -> Iterator[VideoFrame]

with `numbers` a range of scene frames, `coding` the passband and carrier in use, and `cgh` a CGH
method's name or function. A method is one file here and one line below.
"""

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

from chrmc.cgh import Method, method_named
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.options import check_options, option_names
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
    "ch-rmc-object": "chrmc.compensation.ch_rmc_object.video",
    "ch-rmc-paper": "chrmc.compensation.ch_rmc_paper.paper",
}
_CH_RMC = "ch-rmc"  # either of the two, with the option `surface`
_OBJECT_CGH = "curved"  # whose basebands the object surface turns


def unaliased(
    compensation: "str | VideoMethod", options: dict[str, Any]
) -> "tuple[str | VideoMethod, dict[str, Any]]":
    """A registered name and its options: `ch-rmc` and its option `surface` mean one of two."""
    if compensation != _CH_RMC:
        return compensation, options
    others = dict(options)
    surface = others.pop("surface", "object")
    surfaces = [name.removeprefix("ch-rmc-") for name in COMPENSATIONS if _CH_RMC in name]
    if surface not in surfaces:
        raise ValueError(f"unknown surface {surface!r}: choose one of {', '.join(surfaces)}")
    return f"{_CH_RMC}-{surface}", others


def ch_rmc_for(cgh: "str | Method") -> str:
    """The CH-RMC method for a CGH method: the exact one where it works on its basebands."""
    return "ch-rmc-object" if cgh == _OBJECT_CGH else "ch-rmc-paper"


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


def _having(option: str) -> list[str]:
    """Names of the video methods that have an option of their own."""
    return [name for name in COMPENSATIONS if option in option_names(compensation_named(name))[0]]


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
    compensation, options = unaliased(compensation, options)
    method = compensation_named(compensation)
    check_options(f"compensation {compensation}", method, options, _having)
    options = method_named(cgh).with_cache(options)
    return method(scene, slm, wavelength, cgh, numbers, coding, **options)
