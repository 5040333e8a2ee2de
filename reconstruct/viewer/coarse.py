"""A reconstruction at the screen's resolution: the spectrum is cropped before it is propagated.

Behind the filter, the Fourier plane's samples are the decoded field's spectrum, so the samples of
a band of it give the field on a coarser grid, with transforms of that size. While the band holds
all that the filter passes (half the rows of a single sideband), nothing is lost. Two errors
remain:

- light beyond the band: its share of the decoded light is `lost`, and points look wider by
  1/(share of the band kept);
- the panel is taken as periodic where padding is more than `BUDGET` allows: what leaves it on one
  side comes in on the other. On full-size single sideband frames the intensities differ by 1 %;
  what the edges of a panel of 256 pixels diffract is 3 % of the field.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, sqrt
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.optics.propagation import cycles_to_phasor, soft_edge, spread
from reconstruct.four_f_system import FourF, check_distance

BUDGET = 1_200_000
"""Samples of the transforms: 20 ms on one core."""
_OVERSAMPLING = 2
"""Samples per screen pixel that are enough: the intensity's band is twice the field's."""


@dataclass(frozen=True, eq=False)
class Coarse:
    """A decoded field on a coarse grid over the panel, ready for any depth.

    spectrum : (rows, columns) complex64, FFT order, padded
    shape : samples over the panel; sample (i, j) stands at the panel's pixel (i·H/m, j·W/n)
    detour : wave numbers along z less 1/wavelength, cycles per metre, of the quarter f_y, f_x ≥ 0
    lost : share of the decoded light beyond the band
    """

    spectrum: NDArray[np.complex64]
    shape: tuple[int, int]
    detour: NDArray[np.float64]
    wavelength: float
    lost: float

    def at(self, depth: float) -> NDArray[np.complex64]:
        """(m, n) complex field at a depth, metres; absolute phase kept."""
        d = -check_distance(depth)
        cycles = d * self.detour
        cycles += d / self.wavelength - np.rint(d / self.wavelength)
        quarter = cycles_to_phasor(cycles)
        rows, columns = self.spectrum.shape
        a, b = quarter.shape
        # Even in both frequencies: the other three quarters are its mirror images.
        back, left = slice(rows - a, 0, -1), slice(columns - b, 0, -1)
        moved = np.empty_like(self.spectrum)
        np.multiply(self.spectrum[:a, :b], quarter, out=moved[:a, :b])
        np.multiply(self.spectrum[:a, b:], quarter[:, left], out=moved[:a, b:])
        np.multiply(self.spectrum[a:, :b], quarter[back], out=moved[a:, :b])
        np.multiply(self.spectrum[a:, b:], quarter[back, left], out=moved[a:, b:])
        # One thread: the pool that FFTs share may be busy with a sharp picture.
        tall = scipy.fft.ifft(moved, axis=0, workers=1, overwrite_x=True)[: self.shape[0]]
        full = scipy.fft.ifft(tall, axis=1, workers=1, overwrite_x=True)
        return np.asarray(full[:, : self.shape[1]], dtype=np.complex64)


def coarse_shape(system: FourF, screen: tuple[int, int]) -> tuple[int, int]:
    """Samples (m, n) over the panel for a picture of `screen` (rows, columns) screen pixels."""
    counts = []
    limits = system.band.fy_max, system.band.fx_max
    for n, f, pixels in zip(system.slm.shape, limits, screen, strict=True):
        band = ceil(n * f / system.slm.nyquist)
        counts.append(max(16, min(band, _OVERSAMPLING * pixels)))
    excess = sqrt(counts[0] * counts[1] / BUDGET)
    if excess > 1:
        counts = [int(c / excess) for c in counts]
    shape = [
        min(scipy.fft.next_fast_len(c, real=False), n)
        for c, n in zip(counts, system.slm.shape, strict=True)
    ]
    return shape[0], shape[1]


def coarse_field(
    system: FourF, plane: NDArray[np.complex64], screen: tuple[int, int], farthest: float
) -> Coarse:
    """The field of a Fourier plane, for a picture of `screen` (rows, columns) screen pixels.

    plane : (H, W) of `system.fourier_plane`
    farthest : the largest depth that will be asked for without wrapping, metres
    """
    slm, wavelength = system.slm, system.wavelength
    shape = coarse_shape(system, screen)
    bins = system.coding.carrier * slm.height * slm.pixel_pitch
    first = round(bins)
    plain = system.bench.lens2 is None and plane.shape == slm.shape
    if plain and abs(bins - first) < 1e-9:
        # Taking the carrier off moves the spectrum by whole samples.
        cropped = _crop(plane, shape, first)
        cropped *= _crop(system.transmission(), shape, first)
        unit = system.coding.gain * system.scale
        cropped *= np.complex64(unit * np.exp(1j * np.pi * first * (1 - 1 / slm.height)))
        total = _passed(plane, system.transmission()) * unit**2
    else:
        whole = scipy.fft.fft2(system.decode(plane), norm="ortho", workers=1)
        cropped = _crop(whole, shape, 0)
        total = _power(whole)
    lost = 1 - _power(cropped) / total if total > 0 else 0.0
    cropped *= np.float32(np.prod(shape) / np.sqrt(slm.height * slm.width))
    pitches = slm.height * slm.pixel_pitch / shape[0], slm.width * slm.pixel_pitch / shape[1]
    grid = _grid(shape, pitches, wavelength, farthest)
    if grid != shape:
        small = scipy.fft.ifft2(cropped, workers=1, overwrite_x=True)
        cropped = scipy.fft.fft2(small, s=grid, workers=1, overwrite_x=True)
    detour = _detour(grid, pitches, wavelength)
    return Coarse(np.asarray(cropped, dtype=np.complex64), shape, detour, wavelength, max(lost, 0))


def _crop(values: NDArray[Any], shape: tuple[int, int], first: int) -> NDArray[Any]:
    """Samples of a spectrum in FFT order, the frequencies nearest to row `first` and column 0."""
    found = np.empty(shape, dtype=values.dtype)
    rows = _runs(shape[0], values.shape[0], first)
    for target, source in rows:
        for across, beside in _runs(shape[1], values.shape[1], 0):
            found[target, across] = values[source, beside]
    return found


def _runs(count: int, total: int, first: int) -> list[tuple[slice, slice]]:
    """Where `count` frequencies 0, 1, …, −1 around `first` lie among `total`: (to, from)."""
    index = np.arange(count)
    source = (np.where(index < (count + 1) // 2, index, index - count) + first) % total
    ends = [0, *(np.flatnonzero(np.diff(source) != 1) + 1).tolist(), count]
    return [(slice(a, b), slice(int(source[a]), int(source[a]) + b - a)) for a, b in pairwise(ends)]


@lru_cache(maxsize=4)
def _detour(
    grid: tuple[int, int], pitches: tuple[float, float], wavelength: float
) -> NDArray[np.float64]:
    """Of `Coarse`: √(1/λ² − f²) − 1/λ without the difference of large numbers."""
    fy, fx = (np.arange(n // 2 + 1) / (n * p) for n, p in zip(grid, pitches, strict=True))
    square = fy[:, None] ** 2 + fx[None, :] ** 2
    along = np.sqrt(np.maximum(1 / wavelength**2 - square, 0))
    found: NDArray[np.float64] = -square / (along + 1 / wavelength)
    found.setflags(write=False)
    return found


def _grid(
    shape: tuple[int, int], pitches: tuple[float, float], wavelength: float, farthest: float
) -> tuple[int, int]:
    """The shape, padded against wrapping when that is affordable."""
    padded = []
    for n, p in zip(shape, pitches, strict=True):
        walk = ceil(spread(wavelength, 0.5 / p, farthest) / p)
        reach = walk + soft_edge(wavelength, farthest, p)
        padded.append(scipy.fft.next_fast_len(n + min(reach, n), real=False))
    return (padded[0], padded[1]) if padded[0] * padded[1] <= BUDGET else shape


def _passed(plane: NDArray[np.complex64], transmission: NDArray[np.float32]) -> float:
    """Σ|plane·transmission|² from every other row and column: a share needs no more."""
    return 4 * _power(plane[::2, ::2] * transmission[::2, ::2])


def _power(values: NDArray[np.complexfloating]) -> float:
    flat = values.ravel()
    return float(np.vdot(flat, flat).real)
