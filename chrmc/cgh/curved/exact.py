"""The exact sum, kept or refused: what double precision leaves where waves all but cancel."""

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from chrmc.cgh.curved.direct import direct_field
from chrmc.cgh.curved.refusal import Refusal
from chrmc.optics.footprint import taper
from chrmc.scene.points import PointCloud

Floats = NDArray[np.float64]

_WAVE_ERROR = 5e-16  # of a wave in double precision, beside that of its path
_DRAWS = 3.0  # times what rounding leaves on the whole: one pixel may have it
_LONGER, _SEEN = 1e-2, 12  # precision of longer floats to be of use; pixels that they are used on
_POINTS, _TABLES = 1 << 15, 1 << 22  # in longer floats; and weights, held at once


def exact_field(
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
    tolerance: float,
) -> NDArray[np.complex128]:
    """(len(y), len(x)) exact field; Refusal where rounding leaves more than a tolerance."""
    given = cloud, x, y, wavelength, reach
    total = direct_field(*given)
    rounding = rounding_of(total, *given)
    if _DRAWS * rounding > tolerance:
        rounding = min(rounding, rounding_seen(total, *given))
    if _DRAWS * rounding > tolerance:
        raise Refusal(
            f"a tolerance of {tolerance:g} cannot be kept here: waves all but cancel, and double "
            f"precision holds what is left to {rounding:.2g}; leave out points that cancel each "
            "other, or allow more"
        )
    return total


def rounding_of(
    field: NDArray[np.complex128],
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
) -> float:
    """Relative error that double precision leaves of a field at x, y, which waves may cancel in.

    An upper bound of unrelated errors; infinite where waves leave nothing at all.
    """
    left = float(np.vdot(field, field).real)
    z = cloud.positions[:, 2]
    ends = np.array([np.abs(t).max() for t in (x, y)])
    farthest = np.abs(cloud.positions[:, :2]) + ends
    lateral = np.hypot(*farthest.T)
    offset = np.hypot(*np.minimum(farthest, z[:, None] * np.array(reach)).T)
    # Paths and coordinates have so many digits, of which whole wavelengths take most.
    distance = np.hypot(offset, z)
    metres = z + offset**2 / (distance + z) + lateral * offset / distance
    error = _WAVE_ERROR + pi * np.finfo(np.float64).eps * metres / wavelength
    power = (cloud.amplitude * error / z) ** 2
    if left >= 1e16 * field.size * power.sum():
        return 1e-8
    step = max(1, _TABLES // (len(x) + len(y)))
    for first in range(0, len(cloud), step):
        some = slice(first, first + step)
        for axis, (t, far) in enumerate(zip((x, y), reach, strict=True)):
            aside = t - cloud.positions[some, axis, None]
            weight = taper(aside, (z[some] * far)[:, None])
            power[some] *= np.sum(weight**2 / (1 + (aside / z[some, None]) ** 2), axis=1)
    if left == 0:
        return np.inf if power.any() else 0.0
    return sqrt(power.sum() / left)


def rounding_seen(
    field: NDArray[np.complex128],
    cloud: PointCloud,
    x: Floats,
    y: Floats,
    wavelength: float,
    reach: tuple[float, float],
) -> float:
    """The same measured on some pixels, where the machine has longer floats; else infinite.

    Waves of one place that cancel have errors that do.
    """
    wide = np.longdouble
    power = np.abs(field.ravel()) ** 2
    if np.finfo(wide).eps > _LONGER * np.finfo(np.float64).eps or not power.any():
        return np.inf
    chance = 0.5 / power.size + 0.5 * power / power.sum()
    cumulative = np.cumsum(chance)
    at = (np.arange(_SEEN) + 0.5) / _SEEN * cumulative[-1]
    drawn = np.minimum(np.searchsorted(cumulative, at), power.size - 1)
    missed = 0.0
    for pixel in drawn:
        row, column = divmod(int(pixel), len(x))
        total = np.zeros(2, dtype=wide)
        for first in range(0, len(cloud), _POINTS):
            some = slice(first, first + _POINTS)
            px, py, pz = cloud.positions[some].astype(wide).T
            dx, dy = wide(x[column]) - px, wide(y[row]) - py
            aside = dx * dx + dy * dy
            r = np.sqrt(aside + pz * pz)
            turn = aside / (r + pz) / wide(wavelength)
            turn -= np.rint(turn)
            own = pz / wide(wavelength)
            turn += own - np.rint(own)
            angle = 8 * np.arctan(wide(1)) * turn + cloud.phase[some]
            waves = cloud.amplitude[some] / r
            for d, far in ((dx, reach[0]), (dy, reach[1])):
                waves *= taper(d.astype(np.float64), (pz * far).astype(np.float64))
            total += np.sum(waves * np.cos(angle)), np.sum(waves * np.sin(angle))
        miss = np.abs(field[row, column] - complex(*total.astype(np.float64))) ** 2
        missed += float(miss / chance[pixel]) / _SEEN
    return sqrt(missed / float(power.sum()))
