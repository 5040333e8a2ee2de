"""Reconstructions in the light of several lasers as one colour picture."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chrmc.colour import mixed, srgb_levels

BRIGHTEST = 0.995
"""Share of the brightest channel's pixels that are not cut, unless `white` is given: the bright
grains of speckle would leave the rest in the dark."""


def colour_picture(
    intensities: Sequence[ArrayLike], wavelengths: Sequence[float], white: float | None = None
) -> NDArray[np.uint8]:
    """Intensities at one depth, a wavelength each, as (H, W, 3) 8-bit sRGB.

    intensities : (H, W) for each laser, on the same pixels and in the same unit
    wavelengths : metres, visible; lasers are balanced so that equal intensities are white
    white : the intensity that is drawn as white; default what 99.5 % of the brightest laser's
        pixels stay below. Give one for all frames of a film

    The lasers' light is added in the linear space of sRGB. What lies outside sRGB is cut.
    """
    if len(intensities) != len(wavelengths) or not len(wavelengths):
        raise ValueError(f"{len(intensities)} pictures for {len(wavelengths)} wavelengths")
    powers = np.stack([np.asarray(i, dtype=np.float64) for i in intensities], axis=-1)
    if powers.ndim != 3 or not np.isfinite(powers).all():
        raise ValueError(f"intensities must be finite (H, W) each, not {powers.shape[:-1]}")
    if white is None:
        white = float(np.quantile(powers, BRIGHTEST, axis=(0, 1)).max()) or 1.0
    if not (np.isfinite(white) and white > 0):
        raise ValueError(f"white must be a positive intensity, not {white}")
    return srgb_levels(mixed(powers / white, wavelengths))
