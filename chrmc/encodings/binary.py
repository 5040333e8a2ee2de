"""Encodings for panels that are either dark or bright, such as micromirrors.

error-diffusion : the single sideband's amplitude, rounded to 0 or 1; each pixel's rounding error
    is added two rows below, so that it vanishes around the carrier (the filter 1 + z⁻²)
lee : bright where cos(carrier + arg U) exceeds √(1 − A²), A = |U|/scale: stripes whose place
    carries the phase and whose width the amplitude (Lee 1974); its first order is A/π
"""

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chrmc.encoding import Coding
from chrmc.encodings.amplitude import one_sided
from chrmc.slm import SLM


def error_diffusion(slm: SLM) -> Coding:
    """Rounding errors moved away from the carrier, so small pictures are clean.

    Scale at 1.5 standard deviations: of speckle that fills a tenth of the band the field error is
    0.13, of a fifth 0.24 (clipping and rounding in balance); at 3 they are 0.07 and 0.27.
    """
    return one_sided(
        "error-diffusion", slm, limits=True, levels=_diffused, sigmas=1.5, bits=1, needs_field=True
    )


def _diffused(
    field: NDArray[np.complexfloating],
    signal: NDArray[np.float32],
    scale: float,
    slm: SLM,
    response: Any = None,
) -> NDArray[np.uint8]:
    wanted = np.clip(signal * np.float32(0.5 / scale if scale > 0 else 0.0) + 0.5, 0, 1)
    bright = np.empty(wanted.shape, dtype=np.uint8)
    errors = np.zeros((2, wanted.shape[1]), dtype=np.float32)  # of the two rows above
    for row, line in enumerate(wanted):
        line += errors[row % 2]
        lit = line >= 0.5
        bright[row] = lit
        errors[row % 2] = lit - line
    bright *= 255
    return bright


def lee(slm: SLM) -> Coding:
    """Stripes of the carrier, moved and widened."""
    return one_sided(
        "lee", slm, limits=True, levels=_stripes, sigmas=2.0, gain=pi, bits=1, needs_field=True
    )


def _stripes(
    field: NDArray[np.complexfloating],
    signal: NDArray[np.float32],
    scale: float,
    slm: SLM,
    response: Any = None,
) -> NDArray[np.uint8]:
    # With signal = |U|·cos(carrier + arg U) the rule is signal > |U|·√(1 − A²).
    modulus = np.abs(field)
    amplitude = np.minimum(modulus / np.float32(scale if scale > 0 else 1.0), 1)
    lit = signal > modulus * np.sqrt(1 - amplitude**2)
    return lit.astype(np.uint8) * np.uint8(255)
