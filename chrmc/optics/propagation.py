"""Free-space propagation by the band-limited angular spectrum, absolute phase kept.

A field here travels from the points at z > 0 towards the hologram at z = 0, so `distance` counts
along −z: propagating the hologram's field by −d shows it at depth z = d, where points at that
depth are in focus.
"""

from dataclasses import dataclass
from math import ceil, isfinite, sqrt
from sys import maxsize
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from chrmc.kept import Kept
from chrmc.optics.passband import Passband
from chrmc.threads import workers


def cycles_to_phasor(cycles: NDArray[np.float64]) -> NDArray[np.complex64]:
    """exp(2πi·cycles) in complex64, the cycles reduced in float64 before they are cast."""
    turn = (2 * np.pi * (cycles - np.rint(cycles))).astype(np.float32)
    out = np.empty(turn.shape, dtype=np.complex64)
    out.real = np.cos(turn)
    out.imag = np.sin(turn)
    return out


def transfer_function(
    shape: tuple[int, int],
    pixel_pitch: float,
    wavelength: float,
    distance: float,
    shift: tuple[float, float] = (0.0, 0.0),
    band: Passband | None = None,
) -> NDArray[np.complex64]:
    """Band-limited angular-spectrum transfer function on the FFT's frequency grid.

    shape : (rows, columns) of the padded grid
    distance : metres along the wave's travel; negative goes back to the sources
    shift : (y, x) metres; the output grid's centre relative to the input's
    band : beyond which nothing passes, default all

    exp(2πi·(distance·√(1/λ² − f²) + f·shift)), zero for evanescent waves and where its local
    frequency would alias on this grid (Matsushima and Shimobaba, Opt. Express 17, 19662, 2009;
    with shift: Matsushima, Opt. Express 18, 18453, 2010).
    """
    fy, fx = (np.arange(n // 2 + 1) / (n * pixel_pitch) for n in shape)
    # Even in both frequencies: one quarter is computed, and mirrored below.
    w2 = 1 / wavelength**2 - fy[:, None] ** 2 - fx[None, :] ** 2
    kz = np.sqrt(np.maximum(w2, 0))
    quarter = cycles_to_phasor(distance * kz)
    passed = w2 > 0
    if band is not None:
        passed &= (fy[:, None] <= band.fy_max) & (fx[None, :] <= band.fx_max)
    quarter[~passed] = 0
    with np.errstate(divide="ignore", invalid="ignore"):
        travel = -distance / kz
    signed: list[list[tuple[slice, slice, NDArray[np.bool_]]]] = []
    for axis, (f, n, s) in enumerate(zip((fy, fx), shape, shift, strict=True)):
        with np.errstate(invalid="ignore"):
            walk = travel * (f[:, None] if axis == 0 else f[None, :])
        # d(cycles)/df must stay below half the period that a step of f can hold.
        limit = 0.5 * n * pixel_pitch
        positive = (slice(0, (n + 1) // 2), slice(0, (n + 1) // 2))
        negative = (slice((n + 1) // 2, n), slice(n // 2, 0, -1))
        signed.append(
            [
                (*positive, ~(np.abs(s + walk) > limit)),
                (*negative, ~(np.abs(s - walk) > limit)),
            ]
        )
    out = np.empty(shape, dtype=np.complex64)
    for rows, source_rows, y_passed in signed[0]:
        for columns, source_columns, x_passed in signed[1]:
            source = (source_rows, source_columns)
            np.multiply(quarter[source], y_passed[source], out=out[rows, columns])
            out[rows, columns] *= x_passed[source]
    for axis, s in enumerate(shift):
        if s:
            ramp = cycles_to_phasor(scipy.fft.fftfreq(shape[axis], pixel_pitch) * s)
            out *= ramp[:, None] if axis == 0 else ramp[None, :]
    return out


def spread(wavelength: float, f_max: float, distance: float) -> float:
    """How far light of frequency f_max walks sideways over a distance, metres."""
    s = min(wavelength * f_max, 0.99)
    return abs(distance) * s / sqrt(1 - s * s)


def soft_edge(wavelength: float, distance: float, pixel_pitch: float) -> int:
    """Samples over which geometric shadows blur: two Fresnel zones √(λ·distance), and some."""
    return ceil(2 * sqrt(wavelength * abs(distance)) / pixel_pitch) + 16


def padded_shape(
    shape: tuple[int, int],
    pixel_pitch: float,
    wavelength: float,
    distance: float,
    band: Passband | None = None,
) -> tuple[int, int]:
    """Grid that keeps the circular convolution of `propagate` off the output's window.

    The band (default Nyquist) spreads by |distance|·tan α on each side; more than doubling a side
    brings nothing, since light that far out never meets the window.
    """
    nyquist = 0.5 / pixel_pitch
    limits = (nyquist, nyquist) if band is None else (band.fy_max, band.fx_max)
    padded = []
    for n, f in zip(shape, limits, strict=True):
        walk = spread(wavelength, f, distance) / pixel_pitch
        reach = ceil(walk) + soft_edge(wavelength, distance, pixel_pitch)
        padded.append(scipy.fft.next_fast_len(n + min(reach, n), real=False))
    return padded[0], padded[1]


def propagate(
    field: NDArray[np.complexfloating],
    pixel_pitch: float,
    wavelength: float,
    distance: float,
    transfer: NDArray[np.complex64] | None = None,
) -> NDArray[np.complex64]:
    """Field on a parallel plane, same shape and pitch.

    field : (H, W) complex
    distance : metres along the wave's travel (towards −z); −d shows depth d of a hologram
    transfer : a kept `transfer_function`, whose shape then is the padded grid

    Returns (H, W) complex64. `Propagator` does the same for other windows, and many times.
    """
    field = np.asarray(field, dtype=np.complex64)
    rows, columns = field.shape
    if transfer is None:
        grid = padded_shape(field.shape, pixel_pitch, wavelength, distance)
        transfer = transfer_function(grid, pixel_pitch, wavelength, distance)
    spectrum = scipy.fft.fft2(field, s=transfer.shape, workers=workers())
    spectrum *= transfer
    # Rows that nobody asked for are dropped before the second transform.
    half = scipy.fft.ifft(spectrum, axis=0, workers=workers(), overwrite_x=True)[:rows]
    full = scipy.fft.ifft(half, axis=1, workers=workers(), overwrite_x=True)
    return np.asarray(full[:, :columns], dtype=np.complex64)


@dataclass(frozen=True)
class Patch:
    """A rectangle of samples on the output plane.

    centre : (y, x) metres
    shape : (rows, columns)
    pitch : metres between samples, as fine or coarse as wanted
    """

    centre: tuple[float, float]
    shape: tuple[int, int]
    pitch: float

    def __post_init__(self) -> None:
        if min(self.shape) < 1 or not (isfinite(self.pitch) and self.pitch > 0):
            raise ValueError(
                f"a patch needs at least 1 × 1 samples at a positive pitch, not "
                f"{self.shape[1]} × {self.shape[0]} at {self.pitch} m"
            )

    def coordinates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """y of the rows and x of the columns, metres."""
        (rows, columns), (y, x) = self.shape, self.centre
        row = np.arange(rows, dtype=np.float64) - (rows - 1) / 2
        column = np.arange(columns, dtype=np.float64) - (columns - 1) / 2
        return y + row * self.pitch, x + column * self.pitch


MOST_SAMPLES = 1 << 28
"""Of a padded grid: 2 GiB of complex64."""


@dataclass(frozen=True)
class _Axis:
    """One axis of a Propagator: which input is used, and how its grid meets the output's."""

    start: int  # first input sample that can reach the patch
    weight: NDArray[np.float32]  # of the input samples used
    grid: int  # padded length
    shift: float  # metres, output grid against input grid
    first: int  # output index of the patch's first sample (same pitch)
    matrix: NDArray[np.complex64] | None  # (patch samples, grid) inverse DFT (other pitch)


class Propagator:
    """Propagation from one input grid to one patch, for many fields and many distances.

    The padded grid holds input plus patch, not twice the input, and input that cannot reach the
    patch is left out: a small patch costs far less than the plane (shifted angular spectrum,
    Matsushima, Opt. Express 18, 18453, 2010). At another pitch than the input's the inverse
    transform is two matrix products (the matrix Fourier transform of Soummer et al., Opt.
    Express 15, 15935, 2007). Transfer functions are kept per distance.

    shape, pixel_pitch, wavelength : of the input, centred on the axis
    longest : the largest |distance| that will be asked for, metres
    patch : on the output plane, default the input's own window
    band : what the fields occupy, default Nyquist; the rest is cut
    keep : transfer functions held
    """

    def __init__(
        self,
        shape: tuple[int, int],
        pixel_pitch: float,
        wavelength: float,
        longest: float,
        patch: Patch | None = None,
        band: Passband | None = None,
        keep: int = 2,
    ) -> None:
        self.shape = shape
        self.pixel_pitch = pixel_pitch
        self.wavelength = wavelength
        self.longest = abs(longest)
        self.patch = Patch((0.0, 0.0), shape, pixel_pitch) if patch is None else patch
        nyquist = 0.5 / pixel_pitch
        self.band = band
        limits = (nyquist, nyquist)
        if band is not None:
            limits = (min(band.fy_max, nyquist), min(band.fx_max, nyquist))
        self._axes = [self._axis(axis, limits[axis]) for axis in (0, 1)]
        if self.grid[0] * self.grid[1] > MOST_SAMPLES:
            raise ValueError(
                f"propagation over {self.longest:g} m at wavelength {wavelength:g} m spreads over "
                f"{self.grid[1]} × {self.grid[0]} samples: too many for memory; go less far"
            )
        self._transfers = Kept(limit=maxsize, most=keep)

    @property
    def grid(self) -> tuple[int, int]:
        """Shape of the padded grid that the Fourier transforms run on."""
        return self._axes[0].grid, self._axes[1].grid

    def _axis(self, axis: int, f_max: float) -> _Axis:
        p, patch = self.pixel_pitch, self.patch
        n, m, q, centre = self.shape[axis], patch.shape[axis], patch.pitch, patch.centre[axis]
        walk = spread(self.wavelength, f_max, self.longest) / p + 1
        middle = centre / p + (n - 1) / 2  # the patch's centre as an input index
        half = (m - 1) / 2 * q / p
        # A cut in the input diffracts: it is made soft, and clear of what reaches the patch.
        soft = soft_edge(self.wavelength, self.longest, p)
        low = max(0, int(np.floor(middle - half - walk)) - soft)
        high = min(n, ceil(middle + half + walk) + 1 + soft)
        if high <= low:  # nothing reaches the patch: one sample keeps the arrays alive
            low = min(max(low, 0), n - 1)
            high = low + 1
        count = high - low
        weight = np.ones(count, dtype=np.float32)
        if count > 1:
            ramp = (np.arange(min(soft, count)) + 0.5) / soft
            rise = np.sin(np.pi / 2 * ramp).astype(np.float32) ** 2
            if low > 0:
                weight[: len(rise)] *= rise
            if high < n:
                weight[count - len(rise) :] *= rise[::-1]
        extent = ceil(2 * half) + 1
        offset = middle - (low + (count - 1) / 2)
        reach = (count + extent) / 2
        # The band limit cuts at half the grid: a few zones clear of what is needed.
        needed = ceil(reach + min(reach, walk + abs(offset))) + soft
        grid = scipy.fft.next_fast_len(max(needed, count, extent), real=False)
        if q == p:
            first = round((count - m) / 2)
            start = centre - (m - 1) / 2 * q  # of the patch
            shift = start - (low - (n - 1) / 2) * p - first * p
            return _Axis(low, weight, grid, shift, first, None)
        shift = offset * p
        # Output sample k stands at (count − 1)/2 + (k − (m − 1)/2)·q/p on the shifted grid.
        index = (count - 1) / 2 + (np.arange(m) - (m - 1) / 2) * q / p
        frequency = scipy.fft.fftfreq(grid)
        matrix = cycles_to_phasor(index[:, None] * frequency[None, :])
        matrix /= np.float32(grid)
        return _Axis(low, weight, grid, shift, 0, matrix)

    def spectrum(self, field: NDArray[np.complexfloating]) -> NDArray[np.complex64]:
        """Spectrum of an input field on the padded grid: one for all distances."""
        if field.shape != self.shape:
            raise ValueError(
                f"field is {field.shape}, but this propagator was made for {self.shape}"
            )
        y, x = self._axes
        part = np.asarray(
            field[y.start : y.start + len(y.weight), x.start : x.start + len(x.weight)],
            dtype=np.complex64,
        )
        if part.shape != self.shape:
            part = part * y.weight[:, None] * x.weight
        spectrum = scipy.fft.fft2(part, s=self.grid, workers=workers())
        return np.asarray(spectrum, dtype=np.complex64)

    def transfer(self, distance: float) -> NDArray[np.complex64]:
        """The transfer function of a distance, kept for the next call."""
        if abs(distance) > self.longest * (1 + 1e-12):
            raise ValueError(
                f"distance {distance:.6g} m is beyond the {self.longest:.6g} m that this "
                "propagator's padding was chosen for"
            )
        shift = (self._axes[0].shift, self._axes[1].shift)
        return self._transfers.get(
            distance,
            lambda: transfer_function(
                self.grid, self.pixel_pitch, self.wavelength, distance, shift, self.band
            ),
        )

    def at(self, spectrum: NDArray[np.complex64], distance: float) -> NDArray[np.complex64]:
        """Field on the patch, `distance` along the wave's travel, from `spectrum(field)`."""
        y, x = self._axes
        moved: NDArray[Any] = spectrum * self.transfer(distance)
        if y.matrix is not None and x.matrix is not None:
            rows, columns = self.patch.shape
            if rows * x.grid * (y.grid + columns) <= columns * y.grid * (x.grid + rows):
                product = (y.matrix @ moved) @ x.matrix.T
            else:
                product = y.matrix @ (moved @ x.matrix.T)
            return np.asarray(product, dtype=np.complex64)
        tall = scipy.fft.ifft(moved, axis=0, workers=workers(), overwrite_x=True)
        half = np.take(tall, y.first + np.arange(self.patch.shape[0]), axis=0, mode="wrap")
        full = scipy.fft.ifft(half, axis=1, workers=workers(), overwrite_x=True)
        out = np.take(full, x.first + np.arange(self.patch.shape[1]), axis=1, mode="wrap")
        return np.asarray(out, dtype=np.complex64)

    def __call__(
        self, field: NDArray[np.complexfloating], distance: float
    ) -> NDArray[np.complex64]:
        """Field on the patch, `distance` metres along the wave's travel (−d shows depth d)."""
        return self.at(self.spectrum(field), distance)
