"""CGH methods: one frame's points to the complex field on a window.

What a method is says `chrmc.cgh.method`, where each has its line; a function of a method's form
is accepted wherever a method's name is.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.counts import STATED, OperationCounts
from chrmc.cgh.method import (
    DEFAULT_METHOD,
    METHODS,
    CGHMethod,
    Method,
    method_named,
)
from chrmc.encoding import Coding
from chrmc.optics.footprint import check_showable
from chrmc.optics.passband import Passband
from chrmc.options import option_names
from chrmc.ranges import WAVELENGTH_RANGE
from chrmc.reference import resolve_passband
from chrmc.scene.coincident import merged
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

__all__ = [
    "DEFAULT_METHOD",
    "METHODS",
    "CGHMethod",
    "Method",
    "OperationCounts",
    "compute_field",
    "field_and_error",
    "method_named",
    "signal_and_error",
]

TRUE_METHOD = "rt"
"""Sums the waves as they are."""
LONG = 20.0
"""Seconds, as stated, up to which no method is asked whether it pays."""


def compute_field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    method: str | Method = DEFAULT_METHOD,
    *,
    window: Window | None = None,
    passband: Passband | None = None,
    footprint: str | None = "soft",
    **options: Any,
) -> NDArray[np.complex64]:
    """Complex field of a cloud on the hologram plane.

    cloud : points, z > 0
    wavelength : metres
    method : a name in METHODS, FILE.py:NAME, a function of that form, or a `CGHMethod`
    window : part of the SLM, default all
    passband : what the soft footprint ends at, default the SLM's full band
    footprint : "soft", or None for bare spherical waves
    options : the method's own accuracy arguments

    Returns complex64 (H, W), Σ a/r·exp(+i(kr + φ)) with the footprint; zeros for no points.
    Raises ValueError for points behind the hologram or that no pixel can show.
    """
    return field_and_error(
        cloud,
        slm,
        wavelength,
        method,
        window=window,
        passband=passband,
        footprint=footprint,
        **options,
    )[0]


def field_and_error(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    method: str | Method,
    *,
    window: Window | None = None,
    passband: Passband | None = None,
    footprint: str | None = "soft",
    **options: Any,
) -> tuple[NDArray[np.complex64], float | None]:
    """`compute_field`, and the relative L2 error that the method expects of it, if it does."""
    wavelength = WAVELENGTH_RANGE.of(wavelength)
    band = resolve_passband(slm, footprint, passband)
    part = Window.full(slm) if window is None else window.check(slm)
    check_showable(cloud, slm, wavelength, band)
    chosen = method_named(method)
    chosen.check(options)
    if len(cloud) == 0 or part.size == 0:
        return np.zeros(part.shape, dtype=np.complex64), None
    cloud = merged(cloud)
    if chosen.field_and_error is None:
        _check_work(chosen, cloud, slm, wavelength, part, band, options)
        return chosen.field(cloud, slm, wavelength, part, band, **options), None
    return chosen.field_and_error(cloud, slm, wavelength, part, band, **options)


def _check_work(
    chosen: CGHMethod,
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    options: dict[str, Any],
) -> None:
    """ValueError where a short cut would take long, and longer than the true sum."""
    if chosen.cost is None:
        return
    known, _ = option_names(chosen.cost)
    own = {name: value for name, value in options.items() if name in known}
    counts = chosen.cost(cloud, slm, wavelength, window, passband, **own)
    seconds = STATED.seconds(counts, chosen.shares_cores)
    if seconds <= LONG:
        return
    true = method_named(TRUE_METHOD)
    assert true.cost is not None
    exact = STATED.seconds(true.cost(cloud, slm, wavelength, window, passband))
    if exact < seconds:
        raise ValueError(
            f"{chosen.name} would take about {seconds:.2g} s here, the true sum {exact:.2g} s: use "
            f"{TRUE_METHOD} or {DEFAULT_METHOD}"
        )


def signal_and_error(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    method: str | Method,
    coding: Coding,
    **options: Any,
) -> tuple[NDArray[np.float32], float | None]:
    """Re(field·exp(+2πi·carrier·y)), (H, W) float32, from a method that has a signal; its error."""
    wavelength = WAVELENGTH_RANGE.of(wavelength)
    check_showable(cloud, slm, wavelength, coding.passband)
    chosen = method_named(method)
    chosen.check(options)
    if len(cloud) == 0:
        return np.zeros(slm.shape, dtype=np.float32), None
    cloud = merged(cloud)
    window = Window.full(slm)
    if chosen.signal_and_error is not None:
        return chosen.signal_and_error(cloud, slm, wavelength, window, coding, **options)
    if chosen.signal is None:
        raise ValueError(f"CGH method {chosen.name} makes a field only; take its real part")
    return chosen.signal(cloud, slm, wavelength, window, coding, **options), None
