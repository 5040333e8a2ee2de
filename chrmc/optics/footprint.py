"""Where a point's fringe can be shown without aliasing, and the soft edge that ends it.

The footprint of a point at depth z is the rectangle |x − x_j| ≤ L_x, |y − y_j| ≤ L_y with
L = z·tan(asin(λ·f_max)): inside it the fringe's local frequency stays below f_max. Its weight is
1 up to 0.9 L, falls as cos² to 0 at L, and is the product of both axes.
"""

from math import asin, inf, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.optics.passband import Passband
from chrmc.ranges import DISTANCE_RANGE, WAVELENGTH_RANGE
from chrmc.scene.points import PointCloud
from chrmc.slm import SLM

SOFT_SHARE = 0.1
"""Outer share of the half-width over which the weight falls from 1 to 0."""


LIGHT = (1e-18, 1e18)
"""Amplitude over distance of the brightest points: its square has to fit single precision too."""


def reach(wavelength: float, f_max: float) -> float:
    """tan(asin(λ·f_max)): half-width of a footprint per unit of depth; inf from λ·f_max = 1 on."""
    s = wavelength * f_max
    return tan(asin(s)) if s < 1 else inf


def shown_from(
    at: NDArray[np.float64],
    z: NDArray[np.float64] | float,
    half: float,
    wavelength: float,
    f_max: float,
) -> NDArray[np.float64]:
    """Middle of the part of a panel that shows points, along one axis, metres.

    half : of the panel's width
    """
    far = z * reach(wavelength, f_max)
    return (np.maximum(at - far, -half) + np.minimum(at + far, half)) / 2


def taper(offset: NDArray[Any], half_width: NDArray[Any]) -> NDArray[Any]:
    """Soft weight of one axis, broadcast over offset and half_width (metres), in [0, 1].

    In the offset's precision.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        # Large arrays meet only small ones here: half-widths belong to points, offsets to pixels.
        inward = np.abs(offset) * (-1 / (SOFT_SHARE * half_width)).astype(offset.dtype)
    inward += inward.dtype.type(1 / SOFT_SHARE)
    # Not a number is 0/0: on the axis of no footprint.
    np.fmax(np.fmin(inward, 1, out=inward), 0, out=inward)
    soft = (inward > 0) & (inward < 1)
    inward[soft] = np.sin(inward[soft] * inward.dtype.type(np.pi / 2)) ** 2
    return inward


def check_showable(cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband) -> None:
    """ValueError when a point stands behind the hologram, or no pixel lies in its footprint."""
    WAVELENGTH_RANGE.of(wavelength)
    if len(cloud) == 0:
        return
    z = cloud.positions[:, 2]
    behind = z <= 0
    if behind.any():
        raise ValueError(
            f"{int(behind.sum())} of {len(cloud)} points stand at or behind the hologram plane "
            f"(smallest z {z.min() * 1e3:.4g} mm): move the scene to z > 0"
        )
    if z.max() > DISTANCE_RANGE.high:
        DISTANCE_RANGE.of(z.max())
    light = np.abs(cloud.amplitude).max() / z.min()
    if light and not LIGHT[0] <= light <= LIGHT[1]:
        raise ValueError(
            f"the brightest points make {light:.3g} on the hologram, amplitude over distance, and "
            f"single precision holds {LIGHT[0]:g} to {LIGHT[1]:g}: scale the amplitudes"
        )
    overshoot = np.full(len(cloud), -inf)
    for axis, (count, f_max) in enumerate(
        ((slm.width, passband.fx_max), (slm.height, passband.fy_max))
    ):
        # The nearest pixel centre to a coordinate, clipped to the panel.
        index = np.clip(
            np.rint(cloud.positions[:, axis] / slm.pixel_pitch + (count - 1) / 2), 0, count - 1
        )
        centre = (index - (count - 1) / 2) * slm.pixel_pitch
        gap = np.abs(cloud.positions[:, axis] - centre)
        overshoot = np.maximum(overshoot, gap - z * reach(wavelength, f_max))
    lost = overshoot >= 0
    if lost.any():
        raise ValueError(
            f"{int(lost.sum())} of {len(cloud)} points can be shown by no pixel of {slm.name}: "
            f"up to {overshoot.max() * 1e3:.4g} mm outside what it diffracts to; move them "
            "towards the axis or farther away"
        )


def pixels_within(
    cloud: PointCloud,
    slm: SLM,
    wavelength: float,
    passband: Passband,
    number: int,
    random: np.random.Generator,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns, (N, number) each, drawn from the pixels in each point's footprint."""
    out = []
    for axis, (count, f_max) in enumerate(
        ((slm.width, passband.fx_max), (slm.height, passband.fy_max))
    ):
        middle = cloud.positions[:, axis] / slm.pixel_pitch + (count - 1) / 2
        half = cloud.positions[:, 2] * reach(wavelength, f_max) / slm.pixel_pitch
        low = np.clip(np.ceil(middle - half), 0, count - 1)
        high = np.clip(np.floor(middle + half), low, count - 1)
        place = random.random((len(cloud), number))
        out.append((low[:, None] + place * (high - low + 1)[:, None]).astype(np.intp))
    columns, rows = out
    return rows, columns


def coverage(
    cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
) -> NDArray[np.float64]:
    """(N,) share of the SLM's pixels that lie in each point's footprint."""
    share = np.ones(len(cloud))
    z = cloud.positions[:, 2]
    for axis, (count, f_max) in enumerate(
        ((slm.width, passband.fx_max), (slm.height, passband.fy_max))
    ):
        half = z * reach(wavelength, f_max)
        edge = (count / 2) * slm.pixel_pitch
        low = np.maximum(cloud.positions[:, axis] - half, -edge)
        high = np.minimum(cloud.positions[:, axis] + half, edge)
        share *= np.clip((high - low) / (2 * edge), 0, 1)
    return share


def expected_power(
    cloud: PointCloud, slm: SLM, wavelength: float, passband: Passband
) -> NDArray[np.float64]:
    """(N,) mean over all pixels of (a/z)²·weight²; r and z differ by 0.1 % at most at 1.88°.

    Points of random phase add in power, so the sum over points is the mean intensity that the
    field is expected to have: it sets a video's grey scale without computing a field.
    """
    if len(cloud) == 0:
        return np.zeros(0)
    z = cloud.positions[:, 2]
    power = (cloud.amplitude / z) ** 2
    for axis, (pixels, f_max) in enumerate(
        ((slm.x(), passband.fx_max), (slm.y(), passband.fy_max))
    ):
        half = z * reach(wavelength, f_max)
        edge = (pixels[-1] - pixels[0] + slm.pixel_pitch) / 2
        at = cloud.positions[:, axis]
        lit = _lit_length((edge - at) / half) + _lit_length((edge + at) / half)
        with np.errstate(invalid="ignore"):
            share = np.clip(lit * half / (2 * edge), 0, 1)
        power = power * np.where(np.isfinite(half), share, 1.0)
    return power


def _lit_length(end: NDArray[np.float64]) -> NDArray[np.float64]:
    """∫ taper² from 0 to `end`, in half-widths and odd in it: the antiderivative of cos⁴."""
    length = np.abs(end)
    u = np.clip((length - (1 - SOFT_SHARE)) / SOFT_SHARE, 0, 1)
    soft = 3 / 8 * u + np.sin(np.pi * u) / (2 * np.pi) + np.sin(2 * np.pi * u) / (16 * np.pi)
    return np.sign(end) * (np.minimum(length, 1 - SOFT_SHARE) + SOFT_SHARE * soft)
