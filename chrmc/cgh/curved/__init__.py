"""Curved hologram: the field as a low-rank matrix around each cluster's spherical wave.

A cluster's field is S(x, y)·m(x, y), S the separable reference wave from its centre. The baseband
m varies slowly, so that a few hundred Chebyshev nodes in x and about a hundred in y fix it, and
the hologram is A_y·M·A_x: two matrix products, no per-pixel transcendental.
"""

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved import clusters
from chrmc.cgh.curved.assembly import Factor, add_field, add_signal, phasor, reference_cycles
from chrmc.cgh.curved.baseband import make_factor
from chrmc.cgh.curved.clusters import Plane
from chrmc.coding import Coding, Passband
from chrmc.footprint import reach
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM
from chrmc.window import Window

TOLERANCES = (1e-6, 1e-1)
"""Smallest and largest relative L2 error that can be asked for."""


def check_tolerance(tolerance: float) -> float:
    """Itself, or ValueError outside TOLERANCES."""
    low, high = TOLERANCES
    if not low <= tolerance <= high:
        raise ValueError(
            f"tolerance must lie between {low:g} and {high:g}, not {tolerance:g}: single "
            "precision ends at the one, and the other is already a tenth of the light"
        )
    return tolerance


def plane_of(slm: SLM, wavelength: float, window: Window, passband: Passband) -> Plane:
    """The window's pixel centres and the footprint's reach, as clusters are planned on."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    return Plane(
        (float(x[0]), float(x[-1]), len(x)),
        (float(y[0]), float(y[-1]), len(y)),
        wavelength,
        (reach(wavelength, passband.fx_max), reach(wavelength, passband.fy_max)),
    )


def factors(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> list[Factor]:
    """The cloud's hologram on a window, in low-rank form, cluster by cluster."""
    check_tolerance(tolerance)
    targets = slm.x(window.columns), slm.y(window.rows)
    plane = plane_of(slm, wavelength, window, passband)
    parts = clusters.split(cloud, plane)
    made = [make_factor(part, targets, slm.pixel_pitch, plane, tolerance) for part in parts]
    return [factor for factor, _ in made]


def field_of(
    parts: list[Factor], slm: SLM, wavelength: float, window: Window
) -> NDArray[np.complex64]:
    """(H, W) complex64 field from factors."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    out = np.zeros(window.shape, dtype=np.complex64)
    for number, part in enumerate(parts):
        its = part.reference
        add_field(
            out,
            part,
            phasor(reference_cycles(x, its.x, its.z, wavelength)),
            phasor(reference_cycles(y, its.y, its.z, wavelength)),
            add=number > 0,
        )
    return out


def signal_of(
    parts: list[Factor], slm: SLM, wavelength: float, window: Window, carrier: float
) -> NDArray[np.float32]:
    """(H, W) float32 Re(field·exp(+2πi·carrier·y)) from factors, without a complex field."""
    x, y = slm.x(window.columns), slm.y(window.rows)
    out = np.zeros(window.shape, dtype=np.float32)
    for number, part in enumerate(parts):
        its = part.reference
        add_signal(
            out,
            part,
            phasor(reference_cycles(x, its.x, its.z, wavelength)),
            phasor(reference_cycles(y, its.y, its.z, wavelength) + carrier * y),
            add=number > 0,
        )
    return out


def field(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    passband: Passband,
    *,
    tolerance: float = 1e-3,
) -> NDArray[np.complex64]:
    """Complex field on the window.

    tolerance : relative L2 error of the field against the float64 sum of spherical waves with
        the soft footprint, 1e-6 to 1e-1

    Returns complex64 (H, W), Σ w·a/r·exp(i(kr + φ)).
    """
    parts = factors(cloud, slm, wavelength, window, passband, tolerance=tolerance)
    return field_of(parts, slm, wavelength, window)


def signal(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    window: Window,
    coding: Coding,
    *,
    tolerance: float = 1e-3,
) -> NDArray[np.float32]:
    """Re(field·exp(+2πi·carrier·y)) on the window, (H, W) float32, for half the work of `field`."""
    parts = factors(cloud, slm, wavelength, window, coding.passband, tolerance=tolerance)
    return signal_of(parts, slm, wavelength, window, coding.carrier)
