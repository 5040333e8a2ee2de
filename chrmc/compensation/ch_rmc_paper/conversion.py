"""Planar to curved hologram and back, as published: Eqs 5–13 of the CH-RMC paper.

Around the centre O = (x_O, z_O) of the object's circle lies the curved hologram, a cylinder of
fixed radius R; the local planar hologram (LPH) is its chord plane, as wide as the SLM and centred
on x_O. Light that goes from the chord to the cylinder is taken to keep its column (Eq. 5), so the
conversion is a product with T(x) = exp(ikz(x)).
"""

import warnings
from math import asin, sqrt, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.propagation import cycles_to_phasor
from chrmc.slm import SLM

RADIUS = 0.145
"""The paper's radius of the curved hologram, metres."""
_FLAT = 1e6  # metres: an arc across 20 mm bulges by 5e-11 m


def sagitta(radius: float, width: float) -> float:
    """z0 of Eq. 9: how far the cylinder bulges out of a chord of the given width, metres."""
    return radius - sqrt(radius**2 - (width / 2) ** 2)


def one_pixel_distance(pixel_pitch: float, wavelength: float) -> float:
    """The distance at which W of Eq. 6 reaches the pixel pitch, metres; ValueError where the panel
    bends light by any angle."""
    if wavelength >= 2 * pixel_pitch:
        raise ValueError(
            f"the paper's surface needs pixels of more than half a wavelength, "
            f"{wavelength / 2 * 1e6:.4g} µm, not {pixel_pitch * 1e6:.4g} µm: use surface object"
        )
    return pixel_pitch / tan(asin(wavelength / (2 * pixel_pitch)))


def check_radius(radius: float, slm: SLM, wavelength: float) -> float:
    """The radius itself.

    ValueError when no circle of it spans the hologram; a warning when light crosses from one
    column to the next between plane and cylinder, W(z0) > pixel_pitch, which Eq. 5 neglects.
    """
    width = slm.width * slm.pixel_pitch
    if not (np.isfinite(radius) and radius > width / 2):
        raise ValueError(
            f"a circle of radius {radius * 1e3:.4g} mm cannot span a hologram "
            f"{width * 1e3:.4g} mm wide: take radius > {width / 2 * 1e3:.4g} mm"
        )
    if radius > _FLAT:
        raise ValueError(f"a circle of radius {radius:.4g} m is flat: take {_FLAT:g} m at most")
    depth = sagitta(radius, width)
    limit = one_pixel_distance(slm.pixel_pitch, wavelength)
    if depth > limit:
        least = (limit**2 + (width / 2) ** 2) / (2 * limit)
        warnings.warn(
            f"radius {radius * 1e3:.4g} mm bulges {depth * 1e6:.0f} µm, past the {limit * 1e6:.0f} "
            f"µm over which light keeps its pixel; take at least {least * 1e3:.4g} mm",
            stacklevel=2,
        )
    return radius


def gap(x: NDArray[np.float64], radius: float, z0: float) -> NDArray[np.float64]:
    """z(x) of Eq. 8, metres: from the plane to the cylinder at x from the circle's axis.

    Negative where the cylinder lies behind the plane, past the chord's ends. ValueError where
    |x| > radius.
    """
    if np.any(np.abs(x) > radius):
        raise ValueError(
            f"the circle of radius {radius * 1e3:.4g} mm ends before "
            f"x = {np.abs(x).max() * 1e3:.4g} mm"
        )
    return z0 - radius + np.sqrt(radius**2 - x**2)


def conversion_table(
    x: NDArray[np.float64], radius: float, z0: float, wavelength: float
) -> NDArray[np.complex64]:
    """T of Eq. 7, one value per column: exp(ik·z(x))."""
    return cycles_to_phasor(gap(x, radius, z0) / wavelength)


def to_curved(
    planar: NDArray[np.complexfloating[Any, Any]], table: NDArray[np.complex64]
) -> NDArray[np.complexfloating[Any, Any]]:
    """Eq. 10: the curved hologram of a planar one, (…, columns)."""
    return planar * table


def to_planar(
    curved: NDArray[np.complexfloating[Any, Any]], table: NDArray[np.complex64]
) -> NDArray[np.complexfloating[Any, Any]]:
    """Eq. 13: the planar hologram of a curved one; |T| = 1, so 1/T is its conjugate."""
    return curved * table.conj()
