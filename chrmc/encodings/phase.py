"""Encodings for panels that shift the phase by 2π·grey/256 and dim nothing.

double-phase : A·exp(iφ) is the mean of exp(i(φ ± arccos A)), taken by neighbours in turn; an
    aperture of half the band cuts their difference off (Hsueh and Sawchuk 1978)
kinoform : exp(iφ) alone, the amplitude is dropped (Lesem 1969)

There is no carrier: the picture's light surrounds the zero order.
"""

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.encoding import Coding
from chrmc.optics.passband import Passband, full_band
from chrmc.slm import SLM

STEPS = 256
"""Grey levels per turn."""


def wave(frame: NDArray[np.uint8]) -> NDArray[np.complex64]:
    """The light of grey levels: exp(2πi·grey/256)."""
    turns = np.exp(2j * np.pi * np.arange(STEPS) / STEPS).astype(np.complex64)
    light: NDArray[np.complex64] = turns[frame]
    return light


def levels_of(phase: NDArray[np.floating], slm: SLM) -> NDArray[np.uint8]:
    """Nearest grey of a phase in radians, of the panel's 2^bits steps; uint8 (H, W)."""
    steps = 1 << min(slm.bits, 8)
    nearest = np.rint(phase * np.float32(steps / (2 * np.pi))).astype(np.int32) % steps
    return (nearest * (STEPS // steps)).astype(np.uint8)


def double_phase(slm: SLM) -> Coding:
    """Two phases for one complex number."""
    middle = Passband(slm.nyquist / 2, slm.nyquist / 2)
    return Coding(
        "double-phase", middle, 0.0, needs_field=True, limits=True, levels=_two_phases,
        gain=1.0, aperture=middle, zero_order=True, wave=wave,
    )  # fmt: skip


def _two_phases(
    field: NDArray[np.complexfloating],
    signal: NDArray[np.float32],
    scale: float,
    slm: SLM,
    response: Any = None,
) -> NDArray[np.uint8]:
    amplitude = np.minimum(np.abs(field) / np.float32(scale if scale > 0 else 1.0), 1)
    apart = np.arccos(amplitude)
    apart[1::2, ::2] *= -1
    apart[::2, 1::2] *= -1
    return levels_of(np.angle(field) + apart, slm)


def kinoform(slm: SLM) -> Coding:
    """The phase alone; the scale, the field's root mean square, only says its units."""
    return Coding(
        "kinoform", full_band(slm), 0.0, needs_field=True, levels=_phase_alone, sigmas=sqrt(2),
        gain=1.0, zero_order=True, wave=wave,
    )  # fmt: skip


def _phase_alone(
    field: NDArray[np.complexfloating],
    signal: NDArray[np.float32],
    scale: float,
    slm: SLM,
    response: Any = None,
) -> NDArray[np.uint8]:
    return levels_of(np.angle(field), slm)
