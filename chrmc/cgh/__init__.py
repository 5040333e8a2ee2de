"""CGH methods: one frame's points to the complex field on a window.

A method is a function

    field(cloud, slm, wavelength, window, passband, **accuracy) -> complex64 (window.shape)

that returns Σ w·a/r·exp(i(kr + φ)), absolutely scaled. Adding one is writing one file here and one
line below; a callable of that form is accepted wherever a method's name is.
"""

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.footprint import check_showable
from chrmc.optics.passband import Passband
from chrmc.options import check_options, option_names
from chrmc.reference import resolve_passband
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

Method = Callable[..., NDArray[np.complex64]]

# name: the module of this package whose `field` it is
METHODS = {
    "curved": "chrmc.cgh.curved",
    "rt": "chrmc.cgh.rt",
    "fresnel": "chrmc.cgh.fresnel",
    "wrp": "chrmc.cgh.wrp",
    "nlut": "chrmc.cgh.nlut",
    "nlut-1d": "chrmc.cgh.nlut_1d",
}


def method_named(method: "str | Method") -> Method:
    """The function of a method's name; a callable is returned as it is."""
    if callable(method):
        return method
    if method not in METHODS:
        raise ValueError(f"unknown CGH method {method!r}: choose one of {', '.join(METHODS)}")
    function: Method = import_module(METHODS[method]).field
    return function


def with_cache(method: "str | Method", options: dict[str, Any]) -> dict[str, Any]:
    """The options, with a cache to hold for a whole video where the method takes one.

    A method that takes `cache=` names what makes one `new_cache` in its module.
    """
    function = method_named(method)
    module = sys.modules.get(getattr(function, "__module__", None) or "")
    new_cache = getattr(module, "new_cache", None)
    if new_cache is None or "cache" in options or "cache" not in option_names(function)[0]:
        return options
    return {**options, "cache": new_cache()}


def compute_field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    method: "str | Method" = "rt",
    *,
    window: Window | None = None,
    passband: Passband | None = None,
    footprint: str | None = "soft",
    **options: Any,
) -> NDArray[np.complex64]:
    """Complex field of a cloud on the hologram plane.

    cloud : points, z > 0
    wavelength : metres
    method : a name in METHODS, or a function of that form
    window : part of the SLM, default all
    passband : what the soft footprint ends at, default the SLM's full band
    footprint : "soft", or None for bare spherical waves
    options : the method's own accuracy arguments

    Returns complex64 (H, W), Σ a/r·exp(+i(kr + φ)) with the footprint; zeros for no points.
    Raises ValueError for points behind the hologram or that no pixel can show.
    """
    band = resolve_passband(slm, footprint, passband)
    part = Window.full(slm) if window is None else window.check(slm)
    check_showable(cloud, slm, wavelength, band)
    function = method_named(method)
    check_options(f"CGH method {method}", function, options)
    if len(cloud) == 0 or part.size == 0:
        return np.zeros(part.shape, dtype=np.complex64)
    return function(cloud, slm, wavelength, part, band, **options)
