"""Free-space propagation by the band-limited angular spectrum, absolute phase kept.

A field here travels from the points at z > 0 towards the hologram at z = 0, so `distance` counts
along −z: propagating the hologram's field by −d shows it at depth z = d, where points at that
depth are in focus.
"""

import os
from math import sqrt

import numpy as np
import scipy.fft
from numpy.typing import NDArray


def workers() -> int:
    """Threads that FFTs and thread pools here use: one for each core this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Windows or macOS
        return os.cpu_count() or 1


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
) -> NDArray[np.complex64]:
    """Band-limited angular-spectrum transfer function on the FFT's frequency grid.

    shape : (rows, columns) of the padded grid
    distance : metres along the wave's travel; negative goes back to the sources
    shift : (y, x) metres; the output grid's centre relative to the input's

    exp(2πi·(distance·√(1/λ² − f²) + f·shift)), zero for evanescent waves and where its local
    frequency would alias on this grid (Matsushima and Shimobaba, Opt. Express 17, 19662, 2009;
    with shift: Matsushima, Opt. Express 18, 18453, 2010).
    """
    fy = scipy.fft.fftfreq(shape[0], pixel_pitch)[:, None]
    fx = scipy.fft.fftfreq(shape[1], pixel_pitch)[None, :]
    w2 = 1 / wavelength**2 - fx**2 - fy**2
    kz = np.sqrt(np.maximum(w2, 0))
    cycles = distance * kz + fy * shift[0] + fx * shift[1]
    passed = w2 > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        for f, step, s in (
            (fy, 1 / (shape[0] * pixel_pitch), shift[0]),
            (fx, 1 / (shape[1] * pixel_pitch), shift[1]),
        ):
            # d(cycles)/df must stay below half the period that a step of f can hold.
            slope = s - distance * f / kz
            passed &= ~(np.abs(slope) > 0.5 / step)
    return np.where(passed, cycles_to_phasor(cycles), np.complex64(0))


def padded_shape(
    shape: tuple[int, int], pixel_pitch: float, wavelength: float, distance: float
) -> tuple[int, int]:
    """Grid that keeps the circular convolution of `propagate` off the input's window.

    The full Nyquist band spreads by |distance|·tan α on each side; more than doubling a side
    brings nothing, since light that far out never returns to the window.
    """
    s = min(wavelength / (2 * pixel_pitch), 0.99)
    spread = int(np.ceil(abs(distance) * s / sqrt(1 - s * s) / pixel_pitch)) + 1
    rows, columns = (scipy.fft.next_fast_len(n + min(spread, n), real=False) for n in shape)
    return rows, columns


def propagate(
    field: NDArray[np.complexfloating],
    pixel_pitch: float,
    wavelength: float,
    distance: float,
    shift: tuple[float, float] = (0.0, 0.0),
    transfer: NDArray[np.complex64] | None = None,
) -> NDArray[np.complex64]:
    """Field on a parallel plane, same shape and pitch.

    field : (H, W) complex
    distance : metres along the wave's travel (towards −z); −d shows depth d of a hologram
    shift : (y, x) metres of the output window against the input's
    transfer : a kept `transfer_function`, whose shape then is the padded grid

    Returns (H, W) complex64.
    """
    field = np.asarray(field, dtype=np.complex64)
    rows, columns = field.shape
    if transfer is None:
        grid = padded_shape(field.shape, pixel_pitch, wavelength, distance)
        transfer = transfer_function(grid, pixel_pitch, wavelength, distance, shift)
    spectrum = scipy.fft.fft2(field, s=transfer.shape, workers=workers())
    spectrum *= transfer
    out = scipy.fft.ifft2(spectrum, workers=workers(), overwrite_x=True)
    return out[:rows, :columns]
