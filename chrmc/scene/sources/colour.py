"""From the colours of files to light."""

import numpy as np
from numpy.typing import NDArray

REC709 = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of linear red, green and blue."""


def linear(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear light of sRGB values, both 0 … 1 (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def luminance(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """(…,) linear luminance of (…, 3) sRGB colours, both 0 … 1."""
    return np.asarray(linear(srgb) @ REC709)
