"""Encodings for panels that dim the light in many steps.

ssb : single sideband across the motion: |f_y| < 1/4p, carrier 1/4p in y; the filter passes f_y > 0
real : the plain in-line real part, full band, no carrier: the twin image stays
bipolar : like ssb, but what the field has beyond its half band folds over into the image
    (Lucente 1993)
burch : like bipolar, scale at the field's largest modulus, so that nothing is clipped and less
    light is diffracted (Burch 1967)
offaxis : |U + R|² of an off-axis reference of modulus `scale`, as interference on a camera gives
    it: 0.25 + 0.5·signal/scale + |U|²/4·scale²; the last term is noise around the zero order
"""

from math import log, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.encoding import Coding
from chrmc.grey_levels import encode_signal
from chrmc.optics.passband import Passband, full_band
from chrmc.slm import SLM


def one_sided(name: str, slm: SLM, **more: Any) -> Coding:
    """A coding of the half band with the carrier in its middle, read through a half plane."""
    half = Passband(slm.nyquist, slm.nyquist / 2)
    return Coding(name, half, slm.nyquist / 2, half_plane=True, **more)


def ssb(slm: SLM) -> Coding:
    """Single sideband."""
    return one_sided("ssb", slm, limits=True)


def real(slm: SLM) -> Coding:
    """The real part."""
    return Coding("real", full_band(slm), 0.0)


def bipolar(slm: SLM) -> Coding:
    """Single sideband without its filter."""
    return one_sided("bipolar", slm)


def burch(slm: SLM) -> Coding:
    """Scale at the largest modulus: that of fully developed speckle, reached once in N pixels, is
    √(ln N) times the root mean square."""
    return one_sided(
        "burch",
        slm,
        sigmas=sqrt(2 * log(slm.width * slm.height)),
        own_scale=lambda field, _: float(np.abs(field).max()),
    )


def offaxis(slm: SLM) -> Coding:
    """Interference with a reference."""
    return one_sided("offaxis", slm, needs_field=True, levels=_interference)


def _interference(
    field: NDArray[np.complexfloating],
    signal: NDArray[np.float32],
    scale: float,
    slm: SLM,
    response: Any = None,
) -> NDArray[np.uint8]:
    if scale > 0:
        # What |U + R|² has besides the bias and the signal; −0.25 moves the bias to 0.25.
        modulus2 = np.square(field.real) + np.square(field.imag)
        signal += (modulus2 / (2 * scale) - 0.5 * scale).astype(np.float32)
    return encode_signal(signal, scale, response, in_place=True, bits=slm.bits)
