"""Video methods: what one frame can reuse of those before.

A video method is a function

    frames(scene, slm, wavelength, cgh, numbers, coding, **options) -> Iterator[VideoFrame]

with `numbers` a range of scene frames, `coding` the passband and carrier in use, and `cgh` a CGH
method's name or function. A method is one file here and one line below.
"""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import Any

from chrmc.cgh import DEFAULT_METHOD, METHODS, Method, method_named
from chrmc.compensation.frame import VideoFrame
from chrmc.encoding import Coding, coding_for
from chrmc.options import check_options, meant, option_names
from chrmc.python_file import function_from_python_file, is_python_name, label
from chrmc.ranges import TOLERANCE_RANGE, WAVELENGTH_RANGE
from chrmc.scene.scene import Scene, as_scene, frame_range
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
# name: the module whose `cost` counts what each object will take; the plan looks at these
COUNTED = {"ch-rmc-object": "chrmc.compensation.ch_rmc_object.cost"}
# the same of a whole frame, a `VideoCost`
COUNTED_WHOLE = {
    "tr-nlut": "chrmc.compensation.nlut.cost",
    "mc-nlut": "chrmc.compensation.nlut.cost",
    "mpeg-nlut": "chrmc.compensation.nlut.cost",
    "3dmc-nlut": "chrmc.compensation.nlut.cost",
    "ch-rmc-paper": "chrmc.compensation.ch_rmc_paper.cost",
}
DEFAULT_TOLERANCE = 1e-3
AUTO = "auto"
"""What the plan takes, where both methods are left to it; beside a named one, the default."""
_CH_RMC = "ch-rmc"  # either of the two, with the option `surface`
OBJECT_CGH = "curved"  # whose basebands the object surface turns


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
    return "ch-rmc-object" if cgh == OBJECT_CGH else "ch-rmc-paper"


def compensation_named(compensation: "str | VideoMethod") -> VideoMethod:
    """The function of a video method's name; a callable is returned as it is."""
    if is_python_name(compensation):
        compensation = function_from_python_file(compensation)
    if callable(compensation):
        return compensation
    if compensation not in COMPENSATIONS:
        raise ValueError(
            f"unknown compensation {compensation!r}{meant(compensation, COMPENSATIONS)}: "
            f"choose one of {', '.join(COMPENSATIONS)}"
        )
    function: VideoMethod = import_module(COMPENSATIONS[compensation]).frames
    return function


def _having(option: str) -> list[str]:
    """Names of the video methods that have an option of their own, and of the CGH methods."""
    videos = [name for name in COMPENSATIONS if option in option_names(compensation_named(name))[0]]
    return videos + [f"cgh {name}" for name in METHODS if method_named(name).takes(option)]


def chosen(
    cgh: "str | Method | None" = None,
    compensation: "str | VideoMethod | None" = None,
    surface: str | None = None,
    tolerance: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> "tuple[str | Method, str | VideoMethod, dict[str, Any]]":
    """The CGH method, the video method and their options that these choices mean.

    The one place of the defaults: the exact CGH method at a tolerance of 1e-3; with it the CH-RMC
    that is exact too, with any other no compensation. ValueError where choices do not fit.
    """
    if cgh is None or cgh == AUTO:
        cgh = DEFAULT_METHOD
    all_options = dict(options or {})
    if compensation is None or compensation == AUTO:
        exact = ch_rmc_for(cgh) == "ch-rmc-object"
        compensation = _CH_RMC if exact or surface is not None else "none"
    if compensation == _CH_RMC:
        surface = all_options.pop("surface", surface)
        compensation = ch_rmc_for(cgh)
        if surface is not None:
            compensation, _ = unaliased(_CH_RMC, {"surface": surface})
    elif surface is not None:
        raise ValueError(f"a surface belongs to compensation ch-rmc, not to {label(compensation)}")
    video_method = compensation_named(compensation)
    if tolerance is not None:
        tolerance = TOLERANCE_RANGE.of(tolerance)
        if compensation != "none" and "tolerance" not in option_names(video_method)[0]:
            raise ValueError(
                f"compensation {label(compensation)} cannot promise a tolerance of "
                f"{tolerance:g}: use ch-rmc-object, none, or rekey_error on the paper's surface"
            )
        if not method_named(cgh).takes("tolerance"):
            having = [name for name in METHODS if method_named(name).takes("tolerance")]
            raise ValueError(
                f"CGH method {label(cgh)} has no tolerance to set: leave it out, or use "
                f"{', '.join(having)}"
            )
        all_options.setdefault("tolerance", tolerance)
    elif "tolerance" in option_names(method_named(cgh).field)[0]:
        all_options.setdefault("tolerance", DEFAULT_TOLERANCE)
    kind = f"compensation {label(compensation)}"
    names, others = option_names(method_named(cgh).field)
    if option_names(video_method)[1]:
        kind += f" with {label(cgh)}"
    # What `compute_field` itself takes goes with them.
    check_options(
        kind, video_method, all_options, _having, None if others else [*names, "footprint"]
    )
    return cgh, compensation, all_options


def video(
    scene: Scene,
    slm: SLM,
    wavelength: float | None = None,
    *,
    cgh: "str | Method | None" = None,
    compensation: "str | VideoMethod | None" = None,
    tolerance: float | None = None,
    frames: tuple[int, int] | None = None,
    coding: Coding | str | None = None,
    **options: Any,
) -> Iterator[VideoFrame]:
    """Frames of a hologram video, one after the other.

    scene : from `load_scene`, or any object with the `Scene` attributes
    wavelength : metres; default the scene's, else 532 nm
    cgh : CGH method; compensation : video method; each a name, FILE.py:NAME or a function;
        default "curved", and "ch-rmc" with it, "none" with another
    tolerance : largest relative field error, default 1e-3 where the methods promise one
    frames : (first, last), inclusive, from 1; default all
    coding : an encoding ("ssb" limits the field to its half band) or its name; default the
        full band without a carrier
    options : what the video method and the CGH method take

    Yields VideoFrame with .number, .cloud, .field (complex64 (H, W), made when asked for) and
    .record.
    """
    scene = as_scene(scene)
    wavelength = scene_wavelength(scene, wavelength)
    if not isinstance(coding, Coding):
        coding = coding_for("real" if coding is None else coding, slm)
    choices = chosen(cgh, compensation, None, tolerance, options)
    return frames_by(scene, slm, wavelength, coding, frame_range(scene, frames), *choices)


def frames_by(
    scene: Scene,
    slm: SLM,
    wavelength: float,
    coding: Coding,
    numbers: range,
    cgh: "str | Method",
    compensation: "str | VideoMethod",
    options: dict[str, Any],
) -> Iterator[VideoFrame]:
    """Frames by methods and options as `chosen` gives them."""
    method = compensation_named(compensation)
    options = method_named(cgh).with_cache(options)
    return method(scene, slm, wavelength, cgh, numbers, coding, **options)


def scene_wavelength(scene: Scene, asked: float | None) -> float:
    """The user's wavelength, else the scene's, else the default; metres."""
    for wavelength in (asked, scene.wavelength):
        if wavelength is not None:
            return WAVELENGTH_RANGE.of(wavelength)
    return WAVELENGTH
