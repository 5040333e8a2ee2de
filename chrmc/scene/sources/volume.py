"""What an SLM can show at a depth, and how finely."""

from math import asin, inf, tan

import numpy as np
from numpy.typing import NDArray

from chrmc.slm import SLM

DEPTH = 0.25
"""Metres at which things stand unless told otherwise."""
BODY_SHARE = 0.5
"""Of the lower side of the box that a body fills: what is deeper blurs before and behind."""


def reaches(slm: SLM, wavelength: float) -> tuple[float, float]:
    """Half-widths of a fringe per unit of depth in x and y, under single sideband."""
    sines = wavelength * slm.nyquist, wavelength * slm.nyquist / 2
    x, y = (tan(asin(s)) if s < 1 else inf for s in sines)
    return x, y


def box(slm: SLM, wavelength: float, depth: float) -> tuple[float, float]:
    """(width, height) in metres in which points keep most of their fringe on the panel: half the
    panel, or half a fringe where that is less."""
    x, y = reaches(slm, wavelength)
    return (
        min(slm.width * slm.pixel_pitch / 2, depth * x),
        min(slm.height * slm.pixel_pitch / 2, depth * y),
    )


def cell(slm: SLM, wavelength: float, depth: float) -> tuple[float, float]:
    """(x, y) metres that the full panel resolves: λz/W and λz/H."""
    return (
        wavelength * depth / (slm.width * slm.pixel_pitch),
        wavelength * depth / (slm.height * slm.pixel_pitch),
    )


def outside(positions: NDArray[np.float64], slm: SLM, wavelength: float) -> NDArray[np.float64]:
    """(N,) metres by which points lie outside what any pixel shows; negative inside."""
    x, y = reaches(slm, wavelength)
    z = positions[:, 2]
    # The outermost pixels' centres must lie within the footprint.
    return np.maximum(
        np.abs(positions[:, 0]) - (slm.width - 1) / 2 * slm.pixel_pitch - z * x,
        np.abs(positions[:, 1]) - (slm.height - 1) / 2 * slm.pixel_pitch - z * y,
    )
